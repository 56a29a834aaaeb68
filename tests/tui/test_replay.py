"""The console without an engine: what a real one told in a whole task is told again, and shown as it was."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import get_args

import pytest

from engine import events as ev
from tests.tui.desk import console
from tests.tui.replay import RECORDINGS, Replay, read

WHOLE_TASK = RECORDINGS / "whole_task.jsonl"
"""Spoken and typed requests, two layers of models, a failure, a question, an interruption, a refusal, and a silence."""

MARKS: tuple[tuple[type[ev.Body], Callable[..., object], tuple[str, ...]], ...] = (
    (ev.SessionStarted, lambda body: body, ("LOADING", "starting")),
    (ev.Log, lambda body: body.source == "recogniser", ("READY", "not listening")),
    (ev.TranscriptPartial, lambda body: body.stable_words, ("LISTENING", "move forward, one")),
    (ev.ActionProgress, lambda body: body.fraction, ("ACTING", "move_forward(", "0.05 of 1.00 m")),
    (ev.TaskEnded, lambda body: body, ("Moved 1.00 m forward.", "new task")),
    (ev.StateChanged, lambda body: body.state == "DECIDING", ("DECIDING", "it would be lovely to see you")),
    (ev.DecisionMade, lambda body: body, ("go to the kitchen", "look around")),
    (ev.ActionProgress, lambda body: (body.fraction or 0) > 0.5, ("ACTING", "navigation(A)", "1.1 m to the")),
    (ev.StateChanged, lambda body: body.state == "FEEDBACK", ("CHECKING", "putdown()", "I hold nothing that")),
    (ev.StateChanged, lambda body: body.state == "WAITING", ("READY", "I am in the kitchen, and my gripper")),
    (ev.ClarificationAsked, lambda body: body, ("Which thing do you mean?",)),
    (ev.ActionProgress, lambda body: (body.fraction or 0) > 0.5, ("ACTING", "pick_object(red box)", "52% seen")),
    (ev.StateChanged, lambda body: body.state == "WAITING", ("READY", "stopped", "interrupted")),
    (ev.RefusalMade, lambda body: body, ("refused", "I won't do that: something could get")),
    (ev.ListenStarted, lambda body: body, ("LISTENING",)),
    (ev.SessionEnded, lambda body: body, ("ENDED", "q quits")),
)
"""What the engine told last, and what stands on the screen then."""


@pytest.mark.parametrize("size", [(120, 40), (80, 24)], ids=["120x40", "80x24"])
async def test_a_recorded_session_is_shown_as_it_was_told(size: tuple[int, int]) -> None:
    replay = Replay(read(WHOLE_TASK))
    async with console(replay, size=size) as desk:
        for kind, met, shown in MARKS:
            event = replay.until(kind, met)
            await desk.until(lambda: desk.app.shown.parts == replay.parts)
            await desk.settled()
            for words in shown:
                assert words in desk.text, f"after event {event.seq}, {event.kind}:\n{desk.text}"


def test_the_recording_leads_through_every_state() -> None:
    assert set(_states()) == set(get_args(ev.State))


def _states() -> Iterator[ev.State]:
    for event in read(WHOLE_TASK):
        if isinstance(event.body, ev.StateChanged):
            yield event.body.state
