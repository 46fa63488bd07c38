"""One method over all logs in a process of its own, a line of JSON each: `worker.py METHOD LOGS.pickle SECONDS BUDGET`."""

import importlib
import inspect
import io
import json
import pickle
import resource
import sys
import tokenize
import warnings
from dataclasses import replace

import score


def lines(source):
    """Lines with code: no blanks, comments or texts on their own."""
    skipped = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER)
    tokens = list(tokenize.generate_tokens(io.StringIO(source).readline))
    found = set()
    for before, token in zip([None, *tokens], tokens):
        is_text = token.type == tokenize.STRING and (before is None or before.type in skipped)
        if token.type not in skipped and not is_text:
            found.update(range(token.start[0], token.end[0] + 1))
    return len(found)


def user_lines(rival):
    """Lines that a user writes for it."""
    if hasattr(rival, "USER_LINES"):
        return rival.USER_LINES
    parts = [part.py_func for part in getattr(rival, "USES", [])]
    return lines(inspect.getsource(rival)) + sum(lines(inspect.getsource(part)) for part in parts)


def main(name, logs, longest, budget):
    rival = importlib.import_module(f"rivals.{name}")
    with open(logs, "rb") as file:
        all_logs = pickle.load(file)
    print(json.dumps({"user_lines": user_lines(rival)}))
    # What compiles on its first call does so before the clock runs.
    first = all_logs[0]
    head = slice(min(2000, len(first.position)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        warm = replace(first, name=first.name + "-warm", truth={}, position=first.position[head], command=first.command[head])
        score.scored(rival, warm, 10 * longest)
        begun = score.processor()
        for log in all_logs:
            if score.processor() - begun < budget:
                print(json.dumps(score.scored(rival, log, longest)), flush=True)
    of = resource.RUSAGE_CHILDREN if name == "servo_id" else resource.RUSAGE_SELF
    print(json.dumps({"megabytes": resource.getrusage(of).ru_maxrss / 1024}))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
