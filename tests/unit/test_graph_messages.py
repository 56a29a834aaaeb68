"""What passes between a ROS graph and us, as it is written: plans, sound, names, and our own messages."""

from __future__ import annotations

import base64
import json
import re
from array import array
from importlib.resources import files
from typing import Any

import numpy as np
import pytest
import soundfile
from hypothesis import given
from hypothesis import strategies as st

from config import ConfigError, load
from engine.audio.vad import make_vad
from engine.errors import UsageError
from engine.graph.complaints import QUIET_S, Complaints
from engine.graph.messages import (
    EXECUTE_PLAN,
    GET_PLAN,
    as_json,
    as_written,
    full_name,
    get_plan_over,
    goal_over,
    plan_told,
    read_plan,
    string,
)
from engine.graph.own import LASTS_S, LONGEST_S, OwnMessages
from engine.graph.sound import LONGEST_S as LONGEST_SOUND_S
from engine.graph.sound import Onset, pcm_in
from engine.plan import ActionCall, Quantity, parse_calls
from engine.planner.build import build_registry

SETTINGS = load(environ={})
REGISTRY = build_registry(SETTINGS)


# Plans

WORDS = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
NAMES = st.from_regex(r"[a-z][a-z0-9_]{0,8}", fullmatch=True)
NUMBERS = st.builds(
    Quantity, st.floats(-1e6, 1e6).map(lambda value: float(f"{value:.12g}")), st.sampled_from(["", "m", "rad/s", "deg"])
)
ARGUMENTS = WORDS | NUMBERS
CALLS = st.builds(
    ActionCall, NAMES, st.lists(ARGUMENTS, max_size=3).map(tuple), st.dictionaries(NAMES, ARGUMENTS, max_size=3)
)


@given(st.lists(st.tuples(CALLS, st.booleans()), min_size=1, max_size=4))
def test_calls_are_read_as_they_are_written(found: list[tuple[ActionCall, bool]]) -> None:
    calls = tuple(
        ActionCall(call.name, call.positional, call.named, alongside and index > 0)
        for index, (call, alongside) in enumerate(found)
    )
    assert parse_calls(as_written(calls)) == calls


def test_a_plan_that_is_told_is_read_again_with_what_starts_together() -> None:
    written = 'navigation("A"); move_forward(1.5 m, 0.2 m/s) & say("she said \\"go\\", and left"); arm_nod()'
    actions = [REGISTRY.resolve(call) for call in parse_calls(written)]
    told = plan_told("all of it", [], actions, "", "phrases", None, REGISTRY)
    assert told["actions"] == written.split("; ")
    asked = read_plan(as_json(told), REGISTRY)
    assert asked.text == written
    assert [REGISTRY.resolve(call) for call in parse_calls(asked.text)] == actions


def test_every_skill_that_needs_nothing_can_be_told_and_read_again() -> None:
    for skill in REGISTRY:
        if all(parameter.default is not None for parameter in skill.parameters):
            action = REGISTRY.resolve(ActionCall(skill.name))
            asked = read_plan(plan_told("", [], [action], "", "phrases", None, REGISTRY), REGISTRY)
            assert [REGISTRY.resolve(call) for call in parse_calls(asked.text)] == [action], skill.name


def test_a_sentence_is_no_list_of_calls() -> None:
    assert not read_plan("go to the kitchen (slowly)", REGISTRY).is_calls
    assert read_plan(" navigation(A) ", REGISTRY).is_calls


def test_half_a_character_is_told_as_a_question_mark() -> None:
    assert string("nod\ud800") == {"data": "nod?"}
    assert as_json({"args": "\ud800"}) == '{"args": "?"}'
    assert json.loads(as_json({"goal": "去厨房"})) == {"goal": "去厨房"}


INTERFACES = files("assets") / "ros2" / "sayso_interfaces"


@pytest.mark.parametrize("type", [GET_PLAN, EXECUTE_PLAN])
def test_the_package_of_interfaces_has_the_fields_that_are_sent(type: str) -> None:
    package, kind, name = type.split("/")
    file = INTERFACES / kind / f"{name}.{kind}"
    parts = file.read_text("ascii").split("---")
    fields = [re.findall(r"^(\w+) (\w+)", part, re.MULTILINE) for part in parts]
    result = goal_over("done", "") if kind == "action" else get_plan_over(None, "")
    types = {bool: "bool", str: "string"}
    assert [(types[value.__class__], key) for key, value in result.items()] == fields[1]
    assert f'"{kind}/{file.name}"' in (INTERFACES / "CMakeLists.txt").read_text()
    assert package in (INTERFACES / "package.xml").read_text()


# Names


