"""Words for people: whom they mean, and whether somebody is it."""

from __future__ import annotations

import contextlib
import datetime
from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from config.schema import KnownPerson
from engine.facts import fact
from engine.perception.sighting import Colour
from engine.perception.someone import Gender, Someone, UnknownPerson, someone
from engine.robot.company import Gesture, Posture
from engine.skills.people import People
from engine.skills.with_people import name_told


@pytest.mark.parametrize(
    ("words", "means"),
    [
        ("William", "William"), ("the person waving", "person waving"), ("the man in the red shirt", "man in red"),
        ("a woman", "woman"), ("the person raising their left arm", "person raising the left arm"),
        ("a person lying down", "person lying down"), ("who points to the right", "person pointing to the right"),
        ("anna", "Anna"), ("the lady with blue trousers", "woman with blue trousers"), ("everyone", "person"),
        ("the boy wearing a yellow t-shirt and black jeans", "man in yellow with black trousers"),
        ("穿红衣服的人", "person in red"), ("正在挥手的女士", "woman waving"), ("坐着的人", "person sitting"),
        ("举左手的人", "person raising the left arm"), ("威廉", "威廉"),
    ],
)  # fmt: skip
def test_whom_words_mean(words: str, means: str) -> None:
    assert str(someone(words)) == means


@given(
    st.builds(
        Someone,
        name=st.just(""),
        gender=st.sampled_from((None, *get_args(Gender))),
        posture=st.sampled_from((None, *get_args(Posture))),
        gesture=st.sampled_from((None, *get_args(Gesture))),
        shirt=st.sampled_from((None, *get_args(Colour))),
        trousers=st.sampled_from((None, *get_args(Colour))),
    )
)
def test_what_is_told_of_somebody_is_read_as_the_same(who: Someone) -> None:
    assert someone(str(who)) == who


@given(st.text(max_size=40))
def test_whatever_is_said_is_somebody_or_nobody_known(words: str) -> None:
    with contextlib.suppress(UnknownPerson):
        assert isinstance(someone(words), Someone)


def test_people_are_known_by_all_their_names() -> None:
    people = People({"William": KnownPerson(aliases=("Bill", "威廉")), "Anna": KnownPerson()})
    assert [str(people.who(words)) for words in ("bill", "威廉", "the William")] == ["William"] * 3
    assert not people.is_stranger(people.who("Anna"))
    assert people.is_stranger(people.who("Robin"))
    with pytest.raises(UnknownPerson, match="Do you mean William"):
        people.who("Williem")
    told: list[str] = []
    people.on_added = lambda name, person: told.append(name)
    people.add("Robin", KnownPerson(shirt="orange"))
    people.add("Anna", KnownPerson(shirt="yellow"))
    assert told == ["Robin", "Anna"]
    assert people.about("Anna").shirt == "yellow"


@pytest.mark.parametrize(
    ("answer", "expected", "name"),
    [("I am Robin.", "", "Robin"), ("Yes.", "Robin", "Robin"), ("No, I am Mary.", "Robin", "Mary"),
     ("My name is Skyler", "", "Skyler"), ("Robin", "", "Robin"), ("I do not know.", "Robin", ""), ("No.", "Robin", ""),
     ("我叫小明", "", "小明"), ("我是Michael。", "", "Michael"), ("", "Robin", "")],
)  # fmt: skip
def test_the_name_in_an_answer(answer: str, expected: str, name: str) -> None:
    assert name_told(answer, expected) == name


NOW = datetime.datetime(2026, 11, 27, 14, 5)


@pytest.mark.parametrize(
    ("words", "answer"),
    [("the time", "It is 14:05."), ("what day is today", "It is Friday today."),
     ("what day is tomorrow", "It is Saturday tomorrow."), ("the day of the week", "It is Friday today."),
     ("the day of the month", "It is November the 27th today."), ("现在几点", "现在是14点05分。"),
     ("今天是这个月的几号", "今天是11月27日。"), ("明天是几号", "明天是11月28日。"),
     ("今天星期几", "今天是星期五。"), ("your name", "I am called sayso."), ("dinner is ready", ""), ("", "")],
)  # fmt: skip
def test_what_it_knows_without_looking(words: str, answer: str) -> None:
    assert fact(words, NOW) == answer
