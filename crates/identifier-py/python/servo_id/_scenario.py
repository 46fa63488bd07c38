"""Scenarios: a file, or a mapping of its keys."""

import json
import re
from collections.abc import Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import Any, TypeAlias

Scenario: TypeAlias = str | PathLike[str] | Mapping[str, Any]
"""The path of a TOML file, or its tables as a mapping: ``{"plant": {"a": 0.2, "b": 250.0}}``."""


def read(scenario: Scenario) -> tuple[str, str]:
    """The name of a scenario in messages, and its text."""
    if isinstance(scenario, Mapping):
        return "scenario", "\n".join(_tables(scenario, ""))
    if isinstance(scenario, (str, PathLike)):
        try:
            return fspath(scenario), Path(scenario).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise ValueError(f"{fspath(scenario)}: the scenario cannot be read: {error}") from error
    raise TypeError(
        f"a scenario is the path of a TOML file or a mapping of its tables, not a {type(scenario).__name__}"
    )


def _tables(table: Mapping[str, Any], path: str) -> list[str]:
    is_table = lambda value: isinstance(value, Mapping)
    lines = [f"[{path}]"] if path else []
    lines += [f"{_key(key)} = {_value(value)}" for key, value in table.items() if not is_table(value)]
    for key, value in table.items():
        if is_table(value):
            lines += _tables(value, f"{path}.{_key(key)}" if path else _key(key))
    return lines


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _text(key)


def _text(value: str) -> str:
    # A basic string of TOML has the escapes of JSON; DEL needs one as well.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_value(part) for part in value)}]"
    if hasattr(value, "tolist"):
        return _value(value.tolist())
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        # TOML knows inf and nan, and the shortest digits of a float.
        return repr(value)
    raise TypeError(f"{value!r} is not a value for a scenario: it must be a number, a text, true or false, or a list of these")
