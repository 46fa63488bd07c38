"""``python -m servo_id identify FILE``: the page of the program ``servo-id``, of every file that the package reads.

``capture`` and ``tune-servo`` are for smart servos: :mod:`servo_id.servos`.
"""

import re
import shutil
import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence

from ._experiments import page
from ._native import LOG_OPTIONS
from .servos import _commands

ALL_COLUMNS = 65_535
"""Characters to a line in a file or a pipe, which have all columns of a table."""


def options(words: Sequence[str]) -> Namespace:
    """The verb of a command line, and its options."""
    parser = ArgumentParser("python -m servo_id", description="Identification of servo axes, from a log or on a smart servo.")
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="COMMAND")
    text = "identify the servo of a log and print the result"
    usage = "python -m servo_id identify FILE [--joint JOINT] [--KEYWORD VALUE ...]"
    identify = verbs.add_parser("identify", help=text, description=text, usage=usage, allow_abbrev=False)
    identify.add_argument("file", help=".csv, .csv.gz, .db3, .mcap, .bag, .wpilog, .ulg, .parquet, .mat, .npz, .json, or a folder")
    identify.add_argument("--joint", help="name or number of the joint, if the log has several")
    for name, text in LOG_OPTIONS:
        identify.add_argument("--" + name.replace("_", "-"), help=text.strip().replace("%", "%%"), metavar="VALUE")
    for verb, text in _commands.VERBS.items():
        _commands.add_options(verbs.add_parser(verb, help=text, description=text), verb)
    # A number is no option: argparse takes -1e-3 for one.
    return parser.parse_args([f" {word}" if re.match(r"-[\d.]", word) else word for word in words])


def main() -> int:
    stated = options(sys.argv[1:])
    if stated.verb != "identify":
        return _commands.main(stated)
    keywords = {name: value.strip() for name, value in vars(stated).items() if name != "verb" and value is not None}
    try:
        text = page(keywords.pop("file"), width=shutil.get_terminal_size((ALL_COLUMNS, 24)).columns, **keywords)
    except (ValueError, TypeError, ImportError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(text if sys.stdout.isatty() else re.sub("\x1b\\[[0-9;]*m", "", text))
    return 0


if __name__ == "__main__":
    sys.exit(main())
