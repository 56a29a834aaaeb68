"""Understanding a picture: everything that is found in it, in one pass."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Final

import cv2

from engine.perception.person import find_people
from engine.perception.sighting import EVERYTHING, Part, Sight, Sighting
from engine.perception.tags import find_tags
from engine.perception.things import find_things
from engine.robot.camera import Picture
from engine.robot.floor_map import FloorMap

cv2.setNumThreads(1)  # more threads cost more than they bring at this size, and take the recogniser's cores


_OF_A_PERSON: Final = 0.3
"""m around a person within which what looks like a thing may be a shoe or a hand."""


def perceive(picture: Picture, floor_map: FloorMap, parts: Collection[Part] = EVERYTHING) -> Sight:
    """Find people, loose things and tags, or only those ``parts``: without people their shoes may pass for
    things, and without tags blocks have no numbers. ``floor_map`` says what is fixed."""
    tags = find_tags(picture, floor_map.tags) if "tags" in parts else ()
    people = find_people(picture, floor_map) if "people" in parts else ()
    loose = find_things(picture, floor_map, tags) if "things" in parts else ()
    things = [thing for thing in loose if not _part_of(thing, people)]
    return Sight(picture, tuple(sorted((*people, *things), key=lambda thing: thing.range)), tags)


def _part_of(thing: Sighting, people: Sequence[Sighting]) -> bool:
    return any(
        math.dist(thing.position[:2], person.position[:2]) < _OF_A_PERSON
        and person.box[0] - 2 <= (thing.box[0] + thing.box[2]) / 2 <= person.box[2] + 2
        for person in people
    )
