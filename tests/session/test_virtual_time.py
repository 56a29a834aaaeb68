"""A conversation of two minutes takes no time to test, and is the same every time."""

from __future__ import annotations

import asyncio
from itertools import count
from typing import Any

from engine.commands import Interrupt, Say, Wake
from engine.events import to_dict
from tests.session.conversation import Conversation, SlowVoice, converse


async def two_minutes(talk: Conversation) -> list[dict[str, Any]]:
    """Speech, text, interruptions and answers; everything that happened."""
    talk.planner.decide_s, talk.planner.plan_s = 0.4, 0.9
    for request in ("turn left 90 degrees, go forward 2 metres", "go to the moon", "raise your arm and nod"):
        talk.send(Wake("key"))
        await talk.until_state("LISTENING")
        await talk.pass_time(1.0)
        talk.hearing.speak(request)
        await talk.pass_time(14.0)
    talk.send(Say("go to the bedroom"))
    await talk.pass_time(4.0)
    talk.send(Interrupt())
    talk.send(Say("end the current task"))
    await talk.pass_time(120.0 - asyncio.get_running_loop().time())
    return [to_dict(event) for event in talk.seen]


def without_ids(events: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Events with ids by the order of their first appearance, and without durations of real time."""
    names: dict[str, str] = {}
    numbers = count(1)

    def renamed(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: renamed(item) for key, item in value.items()}
        if isinstance(value, str) and len(value) == 26 and value.isalnum():
            return names.setdefault(value, f"id {next(numbers)}")
        return value

    return [renamed(event) for event in events]


def test_the_same_conversation_gives_the_same_events_at_the_same_times() -> None:
    first, second = (without_ids(converse(two_minutes, voice=SlowVoice())) for _ in range(2))
    assert first == second
    assert len(first) > 50
    assert first[-1]["t"] > 45.0
    outcomes = [event["body"]["outcome"] for event in first if event["kind"] == "action.finished"]
    assert outcomes.count("ok") >= 3
    assert outcomes.count("interrupted") == 1
