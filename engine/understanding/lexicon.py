"""The words that the learned reader has learned from (``assets/understanding/words.txt``).

The reader gives a meaning to any text, and may be sure of it: of words that it has never seen it knows no more than how
they are spelt. What it says of those words is worth nothing, however sure it is.

An English word stands in the list as it is. Nothing separates the words of Chinese, so there two characters next to one
another are a word, and one that stands by itself.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from functools import cache
from importlib.resources import files
from typing import Final

from engine.han import SIMPLER
from engine.understanding.units import Unit, units

WORDS: Final = "words.txt"
ALONE: Final = "."
"""Stands in the list for the end of a Chinese character that is by itself."""
COMMON: Final = 30
"""With so many others a character stands that is common."""


def words_in(text: str, leaving_out: Sequence[tuple[int, int]] = ()) -> Iterator[str]:
    """The words of ``text``, without those that begin in one of these spans of its characters. Numbers, punctuation
    marks and single Latin letters that are no word are none."""
    found = units(text.translate(SIMPLER))
    for at, unit in enumerate(found):
        if any(start <= unit.start < end for start, end in leaving_out):
            continue
        if not _is_chinese(unit):
            if unit.word[0].isalpha() and unit.word != "_":
                yield unit.word
            continue
        behind = found[at + 1] if at + 1 < len(found) else None
        if behind is not None and _touch(unit, behind):
            yield unit.word + behind.word
        elif not (at and _touch(found[at - 1], unit)):
            yield unit.word + ALONE


@cache
def lexicon() -> frozenset[str]:
    """All of them."""
    lines = (files("assets") / "understanding" / WORDS).read_text("utf-8").splitlines()
    return frozenset(word for line in lines for word in _words_of(line))


@cache
def common_characters() -> frozenset[str]:
    """Chinese characters that stand beside many others, and the mark of one that is by itself."""
    counts = Counter(character for word in lexicon() if _is_han(word[0]) for character in word)
    return frozenset(character for character, count in counts.items() if count >= COMMON)


def written(words: Sequence[str]) -> str:
    """The file that has these words: English ones a line each, and Chinese ones a line for each first character."""
    chinese: dict[str, str] = {}
    for word in sorted(words):
        if _is_han(word[0]):
            chinese[word[0]] = chinese.get(word[0], "") + word[1]
    english = sorted(word for word in words if word[0] not in chinese)
    return "".join(f"{line}\n" for line in (*english, *(f"{first} {others}" for first, others in chinese.items())))


def _words_of(line: str) -> Iterator[str]:
    first, _, others = line.partition(" ")
    if not others:
        yield line
    for other in others:
        yield first + other


def _is_chinese(unit: Unit) -> bool:
    return _is_han(unit.word[0])


def _is_han(character: str) -> bool:
    return "㐀" <= character <= "鿿"


def _touch(before: Unit, behind: Unit) -> bool:
    return before.end == behind.start and _is_chinese(before) and _is_chinese(behind)
