"""The words of one house: what people call its things, its furniture, its rooms and its places.

Words for things come from perception (what has a shape or a colour that is known) and from the names that the things of
this house have; all others from its map. Each kind of word (``engine.skills.registry.Word``) is resolved here to the
word that skills use, or to an error that names what is known.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final, get_args

from engine.errors import ExitCode, PlanError
from engine.perception.naming import UnknownObject, wanted
from engine.perception.sighting import Colour
from engine.robot.robot import Furniture, Room
from engine.skills.places import ZERO_SYMBOL, Places, UnknownPlace

BIN: Final = "bin"
FLOOR: Final = "floor"
BARE: Final = frozenset({"plant", "dock", "wardrobe"})
"""Kinds of furniture that nothing is put on."""

_ARTICLES: Final = frozenset({"the", "a", "an", "my", "your", "our", "this", "that"})
_CALLED: Final = {"ground": FLOOR, "gray": "grey"}


class Ambiguous(PlanError):
    """A word that means several things."""

    code = "ambiguous"
    exit_code = ExitCode.CLARIFY


class UnknownColour(PlanError):
    """A colour that is not told apart from the others."""

    code = "unknown_colour"


@dataclass(frozen=True, slots=True)
class House:
    """What a robot knows of the house by name."""

    furniture: tuple[Furniture, ...] = ()
    rooms: tuple[Room, ...] = ()
    things: Mapping[str, str] = field(default_factory=dict)
    """Names that things have here, and what they look like: ``teddy`` is a ``brown box``."""


class Vocabulary:
    """Resolves the words of one house."""

    def __init__(self, places: Places, house: House | None = None) -> None:
        house = house or House()
        self._places = places
        self._things = {_plain(name): looks for name, looks in house.things.items()}
        self._rooms = {_plain(room.name): room for room in house.rooms}
        self._furniture = {_plain(piece.name): piece for piece in house.furniture if piece.kind not in BARE}

    def resolvers(self) -> Mapping[str, Callable[[str], str]]:
        """For each kind of word, what resolves it."""
        return {
            "place": self._places.symbol,
            "places": lambda words: ",".join(self._places.symbols(words)),
            "object": self.object,
            "surface": self.surface,
            "room": self.room,
            "thing_colour": self.colour,
        }

    def object(self, words: str) -> str:
        """What is looked for, as ``str(Wanted)``. Raises :class:`UnknownObject` with what is known."""
        plain = _plain(words)
        try:
            return str(wanted(plain))
        except UnknownObject as unknown:
            if plain in self._things:
                return str(wanted(self._things[plain]))
            if not (names := self.things()):
                raise
            raise UnknownObject(unknown.message, hint=f"{unknown.hint} And: {', '.join(names)}.") from None

    def colour(self, word: str) -> str:
        """A colour of things. Raises :class:`UnknownColour` with those that are told apart."""
        colour = _plain(word)
        if colour not in get_args(Colour):
            raise UnknownColour(f"I cannot tell what is {word!r}.", hint=f"I know: {', '.join(get_args(Colour))}.")
        return colour

    def room(self, word: str) -> str:
        """The name of a room, also by the name of the place in it. Raises :class:`UnknownPlace` with all rooms."""
        room = self._room(_plain(word))
        if room is None:
            known = ", ".join(room.name for room in self._rooms.values()) or "no rooms"
            raise UnknownPlace(f"I don't know a room called {word!r}.", hint=f"I know: {known}.")
        return room

    def surface(self, word: str) -> str:
        """Where things are put: the name of a piece of furniture, ``bin`` (the nearest), ``floor``, a room, or another
        place of the map. The last word of a name will do where it means one piece, and so will a name without its
        number. Raises :class:`Ambiguous`, or :class:`UnknownPlace` with all furniture."""
        plain = _plain(word)
        if plain in (BIN, FLOOR):
            return plain
        if plain in self._furniture:
            return self._furniture[plain].name
        if (place := self._place(plain)) is not None:
            piece = self._furniture.get(_plain(place))
            if piece is not None and piece.kind == BIN and sum(p.kind == BIN for p in self._furniture.values()) == 1:
                return BIN
            return piece.name if piece is not None else self._room(_plain(place)) or place
        if plain in self._rooms:
            return self._rooms[plain].name
        alike = [piece.name for name, piece in self._furniture.items() if f" {_unnumbered(name)}".endswith(f" {plain}")]
        if len(alike) == 1:
            return alike[0]
        if alike:
            raise Ambiguous(f"Which {plain}: {', '.join(alike[:-1])} or {alike[-1]}?")
        known = ", ".join((*(piece.name for piece in self._furniture.values()), FLOOR))
        raise UnknownPlace(f"I don't know where {word!r} is.", hint=f"I know: {known}.")

    def surfaces(self) -> tuple[str, ...]:
        """Every word for a surface, also those that mean several."""
        heads = (_unnumbered(name).rpartition(" ")[2] for name in self._furniture)
        called = (word for word in self._place_words() if self._is_furniture(word))
        return tuple(dict.fromkeys((FLOOR, "ground", BIN, *self._furniture, *called, *heads)))

    def rooms(self) -> tuple[str, ...]:
        """Every word for a room."""
        return tuple(dict.fromkeys((*self._rooms, *(word for word in self._place_words() if self._room(word)))))

    def things(self) -> tuple[str, ...]:
        """The names that things have here, beyond what perception calls them."""
        return tuple(name for name in self._things if not _is_seen(name))

    def names(self) -> tuple[str, ...]:
        """All names of furniture, rooms and things."""
        return (*self._furniture, *self._rooms, *self._things)

    def thing_words(self) -> tuple[str, ...]:
        """The kinds and the colours that the things of this house have in their names."""
        return tuple(dict.fromkeys(word for name in self._things for word in name.split() if word.isalpha()))

    def _place_words(self) -> tuple[str, ...]:
        symbols = (symbol for symbol in self._places.known() if symbol != ZERO_SYMBOL)
        return tuple(_plain(word) for symbol in symbols for word in self._places.words(symbol))

    def _place(self, plain: str) -> str | None:
        """The name of the place of the map that is called so; the remembered one is no surface."""
        try:
            symbol = self._places.symbol(plain)
        except UnknownPlace:
            return None
        return None if symbol == ZERO_SYMBOL else self._places.words(symbol)[0]

    def _is_furniture(self, plain: str) -> bool:
        place = self._place(plain)
        return place is not None and _plain(place) in self._furniture

    def _room(self, plain: str) -> str | None:
        """The room of this name, or that the place of this name is called after."""
        if plain not in self._rooms:
            plain = _plain(self._place(plain) or "")
        return self._rooms[plain].name if plain in self._rooms else None


def _is_seen(name: str) -> bool:
    """Whether perception knows by itself what is called so."""
    try:
        wanted(name)
    except UnknownObject:
        return False
    return True


def _unnumbered(name: str) -> str:
    """``tray`` of ``tray 2``."""
    return name.rstrip("0123456789 ") or name


def _plain(words: str) -> str:
    """In lower case, without the article, in the spelling that is used here."""
    parts = words.casefold().split()
    while len(parts) > 1 and parts[0] in _ARTICLES:
        del parts[0]
    return " ".join(_CALLED.get(part, part) for part in parts)
