"""Verbs as people tell of steps ("having dropped it", "by turning"), and as they order them."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

from engine.planner.text.language import load


def ordered(step: str) -> str:
    """A step as somebody would order it: "dropped the ball" and "dropping the ball" are "drop the ball"."""
    forms = _forms()
    words = step.split(" ")
    for count in (2, 1):
        if (verb := forms.get(" ".join(words[:count]).casefold())) is not None:
            return " ".join((verb, *words[count:]))
    return step


@lru_cache
def _forms() -> Mapping[str, str]:
    sections = load("en")
    return {**sections["doing"], **sections["done"]}
