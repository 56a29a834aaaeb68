"""The whole cycle with large models: sayso in a process of its own, platforms on loopback that speak real protocols.

Decide, plan, act, report, think again, until it is finished; and a platform that hangs, talks nonsense, breaks off,
wants to be left alone or never comes to an end moves nothing, loses no turn, and learns no other one's key.
"""

from __future__ import annotations

import json
import re
import signal
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from engine.errors import ExitCode
from tests.e2e.engine import Engine, engine
from tests.e2e.platforms import Platform, Protocol, configuration, platforms
from tests.e2e.sayso import command, environment, events, sayso
from tests.model_service import SILENCE, reply

ODD = "it would be lovely to see you roll over to the kitchen and then half a metre further on"
"""Something that no phrase covers."""
STEPS = {"steps": ["go to the kitchen", "look around", "drive half a metre further"]}
THERE = {"action": ["navigation(kitchen)", "finishtask()"], "response": "On my way."}
FURTHER = {"action": ["move_forward(0.5)", "finishtask()"], "response": "A bit further."}
PATIENCE_S = 2.0
"""How long the execution layer may take; the answer of a platform on loopback takes a hundredth of it."""


@dataclass
class Turn:
    """What came of one thing that was said."""

    events: list[dict[str, Any]]
    result: dict[str, Any]

    def bodies(self, kind: str) -> list[dict[str, Any]]:
        return [event["body"] for event in self.events if event["kind"] == kind]

    @property
    def actions(self) -> list[tuple[str, str]]:
        return [(body["name"], body["outcome"]) for body in self.bodies("action.finished")]

    @property
    def moved(self) -> bool:
        """Whether anything was begun, or the robot is or was on its way."""
        states = self.bodies("robot.state")
        return bool(self.bodies("action.started")) or any(state["moving"] for state in states)


class Cycle:
    """A running engine and the platforms of its two layers."""

    def __init__(self, running: Engine, decision: Platform, execution: Platform, log: Path) -> None:
        self.engine = running
        self.decision = decision
        self.execution = execution
        self.log = log

    def say(self, text: str) -> Turn:
        """Say it, and wait for what comes of it."""
        self.engine.send(do="say", text=text)
        return self.outcome()

    def outcome(self) -> Turn:
        start = len(self.engine.seen)
        result = self.engine.until("state.changed", lambda body: body["result"])["result"]
        return Turn(self.engine.seen[start:], result)

    def begin(self, steps: object, *answers: object) -> None:
        """A new task, in which the two layers answer like that."""
        self.engine.send(do="end_task")
        self.engine.until("ack", lambda body: body["do"] == "end_task")
        self.engine.until("state.changed", lambda body: body["result"])
        self.decision.answers(steps)
        self.execution.answers(*answers)

    def where(self) -> tuple[float, float, float]:
        """Where the robot is: m, m, rad."""
        self.engine.send(do="snapshot", id="where")
        pose = self.engine.until("ack", lambda body: body["id"] == "where")["snapshot"]["robot"]["pose"]
        return pose["x"], pose["y"], pose["yaw"]


@pytest.fixture(scope="module", params=["openai", "dify"])
def protocol(request: pytest.FixtureRequest) -> Protocol:
    found: Protocol = request.param
    return found


@pytest.fixture(scope="module")
def cycle(protocol: Protocol, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cycle]:
    folder = tmp_path_factory.mktemp(protocol)
    with platforms(protocol, decides=60.0, acts=PATIENCE_S) as (decides, acts):
        option, file, environ = configuration(folder, decision=[decides], execution=[acts])
        with engine(folder, "", option, file, environ=environ) as running:
            running.until("log", lambda body: body["source"] == "robot")
            yield Cycle(running, decides, acts, folder / "logs")


# The cycle


