"""What the palette lists, and how what is typed finds it.

An entry does nothing by itself: it says what choosing it asks for. What could move the robot is a request, as if it had
been typed into the line.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from config.nearest import nearest as nearest_name
from tui.keys.keys import DOCTOR_KEYS, HAND_KEYS, KEYS, LOG_KEYS, MAP_KEYS, QUEUE_KEYS, SETTING_KEYS, TURN_KEYS, Key
from tui.options import SHOWN, every
from tui.plan.targets import asked_to_go
from tui.shown.facts import LogLine, printable
from tui.words import strings
from tui.words.language import told

if TYPE_CHECKING:
    from config.schema import Place
    from engine.skills.registry import Skill

Where = Literal["console", "map", "queue", "log", "turn", "doctor", "hand", "settings"]
Kind = Literal["action", "place", "skill", "recent", "setting", "file", "log", "request"]
MAX_RECENT: Final = 50
FIRST_RECENT: Final = 5
"""Earlier requests that stand before all else while nothing is typed."""
MAX_NEAREST: Final = 5
_SENTENCES: Final = ("action", "skill")
"""The titles of these are sentences, and nobody abbreviates a word of a sentence: their names are among the words."""
_WORD: Final = re.compile(r"\w+")


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
class Send:
    """A request."""

    text: str


@dataclass(frozen=True, slots=True)
class Fill:
    """A skill, whose arguments are asked for."""

    skill: Skill


@dataclass(frozen=True, slots=True)
class Tell:
    """Something to be read."""

    text: str


@dataclass(frozen=True, slots=True)
class Change:
    """A setting by its dotted name, on the page where it is changed."""

    setting: str


@dataclass(frozen=True, slots=True)
class Show:
    """A line of the log, where it stands."""

    line: LogLine


@dataclass(frozen=True, slots=True)
class Put:
    """A setting by its dotted name gets this value."""

    setting: str
    value: str


Choice = Act | Write | Send | Fill | Tell | Change | Put | Show


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
    about: str = ""
    """What finds it as well, but after whatever is called so."""


def entries(
    keys: Mapping[str, str],
    places: Mapping[str, Place],
    skills: Sequence[Skill],
    recent: Sequence[str],
    settings_file: str,
    themes: Sequence[str] = (),
    possible: Callable[[str], bool] = lambda action: True,
) -> tuple[Entry, ...]:
    """All there is. ``keys`` are those in use by action id, as they are shown; ``recent``: the newest last; ``themes``
    are those that there are; ``possible``: of the console's own actions, those that could ever act."""
    return (
        *requests(recent),
        *_places(places),
        *_actions(keys, possible),
        *_skills(skills),
        *_settings(),
        *_values(themes),
        Entry("file", strings.SETTINGS_FILE.format(settings_file), strings.KIND_FILE,
              Tell(strings.SETTINGS_ARE_IN.format(settings_file)), "file config yaml"),
    )  # fmt: skip


def requests(recent: Sequence[str]) -> tuple[Entry, ...]:
    """What was asked for before, the newest first, each once."""
    newest = list(dict.fromkeys(reversed(recent)))[:MAX_RECENT]
    return tuple(Entry("recent", printable(text), strings.KIND_RECENT, Write(text)) for text in newest)


def log_lines(lines: Sequence[LogLine]) -> tuple[Entry, ...]:
    """The lines of the log, the newest first."""
    return tuple(
        Entry("log", told(line.message), strings.SOURCES.get(line.source, line.source), Show(line), line.source)
        for line in reversed(lines)
    )


def _places(places: Mapping[str, Place]) -> Iterator[Entry]:
    for symbol, place in places.items():
        text = asked_to_go(place.name)
        words = " ".join((symbol, place.name, *place.aliases))
        yield Entry("place", printable(text), strings.KIND_PLACE, Send(text), words)


def _actions(keys: Mapping[str, str], possible: Callable[[str], bool]) -> Iterator[Entry]:
    for key in KEYS:
        if key.id != "palette" and possible(key.id):
            yield Entry("action", key.about, keys[key.id], Act(key), f"{key.id} {key.word}")
    for key in MAP_KEYS:
        yield Entry("action", key.about, f"{strings.KIND_MAP} {keys[key.id]}", Act(key, "map"), key.id)
    for key in QUEUE_KEYS:
        yield Entry("action", key.about, f"{strings.KIND_QUEUE} {keys[key.id]}", Act(key, "queue"), key.id)
    for key in LOG_KEYS:
        yield Entry("action", key.about, f"{strings.KIND_LOG} {keys[key.id]}", Act(key, "log"), key.id)
    for key in TURN_KEYS:
        yield Entry("action", key.about, f"{strings.KIND_TURN} {keys[key.id]}", Act(key, "turn"), key.id)
    for key in DOCTOR_KEYS:
        yield Entry("action", key.about, f"{strings.KIND_DOCTOR} {keys[key.id]}", Act(key, "doctor"), key.id)
    for key in HAND_KEYS:
        yield Entry("action", key.about, f"{strings.KIND_HAND} {keys[key.id]}", Act(key, "hand"), key.id)
    for key in SETTING_KEYS:
        yield Entry("action", key.about, f"{strings.KIND_SETTINGS} {keys[key.id]}", Act(key, "settings"), key.id)


