"""Another world to plan in: its places, objects and people replace the words of the scene, for planning only.

Plans for such a world name things exactly as its file writes them; :mod:`engine.planner.worlds.world_file` reads it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from config.schema import Place
from engine.perception.naming import UnknownObject
from engine.planner.worlds.names import Named, Names
from engine.skills.places import ZERO_SYMBOL, Places, UnknownPlace, known_names
from engine.skills.vocabulary import FLOOR, Vocabulary


@dataclass(frozen=True, slots=True)
class World:
    """Places, objects and people by name."""

    places: Mapping[str, Place]
    """By the names of the file, people included. Positions are made up: nobody drives here."""
    rooms: tuple[Named, ...]
    spots: tuple[Named, ...]
    objects: tuple[Named, ...]
    people: tuple[Named, ...]
    homes: Mapping[str, str]
    """Where objects usually are, where the file tells."""

    def vocabulary(self, places: Places | None = None) -> WorldVocabulary:
        """The words of this world."""
        return WorldVocabulary(self, places or Places(self.places))


class WorldVocabulary(Vocabulary):
    """Resolves the words of a world to the names of its file. Things can be put at every place."""

    def __init__(self, world: World, places: Places) -> None:
        super().__init__(places)
        known = [one.name for one in (*world.spots, *world.people)] or ["nothing"]
        things = [one.name for one in world.objects] or ["nothing"]

        def no_place(words: str) -> UnknownPlace:
            return UnknownPlace(f"I don't know a place called {words!r}.", hint=known_names(words, known))

        def no_object(words: str) -> UnknownObject:
            return UnknownObject(f"There is no {words!r} here.", hint=known_names(words, things))

        self._where = Names((*world.spots, *world.people), no_place)
        self._rooms_by_name = Names(world.rooms, no_place)
        self._objects = Names(world.objects, no_object)

    def resolvers(self) -> Mapping[str, Callable[[str], str]]:
        """For each kind of word, what resolves it."""
        return {**super().resolvers(), "place": self.place, "places": self._several}

    def place(self, words: str) -> str:
        """Where one can go: a place, a person, or ``zero``, which is where the speaker is, if the world says where.
        Raises :class:`UnknownPlace` or ``Ambiguous``."""
        if words.casefold().strip() != ZERO_SYMBOL:
            return self._where.key(words)
        return next(iter(self._where.keys("me")), ZERO_SYMBOL)

    def object(self, words: str) -> str:
        """A thing, by its name in the file. Raises :class:`UnknownObject` or ``Ambiguous``."""
        return self._objects.key(words)

    def meanings(self, words: str) -> frozenset[str]:
        """All things that the words fit."""
        return frozenset(self._objects.keys(words))

    def fitting(self, words: str) -> tuple[str, ...]:
        """Every thing that the words fit."""
        return self._objects.keys(words)

    def surface(self, word: str) -> str:
        """Where things are put: any place, a person, the floor, or the bin, if there is one."""
        if word.casefold().removeprefix("the ") in (FLOOR, "ground"):
            return FLOOR
        return self._where.key(word)

    def room(self, word: str) -> str:
        """A place that one can look around in. Raises :class:`UnknownPlace`."""
        return self._rooms_by_name.key(word)

    def surfaces(self) -> tuple[str, ...]:
        """Every word for where things are put."""
        return (FLOOR, "ground", *self._words(self._where))

    def rooms(self) -> tuple[str, ...]:
        """Every word for a room."""
        return self._words(self._rooms_by_name)

    def things(self) -> tuple[str, ...]:
        """Every word for a thing, and the categories."""
        return (*self._words(self._objects), *(category.casefold() for category in self._objects.categories))

    def places(self) -> tuple[str, ...]:
        """Every word for a place or a person."""
        return self._words(self._where)

    def inventory(self) -> tuple[str, ...]:
        """What the loose things of this world are called."""
        return tuple(one.name for one in self._objects.named)

    def furniture(self) -> tuple[str, ...]:
        """What things can be put on or in: every place."""
        return tuple(one.name for one in self._where.named)

    def words_for(self, name: str) -> tuple[str, ...]:
        """Every word for a place or a person, the name first."""
        keys = self._where.keys(name)
        said = (word for one in self._where.named if one.key in keys for word in one.said())
        return tuple(dict.fromkeys((name, *said)))

    def names(self) -> tuple[str, ...]:
        """All names of places, people and things."""
        return tuple(one.name.casefold() for one in (*self._where.named, *self._objects.named))

    def thing_words(self) -> tuple[str, ...]:
        """The words that the names of things are made of."""
        return tuple(dict.fromkeys(word for name in self.things() for word in name.split() if word.isalpha()))

    def _several(self, words: str) -> str:
        return ",".join(self.place(word) for word in words.replace(" and ", ",").split(",") if word.strip())

    @staticmethod
    def _words(names: Names) -> tuple[str, ...]:
        return tuple(dict.fromkeys(word.casefold() for one in names.named for word in one.said()))
