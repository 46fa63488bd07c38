"""Dynamixel X: protocol 2.0 and registers as the manual of the XM430-W350 and the maker's client ``dynamixel-sdk`` have them."""

from collections.abc import Callable
from typing import Any

from ._registers import Maker, Register

_ERRORS = ("", "a failed instruction", "an unknown instruction", "a damaged question", "a number out of range", "a wrong length",
           "a number beyond its limit", "a register that cannot be written now")


def _calls(sdk: Any, port: Any) -> Callable[..., Any]:
    handler = sdk.PacketHandler(2.0)
    return lambda name, *arguments: getattr(handler, name)(port, *arguments)


def _fault(error: int) -> str:
    # The highest bit: over-load, over-temperature, voltage or encoder, in Hardware Error Status (70).
    alert = "a hardware error, such as over-load or over-temperature" if error & 0x80 else ""
    return alert or _ERRORS[min(error & 0x7F, len(_ERRORS) - 1)]


DYNAMIXEL = Maker(
    name="dynamixel",
    models={1020: "XM430-W350", 1060: "XL430-W250", 1070: "XC430-W150", 1120: "XM540-W270", 1190: "XL330-M077", 1200: "XL330-M288"},
    registers={
        "model": Register(0, 2),
        "firmware": Register(6),
        "drive_mode": Register(10),
        "mode": Register(11),
        "highest_temperature": Register(31),
        "highest_voltage": Register(32, 2),
        "lowest_voltage": Register(34, 2),
        "highest": Register(48, 4),
        "lowest": Register(52, 4),
        "torque": Register(64),
        "led": Register(65),
        "d": Register(80, 2),
        "i": Register(82, 2),
        "p": Register(84, 2),
        "acceleration": Register(108, 4),
        "speed": Register(112, 4),
        "goal": Register(116, 4, -1),
        "load": Register(124, 2, -1),
        "position": Register(132, 4, -1),
        "voltage": Register(144, 2),
        "temperature": Register(146),
    },
    client="dynamixel_sdk",
    calls=_calls,
    fault=_fault,
    baud=57_600,
    modes=(3,),
    polled=("load", "position"),
    watched=("mode", "temperature"),
    # It restarts with its light off.
    settings={"acceleration": 0, "speed": 0, "led": 1},
    full_load=885.0,
    rate_scale=4.6e-5,
    largest_gain=16383,
)
