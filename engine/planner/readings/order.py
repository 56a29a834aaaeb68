"""Steps that are not told in the order in which they are to be done: "before you go to the kitchen, turn around".

Each reading is the same request as a plain sequence ("turn around, then go to the kitchen"). Where the one step ends
and the other begins nobody says, so that each place is only a proposal: whoever asks knows which one makes commands.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Final

from engine.planner.readings.corrections import QUOTES, bare
from engine.planner.readings.verb_forms import ordered
from engine.planner.request import Language

_YOU: Final = r"(?:you(?:'?ve| have|'re| are)? )?(?:just )?(?:(?:finished|done|completed) (?=\w+ing\b))?"
_AFTER: Final = r"(?:(?:but |and )?(?:only |right |just |straight )?(?:after|once|as soon as|when))"
_BEFORE: Final = r"(?:(?:but )?(?:right |just )?(?:before|prior to))"
_EN: Final = tuple(
    re.compile(pattern, re.IGNORECASE)
    for pattern in (
        rf"(?:(?P<head>.+?)[,;. ]+(?:and |then )?)?\b{_AFTER} {_YOU}(?P<one_two>.+)",
        rf"(?:(?P<head>.+?)[,;. ]+(?:and |then )?)?\b{_BEFORE} {_YOU}(?P<two_one>.+)",
        rf"(?P<two>.+?),? {_AFTER} {_YOU}(?P<one>.+)",
        rf"(?P<one>.+?),? {_BEFORE} {_YOU}(?P<two>.+)",
        r"(?P<two>.+?),? (?:but|and) (?:first|before that|beforehand|before you do(?: that| so| this)?),? (?P<one>.+)",
        r"(?P<two>.+?),? (?:but|and) (?P<one>.+?),? (?:first|before that|beforehand|before you (?:go|start|leave|move|"
        r"set (?:off|out)|do(?: that| so)?))",
        r"(?:don'?t|do not|never) (?P<two>.+?),? (?:until|till|before|unless) (?:you(?:'?ve| have)? )(?P<one>.+)",
        r"(?P<two>.+?),? (?:but )?(?:before that|first of all),? (?P<one>.+)",
        r"(?P<two>.+?),? (?:but |and )?on (?:the|your) way(?: there| over)?,? (?P<one>(?!to |into |back|from |home).+)",
        r"on (?:your|the) way (?:over |back )?(?P<way_one>(?:to|into) .+)",
        r"(?P<one>.+?),? on (?:your|the) way (?:over |back )?(?P<way>(?:to|into) .+)",
        r"(?:instead of|rather than) (?P<not_one>.+)",
        r"leave (?P<not>.+?) alone(?:,| and|, and) (?P<one>.+)",
        r"(?:forget|skip|ignore|never mind) (?:about )?(?P<not>(?:the|my) .+?)(?:,| and|, and) (?P<one>.+)",
        r"(?P<one>.+?),? (?:instead of|rather than) (?P<not>.+)",
    )
)
_ZH: Final = tuple(
    re.compile(pattern)
    for pattern in (
        r"(?:在|等)?你?(?P<two>.+?)(?:之前|以前)[，,]?(?:请|你)?(?:先)?(?P<one>.+)",
        r"(?:在|等)?你?(?P<one>.+?)(?:之后|以后)[，,]?(?:请|你)?(?:再|就)?(?P<two>.+)",
        r"(?P<two>.+?)[，,]?(?:但是|但|不过)?(?:在此)?(?:之前|前)?(?:要)?先(?P<one>.+)",
        r"去(?P<way>.+?)的路上[，,]?(?:顺便)?(?P<one>.+)",
        r"(?:不要|别|不用)(?P<not>.+?)[，,](?:而是|改成|改为)?(?P<one>.+)",
    )
)
_BREAK: Final = re.compile(r"[,;.]+ ?(?:and |then |please )*|(?: and then| and| then)? ")
"""Where one step may end and the other begin, those with punctuation before the others."""
_THING: Final = re.compile(r"(?:the|a|an|it|them|my)\b(?!')", re.IGNORECASE)


def in_order(text: str, language: Language) -> Iterator[str]:
    """What ``text`` asks for as a plain sequence, in every way that it may be cut; nothing where it is one already."""
    plain = bare(text)
    if QUOTES.search(plain):
        return
    for pattern in _EN if language == "en" else _ZH:
        if (found := pattern.fullmatch(plain)) is not None:
            parts = {name: part for name, part in found.groupdict().items() if part}
            yield from _sequences(parts, "" if language == "en" else "zh")


def _sequences(parts: Mapping[str, str], chinese: str) -> Iterator[str]:
    head = parts.get("head", "")
    for whole, (first, second) in _CUTS.items():
        if whole in parts:
            for before, after in _cut(parts[whole]):
                yield from _sequences({"head": head, first: before, second: after}, chinese)
            return
    one, two, way = (parts.get(name, "") for name in ("one", "two", "way"))
    if chinese:
        yield "，然后".join(step for step in (one, two or (f"去{way}" if way else "")) if step)
    else:
        steps = (head, _as_command(one), _as_command(two) or (f"go {way}" if way else ""))
        yield ", then ".join(step for step in steps if step)


_CUTS: Final[Mapping[str, tuple[str, str]]] = {
    "one_two": ("one", "two"), "two_one": ("two", "one"), "way_one": ("way", "one"), "not_one": ("not", "one")
}  # fmt: skip
"""Parts that hold two steps, and which ones."""


def _cut(text: str) -> Iterator[tuple[str, str]]:
    """Every way to cut a text into two steps."""
    breaks = sorted(_BREAK.finditer(text), key=lambda found: found[0][0] == " ")
    for found in breaks:
        before, after = text[: found.start()], text[found.end() :]
        if before and after:
            yield before, after


def _as_command(step: str) -> str:
    """A step as somebody would order it: "dropped the ball" is "drop the ball"."""
    return ordered(f"pick up {step}" if _THING.match(step) else step)  # "once you have the box"