def test_a_request_is_decided_planned_done_and_thought_over_until_it_is_finished(
    cycle: Cycle, protocol: Protocol
) -> None:
    looks = {"action": ["navigation(kitchen)", "seewhat()"], "response": "I will have a look."}
    goes_on = {"action": ["move_forward(0.5)", "report_pose()"], "response": ""}
    done = {"action": ["finishtask()"], "response": "That was all."}
    cycle.begin(STEPS, looks, goes_on, done)
    turn = cycle.say(ODD)
    assert turn.result["exit_code"] == ExitCode.DONE, turn.result

    decided = turn.bodies("decision.made")
    assert [(body["steps"], body["source"]) for body in decided] == [(STEPS["steps"], protocol)]
    assert [body["source"] for body in turn.bodies("plan.made")] == [protocol] * 3
    told = [event["kind"] for event in turn.events]
    assert told.index("decision.made") < told.index("plan.made") < told.index("action.started")
    calls = turn.bodies("model.asked")
    assert [(call["layer"], call["round"]) for call in calls] == [("decision", 1), *[("execution", 1)] * 3]
    assert told.index("model.asked") < told.index("decision.made")
    assert ODD in calls[0]["messages"][-1]["text"]
    assert [json.loads(call["reply"]) for call in calls] == [STEPS, looks, goes_on, done]
    assert [name for name, outcome in turn.actions if outcome == "ok"] == [
        "navigation", "seewhat", "move_forward", "report_pose", "finishtask",
    ]  # fmt: skip

    first, second, third = cycle.execution.asked
    assert ODD in cycle.decision.asked[0]
    assert "go to the kitchen; look around; drive half a metre further" in first
    went, saw, moved, stood, _ = (body["message"] for body in turn.bodies("action.finished"))
    assert re.search(r"navigation\(\w+\) ok\. " + re.escape(went), second)
    assert f"seewhat() ok. {saw}" in second
    assert f"move_forward(0.5, 0.3) ok. {moved}" in third
    x, y, _ = cycle.where()
    assert f"x {x:.2f} m, y {y:.2f} m" in stood
    assert stood in third


def test_what_is_said_later_in_a_task_goes_to_the_execution_layer_only(cycle: Cycle, protocol: Protocol) -> None:
    cycle.begin(STEPS, THERE, FURTHER)
    assert cycle.say(ODD).result["exit_code"] == ExitCode.DONE
    turn = cycle.say("might I see you another 0.5 m ahead of where you stand now")
    assert turn.actions == [("move_forward", "ok"), ("finishtask", "ok")]
    assert not turn.bodies("decision.made")
    assert len(cycle.decision.asked) == 1
    assert len(cycle.execution.asked) == 2
    assert "another 0.5 m ahead" in cycle.execution.asked[1]
    if protocol == "openai":
        assert ODD[:40] in cycle.execution.everything[1]

    cycle.begin(STEPS, THERE)
    cycle.say("how about a stroll to the kitchen, my friend")
    assert len(cycle.decision.asked) == 1
    (question,) = cycle.execution.everything
    assert ODD[:40] not in question


@pytest.mark.parametrize("protocol", ["dify"], indirect=True)
def test_dify_keeps_one_conversation_for_each_layer_of_a_task(cycle: Cycle) -> None:
    rounds = ({"action": ["beep()"], "response": ""}, {"action": ["finishtask()"], "response": ""})
    cycle.begin(STEPS, *rounds, *rounds)
    cycle.say("it would be nice to get another beep out of you")
    cycle.say("one more beep out of you would be lovely")
    assert cycle.decision.conversations == [""]
    first, *later = cycle.execution.conversations
    assert (first, len(set(later)), len(later)) == ("", 1, 3)
    assert later[0]
    cycle.begin(STEPS, rounds[1])
    cycle.say("it would be nice to get another beep out of you")
    assert cycle.decision.conversations == cycle.execution.conversations == [""]