@pytest.mark.parametrize(
    ("namespace", "name", "full"),
    [
        (None, "plan", "/plan"),
        ("robot1", "audio_input/raw", "/robot1/audio_input/raw"),
        ("/house/robot1", "plan", "/house/robot1/plan"),
        ("robot1", "/plan", "/plan"),
    ],
)
def test_names_lie_in_the_namespace_unless_they_are_complete(namespace: str | None, name: str, full: str) -> None:
    assert full_name(namespace, name) == full


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("ros.door=tcp://peer:1", "this is no way to a ROS graph"),
        ("ros.door=ws://", "this is no way to a ROS graph"),
        ("ros.door=ws://robot:99999", "this is no way to a ROS graph"),
        ("ros.door=zenoh://robot:0", "this is no way to a ROS graph"),
        ("ros.names.plan=two words", "this is no name of a ROS graph"),
        ("ros.names.plan=", "Input should be"),
        ("ros.names.plan=a//b", "this is no name of a ROS graph"),
        ("ros.names.plan=outcome", "names.plan and names.outcome are one and the same name"),
        ("ros.namespace=1st", "this is no name of a ROS graph"),
    ],
)
def test_a_wrong_setting_is_told(setting: str, told: str) -> None:
    if setting == "ros.names.plan=":
        assert load(overrides=(setting,), environ={}).ros.names.plan is None
        return
    with pytest.raises(ConfigError, match=told):
        load(overrides=(setting,), environ={})


@pytest.mark.parametrize(
    "door", ["ws://127.0.0.1:9090", "wss://robot/bridge", "zenoh://[::1]:7447/42", "zenoh://robot", "rclpy", "null"]
)
def test_ways_to_a_graph(door: str) -> None:
    assert load(overrides=(f"ros.door={door}",), environ={}).ros.door == (None if door == "null" else door)


# Sound

TWO = b"\x01\x00\xfe\xff"
"""The samples 1 and -2."""


@pytest.mark.parametrize(
    "data", [[1, -2], (1, -2), np.array([1, -2], np.int16), np.array([1, -2]), array("h", [1, -2])]
)  # fmt: skip
def test_samples_of_all_kinds_are_read(data: Any) -> None:
    assert pcm_in({"data": data}, "int16") == TWO


@pytest.mark.parametrize("data", [TWO, list(TWO), np.frombuffer(TWO, np.uint8), base64.b64encode(TWO).decode()])
def test_bytes_of_all_kinds_are_read(data: Any) -> None:
    assert pcm_in({"data": data}, "uint8") == TWO


@pytest.mark.parametrize(
    "data",
    [
        None, 7, "text", {"a": 1}, [1.5], ["1"], [None], [40_000], [-40_000], [10**30], [[1, 2], [3, 4]],
        np.zeros((2, 2), np.int16), np.array([0.5]), np.array([40_000]), [0] * 1_000_000, np.zeros(10**6, np.int16),
    ],
)  # fmt: skip
def test_what_is_no_sound_is_refused(data: Any) -> None:
    with pytest.raises(UsageError):
        pcm_in({"data": data}, "int16")


@pytest.mark.parametrize("data", [b"\0", [256, 0], [-1, 0], "=", "\ud800", b"\0" * 10**6, "A" * 10**7, [0, 0.0]])
def test_what_are_no_bytes_of_sound_is_refused(data: Any) -> None:
    with pytest.raises(UsageError):
        pcm_in({"data": data}, "uint8")


def test_an_empty_message_is_no_sound_and_no_fault() -> None:
    assert pcm_in({"data": []}, "int16") == pcm_in({"data": b""}, "uint8") == b""
    assert LONGEST_SOUND_S > 1


def test_somebody_who_begins_to_speak_is_noticed_once() -> None:
    speech, rate = soundfile.read(str(files("assets") / "speech" / "go_to_the_kitchen.wav"), dtype="int16")
    assert rate == 16_000
    quiet = np.zeros(rate, np.int16)
    onset = Onset(make_vad(SETTINGS.vad))
    sound = np.concatenate((quiet, speech, quiet, speech, quiet))
    began = [
        start / rate + 0.1 - found
        for start in range(0, len(sound), rate // 10)
        if (found := onset.push(sound[start : start + rate // 10].tobytes())) is not None
    ]
    assert len(began) == 2
    assert 0.9 < began[0] < 1.6
    assert began[1] - began[0] == pytest.approx(len(speech) / rate + 1, abs=0.2)


# Our own messages


class Clock:
    t = 0.0

    def __call__(self) -> float:
        return self.t


def test_as_many_come_back_as_were_published() -> None:
    own = OwnMessages(Clock())
    own.publishing("nod")
    own.publishing("nod")
    own.publishing("stop")
    assert [own.is_own("nod") for _ in range(3)] == [True, True, False]
    assert own.is_own("stop")


def test_one_that_does_not_come_back_is_not_waited_for_any_more() -> None:
    clock = Clock()
    own = OwnMessages(clock)
    own.publishing("nod")
    clock.t = LASTS_S + 0.1
    assert not own.is_own("nod")


def test_one_that_cannot_come_back_yet_is_waited_for_but_not_for_ever() -> None:
    clock = Clock()
    own = OwnMessages(clock)
    own.publishing("nod")
    own.publishing("turn")
    for _ in range(10):
        clock.t += LASTS_S - 1
        own.wait()
    assert own.is_own("nod")
    while clock.t <= LONGEST_S:
        clock.t += LASTS_S - 1
        own.wait()
    assert not own.is_own("turn")


def test_of_many_complaints_one_is_told_and_then_how_many_there_were() -> None:
    clock, told = Clock(), list[str]()
    complain = Complaints(told.append, clock)
    for _ in range(100):
        complain("It is no text.")
    complain.catch_up()
    assert told == ["It is no text."]
    clock.t = QUIET_S
    complain.catch_up()
    complain.catch_up()
    assert told == ["It is no text.", "99 more messages from the ROS graph were refused."]
