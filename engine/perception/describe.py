"""A picture in words: what people and planners are told about what the robot sees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.perception.people import PersonSeen
from engine.perception.sighting import Sight, Sighting
from engine.robot.floor_map import FloorMap

MOST: Final = 8
"""Things that are told one by one; the rest are counted."""

_AHEAD: Final = math.radians(12)
_BEHIND: Final = math.radians(110)
_ON: Final = 0.08  # m beyond the edge of a piece of furniture at which a thing is still said to be on it
_COUNTS: Final = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
_PLURALS: Final = {"box": "boxes", "person": "people"}


def describe(sight: Sight, floor_map: FloorMap) -> str:
    """One or two sentences, people and the nearest things first: ``I see a red box 0.6 m ahead on the coffee table, a
    blue cup to the left on the floor, and block 3 to the right on the floor.``"""
    if not sight.objects:
        return "I see nothing but the room."
    order = sorted(sight.objects, key=lambda thing: (thing.kind != "person", thing.range))
    groups: dict[tuple[str, str, str], list[Sighting]] = {}
    for thing in order[:MOST]:
        name = thing.name if thing.tag is None else f"tag block {thing.tag}"
        groups.setdefault((name, _side(sight, thing), _place(thing, floor_map)), []).append(thing)
    phrases = [_phrase(sight, *key, things) for key, things in groups.items()]
    text = f"I see {_enumerated(phrases)}."
    if len(order) > MOST:
        rest = len(order) - MOST
        text += f" There {'is' if rest == 1 else 'are'} {_count(rest)} more."
    return text


def in_words(person: PersonSeen) -> str:
    """Who it is and what they do: ``Anna is sitting``, ``A person in a red shirt and blue trousers is waving``."""
    worn = " and ".join(
        filter(None, (person.shirt and f"a {person.shirt} shirt", person.trousers and f"{person.trousers} trousers"))
    )
    who = person.name or (f"A person in {worn.replace('a orange', 'an orange')}" if worn else "A person")
    return " ".join((who, "is", " and ".join(filter(None, (person.posture, person.gesture))))).rstrip()


def _phrase(sight: Sight, name: str, side: str, place: str, things: Sequence[Sighting]) -> str:
    first = things[0]
    if len(things) > 1:
        head, _, kind = name.rpartition(" ")
        what = f"{_count(len(things))} {head} {_PLURALS.get(kind, kind + 's')}".replace("  ", " ")
    elif first.tag is not None:
        what = name
    else:
        what = f"{'an' if name[0] in 'aeiou' else 'a'} {name}"
    return f"{what} {_away(sight, first):.1f} m {side} {place}".rstrip()


def _away(sight: Sight, thing: Sighting) -> float:
    """From the middle of the robot, along the floor, m."""
    pose = sight.picture.pose
    return math.hypot(thing.position[0] - pose.x, thing.position[1] - pose.y)


def _side(sight: Sight, thing: Sighting) -> str:
    x, y, _ = sight.picture.from_map(_row(thing))[0].tolist()
    bearing = math.atan2(y, x)
    if abs(bearing) < _AHEAD:
        return "ahead"
    if abs(bearing) > _BEHIND:
        return "behind me"
    return "to the left" if bearing > 0 else "to the right"


def _place(thing: Sighting, floor_map: FloorMap) -> str:
    if thing.kind == "person":
        return ""
    if thing.surface < 0.02:
        return "on the floor"
    x, y, _ = thing.position
    tops = [
        furniture
        for furniture in floor_map.furniture
        if furniture.holds(x, y, margin=-_ON) and (furniture.height == 0 or thing.surface < furniture.height + 0.05)
    ]
    if tops:
        best = min(tops, key=lambda furniture: abs(furniture.height - thing.surface))
        return f"{'in' if best.kind == 'bin' else 'on'} the {best.name}"
    return f"{100 * thing.surface:.0f} cm above the floor"


def _row(thing: Sighting) -> NDArray[np.float64]:
    return np.array([thing.position])


def _count(number: int) -> str:
    return _COUNTS[number] if number < len(_COUNTS) else str(number)


def _enumerated(phrases: Sequence[str]) -> str:
    if len(phrases) <= 2:
        return " and ".join(phrases)
    return f"{', '.join(phrases[:-1])}, and {phrases[-1]}"
