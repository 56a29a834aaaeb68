"""English numbers and measures: "one and a half metres" becomes 1.5 m.

:func:`read_measures` goes once through the tokens of a sentence and replaces every number, however it is worded, by
a number token, and every number with a unit by a quantity in the unit that skills use (m, deg, s, m/s, rad/s, or
times). Words that only look like numbers ("someone", "the second room") stay as they are.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from engine.planner.text.words import Token, merged

_BELOW_TWENTY = (
    "zero one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen "
    "seventeen eighteen nineteen"
)
_SMALL = {word: value for value, word in enumerate(_BELOW_TWENTY.split())}
_TENS = {"twenty": 20, "thirty": 30, "forty": 40, "fourty": 40, "fifty": 50, "sixty": 60, "seventy": 70, "eighty": 80,
         "ninety": 90}  # fmt: skip
_SCALES = {"hundred": 100, "thousand": 1_000, "million": 1_000_000, "billion": 1_000_000_000}
_FRACTIONS = {
    "half": 1 / 2, "halves": 1 / 2,
    "quarter": 1 / 4, "quarters": 1 / 4,
    "third": 1 / 3, "thirds": 1 / 3,
    "tenth": 1 / 10, "tenths": 1 / 10,
}  # fmt: skip
_PLURAL_FRACTIONS = {word for word in _FRACTIONS if word.endswith("s")}
_ARTICLES = {"a", "an"}
_COUNTS = {"once": 1, "twice": 2, "thrice": 3}


class Unit(NamedTuple):
    """A unit as said: its dimension, named by the unit that skills use, and its size in that unit."""

    dimension: str
    factor: float


def _spellings(dimension: str, factor: float, words: str) -> dict[str, Unit]:
    return dict.fromkeys(words.split(), Unit(dimension, factor))


UNITS = {
    **_spellings("m", 1.0, "m metre metres meter meters"),
    **_spellings("m", 0.01, "cm cms centimetre centimetres centimeter centimeters"),
    **_spellings("m", 0.001, "mm millimetre millimetres millimeter millimeters"),
    **_spellings("m", 1000.0, "km kilometre kilometres kilometer kilometers"),
    **_spellings("m", 0.3048, "ft foot feet"),
    **_spellings("m", 0.0254, "inch inches"),
    **_spellings("m", 0.9144, "yd yard yards"),
    **_spellings("deg", 1.0, "deg degs degree degrees °"),
    **_spellings("deg", 180 / math.pi, "rad rads radian radians"),
    **_spellings("deg", 360.0, "turn turns rotation rotations revolution revolutions circle circles"),
    **_spellings("s", 1.0, "s sec secs second seconds"),
    **_spellings("s", 0.001, "ms millisecond milliseconds"),
    **_spellings("s", 60.0, "min mins minute minutes"),
    **_spellings("s", 3600.0, "h hour hours"),
    **_spellings("m/s", 1.0, "mps"),
    **_spellings("m/s", 1 / 3.6, "kph kmh"),
    **_spellings("m/s", 0.44704, "mph"),
    **_spellings("times", 1.0, "time times x"),
}
"""English words and international symbols."""
_WHOLE = {"full", "complete", "whole", "entire"}
_PER = {"per", "/", "a", "an", "each", "every"}
_ABBREVIATED = {"m", "s", "h", "x", "cm", "mm", "km", "ms", "ft", "yd", "min", "sec", "deg", "rad", "time"}
"""Units that "a" does not make one of: "a m" is a letter and "a time" a moment."""


@dataclass(frozen=True, slots=True)
class _Measure:
    """A quantity that was read: up to which token, how much, and in which unit it was said."""

    end: int
    value: float  # in the unit of the dimension
    unit: Unit


class _Number(NamedTuple):
    end: int
    value: float


def read_measures(tokens: Sequence[Token]) -> tuple[Token, ...]:
    """Replace spoken numbers by number tokens, and numbers with units by quantity tokens."""
    return tuple(_Reader(tokens).read())


class _Reader:
    """Recursive descent over the tokens; each method reads at an index, and returns None where it finds nothing."""

    def __init__(self, tokens: Sequence[Token]) -> None:
        self._tokens = tokens

    def read(self) -> list[Token]:
        found: list[Token] = []
        at = 0
        while at < len(self._tokens):
            first = self._tokens[at]
            if (measure := self._compound(at)) is not None:
                value = round(measure.value, 9)  # 0.1 + 0.2 is 0.3 to whoever said it
                found.append(merged(self._tokens, at, measure.end, value, measure.unit.dimension))
                at = measure.end
            elif (number := self._number(at)) is not None:
                found.append(merged(self._tokens, at, number.end, number.value, ""))
                at = number.end
            else:
                found.append(first)
                at += 1
        return found

    # Measures

    def _compound(self, at: int) -> _Measure | None:
        """``one minute and thirty seconds``, ``5 feet 6 inches``, ``a metre and a half``."""
        first = self._measure(at)
        if first is None:
            return None
        joined = self._word(first.end) == "and"
        after = first.end + joined
        second = self._measure(after)
        if second is not None:
            smaller = second.unit.dimension == first.unit.dimension and second.unit.factor < first.unit.factor
            # "one metre and twenty centimetres to the left" may be two moves; a minute and ten seconds is one wait
            if smaller and first.unit.dimension in ("m", "s") and (not joined or first.unit.dimension == "s"):
                return _Measure(second.end, first.value + second.value, first.unit)
            return first
        if joined and (half := self._fraction(after)) is not None and half.value < 1:
            return _Measure(half.end, first.value + half.value * first.unit.factor, first.unit)
        return first

    def _measure(self, at: int) -> _Measure | None:
        """A number with a unit, or a unit of which there is one (``a metre``, ``a full turn``, ``twice``)."""
        word = self._word(at)
        if word in _COUNTS:
            return _Measure(at + 1, _COUNTS[word], UNITS["times"])
        number = self._number(at)
        if number is None and (word in _ARTICLES or word == "another"):
            whole = self._word(at + 1) in _WHOLE
            unit = self._unit(at + 1)
            named = unit is not None and self._word(at + 1 + whole) not in _ABBREVIATED
            # "a turn" is a quarter to the one and a circle to the other; "a full turn" is not
            if unit is None or not named or (unit[1].factor == 360.0 and not whole):
                return None
            return _Measure(unit[0], unit[1].factor, unit[1])
        if number is not None and 0 < number.value < 1:
            number = self._of(number)  # "point six of a metre"
        if number is None or (unit := self._unit(number.end)) is None:
            return None
        return _Measure(unit[0], number.value * unit[1].factor, unit[1])

    def _unit(self, at: int) -> tuple[int, Unit] | None:
        """A unit, or a length or angle per time."""
        at += self._word(at) in _WHOLE
        unit = UNITS.get(self._word(at))
        if self._word(at) == "in" and at > 0 and self._tokens[at - 1].end == self._tokens[at].start:
            unit = UNITS["inch"]  # "5in"; with a space it is the preposition
        if unit is None:
            return None
        per = UNITS.get(self._word(at + 2)) if self._word(at + 1) in _PER else None
        if per is None or per.dimension != "s" or unit.dimension not in ("m", "deg"):
            return at + 1, unit
        if unit.dimension == "m":
            return at + 3, Unit("m/s", unit.factor / per.factor)
        return at + 3, Unit("rad/s", math.radians(unit.factor) / per.factor)

    # Numbers

    def _number(self, at: int) -> _Number | None:
        if self._word(at) in ("minus", "negative"):
            number = self._unsigned(at + 1)
            return None if number is None else number._replace(value=-number.value)
        return self._unsigned(at)

    def _unsigned(self, at: int) -> _Number | None:
        if (few := self._few(at)) is not None:
            return few
        if (fraction := self._fraction(at)) is not None:
            return self._of(fraction)
        number = self._cardinal(at)
        if number is None:
            return None
        if self._word(number.end) == "and":
            part = self._fraction(number.end + 1)
            # "one and half a turn" would be two things
            if part is not None and part.value < 1 and self._word(part.end) not in _ARTICLES:
                return _Number(part.end, number.value + part.value)
        elif (part := self._written_fraction(number.end)) is not None and number.value == int(number.value):
            return _Number(part.end, number.value + part.value)  # "1 1/2", "1½"
        return number

    def _few(self, at: int) -> _Number | None:
        article = self._word(at) in _ARTICLES
        match self._word(at + article):
            case "couple" if article:
                end = at + 2
                return _Number(end + (self._word(end) == "of"), 2)
            case "dozen":
                return _Number(at + article + 1, 12)
        return None

    def _of(self, fraction: _Number) -> _Number:
        """Skip the "of a" in ``a quarter of a metre`` and the "a" in ``half a metre``, where a unit follows; "the" is
        how recognisers hear it."""
        end = fraction.end
        end += self._word(end) == "of"
        end += self._word(end) in (*_ARTICLES, "the")
        return fraction._replace(end=end) if self._unit(end) is not None else fraction

    def _fraction(self, at: int) -> _Number | None:
        """``half``, ``a quarter``, ``three quarters``, ``1/2``, ``½``."""
        if (written := self._written_fraction(at)) is not None:
            return written
        word = self._word(at)
        if word in _ARTICLES or word == "one":
            part = self._word(at + 1)
            return _Number(at + 2, _FRACTIONS[part]) if part in _FRACTIONS.keys() - _PLURAL_FRACTIONS else None
        if word in ("half", "quarter"):
            return _Number(at + 1, _FRACTIONS[word])
        if (count := self._cardinal(at)) is not None and self._word(count.end) in _PLURAL_FRACTIONS:
            return _Number(count.end + 1, count.value * _FRACTIONS[self._word(count.end)])
        return None

    def _written_fraction(self, at: int) -> _Number | None:
        above = self._figure(at)
        if above is None:
            return None
        below = self._figure(at + 2) if self._word(at + 1) in ("/", "⁄") else None
        if below is not None and below > 0 and above < below:
            return _Number(at + 3, above / below)
        single = self._tokens[at].end - self._tokens[at].start == 1
        return _Number(at + 1, above) if single and 0 < above < 1 else None

    def _cardinal(self, at: int) -> _Number | None:
        """``twenty-five``, ``a hundred and ten``, ``two thousand``, ``3 hundred``, ``zero point three``, ``90``."""
        total, group, end, scaled = 0.0, None, at, False
        while True:
            word = self._word(end)
            if word == "and" and scaled and group is not None and self._small(end + 1) is not None:
                end += 1
            elif group is None and word in _ARTICLES and self._word(end + 1) in _SCALES:
                group, end = 1.0, end + 1
            elif (group is None or (scaled and group % 100 == 0)) and (small := self._small(end)) is not None:
                group, end, scaled = (group or 0.0) + small.value, small.end, False
            elif word == "hundred" and group is not None and group < 100:
                group, end, scaled = group * 100, end + 1, True
            elif word in _SCALES and word != "hundred" and group is not None:
                total, group, end, scaled = total + group * _SCALES[word], 0.0, end + 1, True
            else:
                break
        if group is None:
            return self._decimals(at, 0.0) if self._word(at) == "point" and self._has_unit_after_decimals(at) else None
        return self._decimals(end, total + group) or _Number(end, total + group)

    def _small(self, at: int) -> _Number | None:
        """Figures, or words below one hundred."""
        if (figure := self._figure(at)) is not None:
            return _Number(at + 1, figure)
        word = self._word(at)
        if word in _SMALL:
            return _Number(at + 1, _SMALL[word])
        if word in _TENS:
            ones = _SMALL.get(self._word(at + 1), 0)
            return _Number(at + 2, _TENS[word] + ones) if 0 < ones < 10 else _Number(at + 1, _TENS[word])
        return None

    def _decimals(self, at: int, whole: float) -> _Number | None:
        """``point two five`` after ``whole``."""
        if self._word(at) != "point":
            return None
        written, end = "", at + 1
        while True:
            word = self._word(end)
            figure = self._figure(end)
            if word in _SMALL and _SMALL[word] < 10:
                written += str(_SMALL[word])
            elif word == "oh":
                written += "0"
            elif figure is not None and figure >= 0 and figure == int(figure):
                written += str(int(figure))
            else:
                break
            end += 1
        return _Number(end, whole + float(f"0.{written}")) if written else None

    def _has_unit_after_decimals(self, at: int) -> bool:
        """Whether "point five" is a number: it is the name of a place unless a unit follows."""
        number = self._decimals(at, 0.0)
        return number is not None and (self._unit(number.end) or self._unit(self._of(number).end)) is not None

    # Tokens

    def _word(self, at: int) -> str:
        if at >= len(self._tokens) or self._tokens[at].kind != "word":
            return ""
        return self._tokens[at].text

    def _figure(self, at: int) -> float | None:
        if at >= len(self._tokens) or self._tokens[at].kind != "number":
            return None
        return self._tokens[at].value
