"""Questions to the robot about itself are answered from what the session has on record."""

from __future__ import annotations

import pytest

from engine import events
from engine.commands import Interrupt, Say
from engine.errors import ExitCode
from tests.session.conversation import Conversation, converse


async def told(talk: Conversation, question: str, number: int) -> str:
    """What the robot answers, as the turn of this number."""
    talk.send(Say(question))
    return (await talk.result(number)).message


def test_it_knows_why_it_stopped_and_what_it_did() -> None:
    async def test(talk: Conversation) -> None:
        assert await told(talk, "what have you done so far?", 1) == "I have done nothing in this task yet."
        talk.send(Say("turn left 90 degrees, then go forward 10 metres"))
        await talk.until(events.ActionStarted, lambda body: body.name == "move_forward")
        await talk.pass_time(1.0)
        talk.send(Interrupt())
        assert (await talk.result(2)).exit_code == ExitCode.INTERRUPTED
        assert await told(talk, "why did you stop?", 3) == "Because you interrupted me."
        assert "Turned" in await told(talk, "what did you just do?", 4)
        assert await told(talk, "what are you holding?", 5) == "I hold nothing."
        assert (await told(talk, "how is your battery?", 6)).startswith("I don't know")
        assert await told(talk, "你为什么停了？", 7) == "因为您打断了我。"

    converse(test)


def test_continue_does_what_is_left_of_a_motion_that_was_cut_and_what_never_started() -> None:
    async def test(talk: Conversation) -> None:
        assert "nothing that I could go on with" in await told(talk, "continue", 1)
        talk.send(Say("go forward 2 metres, then wave"))
        await talk.until(events.ActionStarted)
        await talk.pass_time(2.0)
        talk.send(Interrupt())
        await talk.result(2)
        assert 0.3 < talk.robot.state().pose.x < 1.0
        assert (await told(talk, "carry on please", 3)).startswith("Moved 1.4")
        assert abs(talk.robot.state().pose.x - 2.0) < 0.02

    converse(test)


def test_continue_begins_what_was_cut_anew_where_it_is_no_matter_of_how_much() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("wait 20 seconds, then wave and beep"))
        await talk.until(events.ActionFinished, lambda body: body.name == "wait")
        await talk.until(events.ActionStarted, lambda body: body.name == "arm_shake")
        talk.send(Interrupt())
        await talk.result(1)
        talk.send(Say("continue"))
        assert (await talk.result(2)).exit_code == ExitCode.DONE
        names = [body.name for body in talk.bodies(events.ActionFinished)]
        assert names[-3:] == ["arm_shake", "arm_shake", "beep"]

    converse(test)


@pytest.mark.parametrize(
    ("text", "more", "told"),
    [("drift, then wave", "continue", "in the middle of drifting"), ("漂移，然后挥手", "继续", "在做漂移的时候")],
)
def test_continue_asks_about_a_motion_of_which_nobody_knows_how_much_is_left(text: str, more: str, told: str) -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say(text))
        await talk.until(events.ActionStarted)
        await talk.pass_time(1.0)
        talk.send(Interrupt())
        await talk.result(1)
        talk.send(Say(more))
        asked = await talk.result(2)
        assert asked.exit_code == ExitCode.CLARIFY
        assert told in asked.message
        assert "(" not in asked.message, "not as a program writes it"
        assert talk.robot.state().twist.is_zero

    converse(test)
