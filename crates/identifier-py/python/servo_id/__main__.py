"""``python -m servo_id identify FILE``: the page of the program ``servo-id``, of every file that the package reads.

``capture`` and ``tune-servo`` are for smart servos: :mod:`servo_id.servos`.
"""

import re
import shutil
import sys
from argparse import ArgumentParser

from ._experiments import page


def main() -> int:
    if sys.argv[1:2] in (["capture"], ["tune-servo"]):
        from .servos import _commands

        return _commands.main(sys.argv[1:])
    parser = ArgumentParser("python -m servo_id", usage="%(prog)s identify FILE [--joint JOINT] [--KEYWORD VALUE ...]")
    parser.add_argument("verb", choices=["identify"], help="identify the servo of a log and print the result")
    parser.add_argument("file", help=".csv, .csv.gz, .db3, .mcap, .bag, .wpilog, .ulg, .parquet, .mat, .npz, .json, or a folder")
    parser.add_argument("--joint", help="name or number of the joint, if the log has several")
    known, rest = parser.parse_known_args()
    names = [word.removeprefix("--").replace("-", "_") for word in rest[::2] if word.startswith("--")]
    if 2 * len(names) != len(rest):
        parser.error("each keyword of identify needs a value, such as --position angle --command-scale 0.1")
    try:
        width = shutil.get_terminal_size((100, 24)).columns
        text = page(known.file, joint=known.joint, width=width, **dict(zip(names, rest[1::2])))
    except (ValueError, TypeError, ImportError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(text if sys.stdout.isatty() else re.sub("\x1b\\[[0-9;]*m", "", text))
    return 0


if __name__ == "__main__":
    sys.exit(main())