def test_an_action_that_failed_is_tried_once_more_and_then_explained(cycle: Cycle) -> None:
    cycle.begin(STEPS, {"action": ["putdown()"], "response": ""})
    turn = cycle.say("would you mind putting to the ground whatever you are clutching")
    assert turn.actions == [("putdown", "failed"), ("putdown", "failed")]
    assert turn.result["exit_code"] == ExitCode.FAILED
    assert "twice" in turn.result["message"]
    assert len(cycle.execution.asked) == 3
    assert "putdown() failed. " in cycle.execution.asked[1]


def test_a_failure_is_explained_by_the_model_and_counts_as_one(cycle: Cycle) -> None:
    cycle.begin(STEPS, {"action": ["putdown()"]}, {"action": [], "response": "There is nothing in my hand."})
    turn = cycle.say("would you mind putting to the ground whatever you are clutching")
    assert turn.actions == [("putdown", "failed")]
    assert turn.result["exit_code"] == ExitCode.FAILED
    assert turn.result["message"] == "There is nothing in my hand."


def test_a_question_ends_the_turn_and_the_next_utterance_completes_it(cycle: Cycle) -> None:
    cycle.begin(STEPS, {"action": [], "response": "", "clarification": "Which room would you like?"}, THERE)
    turn = cycle.say("I would like to meet you in one of the other rooms")
    assert not turn.moved
    assert turn.result["exit_code"] == ExitCode.CLARIFY
    assert [body["question"] for body in turn.bodies("clarification.asked")] == ["Which room would you like?"]
    turn = cycle.say("the kitchen would suit me best")
    assert turn.actions == [("navigation", "ok"), ("finishtask", "ok")]
    assert turn.result["exit_code"] == ExitCode.DONE, turn.result
    assert len(cycle.decision.asked) == 1
    assert "the kitchen would suit me best" in cycle.execution.asked[1]


def test_what_is_impossible_ends_the_turn_with_the_reason(cycle: Cycle) -> None:
    cycle.begin(STEPS, {"action": [], "response": "", "impossible": "I have no wings."})
    turn = cycle.say("a round above the roofs would be fun")
    assert not turn.moved
    assert (turn.result["exit_code"], turn.result["message"]) == (ExitCode.FAILED, "I have no wings.")
    assert [body["code"] for body in turn.bodies("plan.rejected")] == ["impossible"]


# Bad platforms


LEAVE_ME = {"error": {"message": "slow down"}}


def bad(platform: Platform, how: str) -> list[object]:
    """What a platform answers that is no good."""
    half = '{"action": ["move_forward(0.5)"'
    answers: dict[str, list[object]] = {
        "hangs": [SILENCE],
        "drips": [platform.drips(half)],
        "talks about something else": [reply(200, b"<html>Welcome to nginx!</html>")],
        "plans nonsense": ["I am a language model.", {"action": ["teleport(kitchen)"]}],
        "breaks off": [platform.breaks_off(half)],
        "is busy": [reply(429, LEAVE_ME)],
        "is busy for long": [reply(429, LEAVE_ME, **{"Retry-After": "3600"})],
        "is broken": [reply(500, b"oh")],
        "says half a character": [r"""{"action": ["say('\ud800')", "finishtask()"], "response": ""}"""],
        "counts without end": [f'{{"action": [{{"name": "wait", "args": [{"9" * 400}]}}]}}'],
        "is busy for ever": [reply(429, LEAVE_ME, **{"Retry-After": "Fri, 20 Nov 99999999999 08:00:00 GMT"})],
    }
    return answers[how]


