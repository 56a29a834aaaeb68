"""World files: places, objects and people by name, in YAML or JSON.

All three parts may be lists of names, lists of ``{name, aliases, …}``, or mappings from names to their other names or
details; objects may also stand under their category. Other keys are left aside, with a warning::

    places: {living_room: [lounge], kitchen: {aliases: [galley], kind: room}}
    objects: {fruit: [apple, banana], mug: {category: dish, aliases: [cup], place: kitchen}}
    people: [Anna, {name: Doctor Chen, aliases: [Chen]}]
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import yaml

from config.schema import Place, Position
from engine.errors import UsageError
from engine.planner.worlds.names import Named, spoken
from engine.planner.worlds.world import World
from engine.skills.places import ZERO_SYMBOL
from engine.skills.vocabulary import BIN

Warn = Callable[[str], None]

_ALIASES: Final = ("aliases", "alias", "synonyms", "also", "names")
_CATEGORY: Final = ("category", "kind", "type", "class")
_COLOUR: Final = ("colour", "color")
_PLACE: Final = ("place", "location", "at", "on", "in", "room", "home")
_LEFT_ASIDE: Final = ("name", "id", "description", "position", "pose", "x", "y", "z", "size", "symbol", "yaw")
"""Details that planning has no use for, without a warning."""
_ME: Final = ("user", "me", "you", "the user", "operator", "speaker")
"""Places that stand for whoever speaks."""
_SPEAKER: Final = ("me", "here", "user", "the user")
_BINS: Final = frozenset({BIN, "trash", "rubbish", "garbage", "waste", "dustbin", "wastebasket", "trashcan"})
MOST: Final = 500
"""Names of one sort."""


class WorldError(UsageError):
    """A world file is wrong."""

    code = "world"


def load_world(path: Path, warn: Warn = lambda message: None) -> World:
    """Read a world file. Raises :class:`WorldError` that says what is wrong and what to write instead."""
    try:
        raw = yaml.safe_load(path.read_text(encoding="utf-8"))  # JSON is YAML too
    except OSError as error:
        raise WorldError(f"Cannot read the world file {path}: {error.strerror}.") from error
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError) as error:
        raise WorldError(f"{path} is neither YAML nor JSON: {' '.join(str(error).split())}.") from error
    return read_world(raw, str(path), warn)


def read_world(raw: object, source: str, warn: Warn = lambda message: None) -> World:
    """The world that a file's content describes. Raises :class:`WorldError`."""
    if not isinstance(raw, Mapping):
        raise WorldError(f"{source}: a world is a mapping with places, objects and people.", hint=_EXAMPLE)
    for key in raw.keys() - {"places", "objects", "people", "name"}:
        warn(f"{source}: {key} is left aside; a world has places, objects and people.")
    spots = tuple(_with_speaker(entry.named) for entry in _entries(raw.get("places"), "places", source, warn))
    objects = _told_apart(tuple(_by_category(raw.get("objects"), source, warn)))
    people = tuple(_with_speaker(entry.named) for entry in _entries(raw.get("people"), "people", source, warn))
    people = tuple(one for one in people if not _is_among(one, spots))
    if not spots and not people:
        raise WorldError(f"{source}: places is missing, so there is nowhere to go.", hint=_EXAMPLE)
    for sort, entries in (("places", (*spots, *people)), ("objects", tuple(entry.named for entry in objects))):
        _distinct(sort, entries, source)
    rooms = tuple(one for one in spots if one.category in ("", "room") and one.name not in _ME)
    homes = {entry.named.key: entry.home for entry in objects if entry.home}
    places = {one.key: _place(one, index) for index, one in enumerate((*spots, *people))}
    return World(places, rooms, spots, tuple(entry.named for entry in objects), people, homes)


_EXAMPLE: Final = "Write for example: {places: [kitchen, bedroom], objects: {fruit: [apple, banana]}, people: [Anna]}."


@dataclass(frozen=True, slots=True)
class _Entry:
    named: Named
    home: str = ""


def _entries(raw: object, sort: str, source: str, warn: Warn, category: str = "") -> Iterator[_Entry]:
    """The entries of a list of names or details, or of a mapping from names to aliases or details."""
    if raw is None:
        return
    pairs: list[tuple[object, object]] = []
    if isinstance(raw, Mapping):
        pairs = list(raw.items())
    elif isinstance(raw, Sequence) and not isinstance(raw, str | bytes):
        for item in raw:
            if not isinstance(item, Mapping):
                pairs.append((item, None))
            elif "name" in item or "id" in item:
                pairs.append((item.get("id", item.get("name")), item))
            elif len(item) == 1:
                pairs += item.items()
            else:
                raise WorldError(f"{source}: {sort}: {_shown(item)} has no name.", hint="Write {name: …}.")
    else:
        raise WorldError(f"{source}: {sort} must be a list or a mapping, not {_shown(raw)}.", hint=_EXAMPLE)
    if len(pairs) > MOST:
        raise WorldError(f"{source}: there are {len(pairs)} {sort}; {MOST} are read at most.")
    for name, details in pairs:
        yield _entry(name, details, f"{source}: {sort}", warn, category)


