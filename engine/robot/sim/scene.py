"""A scene: a dwelling as a whole, in which everything that is named exists and stands where it can.

Rooms are rectangles; walls stand on their edges, with doors as gaps between two rooms. Furniture and loose objects
are placed by name, and an object may stand on a piece of furniture or on another object. Its parts are in
:mod:`engine.robot.sim.scene_parts`; a fault is told with the key that it is in.

The robot knows the house as it was mapped. A scene may differ from that: furniture that was ``moved`` or is not
``mapped``, a door that is ``closed``, people who walk about.
"""

from __future__ import annotations

import math
import string
from typing import Any, Self, get_args

from pydantic import Field, model_validator

from config.nearest import nearest
from config.schema import KnownPerson, PersonColour, Place, Position, Quaternion
from engine.robot.sim.scene_parts import (
    Area,
    Door,
    FloorLine,
    FurniturePiece,
    KeepOut,
    LandmarkTag,
    LooseObject,
    Part,
    Person,
    Poster,
    RoomArea,
    ScenePlace,
    Start,
    Walls,
)


class Scene(Part):
    """A whole scene. ``bounds`` is the workspace of the robot."""

    name: str
    bounds: Area
    start: Start
    walls: Walls = Walls()
    rooms: dict[str, RoomArea] = Field(min_length=1)
    doors: tuple[Door, ...] = ()
    furniture: dict[str, FurniturePiece] = Field(default_factory=dict)
    objects: dict[str, LooseObject] = Field(default_factory=dict)
    lines: dict[str, FloorLine] = Field(default_factory=dict)
    keep_out: tuple[KeepOut, ...] = ()
    landmarks: tuple[LandmarkTag, ...] = ()
    posters: tuple[Poster, ...] = ()
    people: dict[str, Person] = Field(default_factory=dict)
    places: dict[str, ScenePlace] = Field(default_factory=dict, max_length=len(string.ascii_uppercase))

    def standing_height(self, loose: LooseObject) -> float:
        """Of the bottom of an object above the floor, m."""
        if loose.stands_on is None:
            return 0.0
        if loose.stands_on in self.furniture:
            return self.furniture[loose.stands_on].size[2]
        below = self.objects[loose.stands_on]
        return self.standing_height(below) + below.tall

    def known_places(self) -> dict[str, Place]:
        """Its places with the symbols A, B, C…, as the configuration has them."""
        found = {}
        for symbol, (name, place) in zip(string.ascii_uppercase, self.places.items(), strict=False):
            half = math.radians(place.yaw) / 2
            found[symbol] = Place(
                name=name,
                aliases=place.aliases,
                position=Position(x=place.at[0], y=place.at[1]),
                orientation=Quaternion(z=math.sin(half), w=math.cos(half)),
            )
        return found

    def known_people(self) -> dict[str, KnownPerson]:
        """Those whom the robot knows, by name, as the configuration has them; what they wear has the colours' names
        that perception has."""
        told = get_args(PersonColour)
        return {
            person.called or name: KnownPerson(
                shirt=person.shirt if person.shirt in told else None,  # type: ignore[arg-type]
                trousers=person.trousers if person.trousers in told else None,  # type: ignore[arg-type]
                gender=person.gender,
                aliases=person.aliases,
            )
            for name, person in self.people.items()
            if person.known
        }

    def edges(self) -> list[tuple[float, float, float, float]]:
        """Rectangles whose outlines the robot must not cross, x and y of two corners, m: bounds and keep-out zones."""
        areas: tuple[Area | KeepOut, ...] = (self.bounds, *self.keep_out)
        return [(area.x[0], area.y[0], area.x[1], area.y[1]) for area in areas]

    @model_validator(mode="after")
    def _names_exist_and_things_are_inside(self) -> Self:
        for index, door in enumerate(self.doors):
            for room in door.between:
                _must_know(room, self.rooms, f"doors.{index}.between", "room")
        for name, loose in self.objects.items():
            self._must_stand(name, loose)
        placed = [(f"furniture.{n}", f.stands) for n, f in self.furniture.items()]
        placed += [(f"objects.{n}", o.at) for n, o in self.objects.items()]
        placed += [(f"landmarks.{i}", mark.at) for i, mark in enumerate(self.landmarks)]
        placed += [(f"posters.{i}", poster.at) for i, poster in enumerate(self.posters)]
        placed += [(f"people.{n}.path", point) for n, person in self.people.items() for point in person.path]
        placed += [(f"people.{n}.leads", point) for n, person in self.people.items() for point in person.leads]
        for name, person in self.people.items():
            if person.holds is not None:
                _must_know(person.holds, self.objects, f"people.{name}.holds", "object")
        _must_differ([person.holds for person in self.people.values() if person.holds is not None], "people.holds")
        placed += [(f"places.{n}", place.at) for n, place in self.places.items()]
        placed.append(("start", (self.start.x, self.start.y)))
        for key, (x, y) in placed:
            if not self.bounds.contains(x, y):
                raise ValueError(f"{key}: ({x:g}, {y:g}) is outside the bounds")
        _must_differ([str(mark.id) for mark in self.landmarks], "landmarks")
        _must_differ([word.casefold() for n, p in self.places.items() for word in (n, *p.aliases)], "places")
        _must_differ([name for kind in (self.furniture, self.objects, self.people) for name in kind], "things")
        for zone in self.keep_out:
            if zone.contains(self.start.x, self.start.y):
                raise ValueError(f"start: lies inside the keep-out zone {zone.name}")
        return self

    def _must_stand(self, name: str, loose: LooseObject) -> None:
        """What an object stands on exists, and is where the object is."""
        if loose.stands_on is None:
            return
        key = f"objects.{name}.stands_on"
        below: str | None = loose.stands_on
        seen = {name}
        while below in self.objects:
            if below in seen:
                raise ValueError(f"{key}: the {name} would stand on itself")
            seen.add(below)
            below = self.objects[below].stands_on
        _must_know(loose.stands_on, {**self.furniture, **self.objects}, key, "piece of furniture or object")
        if loose.stands_on in self.objects:
            (x, y), half = self.objects[loose.stands_on].at, self.objects[loose.stands_on].size / 2
            x0, y0, x1, y1 = x - half, y - half, x + half, y + half
        else:
            x0, y0, x1, y1 = self.furniture[loose.stands_on].area
        if not (x0 <= loose.at[0] <= x1 and y0 <= loose.at[1] <= y1):
            raise ValueError(f"objects.{name}: at {loose.at} is not on the {loose.stands_on}")


def _must_differ(words: list[str], key: str) -> None:
    for index, word in enumerate(words):
        if word in words[:index]:
            raise ValueError(f"{key}: {word!r} is there twice")


def _must_know(name: str, known: dict[str, Any], key: str, what: str) -> None:
    if name not in known:
        near = nearest(name, known)
        ask = f"; did you mean {near}?" if near else f"; there are {', '.join(known) or 'none'}"
        raise ValueError(f"{key}: no {what} is called {name!r}{ask}")
