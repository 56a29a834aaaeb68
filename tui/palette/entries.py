"""What the palette lists, and how what is typed finds it.

An entry does nothing by itself: it says what choosing it asks for. What could move the robot is a request that goes
into the input line, where enter sends it; only the console's own actions act at once.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from tui.keys.keys import KEYS, MAP_KEYS, SETTING_KEYS, TURN_KEYS, Key
from tui.shown.facts import printable
from tui.words import strings
from tui.words.language import told

if TYPE_CHECKING:
    from config.schema import Place
    from engine.skills.registry import Skill

Where = Literal["console", "map", "turn", "settings"]
Kind = Literal["action", "place", "skill", "recent", "file"]
MAX_RECENT: Final = 50


@dataclass(frozen=True, slots=True)
class Act:
    """An action of the console, of the map, or of a page."""

    key: Key
    where: Where = "console"


@dataclass(frozen=True, slots=True)
class Write:
    """Words for the input line."""

    text: str


@dataclass(frozen=True, slots=True)
class Fill:
    """A skill, whose arguments are asked for."""

    skill: Skill


@dataclass(frozen=True, slots=True)
class Tell:
    """Something to be read."""

    text: str


Choice = Act | Write | Fill | Tell


@dataclass(frozen=True, slots=True)
class Entry:
    """One line of the palette."""

    kind: Kind
    title: str
    beside: str
    """Its key, or what kind of entry it is."""
    choice: Choice
    words: str = ""
    """What finds it besides its title."""


def entries(
    keys: Mapping[str, str],
    places: Mapping[str, Place],
    skills: Sequence[Skill],
    recent: Sequence[str],
    settings_file: str,
) -> tuple[Entry, ...]:
    """All there is. ``keys`` are those in use by action id, as they are shown; ``recent``: the newest last."""
    return (
        *requests(recent),
        *_places(places),
        *_actions(keys),
        *_skills(skills),
        Entry("file", strings.SETTINGS_FILE.format(settings_file), strings.KIND_FILE,
              Tell(strings.SETTINGS_ARE_IN.format(settings_file)), "file config yaml"),
    )  # fmt: skip


def requests(recent: Sequence[str]) -> tuple[Entry, ...]:
    """What was asked for before, the newest first, each once."""
    newest = list(dict.fromkeys(reversed(recent)))[:MAX_RECENT]
    return tuple(Entry("recent", printable(text), strings.KIND_RECENT, Write(text)) for text in newest)


def _places(places: Mapping[str, Place]) -> Iterator[Entry]:
    for symbol, place in places.items():
        name = told(place.name)
        text = (strings.GO_TO if name.isascii() else strings.GO_TO_HAN).format(name)
        words = " ".join((symbol, place.name, *place.aliases))
        yield Entry("place", printable(text), strings.KIND_PLACE, Write(text), words)


def _actions(keys: Mapping[str, str]) -> Iterator[Entry]:
    for key in KEYS:
        if key.id != "palette":
            yield Entry("action", key.about, keys[key.id], Act(key), f"{key.id} {key.word}")
    for key in MAP_KEYS:
        yield Entry("action", key.about, f"{strings.KIND_MAP} {keys[key.id]}", Act(key, "map"), key.id)
    for key in TURN_KEYS:
        yield Entry("action", key.about, f"{strings.KIND_TURN} {keys[key.id]}", Act(key, "turn"), key.id)
    for key in SETTING_KEYS:
        yield Entry("action", key.about, f"{strings.KIND_SETTINGS} {keys[key.id]}", Act(key, "settings"), key.id)


def _skills(skills: Sequence[Skill]) -> Iterator[Entry]:
    for skill in skills:
        words = " ".join((skill.name, skill.name.replace("_", " "), *(p.name for p in skill.parameters)))
        about, name = about_skill(skill), told(skill.name)
        if name != skill.name:  # in another language: its own words find it as well
            words = f"{words} {name} {printable(skill.summary)}"
        yield Entry("skill", about, strings.KIND_SKILL, Fill(skill), words)


def about_skill(skill: Skill) -> str:
    """What a skill does, in one sentence; where there is none in the language of the console, with its word in it."""
    english, name = skill.summary.replace("`", ""), told(skill.name)
    about = told(english)
    return printable(about if about != english or name == skill.name else f"{name} · {about}")


def found(listed: Sequence[Entry], typed: str) -> tuple[Entry, ...]:
    """The entries in which every word that was typed occurs, or at least its letters in their order; the best first,
    and those that are as good in the order of the list."""
    wanted = typed.casefold().split()
    if not wanted:
        return tuple(listed)
    scored = [(score, number) for number, entry in enumerate(listed) if (score := _score(entry, wanted)) > 0]
    return tuple(listed[number] for _, number in sorted(scored, key=lambda pair: (-pair[0], pair[1])))


def _score(entry: Entry, wanted: Sequence[str]) -> float:
    """How well an entry fits: 0 for not at all."""
    title, words = entry.title.casefold(), entry.words.casefold()
    names = words.split()
    scores = [max(_fit(title, word), 1.05 if word in names else 0.9 * _fit(words, word)) for word in wanted]
    return 0.0 if min(scores) == 0 else sum(scores)


def _fit(text: str, word: str) -> float:
    """The beginning counts most, then a word as a whole, the beginning of one, a part, its letters in their order."""
    if word not in text:
        return 0.1 if len(word) > 2 and _scattered(text, word) else 0.0
    if text.startswith(word):
        return 1.1
    parts = text.replace("_", " ").split()
    if word in parts:
        return 1.0
    return 0.8 if any(part.startswith(word) for part in parts) else 0.5


def _scattered(text: str, word: str) -> bool:
    """Whether its letters stand in this order in one word: ``ktchn``."""
    for part in text.split():
        letters = iter(part)
        if part[:1] == word[:1] and all(letter in letters for letter in word):
            return True
    return False
