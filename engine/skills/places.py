"""The places the robot knows: those of the map, and ``zero``: where it started, until it is told to
remember another pose."""

from __future__ import annotations

import itertools
import math
import re
import string
from collections.abc import Callable, Container, Mapping, Sequence

from config.nearest import did_you_mean
from config.schema import Place, Position, Quaternion
from engine.errors import PlanError
from engine.han import SIMPLER
from engine.robot.geometry import Pose
from engine.skills.synonyms import synonyms

ZERO_SYMBOL = "zero"
_SEPARATOR = re.compile(r"(\s*[,，、]\s*(?:and\s+)?|\s+and\s+|\s*和\s*)", re.IGNORECASE)


def free_symbol(taken: Container[str]) -> str:
    """The next letter that no place has for its symbol, or the next number with a P before it."""
    letters = (letter for letter in string.ascii_uppercase if letter not in taken)
    return next(letters, "") or next(f"P{n}" for n in itertools.count(1) if f"P{n}" not in taken)


def place_at(name: str, pose: Pose) -> Place:
    """A place of this name."""
    half = pose.yaw / 2
    return Place(
        name=name,
        position=Position(x=round(pose.x, 3), y=round(pose.y, 3)),
        orientation=Quaternion(z=round(math.sin(half), 4), w=round(math.cos(half), 4)),
    )


class UnknownPlace(PlanError):
    """A place that is not on the map; the message names those that are."""

    code = "unknown_place"


def known_names(word: str, names: Sequence[str]) -> str:
    """What to say to somebody whose ``word`` is none of the ``names``: the nearest of them, and which there are."""
    return " ".join(filter(None, (did_you_mean(word, names), f"I know: {', '.join(names)}.")))


class Places:
    """Looks places up by symbol, name or alias, and remembers one pose."""

    def __init__(self, places: Mapping[str, Place]) -> None:
        self._places = dict(places)
        self._zero: Pose | None = None
        self._is_start = True
        self.on_added: Callable[[str, Place], object] = lambda symbol, place: None
        self._words = {
            word.casefold().translate(SIMPLER): symbol
            for symbol, place in places.items()
            for word in (symbol, place.name, *place.aliases)
        }  # fmt: skip
        self._others = synonyms(self._words)
        """Words that mean a place where nothing else is called so."""

    def add(self, name: str, place: Place) -> str:
        """Have a place of this name, or move the one that has it; gives its symbol. ``on_added`` is told."""
        symbol = self._words.get(self._key(name)) or free_symbol(self._places)
        old = self._places.get(symbol)
        if old is not None:
            place = old.model_copy(update={"position": place.position, "orientation": place.orientation})
        self._places[symbol] = place
        self._words |= {word.casefold().translate(SIMPLER): symbol for word in (symbol, place.name, *place.aliases)}
        self._others = synonyms(self._words)
        self.on_added(symbol, place)
        return symbol

    def begin(self, pose: Pose) -> None:
        """The robot starts at ``pose``: this is ``zero`` until it is told to remember another one."""
        self._zero = pose

    def remember(self, pose: Pose) -> None:
        """Make ``pose`` the place ``zero``, as somebody asked for."""
        self._zero, self._is_start = pose, False

    @property
    def zero_is_start(self) -> bool:
        """Whether ``zero`` is where the robot started, and nobody has asked to remember another pose."""
        return self._is_start

    def symbol(self, word: str) -> str:
        """Symbol of the place that people call ``word``. Raises :class:`UnknownPlace`."""
        key = self._key(word)
        if key == ZERO_SYMBOL:
            return ZERO_SYMBOL
        if (symbol := self._words.get(key) or self._others.get(key)) is not None:
            return symbol
        raise UnknownPlace(f"I don't know a place called {word!r}.", hint=known_names(word, self.names()))

    def symbols(self, words: str) -> tuple[str, ...]:
        """Symbols of the places in a list, separated by commas or "and" (which may also be within a name). Raises
        :class:`UnknownPlace`."""
        pieces = [piece for piece in _SEPARATOR.split(words.strip(" ,")) if piece.strip()]
        found: list[str] = []
        while pieces:
            for length in range(len(pieces), 0, -2):  # every other piece is a separator
                name = "".join(pieces[:length])
                if length == 1 or self._key(name) in self._words:
                    found.append(self.symbol(name))
                    del pieces[: length + 1]
                    break
        return tuple(found)

    def known(self) -> tuple[str, ...]:
        """Symbols of all places that the robot can be sent to now, in the order of the map."""
        return (*self._places, *([ZERO_SYMBOL] if self._zero is not None else []))

    def words(self, symbol: str) -> tuple[str, ...]:
        """The name of a place of the map and its other names."""
        place = self._places[symbol]
        return (place.name, *place.aliases)

    def pose(self, symbol: str) -> Pose | None:
        """Where to stand for this place; None for ``zero`` while nothing is remembered."""
        if symbol == ZERO_SYMBOL:
            return self._zero
        place = self._places[symbol]
        return Pose(place.position.x, place.position.y, place.orientation.yaw)

    def pose_of(self, name: str) -> Pose | None:
        """Where to stand for the place of this name; None where there is none."""
        symbol = self._words.get(self._key(name))
        return self.pose(symbol) if symbol is not None else None

    def name(self, symbol: str) -> str:
        """What people call it."""
        if symbol == ZERO_SYMBOL:
            return "my starting point" if self._is_start else "the remembered place"
        return f"the {self._places[symbol].name}"

    @staticmethod
    def _key(word: str) -> str:
        return word.casefold().translate(SIMPLER).strip().removeprefix("the ").strip()

    def names(self) -> tuple[str, ...]:
        """All names, in the order of the map."""
        return tuple(place.name for place in self._places.values())
