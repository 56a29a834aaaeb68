"""Commands in: one JSON object a line, or an error that says what is allowed."""

from __future__ import annotations

import asyncio
import json
from base64 import b64encode

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from config import load
from engine.commands import (
    COMMANDS,
    MAX_LINE,
    MAX_TEXT,
    Audio,
    BadCommand,
    Command,
    EndTask,
    Interrupt,
    Quit,
    Say,
    SetVolume,
    Snapshot,
    Wake,
    parse_command,
)
from engine.errors import ExitCode, UsageError
from engine.parts.loading import at_home
from engine.planner.build import build_planner
from engine.planner.planner import NoPlan, PlanRequest
from tui.commands.ask import requests


@pytest.mark.parametrize(
    ("line", "command"),
    [
        ('{"do": "say", "text": "go home"}', Say("go home")),
        ('{"do": "say", "text": "去厨房", "id": "7"}', Say("去厨房", "7")),
        ('{"do": "say", "text": "go home", "then": ["beep"]}', Say("go home", then=("beep",))),
        ('{"do": "wake"}', Wake()),
        ('{"do": "interrupt", "id": null}', Interrupt()),
        ('{"id": "a", "do": "end_task"}', EndTask("a")),
        ('{"do": "set_volume", "volume": 0.5}', SetVolume(0.5)),
        ('{"do": "snapshot"}', Snapshot()),
        ('{"do": "quit"}\n', Quit()),
        (b'{"do": "quit"}', Quit()),
    ],
)
def test_each_command_is_read_from_its_line(line: str | bytes, command: Command) -> None:
    assert parse_command(line) == command


def test_the_commands_are_those_that_were_promised() -> None:
    assert set(COMMANDS) == {
        "say", "wake", "interrupt", "end_task", "estop", "release", "drive", "here", "limit_speed", "set_volume",
        "audio", "drop", "move", "snapshot", "quit",
    }  # fmt: skip


@settings(deadline=None)
@given(st.lists(st.integers(min_value=-(2**15), max_value=2**15 - 1), max_size=100))
def test_sound_arrives_as_it_was_sent(samples: list[int]) -> None:
    pcm = b"".join(sample.to_bytes(2, "little", signed=True) for sample in samples)
    assert parse_command(json.dumps({"do": "audio", "pcm": b64encode(pcm).decode()})) == Audio(pcm)


TEXT = st.text(st.characters(exclude_categories=["Cs"]))


@settings(deadline=None)
@given(TEXT.filter(str.strip), st.none() | TEXT)
def test_any_request_arrives_as_it_was_typed(text: str, id: str | None) -> None:
    assert parse_command(json.dumps({"do": "say", "text": text, "id": id})) == Say(text, id)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("", "Not JSON"),
        ("go home", "Not JSON"),
        (b"\xff", "Not JSON"),
        ("[" * 100_000, "Not JSON"),
        ('{"do": ' * 50_000, "Not JSON"),
        ("[]", "text field 'do'"),
        ("{}", "text field 'do'"),
        ('{"do": 5}', "text field 'do'"),
        ('{"do": ["say"]}', "text field 'do'"),
        ('{"do": "fly"}', "Unknown command 'fly'"),
        ('{"do": "say"}', "say: .*text"),
        ('{"do": "say", "text": 5}', "say: .*text"),
        ('{"do": "say", "text": "x", "id": 5}', "say: .*id"),
        ('{"do": "say", "text": "x", "then": "y"}', "say: .*then"),
        ('{"do": "say", "text": "x", "then": ["y", " "]}', "request is empty"),
        ('{"do": "say", "text": "x", "loud": true}', "unknown field 'loud'"),
        ('{"do": "wake", "text": "x"}', "wake: unknown field 'text'"),
        ('{"do": "audio", "pcm": "!!"}', "not base64"),
        ('{"do": "audio", "pcm": "é"}', "not base64"),
        ('{"do": "audio", "pcm": "AA=="}', "odd number of bytes"),
        ('{"do": "audio", "pcm": 5}', "audio: .*pcm"),
        ('{"do": "audio"}', "audio: .*pcm"),
        (" " * (MAX_LINE + 1), "at most"),
        ('{"do": "say", "text": " "}', "request is empty"),
        (json.dumps({"do": "say", "text": "x" * (MAX_TEXT + 1)}), "2001 characters long; 2000 are read at most"),
    ],
)
def test_what_is_wrong_with_a_command_is_said(line: str | bytes, said: str) -> None:
    with pytest.raises(UsageError, match=said) as raised:
        parse_command(line)
    assert raised.value.exit_code is ExitCode.USAGE


def test_the_longest_request_is_read() -> None:
    assert parse_command(json.dumps({"do": "say", "text": "x" * MAX_TEXT})) == Say("x" * MAX_TEXT)


def test_what_is_too_long_is_neither_read_on_the_command_line_nor_planned() -> None:
    text = "go to the kitchen and then " * 100
    with pytest.raises(UsageError, match="2700 characters long"):
        next(requests(text))
    found = asyncio.run(build_planner(at_home(load(environ={}))).plan(PlanRequest(text)))
    assert isinstance(found, NoPlan)
    assert (found.code, found.exit_code) == ("too_long", ExitCode.FAILED)
    assert "2700 characters long" in found.answer


@pytest.mark.parametrize(
    ("line", "do", "id"),
    [
        ('{"do": "say", "id": "7"}', "say", "7"),
        ('{"do": "say", "id": "7", "text": "x", "loud": true}', "say", "7"),
        ('{"do": "say", "id": 7, "text": "x"}', "say", "7"),
        ('{"do": "audio", "id": "7", "pcm": "!!"}', "audio", "7"),
        ('{"do": "fly", "id": "7"}', "fly", "7"),
        ('{"id": "7"}', "", "7"),
        (r'{"do": "say", "id": "7", "text": "\ud800"}', "say", "7"),
        (r'{"do": "\ud800", "id": "\udc00"}', "", None),
        ('{"do": "wake", "id": ["7"]}', "wake", None),
        ('{"do": "say", "id": "7"', "", None),
        ("[7]", "", None),
    ],
)
def test_of_a_bad_command_is_kept_what_its_sender_knows_it_by(line: str, do: str, id: str | None) -> None:
    with pytest.raises(BadCommand) as raised:
        parse_command(line)
    assert (raised.value.do, raised.value.id) == (do, id)


def test_an_unknown_command_is_answered_with_the_known_ones() -> None:
    with pytest.raises(UsageError) as raised:
        parse_command('{"do": "fly"}')
    assert all(name in raised.value.hint for name in COMMANDS)


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)
FIELDS = st.dictionaries(st.sampled_from(["text", "pcm", "id", "x"]), JSON, max_size=3)


@settings(deadline=None)
@given(st.binary(max_size=200) | st.text(max_size=200) | JSON.map(json.dumps))
def test_any_line_is_a_command_or_a_usage_error(line: str | bytes) -> None:
    with pytest.raises(UsageError):
        parse_command(line)


@settings(deadline=None)
@given(st.sampled_from(sorted(COMMANDS)), FIELDS)
def test_any_fields_make_a_command_or_a_usage_error(do: str, fields: dict[str, object]) -> None:
    try:
        command = parse_command(json.dumps(fields | {"do": do}))
    except UsageError:
        return
    assert command.do == do
