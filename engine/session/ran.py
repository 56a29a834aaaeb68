"""An action that ran: how it ended, and how everything was when it began. What is left of one that was cut is counted
from that."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

from engine.perception.memory import World
from engine.plan import Action
from engine.robot.geometry import Pose, wrap
from engine.robot.robot import RobotState
from engine.skills.outcome import Result

MOST_TURNED: Final = 170.0
"""degrees: the heading tells how much of a turn has been done up to here."""


@dataclass(frozen=True, slots=True)
class Moment:
    """The robot, and what it remembered of things, at one moment."""

    state: RobotState
    world: World


@dataclass(frozen=True, slots=True)
class Ran:
    """An action and how it ended."""

    action: Action
    result: Result
    duration_s: float  # robot time
    before: Moment | None = None
    """When it began; None: the robot could not be asked."""
    after: Pose | None = None
    """Where the robot was when it ended."""
    began: bool = True
    """False: the robot refused to begin it as it stood, and nothing came of it."""


def rest_of(ran: Ran) -> Action | None:
    """What is left of a relative motion, or of a wait, that was cut: of nothing left, an amount of 0. None where nobody
    knows how much that is, or the action is done anew."""
    match ran.action.name:
        case "wait":
            return _less(ran, "seconds", ran.duration_s)
        case "set_cmdvel":
            return _less(ran, "duration", ran.duration_s)
    if ran.before is None or ran.after is None:
        return None
    began, ended = ran.before.state.pose, ran.after
    x, y = ended.x - began.x, ended.y - began.y
    turned = math.degrees(wrap(ended.yaw - began.yaw))
    match ran.action.name:
        case "move_forward":
            return _less(ran, "distance", x * math.cos(began.yaw) + y * math.sin(began.yaw))
        case "move_sideways":
            return _less(ran, "distance", y * math.cos(began.yaw) - x * math.sin(began.yaw))
        case "move_left" if float(ran.action.args["angle"]) <= MOST_TURNED:
            return _less(ran, "angle", turned)
        case "move_right" if float(ran.action.args["angle"]) <= MOST_TURNED:
            return _less(ran, "angle", -turned)
    return None


def _less(ran: Ran, amount: str, done: float) -> Action:
    """The action with what is left of an amount; nobody goes back for what was too much."""
    wanted = float(ran.action.args[amount])
    left = wanted - done if (wanted - done) * wanted > 0 else 0.0
    return replace(ran.action, args={**ran.action.args, amount: round(left, 3)})
