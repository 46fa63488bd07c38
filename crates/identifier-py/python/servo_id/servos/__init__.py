"""Smart servos: their position loop is recorded, identified, tuned and tried on the servo itself.

A maker is a file here that describes its registers and opens its client; see :class:`Maker`.
"""

from ._registers import Fault, Maker, Refused, Servo
from ._session import Interrupted, Session
from .dynamixel import DYNAMIXEL
from .feetech import FEETECH

MAKERS = {maker.name: maker for maker in (DYNAMIXEL, FEETECH)}

__all__ = ["MAKERS", "Fault", "Interrupted", "Maker", "Refused", "Servo", "Session"]
