"""The words of the configured house: names from its map and its inventory, never where loose things are."""

from __future__ import annotations

from functools import lru_cache

from config.schema import Settings
from engine.perception.naming import UnknownObject, wanted
from engine.skills.places import Places
from engine.skills.vocabulary import House, Vocabulary


def build_vocabulary(settings: Settings, places: Places | None = None) -> Vocabulary:
    """The words of the configured house. Raises ``SceneError``."""
    return Vocabulary(places or Places(settings.places), _house(settings.robot.scene))


@lru_cache(maxsize=8)
def _house(scene: str) -> House:
    """What map and inventory of a simulated house tell."""
    from engine.robot.sim.floor import floor_map
    from engine.robot.sim.scene_file import load_scene, scene_path

    loaded = load_scene(scene_path(scene))
    mapped = floor_map(loaded)
    things = {name: _looks(name, f"{thing.colour} {thing.kind}") for name, thing in loaded.objects.items()}
    named = [(name, room.aliases) for name, room in loaded.rooms.items()]
    named += [(name, piece.aliases) for name, piece in loaded.furniture.items()]
    called = {word: name for name, words in named for word in words}
    return House(mapped.furniture, mapped.rooms, {name: looks for name, looks in things.items() if looks}, called)


def _looks(name: str, otherwise: str) -> str:
    """What a thing of this name looks like, in words of perception; empty where there are none for it."""
    for words in (name, otherwise.replace("tag_", "")):
        try:
            return str(wanted(words))
        except UnknownObject:
            continue
    return ""