def _entry(name: object, details: object, at: str, warn: Warn, category: str) -> _Entry:
    if isinstance(name, bool) or not isinstance(name, str | int) or not str(name).strip():
        raise WorldError(f"{at}: {_shown(name)} is no name.", hint="A name is a text; put it in quotation marks.")
    key = str(name).strip()
    if key.casefold() == ZERO_SYMBOL:
        raise WorldError(f"{at}: zero is the place that the robot remembers.", hint="Give this one another name.")
    if details is None or isinstance(details, str | Sequence):
        aliases = _names(details, f"{at}: {key}")
        return _Entry(Named(key, spoken(key), aliases, category.casefold()))
    if not isinstance(details, Mapping):
        raise WorldError(f"{at}: {key}: {_shown(details)} is neither a list of other names nor a mapping of details.")
    known = {*_ALIASES, *_CATEGORY, *_COLOUR, *_PLACE, *_LEFT_ASIDE}
    for extra in details.keys() - known:
        warn(f"{at}: {key}: {extra} is left aside.")
    said = spoken(str(details.get("name") or key))
    aliases = tuple(alias for word in _ALIASES for alias in _names(details.get(word), f"{at}: {key}: {word}"))
    kind = _first(details, _CATEGORY) or category
    return _Entry(
        Named(key, said, aliases, spoken(kind).casefold(), _first(details, _COLOUR).casefold()),
        _first(details, _PLACE),
    )


def _by_category(raw: object, source: str, warn: Warn) -> Iterator[_Entry]:
    """Objects by name, or under their category. A list under a name holds the objects of a category, unless lists are
    empty: then they hold other names."""
    if not isinstance(raw, Mapping):
        yield from _entries(raw, "objects", source, warn)
        return
    by_name = any(inside in ([], ()) for inside in raw.values())
    for name, inside in raw.items():
        if not by_name and _holds_objects(inside):
            yield from _entries(inside, f"objects: {name}", source, warn, spoken(str(name)))
        else:
            yield from _entries({name: inside}, "objects", source, warn)


def _told_apart(entries: Sequence[_Entry]) -> tuple[_Entry, ...]:
    """Objects of one name and several colours have the colour in their names."""
    names = [entry.named.key.casefold() for entry in entries]

    def coloured(entry: _Entry) -> _Entry:
        one = entry.named
        if names.count(one.key.casefold()) == 1 or not one.colour:
            return entry
        joint = "_" if "_" in one.key else " "
        return _Entry(replace(one, key=f"{one.colour}{joint}{one.key}", name=f"{one.colour} {one.name}"), entry.home)

    return tuple(map(coloured, entries))


def _holds_objects(inside: object) -> bool:
    if isinstance(inside, Mapping):
        return bool(inside) and all(isinstance(value, Mapping) for value in inside.values())
    return isinstance(inside, Sequence) and not isinstance(inside, str)


def _names(raw: object, at: str) -> tuple[str, ...]:
    if raw is None:
        return ()
    names = [raw] if isinstance(raw, str) else raw
    if not isinstance(names, Sequence) or not all(isinstance(name, str) and name.strip() for name in names):
        raise WorldError(f"{at}: other names are a list of texts, not {_shown(raw)}.")
    return tuple(spoken(name) for name in names)


def _first(details: Mapping[Any, Any], keys: Sequence[str]) -> str:
    value = next((details[key] for key in keys if isinstance(details.get(key), str)), "")
    return str(value).strip()


def _with_speaker(one: Named) -> Named:
    """``here`` and ``me`` are where whoever speaks is; and what is called like a bin is the bin."""
    said = {word.casefold() for word in one.said()}
    more: tuple[str, ...] = ()
    if said & set(_ME):
        more = _SPEAKER
    elif set(one.name.casefold().split()) & _BINS or said & _BINS:
        more = (BIN, "trash")
    new = tuple(word for word in more if word not in said)
    return replace(one, aliases=(*one.aliases, *new))


def _is_among(one: Named, spots: Sequence[Named]) -> bool:
    """Whether a person is a place already, as ``user`` often is."""
    said = {word.casefold() for word in one.said()}
    return any(said & {word.casefold() for word in spot.said()} for spot in spots)


def _distinct(sort: str, entries: Sequence[Named], source: str) -> None:
    taken: dict[str, str] = {}
    for one in entries:
        key = one.key.casefold()
        if key in taken:
            raise WorldError(f"{source}: {sort}: {one.key} is there twice.", hint="Give one of them another name.")
        taken[key] = one.key


def _place(one: Named, index: int) -> Place:
    return Place(name=one.name, aliases=one.aliases, position=Position(x=float(index), y=0.0))


def _shown(value: object) -> str:
    return repr(value) if len(repr(value)) <= 60 else f"{repr(value)[:60]}…"
