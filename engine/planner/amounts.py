"""How much, how often, how fast: what the words of a role come to, in the units of skills."""

from __future__ import annotations

import re
from typing import Final

from engine.planner.conventions import A_BIT, A_BIT_OF_A_TURN, FULL, HALF, QUARTER, Manner
from engine.planner.text.measures import read_measures
from engine.planner.text.words import words_of

_A_BIT: Final = re.compile(
    r"(?:just |only )?(?:a (?:little|tiny|wee|small|teeny)?\s*(?:bit|tad|touch|little|smidge|smidgen|step|nudge)|"
    r"(?:little|tiny|wee|small|teeny) (?:bit|step|nudge)|(?:a )?(?:little|bit|tad)|slightly|"
    r"a few (?:cm|centimet(?:re|er)s))(?: (?:more|further))?|一点[点儿]?|一丁点儿?|一小点儿?|一些|一小步|稍微|一丢丢"
)
_AND_SO_MUCH: Final = re.compile(r"\bmet(?:re|er)s? ([a-z-]+|\d\d?)$")
_MUCH: Final = re.compile(r"\b(?:far|lots?|long|way|much|length|same|as|until|all|many|few|further|more|less|half)\b")
_ANGLES: Final[tuple[tuple[re.Pattern[str], float], ...]] = (
    (re.compile(r"three quarters|四分之三"), QUARTER + HALF),
    (re.compile(r"quarter|四分之一|直角|right angle"), QUARTER),
    (re.compile(r"half|半圈|半周|about face|一百八"), HALF),
    (re.compile(r"full|whole|all the way|complete|once (?:a)?round|circle|一圈|一整圈|整圈|一周"), FULL),
)
_SLOW: Final = re.compile(
    r"slow|gentl|careful|crawl|snail|tiptoe|inch by inch|"
    r"half (?:the |your )?(?:normal )?speed|easy|unhurried|leisur|creep|"
    r"慢|轻|小心|缓|半速|一半的?速度"
)
_FAST: Final = re.compile(
    r"fast|quick|speed|zoom|dash|zip|rush|asap|"
    r"hurr|rapid|swift|brisk|full (?:speed|throttle)|possible|快|迅速|全速|急|赶紧"
)
_COUNTS: Final = {
    "once": 1,
    "one time": 1,
    "twice": 2,
    "thrice": 3,
    "a couple of times": 2,
    "a couple times": 2,
    "一次": 1,
    "两次": 2,
    "俩": 2,
}
_TIMES_ZH: Final = re.compile(r"([一二两三四五六七八九十\d]+)(?:次|遍|下|回|圈|声)")
_NUMERALS: Final = {"一": 1, "二": 2, "两": 2, "三": 3, "四": 4, "五": 5, "六": 6, "七": 7, "八": 8, "九": 9, "十": 10}


def quantity(words: str, unit: str) -> float | None:
    """The first amount in this unit that the words hold: "half a metre" is 0.5 m."""
    tokens = read_measures(words_of(_A_SEC.sub("a second", words)).tokens)
    return next((token.value for token in tokens if token.kind == "quantity" and token.unit == unit), None)


_A_SEC: Final = re.compile(r"\ba sec\b", re.IGNORECASE)


def unit_in(words: str) -> str:
    """The unit of an amount as it is said: "centimetres" of "twenty centimetres"; empty where there is none."""
    found = re.search(r"[^\W\d_]+$", words.strip())
    said = found[0] if found is not None else ""
    ends = (said[-length:] for length in range(len(said), 0, -1))
    return next((end for end in ends if _is_unit(end)), "")


def _is_unit(word: str) -> bool:
    """Whether it is one, and no amount itself."""
    return any(quantity(word, unit) is None and quantity(f"2 {word}", unit) is not None for unit in UNITS)


UNITS: Final = ("m", "deg", "s", "m/s")
"""Those in which skills measure."""


def number(words: str) -> float | None:
    """The first bare number that the words hold."""
    tokens = read_measures(words_of(words).tokens)
    return next((token.value for token in tokens if token.kind == "number"), None)


def distance(words: str) -> float | None:
    """m; None where the words tell none."""
    found = quantity(words, "m")
    if found is not None and (more := _AND_SO_MUCH.search(words.casefold())) and (small := number(more[1])) is not None:
        return found + small / 100 if 0 < small < 100 else found  # "one metre twenty"
    return A_BIT if found is None and _is_a_bit(words.casefold().strip()) else found


def _is_a_bit(plain: str) -> bool:
    """Whether it is no amount but a little: "a hair", "ever so slightly"."""
    counted = any(token.kind in ("number", "quantity") for token in read_measures(words_of(plain).tokens))
    told = plain and plain.isascii() and not counted and _MUCH.search(plain) is None
    return bool(told) or _A_BIT.fullmatch(plain) is not None


def angle(words: str) -> float | None:
    """deg, positive; a number alone counts as degrees. None where the words tell none."""
    words = re.sub(r"^(?=(?:hundred|thousand)\b)", "a ", words.strip(), flags=re.IGNORECASE)
    found = quantity(words, "deg")
    if found is None:
        found = number(words)
    if found is None:
        found = next((degrees for pattern, degrees in _ANGLES if pattern.search(words.casefold())), None)
    if found is None and (count := _COUNTS.get(words.casefold().strip())) is not None:
        found = FULL * count
    return found


def turn(words: str) -> float | None:
    """As :func:`angle`, of a turn to a side, which may be a little one."""
    found = angle(words)
    return A_BIT_OF_A_TURN if found is None and _A_BIT.fullmatch(words.casefold().strip()) else found


def times(words: str) -> int | None:
    """How often; None where the words tell no whole number."""
    plain = words.casefold().strip()
    if plain in _COUNTS:
        return _COUNTS[plain]
    found = quantity(words, "times") or number(words)
    if found is None and (zh := _TIMES_ZH.search(plain)) is not None:
        found = _NUMERALS.get(zh[1])
    return int(found) if found is not None and found == int(found) and found >= 1 else None


def manner(words: str) -> Manner | None:
    """Slow or fast, where the words say so."""
    plain = words.casefold()
    if _SLOW.search(plain):
        return "slow"
    return "fast" if _FAST.search(plain) else None