@pytest.mark.parametrize(
    ("how", "code", "asked", "words"),
    [
        ("hangs", ExitCode.TIMEOUT, 1, "did not answer within 2 s"),
        ("drips", ExitCode.TIMEOUT, 1, "did not answer within 2 s"),
        ("talks about something else", ExitCode.FAILED, 1, "cannot be read"),
        ("plans nonsense", ExitCode.FAILED, 2, "no plan, twice"),
        ("breaks off", ExitCode.MISSING, 1, "broke off in the middle of its answer"),
        ("is busy", ExitCode.FAILED, 3, "status 429: slow down"),
        ("is busy for long", ExitCode.FAILED, 1, "status 429: slow down"),
        ("is broken", ExitCode.FAILED, 3, "status 500: oh"),
        ("says half a character", ExitCode.FAILED, 2, "no plan, twice"),
        ("counts without end", ExitCode.FAILED, 2, "no plan, twice"),
        ("is busy for ever", ExitCode.FAILED, 1, "status 429: slow down"),
    ],
)
def test_a_bad_platform_moves_nothing_and_says_why(
    cycle: Cycle, how: str, code: ExitCode, asked: int, words: str
) -> None:
    cycle.begin(STEPS, *bad(cycle.execution, how))
    before = cycle.where()
    turn = cycle.say(ODD)
    assert not turn.moved
    assert cycle.where() == pytest.approx(before, abs=1e-3)
    assert turn.result["exit_code"] == code
    assert words in turn.result["message"]
    assert len(cycle.execution.asked) == asked
    assert len(turn.bodies("plan.rejected")) == 1
    assert cycle.say("beep()").actions == [("beep", "ok")]
    cycle.execution.answers(THERE)
    assert cycle.say("how about a stroll to the kitchen, my friend").result["exit_code"] == ExitCode.DONE


def test_a_platform_that_is_busy_for_a_moment_is_asked_again(cycle: Cycle) -> None:
    cycle.begin(STEPS, reply(429, LEAVE_ME, **{"Retry-After": "0.1"}), THERE)
    assert cycle.say(ODD).actions == [("navigation", "ok"), ("finishtask", "ok")]
    assert len(cycle.execution.asked) == 2


def test_a_platform_that_fails_before_it_is_finished_does_not_pass_for_having_finished(cycle: Cycle) -> None:
    cycle.begin(STEPS, {"action": ["beep()"], "response": ""}, *bad(cycle.execution, "is busy for long"))
    turn = cycle.say("it would be nice to get another beep out of you")
    assert turn.actions == [("beep", "ok")]
    assert turn.result["exit_code"] == ExitCode.FAILED
    assert "I cannot tell whether that was all" in turn.result["message"]
    assert [body["code"] for body in turn.bodies("error")] == ["model_refused"]
    assert cycle.say("beep()").actions == [("beep", "ok")]


@pytest.mark.parametrize("how", ["is busy for long", "breaks off", "talks about something else"])
def test_without_a_decision_layer_the_execution_layer_does_both_and_that_is_told(cycle: Cycle, how: str) -> None:
    cycle.begin(None, THERE)
    cycle.decision.answers(*bad(cycle.decision, how))
    turn = cycle.say(ODD)
    assert turn.actions == [("navigation", "ok"), ("finishtask", "ok")]
    (warned,) = (body for body in turn.bodies("log") if body["source"] == "planner")
    assert warned["level"] == "warning"
    assert "platform decides" in warned["message"]


def test_an_interruption_of_a_model_that_hangs_comes_back_and_hangs_up(cycle: Cycle) -> None:
    cycle.begin(SILENCE, THERE)
    cycle.engine.send(do="say", text=ODD)
    cycle.decision.until_asked()
    cycle.engine.send(do="interrupt")
    turn = cycle.outcome()
    assert turn.result["outcome"] == "interrupted"
    assert turn.result["exit_code"] == ExitCode.INTERRUPTED
    assert turn.bodies("state.changed")[-1]["state"] == "WAITING"
    cycle.decision.until_left()
    assert not cycle.execution.asked
    assert cycle.say("beep()").actions == [("beep", "ok")]


