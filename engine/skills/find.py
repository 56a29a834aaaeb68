"""Finding a thing: from memory if it was seen lately, else by looking around, then through the rooms, and by going
near to what might be it.

From afar a bottle may look like a box, and the number of a block cannot be read at all. What might be what is wanted is
visited, once each, before the search goes on.
"""

from __future__ import annotations

import math
from typing import Final

from engine.perception.looking import LOOK_POSES, LookName
from engine.perception.memory import Thing
from engine.perception.naming import Wanted
from engine.robot.floor_map import FloorMap, Furniture, Room
from engine.robot.geometry import Pose
from engine.skills.approach import stand_before
from engine.skills.choosing import choose
from engine.skills.context import SkillContext
from engine.skills.hand import move_to
from engine.skills.outcome import ErrorCode, Result, fail
from engine.skills.search import BRISK, Survey, room_at, search

NO_WAY: Final[frozenset[ErrorCode | None]] = frozenset({"path_blocked", "unreachable", "door_closed", "out_of_reach"})
"""Why one place may be left out of a search that goes on elsewhere."""
CLOSE: Final = 0.75
"""m from which one sees well what a thing is."""
_READ: Final = 0.34
"""m from the robot's centre from which the small tags of blocks are read, and everything else is told apart."""
_STEP: Final = 30.0
"""s by which a step away from there counts, per m."""
_SAME_PLACE: Final = 0.06  # m: what was visited there is not visited again
_GLANCES: Final[tuple[tuple[LookName, float], ...]] = (("DOWN", 0.0), ("AHEAD", 0.0), ("AHEAD", 0.65), ("AHEAD", -0.65))
"""Where to look without driving, and how far to the side, rad."""


class Finder:
    """One search for one thing. ``rooms``: where to look, in this order."""

    def __init__(self, context: SkillContext, what: Wanted, rooms: tuple[Room, ...]) -> None:
        self._context = context
        self._what = what
        self._rooms = rooms
        self._surveys: dict[str, Survey] = {}
        self._visited: list[tuple[float, float, float]] = []

    def known(self) -> Thing | None:
        """The nearest thing that is wanted, was seen lately, and is not in a bin."""
        context = self._context
        now = context.robot.state().t
        near = context.world.find(self._what, (context.pose.x, context.pose.y))
        return next((thing for thing in near if not thing.is_stale(now) and self._is_meant(thing)), None)

    async def glance(self) -> None:
        """Look down before the hull, ahead, and to the sides, without driving."""
        for name, yaw in _GLANCES:
            await move_to(self._context, LOOK_POSES[name].turned(yaw))
            await self._context.see()
            if self.known() is not None:
                return

    async def look_through(self, room: Room, least: float = 0.0) -> Result | None:
        """Look through a room until the thing is known, or, with ``least``, until little of it is seen per second
        (see ``search``); what kept it from that, if anything did. The second time it goes on where it left off."""
        context = self._context
        survey = self._surveys.get(room.name)
        if survey is None:
            survey = Survey(room, context.robot.floor_map, context.robot.footprint, context.pose)
            self._surveys[room.name] = survey
        while self.known() is None:
            if (thing := self._doubtful(room)) is not None:
                await self._visit(thing)
                continue
            searched = await search(
                context, room, lambda: self.known() is not None or self._doubtful(room) is not None, survey, least=least
            )
            if not searched.found:
                return searched.trouble
        return None

    def _is_meant(self, thing: Thing) -> bool:
        x, y, _ = thing.position
        return any(room.holds(x, y) for room in self._rooms) and not in_a_bin(thing, self._context.robot.floor_map)

    def _doubtful(self, room: Room) -> Thing | None:
        """What might be it and has not been visited, the nearest first."""
        pose = self._context.pose
        things = [thing for thing in things_in(self._context, room) if self._might_be(thing)]
        fresh = [t for t in things if all(math.dist(t.position, seen) > _SAME_PLACE for seen in self._visited)]
        return min(fresh, key=lambda thing: thing.distance_to(pose.x, pose.y), default=None)

    def _might_be(self, thing: Thing) -> bool:
        what = self._what
        if what.kind == "person":
            return False
        if what.tag is not None:
            return thing.tag is None and thing.kind in ("block", "box", "thing") and thing.colour in _LIKE_PAPER
        return thing.named_from > CLOSE and what.colour in (None, thing.colour) and thing.tag is None

    async def _visit(self, thing: Thing) -> None:
        self._visited.append(thing.position)
        context = self._context
        context.progress(None, f"taking a closer look at what may be the {self._what}")
        stood = await stand_before(context, thing.position, lambda way: _STEP * abs(way - _READ), thing.name)
        if stood.ok:
            await move_to(context, LOOK_POSES["AHEAD" if thing.surface > 0.05 else "DOWN"].joints)
            await context.see()


_LIKE_PAPER: Final = ("white", "grey", "black")


