"""Feetech STS: protocol and registers as the maker's client ``ftservo-python-sdk`` or ``feetech-servo-sdk`` has them."""

from collections.abc import Callable
from functools import partial
from typing import Any

from ._registers import Maker, Register

_ERRORS = {1: "its voltage", 2: "its angle sensor", 4: "over-temperature", 8: "over-current", 32: "over-load"}


def _connect(port: str, baud: int) -> tuple[Any, Callable[..., Any]]:
    try:
        import scservo_sdk as sdk
    except ImportError as error:
        raise ValueError("the maker's client is not there: pip install 'servo-id[feetech]'") from error
    client = sdk.PortHandler(port)
    if not client.setBaudRate(baud):
        raise ValueError(f"{baud} baud is not a rate of this servo")
    # The newer client keeps its port, the older one is told with each call.
    newer = hasattr(sdk, "sms_sts")
    handler = sdk.sms_sts(client) if newer else sdk.PacketHandler(0)
    first = () if newer else (client,)
    return client, lambda name, *arguments: partial(getattr(handler, name), *first)(*arguments)


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
    connect=_connect,
    fault=lambda error: ", ".join(text for bit, text in _ERRORS.items() if error & bit),
    baud=1_000_000,
    modes=(0,),
    polled=("position", "load"),
    profile=("acceleration", "speed"),
    full_load=1000.0,
    gain_scale=1 / 0.166,
    rate_scale=1.6e-3,
    largest_gain=254,
    supply=(10.0, 10.0),
    lock=True,
)
