"""Conditions on how many there are: "if there are two boxes on the table, beep twice".

A look tells which things of the house are there, each known by its name; so as many can be counted as have names of
their own ("red box" and "blue box" are two boxes). Of things that share a name nobody knows how many were seen.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

_NUMBERS: Final = {
    "two": 2, "three": 3, "four": 4, "five": 5, "six": 6, "both": 2, "2": 2, "3": 3, "4": 4, "5": 5, "6": 6,
    "one": 1, "a single": 1, "1": 1, "两": 2, "二": 2, "三": 3, "四": 4, "五": 5, "一": 1,
}  # fmt: skip
_HOW: Final[Mapping[str, Callable[[int, int], bool]]] = {
    "at least": operator.ge, "": operator.ge, "no fewer than": operator.ge, "至少": operator.ge,
    "more than": operator.gt, "超过": operator.gt, "多于": operator.gt, "不止": operator.gt,
    "exactly": operator.eq, "only": operator.eq, "just": operator.eq, "只": operator.eq, "正好": operator.eq,
    "fewer than": operator.lt, "less than": operator.lt, "不到": operator.lt,
    "at most": operator.le, "no more than": operator.le, "最多": operator.le,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Count:
    """How many there have to be."""

    how: Callable[[int, int], bool]
    number: int

    def holds(self, names: Sequence[str], sees: Callable[[str], bool]) -> bool:
        """Whether as many of the things of these names are there."""
        return self.fits(sum(map(sees, names)))

    def fits(self, number: int) -> bool:
        """Whether that are as many."""
        return self.how(number, self.number)


def at_least(number: int) -> Count:
    """So many or more."""
    return Count(operator.ge, number)


def how_many(words: str) -> tuple[str, Count] | None:
    """What is counted in a noun phrase, and how many there have to be: "at least two cups"; None where nothing is."""
    found = _AMOUNT.fullmatch(words.casefold().strip(" ,.!?;:，。！？"))
    if found is None or (not (how := found["how"] or found["how_zh"] or "") and _NUMBERS[found["number"]] == 1):
        return None
    return found["rest"], (
        at_least(_NUMBERS[found["number"]])
        if found["more"] or found["or_more"]
        else Count(_HOW[how], _NUMBERS[found["number"]])
    )


def is_amount(words: str) -> bool:
    """Whether they say how many, and not of what: "at least two"."""
    return _AMOUNT.fullmatch(f"{words.casefold().strip()} x") is not None or (
        _AMOUNT.fullmatch(f"{words.strip()}x") is not None and not words.isascii()
    )


_AMOUNT: Final = re.compile(
    rf"(?:(?P<how>{'|'.join(sorted((how for how in _HOW if how.isascii() and how), key=len, reverse=True))}) |"
    r"(?P<how_zh>至少|超过|多于|不止|只|正好|不到|最多)有?)?"
    rf"(?P<number>{'|'.join(sorted(_NUMBERS, key=len, reverse=True))})(?P<more> or more)?"
    r"(?: (?:of )?(?:the |my |those |these )?|[个只块瓶杯件把张本])(?P<rest>.+?)(?P<or_more> or more)?"
)
