"""Feetech STS: protocol and registers as the maker's client ``ftservo-python-sdk`` or ``feetech-servo-sdk`` has them."""

from collections.abc import Callable
from typing import Any

from ._registers import Maker, Register

_ERRORS = {1: "its voltage", 2: "its angle sensor", 4: "over-temperature", 8: "over-current", 32: "over-load"}


def _calls(sdk: Any, port: Any) -> Callable[..., Any]:
    # The newer client keeps its port, the older one is told with each call.
    newer = hasattr(sdk, "sms_sts")
    handler, first = (sdk.sms_sts(port), ()) if newer else (sdk.PacketHandler(0), (port,))
    return lambda name, *arguments: getattr(handler, name)(*first, *arguments)


FEETECH = Maker(
    name="feetech",
    models={777: "STS3215", 2825: "STS3250"},
    registers={
        "firmware": Register(0, 2),
        "model": Register(3, 2),
        "lowest": Register(9, 2),
        "highest": Register(11, 2),
        "highest_temperature": Register(13),
        "highest_voltage": Register(14),
        "lowest_voltage": Register(15),
        "p": Register(21),
        "d": Register(22),
        "i": Register(23),
        "start_force": Register(24, 2),
        "dead_zone": Register(26),
        "mode": Register(33),
        "torque": Register(40),
        "acceleration": Register(41),
        "goal": Register(42, 2, 15),
        "speed": Register(46, 2, 15),
        "lock": Register(55),
        "position": Register(56, 2, 15),
        "load": Register(60, 2, 10),
        "voltage": Register(62),
        "temperature": Register(63),
    },
    client="scservo_sdk",
    calls=_calls,
    fault=lambda error: ", ".join(text for bit, text in _ERRORS.items() if error & bit),
    baud=1_000_000,
    modes=(0,),
    polled=("position", "load"),
    watched=("highest_temperature", "temperature"),
    settings={"acceleration": 0, "speed": 0},
    full_load=1000.0,
    rate_scale=1.6e-3,
    largest_gain=254,
    lock=True,
)
