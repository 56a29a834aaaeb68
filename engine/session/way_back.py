"""The way back from what a turn did, found from records and never from words.

Every skill says what it may leave changed (:attr:`engine.skills.registry.Skill.changes`). What is changed now is found
by comparing the robot as it was when the turn's first action began with the robot as it is, so that it does not matter
how far an action got. The way back is a list of actions like any other: it is planned, checked and carried out as such.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from engine.perception.memory import Thing, World
from engine.perception.naming import wanted
from engine.plan import Action, ActionCall, InWords, Quantity, as_written
from engine.robot.arm import ARM_UP, Joints
from engine.robot.floor_map import FloorMap
from engine.robot.geometry import Pose, wrap
from engine.session.ran import Moment, Ran
from engine.skills.library.signals import COLOURS
from engine.skills.registry import Change, Skill, SkillRegistry

NEAR: Final = (0.03, math.radians(2))
"""m and rad within which the robot is where it was."""
JOINT: Final = 0.05
"""rad within which a joint is where it was."""
ON_TOP: Final = 0.03
"""m above the floor from which a thing stands on something."""

NOTHING_CHANGED: Final = "Nothing is to be undone: all is as it was."


@dataclass(frozen=True, slots=True)
class WayBack:
    """The actions that undo something; without any, ``why_not`` says why, in words for people;
    empty where nothing was done."""

    calls: tuple[ActionCall, ...] = ()
    why_not: str = ""


class NoWayBack(Exception):
    """Something was done that cannot be undone; the message says what and why."""


def way_back(
    acted: Sequence[Ran],
    skills: SkillRegistry,
    now: Moment,
    floor: FloorMap,
    rest: Joints,
    *,
    relocated: bool = False,
    told: Callable[[Action], InWords] = as_written,
) -> WayBack:
    """The way back from what was done in one turn. ``rest`` is the arm's initial pose; ``relocated``: somebody has put
    the robot elsewhere on the map since, so that no pose of the turn means anything any more; ``told`` tells people of
    an action."""
    if not acted:
        return WayBack()
    try:
        began = _began(acted)
        changes = {change for ran in acted for change in _changes(skills[ran.action.name], ran, told)}
        calls = tuple(_back(changes, acted, skills, began, now, floor, rest, relocated))
    except NoWayBack as why:
        return WayBack(why_not=str(why))
    return WayBack(calls, "" if calls else NOTHING_CHANGED)


def _changes(skill: Skill, ran: Ran, told: Callable[[Action], InWords]) -> frozenset[Change]:
    """What an action may have left changed. Raises :class:`NoWayBack`."""
    if skill.changes is None:
        raise NoWayBack(f"I cannot undo {told(ran.action).doing}.")
    if ran.result.outcome == "uncertain":
        raise NoWayBack(f"I do not know how far I got with {told(ran.action).doing}, so I cannot undo it.")
    return skill.changes


def _began(acted: Iterable[Ran]) -> Moment:
    """The moment in which the first of them began. Raises :class:`NoWayBack`."""
    moments = [ran.before for ran in acted]
    if any(moment is None for moment in moments):
        raise NoWayBack("I do not know how everything was before, so I cannot undo it.")
    return min((moment for moment in moments if moment is not None), key=lambda moment: moment.state.t)


def _back(
    changes: set[Change],
    acted: Sequence[Ran],
    skills: SkillRegistry,
    began: Moment,
    now: Moment,
    floor: FloorMap,
    rest: Joints,
    relocated: bool,
) -> Iterator[ActionCall]:
    """Things first, while the arm is free; the way back to where the robot stood last."""
    moved = tuple(ran for ran in acted if "things" in (skills[ran.action.name].changes or ()))
    if moved:
        yield from _things(moved, began.world, now.world, floor)
    elif (held := began.world.held) is not None and now.world.held is None:
        raise NoWayBack(f"I do not hold the {held.name} any more, so I cannot undo that.")
    if "arm" in changes and not _same(began.state.joint_targets, now.state.joint_targets):
        yield _arm(began.state.joint_targets, now.state.joint_targets, rest)
    if "light" in changes and began.state.light != now.state.light:
        yield ActionCall("light", (_colour(began.state.light),))
    if "pose" in changes and (moved or not _there(began.state.pose, now.state.pose)):
        if relocated:
            raise NoWayBack("I was put elsewhere on the map since, so I do not know the way back.")
        pose = began.state.pose
        heading = round(math.degrees(pose.yaw), 1)
        yield ActionCall(
            "return_to", (Quantity(round(pose.x, 3), "m"), Quantity(round(pose.y, 3), "m"), Quantity(heading, "deg"))
        )


def _there(before: Pose, now: Pose) -> bool:
    return before.distance_to(now) < NEAR[0] and abs(wrap(before.yaw - now.yaw)) < NEAR[1]


def _same(before: Joints, now: Joints) -> bool:
    return all(abs(old - new) < JOINT for old, new in zip(before, now, strict=True))


def _arm(before: Joints, now: Joints, rest: Joints) -> ActionCall:
    """What brings the arm back. Raises :class:`NoWayBack` where no skill does."""
    if _same(before, rest):
        return ActionCall("arm_down")
    if _same(before, ARM_UP):
        return ActionCall("arm_up")
    if _same((now[0], *before[1:]), now):  # it has only turned about its vertical axis
        return ActionCall("servo1_move", (Quantity(round(math.degrees(before[0])) + 90, "deg"),))
    raise NoWayBack("I have no skill that brings my arm back to where it was.")


def _colour(rgb: tuple[int, int, int]) -> str:
    for name, colour in COLOURS.items():
        if colour == rgb:
            return name
    raise NoWayBack("The light had a colour that I have no name for.")


# Things


def _things(moved: Sequence[Ran], before: World, now: World, floor: FloorMap) -> Iterator[ActionCall]:
    """One thing that was moved goes back to where it was known to stand. Raises :class:`NoWayBack`."""
    name = _moved(moved, before)
    if not moved[-1].result.ok:
        raise NoWayBack(f"I do not know where the {name} is now, so I cannot undo that.")
    held_before, held_now = (world.held is not None and world.held.name == name for world in (before, now))
    if held_before:
        if not held_now:
            yield ActionCall("pick_object", (name,))
        return
    surface = _surface(name, before, floor)
    if not held_now:
        yield ActionCall("pick_object", (name,))
    yield ActionCall("place_object", (surface,))


def _moved(moved: Sequence[Ran], before: World) -> str:
    """The name of the one thing that was moved."""
    names = {str(ran.action.args["object"]) for ran in moved if "object" in ran.action.args}
    names |= {held.name for ran in moved if ran.before is not None and (held := ran.before.world.held) is not None}
    if len(names) != 1:
        raise NoWayBack("Several things were moved, so I cannot undo that.")
    name = next(iter(names))
    known = (*before.things, *([before.held] if before.held is not None else []))
    found = {thing.name for thing in known if wanted(name).fits(thing.kind, thing.colour, thing.tag)}
    if len(found) > 1:
        raise NoWayBack(f"I know several things that are called {name}, so I cannot undo that.")
    return next(iter(found), name)


def _surface(name: str, before: World, floor: FloorMap) -> str:
    """The piece of furniture on which it was known to stand."""
    things = [thing for thing in before.things if thing.name == name]
    if len(things) > 1:
        raise NoWayBack(f"I know several things that are called {name}, so I cannot undo that.")
    if not things:
        raise NoWayBack(f"I did not know where the {name} was before, so I cannot bring it back.")
    if (surface := _stood_on(things[0], floor)) is None:
        raise NoWayBack(f"The {name} lay on the floor, and I cannot put it back on the same spot.")
    return surface


def _stood_on(thing: Thing, floor: FloorMap) -> str | None:
    x, y, _ = thing.position
    on_top = thing.surface > ON_TOP
    return next((piece.name for piece in floor.furniture if on_top and piece.holds(x, y)), None)
