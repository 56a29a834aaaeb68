"""All that a plan may draw on: what was said in this task, what was seen, what is known, and the words of the house."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Final

from engine.errors import PlanError
from engine.planner.grounding.statement import Statement
from engine.skills.vocabulary import Vocabulary

_OPEN: Final = re.compile(
    r"\b(?:whatever|everything|anything|all|any|every|each|both|what|which|whichever|things that|rest|others|clean|"
    r"tidy|clear|sort|line|mess)\b"
    r"|所有|全部|一切|每|任何|什么|都|打扫|收拾|整理"
)
_EVERYWHERE: Final = re.compile(
    r"\b(?:every|all|each|everywhere|whole|entire|patrol|rounds?|house|flat|apartment|rooms|anywhere|somewhere)\b|"
    r"每个|所有|到处|整个|巡逻|各个|全部"
)


@dataclass(frozen=True, slots=True)
class Grounds:
    """``said`` is what the user said, newest last."""

    said: tuple[Statement, ...]
    seen: tuple[Statement, ...]
    known: tuple[Statement, ...]
    vocabulary: Vocabulary

    @property
    def newest(self) -> Statement:
        """What was said last."""
        return self.said[-1] if self.said else Statement("")

    def everything(self) -> tuple[Statement, ...]:
        """What was said, seen and is known."""
        return (*self.said, *self.seen, *self.known)

    def says(self, pattern: re.Pattern[str]) -> bool:
        """Whether the user said what the pattern finds."""
        return any(pattern.search(statement.text) for statement in self.said)

    def says_symbol(self, symbol: str) -> bool:
        """Whether the user named a place by its letter."""
        return any(statement.says_symbol(symbol) for statement in self.said)

    def asks_for_whatever(self) -> bool:
        """Whether things were left open on purpose: "whatever you find"."""
        return self.says(_OPEN)

    def asks_for_everywhere(self) -> bool:
        """The same of places: "go to every room"."""
        return self.says(_EVERYWHERE)

    def names(self, value: str, words: Iterable[str], resolve: Callable[[str], str]) -> bool:
        """Whether one of ``words`` was said, seen or is known, and is resolved to ``value``."""
        statements = self.everything()
        words = (*words, *((value,) if len(value) > 1 else ()))  # a letter may be an article
        return any(
            any(statement.says(word) for statement in statements) and resolved(resolve, word) == value for word in words
        )


def resolved(resolve: Callable[[str], str], word: str) -> str | None:
    """What a word means; None where it means nothing."""
    try:
        return resolve(word)
    except PlanError:
        return None
