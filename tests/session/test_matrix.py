"""Every cell of the table in ``matrix``: the session is brought into the state for real, then it happens.

What is checked in each: the robot stands before the call returns, the states that follow, one result for each turn and
one end for each action, nothing of the past moves later, the arm, the task cycle, and that the books hold the truth.
"""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, get_args

import pytest
from msgspec import structs

from engine import events
from engine.commands import Command, Halted, Snapshot
from engine.errors import ExitCode
from engine.events import State
from engine.robot.arm import ARM_INITIAL, ARM_UP
from engine.session.session import ARM_RETURN_SPEED
from tests.session.conversation import Conversation, SlowVoice, converse
from tests.session.matrix import CONSEQUENCES, INTERRUPTIONS, OVERHEARING, WHAT_HAPPENS, Consequence, markdown
from tests.session.scenes import SCENES, STAGE_S, Scene, prepare, rest

AFTER_S = 20.0
"""How long nothing of the past may come back; all that a state leads to would be over by then."""

README = Path(__file__).parents[2] / "README.md"


# One cell


@dataclass
class Trial:
    """One session in one state, to which one thing happens."""

    talk: Conversation
    scene: Scene
    expected: Consequence
    turn: str | None
    """The turn that runs."""
    sent: int
    """How many events were there before."""
    moment: float
    """When it happened, s."""
    epoch: int
    """The epoch that it left."""
    arm: int
    """How often the arm had been moved."""
    before: Mapping[str, Any]
    """The snapshot of just before."""

    @property
    def left_alone(self) -> bool:
        return self.turn is not None and self.expected.turn == "left alone"

    def later(self, kind: type[Any], *, own: bool = False) -> list[Any]:
        """What came of a kind from then on: of the turn that ran before, or (without ``own``) of all others."""
        return [
            event.body
            for event in self.talk.seen[self.sent :]
            if isinstance(event.body, kind) and (event.turn is not None and event.turn == self.turn) == own
        ]


@pytest.mark.parametrize("name", INTERRUPTIONS)
@pytest.mark.parametrize("state", SCENES)
def test_what_happens_when(state: State, name: str) -> None:
    interruption = INTERRUPTIONS[name]
    scene = SCENES[state]
    phrase = next(row[name] for states, row in WHAT_HAPPENS.items() if state in states)
    expected = CONSEQUENCES[phrase]
    expected = replace(expected, says=tuple(interruption.told.get(text, text) for text in expected.says))

    async def test(talk: Conversation) -> None:
        ears = watch_the_ears(talk)
        await prepare(talk, state)
        trial = await send(talk, scene, expected, interruption.command)
        if trial.left_alone:
            assert talk.robot.state().twist.is_zero == (not scene.running)
            if state == "LISTENING":
                asyncio.get_running_loop().call_later(STAGE_S, talk.hearing.speak, None)
        else:
            assert talk.robot.state().twist.is_zero  # before the loop could do anything
        await talk.pass_time(AFTER_S)
        the_states_follow(trial)
        every_turn_has_one_result(trial)
        every_action_ends_once(trial, "robot_halted" if name == "halted" else "cancelled")
        what_was_being_said_is_cut(trial)
        nothing_of_the_past_moves(trial)
        what_was_asked_for_happens(trial)
        raised = [(body.scope, body.source, body.state) for body in talk.bodies(events.InterruptRaised)]
        assert raised == ([(interruption.scope, interruption.command.do, state)] if expected.raised else [])
        acks = [body.ok for body in talk.bodies(events.Ack) if body.id == "it"]
        assert acks == ([expected.acknowledged] if hasattr(interruption.command, "id") else [])
        assert all(on == (state in OVERHEARING) for state, on in ears)
        assert all(talk.holds.holder(capability) is None for capability in talk.robot.capabilities)
        if expected.ends_session:
            assert [body.message for body in talk.bodies(events.Ack) if body.do == "quit"] == ["The session ends."]
        else:
            the_history_is_true(trial, interruption.scope, await snapshot(talk, "after"))

    converse(test, f"session.busy={interruption.busy}", voice=SlowVoice())


def watch_the_ears(talk: Conversation) -> list[tuple[State, bool]]:
    """Every state that is entered, and whether the session overhears in it."""
    seen: list[tuple[State, bool]] = [(talk.session.state, talk.hearing.overhearing)]

    def see(event: events.Event) -> None:
        if isinstance(event.body, events.StateChanged):
            seen.append((event.body.state, talk.hearing.overhearing))

    talk.on_event = see
    return seen


async def send(talk: Conversation, scene: Scene, expected: Consequence, command: Command) -> Trial:
    before = await snapshot(talk, "before")
    last = [event for event in talk.seen if isinstance(event.body, events.StateChanged)][-1:]
    turn = last[0].turn if last and not last[0].body.result else None  # type: ignore[attr-defined]
    trial = Trial(
        talk, scene, expected, turn, len(talk.seen), asyncio.get_running_loop().time(), talk.epoch.current,
        len(talk.robot.arm_moves), before,
    )  # fmt: skip
    assert (turn is None) == (scene.reach is rest)
    talk.send(structs.replace(command, epoch=talk.epoch.current) if isinstance(command, Halted) else command)
    return trial


async def snapshot(talk: Conversation, key: str) -> Mapping[str, Any]:
    talk.send(Snapshot(id=key))
    ack = await talk.until(events.Ack, lambda body: body.id == key)
    assert ack.snapshot is not None
    return ack.snapshot


# What is checked


