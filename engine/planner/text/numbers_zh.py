"""Chinese numbers and measures: 一米五 becomes 1.5 m, 半圈 becomes 180 degrees.

:func:`read_measures` goes once through the tokens of a sentence, in which each character is a token, and does what
``engine.planner.text.numbers`` does for English; figures and international symbols (90°, 0.5 m/s) have been read there.
Characters that only look like numbers (一下, 一起, 四周, 十分) stay as they are.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Final, NamedTuple

from engine.han import is_chinese
from engine.planner.text.numbers import UNITS, Unit
from engine.planner.text.words import Token, merged

_DIGITS: Final = {char: value for value, char in enumerate("零一二三四五六七八九")} | {"〇": 0, "两": 2}
_SCALES: Final = {"十": 10, "百": 100, "千": 1_000}
_GREAT: Final = {"万": 10_000, "亿": 100_000_000}

"""Characters that numbers are written with."""

_NO_NUMBERS: Final = re.compile(
    r"""
      一(?:[下起样直边会些切定旦般同共块只瓶张把条颗枚件罐支段曲首部番路旁侧前后来去到看两面方]
         |点(?![零一二三四五六七八九]) | 个(?!半?(?:小时|钟头)|整?圈) | 整(?!圈))
    | (?<=[第统同唯逐单])一
    | (?<=[看走点摇拍挥转停跳等说试])一(?=[看走点摇拍挥转停跳等说试])
    | (?<=[逻视走跑绕逛看])一圈
    | 二维 | 两[边侧旁三面者] | 三(?:角|[两四五](?![十百千零])) | 四(?:[周处面方]|五(?![十百千零]))
    | 五(?:角|六(?![十百千零])) | 七八 | 十(?:分(?![钟之])|字|几) | 八字
    | (?<![零一二两三四五六七八九十百千万])(?:千万|万[能万一物])
    """,
    re.VERBOSE,
)
"""Words that are written with a numeral and are none, and rough numbers (三四米), which nobody can drive."""


def _spellings(dimension: str, factor: float, words: str) -> dict[str, Unit]:
    return dict.fromkeys(words.split(), Unit(dimension, factor))


_UNITS: Final = {
    **_spellings("m", 1.0, "米 公尺"),
    **_spellings("m", 0.1, "分米"),
    **_spellings("m", 0.01, "厘米 公分"),
    **_spellings("m", 0.001, "毫米"),
    **_spellings("m", 1000.0, "公里 千米"),
    **_spellings("m", 0.3048, "英尺"),
    **_spellings("m", 0.0254, "英寸"),
    **_spellings("deg", 1.0, "度 角度"),
    **_spellings("deg", 180 / math.pi, "弧度"),
    **_spellings("deg", 360.0, "圈 周 整圈 整周 个圈 个整圈"),
    **_spellings("s", 1.0, "秒 秒钟"),
    **_spellings("s", 0.001, "毫秒"),
    **_spellings("s", 60.0, "分钟"),
    **_spellings("s", 3600.0, "小时 个小时 钟头 个钟头"),
    **_spellings("times", 1.0, "次 下 遍 回 声 趟"),
}
_SHORT_MINUTE: Final = Unit("s", 60.0)
"""分 is a minute where seconds or 半 follow: 一分三十秒."""
_LONGEST_UNIT: Final = max(map(len, _UNITS))
_TEMPI: Final = {"每秒": 1.0, "每秒钟": 1.0, "每分钟": 60.0, "每小时": 3600.0, "时速": 3600.0}


class _Number(NamedTuple):
    end: int
    value: float


class _Measure(NamedTuple):
    end: int
    value: float  # in the unit of the dimension
    unit: Unit


def read_measures(tokens: Sequence[Token]) -> tuple[Token, ...]:
    """Replace Chinese numerals by number tokens, and numbers with units by quantity tokens."""
    if not any(token.kind == "word" and is_chinese(token.text) for token in tokens):
        return tuple(tokens)
    return tuple(_Reader(tokens).read())


class _Reader:
    """Recursive descent over the tokens; each method reads at an index, and returns None where it finds nothing."""

    def __init__(self, tokens: Sequence[Token]) -> None:
        self._tokens = tokens
        # one character for each token, so that places in the text are places in the sequence
        self._text = "".join(t.text if t.kind == "word" and len(t.text) == 1 else "\0" for t in tokens)
        self._words = {at for match in _NO_NUMBERS.finditer(self._text) for at in range(*match.span())}

    def read(self) -> list[Token]:
        found: list[Token] = []
        at = 0
        while at < len(self._tokens):
            first = self._tokens[at]
            if (measure := self._tempo(at) or self._compound(at)) is not None:
                value = round(measure.value, 9)
                found.append(merged(self._tokens, at, measure.end, value, measure.unit.dimension))
                at = measure.end
            elif first.kind != "number" and (number := self._number(at)) is not None:
                found.append(merged(self._tokens, at, number.end, number.value, ""))
                at = number.end
            else:
                found.append(first)
                at += 1
        return found

    # Measures

    def _tempo(self, at: int) -> _Measure | None:
        """``每秒零点五米``, ``三十度每秒``, ``0.5米/秒``."""
        for tempo, seconds in sorted(_TEMPI.items(), reverse=True):  # 每秒钟 before 每秒
            if self._text.startswith(tempo, at):
                measure = self._measure(at + len(tempo))
                return None if measure is None else _per(measure, seconds)
        measure = self._measure(at)
        if measure is None or self._text[measure.end : measure.end + 1] not in ("每", "/"):
            return None
        per = self._unit(measure.end + 1)
        return None if per is None or per[1].dimension != "s" else _per(measure._replace(end=per[0]), per[1].factor)

    def _compound(self, at: int) -> _Measure | None:
        """``一米五``, ``一圈半``, ``一分三十秒``, ``一米二十厘米``."""
        first = self._measure(at) or self._minutes(at)
        if first is None or first.unit.dimension == "times":
            return first
        if self._text[first.end : first.end + 1] == "半":
            end = first.end + 1
            end += self._text[end : end + 1] == "钟"
            return first._replace(end=end, value=first.value + first.unit.factor / 2)
        second = self._measure(first.end)
        if second is not None:
            smaller = second.unit.dimension == first.unit.dimension and second.unit.factor < first.unit.factor
            return second._replace(value=first.value + second.value, unit=first.unit) if smaller else first
        if first.unit == _UNITS["米"] and first.value == int(first.value):
            return self._tenths(first)
        return first

    def _tenths(self, metres: _Measure) -> _Measure:
        """``一米五``, ``1米85``: figures right behind the unit are its decimals."""
        end, decimals = metres.end, ""
        while self._text[end : end + 1] in _DIGITS and end not in self._words:
            decimals += str(_DIGITS[self._text[end]])
            end += 1
        if not decimals and end < len(self._tokens) and self._tokens[end].kind == "number":
            token = self._tokens[end]
            width = token.end - token.start
            if len(token.text) <= width <= 2 and token.text.isdigit() and token.start == self._tokens[end - 1].end:
                decimals, end = token.text.zfill(width), end + 1
        if not 0 < len(decimals) <= 2 or self._text[end : end + 1] in (*_SCALES, "号", "个", "点"):
            return metres
        return metres._replace(end=end, value=metres.value + float(f"0.{decimals}"))

    def _minutes(self, at: int) -> _Measure | None:
        number = self._number(at)
        if number is None or self._text[number.end : number.end + 1] != "分":
            return None
        end = number.end + 1
        seconds = self._measure(end)
        followed = self._text[end : end + 1] == "半" or (seconds is not None and seconds.unit == _UNITS["秒"])
        return _Measure(end, number.value * _SHORT_MINUTE.factor, _SHORT_MINUTE) if followed else None

    def _measure(self, at: int) -> _Measure | None:
        """A number with a unit; also what has been read as a quantity already."""
        if (
            at < len(self._tokens)
            and self._tokens[at].kind == "quantity"
            and self._tokens[at].unit in ("m", "deg", "s")
        ):
            token = self._tokens[at]
            return _Measure(at + 1, token.value, Unit(token.unit, 1.0))
        number = self._number(at)
        if number is None:
            return self._half(at)
        if self._text.startswith("个半", number.end) and (unit := self._unit(number.end + 2)) is not None:
            # 一个半小时 is ninety minutes, but 两个半圈 may be two halves
            hours = unit[1] == _UNITS["小时"]
            return _Measure(unit[0], (number.value + 0.5) * unit[1].factor, unit[1]) if hours else None
        unit = self._unit(number.end)
        return None if unit is None else _Measure(unit[0], number.value * unit[1].factor, unit[1])

    def _half(self, at: int) -> _Measure | None:
        """``半米``, ``半个小时``, ``半圈``."""
        if self._text[at : at + 1] != "半":
            return None
        unit = self._unit(at + 1)
        if unit is None or unit[1].dimension == "times":
            return None
        return _Measure(unit[0], unit[1].factor / 2, unit[1])

    def _unit(self, at: int) -> tuple[int, Unit] | None:
        for length in range(_LONGEST_UNIT, 0, -1):
            said = self._text[at : at + length]
            if said in _UNITS:
                return at + len(said), _UNITS[said]
        word = self._tokens[at].text if at < len(self._tokens) and self._tokens[at].kind == "word" else ""
        return (at + 1, UNITS[word]) if word in UNITS else None  # 三十cm, 二m

    # Numbers

    def _number(self, at: int) -> _Number | None:
        if self._text[at : at + 1] == "负":
            number = self._unsigned(at + 1)
            return None if number is None else number._replace(value=-number.value)
        return self._unsigned(at)

    def _unsigned(self, at: int) -> _Number | None:
        if at in self._words:
            return None
        number = self._cardinal(at)
        if number is None:
            return self._parts_of(at + 2, 100.0) if self._text.startswith("百分之", at) else None
        if self._text.startswith("分之", number.end):
            return self._parts_of(number.end, number.value)
        if self._text[number.end : number.end + 1] == "又" and number.value == int(number.value):
            part = self._cardinal(number.end + 1)
            fraction = None if part is None else self._parts_of(part.end, part.value)
            if fraction is not None:
                return fraction._replace(value=number.value + fraction.value)
        return number

    def _parts_of(self, at: int, whole: float) -> _Number | None:
        """``分之三`` behind ``whole``."""
        # behind 百 stands 分之 as it does behind any number, but 百 alone is none
        above = self._cardinal(at + (2 if self._text.startswith("分之", at) else 1))
        return None if above is None or whole <= 0 else above._replace(value=above.value / whole)

    def _cardinal(self, at: int) -> _Number | None:
        """``九十``, ``一百零五``, ``一百五``, ``两万三千``, ``零点五``, ``一二〇``, ``3百``, ``90``."""
        if (figures := self._figures(at)) is not None:
            return self._decimals(figures)
        total, group, digit, end, scale = 0.0, 0.0, None, at, 0.0
        while end < len(self._tokens) and (end == at or end not in self._words):
            char, figure = self._text[end], self._figure(end)
            if digit is None and (figure is not None or char in _DIGITS):
                digit = figure if figure is not None else float(_DIGITS[char])
                if digit == 0 and end > at:  # the 零 of 一百零五 says that a place is empty
                    digit, scale = None, 10.0
                    if self._text[end + 1 : end + 2] not in _DIGITS and self._text[end + 1 : end + 2] != "十":
                        return None
            elif char in _SCALES and (digit is not None or (char == "十" and group % 100 == 0)):
                group, digit, scale = group + (1.0 if digit is None else digit) * _SCALES[char], None, _SCALES[char]
            elif char in _GREAT and (digit is not None or group):
                myriads = group + (digit or 0.0)
                total = (total + myriads) * _GREAT[char] if char == "亿" else total + myriads * _GREAT[char]
                group, digit, scale = 0.0, None, float(_GREAT[char])
            else:
                break
            end += 1
        if end == at:
            return None
        ones = 0.0 if digit is None else digit
        if scale > 10 and 0 < ones < 10 and self._text[end - 2] in {**_SCALES, **_GREAT}:
            ones *= scale / 10  # 一百五 is 150
        return self._decimals(_Number(end, total + group + ones))

    def _figures(self, at: int) -> _Number | None:
        """Digits one by one: ``一二〇``, ``九零``; two that are no round number are rough (三四米)."""
        end = at
        while self._text[end : end + 1] in _DIGITS and end not in self._words:
            end += 1
        said = "".join(str(_DIGITS[char]) for char in self._text[at:end])
        if len(said) < 2 or (len(said) == 2 and said[1] != "0") or self._text[end : end + 1] in {**_SCALES, **_GREAT}:
            return None
        return _Number(end, float(said)) if len(said) <= 6 else None

    def _decimals(self, number: _Number) -> _Number:
        """``点二五`` behind a whole number."""
        end = number.end + 1
        written = ""
        if self._text[number.end : end] != "点" or number.value != int(number.value):
            return number
        while self._text[end : end + 1] in _DIGITS:
            written += str(_DIGITS[self._text[end]])
            end += 1
        if not written and (figure := self._figure(end)) is not None and figure == int(figure) >= 0:
            written, end = str(int(figure)), end + 1
        return _Number(end, number.value + float(f"0.{written}")) if written else number

    def _figure(self, at: int) -> float | None:
        if at >= len(self._tokens) or self._tokens[at].kind != "number":
            return None
        return self._tokens[at].value


def _per(measure: _Measure, seconds: float) -> _Measure | None:
    """A length or angle in so many seconds."""
    match measure.unit.dimension:
        case "m":
            return measure._replace(value=measure.value / seconds, unit=Unit("m/s", 1.0))
        case "deg":
            return measure._replace(value=math.radians(measure.value) / seconds, unit=Unit("rad/s", 1.0))
    return None