async def find(context: SkillContext, what: Wanted, *, rooms: tuple[Room, ...] | None = None) -> Thing | Result:
    """The thing that is wanted, or why there is none. It is looked for first where it was seen last, then in ``rooms``
    (all, beginning with this one, unless told otherwise). Of several things, one is chosen among all that are here."""
    if what.is_choice:
        return await choose(context, what)
    floor = context.robot.floor_map
    order = list(rooms if rooms is not None else by_distance(floor, context.pose))
    finder = Finder(context, what, tuple(order))
    if (thing := finder.known()) is not None:
        return thing
    await finder.glance()
    last = [room_at(floor, *thing.position[:2]) for thing in context.world.find(what)]
    order.sort(key=lambda room: room not in last)  # stable: where it was seen before comes first
    shut: Result | None = None
    seen_through: list[str] = []
    for least in (BRISK, 0.0) if len(order) > 1 else (0.0,):  # every room quickly, then every room to its corners
        shut, seen_through = None, []
        for room in order if least else reversed(order):  # back from the last one
            trouble = await finder.look_through(room, least)
            if (thing := finder.known()) is not None:
                return thing
            if trouble is None:
                seen_through.append(room.name)
            elif trouble.error_code in NO_WAY:
                shut = trouble  # another room may be open
            else:
                return trouble
    if not seen_through and shut is not None:
        return shut
    names = [room.name for room in order if room.name in seen_through]
    message = f"I looked in the {' and the '.join(names)} and saw no {what}."
    return fail("object_not_found", f"{message} {shut.message}" if shut is not None else message)


def by_distance(floor: FloorMap, pose: Pose) -> tuple[Room, ...]:
    """All rooms, the nearest first; the one around ``pose`` is the very first."""

    def away(room: Room) -> float:
        dx = max(room.x_min - pose.x, 0.0, pose.x - room.x_max)
        dy = max(room.y_min - pose.y, 0.0, pose.y - room.y_max)
        return dx * dx + dy * dy

    return tuple(sorted(floor.rooms, key=away)) or (room_at(floor, pose.x, pose.y),)


def room_called(context: SkillContext, name: str) -> Room:
    """The room of this name; the one that the robot is in for none."""
    floor = context.robot.floor_map
    found = next((room for room in floor.rooms if room.name == name), None)
    return found or room_at(floor, context.pose.x, context.pose.y)


def furniture_called(context: SkillContext, name: str) -> Furniture | None:
    """The piece of furniture of this name; ``bin`` is the nearest one."""
    floor, pose = context.robot.floor_map, context.pose
    if name == "bin":
        return nearest_bin(context, room_at(floor, pose.x, pose.y))
    return next((piece for piece in floor.furniture if piece.name == name), None)


def nearest_bin(context: SkillContext, room: Room) -> Furniture | None:
    """The bin in the room, else the nearest one."""
    pose = context.pose

    def away(piece: Furniture) -> tuple[bool, float]:
        x, y = (piece.x_min + piece.x_max) / 2, (piece.y_min + piece.y_max) / 2
        return not room.holds(x, y), (x - pose.x) ** 2 + (y - pose.y) ** 2

    bins = [piece for piece in context.robot.floor_map.furniture if piece.kind == "bin"]
    return min(bins, key=away, default=None)


def things_in(context: SkillContext, room: Room) -> tuple[Thing, ...]:
    """What is remembered to be in a room, the nearest to the robot first; what is in a bin is left out."""
    floor, pose = context.robot.floor_map, context.pose
    found = [thing for thing in context.world.things if room.holds(*thing.position[:2]) and not in_a_bin(thing, floor)]
    return tuple(sorted(found, key=lambda thing: thing.distance_to(pose.x, pose.y)))


def in_a_bin(thing: Thing, floor: FloorMap) -> bool:
    return any(piece.kind == "bin" and piece.holds(*thing.position[:2]) for piece in floor.furniture)


def whereabouts(thing: Thing, floor: FloorMap) -> str:
    """Where a thing is, in words: ``on the coffee table in the living room``."""
    x, y, _ = thing.position
    on = _furniture_under(thing, floor)
    room = next((room.name for room in floor.rooms if room.holds(x, y)), None)
    if thing.kind == "person":
        return f"in the {room}" if room else "here"
    return f"{f'on the {on}' if on else 'on the floor'}{f' in the {room}' if room else ''}"


def may_stand(thing: Thing, place: str, floor: FloorMap) -> bool:
    """Whether a thing may be on, in or right beside the piece of furniture of this name, or in the room; True where the
    map has no such name."""
    x, y, _ = thing.position
    if room := next((room for room in floor.rooms if room.name == place), None):
        return room.holds(x, y)
    piece = next((piece for piece in floor.furniture if piece.name == place), None)
    on = _furniture_under(thing, floor)
    return piece is None or (on == place if on is not None else piece.away(x, y) <= _BESIDE)


_BESIDE: Final = 0.5
"""m from a piece of furniture at which a thing on the floor is said to be there."""


def _furniture_under(thing: Thing, floor: FloorMap) -> str | None:
    """The name of what a thing stands on; None: the floor."""
    x, y, _ = thing.position
    under = (piece.name for piece in floor.furniture if thing.surface > 0.03 and piece.holds(x, y, margin=-0.05))
    return next(under, None)


def listing(things: tuple[Thing, ...]) -> str:
    """``two red boxes and a cup`` as people count."""
    names: dict[str, int] = {}
    for thing in things:
        names[thing.name] = names.get(thing.name, 0) + 1
    words = [f"{count} {_plural(name)}" if count > 1 else _one(name) for name, count in names.items()]
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def listing_the(things: tuple[Thing, ...]) -> str:
    """``the red box, the red box and the cup``."""
    words = [f"the {thing.name}" for thing in things]
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _one(name: str) -> str:
    if name.startswith("block "):
        return name
    return f"{'an' if name[0] in 'aeiou' else 'a'} {name}"


def _plural(name: str) -> str:
    return f"{name}es" if name.endswith("x") else f"{name}s"
