"""An answer, a correction, a follow-up: what is said second belongs to the act that was said before."""

from __future__ import annotations

import asyncio
from dataclasses import replace

import pytest

from config import load
from engine.errors import ExitCode
from engine.parts.loading import at_home
from engine.plan import ActionCall, Plan
from engine.planner import build
from engine.planner.options import agreed, chosen
from engine.planner.planner import Planner
from engine.planner.request import Happened, Heard, NoPlan, PlanRequest, Said
from engine.planner.understood import Understood
from tests.history import asked, planned
from tests.unit.test_understood import Written


@pytest.fixture
def reader() -> Written:
    return Written()


@pytest.fixture
def understood(reader: Written, monkeypatch: pytest.MonkeyPatch) -> Understood:
    monkeypatch.setattr(build, "learned_reader", lambda folder: reader)
    planner: Planner = build.build_planner(at_home(load()))
    assert planner._learned is not None
    return planner._learned


def after(understood: Understood, happened: tuple[Happened, ...], text: str, **about: str) -> str:
    """What is done on ``text``, or asked."""
    request = PlanRequest(text, happened, holding=about.get("holding", ""))
    found = understood.plan(Heard(request, text, "en"))
    if isinstance(found, Plan):
        return "; ".join(map(str, found.actions)) or found.response
    return "" if found is None else found.answer


DONE = planned("navigation(A)")


@pytest.mark.parametrize(
    ("first", "second", "does"),
    [
        ("go | go to {place: the desk}", "fragment | and now {thing: the wardrobe}", "navigation(S)"),
        ("go | go to {place: the desk}", "instead | no, {place: the kitchen}", "navigation(A)"),
        ("pick_up | take {thing: the red box}", "fragment | {thing: the blue one} too", "pick_object(blue box)"),
        ("forward | go {amount: one metre} ahead", "fragment | {amount: twice as far}", "move_forward(2, 0.3)"),
        ("forward | go {amount: one metre} ahead", "fragment | {amount: half that}", "move_forward(0.5, 0.3)"),
        ("forward | go {amount: one metre} ahead", "instead | no, {amount: two}", "move_forward(2, 0.3)"),
        ("forward | go {amount: one metre} ahead", "fragment | {place: the other way}", "move_forward(-1, 0.3)"),
        ("forward | go {amount: one metre} ahead", "fragment | now {manner: slowly}", "move_forward(1, 0.1)"),
        ("turn_left | turn left {amount: 90 degrees}", "fragment | {place: right}", "move_right(90, 1)"),
        ("turn_left | turn left {amount: 90 degrees}", "fragment | another {amount: 20 degrees}", "move_left(20, 1)"),
        ("light | make it {colour: red}", "fragment | {colour: green} now", "light(green)"),
        ("beep | beep {times: twice}", "fragment | {times: once} more", "beep(0.2)"),
    ],
)
def test_what_is_said_second_takes_the_place_of_a_role(
    understood: Understood, reader: Written, first: str, second: str, does: str
) -> None:
    assert after(understood, (Said(reader.knows(first)), DONE), reader.knows(second)) == does


def test_only_the_act_that_takes_the_role_is_done_again(understood: Understood, reader: Written) -> None:
    first = reader.knows("go beep | go to {1.place: the desk} and beep")
    assert after(understood, (Said(first), DONE), reader.knows("fragment | and {place: the kitchen}")) == (
        "navigation(A)"
    )


def test_several_follow_one_another(understood: Understood, reader: Written) -> None:
    history = [Said(reader.knows("forward | go {amount: one metre} ahead")), DONE]
    history += [Said(reader.knows("fragment | {amount: twice as far}")), DONE]
    assert after(understood, tuple(history), reader.knows("fragment | and {place: back}")) == "move_forward(-2, 0.3)"


def test_what_else_is_said_with_an_answer_is_done_after_it(understood: Understood, reader: Written) -> None:
    history = (Said(reader.knows("pick_up | take {thing: the box}")), asked("Which one: the red box or the blue box?"))
    answer = reader.knows("fragment come | {1.thing: the red one}, and then come here")
    assert after(understood, history, answer) == "pick_object(red box); navigation(zero)"


def test_an_answer_fills_what_was_open_and_keeps_the_rest(understood: Understood, reader: Written) -> None:
    history = (Said(reader.knows("go beep | go there and beep")), asked("Where to?"))
    assert after(understood, history, reader.knows("fragment | {place: the kitchen}")) == "navigation(A); beep(0.2)"


