"""Events on the wire: what is written is read back, and nothing else is taken for an event."""

from __future__ import annotations

import json
import types
from collections.abc import Mapping
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.errors import ExitCode, UsageError
from engine.events import BODIES, Body, Event, Log, from_json, to_dict, to_json

WIRE_NAMES = {
    "session.started", "session.ended", "state.changed", "wake.heard",
    "listen.started", "listen.level", "listen.ended",
    "transcript.partial", "transcript.final", "transcript.rejected",
    "decision.made", "meaning.read", "plan.made", "plan.rejected", "clarification.asked", "refusal.made",
    "action.queued", "action.started", "action.progress", "action.finished",
    "speech.started", "speech.ended", "interrupt.raised", "task.ended",
    "robot.state", "motion.paused", "motion.resumed", "camera.frame", "perception.result", "log", "error", "timing",
}  # fmt: skip
"""The kinds that the design promises to outside tools."""

TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
INTEGERS = st.integers(min_value=-(2**63), max_value=2**63 - 1)


def values_of(hint: Any) -> st.SearchStrategy[Any]:
    """Everything that a field of this type can hold and JSON can carry."""
    plain = {str: TEXT, bool: st.booleans(), int: INTEGERS, float: NUMBERS, type(None): st.none(), Any: TEXT}
    if hint in plain:
        return plain[hint]
    if isinstance(hint, type) and issubclass(hint, msgspec.Struct):
        hints = get_type_hints(hint)
        return st.builds(hint, **{name: values_of(hints[name]) for name in hint.__struct_fields__})
    arguments = get_args(hint)
    match get_origin(hint):
        case origin if origin is Literal:
            return st.sampled_from(arguments)
        case origin if origin in (Union, types.UnionType):
            return st.one_of(*map(values_of, arguments))
        case origin if origin is tuple and arguments[-1] is Ellipsis:
            return st.lists(values_of(arguments[0]), max_size=3).map(tuple)
        case origin if origin is tuple:
            return st.tuples(*map(values_of, arguments))
        case origin if origin in (Mapping, dict):
            return st.dictionaries(values_of(arguments[0]), values_of(arguments[1]), max_size=3)
    raise TypeError(f"no strategy for {hint}: teach values_of about it")


def events(body: type[Body]) -> st.SearchStrategy[Event]:
    return st.builds(
        Event,
        seq=st.integers(min_value=1, max_value=2**53),
        t=st.floats(min_value=0, max_value=1e6).map(lambda t: round(t, 6)),
        wall=TEXT,
        session=TEXT,
        turn=st.none() | TEXT,
        epoch=st.integers(min_value=0, max_value=2**53),
        body=values_of(body),
    )


@pytest.mark.parametrize("kind", sorted(BODIES))
@settings(max_examples=30)
@given(data=st.data())
def test_every_kind_is_read_back_as_it_was_written(kind: str, data: st.DataObject) -> None:
    event = data.draw(events(BODIES[kind]))
    line = to_json(event)
    assert b"\n" not in line
    assert from_json(line) == event
    assert from_json(line.decode()) == event


def test_the_kinds_are_those_that_were_promised() -> None:
    assert BODIES.keys() >= WIRE_NAMES
    later = {
        "ack",
        "model.asked",
        "requests.waiting",
        "requests.dropped",
        "request.ended",
        "question.ended",
        "offers.made",
    }
    assert BODIES.keys() - WIRE_NAMES == {*later, "person.asked", "person.answered", "person.acted"}


def example(**changes: Any) -> dict[str, Any]:
    """A good event as a dictionary, with some fields changed."""
    return to_dict(Event(17, 12.345, "2026-11-21T10:00:00Z", "S", None, 3, Log("info", "test", "hello"))) | changes


def test_the_envelope_is_in_wire_order() -> None:
    assert list(example()) == ["v", "seq", "t", "wall", "session", "turn", "epoch", "kind", "body"]
    assert example()["v"] == 1


def test_readers_ignore_fields_that_they_do_not_know() -> None:
    newer = example(colour="red", body={"level": "info", "source": "test", "message": "hello", "colour": "red"})
    assert from_json(json.dumps(newer)).body == Log("info", "test", "hello")


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"v": 2}, "version 1"),
        ({"v": True}, "Expected `int`"),
        ({"v": "1"}, "Expected `int`"),
        ({"kind": "robot.exploded"}, "robot.exploded"),
        ({"kind": ["log"]}, "kind"),
        ({"seq": "17"}, "seq"),
        ({"t": None}, "t"),
        ({"turn": 5}, "turn"),
        ({"body": None}, "Expected"),
        ({"body": []}, "Expected"),
        ({"body": {"level": "info"}}, "source"),
        ({"body": {"level": "loud", "source": "", "message": ""}}, "loud"),
    ],
)
def test_what_is_not_an_event_is_a_usage_error_that_says_why(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(UsageError, match=said) as raised:
        from_json(json.dumps(example(**changes)))
    assert raised.value.exit_code is ExitCode.USAGE


@pytest.mark.parametrize("missing", ["v", "seq", "t", "wall", "session", "turn", "epoch", "kind", "body"])
def test_no_field_of_the_envelope_may_be_missing(missing: str) -> None:
    cut = example()
    del cut[missing]
    with pytest.raises(UsageError, match=missing):
        from_json(json.dumps(cut))


@pytest.mark.parametrize(
    "line", ["", "null", "[]", "17", '"x"', "{", b"\xff\xfe", "[" * 100_000, '{"body":' * 50_000, '"\\ud800"']
)
def test_garbage_is_a_usage_error(line: str | bytes) -> None:
    with pytest.raises(UsageError):
        from_json(line)


@settings(deadline=None)
@given(st.binary(max_size=200))
def test_any_bytes_are_an_event_or_a_usage_error(line: bytes) -> None:
    with pytest.raises(UsageError):
        from_json(line)


def test_text_that_is_not_unicode_is_written_readably() -> None:
    # sys.argv holds lone surrogates where the shell passed bytes that are not UTF-8
    event = Event(1, 0.0, "", "", None, 1, Log("info", "test", "go \udcff home"))
    assert from_json(to_json(event)).body == Log("info", "test", "go ? home")
