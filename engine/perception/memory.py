"""What was seen where and when: the robot's memory of loose things, and beside it that of people.

Every sight updates it. A sighting close to a remembered thing that it could be is that thing, moved or not; another one
is new. What should be in the picture and is not there any more is forgotten, as long as nothing hides the place. What
the gripper holds is remembered apart: it moves with the robot. Positions age: see :meth:`Thing.is_stale`.

Thread-safe: the loop that runs skills writes, the console reads frozen facts.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from engine.perception.naming import Wanted
from engine.perception.people import PeopleMemory, PersonSeen
from engine.perception.sighting import Colour, Kind, Sight, Sighting
from engine.robot.camera import Picture

STALE_S: Final = 60.0
"""Robot time after which a position counts as stale, s: people move things."""
SAME: Final = 0.12
"""Two sightings of things alike are one thing within this distance, m, and three standard deviations."""
VISIBLE_RANGE: Final = 1.0
"""m within which a small thing that is in the picture is certain to be noticed."""
SPOT: Final = 0.035
"""m within which two small things cannot stand."""
MOST: Final = 200
"""Things that are remembered: beyond that the one that was seen longest ago is forgotten."""
_UNLIKE = 0.03  # m that count against something else on the same spot
_PILED = 0.03  # m between the middles of things in one picture that are not the same thing
_LARGER = 1.2  # times as wide as what shows of it
_ACROSS = 0.5  # m that somebody takes
_HANDED = (0.05, 0.08)  # m, of what was never seen
_ON_THE_FLOOR = 0.05  # m: what stands lower
_EDGE = 6  # pixels at the picture's edge where a thing may be cut off and not be noticed


@dataclass(frozen=True, slots=True)
class Thing:
    """One remembered thing. Positions as in :class:`Sighting`."""

    number: int  # unique in the session
    kind: Kind
    colour: Colour
    tag: int | None
    position: tuple[float, float, float]
    sigma: float
    size: tuple[float, float]
    surface: float
    yaw: float | None
    seen_at: float  # robot time, s
    named_from: float = math.inf  # m, how close the look was that told what it is
    whole: bool = True  # whether that look showed all of it

    @property
    def name(self) -> str:
        """What people would call it."""
        if self.kind == "person":
            return self.kind
        return f"block {self.tag}" if self.tag is not None else f"{self.colour} {self.kind}"

    def distance_to(self, x: float, y: float) -> float:
        """On the floor, m."""
        return math.hypot(self.position[0] - x, self.position[1] - y)

    def is_stale(self, now: float) -> bool:
        """Whether it was seen too long before ``now`` (robot time, s) to be sure that it still is there."""
        return now - self.seen_at > STALE_S


@dataclass(frozen=True, slots=True)
class World:
    """What is remembered at one moment."""

    things: tuple[Thing, ...] = ()
    held: Thing | None = None
    people: tuple[PersonSeen, ...] = ()


class WorldMemory:
    """All things seen so far, and what is held; ``people`` is everybody seen so far."""

    def __init__(self, people: PeopleMemory | None = None) -> None:
        self.people = people if people is not None else PeopleMemory()
        self._lock = threading.Lock()
        self._things: dict[int, Thing] = {}
        self._numbers = 0
        self._held: Thing | None = None
        self._pitch = math.pi

    @property
    def things(self) -> tuple[Thing, ...]:
        """Everything that lies or stands about, the newest sighting first. What may be a shoe or a leg of somebody who
        stands there is none: a picture of the floor does not show the rest of them."""
        people = self.people.everybody
        with self._lock:
            newest = sorted(self._things.values(), key=lambda thing: -thing.seen_at)
        return tuple(thing for thing in newest if not _is_part_of_somebody(thing, people))

    def snapshot(self) -> World:
        """Everything, for those who only look."""
        return World(self.things, self._held, self.people.everybody)

    @property
    def held(self) -> Thing | None:
        """What the gripper holds, as far as the robot knows."""
        return self._held

    @property
    def held_pitch(self) -> float:
        """Of the hand when it took what it holds, rad: with the hand like this, it is upright."""
        return self._pitch

    def find(self, what: Wanted, near: tuple[float, float] | None = None) -> tuple[Thing, ...]:
        """The things that are what is wanted, or the people: the nearest first where ``near`` is given, else the
        newest."""
        things = map(_as_thing, self.people.find(lambda person: True)) if what.kind == "person" else self.things
        found = [thing for thing in things if what.fits(thing.kind, thing.colour, thing.tag)]
        if near is not None:
            found.sort(key=lambda thing: thing.distance_to(*near))
        return tuple(found)

    def take(self, thing: Thing, pitch: float = math.pi) -> None:
        """The gripper holds it now, taken with the hand at ``pitch`` rad."""
        with self._lock:
            self._things.pop(thing.number, None)
            self._held, self._pitch = thing, pitch

    def receive(self, what: Wanted, t: float) -> Thing:
        """Somebody has put it into the gripper, at ``t`` (robot time, s): what it is, only they have said."""
        with self._lock:
            self._numbers += 1
            self._held, self._pitch = (
                Thing(
                    number=self._numbers,
                    kind=what.kind or "thing",
                    colour=what.colour or "grey",
                    tag=what.tag,
                    position=(0.0, 0.0, 0.0),
                    sigma=0.0,
                    size=_HANDED,
                    surface=0.0,
                    yaw=None,
                    seen_at=t,
                ),
                math.pi / 2,
            )
            return self._held

    def put(self, position: tuple[float, float, float] | None, t: float) -> None:
        """What was held lies at ``position`` (of its middle, map frame) now; None: nobody knows where."""
        with self._lock:
            held, self._held = self._held, None
            if held is not None and position is not None:
                self._things[held.number] = replace(held, position=position, sigma=max(held.sigma, 0.03), seen_at=t)

    def forget(self, thing: Thing) -> None:
        """It is not where it was."""
        if thing.kind == "person":
            self.people.forget(-thing.number)
            return
        with self._lock:
            self._things.pop(thing.number, None)

    def clear(self) -> None:
        """Begin anew."""
        with self._lock:
            self._things.clear()
            self._held = None
        self.people.clear()

    def update(self, sight: Sight) -> tuple[Thing, ...]:
        """Take in what was seen; gives the things in the picture in the order of ``sight.objects``, without people."""
        self.people.update(sight)
        objects = [thing for thing in sight.objects if thing.kind != "person"]
        with self._lock:
            seen: dict[int, Thing] = {}
            found: dict[int, Thing] = {}
            by_number = sorted(range(len(objects)), key=lambda index: objects[index].tag is None)
            for index in by_number:  # a tag says which thing it is, the rest goes by where it is
                sighting = objects[index]
                known = self._match(sighting, seen.keys())
                if known is not None and known.number in seen:  # another part of what is in the picture already
                    found[index] = seen[known.number]
                    continue
                found[index] = thing = self._remember(sighting, known, sight.t)
                seen[thing.number] = thing
            for number in self._missing(sight.picture, seen.keys()) | self._doubles(seen):
                del self._things[number]
            for thing in sorted(self._things.values(), key=lambda thing: -thing.seen_at)[MOST:]:
                del self._things[thing.number]
            return tuple(found[index] for index in range(len(objects)))

    def _match(self, sighting: Sighting, taken: Collection[int]) -> Thing | None:
        """The remembered thing that this is, if there is one: the one of its number wherever that was, one like it near
        by, or whatever stands on that spot."""
        if sighting.tag is not None:
            for thing in self._things.values():
                if thing.tag == sighting.tag:
                    return thing
        best, nearest = None, math.inf
        for thing in self._things.values():
            distance = math.dist(thing.position, sighting.position)
            if thing.number not in taken and _is_part(thing, sighting):
                limit = math.inf
            elif _alike(thing, sighting) and thing.number not in taken:
                limit = max(SAME, 3 * math.hypot(thing.sigma, sighting.sigma))
            elif (sighting.tag is not None and thing.tag is not None) or (thing.number in taken and distance > _PILED):
                continue  # another block, or one stands on the other
            else:
                limit, distance = SPOT + _UNLIKE, distance + _UNLIKE
            if distance < min(limit, nearest):
                best, nearest = thing, distance
        return best

    def _remember(self, sighting: Sighting, known: Thing | None, t: float) -> Thing:
        """Where it is, the newest look tells unless an older one knew much better; what it is, the closest one."""
        if known is None:
            self._numbers += 1
        better = known is None or (
            not _is_part(known, sighting) and (sighting.sigma <= 1.5 * known.sigma or _moved(known, sighting))
        )
        place: Sighting | Thing = sighting if better or known is None else known
        surer = (
            known is None
            or known.kind == "thing"
            or (sighting.complete and sighting.range <= 1.2 * known.named_from)
            or (not known.whole and (sighting.complete or math.prod(sighting.size) > math.prod(known.size)))
        )
        shape: Sighting | Thing = sighting if surer or known is None else known
        thing = Thing(
            number=known.number if known is not None else self._numbers,
            kind=shape.kind,
            colour=shape.colour,
            tag=sighting.tag if sighting.tag is not None or known is None else known.tag,
            position=place.position,
            sigma=place.sigma,
            size=shape.size,
            surface=place.surface,
            yaw=place.yaw,
            seen_at=t,
            named_from=sighting.range if surer or known is None else known.named_from,
            whole=sighting.complete if surer or known is None else known.whole,
        )
        self._things[thing.number] = thing
        return thing

    def _doubles(self, seen: Mapping[int, Thing]) -> set[int]:
        """Remembered things that are nothing but older, worse looks at what was seen now."""
        return {
            number
            for number, thing in self._things.items()
            if number not in seen
            and any(
                _within(thing, other)
                or (
                    other.named_from < thing.named_from
                    and (other.whole or not thing.whole)
                    and other.distance_to(*thing.position[:2]) < max(SPOT, min(SAME, 2 * thing.sigma))
                )
                for other in seen.values()
            )
        }

    def _missing(self, picture: Picture, seen: Collection[int]) -> set[int]:
        """Things that the picture should show, near and unhidden, and does not."""
        rest = [thing for thing in self._things.values() if thing.number not in seen]
        if not rest:
            return set()
        points = picture.from_map(np.array([thing.position for thing in rest]))
        depth = picture.mount.into(points)[:, 2]
        pixels = picture.pixels(points)
        height, width = picture.depth.shape
        gone = set()
        for thing, z, (column, row) in zip(rest, depth, pixels, strict=True):
            if not 0.05 < z < VISIBLE_RANGE:
                continue
            inside = _EDGE < column < width - _EDGE and _EDGE < row < height - _EDGE
            if inside and picture.depth[int(row), int(column)] > z + 0.03 + 2 * thing.sigma:
                gone.add(thing.number)
        return gone


def _is_part_of_somebody(thing: Thing, people: Sequence[PersonSeen]) -> bool:
    if thing.tag is not None or thing.surface > _ON_THE_FLOOR:
        return False
    return any(person.may_be_part(thing.colour, thing.position[:2], thing.seen_at) for person in people)


def _as_thing(person: PersonSeen) -> Thing:
    """Somebody, for those who look for people as they look for things; no thing has a number below 1."""
    return Thing(
        -person.number, "person", person.shirt or "grey", None, person.position, person.sigma, (_ACROSS, person.height),
        0.0, None, -math.inf if person.gone else person.seen_at,
    )  # fmt: skip


def _alike(thing: Thing, sighting: Sighting) -> bool:
    if thing.tag is not None and sighting.tag is not None:
        return thing.tag == sighting.tag
    if thing.tag is not None or sighting.tag is not None:  # a block whose tag does not show is a box
        return {thing.kind, sighting.kind} <= {"block", "box", "thing"}
    return thing.colour == sighting.colour and (thing.kind == sighting.kind or "thing" in (thing.kind, sighting.kind))


def _is_part(thing: Thing, sighting: Sighting) -> bool:
    """Whether this is a piece of a larger thing, the rest of which the picture's edge or something else hides."""
    smaller = not sighting.complete and sighting.size[0] * _LARGER < thing.size[0]
    return smaller and thing.colour == sighting.colour and thing.distance_to(*sighting.position[:2]) < thing.size[0]


def _within(thing: Thing, seen: Thing) -> bool:
    """Whether it can only have been a piece of what was seen now: the middle of it is inside."""
    x, y, z = thing.position
    high = seen.surface < z < seen.surface + seen.size[1]
    smaller = thing.size[1] * _LARGER < seen.size[1] and seen.whole and seen.named_from < 1.5 * thing.named_from
    return high and smaller and seen.distance_to(x, y) < seen.size[0] / 2


def _moved(thing: Thing, sighting: Sighting) -> bool:
    return thing.distance_to(*sighting.position[:2]) > 3 * math.hypot(thing.sigma, sighting.sigma)