def test_an_answer_to_where_to_is_still_one_when_the_next_question_is_answered(
    understood: Understood, reader: Written
) -> None:
    history = (
        Said(reader.knows("bring | bring {thing: it} {place: over there}")),
        replace(asked("Where to?"), lacks="where"),
        Said(reader.knows("go nod | go to {1.place: the bedroom} and nod")),
        asked("Which one?"),
    )
    answer = reader.knows("fragment | {thing: the red box}")
    assert after(understood, history, answer) == "carry(red box, C, ); arm_nod()"


def test_who_is_asked_where_to_may_say_it_as_an_order(understood: Understood, reader: Written) -> None:
    first = reader.knows("guide beep | lead {1.person: me} and beep")
    open_ = replace(asked("Where to?"), lacks="where")
    answer = reader.knows("go | go to {place: the kitchen}")
    assert after(understood, (Said(first), open_), answer) == "guide(me, A); beep(0.2)"
    more = reader.knows("go beep | go to {1.place: the kitchen} and beep")
    assert after(understood, (Said(reader.knows("go | go there")), open_), more) == "navigation(A); beep(0.2)"
    other = asked("Which one: the red box or the blue box?")
    assert after(understood, (Said(first), other), answer) == "navigation(A)"


def test_what_was_given_up_is_not_completed_later(understood: Understood, reader: Written) -> None:
    first = reader.knows("bring | fetch {person: me} {thing: the box}")
    question = asked("Which one: the red box or the blue box?")
    given_up = NoPlan("no", "no_order", "I heard “no”, so I do nothing. What shall I do?", ExitCode.CLARIFY)
    history = (Said(first), question, Said("no"), given_up)
    assert not after(understood, history, reader.knows("fragment | {thing: the red one}")).startswith("carry")


def test_an_answer_that_names_nothing_here_leaves_the_question_open(
    reader: Written, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(build, "learned_reader", lambda folder: reader)
    planner = build.build_planner(at_home(load()))
    answered: list[str] = []
    history: tuple[Happened, ...] = (
        Said(reader.knows("pick_up | take {thing: the box}")), asked("Which one: the red box or the blue box?")
    )  # fmt: skip
    request = PlanRequest(
        reader.knows("fragment | {thing: the banana}"), history, answers=lambda: answered.append("yes")
    )
    found = asyncio.run(planner.plan(request))
    assert isinstance(found, NoPlan)
    assert found.repeats
    assert found.answer.endswith("Which one: the red box or the blue box?")
    assert answered == []
    again = asyncio.run(planner.plan(replace(request, happened=(*history, Said(request.text), found))))
    assert not (isinstance(again, NoPlan) and again.repeats)


@pytest.mark.parametrize(
    ("answer", "name"),
    [("the second one", "blue box"), ("the last", "green box"), ("第一个", "red box"), ("a box", "")],
)
def test_an_ordinal_chooses_of_what_was_offered(answer: str, name: str) -> None:
    question = NoPlan("", "ambiguous", "", ExitCode.CLARIFY, options=("red box", "blue box", "green box"))
    assert chosen(question, answer) == name


def test_what_is_not_meant_leaves_the_other() -> None:
    question = asked("Which one: the red box or the blue cup?")
    assert chosen(question, "not the red one") == "blue cup"
    assert chosen(question, "the one on the stool", ("A blue cup on the stool.",)) == "blue cup"
    assert chosen(asked("Where to?"), "the second one") == ""


def test_a_yes_does_what_was_offered() -> None:
    offered = (ActionCall("beep"),)
    question = NoPlan("", "unsure", "Shall I?", ExitCode.CLARIFY, offer=offered)
    assert agreed(question, "yes please") == offered
    assert agreed(question, "yes, but slowly") == ""
    assert agreed(asked("Shall I bring you the bottle?"), "ok") == "bring me the bottle"


def test_without_anything_before_it_a_place_is_gone_to_and_all_else_asked_about(
    understood: Understood, reader: Written
) -> None:
    assert after(understood, (), reader.knows("fragment | {place: the kitchen}")) == "navigation(A)"
    assert after(understood, (), reader.knows("fragment | {thing: the red one}")).startswith("What should I do?")
