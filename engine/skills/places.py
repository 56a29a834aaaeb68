"""The places the robot knows: those of the map, and ``zero``, the pose it was told to remember."""

from __future__ import annotations

from collections.abc import Mapping

from config.schema import Place
from engine.errors import PlanError
from engine.robot.robot import Pose

ZERO_SYMBOL = "zero"


class UnknownPlace(PlanError):
    """A place that is not on the map; the message names those that are."""

    code = "unknown_place"


class Places:
    """Looks places up by symbol, name or alias, and remembers one pose."""

    def __init__(self, places: Mapping[str, Place]) -> None:
        self._places = dict(places)
        self._zero: Pose | None = None
        self._words = {
            word.casefold(): symbol
            for symbol, place in places.items()
            for word in (symbol, place.name, *place.aliases)
        }  # fmt: skip

    def remember(self, pose: Pose) -> None:
        """Make ``pose`` the place ``zero``."""
        self._zero = pose

    def symbol(self, word: str) -> str:
        """Symbol of the place that people call ``word``. Raises :class:`UnknownPlace`."""
        key = word.casefold().strip().removeprefix("the ").strip()
        if key == ZERO_SYMBOL:
            return ZERO_SYMBOL
        if key in self._words:
            return self._words[key]
        raise UnknownPlace(f"I don't know a place called {word!r}.", hint=f"I know: {', '.join(self.names())}.")

    def pose(self, symbol: str) -> Pose | None:
        """Where to stand for this place; None for ``zero`` while nothing is remembered."""
        if symbol == ZERO_SYMBOL:
            return self._zero
        place = self._places[symbol]
        return Pose(place.position.x, place.position.y, place.orientation.yaw)

    def name(self, symbol: str) -> str:
        """What people call it."""
        return "the remembered place" if symbol == ZERO_SYMBOL else f"the {self._places[symbol].name}"

    def names(self) -> tuple[str, ...]:
        """All names, in the order of the map."""
        return tuple(place.name for place in self._places.values())
