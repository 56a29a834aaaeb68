"""Understanding a picture: everything that is found in it, in one pass."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Final

import cv2

from engine.perception.people import REACH
from engine.perception.person import find_people
from engine.perception.sighting import EVERYTHING, Part, Sight, Sighting, TagSighting
from engine.perception.tags import find_tags
from engine.perception.things import find_things
from engine.robot.camera import Picture
from engine.robot.company import Posture
from engine.robot.floor_map import FloorMap

cv2.setNumThreads(1)  # more threads cost more than they bring at this size, and take the recogniser's cores


_WORN: Final = 0.35  # m from the middle of somebody within which a tag is on their clothes


def perceive(picture: Picture, floor_map: FloorMap, parts: Collection[Part] = EVERYTHING) -> Sight:
    """Find people, loose things and tags, or only those ``parts``: without people their shoes may pass for
    things, and without tags blocks have no numbers. ``floor_map`` says what is fixed."""
    tags = find_tags(picture, floor_map.tags) if "tags" in parts else ()
    found = find_people(picture, floor_map) if "people" in parts else ()
    people = [_with_tag(person, tags, floor_map) for person in found]
    loose = find_things(picture, floor_map, tags) if "things" in parts else ()
    things = [thing for thing in loose if not _part_of(thing, people)]
    return Sight(picture, tuple(sorted((*people, *things), key=lambda thing: thing.range)), tags)


def _part_of(thing: Sighting, people: Sequence[Sighting]) -> bool:
    return any(
        math.dist(thing.position[:2], person.position[:2]) < REACH[_posture(person)]
        and person.box[0] - 2 <= (thing.box[0] + thing.box[2]) / 2 <= person.box[2] + 2
        for person in people
    )


def _posture(person: Sighting) -> Posture | None:
    return person.figure.posture if person.figure is not None else None


def _with_tag(person: Sighting, tags: Sequence[TagSighting], floor_map: FloorMap) -> Sighting:
    """The same with the tag that they wear, if they do."""
    left, top, right, bottom = person.box
    fixed = {mark.id for mark in floor_map.tags}
    for tag in tags:
        column, row = tag.corners.mean(axis=0)
        near = math.dist(tag.position[:2], person.position[:2]) < _WORN
        if near and left <= column < right and top <= row < bottom and tag.id not in fixed:
            return replace(person, tag=tag.id)
    return person
