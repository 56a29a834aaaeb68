"""The words of one house: what people call its things, its furniture, its rooms and its places.

Words for things come from perception (what has a shape or a colour that is known) and from the names that the things of
this house have; all others from its map. Each kind of word (``engine.skills.registry.Word``) is resolved here to the
word that skills use, or to an error that names what is known.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, get_args

from config.nearest import nearest
from engine.errors import ExitCode, PlanError
from engine.han import SIMPLER
from engine.perception.naming import CHINESE, UnknownObject, Wanted, parted, ranked, wanted
from engine.perception.sighting import Colour
from engine.robot.floor_map import Furniture, Room
from engine.skills.people import People
from engine.skills.places import ZERO_SYMBOL, Places, UnknownPlace, known_names
from engine.skills.synonyms import synonyms

BIN: Final = "bin"
FLOOR: Final = "floor"
ME: Final = "me"
"""Whoever gave the order."""
BARE: Final = frozenset({"plant", "dock", "wardrobe"})
"""Kinds of furniture that nothing is put on."""

_ARTICLES: Final = frozenset({"the", "a", "an", "my", "your", "our", "this", "that"})
_CALLED: Final = {
    "ground": FLOOR, "地上": FLOOR, "地板": FLOOR, "地面": FLOOR, "地板上": FLOOR, "地面上": FLOOR, "gray": "grey",
    "垃圾桶": BIN, "垃圾箱": BIN, "垃圾筒": BIN, "废纸篓": BIN,
    **{f"{said}{suffix}": colour for said, colour in CHINESE.items() if colour in get_args(Colour)
       for suffix in ("", "色", "色的", "的")},
}  # fmt: skip
_CHINESE_ARTICLE: Final = re.compile("^(?:[这那][个张只把台]?|一[个张只把台]|[我你]们?的)(?=.)")

_NUMBER: Final = re.compile(r"[\d ]+$|^\d+号")


class Ambiguous(PlanError):
    """A word that means several things."""

    code = "ambiguous"
    exit_code = ExitCode.CLARIFY

    def __init__(self, message: str, names: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.names = names
        """What it may mean."""


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
    categories: Mapping[str, str] = field(default_factory=dict)
    """What things of one kind are called together, by the names of these things: ``coke`` is one of the ``drinks``."""
    called: Mapping[str, str] = field(default_factory=dict)
    """Other names of furniture and rooms, and the ones above."""


class Vocabulary:
    """Resolves the words of one house."""

    def __init__(self, places: Places, house: House | None = None, people: People | None = None) -> None:
        house = house or House()
        self.people = people or People()
        self._places = places
        self._things = {_plain(name): looks for name, looks in house.things.items()}
        self._categories = {_plain(name): _plain(kind) for name, kind in house.categories.items()}
        self._rooms = {_plain(room.name): room for room in house.rooms}
        self._furniture = {_plain(piece.name): piece for piece in house.furniture if piece.kind not in BARE}
        self._called = {_plain(word): _plain(name) for word, name in house.called.items()}
        names = {**{name: name for name in (*self._furniture, *self._rooms)}, **self._called}
        self._others = synonyms(names, self._place_words())
        self._stands_in = {_plain(piece.name): _room_around(piece, house.rooms) for piece in house.furniture}

    def resolvers(self) -> Mapping[str, Callable[[str], str]]:
        """For each kind of word, what resolves it."""
        return {
            "place": self._places.symbol,
            "places": lambda words: ",".join(self._places.symbols(words)),
            "object": self.object,
            "surface": self.surface,
            "room": self.room,
            "thing_colour": self.colour,
            "person": self.person,
            "people": self.person,
        }

    def object(self, words: str) -> str:
        """What is looked for, as ``str(Wanted)``. Raises :class:`UnknownObject` with what is known."""
        plain = _plain(words)
        if plain in self._things:  # also one that is called like a colour: "the orange"
            return str(wanted(self._things[plain]))
        rank, rest = ranked(plain)
        if rank is not None and (alike := self._of_any(_plain(rest))):
            return str(replace(alike, rank=rank))
        try:
            return str(wanted(plain))
        except UnknownObject as unknown:
            if (beside := parted(plain)) is not None:
                head, side, anchor = beside
                return str(replace(wanted(self.object(head)), beside=(side, wanted(self.object(anchor)))))
            if (names := self.of_category(plain)) and len(names) == 1:
                return str(wanted(self._things[names[0]]))
            if names:
                raise Ambiguous(f"Which {plain}: {', '.join(names[:-1])} or {names[-1]}?", names) from None
            if not (names := self.things()):
                raise
            near = nearest(plain, names) or unknown.near
            raise UnknownObject(unknown.message, hint=f"{unknown.known} And: {', '.join(names)}.", near=near) from None

    def any_of(self, words: str) -> str:
        """What is looked for where each thing of a kind will do ("a fruit", "the drinks"), as ``str(Wanted)``; empty
        where the words are no kind of this house."""
        alike = self._of_any(_plain(words))
        return str(alike) if alike is not None else ""

    def _of_any(self, plain: str) -> Wanted | None:
        """Whatever is called so together, or by this name."""
        names = self.of_category(plain) or ((plain,) if plain in self._things else ())
        looks = tuple(dict.fromkeys(wanted(self._things[name]) for name in names))
        return None if not looks else looks[0] if len(looks) == 1 else Wanted(among=looks)

    def of_category(self, words: str) -> tuple[str, ...]:
        """The names of all things here that are called so together, in the singular or the plural."""
        plain = _plain(words)
        return tuple(
            name
            for name, kind in self._categories.items()
            if plain in (kind, kind.removesuffix("s"), f"{kind}s", kind.removesuffix("es"))
        )

    def person(self, words: str) -> str:
        """Somebody, as ``str(Someone)``; whoever gave the order stays ``me``. Raises :class:`UnknownPerson`."""
        return ME if words.casefold().strip() == ME else str(self.people.who(words))

    def fitting(self, words: str) -> tuple[str, ...]:
        """Every thing of this house that the words may mean, by its name, or the words as :meth:`object` has them where
        the house has none; nothing for unknown words."""
        try:
            plain = self.object(words)
        except PlanError:
            return ()
        meant = wanted(plain)
        if meant.is_choice or meant.among:  # the robot tells which one, or any will do
            return (plain,)
        looks = {name: wanted(looks) for name, looks in self._things.items()}
        fit = (name for name, look in looks.items() if meant.covers(look))
        return tuple(fit) or (plain,)

    def colour(self, word: str) -> str:
        """A colour of things. Raises :class:`UnknownColour` with those that are told apart."""
        colour = _plain(word)
        if colour not in get_args(Colour):
            raise UnknownColour(f"I cannot tell what is {word!r}.", hint=known_names(word, get_args(Colour)))
        return colour

    def room(self, word: str) -> str:
        """The name of a room, also by the name of the place in it. Raises :class:`UnknownPlace` with all rooms."""
        room = self._room(_plain(word))
        if room is None:
            known = [room.name for room in self._rooms.values()] or ["no rooms"]
            raise UnknownPlace(f"I don't know a room called {word!r}.", hint=known_names(word, known))
        return room

    def surface(self, word: str) -> str:
        """Where things are put: the name of a piece of furniture, ``bin`` (the nearest), ``floor``, a room, or another
        place of the map. The last word of a name will do where it means one piece, and so will a name without its
        number. Raises :class:`Ambiguous`, or :class:`UnknownPlace` with all furniture."""
        plain = _plain(word)
        if plain in (BIN, FLOOR):
            return plain
        if (name := self._called.get(plain) or self._others.get(plain, plain)) in self._furniture:
            return self._furniture[name].name
        if (place := self._place(plain)) is not None:
            piece = self._furniture.get(_plain(place))
            if piece is not None and piece.kind == BIN and sum(p.kind == BIN for p in self._furniture.values()) == 1:
                return BIN
            return piece.name if piece is not None else self._room(_plain(place)) or place
        if name in self._rooms:
            return self._rooms[name].name
        alike = [piece.name for name, piece in self._furniture.items() if self._may_mean(plain, name)]
        if len(alike) == 1:
            return alike[0]
        if alike:
            raise Ambiguous(f"Which {plain}: {', '.join(alike[:-1])} or {alike[-1]}?", alike)
        known = (*(piece.name for piece in self._furniture.values()), FLOOR)
        raise UnknownPlace(f"I don't know where {word!r} is.", hint=known_names(word, known))

    def surfaces(self) -> tuple[str, ...]:
        """Every word for a surface, also those that mean several."""
        heads = (_unnumbered(name).rpartition(" ")[2] for name in self._furniture)
        called = (word for word in (*self._place_words(), *self._called) if self._is_furniture(word))
        numbered = (_unnumbered(word) for word in self._called if self._is_furniture(word))
        common = (word for word, meant in _CALLED.items() if meant in (FLOOR, BIN))
        return tuple(dict.fromkeys((FLOOR, BIN, *common, *self._furniture, *called, *heads, *numbered)))

    def rooms(self) -> tuple[str, ...]:
        """Every word for a room."""
        words = (*self._place_words(), *self._called)
        return tuple(dict.fromkeys((*self._rooms, *(word for word in words if self._room(word)))))

    def places(self) -> tuple[str, ...]:
        """Every word for a place of the map."""
        return tuple(dict.fromkeys(self._place_words()))

    def is_marked(self, place: str) -> bool:
        """Whether that is a symbol of the map, the remembered place among them."""
        return place in ("", ZERO_SYMBOL) or place in self._places.known()

    def place_name(self, symbol: str) -> str:
        """What people call a place of the map."""
        return self._places.words(symbol)[0] if symbol and symbol != ZERO_SYMBOL else ""

    def is_symbol(self, word: str) -> bool:
        """Whether that is how a place is marked on the map, and not what anything is called."""
        plain = _plain(word)
        symbols = (symbol.casefold() for symbol in self._places.known() if symbol != ZERO_SYMBOL)
        return plain in symbols and plain not in self._place_words()

    def all_rooms(self) -> tuple[str, ...]:
        """The name of each room, in the order of the map."""
        return tuple(room.name for room in self._rooms.values())

    def things(self) -> tuple[str, ...]:
        """The names that things have here, beyond what perception calls them."""
        return tuple(name for name in self._things if not _is_seen(name))

    def inventory(self) -> tuple[str, ...]:
        """What the loose things of this house are called."""
        return tuple(self._things)

    def furniture(self) -> tuple[str, ...]:
        """What things can be put on or in."""
        return tuple(piece.name for piece in self._furniture.values())

    def room_of(self, word: str) -> str:
        """The room that a piece of furniture stands in; empty where that is not known, or the word means several."""
        plain = _plain(word)
        name = plain if plain in self._stands_in else self._called.get(plain) or _plain(self._place(plain) or "")
        return self._stands_in.get(name, "")

    def names(self) -> tuple[str, ...]:
        """All names of furniture, rooms and things."""
        return (*self._furniture, *self._rooms, *self._things, *self._called)

    def words_for(self, name: str) -> tuple[str, ...]:
        """Every word for a piece of furniture, a room, or a place of the map, its name first."""
        plain = _plain(name)
        places = [self._places.words(symbol) for symbol in self._places.known() if symbol != ZERO_SYMBOL]
        called = (word for words in places if plain in map(_plain, words) for word in words)
        return tuple(dict.fromkeys((name, *called, *(word for word, meant in self._called.items() if meant == plain))))

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

    def _may_mean(self, plain: str, name: str) -> bool:
        """Whether the word is the last one of the name of a piece, or another name without its number."""
        alike = (_unnumbered(word) for word, meant in self._called.items() if meant == name)
        return f" {_unnumbered(name)}".endswith(f" {plain}") or plain in alike

    def _is_furniture(self, plain: str) -> bool:
        if self._called.get(plain) in self._furniture:
            return True
        place = self._place(plain)
        return place is not None and _plain(place) in self._furniture

    def _room(self, plain: str) -> str | None:
        """The room of this name, or that the place of this name is called after."""
        plain = self._called.get(plain, plain)
        if plain not in self._rooms:
            plain = _plain(self._place(plain) or "")
        return self._rooms[plain].name if plain in self._rooms else None


def _room_around(piece: Furniture, rooms: tuple[Room, ...]) -> str:
    x, y = (piece.x_min + piece.x_max) / 2, (piece.y_min + piece.y_max) / 2
    return next((room.name for room in rooms if room.holds(x, y)), "")


def _is_seen(name: str) -> bool:
    """Whether perception knows by itself what is called so."""
    try:
        wanted(name)
    except UnknownObject:
        return False
    return True


def _unnumbered(name: str) -> str:
    """``tray`` of ``tray 2``, 托盘 of 2号托盘."""
    return _NUMBER.sub("", name) or name


def _plain(words: str) -> str:
    """In lower case, without the article, in the spelling that is used here."""
    parts = _CHINESE_ARTICLE.sub("", words.casefold().translate(SIMPLER).strip()).split()
    while len(parts) > 1 and parts[0] in _ARTICLES:
        del parts[0]
    return " ".join(_CALLED.get(part, part) for part in parts)
