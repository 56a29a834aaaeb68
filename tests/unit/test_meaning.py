"""What a request means, and how meanings are written."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.understanding.acts import ACTS
from engine.understanding.meaning import About, Do, If, Meaning, Not, Repeat, Retract, meaning_of
from engine.understanding.notation import NotationError, Step, read, roles_of, write
from engine.understanding.symbols import DONE, MAX_STEPS, ROLE_NAMES, Grammar
from engine.understanding.units import plain, units

SENTENCES = Path(__file__).parents[2] / "assets" / "understanding" / "sentences"


def meant(line: str) -> Meaning:
    example = read(line)
    return meaning_of(example.text, example.steps)


def acts(meaning: Meaning) -> list[str]:
    return [node.act for node in meaning.wanted() if isinstance(node, Do)]


def test_each_role_knows_its_words_and_where_they_stand() -> None:
    meaning = meant("bring | fetch {person: me} {thing: the red cup} off {source: the shelf}")
    act = meaning.nodes[0]
    assert isinstance(act, Do)
    assert {role.name: role.words for role in act.roles} == {
        "person": "me", "thing": "the red cup", "source": "the shelf",
    }  # fmt: skip
    assert all(meaning.text[role.start : role.end] == role.words for role in act.roles)


def test_a_retraction_leaves_nothing_of_what_was_said_before_it() -> None:
    assert meant("go retract | go to {1.place: the kitchen}, scrap that").wanted() == ()
    assert acts(meant("go retract beep | go to {1.place: the kitchen}, no, just beep")) == ["beep"]


def test_a_correction_puts_another_role_into_the_act_that_takes_it() -> None:
    meaning = meant("go beep instead | go to {1.place: the kitchen} and beep, no, {3.place: the study}")
    go, beep = meaning.wanted()
    assert isinstance(go, Do)
    assert go.words("place") == "the study"
    assert isinstance(beep, Do)


def test_a_correction_without_an_act_to_correct_is_a_part_of_a_request() -> None:
    (node,) = meant("instead | no, {place: the study}").wanted()
    assert isinstance(node, Do)
    assert (node.act, node.words("place")) == ("fragment", "the study")


def test_what_is_forbidden_or_only_spoken_about_is_not_wanted() -> None:
    meaning = meant("not go go | don't go to {1.place: the kitchen}, go to {2.place: the study}")
    assert acts(meaning) == ["go"]
    assert meaning.has(Not)
    told = meant("about go | she told me to go to {1.place: the kitchen}")
    assert told.wanted() == ()
    assert told.has(About)


def test_a_retraction_within_a_branch_takes_back_only_that_branch() -> None:
    line = "if there's {1.thing: a cup} go to {2.place: it}, no, beep, else nod"
    (node,) = meant(f"if seen then go retract beep else nod end | {line}").wanted()
    assert isinstance(node, If)
    assert [one.act for one in node.then if isinstance(one, Do)] == ["beep"]
    assert [one.act for one in node.otherwise if isinstance(one, Do)] == ["nod"]


def test_what_is_repeated_says_how_often() -> None:
    (node,) = meant("repeat go beep end | {0.times: twice} go to {1.place: the door} and beep").wanted()
    assert isinstance(node, Repeat)
    assert node.times == "twice"
    assert [one.act for one in node.nodes if isinstance(one, Do)] == ["go", "beep"]


def test_brackets_and_semicolons_may_stand_in_the_notation() -> None:
    bracketed = read("if ( seen ) then ( go ; beep ) else ( nod ) | is {1.thing: a cup} there? {2.place: here} …")
    assert [step.symbol for step in bracketed.steps if step.symbol not in ROLE_NAMES] == [
        "if", "seen", "then", "go", "beep", "else", "nod", "end",
    ]  # fmt: skip


@pytest.mark.parametrize(
    "line",
    ["go", "fly | fly", "go | go {colour: red}", "go | go to {place: the", "go | go ~1.place", "go | {2.place: here}"],
)
def test_a_line_that_is_none_is_refused(line: str) -> None:
    with pytest.raises(NotationError):
        read(line)


def test_every_sentence_to_learn_from_can_be_written_as_it_is_read() -> None:
    lines = [line for file in SENTENCES.glob("*/*.txt") for line in file.read_text("utf-8").splitlines()]
    assert len(lines) > 10_000
    for line in lines:
        example = read(line)
        assert read(write(example)) == example
        grammar = Grammar()
        for symbol in (*(step.symbol for step in example.steps), DONE):
            assert symbol in grammar.allowed(), line
            grammar.feed(symbol)
        assert meaning_of(example.text, example.steps).nodes


@given(st.data())
def test_whatever_the_grammar_allows_is_a_meaning(data: st.DataObject) -> None:
    grammar, steps = Grammar(), list[Step]()
    while len(steps) < MAX_STEPS:
        allowed = grammar.allowed()
        symbol = data.draw(st.sampled_from(sorted(allowed)))
        if symbol == DONE:
            break
        grammar.feed(symbol)
        steps.append(Step(symbol, 0, 1) if symbol in ROLE_NAMES else Step(symbol))
    else:
        return
    meaning = meaning_of("x", steps)
    assert all(not isinstance(node, (Not, About, Retract)) for node in meaning.wanted())
    assert meaning.describe()["nodes"] or not meaning.nodes


def test_every_act_says_what_it_means_and_takes_known_roles() -> None:
    assert all(act.means for act in ACTS.values())
    assert all(role in ROLE_NAMES for name in ACTS for role in roles_of(name))


def test_units_are_words_numbers_marks_and_single_chinese_characters() -> None:
    assert [unit.word for unit in units("Anna’s cup: 1.5m!")] == ["anna's", "cup", ":", "1.5", "m", "!"]
    assert [unit.word for unit in units("去厨房kitchen")] == ["去", "厨", "房", "kitchen"]


@given(st.text())
def test_every_unit_stands_where_it_says(text: str) -> None:
    small = plain(text)
    assert len(small) == len(text)
    assert all(small[unit.start : unit.end] == unit.word for unit in units(text))
