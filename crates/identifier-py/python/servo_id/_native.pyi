"""The native half: texts and columns in, JSON and the bytes of float64 columns out."""

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

VERSION: str
LOG_OPTIONS: Sequence[tuple[str, str]]
CONDITIONS: Sequence[tuple[str, str]]

_Columns: TypeAlias = dict[str, bytes]
_Path: TypeAlias = "str | PathLike[str]"
_Log: TypeAlias = "_Path | tuple[_Path, Sequence[tuple[str, npt.NDArray[np.float64]]]]"

class Online:
    def __init__(self, file: str, text: str) -> None: ...
    def learn(self, position: float, command: float) -> None: ...
    def learn_columns(
        self, position: npt.NDArray[np.float64], command: npt.NDArray[np.float64]
    ) -> None: ...
    def resume(self) -> None: ...
    def found(
        self,
    ) -> tuple[int, dict[str, float], dict[str, float] | None, list[str]]: ...

class SimulatedServo:
    def __init__(self, file: str, text: str) -> None: ...
    def step(self, command: float) -> tuple[float, float]: ...

def simulate(file: str, text: str, *, trace: bool) -> tuple[str, _Columns, str]: ...
def recognise_log(
    logs: Sequence[_Log], stated: Mapping[str, str]
) -> tuple[str, str, list[tuple[str, str]]]: ...
def identify_log(
    file: str, text: str, logs: Sequence[_Log], reading: str | None, *, trace: bool
) -> tuple[str, _Columns, str, bytes | None]: ...
def reading(result: str) -> list[str]: ...
def predict(
    file: str, text: str, servo: bytes, logs: Sequence[_Log]
) -> tuple[str, _Columns]: ...
def page(logs: Sequence[_Log], stated: Mapping[str, str], width: int) -> str: ...
def read_log(file: str, text: str, logs: Sequence[_Log]) -> _Columns: ...
def commission(file: str, text: str) -> str: ...
def sweep(
    file: str, text: str, first: int, count: int, seed: int
) -> tuple[_Columns, list[str]]: ...
def tune(
    result: str,
    conditions: Mapping[str, float],
    form: str | None,
    accept_unconverged: bool,
) -> tuple[str, list[str]]: ...
def export(
    joints: Sequence[tuple[str, str, float | None, float | None, float, float | None]],
    format: str,
    ratios: bool,
    resistance: float | None,
    accept_unconverged: bool,
) -> str: ...
