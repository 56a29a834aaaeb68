"""What models answer, from the form that they were asked for to garbage: read, or turned down with the reason."""

from __future__ import annotations

import contextlib
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.errors import PlanError
from engine.plan import ActionCall, Quantity
from engine.planner.reply import Proposal, UnreadableReply, read_reply, read_steps
from engine.skills.registry import NOT_SAID


@pytest.mark.parametrize(
    "text",
    [
        '{"action": ["navigation(kitchen)", "beep()"], "response": "On my way.", "clarification": null}',
        '```json\n{"action": ["navigation(kitchen)", "beep()"], "response": "On my way."}\n```',
        'Sure! {"action": ["navigation(kitchen)", "beep()"], "response": "On my way."} I hope that helps.',
        '{"action": "navigation(kitchen), beep()", "response": "On my way."}',
        '{"action": [{"name": "navigation", "args": ["kitchen"]}, {"name": "beep"}], "response": "On my way."}',
    ],
)
def test_a_plan_is_read_in_whichever_dress_it_comes(text: str) -> None:
    found = read_reply(text)
    assert [call.name for call in found.calls] == ["navigation", "beep"]
    assert found.calls[0].positional == ("kitchen",)
    assert found.response == "On my way."


def test_arguments_may_have_names() -> None:
    [call] = read_reply('{"action": [{"name": "move_left", "args": {"angle": 90}}]}').calls
    assert call == ActionCall("move_left", (), {"angle": Quantity(90.0)})


def test_a_question_a_reason_and_a_response_are_told_apart() -> None:
    assert read_reply('{"action": [], "response": "", "clarification": "Which box?"}') == Proposal(
        clarification="Which box?"
    )
    assert read_reply('{"impossible": "I cannot fly."}') == Proposal(impossible="I cannot fly.")
    assert read_reply('{"action": [], "response": "Hello."}') == Proposal(response="Hello.")


def test_what_a_model_leaves_open_is_read_as_not_said() -> None:
    first, second = read_reply("""{"action": ["carry(?, kitchen)", "move_forward('?')"]}""").calls
    assert first.positional == (NOT_SAID, "kitchen")
    assert second.positional == (NOT_SAID,)
    [spoken] = read_reply("""{"action": ["say('ready?')"]}""").calls
    assert spoken.positional == ("ready?",)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "I will go to the kitchen.",
        "[]",
        "{",
        "null",
        '{"action": [], "response": ""}',
        '{"action": 7}',
        '{"action": [7]}',
        '{"action": [{"name": "beep", "args": [true]}]}',
        '{"action": [{"name": "beep", "args": [{"x": 1}]}]}',
        '{"action": ["beep(), beep()"]}',
        "{\"action\": [\"__import__('os').system('x')\"]}",
        json.dumps({"action": ["beep()"] * 10_000}),
        "[" * 100_000,
        '{"action": ' * 10_000,
        f'{{"action": [{{"name": "wait", "args": [{"9" * 400}]}}]}}',
        f'{{"action": [{{"name": "wait", "args": [{"9" * 5000}]}}]}}',
        '{"action": [{"name": "wait", "args": [1e400]}]}',
        '{"action": [{"name": "wait", "args": [NaN]}]}',
        r"""{"action": ["say('\ud800')"], "response": ""}""",
        r'{"action": [], "response": "Well \udc00."}',
    ],
)
def test_garbage_is_turned_down_with_a_reason(text: str) -> None:
    with pytest.raises(PlanError) as caught:
        read_reply(text)
    assert caught.value.message


def test_no_control_character_and_no_endless_sentence_gets_through() -> None:
    response = read_reply(json.dumps({"response": "\x1b[31mred\x07\n" + "x" * 5000})).response
    assert response.isprintable()
    assert len(response) <= 400


def test_steps_are_read_from_json_or_lines() -> None:
    assert read_steps('{"steps": ["go to the kitchen", "look"]}') == ("go to the kitchen", "look")
    assert read_steps("1. go to the kitchen\n2) look\n\n- beep") == ("go to the kitchen", "look", "beep")
    with pytest.raises(UnreadableReply):
        read_steps('{"steps": 3}')


anything = st.recursive(st.none() | st.booleans() | st.floats() | st.integers() | st.text(), st.lists)


@given(st.text(max_size=300) | anything.map(json.dumps))
def test_nothing_that_a_model_writes_makes_it_fail_in_another_way(text: str) -> None:
    for read in (read_reply, read_steps):
        with contextlib.suppress(PlanError):
            read(text)