@pytest.mark.parametrize("protocol", ["dify"], indirect=True)
def test_an_interruption_in_the_middle_of_an_answer_tells_dify_to_stop(cycle: Cycle) -> None:
    cycle.begin(cycle.decision.drips("Let me"), THERE)
    cycle.engine.send(do="say", text=ODD)
    cycle.decision.until_asked()
    cycle.engine.send(do="interrupt")
    assert cycle.outcome().result["outcome"] == "interrupted"
    cycle.decision.until_told_to_stop()


def test_a_key_that_a_platform_repeats_is_shown_to_nobody(cycle: Cycle) -> None:
    key = cycle.execution.key
    cycle.begin(STEPS, reply(401, {"error": {"message": f"wrong key: {key}"}}))
    assert "********" in cycle.say(ODD).result["message"]
    cycle.execution.answers({"action": ["finishtask()"], "response": f"My key is {key}."})
    assert (
        "My key is ********."
        in cycle.say("what would a pirate ask you about, my friend").bodies("plan.made")[0]["response"]
    )
    cycle.where()  # a snapshot has the whole history
    (log,) = cycle.log.glob("*.jsonl")
    written = str(cycle.engine.seen) + log.read_text("utf-8")
    assert "nobody-may-read-this" not in written


# Fallbacks, and the exit codes of a process

CHAIN = ("talks about something else", "hangs", "breaks off", "is busy for long", "drips", "is broken")


def test_where_platforms_fail_the_next_one_is_asked_and_that_is_told(protocol: Protocol, tmp_path: Path) -> None:
    names = [how.replace(" ", "_") for how in CHAIN]
    with platforms(protocol, **dict.fromkeys(names, 1.0), refuses=60.0, good=60.0) as served:
        *weak, refuses, good = served
        for platform, how in zip(weak, CHAIN, strict=True):
            platform.answers(*bad(platform, how))
        refuses.answers(reply(401, {"error": {"message": f"wrong key: {refuses.key}"}}))
        good.answers({**FURTHER, "response": f"My key is {good.key}."})
        option, file, environ = configuration(tmp_path, execution=[refuses, *weak, good])
        done = sayso(option, file, "ask", "--json", ODD, state=tmp_path, environ=environ)
        assert done.returncode == ExitCode.DONE, done.stderr
        switches = [event["body"] for event in events(done, "log") if event["body"]["source"] == "model"]
        assert [body["level"] for body in switches] == ["warning"] * 7
        for body, platform in zip(switches, [*weak, good], strict=True):
            assert body["message"].endswith(f"The platform {platform.name} is asked instead.")
        assert [event["body"]["outcome"] for event in events(done, "action.finished")] == ["ok", "ok"]
        assert len(good.asked) == 1
        (log,) = (tmp_path / "logs").glob("*.jsonl")
        assert b"nobody-may-read-this" not in done.stdout + done.stderr + log.read_bytes()


def test_ask_exits_with_what_the_platform_failed_of_and_still_does_plain_commands(tmp_path: Path) -> None:
    with platforms("dify", acts=1.0) as (acts,):
        acts.answers(SILENCE)
        option, file, environ = configuration(tmp_path, execution=[acts])
        said = f"{ODD}\nbeep()\n".encode()
        done = sayso(option, file, "ask", "--json", "-", state=tmp_path, stdin=said, environ=environ)
        assert done.returncode == ExitCode.TIMEOUT, done.stderr
        assert [event["body"]["name"] for event in events(done, "action.finished")] == ["beep"]


def test_ctrl_c_while_a_model_hangs_ends_ask_with_130(tmp_path: Path) -> None:
    with platforms("openai", acts=60.0) as (acts,):
        acts.answers(SILENCE)
        option, file, environ = configuration(tmp_path, execution=[acts])
        argv = command(option, file, "ask", "--json", ODD)
        with subprocess.Popen(argv, stdout=subprocess.PIPE, env=environment(tmp_path, environ)) as process:
            acts.until_asked()
            process.send_signal(signal.SIGINT)
            acts.until_left()
            assert process.wait(timeout=30) == ExitCode.INTERRUPTED
