"""Chinese numbers and measures. unicode-rbnf, which hassil brings along, says how numbers are spelled."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from unicode_rbnf import RbnfEngine

from engine.planner.text.measures import read_measures
from engine.planner.text.words import Token, digits, words_of

SPELLING = RbnfEngine.for_language("zh")
SPELLINGS = ("spellout-numbering", "spellout-cardinal", "spellout-cardinal-alternate2")


def read(text: str) -> tuple[Token, ...]:
    return read_measures(words_of(text).tokens)


def shown(text: str) -> str:
    """The tokens as text, measures with their unit."""
    return " ".join(f"{token.text} {token.unit}" if token.unit else token.text for token in read(text))


def spaced(text: str) -> str:
    return " ".join(text)


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ("九十度", "90 deg"),
        ("90度", "90 deg"),
        ("１２０度", "120 deg"),
        ("三百六十度", "360 deg"),
        ("三六零度", "360 deg"),
        ("一弧度", f"{digits(57.29577951308232)} deg"),
        ("半圈", "180 deg"),
        ("一圈", "360 deg"),
        ("一个圈", "360 deg"),
        ("一圈半", "540 deg"),
        ("四分之一圈", "90 deg"),
        ("负九十度", "-90 deg"),
        ("两米", "2 m"),
        ("兩公尺", "2 m"),
        ("半米", "0.5 m"),
        ("一米半", "1.5 m"),
        ("一米五", "1.5 m"),
        ("一米八五", "1.85 m"),
        ("一米零五", "1.05 m"),
        ("1米5", "1.5 m"),
        ("1米05", "1.05 m"),
        ("一米二十厘米", "1.2 m"),
        ("0.5米", "0.5 m"),
        ("０．５米", "0.5 m"),
        ("零点五米", "0.5 m"),
        ("一点二五米", "1.25 m"),
        ("一又二分之一米", "1.5 m"),
        ("百分之五十", "0.5"),
        ("三十厘米", "0.3 m"),
        ("三十cm", "0.3 m"),
        ("50公分", "0.5 m"),
        ("3百米", "300 m"),
        ("一公里", "1000 m"),
        ("十秒", "10 s"),
        ("十秒钟", "10 s"),
        ("两分钟", "120 s"),
        ("一分半", "90 s"),
        ("一分三十秒", "90 s"),
        ("五分钟三十秒", "330 s"),
        ("半个小时", "1800 s"),
        ("一个半小时", "5400 s"),
        ("两次", "2 times"),
        ("三下", "3 times"),
        ("十遍", "10 times"),
        ("每秒零点五米", "0.5 m/s"),
        ("0.5米每秒", "0.5 m/s"),
        ("0.5米/秒", "0.5 m/s"),
        ("每秒0.5m", "0.5 m/s"),
        ("每秒钟九十度", "1.570796 rad/s"),
        ("时速3.6公里", "1 m/s"),
        ("一百五", "150"),
        ("一万二", "12000"),
        ("一二〇", "120"),
    ],
)
def test_a_measure_is_read_in_the_units_of_skills(said: str, meant: str) -> None:
    assert shown(said) == meant


@pytest.mark.parametrize(
    "said",
    [
        "看一下", "一起", "一直", "一点点", "第一", "万一", "千万", "四周", "十分慢", "十字路口", "二维码", "一个盒子",
        "一边", "一会儿", "看一看", "巡逻一圈", "三四米", "两三秒", "半天", "百", "几米", "慢一点", "十几米",
    ],
)  # fmt: skip
def test_words_that_only_look_like_numbers_and_rough_ones_stay_words(said: str) -> None:
    assert shown(said) == spaced(said)


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ("一米五次", "1 m 5 times"),
        ("三号", "3 号"),
        ("3号块", "3 号 块"),
        ("托盘二", "托 盘 2"),
        ("五秒后", "5 s 后"),
        ("一号转到45度", "1 号 转 到 45 deg"),
        ("一百零", "一 百 0"),
        ("两个半圈", "2 个 180 deg"),
        ("转90度2次", "转 90 deg 2 times"),
    ],
)
def test_what_may_be_two_things_is_not_made_one(said: str, meant: str) -> None:
    assert shown(said) == meant


def test_every_number_below_ten_thousand_is_read_as_itself() -> None:
    for number in range(10_000):
        spelled = SPELLING.format_number(number).text_by_ruleset
        for said in {spelled[spelling] for spelling in SPELLINGS}:
            assert shown(said) == str(number), said


@settings(deadline=None)
@given(st.integers(min_value=0, max_value=999_999_999), st.sampled_from(SPELLINGS))
def test_every_large_number_is_read_as_itself(number: int, spelling: str) -> None:
    (token,) = read(SPELLING.format_number(number).text_by_ruleset[spelling])
    assert (token.kind, token.value) == ("number", number)


@settings(deadline=None)
@given(st.decimals(min_value=0, max_value=9999, places=2).map(float), st.sampled_from(["米", "度", "秒", "厘米"]))
def test_a_decimal_keeps_its_value_however_it_is_written(value: float, unit: str) -> None:
    written = digits(value)
    whole, _, decimals = written.partition(".")
    spelled = SPELLING.format_number(int(whole)).text_by_ruleset["spellout-cardinal"]
    spelled += f"点{''.join('零一二三四五六七八九'[int(figure)] for figure in decimals)}" if decimals else ""
    wide = written.translate(str.maketrans("0123456789.", "０１２３４５６７８９．"))
    for said in (written, spelled, wide):
        (token,) = read(f"{said}{unit}")
        assert token.kind == "quantity"
        assert token.value == pytest.approx(value * (0.01 if unit == "厘米" else 1), abs=1e-8)


@settings(deadline=None)
@given(st.text(alphabet="零一二两三四五十百千万半点分之又负米度秒圈次个每/号0.5９", max_size=25))
def test_any_heap_of_numerals_is_read_in_order_and_to_the_end(text: str) -> None:
    tokens = read(text)
    assert [token.start for token in tokens] == sorted(token.start for token in tokens)
    assert all(before.end <= after.start for before, after in pairwise(tokens))
    assert not tokens or tokens[-1].end == words_of(text).tokens[-1].end
