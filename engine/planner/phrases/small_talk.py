"""Answers to small talk: "hello", "how are you", "well done". Nothing moves.

That something is small talk, or a question to which the robot knows no answer, the learned reader says; here a few
words decide which sentence is the answer (``talk`` in assets/phrases).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, Final

ASIDE: Final = "Aside"
UNKNOWN: Final = "Unknown"


class SmallTalk:
    """Knows the small talk of one language. Thread-safe."""

    def __init__(self, sections: Mapping[str, Any]) -> None:
        self._kinds = tuple((kind, _pattern(words)) for kind, words in sections["talk"].items())
        self._answers: Mapping[str, str] = sections["answers"]["talk"]

    def answer(self, text: str, *, asks: bool = False) -> str:
        """The answer to ``text``; ``asks``: it is a question, also where it is not written as one."""
        plain, asks = _plain(text), asks or text.rstrip().endswith(("?", "？"))
        kind = next((kind for kind, words in self._kinds if words.search(plain)), UNKNOWN if asks else ASIDE)
        return self._answers[kind]

    def only(self, text: str) -> str:
        """The answer to ``text`` where its words are those of one kind, and no others; else empty."""
        kind = next((kind for kind, words in self._kinds if words.fullmatch(_plain(text))), "")
        return self._answers[kind] if kind else ""


def _plain(text: str) -> str:
    return " ".join(re.sub(r"[^\w']+", " ", text.casefold().replace("’", "'")).split())


def _pattern(words: Sequence[str]) -> re.Pattern[str]:
    """Any of the words; nothing separates those of Chinese."""
    return re.compile("|".join(rf"\b{re.escape(word)}\b" if word.isascii() else re.escape(word) for word in words))
