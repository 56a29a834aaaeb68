"""The words of the configured house: names from its map and its inventory, never where loose things are."""

from __future__ import annotations

from functools import lru_cache

from config.schema import Robot as RobotSettings
from config.schema import Settings
from engine.perception.naming import UnknownObject, wanted
from engine.robot.home import home
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
    things = {thing.name: _looks(thing.name, thing.looks) for thing in lived_in.things}
    named = {name: looks for name, looks in things.items() if looks}
    categories = {thing.name: thing.category for thing in lived_in.things if thing.category and thing.name in named}
    return House(mapped.furniture, mapped.rooms, named, categories, lived_in.called)


def _looks(name: str, otherwise: str) -> str:
    """What a thing of this name looks like, in words of perception; empty where there are none for it."""
    for words in (name, otherwise.replace("tag_", "")):
        try:
            return str(wanted(words))
        except UnknownObject:
            continue
    return ""