def the_states_follow(trial: Trial) -> None:
    own = trial.scene.path if trial.left_alone else ()
    changes = [event.body for event in trial.talk.seen[trial.sent :] if isinstance(event.body, events.StateChanged)]
    assert tuple(change.state for change in changes) == own + trial.expected.path


def every_turn_has_one_result(trial: Trial) -> None:
    results = [body.result for body in trial.later(events.StateChanged, own=True) if body.result is not None]
    if trial.turn is not None:
        (result,) = results
        assert result.outcome == (trial.scene.outcome if trial.left_alone else trial.expected.turn)
        if trial.expected.turn == "interrupted":
            assert result.exit_code == ExitCode.INTERRUPTED
    others = [body.result.outcome for body in trial.later(events.StateChanged) if body.result is not None]
    assert others == ["done"] * bool(trial.expected.does or trial.expected.says or trial.expected.new_cycle)


def every_action_ends_once(trial: Trial, code: str) -> None:
    started = [body.action for body in trial.talk.bodies(events.ActionStarted)]
    finished = [body.action for body in trial.talk.bodies(events.ActionFinished)]
    assert sorted(started) == sorted(finished)
    ends = [(body.name, body.outcome, body.error_code) for body in trial.later(events.ActionFinished, own=True)]
    if trial.left_alone:
        assert all(outcome == "ok" for _, outcome, _ in ends)
    else:
        assert ends == ([(trial.scene.running, "interrupted", code)] if trial.scene.running else [])
        assert trial.later(events.ActionStarted, own=True) == []
    others = [(body.name, body.outcome) for body in trial.later(events.ActionFinished)]
    assert others == [(name, "ok") for name in trial.expected.does]


def what_was_being_said_is_cut(trial: Trial) -> None:
    said = trial.later(events.SpeechEnded, own=True)
    if trial.left_alone:
        assert all(body.outcome == "ok" and body.heard == body.text for body in said)
    else:
        heard = [trial.scene.heard] if trial.scene.heard else []
        assert [(body.heard, body.outcome) for body in said] == [(text, "interrupted") for text in heard]
        assert trial.later(events.SpeechStarted, own=True) == []


def nothing_of_the_past_moves(trial: Trial) -> None:
    robot = trial.talk.robot
    state = robot.state()  # first: it writes down what has moved until now
    moved = {epoch for when, epoch, _ in robot.moved if when > trial.moment}
    assert not trial.expected.raised or all(epoch > trial.epoch for epoch in moved)
    moves = trial.expected.does or trial.expected.by_hand or (trial.left_alone and trial.scene.running)
    assert bool(moved) == bool(moves)
    arm = [(joints, speed) for _, _, joints, speed in robot.arm_moves[trial.arm :]]
    assert arm == ([(ARM_INITIAL, ARM_RETURN_SPEED)] if trial.expected.arm_home else [])
    assert state.joints == (ARM_INITIAL if trial.expected.arm_home else ARM_UP)


def what_was_asked_for_happens(trial: Trial) -> None:
    expected = trial.expected
    said = [(body.text, body.outcome) for body in trial.later(events.SpeechEnded)]
    assert said == [(text, "ok") for text in expected.says]
    recordings = ["restarted" if body.restarted else "new" for body in trial.later(events.ListenStarted)]
    assert recordings == list(expected.recordings)
    errors = [body.message for body in trial.talk.bodies(events.ErrorRaised)]
    assert errors == ([expected.error] if expected.error else [])
    assert len(trial.talk.bodies(events.TaskEnded)) == int(expected.new_cycle)


def the_history_is_true(trial: Trial, scope: str, after: Mapping[str, Any]) -> None:
    scene, history, past = trial.scene, after["history"], trial.before["history"]
    if trial.expected.new_cycle:
        assert (after["cycle"], history) == (trial.before["cycle"] + 1, [])
        return
    assert (after["cycle"], history[: len(past)]) == (trial.before["cycle"], past)
    own = [entry for entry in history if entry["turn"] == trial.turn]
    cut = [entry for entry in own if entry.get("cut_off")]
    done = [(entry["action"].partition("(")[0], entry["outcome"]) for entry in own if "action" in entry]
    interrupted = [entry["interrupted"] for entry in own if "interrupted" in entry]
    never = [entry["never_started"] for entry in own if "never_started" in entry]
    if trial.turn is None or trial.left_alone:
        assert (interrupted, cut, never) == ([], [], [])
        return
    nobody_has_said_anything = trial.before["state"] in ("LISTENING", "TRANSCRIBING")
    assert interrupted == ([] if nobody_has_said_anything else [scope])
    assert [entry["answered"] for entry in cut] == ([scene.heard] if scene.heard else [])
    assert done == [(name, "ok") for name in scene.done] + ([(scene.running, "interrupted")] if scene.running else [])
    assert never == ([[scene.never]] if scene.never else [])


# The table itself


def test_the_table_has_a_cell_for_every_state_and_every_interruption() -> None:
    states = [state for row in WHAT_HAPPENS for state in row]
    assert sorted(states) == sorted(get_args(State)) == sorted(SCENES)
    assert all(list(row) == list(INTERRUPTIONS) for row in WHAT_HAPPENS.values())
    assert {phrase for row in WHAT_HAPPENS.values() for phrase in row.values()} == set(CONSEQUENCES)


def test_the_readme_shows_the_table() -> None:
    _, _, rest = README.read_text(encoding="utf-8").partition("<!-- python -m tests.session.matrix -->\n")
    table, end, _ = rest.partition("\n<!-- end -->")
    assert end
    assert table == markdown(), "print it with: python -m tests.session.matrix"
