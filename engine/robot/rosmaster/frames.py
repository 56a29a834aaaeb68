"""What the motor board understands and tells: frames, and what they mean.

A frame to the board is ``FF FC LEN FUNCTION data CHECK``: LEN counts the bytes before CHECK but one, and CHECK makes
the sum of all bytes before it, and 5, in eight bits. A frame from the board is ``FF FB LEN TYPE data CHECK``: LEN
counts itself, TYPE, data and CHECK, and CHECK is the sum of LEN, TYPE and data. Numbers are little-endian. (Source:
Yahboom's ``Rosmaster_Lib``, V3.3.9.)
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from engine.robot.geometry import Twist

TO_BOARD: Final = b"\xff\xfc"
FROM_BOARD: Final = b"\xff\xfb"
HEAD: Final = 4
"""Bytes before the data, either way."""
LONGEST: Final = 64
"""Of the frames that the board sends, bytes: the longest that is known has 22."""
SERVOS: Final = 6

AUTO_REPORT, BEEP, RGB = 0x01, 0x02, 0x05
SPEED, RAW, ATTITUDE, ENCODERS = 0x0A, 0x0B, 0x0C, 0x0D
MOTION, CAR_TYPE = 0x12, 0x15
SERVO, TORQUE, ARM = 0x20, 0x22, 0x23
REQUEST, VERSION = 0x50, 0x51
KEEP: Final = 0x5F
"""Has the board keep a setting in its flash."""
ALL_LIGHTS: Final = 0xFF
PULSES: Final = (96, 4000)
"""Least and greatest position of a servo."""
SERVO_MS: Final = 2000
"""Longest time that a servo may be given for a move."""

# To the board


def frame(function: int, data: bytes = b"") -> bytes:
    """The bytes of a frame to the board."""
    body = TO_BOARD + bytes((HEAD - 1 + len(data), function)) + data
    return body + bytes(((sum(body) + 5) & 0xFF,))


def motion(car_type: int, twist: Twist) -> bytes:
    """Drive at ``twist`` (m/s, rad/s, base frame) until another is told: the board knows no time-out."""
    values = (round(1000 * value) for value in (twist.vx, twist.vy, twist.wz))
    return frame(MOTION, struct.pack("<B3h", car_type, *(max(-32768, min(32767, value)) for value in values)))


def servo(number: int, pulse: int, milliseconds: int) -> bytes:
    """Turn servo ``number``, 1 to 6, to a position in this time."""
    return frame(SERVO, struct.pack("<B2h", number, _pulse(pulse), _time(milliseconds)))


def arm(pulses: Sequence[int], milliseconds: int) -> bytes:
    """Turn all six servos to positions in this time."""
    return frame(ARM, struct.pack("<7h", *map(_pulse, pulses), _time(milliseconds)))


def torque(on: bool) -> bytes:
    """Have the servos hold their positions, or let go of them."""
    return frame(TORQUE, bytes((on,)))


def beep(milliseconds: int) -> bytes:
    """Sound the buzzer for so long; 0 ends it, and less than 10 would sound until it is ended."""
    return frame(BEEP, struct.pack("<h", 0 if milliseconds <= 0 else max(10, min(32767, milliseconds))))


def light(red: int, green: int, blue: int) -> bytes:
    """Set the colour of all lights."""
    return frame(RGB, bytes((ALL_LIGHTS, red, green, blue)))


def car_type(number: int) -> bytes:
    """Tell the board which robot it is in; it keeps that."""
    return frame(CAR_TYPE, bytes((number, KEEP)))


def auto_report(on: bool) -> bytes:
    """Have the board send its readings by itself, until it is switched off."""
    return frame(AUTO_REPORT, bytes((on, 0)))


def request(function: int, parameter: int = 0) -> bytes:
    """Ask for one reading."""
    return frame(REQUEST, bytes((function, parameter)))


def _pulse(pulse: int) -> int:
    return max(PULSES[0], min(PULSES[1], pulse))


def _time(milliseconds: int) -> int:
    return max(0, min(SERVO_MS, milliseconds))


# From the board


@dataclass(frozen=True, slots=True)
class Speed:
    """What the wheels do, and the battery."""

    twist: Twist  # measured, base frame
    volts: float


@dataclass(frozen=True, slots=True)
class Attitude:
    """How the board lies in the world, rad."""

    roll: float
    pitch: float
    yaw: float


@dataclass(frozen=True, slots=True)
class Encoders:
    """What the four wheels have turned since the board was switched on, in counts that may wrap."""

    counts: tuple[int, int, int, int]


@dataclass(frozen=True, slots=True)
class ServoAt:
    """Where one servo is."""

    number: int
    pulse: int


@dataclass(frozen=True, slots=True)
class ArmAt:
    """Where all servos are; a negative one did not answer."""

    pulses: tuple[int, int, int, int, int, int]


@dataclass(frozen=True, slots=True)
class CarType:
    """Which robot the board believes to be in."""

    number: int


@dataclass(frozen=True, slots=True)
class Version:
    """Of what runs on the board."""

    major: int
    minor: int


@dataclass(frozen=True, slots=True)
class Other:
    """A frame that nobody here needs."""

    kind: int


Report = Speed | Attitude | Encoders | ServoAt | ArmAt | CarType | Version | Other


def report(kind: int, data: bytes) -> Report | None:
    """What a frame of the board tells; None where its data are none of that kind."""
    try:
        match kind:
            case _ if kind == SPEED:
                vx, vy, wz, tenths = struct.unpack("<3hB", data)
                return Speed(Twist(vx / 1000, vy / 1000, wz / 1000), tenths / 10)
            case _ if kind == ATTITUDE:
                angles = [value / 10000 for value in struct.unpack("<3h", data)]
                return Attitude(*angles) if all(abs(angle) <= math.pi + 0.01 for angle in angles) else None
            case _ if kind == ENCODERS:
                return Encoders(struct.unpack("<4i", data))
            case _ if kind == SERVO:
                return ServoAt(*struct.unpack("<Bh", data))
            case _ if kind == ARM:
                return ArmAt(struct.unpack("<6h", data))
            case _ if kind == CAR_TYPE:
                return CarType(data[0]) if data else None
            case _ if kind == VERSION:
                major, minor = struct.unpack("<2B", data[:2])
                return Version(major, minor)
    except struct.error:
        return None
    return Other(kind)


def report_bytes(kind: int, data: bytes) -> bytes:
    """A frame as the board sends it (for the emulator)."""
    length = len(data) + 3
    return FROM_BOARD + bytes((length, kind)) + data + bytes(((length + kind + sum(data)) & 0xFF,))


class FromBoard:
    """How frames of the board are found in a stream (``engine.framing.Framer``)."""

    header = FROM_BOARD
    head = HEAD
    longest = LONGEST

    def length(self, head: bytes) -> int | None:
        """Of the whole frame that begins so; None where none does."""
        return head[2] + 2 if 3 <= head[2] <= LONGEST - 2 else None

    def read(self, frame: bytes) -> Report | None:
        """What the frame tells; None where it is none."""
        return report(frame[3], frame[HEAD:-1]) if sum(frame[2:-1]) & 0xFF == frame[-1] else None


@dataclass(frozen=True, slots=True)
class Order:
    """A frame to the board, as the emulator finds it."""

    function: int
    data: bytes


class ToBoard:
    """How frames to the board are found in a stream (for the emulator)."""

    header = TO_BOARD
    head = HEAD
    longest = LONGEST

    def length(self, head: bytes) -> int | None:
        """Of the whole frame that begins so; None where none does."""
        return head[2] + 2 if 3 <= head[2] <= LONGEST - 2 else None

    def read(self, frame: bytes) -> Order | None:
        """The order; None where it is none."""
        return Order(frame[3], frame[HEAD:-1]) if (sum(frame[:-1]) + 5) & 0xFF == frame[-1] else None
