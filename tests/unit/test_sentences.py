"""A text is said sentence by sentence, word by word, and none of it is lost or said twice."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.tts.sentences import LONGEST, Sentence, sentences
from engine.tts.synthesis import Piece, Said, Timing

TEXTS = st.one_of(
    st.text(max_size=300),
    st.lists(st.sampled_from(["red", "0.50", "m", "-90°", "and", "厨房", "，", "。", ".", " ", "a_b", "x" * 90])).map(
        "".join
    ),
    st.lists(st.sampled_from(["the", "box,", "is", "1.00 m", "away.", "我在厨房。", "—", "why?!"])).map(" ".join),
)


def said(text: str) -> list[str]:
    return [sentence.joined()[0] for sentence in sentences(text)]


@given(TEXTS)
def test_every_character_that_is_no_space_belongs_to_one_word_in_order(text: str) -> None:
    ends = [word.end for sentence in sentences(text) for word in sentence.words]
    assert all(a < b for a, b in pairwise([0, *ends]))
    assert not text[ends[-1] if ends else 0 :].strip()
    for begin, end in pairwise([0, *ends]):
        assert text[begin:end].strip()
        assert text[begin:end].rstrip() == text[begin:end]


@given(st.text(st.sampled_from("a1m-.` 厨\ud83d\udcc3"), max_size=100))
def test_whatever_is_said_can_be_sent_to_a_voice(text: str) -> None:
    for sentence in sentences(text):
        assert sentence.joined()[0].isprintable()  # which half a character is not
    ends = [word.end for sentence in sentences(text) for word in sentence.words]
    assert not text[ends[-1] if ends else 0 :].strip()


@given(TEXTS)
def test_no_sentence_is_long_unless_one_word_is(text: str) -> None:
    begin = 0
    for sentence in sentences(text):
        assert sentence.words
        end = sentence.words[-1].end
        assert len(text[begin:end].strip()) <= LONGEST or len(sentence.words) == 1
        begin = end


@given(TEXTS)
def test_each_word_is_where_the_sentence_says_it_is(text: str) -> None:
    for sentence in sentences(text):
        spoken, begins = sentence.joined()
        assert len(begins) == len(sentence.words)
        for begin, word in zip(begins, sentence.words, strict=True):
            assert spoken[begin : begin + len(word.said)] == word.said


@pytest.mark.parametrize(
    ("text", "spoken"),
    [
        ("", []),
        (" \n ", []),
        ("Stopped.", ["Stopped."]),
        ("I am at x 0.60 m. Moved 1.00 m forward.", ["I am at x 0.6 metres.", "Moved 1 metre forward."]),
        ("Turned -90° at 0.3 m/s!", ["Turned minus 90 degrees at 0.3 metres per second!"]),
        ("move_forward(1) is `done`", ["move forward(1) is done"]),
        ("Wait 2.5 s, then go.", ["Wait 2.5 seconds, then go."]),
        ("我在厨房。离桌子 0.50 m。", ["我在厨房。", "离桌子 0.5 米。"]),
        ("前进-1m？好", ["前进负1 米？", "好"]),
        ("Going to 厨房 now.", ["Going to 厨房 now."]),
        ("It is 3 m", ["It is 3 metres"]),
        ("Room m is small", ["Room m is small"]),
        ("Going to caf\udcc3 now.", ["Going to caf? now."]),
        ("Version 1.2.3 of e.g. this", ["Version 1.2.3 of e.g.", "this"]),
    ],
)
def test_what_is_said_of_a_text(text: str, spoken: list[str]) -> None:
    assert said(text) == spoken


def test_a_long_answer_begins_with_a_short_sentence_so_that_it_sounds_soon() -> None:
    text = (
        "The red box is on the workbench in the study, and the blue cup is on the low table in the living room next to "
        "the door, while the yellow ball lies on the floor of the kitchen"
    )
    parts = said(text)
    assert len(parts) >= 3
    assert len(parts[0]) < 60
    assert " ".join(parts) == text


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("I see a red box 0.6 m ahead on the coffee table, and two cups.", "I see a red box 0.6 metres ahead,"),
        ("The red box is on the workbench in the study of the house.", "The red box is on the workbench,"),
        ("The red box is on the workbench in the study.", "The red box is on the workbench in the study."),
        ("I looked for it in the kitchen, in the hall and in the study.", "I looked for it in the kitchen,"),
        ("I looked everywhere in the house and found nothing.", "I looked everywhere in the house,"),
        ("Ich habe das Wort Donaudampfschifffahrtsgesellschaft gesagt.", None),
    ],
)
def test_the_first_sentence_is_cut_where_one_breathes_and_sounds_as_if_it_goes_on(text: str, first: str | None) -> None:
    parts = said(text)
    assert parts[0] == (first or text)
    assert parts[-1].endswith(".")
    assert [part[-1] for part in parts[:-1]] == [","] * (len(parts) - 1)


def test_a_cut_adds_nothing_to_the_words_that_were_heard() -> None:
    text = "I looked everywhere in the house and found nothing."
    ends = [word.end for sentence in sentences(text) for word in sentence.words]
    assert [text[:end].split()[-1] for end in ends] == text.split()


def test_chinese_sentences_are_known_as_such() -> None:
    assert [sentence.chinese for sentence in sentences("Hello. 你好。 Going to 厨房.")] == [False, True, True]


# Which words have been said


def a_sentence(text: str) -> Sentence:
    [sentence] = sentences(text)
    return sentence


def test_a_voice_that_knows_when_words_end_is_believed() -> None:
    timing = Timing(a_sentence("one two three four"))
    timing.add(Piece(np.ones(16_000, np.int16), 16_000, (Said(1, 0.2), Said(3, 0.5), Said(4, 1.0))))
    assert [timing.said(at) for at in (0.0, 0.19, 0.2, 0.49, 0.5, 0.99, 1.0)] == [0, 0, 1, 1, 3, 3, 4]


def test_without_that_knowledge_a_word_lasts_as_long_as_it_is_and_silence_at_the_end_says_nothing() -> None:
    timing = Timing(a_sentence("a abcdefghi"))
    sound = np.concatenate((np.full(16_000, 8000, np.int16), np.zeros(16_000, np.int16)))
    timing.add(Piece(sound, 16_000))
    timing.finish()
    assert timing.said(0.09) == 0
    assert timing.said(0.11) == 1
    assert timing.said(0.9) == 1
    assert timing.said(1.0) == 2


@given(TEXTS, st.lists(st.integers(1, 8000), min_size=1, max_size=5), st.floats(0, 3))
def test_what_is_thought_to_be_said_only_grows_and_is_never_all_before_the_sound_is_there(
    text: str, lengths: list[int], at: float
) -> None:
    for sentence in sentences(text):
        timing = Timing(sentence)
        for length in lengths:
            timing.add(Piece(np.full(length, 1000, np.int16), 8000))
            assert timing.said(at) < len(sentence.words)
        timing.finish()
        counts = [timing.said(moment) for moment in np.linspace(0, sum(lengths) / 8000, 20)]
        assert counts == sorted(counts)
        assert counts[-1] == len(sentence.words)
