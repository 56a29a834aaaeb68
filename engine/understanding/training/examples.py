"""Sentences to learn from, made of those that people wrote.

Each written example is used as it stands and in variations: another filler in a role, two or three requests joined to
one, politeness around it, the marks of a recogniser instead of those of a typist. A seed makes them the same every
time."""

from __future__ import annotations

import random
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import yaml

from engine.han import is_chinese
from engine.understanding.acts import ACTS
from engine.understanding.notation import Example, NotationError, Step, read

ASSETS: Final = Path("assets/understanding")
HABITS: Final = ASSETS / "habits.yaml"
SENTENCES: Final = ASSETS / "sentences"
"""A folder of folders of files of sentences."""
SHARE: Final = 0.15
"""Of the thinned sentences, what an epoch takes."""
_SINGLE_ONLY: Final = frozenset({"fragment", "talk", "yes", "no", "about", "instead", "fact"})
_SWAPPED: Final = frozenset({"thing", "place", "source", "person", "amount", "time", "times", "colour", "text"})


@dataclass(frozen=True, slots=True)
class Habits:
    """How people of one language join requests, and what they put around them (assets/understanding/habits.yaml)."""

    joints: tuple[str, ...]
    before: tuple[str, ...]
    behind: tuple[str, ...]
    taken_back: tuple[str, ...]
    fillers: tuple[str, ...]


def habits(path: Path) -> dict[str, Habits]:
    """Read the habits of each language."""
    found = yaml.safe_load(path.read_text("utf-8"))
    return {language: Habits(**{key: tuple(words) for key, words in of.items()}) for language, of in found.items()}


def lines(path: Path) -> Iterator[tuple[int, str]]:
    """The lines of a file with their numbers; a line with # is a comment."""
    for number, line in enumerate(path.read_text("utf-8").splitlines(), 1):
        if line.strip() and not line.startswith("#"):
            yield number, line


def written(paths: Iterable[Path]) -> list[Example]:
    """All examples of some files. Raises :class:`NotationError` with file and line."""
    examples = []
    for path in paths:
        for number, line in lines(path):
            try:
                examples.append(read(line))
            except NotationError as error:
                raise NotationError(f"{path}:{number}: {error}") from error
    return examples


_OUTER: Final = re.compile(
    r"(?:to|in|into|on|onto|at|from|for|of|with|by|inside|towards|toward|that|whether|if) (?=\S)", re.IGNORECASE
)


def clean(text: str, step: Step) -> Step:
    """The role without the preposition that only says which role it is ("to the kitchen")."""
    start = step.start
    while (outer := _OUTER.match(text, start, step.end)) is not None:
        start = outer.end()
    return Step(step.symbol, start, step.end)


def language_of(text: str) -> str:
    """``zh`` where there is a Chinese character, else ``en``."""
    return "zh" if is_chinese(text) else "en"