def _skills(skills: Sequence[Skill]) -> Iterator[Entry]:
    for skill in skills:
        words = " ".join((skill.name, skill.name.replace("_", " "), *(p.name for p in skill.parameters)))
        english, name = "", told(skill.name)
        if name != skill.name:  # in another language: its own words find it as well
            words, english = f"{words} {name}", printable(skill.summary)
        yield Entry("skill", about_skill(skill), strings.KIND_SKILL, Fill(skill), words, english)


def _settings() -> Iterator[Entry]:
    from config.changing import described

    for key in every():
        about = " ".join((strings.SETTING_ABOUTS.get(key, ""), described(tuple(key.split(".")))))
        words = " ".join((key, key.replace(".", " ").replace("_", " ")))
        title = strings.SETTING_ENTRY.format(strings.SETTING_NAMES.get(key, key))
        yield Entry("setting", title, key, Change(key), words, about)


def _values(themes: Sequence[str]) -> Iterator[Entry]:
    """What settings can be, where that is a list."""
    from config.changing import choices

    for key in SHOWN:
        for value in themes if key == "console.theme" else choices(tuple(key.split("."))):
            title = strings.VALUE_ENTRY.format(strings.SETTING_NAMES[key], strings.SETTING_VALUES.get(value, value))
            yield Entry("setting", title, key, Put(key, value), f"{key} {value.replace('-', ' ')}")


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
        recent = [entry for entry in listed if entry.kind == "recent"]
        others = [entry for entry in listed if entry.kind != "recent"]
        return (*recent[:FIRST_RECENT], *others, *recent[FIRST_RECENT:])
    scored = [(score, number) for number, entry in enumerate(listed) if (score := _score(entry, wanted)) > 0]
    return tuple(listed[number] for _, number in sorted(scored, key=lambda pair: (-pair[0], pair[1])))


def nearest(listed: Sequence[Entry], typed: str) -> tuple[Entry, ...]:
    """What may have been meant by words that are in no entry: each stands for the word that is most like it. And what
    was typed as a request, which is always possible."""
    known = sorted({word for entry in listed for word in _WORD.findall(f"{entry.title} {entry.words}".casefold())})
    alike = [nearest_name(word, known) or word for word in typed.casefold().split()]
    asked = Entry("request", strings.ASK_TYPED.format(printable(typed.strip())), strings.KIND_REQUEST, Send(typed))
    return (*found(listed, " ".join(alike))[:MAX_NEAREST], asked)


def _score(entry: Entry, wanted: Sequence[str]) -> float:
    """How well an entry fits: 0 for not at all. What is called so comes first, then what begins so."""
    title, words, about = (text.casefold() for text in (entry.title, entry.words, entry.about))
    names = words.split() if entry.kind in _SENTENCES else (*words.split(), title)
    scores = [
        max(
            _fit(title, word, short=entry.kind not in _SENTENCES),
            1.2 if word in names else 1.1 if any(name.startswith(word) for name in names) else 0.9 * _fit(words, word),
            0.4 if word in about else 0.0,
        )
        for word in wanted
    ]
    return 0.0 if min(scores) == 0 else sum(scores)


def _fit(text: str, word: str, *, short: bool = True) -> float:
    """The beginning counts most, then a word as a whole, the beginning of one, a part, and last what it may be
    ``short`` for; in a sentence, which is not ``short``, words are not names and count less."""
    if word not in text:
        return _abbreviated(text, word) if short and len(word) > 2 else 0.0
    if text.startswith(word):
        return 1.1
    parts = text.replace("_", " ").split()
    share = 1.0 if word in parts else 0.8 if any(part.startswith(word) for part in parts) else 0.5
    return share if short else 0.8 * share


def _abbreviated(text: str, word: str) -> float:
    """Whether it is short for a word of the text, whose letters stand in this order (``ktchn``), or for several, of
    which it has the first letters (``gttk``). The more of the word it has, the better it fits."""
    parts = _WORD.findall(text)
    if word in "".join(part[0] for part in parts):
        return 0.1
    fits = [len(word) / len(part) for part in parts if _is_short_for(word, part)]
    return 0.2 * max(fits, default=0.0)


def _is_short_for(word: str, part: str) -> bool:
    letters = iter(part)
    return part[:1] == word[:1] and all(letter in letters for letter in word)
