"""Whether a number of a plan has a ground: it was said, or is a convention of what was said ("turn around")."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Final

from engine.plan import Action
from engine.planner.conventions import DRIVE_SPEED, FULL, HALF, QUARTER, TURN_SPEED, Manner
from engine.planner.grounding.grounds import Grounds
from engine.skills.registry import Parameter

_SLOW: Final = re.compile(
    r"\b(?:slow\w*|gently|careful\w*|gradual\w*|turtle|tortoise|snail\w*|easy|crawl|creep)\b|慢|小心|轻轻|缓"
)
_FAST: Final = re.compile(
    r"\b(?:fast\w*|quick\w*|rapid\w*|swift\w*|brisk\w*|rabbit|hare|hurry|run|rush|speed\w*|race)\b|快|迅速|赶紧|跑"
)
_CORNER: Final = re.compile(
    r"\b(?:left\w*|right\w*|turn|corner|square|quarter|clockwise|counterclockwise|sideways)\b|左|右|转|正方形|直角"
)
_AROUND: Final = re.compile(
    r"\b(?:around|round|back\w*|half|behind|opposite|reverse|face me|one eighty)\b|掉头|转身|后|半圈|回头|反"
)
_CIRCLE: Final = re.compile(
    r"\b(?:circles?|full|spin|whole|complete|around|round|pirouette|revolution|rotation|once|three sixty)\b|圈|周|转一"
)
_TURNS: Final = ((QUARTER, _CORNER), (HALF, _AROUND), (FULL, _CIRCLE))
"""Angles that need not be said, and the words that stand for them."""
_POINTS: Final = (
    (0.0, re.compile(r"\bright\b|右")),
    (QUARTER, re.compile(r"\b(?:ahead|forwards?|front|middle|straight|cent(?:re|er))\b|前|中间")),
    (HALF, re.compile(r"\bleft\b|左")),
)
"""Where the arm points at the angles of servo 1 that need not be said."""
_PIXELS: Final = frozenset({"x", "y", "x1", "y1", "x2", "y2"})
"""Parameters that are read off a picture; nobody says them."""
_CLOSE: Final = 0.02
"""Relative: a foot is 30 cm to a model and 0.3048 m to a table of units."""


def is_grounded_number(grounds: Grounds, action: Action, parameter: Parameter, value: float) -> bool:
    """Whether ``value`` may be this argument of ``action``; its sign is not looked at."""
    if parameter.name in _PIXELS:
        return True
    if action.name == "set_cmdvel":
        return _is_grounded_velocity(grounds, action, parameter, value)
    size = abs(value)
    if _was_said(grounds, size, parameter.unit):
        return True
    match parameter.unit:
        case "deg" if action.name == "servo1_move":
            return any(_near(size, angle) and grounds.says(pattern) for angle, pattern in _POINTS)
        case "deg":
            return _is_usual_turn(grounds, size)
        case "m/s":
            return _is_manner(grounds, size, DRIVE_SPEED)
        case "rad/s":
            return _is_manner(grounds, size, TURN_SPEED)
    return False


def _is_grounded_velocity(grounds: Grounds, action: Action, parameter: Parameter, value: float) -> bool:
    """A part of a velocity command: as said, or such that it covers the way that was said."""
    if value == 0:
        return True
    lasting = _number(action, "duration")
    if parameter.name == "duration":
        parts = (("linear_x", "m"), ("linear_y", "m"), ("angular_z", "rad"))
        return _was_said(grounds, value, "s") or any(
            _covers(grounds, _number(action, name) * lasting, unit) for name, unit in parts
        )
    angular = parameter.name == "angular_z"
    if _covers(grounds, value * lasting, "rad" if angular else "m") or _was_said(grounds, abs(value), parameter.unit):
        return True
    return _is_manner(grounds, abs(value), TURN_SPEED if angular else DRIVE_SPEED)


def _covers(grounds: Grounds, way: float, unit: str) -> bool:
    size = abs(way)
    if unit == "m":
        return _was_said(grounds, size, "m")
    degrees = math.degrees(size)
    return _was_said(grounds, degrees, "deg") or _is_usual_turn(grounds, degrees)


def _was_said(grounds: Grounds, size: float, unit: str) -> bool:
    """As a quantity of this unit, or as a bare number; of a length, as one that counts nothing else."""
    for statement in grounds.everything():
        if any(said_unit == unit and _near(size, abs(said)) for said, said_unit in statement.quantities):
            return True
        if any(_near(size, abs(said)) for said in (statement.lone if unit == "m" else statement.numbers)):
            return True
        if unit == "s" and any(said_unit == "times" and _near(size, said) for said, said_unit in statement.quantities):
            return True
    return False


def _is_usual_turn(grounds: Grounds, degrees: float) -> bool:
    return any(_near(degrees, angle) and grounds.says(pattern) for angle, pattern in _TURNS)


def _is_manner(grounds: Grounds, size: float, speeds: Mapping[Manner | None, float]) -> bool:
    if _near(size, speeds[None]):
        return True
    return (_near(size, speeds["slow"]) and grounds.says(_SLOW)) or (
        _near(size, speeds["fast"]) and grounds.says(_FAST)
    )


def _number(action: Action, name: str) -> float:
    value = action.args.get(name, 0.0)
    return float(value) if isinstance(value, (int, float)) else 0.0


def _near(value: float, said: float) -> bool:
    return abs(value - said) <= _CLOSE * max(abs(said), 0.01)
