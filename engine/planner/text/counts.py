"""Conditions on how many there are: "if there are two boxes on the table, beep twice".

A look tells which things of the house are there, each known by its name; so as many can be counted as have names of
their own ("red box" and "blue box" are two boxes). Of things that share a name nobody knows how many were seen.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

from engine.planner.text.language import alternatives, load

_NUMBERS: Final = {
    "two": 2, "three": 3, "four": 4, "five": 5, "six": 6, "both": 2, "2": 2, "3": 3, "4": 4, "5": 5, "6": 6,
    "one": 1, "a single": 1, "1": 1, "两": 2, "二": 2, "三": 3, "四": 4, "五": 5,
}  # fmt: skip
_HOW: Final[Mapping[str, Callable[[int, int], bool]]] = {
    "at least": operator.ge, "": operator.ge, "no fewer than": operator.ge, "至少": operator.ge,
    "more than": operator.gt, "超过": operator.gt,
    "exactly": operator.eq, "only": operator.eq, "just": operator.eq, "只": operator.eq, "正好": operator.eq,
    "fewer than": operator.lt, "less than": operator.lt, "不到": operator.lt,
    "at most": operator.le, "no more than": operator.le, "最多": operator.le,
}  # fmt: skip
_ZH: Final = re.compile(
    r"(?P<how>至少|超过|只|正好|不到|最多)?有(?P<how_too>至少|超过|不到|最多)?(?P<number>[两二三四五])[个只块瓶杯件]"
)


@dataclass(frozen=True, slots=True)
class Count:
    """How many there have to be."""

    how: Callable[[int, int], bool]
    number: int

    def holds(self, names: Sequence[str], sees: Callable[[str], bool]) -> bool:
        """Whether as many of the things of these names are there."""
        return self.how(sum(map(sees, names)), self.number)


def at_least(number: int) -> Count:
    """So many or more."""
    return Count(operator.ge, number)


def counted(text: str) -> tuple[str, Count] | None:
    """``text`` as a condition on one of them, and how many there have to be; None where nothing is counted."""
    if (found := _english().search(text)) is not None:
        one = _singular()[found["many"].casefold()]
        if not found["how"] and _NUMBERS[found["number"].casefold()] == 1:
            return None
        article = "an" if (found["rest"] or one)[0] in "aeiou" else "a"
        there = "is there" if found["is"].casefold().startswith(("is", "are")) else "there is"
        plain = f"{text[: found.start()]}{there} {article} {found['rest']}{one}{text[found.end() :]}"
        return plain, Count(_HOW[(found["how"] or "").casefold()], _NUMBERS[found["number"].casefold()])
    if (zh := _ZH.search(text)) is not None:
        how = zh["how"] or zh["how_too"] or ""
        return f"{text[: zh.start()]}有{text[zh.end() :]}", Count(_HOW[how], _NUMBERS[zh["number"]])
    return None


def how_many(words: str) -> tuple[str, Count] | None:
    """What is counted in a noun phrase, and how many there have to be: "at least two cups"; None where nothing is."""
    found = _AMOUNT.fullmatch(words.casefold().strip(" ,.!?;:，。！？"))
    if found is None or (not (how := found["how"] or found["how_zh"] or "") and _NUMBERS[found["number"]] == 1):
        return None
    return found["rest"], (
        at_least(_NUMBERS[found["number"]]) if found["more"] else Count(_HOW[how], _NUMBERS[found["number"]])
    )


_AMOUNT: Final = re.compile(
    rf"(?:(?P<how>{'|'.join(sorted((how for how in _HOW if how.isascii() and how), key=len, reverse=True))}) |"
    r"(?P<how_zh>至少|超过|只|正好|不到|最多)有?)?"
    rf"(?P<number>{'|'.join(sorted(_NUMBERS, key=len, reverse=True))})(?P<more> or more)?"
    r"(?: (?:of )?(?:the |my |those |these )?|[个只块瓶杯件把张本])(?P<rest>.+)"
)


@lru_cache
def _english() -> re.Pattern[str]:
    hows = alternatives(how for how in _HOW if how.isascii() and how)
    return re.compile(
        r"\b(?P<is>there are|there is|there's|are there|is there|you see|you find|you can see) "
        rf"(?:(?P<how>{hows}) )?(?P<number>{alternatives(n for n in _NUMBERS if n.isascii())}) "
        rf"(?P<rest>(?:[a-z]+ )?)(?P<many>{alternatives(_singular())})\b",
        re.IGNORECASE,
    )


@lru_cache
def _singular() -> Mapping[str, str]:
    """Words for several things, and for one of them."""
    things = load("en")["things"]
    many = {said: kind for kind, words in things["many"].items() for said in words}
    return {**many, **{said: kind for kind, words in things["one"].items() for said in words}, "apples": "apple"}
