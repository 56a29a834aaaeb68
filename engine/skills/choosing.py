"""Which one of several things is meant: the leftmost, the biggest, the one on the left of the cup.

The robot looks at all that is there before it chooses: on the piece of furniture that it stands at, else in the room.
Weights cannot be seen: the heaviest thing is the biggest one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final

from engine.perception.looking import LOOK_POSES, LookName
from engine.perception.memory import Thing
from engine.perception.naming import Rank, Side, Wanted
from engine.robot.floor_map import Furniture
from engine.robot.geometry import Pose
from engine.skills.context import SkillContext
from engine.skills.hand import move_to
from engine.skills.outcome import Result, fail
from engine.skills.search import room_at, search

STANDS_AT: Final = 0.9
"""m from its centre to the edge of a piece of furniture that the robot stands at."""
BY: Final = 0.45
"""m from the edge of a piece of furniture, within which a thing belongs to it where nothing is on it."""
_LOOKS: Final[tuple[tuple[LookName, float], ...]] = (
    ("DOWN", 0.0), ("AHEAD", 0.0), ("AHEAD", 0.65), ("AHEAD", -0.65)
)  # fmt: skip
"""Where to look to see all of a piece of furniture, and how far to the side, rad."""
_NEXT_TO: Final = 0.7
"""m between two things of which one is beside the other."""
_STACKED: Final = 0.12  # m on the floor between the middles of two things of which one lies on the other
_HIGHER: Final = 0.02  # m between them in height


def furniture_at(context: SkillContext) -> Furniture | None:
    """What the robot stands at; None in the middle of a room."""
    pose = context.pose
    pieces = context.robot.floor_map.furniture
    nearest = min(pieces, key=lambda piece: piece.away(pose.x, pose.y), default=None)
    return nearest if nearest is not None and nearest.away(pose.x, pose.y) < STANDS_AT else None


async def seen_here(context: SkillContext) -> tuple[Thing, ...] | Result:
    """All things on the piece of furniture at which the robot stands, else around it, else in the room; it looks at
    them first."""
    began = context.robot.state().t
    piece = furniture_at(context)
    room = room_at(context.robot.floor_map, context.pose.x, context.pose.y)
    if piece is None:
        searched = await search(context, room)
        if searched.trouble is not None:
            return searched.trouble
        return tuple(thing for thing in context.world.things if room.holds(*thing.position[:2]))
    for name, yaw in _LOOKS:
        if not await move_to(context, LOOK_POSES[name].turned(yaw)):
            return fail("no_progress", "The arm stopped on the way to its looking pose.")
        await context.see()
    fresh = [thing for thing in context.world.things if thing.seen_at >= began]
    on_it = tuple(t for t in fresh if t.surface > 0.03 and piece.away(*t.position[:2]) == 0.0)
    return on_it or tuple(t for t in fresh if piece.away(*t.position[:2]) < BY)


async def choose(context: SkillContext, what: Wanted) -> Thing | Result:
    """The one that is meant, of all that are here."""
    things = await seen_here(context)
    if isinstance(things, Result):
        return things
    best = best_of(things, what, context.pose)
    if best:
        return best[0]
    return fail("object_not_found", f"I looked around here and saw no {what}.")


def best_of(things: Sequence[Thing], what: Wanted, pose: Pose) -> tuple[Thing, ...]:
    """Those that fit, the one that is meant first: ``pose`` is where the robot looks from."""
    fitting = [thing for thing in things if what.fits(thing.kind, thing.colour, thing.tag)]
    if what.beside is not None:
        side, other = what.beside
        anchors = [thing for thing in things if other.fits(thing.kind, thing.colour, thing.tag)]
        apart = {
            thing.number: min((away for anchor in anchors if (away := _apart(thing, anchor, side, pose))), default=0.0)
            for thing in fitting
        }
        fitting = [thing for thing in fitting if apart[thing.number]]
        fitting.sort(key=lambda thing: apart[thing.number])
    if what.rank is not None:
        sign, measure = _MEASURES[what.rank]
        fitting.sort(key=lambda thing: sign * measure(thing, pose))
    return tuple(fitting)


def _apart(thing: Thing, anchor: Thing, side: Side, pose: Pose) -> float:
    """How far it is from the other one, m; 0 where it is not on that side."""
    away = math.dist(thing.position[:2], anchor.position[:2])
    if thing is anchor or away > _NEXT_TO:
        return 0.0
    if side in ("on top of", "under"):
        higher = (thing.position[2] - anchor.position[2]) * (1 if side == "on top of" else -1)
        return higher if higher > _HIGHER and away < _STACKED else 0.0
    left = _left(thing, pose) - _left(anchor, pose)
    behind = _ahead(thing, pose) - _ahead(anchor, pose)
    there = {
        "left of": left > abs(behind), "right of": -left > abs(behind),
        "behind": behind > abs(left), "in front of": -behind > abs(left), "next to": True,
    }[side]  # fmt: skip
    return math.hypot(left, behind) if there else 0.0


def _left(thing: Thing, pose: Pose) -> float:
    """To the left of the robot, m."""
    x, y = thing.position[0] - pose.x, thing.position[1] - pose.y
    return y * math.cos(pose.yaw) - x * math.sin(pose.yaw)


def _ahead(thing: Thing, pose: Pose) -> float:
    x, y = thing.position[0] - pose.x, thing.position[1] - pose.y
    return x * math.cos(pose.yaw) + y * math.sin(pose.yaw)


def _away(thing: Thing, pose: Pose) -> float:
    return thing.distance_to(pose.x, pose.y)


def _bulk(thing: Thing, pose: Pose) -> float:
    """As if it were as deep as wide, m³."""
    return thing.size[0] ** 2 * thing.size[1]


_MEASURES: Final[dict[Rank, tuple[int, Callable[[Thing, Pose], float]]]] = {
    "nearest": (1, _away), "farthest": (-1, _away),
    "leftmost": (-1, _left), "rightmost": (1, _left),
    "biggest": (-1, _bulk), "heaviest": (-1, _bulk), "smallest": (1, _bulk), "lightest": (1, _bulk),
    "tallest": (-1, lambda thing, pose: thing.size[1]), "shortest": (1, lambda thing, pose: thing.size[1]),
    "thinnest": (1, lambda thing, pose: thing.size[0]),
}  # fmt: skip
"""What the things are ordered by, and whether the least (1) or the most (-1) is meant."""
