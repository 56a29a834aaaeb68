"""Spoken numbers and measures. unicode-rbnf, which hassil brings along, says how numbers are spelled."""

import math
import re
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from unicode_rbnf import RbnfEngine

from engine.planner.text.numbers import read_measures
from engine.planner.text.words import Token, digits, words_of

SPELLING = RbnfEngine.for_language("en")


def read(text: str) -> tuple[Token, ...]:
    return read_measures(words_of(text).tokens)


def shown(text: str) -> str:
    """The tokens as text, measures with their unit."""
    return " ".join(f"{token.text} {token.unit}" if token.unit else token.text for token in read(text))


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ("half a metre", "0.5 m"),
        ("point six of a metre", "0.6 m"),
        ("half of a meter", "0.5 m"),
        ("half the meter", "0.5 m"),
        ("a half metre", "0.5 m"),
        ("one and a half metres", "1.5 m"),
        ("1 and a half metres", "1.5 m"),
        ("two and three quarters metres", "2.75 m"),
        ("a metre and a half", "1.5 m"),
        ("a quarter of a metre", "0.25 m"),
        ("two thirds of a turn", "240 deg"),
        ("1/2 m", "0.5 m"),
        ("1 1/2 m", "1.5 m"),
        ("1½ m", "1.5 m"),
        ("½ metre", "0.5 m"),
        ("zero point three metres", "0.3 m"),
        ("two point oh five metres", "2.05 m"),
        ("point five metres", "0.5 m"),
        ("ninety degrees", "90 deg"),
        ("twenty-five degrees", "25 deg"),
        ("a hundred and eighty degrees", "180 deg"),
        ("three hundred sixty degrees", "360 deg"),
        ("90°", "90 deg"),
        ("1 radian", f"{digits(math.degrees(1))} deg"),
        ("a quarter turn", "90 deg"),
        ("half a turn", "180 deg"),
        ("a full turn", "360 deg"),
        ("two full turns", "720 deg"),
        ("10cm", "0.1 m"),
        ("1.5m", "1.5 m"),
        (".5 m", "0.5 m"),
        ("1,5 m", "1.5 m"),
        ("1,500 m", "1500 m"),
        ("0,500 m", "0.5 m"),
        ("1,234,567 mm", "1234.567 m"),
        ("three feet", "0.9144 m"),
        ("5 feet 6 inches", "1.6764 m"),
        ("5in", "0.127 m"),
        ("two yards", "1.8288 m"),
        ("a couple of metres", "2 m"),
        ("a million metres", "1000000 m"),
        ("minus two metres", "-2 m"),
        ("-2 m", "-2 m"),
        ("move -2 m", "move -2 m"),
        ("move −0.5 m", "move -0.5 m"),  # U+2212, the minus sign that recognisers and phones write
        ("０.５ m", "0.5 m"),
        ("half a minute", "30 s"),
        ("an hour and a half", "5400 s"),
        ("one minute and thirty seconds", "90 s"),
        ("1 minute 30", "60 s 30"),
        ("a second", "1 s"),
        ("0.2 metres per second", "0.2 m/s"),
        ("20 cm/s", "0.2 m/s"),
        ("half a radian per second", "0.5 rad/s"),
        ("180 degrees a second", f"{digits(math.pi)} rad/s"),
        ("3.6 km/h", "1 m/s"),
        ("once", "1 times"),
        ("twice", "2 times"),
        ("three times", "3 times"),
        ("a couple of times", "2 times"),
    ],
)
def test_a_measure_is_read_in_the_units_of_skills(said: str, meant: str) -> None:
    assert shown(said) == meant


@pytest.mark.parametrize(
    "said",
    [
        "someone",
        "the second room",
        "a turn",
        "go in",
        "that many times",
        "the quarterdeck",
        "point",
        "hundred",
        "a m",
        "your feet",
        "a few metres",
        "1.2.3",
        "9999999999999999999999",
    ],
)
def test_words_that_only_look_like_numbers_stay_words(said: str) -> None:
    assert shown(said) == said


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ("1 m and 20 cm to the left", "1 m and 0.2 m to the left"),
        ("one metre and half a turn", "1 m and 180 deg"),
        ("one and turn", "1 and turn"),
        ("one two 3", "1 2 3"),
        ("three sixty degrees", "3 60 deg"),
        ("go 5-3", "go 5 3"),
        ("go to point five", "go to point 5"),
        ("room two", "room 2"),
        ("minus minus two m", "minus -2 m"),
    ],
)
def test_what_may_be_two_things_is_not_made_one(said: str, meant: str) -> None:
    assert shown(said) == meant


@settings(deadline=None)
@given(st.integers(min_value=0, max_value=999_999_999))
def test_every_spelled_number_is_read_as_itself(number: int) -> None:
    american = SPELLING.format_number(number).text_by_ruleset["spellout-cardinal"]
    british = re.sub("hundred (?!thousand|million)", "hundred and ", american)
    for words in (american, british):
        (token,) = read(words)
        assert (token.kind, token.value) == ("number", number)


@settings(deadline=None)
@given(st.decimals(min_value=0, max_value=100_000, places=3).map(float), st.sampled_from(["m", " m", " metres", "m "]))
def test_a_written_decimal_keeps_its_value(value: float, unit: str) -> None:
    (token,) = read(f"{digits(value)}{unit}")
    assert (token.kind, token.unit) == ("quantity", "m")
    assert token.value == pytest.approx(value, abs=1e-9)


def test_a_measure_remembers_where_it_was_said() -> None:
    sentence = words_of("Go FORWARD one and a half metres, please")
    measure = next(token for token in read_measures(sentence.tokens) if token.kind == "quantity")
    assert sentence.part([measure]) == "one and a half metres"


@settings(deadline=None)
@given(st.text(max_size=300))
def test_any_text_is_read_without_an_error_and_keeps_its_order(text: str) -> None:
    tokens = read(text)
    assert all(before.end <= after.start for before, after in pairwise(tokens))
    assert all(math.isfinite(token.value) for token in tokens)


HEAP = (
    "a an one two nine ten twenty hundred thousand million and point half quarter quarters of minus metres per "
    "second 1 0.5 / times"
)


@settings(deadline=None)
@given(st.lists(st.sampled_from(HEAP.split()), max_size=40).map(" ".join))
def test_any_heap_of_number_words_is_read_without_an_error(text: str) -> None:
    assert all(math.isfinite(token.value) for token in read(text))
