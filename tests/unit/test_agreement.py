"""Which words of a growing transcript are certain."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from engine.asr.agreement import Agreement, first_words, words_of


def test_words_are_certain_once_two_answers_agree_on_them_from_the_first_on() -> None:
    agreement = Agreement()
    texts = ["Go.", "Go to the kit", "Go to the kitchen and", "Go to the kitchen and come back."]
    assert [agreement.add(text) for text in texts] == [0, 1, 3, 5]


def test_capitals_and_full_stops_are_no_disagreement() -> None:
    agreement = Agreement()
    agreement.add("go to the kitchen.")
    assert agreement.add("Go to the kitchen, then") == 4


def test_a_word_that_turns_out_to_be_another_one_takes_those_after_it_along() -> None:
    agreement = Agreement()
    agreement.add("pick up the red box")
    assert agreement.add("pick up the bread box") == 3


def test_every_chinese_character_is_a_word() -> None:
    agreement = Agreement()
    agreement.add("去厨房。")
    assert agreement.add("去厨房看看") == 3
    assert words_of("去kitchen看看") == ["去", "kitchen", "看", "看"]
    assert first_words("去厨房看看", 3) == "去厨房"


@given(st.lists(st.text(max_size=40), max_size=4))
def test_no_more_words_are_certain_than_there_are(texts: list[str]) -> None:
    agreement = Agreement()
    for text in texts:
        assert 0 <= agreement.add(text) <= len(words_of(text))


@given(st.text(max_size=60), st.integers(0, 20))
def test_the_first_words_of_a_text_are_its_beginning(text: str, count: int) -> None:
    beginning = first_words(text, count)
    assert text.startswith(beginning)
    assert len(words_of(beginning)) == min(count, len(words_of(text)))
