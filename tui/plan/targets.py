"""What one can point at on the map, and what is asked for by that: a place, a thing that was seen, or a room.

Pointing at something never moves the robot: a target has the request that would, in the words of a person, and it goes
the way of everything that is said.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from msgspec import Struct

from tui.shown.facts import printable
from tui.words import strings
from tui.words.language import told

if TYPE_CHECKING:
    from config.schema import Place
    from engine.perception.memory import Thing
    from engine.perception.people import PersonSeen
    from engine.robot.floor_map import FloorMap, Furniture, Room


class Target(Struct, frozen=True):
    """Something on the map."""

    x: float  # m, map frame
    y: float
    about: str
    """What it is, for people."""
    name: str = ""
    """Where one goes; empty: nobody can be sent there."""
    named: bool = False
    """It is somebody's name."""
    goal: tuple[float, float, str] | None = None
    """Where one really goes, m, and what stands there, for people: a room is gone to at its place, not at the spot."""

    @property
    def request(self) -> str:
        """What is said to go there."""
        return asked_to_go(self.name, named=self.named)


def asked_to_go(name: str, *, named: bool = False) -> str:
    """What is said to go to a place, or to somebody of this name (``named``)."""
    name = told(name)
    if not name.isascii():
        return strings.GO_TO_HAN.format(name)
    return (strings.GO_TO_NAMED if named else strings.GO_TO).format(name)


def targets(
    places: Mapping[str, Place], things: Sequence[Thing], people: Sequence[PersonSeen], now: float
) -> tuple[Target, ...]:
    """All that has a place of its own: the places of the map, then the things and the people, the newest first;
    ``now`` is robot time, s."""
    return (
        *(
            Target(place.position.x, place.position.y, printable(f"{symbol} {told(place.name)}"), place.name)
            for symbol, place in places.items()
        ),
        *(
            Target(
                *thing.position[:2],
                f"{told(thing.name)}, {strings.SEEN_AGO.format(ago(now - thing.seen_at))}",
                thing.name,
            )
            for thing in things
        ),
        *(
            Target(
                *person.position[:2],
                f"{printable(told(_named(person)))}, {strings.SEEN_AGO.format(ago(now - person.seen_at))}",
                _named(person),
                person.name is not None,
            )
            for person in people
        ),
    )


def pointed_at(
    x: float, y: float, reach: float, known: Sequence[Target], floor: FloorMap, places: Mapping[str, Place]
) -> Target:
    """What is meant by a spot: the nearest target within ``reach`` m; else the furniture or the room there, to which
    one can be sent if there is a place of that name."""
    near = min(known, key=lambda target: math.hypot(target.x - x, target.y - y), default=None)
    if near is not None and math.hypot(near.x - x, near.y - y) <= reach:
        return near
    by_name = {place.name: (symbol, place) for symbol, place in places.items()}
    areas: tuple[Furniture | Room, ...] = (*floor.furniture, *floor.rooms)
    for area in areas:
        if area.x_min <= x <= area.x_max and area.y_min <= y <= area.y_max:
            about = f"{printable(told(area.name))} ({x:.1f}, {y:.1f})"
            if area.name not in by_name:
                return Target(x, y, about)
            symbol, place = by_name[area.name]
            there = place.position.x, place.position.y, printable(f"{symbol} {told(place.name)}")
            return Target(x, y, about, area.name, goal=there)
    return Target(x, y, f"({x:.1f}, {y:.1f})")


def ago(seconds: float) -> str:
    """How long ago that is, as people say it: now, 40 s, 2 min, 3 h."""
    if not math.isfinite(seconds) or seconds < 5:
        return strings.JUST_NOW
    if seconds < 60:
        return strings.SECONDS_AGO.format(int(seconds / 5) * 5)
    if seconds < 3600:
        return strings.MINUTES_AGO.format(int(seconds / 60))
    return strings.HOURS_AGO.format(int(seconds / 3600))


def _named(person: PersonSeen) -> str:
    return person.name or "person"
