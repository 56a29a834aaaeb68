"""Words as recognisers and hurried typists write them: "turn write", "go too the book shelf".

Each reading is what the same sounds mean in a command. It counts only where it makes one.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Final

from engine.planner.readings.corrections import LONGEST
from engine.planner.text.language import load
from engine.skills.vocabulary import Vocabulary

_DRAWN_OUT: Final = re.compile(r"([aeiou])\1{2,}", re.IGNORECASE)


class Misheard:
    """Knows the names of one house."""

    def __init__(self, vocabulary: Vocabulary) -> None:
        names = {name for name in (*vocabulary.names(), *vocabulary.places()) if name.isascii()}
        self._whole = {name: re.compile(_apart(name), re.IGNORECASE) for name in names if name.isalpha()}
        joined = {name.replace(" ", ""): name for name in names if " " in name}
        self._apart = {re.compile(rf"\b{re.escape(run)}\b", re.IGNORECASE): name for run, name in joined.items()}

    def meant(self, text: str) -> Iterator[str]:
        """What was meant; nothing where it was written so."""
        if len(text) > LONGEST:
            return
        heard = _DRAWN_OUT.sub(r"\1", text)
        for pattern, word in _homophones().items():
            heard = pattern.sub(word, heard)
        for name, pattern in self._whole.items():
            heard = pattern.sub(name, heard)
        for pattern, name in self._apart.items():
            heard = pattern.sub(name, heard)
        if heard != text:
            yield heard


def _apart(name: str) -> str:
    """Finds a name that was cut in two anywhere: "book shelf"."""
    return "|".join(rf"\b{name[:at]}[ -]{name[at:]}\b" for at in range(3, len(name) - 2)) or r"(?!)"


@lru_cache
def _homophones() -> Mapping[re.Pattern[str], str]:
    sections: Mapping[str, str] = load("en")["homophones"]
    return {re.compile(rf"\b{re.escape(heard)}\b", re.IGNORECASE): meant for heard, meant in sections.items()}
