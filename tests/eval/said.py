"""Whether what a plan names was said: its numbers, in whichever unit, and its things, by whichever word.

Nothing here knows what is right; it only finds arguments that come from nowhere.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from typing import Final

from engine.perception.naming import CHINESE, KINDS
from tests.eval.effects import Effect, Step, Value, Words, effects

_ONES: Final = (
    "zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve",
    "thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen",
)  # fmt: skip
_UNITS: Final = {word: n for n, word in enumerate(_ONES)}
_TENS: Final = {
    "twenty": 20, "thirty": 30, "forty": 40, "fifty": 50, "sixty": 60, "seventy": 70, "eighty": 80, "ninety": 90,
}  # fmt: skip
_PARTS: Final = {
    "half": 0.5, "quarter": 0.25, "third": 1 / 3, "tenth": 0.1, "once": 1, "twice": 2, "double": 2, "thrice": 3,
    "couple": 2, "dozen": 12, "半": 0.5,
}  # fmt: skip
_A: Final = re.compile(r"\ban? (?:single |whole |full )?(?:met|cent|deg|min|sec|hundred|turn|rev|half|quarter|third)")
_HAN: Final = {sign: float(n) for n, sign in enumerate("零一二三四五六七八九")} | {"两": 2.0}
_SCALES: Final = (1.0, 0.01, 0.001, 60.0, 90.0, 180.0, 360.0, 57.29577951308232)
"""From what was said to m, s and deg: cm, mm, minutes, turns, radians."""
_TURNS: Final = (90.0, 180.0, 360.0)
"""What a turn comes to when nobody says how far."""
_PACES: Final = (0.1, 0.2, 0.3, 0.5, 2.0)
"""What a speed may be when nobody says it, m/s or rad/s."""
_IN_TIME: Final = re.compile("second|sec\\b|minute|秒|分钟")


def numbers_in(text: str) -> frozenset[float]:
    """Every number that the words may stand for, in SI units and degrees, and their products."""
    plain = list(dict.fromkeys(_numbers(text.casefold())))[:12]
    found = {number * scale for number in plain for scale in _SCALES}
    found |= {one * two * scale for one, two in product(plain, plain) for scale in _SCALES}
    found |= {one + two for one, two in product(plain, plain)}
    if _IN_TIME.search(text.casefold()):
        found |= {number * pace for number in tuple(found) for pace in _PACES} | set(_PACES)
    return frozenset({*found, *_TURNS, 0.0})


def _numbers(text: str) -> Iterator[float]:
    yield from (float(digits.replace(",", ".")) for digits in re.findall(r"\d+(?:[.,]\d+)?", text))
    words = re.findall(r"[a-z]+|[零一二三四五六七八九十百两半]", text)
    yield from (_PARTS[word] for word in words if word in _PARTS)
    yield from (1.0 for _ in _A.finditer(text))
    yield from _composed(words)
    yield from _composed_han(text)


def _composed(words: Sequence[str]) -> Iterator[float]:
    total: float | None = None
    digits = ""
    for word in (*words, ""):
        if word in _UNITS or word in _TENS:
            number = float(_UNITS.get(word, _TENS.get(word, 0)))
            digits = f"{digits}{number:g}"
            total = (total or 0) + number
            yield number
        elif word in ("hundred", "thousand"):
            total = (total or 1) * (100 if word == "hundred" else 1000)
        elif word == "point":
            yield from (() if total is None else (total,))
            total, digits = None, f"{total or 0:g}."
        elif word != "and" or total is None:
            yield from (() if total is None else (total,))
            if digits and digits not in ".":
                yield float(digits if digits.count(".") < 2 else "0")
            total, digits = None, ""


def _composed_han(text: str) -> Iterator[float]:
    for run in re.findall(r"[零一二三四五六七八九十百两点]+", text):
        whole, _, part = run.partition("点")
        total, digit = 0.0, 0.0
        for sign in whole:
            if sign in "十百":
                total += (digit or 1) * (10 if sign == "十" else 100)
                digit = 0
            else:
                digit = _HAN.get(sign, digit)
        yield total + digit + sum(_HAN.get(sign, 0) * 10.0**-n for n, sign in enumerate(part, 1))
    for one, more in re.findall("([一二三四五六七八九两])米([一二三四五六七八九半])", text):  # one metre five
        yield _HAN[one] + (0.5 if more == "半" else _HAN[more] / 10)


def ungrounded(
    steps: Iterable[Step], said: str, inventory: Iterable[str], words: Words, *, wanted: Iterable[Effect] = ()
) -> tuple[str, ...]:
    """Arguments of a plan that were neither said nor are those of an acceptable plan (``wanted``)."""
    numbers = numbers_in(said)
    given = tuple(wanted)
    things = frozenset(thing for thing in inventory if _is_said(thing, said))
    right = [thing for effect in given if effect.what in _OF_THINGS for thing in _meant(effect.args[0], words)]
    found = []
    for effect in effects(steps, words):
        if effect.what in _OF_THINGS:
            if not words.things(str(effect.args[0])) & {*things, *right} and not _is_said(str(effect.args[0]), said):
                found.append(f"{effect.what} {effect.args[0]}")
        elif effect.what in _MEASURED:
            allowed = (*numbers, *(v for e in given if e.what == effect.what for v in e.args if not isinstance(v, str)))
            if not all(_close(value, allowed) for value in effect.args if not isinstance(value, str)):
                found.append(f"{effect.what} {', '.join(f'{v:g}' for v in effect.args if not isinstance(v, str))}")
    return tuple(found)


_OF_THINGS: Final = frozenset({"find", "near", "pick"})
_MEASURED: Final = frozenset({"turn", "drive", "slide", "wait", "velocity", "servo1_move", "apriltag_remove_higher",
                              "color_remove_higher", "apriltag_sort", "apriltag_follow"})  # fmt: skip
_NONE_SAID: Final = -1.0
"""The number of a tag that nobody has said."""


def _close(value: float, allowed: Iterable[float]) -> bool:
    return value == _NONE_SAID or any(abs(abs(value) - abs(n)) <= max(0.011, 0.02 * abs(n)) for n in allowed)


def _meant(value: Value, words: Words) -> frozenset[str]:
    return frozenset().union(*(words.things(part) for part in str(value).split("|")))


def _is_said(thing: str, said: str) -> bool:
    """Whether the words of a thing's name were said: the colour too where it has one, and any word for its kind."""
    text = said.casefold()
    english = " ".join((text, *(f" {meant} " for word, meant in CHINESE.items() if word in text)))
    heard = set(re.findall(r"[a-z]+|\d+", english)) | {text}
    heard |= {form for word in tuple(heard) for form in (word.removesuffix("s"), word.removesuffix("es"))}
    heard |= {KINDS[word] for word in tuple(heard) if word in KINDS}
    heard |= {str(_UNITS[word]) for word in tuple(heard) if word in _UNITS}
    parts = [part for part in re.findall(r"[^\W\d_]+|\d+", thing.casefold()) if part != "thing"]
    return all(part in heard or KINDS.get(part) in heard or (not part.isascii() and part in text) for part in parts)
