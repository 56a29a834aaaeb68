"""The line that a small model writes, and the object that it stands for."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from engine.plan import Plan
from engine.planner.reply import UnreadableReply, read_reply
from engine.planner.request import Said
from engine.planner.stages.brief import brief, full
from tests import history
from tests.unit.test_two_stage import ODD, Model, asked, names

EXAMPLES: list[dict[str, str]] = [
    example
    for language in ("en", "zh")
    for example in yaml.safe_load((files("assets") / "prompts" / f"examples.{language}.yaml").read_text("utf-8"))
]


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example["user"])
def test_every_example_is_the_same_in_both_forms(example: dict[str, str]) -> None:
    told: dict[str, Any] = {key: value for key, value in example.items() if key not in ("user", "brief")}
    if "action" in told:
        told["action"] = told["action"].split("; ")
    line = brief(json.dumps(told))
    assert "{" not in line
    assert json.loads(full(line)) == told


@pytest.mark.parametrize(
    ("answer", "line"),
    [
        ('{"action": ["say(\'wait; then go (now)\')", "beep()"]}', "say('wait; then go (now)'); beep()"),
        ('{"action": ["beep()"], "response": "Beep."}', "beep()"),
        ('{"action": [], "response": "Hello.", "clarification": null}', "response: Hello."),
        ('{"clarification": "Which one?", "action": []}', "clarification: Which one?"),
        ("[]", "[]"),
        ("{}", "{}"),
        ("I am a language model.", "I am a language model."),
    ],
)
def test_an_answer_in_the_brief_form(answer: str, line: str) -> None:
    assert brief(answer) == line


@pytest.mark.parametrize("line", ["Sure: navigation(kitchen)", "navigation", "", "responses: none", "Impossible"])
def test_what_is_no_such_line_is_no_answer_either(line: str) -> None:
    with pytest.raises(UnreadableReply):
        read_reply(full(line))


@given(st.text())
def test_nothing_that_a_model_writes_is_too_odd(text: str) -> None:
    assert isinstance(brief(text), str)
    assert isinstance(full(text), str)


def test_a_small_model_is_shown_and_writes_lines() -> None:
    model = Model(["pick_object(red box); place_object(sofa)"], local=True)
    before = (Said("hello"), history.answered("Hi."), history.ran("beep()"))
    plan = asked(model, ODD, happened=before)
    assert names(plan) == ["pick_object", "place_object"]
    assert isinstance(plan, Plan)
    assert json.loads(plan.as_written())["action"] == ["pick_object(red box)", "place_object(sofa)"]
    [question] = model.asked
    assert question.grammar is not None
    assert not any("{" in message.text for message in question.messages)
    own = question.messages[question.shared :]
    assert [message.text for message in own if message.role == "assistant"] == ["response: Hi."]


def test_an_answer_that_is_no_good_is_given_back_as_it_was_written() -> None:
    line = "pick_object(red box); teleport(sofa)"
    model = Model([line, "pick_object(red box); place_object(sofa)"], local=True)
    assert names(asked(model, ODD)) == ["pick_object", "place_object"]
    assert model.asked[1].messages[-2].text == line


def test_the_line_of_a_model_that_is_held_to_objects_is_no_plan() -> None:
    model = Model(["pick_object(red box); place_object(sofa)", '{"action": ["beep()", "finishtask()"]}'])
    assert names(asked(model, ODD)) == ["beep", "finishtask"]
