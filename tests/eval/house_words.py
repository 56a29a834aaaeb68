"""What the words of an entry stand for: in a simulated house, in a world from a file, or names that nobody resolves."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property
from typing import Any

from config.schema import Settings
from engine.errors import PlanError
from engine.perception.naming import wanted
from engine.planner.worlds.house import build_vocabulary
from engine.planner.worlds.names import spoken
from engine.planner.worlds.world import World
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_file import load_scene, scene_path
from engine.skills.places import Places
from engine.skills.vocabulary import Vocabulary
from tests.eval.effects import BIN, ZERO

_KINDS = {"tag_block": "block"}


class SceneWords:
    """The words of a simulated house, with the truth about where its things are at the start."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._scene: Scene = load_scene(scene_path(settings.robot.scene))
        self._vocabulary: Vocabulary = build_vocabulary(settings)
        self._places = Places(settings.places)

    def place(self, word: str) -> str:
        """The name of a piece of furniture, a room or a place, in lower case."""
        name = _tried(self._called, word)
        return _tried(self._vocabulary.surface, name).casefold()

    def room(self, place: str) -> str:
        """The room around a piece of furniture or a place; empty for rooms."""
        if place in self._scene.rooms:
            return ""
        if (piece := self._scene.furniture.get(place)) is not None:
            return self._room_at(*piece.at)
        spots = (spot.position for spot in self._settings.places.values() if spot.name == place)
        return next((self._room_at(spot.x, spot.y) for spot in spots), "")

    def things(self, word: str) -> frozenset[str]:
        """The things of the scene that look so; the word itself where none does."""
        plain = word.casefold().strip()
        if plain in self._scene.objects:
            return frozenset({plain})
        try:
            meant = wanted(word)
        except PlanError:
            return frozenset({plain})
        fitting = frozenset(name for name, looks in self._looks.items() if meant.fits(*looks))
        return fitting or frozenset({str(meant)})

    def homes(self, thing: str) -> frozenset[str]:
        """What it stands on, and the room."""
        loose = self._scene.objects.get(thing)
        return frozenset(filter(None, (loose.stands_on, self._room_at(*loose.at)))) if loose else frozenset()

    def is_surface(self, place: str) -> bool:
        """Furniture: things on the floor beside it are not on it."""
        return place == BIN or place in self._scene.furniture

    def inventory(self) -> tuple[str, ...]:
        """The names of all things."""
        return tuple(self._scene.objects)

    @cached_property
    def _looks(self) -> dict[str, tuple[Any, Any, int | None]]:
        loose = self._scene.objects.items()
        return {name: (_KINDS.get(thing.kind, thing.kind), thing.colour, thing.tag) for name, thing in loose}

    def _called(self, word: str) -> str:
        symbol = self._places.symbol(word)
        return ZERO if symbol == ZERO else self._places.words(symbol)[0]

    def _room_at(self, x: float, y: float) -> str:
        inside = (
            n for n, room in self._scene.rooms.items() if room.x[0] <= x <= room.x[1] and room.y[0] <= y <= room.y[1]
        )
        return next(inside, "")


class WorldWords:
    """The words of a world: the names of its file."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._vocabulary = world.vocabulary()

    def place(self, word: str) -> str:
        """Its name in the file; the bin of this world is the bin."""
        return _tried(self._vocabulary.place, word)

    def room(self, place: str) -> str:
        """Nobody knows."""
        del place
        return ""

    def things(self, word: str) -> frozenset[str]:
        """Every thing that the word fits; the word itself where none does."""
        return self._vocabulary.meanings(word) or frozenset({word.casefold()})

    def homes(self, thing: str) -> frozenset[str]:
        """Where the file says that it is."""
        home = self._world.homes.get(thing, "")
        return frozenset({self.place(home)} if home else ())

    def is_surface(self, place: str) -> bool:
        """On it, in it or beside it is the same in a world of words."""
        del place
        return False

    def inventory(self) -> tuple[str, ...]:
        """The names of all things."""
        return self._vocabulary.inventory()


class PlainWords:
    """Names as they stand, in lower case; ``called`` has others for them."""

    def __init__(self, called: dict[str, str] | None = None) -> None:
        self._called = called or {}

    def place(self, word: str) -> str:
        """The name without underscores."""
        plain = spoken(word).casefold()
        return self._called.get(plain, plain)

    def room(self, place: str) -> str:
        """Nobody knows."""
        del place
        return ""

    def things(self, word: str) -> frozenset[str]:
        """The name itself."""
        return frozenset({self.place(word)})

    def homes(self, thing: str) -> frozenset[str]:
        """Nobody knows."""
        del thing
        return frozenset()

    def is_surface(self, place: str) -> bool:
        """On it or beside it is the same."""
        del place
        return False

    def inventory(self) -> Iterable[str]:
        """None are known."""
        return ()


def _tried(resolve: Callable[[str], str], word: str) -> str:
    try:
        return resolve(word)
    except PlanError:
        return word
