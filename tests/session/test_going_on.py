"""Somebody goes on who was taken to have ended: what has begun because of that is given up; both pieces are heard."""

from __future__ import annotations

import pytest

from engine import events
from engine.commands import Command, EndTask, Halted, Interrupt, Say, Wake
from engine.errors import ExitCode
from engine.robot.arm import ARM_UP
from tests.session.conversation import Conversation, SlowVoice, converse


def test_a_question_about_half_a_command_gives_way_to_the_other_half_and_nothing_else_moves() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("raise your arm"))
        await talk.result(1)
        await talk.wake_and_say("go forward")
        await talk.until_state("CLARIFYING")
        question = talk.epoch.current
        talk.send(Wake("speech", ago_s=0.3))
        assert talk.epoch.current == question + 1
        await talk.until_state("LISTENING")
        await talk.pass_time(0.1)
        talk.hearing.speak("go forward 1 metre")
        result = await talk.result(3)
        assert result.exit_code == ExitCode.DONE
        assert talk.robot.state().joints == ARM_UP  # nobody has called it away from what it does
        assert [body.name for body in talk.bodies(events.ActionStarted)] == ["arm_up", "move_forward"]
        assert [body.outcome for body in talk.bodies(events.SpeechEnded) if "how far" in body.text.casefold()] == [
            "interrupted"
        ]

    converse(test, voice=SlowVoice())


# After a request that was complete


def names(talk: Conversation) -> list[str]:
    return [body.name for body in talk.bodies(events.ActionStarted)]


def test_what_is_added_to_a_request_is_done_after_it() -> None:
    async def test(talk: Conversation) -> None:
        await talk.wake_and_say("go forward 1 metre")
        await talk.until(events.ActionStarted)
        epoch = talk.epoch.current
        assert talk.hearing.go_on("and raise your arm", adds=True)
        await talk.pass_time(0.1)
        assert [body.message for body in talk.bodies(events.Log)] == ["After this: “and raise your arm”."]
        await talk.result(2)
        assert talk.epoch.current == epoch, "nothing was interrupted"
        assert [result.exit_code for result in talk.results] == [ExitCode.DONE, ExitCode.DONE]
        assert names(talk) == ["move_forward", "arm_up"]
        assert [body.text for body in talk.bodies(events.TranscriptFinal)][1] == "and raise your arm"

    converse(test)


def test_what_is_added_when_the_request_has_been_done_is_done_at_once() -> None:
    async def test(talk: Conversation) -> None:
        await talk.wake_and_say("raise your arm")
        await talk.result(1)
        assert talk.hearing.go_on("and go forward 1 metre", adds=True)
        await talk.result(2)
        assert names(talk) == ["arm_up", "move_forward"]

    converse(test)


def test_what_makes_another_request_of_it_takes_its_place() -> None:
    async def test(talk: Conversation) -> None:
        await talk.wake_and_say("go forward 2 metres")
        await talk.until(events.ActionStarted)
        epoch = talk.epoch.current
        assert talk.hearing.go_on("no, raise your arm", adds=False)
        assert talk.epoch.current == epoch + 1, "it stands"
        await talk.result(2)
        assert names(talk) == ["move_forward", "arm_up"]
        assert [body.outcome for body in talk.bodies(events.ActionFinished)] == ["interrupted", "ok"]

    converse(test)


@pytest.mark.parametrize("adds", [True, False])
@pytest.mark.parametrize("command", [Interrupt(), Say("stop"), EndTask()])
def test_after_an_interruption_nothing_is_added(command: Command, adds: bool) -> None:
    async def test(talk: Conversation) -> None:
        await talk.wake_and_say("go forward 2 metres")
        await talk.until(events.ActionStarted)
        talk.send(command)
        epoch = talk.epoch.current
        assert talk.hearing.go_on("and raise your arm", adds=adds)
        await talk.pass_time(10)
        assert talk.epoch.current == epoch
        assert names(talk) == ["move_forward"]

    converse(test)


def test_what_waits_for_the_end_of_a_request_is_dropped_by_an_interruption() -> None:
    async def test(talk: Conversation) -> None:
        await talk.wake_and_say("go forward 2 metres")
        await talk.until(events.ActionStarted)
        assert talk.hearing.go_on("and raise your arm", adds=True)
        await talk.pass_time(0.1)
        talk.send(Interrupt())
        await talk.pass_time(10)
        assert names(talk) == ["move_forward"]

    converse(test)


@pytest.mark.parametrize("late", [False, True])
def test_what_was_to_follow_something_that_was_not_done_is_left_and_that_is_said(late: bool) -> None:
    async def test(talk: Conversation) -> None:
        await talk.wake_and_say("go forward 2 metres")
        await talk.until(events.ActionStarted)
        if late:
            talk.send(Halted("it tipped over", talk.epoch.current))
            await talk.result(1)
        assert talk.hearing.go_on("and raise your arm", adds=True)
        await talk.pass_time(0.1)
        if not late:
            talk.send(Halted("it tipped over", talk.epoch.current))
        await talk.pass_time(10)
        assert names(talk) == ["move_forward"]
        left = [body.message for body in talk.bodies(events.Log) if "is left" in body.message]
        assert left == ["“and raise your arm” is left: what it was to follow was not done."]

    converse(test)
