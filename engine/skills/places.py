"""The places the robot knows: those of the map, and ``zero``, the pose it was told to remember."""

from __future__ import annotations

import re
from collections.abc import Mapping

from config.schema import Place
from engine.errors import PlanError
from engine.han import SIMPLER
from engine.robot.geometry import Pose
from engine.skills.synonyms import synonyms

ZERO_SYMBOL = "zero"
_SEPARATOR = re.compile(r"(\s*[,，、]\s*(?:and\s+)?|\s+and\s+|\s*和\s*)", re.IGNORECASE)


class UnknownPlace(PlanError):
    """A place that is not on the map; the message names those that are."""

    code = "unknown_place"


class Places:
    """Looks places up by symbol, name or alias, and remembers one pose."""

    def __init__(self, places: Mapping[str, Place]) -> None:
        self._places = dict(places)
        self._zero: Pose | None = None
        self._words = {
            word.casefold().translate(SIMPLER): symbol
            for symbol, place in places.items()
            for word in (symbol, place.name, *place.aliases)
        }  # fmt: skip
        self._others = synonyms(self._words)
        """Words that mean a place where nothing else is called so."""

    def remember(self, pose: Pose) -> None:
        """Make ``pose`` the place ``zero``."""
        self._zero = pose

    def symbol(self, word: str) -> str:
        """Symbol of the place that people call ``word``. Raises :class:`UnknownPlace`."""
        key = self._key(word)
        if key == ZERO_SYMBOL:
            return ZERO_SYMBOL
        if (symbol := self._words.get(key) or self._others.get(key)) is not None:
            return symbol
        raise UnknownPlace(f"I don't know a place called {word!r}.", hint=f"I know: {', '.join(self.names())}.")

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

    def name(self, symbol: str) -> str:
        """What people call it."""
        return "the remembered place" if symbol == ZERO_SYMBOL else f"the {self._places[symbol].name}"

    @staticmethod
    def _key(word: str) -> str:
        return word.casefold().translate(SIMPLER).strip().removeprefix("the ").strip()

    def names(self) -> tuple[str, ...]:
        """All names, in the order of the map."""
        return tuple(place.name for place in self._places.values())
