"""The words of a request, as spans of its characters.

A unit is what a role can begin or end with: a word, a number, a punctuation mark, or one Chinese character.
"""

from __future__ import annotations

import re
import unicodedata
from typing import Final, NamedTuple

_UNIT: Final = re.compile(
    r"[㐀-䶿一-鿿]"  # one Chinese character
    r"|\d+(?:[.,:/]\d+)*"
    r"|[^\W\d_㐀-䶿一-鿿]+(?:['-][^\W\d_㐀-䶿一-鿿]+)*"
    r"|[^\w\s]|_"
)
_PLAIN: Final = str.maketrans({"’": "'", "‘": "'", "“": '"', "”": '"', "–": "-", "—": "-", "‑": "-"})


class Unit(NamedTuple):
    """One word: as the reader sees it, and where it stands in the text. ``end`` is exclusive."""

    word: str
    start: int
    end: int
    spaced: bool
    """Whether a space, or nothing at all, stands before it."""


def plain(text: str) -> str:
    """``text`` with one kind of quotes and dashes and in small letters, each character at its own place."""
    folded = (unicodedata.normalize("NFKC", letter).lower() for letter in text.translate(_PLAIN))
    return "".join(small if len(small) == 1 else letter for small, letter in zip(folded, text, strict=True))


def units(text: str) -> list[Unit]:
    """The words of ``text`` in order."""
    small = plain(text)
    return [
        Unit(found[0], found.start(), found.end(), found.start() == 0 or small[found.start() - 1].isspace())
        for found in _UNIT.finditer(small)
    ]
