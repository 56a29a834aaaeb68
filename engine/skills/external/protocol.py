"""What the engine and an external skill say to each other: JSON objects, one a line, over its stdin and stdout.

The engine begins, once::

    {"start": {"name", "args": {NAME: VALUE}, "epoch", "robot": {"name", "capabilities", "footprint": {"length",
      "width"}, "arm": {"shoulder", "upper", "fore", "hand", "jaw", "ranges", "eye"}}, "places": {SYMBOL: {"names":
      [NAME, …], "x", "y", "yaw"}}, "map": {"resolution", "origin": [x, y], "rows": ["#..#", …], "rooms": [{"name",
      "x_min", "y_min", "x_max", "y_max"}], "furniture": [the same, and "height", "kind"], "doors": [{"between":
      [ROOM, ROOM], "x", "y", "width"}], "tags": [{"id", "x", "y", "z", "yaw", "size"}], "walls": [{"x_min", "y_min",
      "x_max", "y_max"}]}, "state": STATE}}

and then answers: ``{"state": STATE}`` to each tick, ``{"scan": {"t", "angles", "ranges"}}`` to each wish for a scan,
``{"picture": {"t", "pose", "lens": {"width", "height", "fx", "fy", "cx", "cy"}, "mount": {"rotation": [3 rows],
"position"}, "rgb", "depth"}}`` to each wish for a picture. Its pixels are in base64, row by row from the top: three
bytes of colour, and two of depth, little-endian, in mm along the line of sight (0: none). The mount takes points of
the optical frame (x right, y down, z ahead) to the base frame. Capabilities are those that the program occupies; tags
are AprilTags 36h11 that hang in the house.
STATE is ``{"t", "pose": [x, y, yaw], "twist": [vx, vy, wz], "command": [vx, vy, wz], "joints": [5], "joint_targets":
[5], "gripper", "grip", "light": [r, g, b], "blocked", "halted", "paused_s"}``. Everything is in SI units and radians,
poses in the map frame, twists in the base frame; row 0 of the map is the southernmost, "#" is occupied, a range of null
hit nothing. While the robot is paused no tick comes; ``paused_s`` is how much of ``t`` that was.

The program may say, one or several in an object:

======================================================  ==============================================================
``{"tick": true}``                                      answered by the state after the next control period (20 ms of
                                                        robot time); time may pass only while a program waits here
``{"drive": [vx, vy, wz]}``                             needs ``base``; dies after 0.2 s, so repeat it every tick
``{"arm": [5 joints], "speed": rad/s}``                 needs ``arm``; ``speed`` may be left out
``{"gripper": 0…1}``                                    needs ``arm``
``{"light": [r, g, b]}``, ``{"beep": s}``               need nothing
``{"scan": true}``                                      answered at once
``{"look": true}``                                      needs ``camera``; answered by a picture of now
``{"relocate": {"believed": [x, y, yaw],                needs ``base``: when it believed to be here, it was there;
"true": [x, y, yaw]}}``                                 poses go on from that, and nothing moves; on the map, and 2 m
                                                        and 90° off at most
``{"say": "…"}``                                        needs ``voice``; spoken while the program goes on
``{"progress": {"fraction", "message", "path"}}``       any of them; ``path`` is the way ahead as [[x, y], …]
``{"result": {"outcome", "error_code", "message",       the end: ``ok``, or ``failed`` with a code of
"data"}}``                                              ``engine.skills.outcome.ErrorCode``
======================================================  ==============================================================

A program that ends without a result has done it (exit code 0) or failed; its last words on stderr are the message
then. What it needs must be declared in ``occupies``. What cannot be read is counted, told once, and does nothing.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, get_args

from engine.robot.arm import Joints
from engine.robot.geometry import Pose, Twist, wrap
from engine.robot.robot import Capability
from engine.skills.outcome import ErrorCode, Result, fail

MAX_WORDS = 1000
"""Longest text that a program may have shown or spoken, characters."""
MAX_PATH = 10_000
MAX_NUMBER = 1e6
"""Largest number that a program may say, in m, rad or s: a larger one is a fault, and its square may overflow."""


class NotUnderstood(Exception):
    """A line that is no message of this protocol."""


@dataclass(frozen=True, slots=True)
class Tick:
    """Wants to wait for the next control period."""


@dataclass(frozen=True, slots=True)
class ScanWish:
    """Wants the newest lidar scan."""


@dataclass(frozen=True, slots=True)
class Look:
    """Wants a picture of now."""


@dataclass(frozen=True, slots=True)
class Relocate:
    """Knows better where the robot is."""

    believed: Pose
    true: Pose


@dataclass(frozen=True, slots=True)
class Drive:
    twist: Twist


@dataclass(frozen=True, slots=True)
class Arm:
    joints: Joints
    speed: float  # rad/s


@dataclass(frozen=True, slots=True)
class Gripper:
    opening: float


@dataclass(frozen=True, slots=True)
class Light:
    rgb: tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class Beep:
    seconds: float


@dataclass(frozen=True, slots=True)
class Speech:
    text: str


@dataclass(frozen=True, slots=True)
class Report:
    """Progress."""

    fraction: float | None
    message: str
    path: tuple[tuple[float, float], ...] | None


@dataclass(frozen=True, slots=True)
class Finished:
    result: Result


Message = Tick | ScanWish | Look | Relocate | Drive | Arm | Gripper | Light | Beep | Speech | Report | Finished

NEEDS: Mapping[type[Message], Capability] = {
    Look: "camera",
    Relocate: "base",
    Drive: "base",
    Arm: "arm",
    Gripper: "arm",
    Speech: "voice",
}
"""What a program must have declared to say this."""


def read(line: str) -> tuple[Message, ...]:
    """The messages of one line. Raises :class:`NotUnderstood`; then none of them counts."""
    try:
        found = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise NotUnderstood(line) from error
    if not isinstance(found, dict) or not found:
        raise NotUnderstood(line)
    try:
        return tuple(_messages(found))
    except (TypeError, ValueError, KeyError, OverflowError) as error:
        raise NotUnderstood(line) from error


def _messages(found: dict[str, Any]) -> Iterator[Message]:
    for key, value in found.items():
        match key, value:
            case "tick", True:
                yield Tick()
            case "scan", True:
                yield ScanWish()
            case "look", True:
                yield Look()
            case "relocate", {"believed": believed, "true": true}:
                yield Relocate(_pose(believed), _pose(true))
            case "drive", _:
                vx, vy, wz = _numbers(value, 3)
                yield Drive(Twist(vx, vy, wz))
            case "arm", _:
                yaw, shoulder, elbow, wrist, roll = _numbers(value, 5)
                [speed] = _numbers([found.get("speed", 1.0)], 1)
                yield Arm((yaw, shoulder, elbow, wrist, roll), speed)
            case "speed", _ if "arm" in found:
                pass
            case "gripper", _:
                yield Gripper(_numbers([value], 1)[0])
            case "light", _:
                red, green, blue = (max(0, min(255, int(part))) for part in _numbers(value, 3))
                yield Light((red, green, blue))
            case "beep", _:
                yield Beep(max(0.0, min(5.0, _numbers([value], 1)[0])))
            case "say", str():
                yield Speech(plain(value))
            case "progress", dict():
                yield _report(value)
            case "result", _:
                yield Finished(_result(value))
            case _:
                raise ValueError(key)


def _numbers(value: object, count: int) -> list[float]:
    if not isinstance(value, list) or len(value) != count:
        raise ValueError(value)
    if not all(isinstance(item, (int, float)) and not isinstance(item, bool) for item in value):
        raise TypeError(value)
    numbers = [float(item) for item in value]
    if not all(abs(number) <= MAX_NUMBER for number in numbers):  # nor what is no number
        raise ValueError(value)
    return numbers


def _pose(value: object) -> Pose:
    x, y, yaw = _numbers(value, 3)
    return Pose(x, y, wrap(yaw))


def _report(value: dict[str, Any]) -> Report:
    fraction, path = value.get("fraction"), value.get("path")
    if fraction is not None:
        fraction = max(0.0, min(1.0, _numbers([fraction], 1)[0]))
    if path is not None:
        path = tuple((x, y) for x, y in (_numbers(point, 2) for point in path[:MAX_PATH]))
    return Report(fraction, plain(str(value.get("message") or "")), path)


def _result(value: object) -> Result:
    """A result that cannot be read is a fault of the program, and still its end."""
    if not isinstance(value, dict) or value.get("outcome") not in ("ok", "failed"):
        return fail("crashed", "It ended with a result that I cannot read.")
    said, code, data = plain(str(value.get("message") or "")), value.get("error_code"), value.get("data")
    facts = {
        str(name): fact
        for name, fact in (data if isinstance(data, dict) else {}).items()
        if isinstance(fact, (str, bool, int, float))
    }
    if value["outcome"] == "ok":
        return Result("ok", None, said, facts)
    return Result("failed", code if code in get_args(ErrorCode) else "crashed", said, facts)


def plain(text: str) -> str:
    """Text that may be shown in a terminal: one line, no control characters, not too long."""
    words = " ".join("".join(c if c.isprintable() else " " for c in text[: 2 * MAX_WORDS]).split())
    return words if len(words) <= MAX_WORDS else f"{words[: MAX_WORDS - 1]}…"
