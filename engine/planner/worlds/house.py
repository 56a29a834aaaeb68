"""The words of the configured house: names from its map and its inventory, never where loose things are."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

from config.schema import Robot as RobotSettings
from config.schema import Settings
from engine.perception.naming import UnknownObject, Wanted, wanted
from engine.robot.home import Thing, home
from engine.skills.people import People
from engine.skills.places import Places
from engine.skills.vocabulary import House, Vocabulary


def build_vocabulary(settings: Settings, places: Places | None = None, people: People | None = None) -> Vocabulary:
    """The words of the configured house. Raises ``SceneError``."""
    return Vocabulary(places or Places(settings.places), _house(settings.robot), people or People(settings.people))


@lru_cache(maxsize=8)
def _house(robot: RobotSettings) -> House:
    """What map and inventory of its house tell."""
    lived_in = home(robot)
    mapped = lived_in.floor_map
    things = {thing.name: _looks(thing, lived_in.things) for thing in lived_in.things}
    named = {name: looks for name, looks in things.items() if looks}
    categories = {thing.name: thing.category for thing in lived_in.things if thing.category and thing.name in named}
    return House(mapped.furniture, mapped.rooms, named, categories, lived_in.called)


def _looks(thing: Thing, others: Sequence[Thing]) -> str:
    """What a thing of this name looks like, in words of perception; empty where there are none for it. Where that name
    is a kind or a colour ("cup", "orange") that others here have as well, it is the one that looks so."""
    by_name, by_looks = _wanted(thing.name), _wanted(thing.looks.replace("tag_", ""))
    if by_name is None or by_looks is None:
        return str(by_name or by_looks or "")
    alike = (_wanted(other.looks.replace("tag_", "")) for other in others if other is not thing)
    is_one_of_several = any(other is not None and by_name.covers(other) for other in alike)
    return str(by_looks if is_one_of_several and by_name.covers(by_looks) else by_name)


def _wanted(words: str) -> Wanted | None:
    try:
        return wanted(words)
    except UnknownObject:
        return None
