"""Numbers and measures in every language at once: a Chinese sentence may hold 0.5 m/s, a place be called room two."""

from __future__ import annotations

from collections.abc import Sequence

from engine.planner.text import numbers, numbers_zh
from engine.planner.text.words import Token, words_of

_UNITS = {"m": " m", "deg": " degrees", "s": " s", "m/s": " m/s", "rad/s": " rad/s"}


def read_measures(tokens: Sequence[Token]) -> tuple[Token, ...]:
    """Replace spoken numbers by number tokens, and numbers with units by quantity tokens."""
    return numbers_zh.read_measures(numbers.read_measures(tokens))


def in_figures(text: str) -> str:
    """``text`` with its numbers and measures in figures and basic units: ``go twenty centimetres`` is ``go 0.2 m``."""
    told, at = "", 0
    for token in read_measures(words_of(text).tokens):
        figures = f"{token.value:g}{_UNITS.get(token.unit, '')}"
        if token.kind == "quantity" and token.unit in _UNITS:
            told, at = f"{told}{text[at : token.start]}{figures}", token.end
    return told + text[at:]