@dataclass
class Variations:
    """Makes new examples of written ones."""

    examples: Sequence[Example]
    habits: dict[str, Habits]
    random: random.Random
    thinned: Sequence[Example] = ()
    """Of these, each epoch takes another ``SHARE``."""
    _fillers: dict[tuple[str, str, str], list[str]] = field(default_factory=lambda: defaultdict(list))
    _pools: dict[tuple[str, str], list[str]] = field(default_factory=lambda: defaultdict(list))
    _joinable: dict[str, list[Example]] = field(default_factory=lambda: defaultdict(list))

    def __post_init__(self) -> None:
        for example in (*self.examples, *self.thinned):
            language = language_of(example.text)
            act = ""
            for step in example.steps:
                if step.start < 0:
                    act = step.symbol
                elif step.symbol in _SWAPPED:
                    words = example.text[step.start : step.end]
                    self._fillers[language, act, step.symbol].append(words)
                    self._pools[language, step.symbol].append(words)
            symbols = {step.symbol for step in example.steps}
            if not symbols & _SINGLE_ONLY and len(example.text) < 90:
                self._joinable[language].append(example)

    def epoch(self) -> Iterator[Example]:
        """One variation of each example, and joined ones: as many again as a fifth of them."""
        taken = [*self.examples, *self.random.sample(list(self.thinned), int(len(self.thinned) * SHARE))]
        for example in taken:
            yield self._dressed(self._refilled(example) if self.random.random() < 0.5 else example)
        for language, joinable in sorted(self._joinable.items()):
            for _ in range(len(joinable) * len(taken) // (5 * (len(self.examples) + len(self.thinned)))):
                yield self._dressed(self._joined(language, joinable))

    def _refilled(self, example: Example) -> Example:
        """The same with other words in some of its roles."""
        language, act = language_of(example.text), ""
        text, moved = example.text, list(example.steps)
        for index, step in enumerate(example.steps):
            if step.start < 0:
                act = step.symbol
                continue
            if step.symbol not in _SWAPPED or self.random.random() < 0.4:
                continue
            pool = self._fillers[language, act, step.symbol]
            if self.random.random() < 0.3 and step.symbol in ("thing", "place", "source", "person"):
                pool = self._pools[language, step.symbol]
            start, end = moved[index].start, moved[index].end
            if any(
                at != index and other.start >= 0 and other.start < step.end and step.start < other.end
                for at, other in enumerate(example.steps)
            ):
                continue
            new = self.random.choice(pool)
            text = text[:start] + new + text[end:]
            shift = len(new) - (end - start)
            moved = [
                Step(s.symbol, s.start, s.end + shift) if i == index
                else Step(s.symbol, s.start + shift, s.end + shift) if s.start >= end else s
                for i, s in enumerate(moved)
            ]  # fmt: skip
        return Example(text, tuple(moved))

    def _joined(self, language: str, joinable: Sequence[Example]) -> Example:
        """Two or three requests as one; sometimes taken back."""
        parts = [self._refilled(part) for part in self.random.sample(joinable, self.random.choice((2, 2, 2, 3)))]
        text, steps = _open_ended(parts[0].text, parts[0].steps)
        for part in parts[1:]:
            text += self.random.choice(self.habits[language].joints)
            small, own = _open_ended(part.text[0].lower() + part.text[1:], part.steps)
            steps += _moved(own, len(text))
            text += small
        if self.random.random() < 0.1:
            text += self.random.choice(self.habits[language].taken_back)
            steps.append(Step("retract"))
        return Example(text, tuple(steps))

    def _dressed(self, example: Example) -> Example:
        """With politeness in front or behind, and as a recogniser or a typist writes it."""
        text, steps = example.text, list(example.steps)
        of = self.habits[language_of(text)]
        order = steps[0].symbol in ACTS and steps[0].symbol not in _SINGLE_ONLY
        if order and self.random.random() < 0.12:
            before = self.random.choice(of.before)
            text, steps = before + text[0].lower() + text[1:], _moved(steps, len(before))
        if order and steps[-1].symbol != "retract" and self.random.random() < 0.08:
            text, steps = _open_ended(text, steps)
            text += self.random.choice(of.behind)
        elif order and steps[-1].symbol != "retract" and len(steps) < 9 and self.random.random() < 0.03:
            text, steps = _open_ended(text, steps)
            text += self.random.choice(of.taken_back)
            steps = [*steps, Step("retract")]
        if self.random.random() < 0.45:
            text, steps = _without_marks(text, steps)
        if self.random.random() < 0.06:
            text, steps = self._hesitating(text, steps, of)
        return Example(text, tuple(steps))

    def _hesitating(self, text: str, steps: Sequence[Step], of: Habits) -> tuple[str, list[Step]]:
        gaps = [found.end() for found in re.finditer(r"[\s，,]+", text)]
        gaps = [gap for gap in gaps if not any(step.start < gap < step.end for step in steps)]
        if not gaps:
            return text, list(steps)
        at, word = self.random.choice(gaps), self.random.choice(of.fillers)
        moved = [Step(s.symbol, s.start + len(word), s.end + len(word)) if s.start >= at else s for s in steps]
        return text[:at] + word + text[at:], moved


def _open_ended(text: str, steps: Iterable[Step]) -> tuple[str, list[Step]]:
    """Without the marks at its end, also where a role has them."""
    bare = text.rstrip(" .!?。！？")
    return bare, [Step(s.symbol, s.start, min(s.end, len(bare))) if s.start >= 0 else s for s in steps]


def _moved(steps: Iterable[Step], by: int) -> list[Step]:
    return [Step(s.symbol, s.start + by, s.end + by) if s.start >= 0 else s for s in steps]


def _without_marks(text: str, steps: Sequence[Step]) -> tuple[str, list[Step]]:
    """Without commas and full stops, as some recognisers write; each place is kept by counting."""
    kept, where = list[str](), list[int]()
    for index, letter in enumerate(text):
        where.append(len(kept))
        inner = 0 < index < len(text) - 1 and text[index - 1].isdigit() and text[index + 1].isdigit()
        if letter in ",.!?;:，。！？；：" and not inner:
            continue
        kept.append(letter)
    where.append(len(kept))
    return "".join(kept), [Step(s.symbol, where[s.start], where[s.end]) if s.start >= 0 else s for s in steps]
