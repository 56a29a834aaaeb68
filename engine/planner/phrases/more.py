"""More of the last motion, told by a number: "ten more", "another 30 degrees", 再来二十.

What drove, turned, waited or beeped last does so once more, as far as the number says. A number without a unit has the
one that was spoken of; only where that can hardly be meant (ten more metres, after one) it stays open which one it is.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import copysign
from typing import Final

from engine.plan import MAX_ACTIONS, ActionCall, Quantity
from engine.planner.phrases.said import Calls
from engine.planner.text.measures import read_measures
from engine.planner.text.numbers_zh import NUMERALS
from engine.planner.text.words import Token, digits, words_of

MOST_M: Final = 5.0
"""Metres that a bare number may mean."""
_MORE: Final = frozenset({"more", "another", "further", "extra", "additional", "再", "还", "又"})
_IDLE: Final = frozenset(
    {"and", "now", "then", "just", "please", "okay", "ok", "yes", "go", "on", "for", "do", "来", "要"}
)


@dataclass(frozen=True, slots=True)
class _Way:
    """How a skill is measured."""

    unit: str
    usual: str
    """The unit that is meant where none was spoken of."""
    verbs: frozenset[str]
    """What it may be called."""


_DRIVES: Final = _Way("m", "metres", frozenset({"move", "drive", "走", "开", "进", "退"}))
_TURNS: Final = _Way("deg", "degrees", frozenset({"turn", "rotate", "转"}))
_WAYS: Final[Mapping[str, _Way]] = {
    "move_forward": _DRIVES,
    "move_sideways": _DRIVES,
    "move_left": _TURNS,
    "move_right": _TURNS,
    "wait": _Way("s", "seconds", frozenset({"wait", "等"})),
    "beep": _Way("times", "times", frozenset({"beep", "beeps", "times", "叫", "声", "下"})),
}
_SPOKEN_UNIT: Final = re.compile(rf"(?:(?![{NUMERALS}])[^\W\d_])+$")


def more(text: str, before: Calls, said: str) -> Calls | None:
    """The actions that ``text`` asks for after what was done ``before`` and the ``said`` request for it; nothing where
    it is open in which unit, and None where ``text`` asks for no such thing."""
    last = before[-1] if before else ActionCall("")
    way = _WAYS.get(last.name)
    words = [token for token in words_of(text).tokens if token.kind != "mark"]
    if way is None or not any(word.text in _MORE for word in words):
        return None
    told = read_measures([word for word in words if word.text not in _MORE | _IDLE | way.verbs])
    if len(told) != 1 or told[0].kind not in ("number", "quantity") or told[0].value <= 0:
        return None
    measure = told[0] if told[0].kind == "quantity" or way.unit == "times" else _measured(told[0], way, said)
    if measure.kind == "quantity" and measure.unit != way.unit:
        return None
    if told[0].kind == "number" and way is _DRIVES and measure.value > MOST_M:
        return ()
    if way.unit == "times":
        return (last,) * min(round(measure.value), MAX_ACTIONS + 1)
    old = last.positional[0]
    assert isinstance(old, Quantity)
    again = Quantity(copysign(measure.value, old.value), way.unit)
    return (replace(last, positional=(again, *last.positional[1:])),)


def _measured(number: Token, way: _Way, said: str) -> Token:
    """A bare number in the unit that was spoken of last."""
    spoken = [token for token in read_measures(words_of(said).tokens) if token.unit == way.unit]
    unit = _SPOKEN_UNIT.search(said[spoken[-1].start : spoken[-1].end]) if spoken else None
    told = read_measures(words_of(f"{digits(number.value)} {unit[0] if unit is not None else way.usual}").tokens)
    return told[0] if len(told) == 1 else read_measures(words_of(f"{digits(number.value)} {way.usual}").tokens)[0]
