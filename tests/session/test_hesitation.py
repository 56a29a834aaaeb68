"""What may have been a stop pauses the robot until somebody knows: then it has stopped, or goes on as before."""

from __future__ import annotations

import asyncio

import pytest

from engine import events
from engine.commands import Heard, Interrupt, Say, Wake
from engine.errors import ExitCode
from engine.robot.robot import PAUSE_LIMIT_S, UNDECIDED
from tests.session.conversation import Conversation, SlowVoice, converse


async def driving(talk: Conversation, text: str = "go forward 2 metres") -> None:
    """Ask for a drive and let it run for two seconds."""
    talk.send(Say(text))
    await talk.until_state("ACTING")
    await talk.pass_time(2.0)
    assert not talk.robot.state().twist.is_zero


def test_a_suspicion_pauses_the_robot_before_the_call_returns() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.hesitation.suspect("stop", sure=True)
        assert talk.robot.state().twist.is_zero
        assert talk.robot.paused
        assert talk.bodies(events.MotionPaused) == [events.MotionPaused("word", "stop")]
        assert talk.ducked == [True]
        await talk.pass_time(0.1)
        assert talk.hearing.suspected == ["stop"]
        talk.hearing.settle()

    converse(test)


def test_a_stop_that_is_confirmed_is_a_stop_and_no_false_pause() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.hesitation.suspect("stop", sure=True)
        await talk.pass_time(0.2)
        await asyncio.to_thread(talk.send, Heard("Stop."))
        talk.hearing.settle()
        stopped = await talk.result()
        assert stopped.exit_code == ExitCode.INTERRUPTED
        await talk.pass_time(5.0)
        assert not talk.robot.paused
        assert not talk.bodies(events.MotionResumed)
        assert talk.hesitation.false_pauses == 0
        assert talk.robot.state().pose.x < 1.0
        assert talk.ducked[-1] is False

    converse(test)


def test_motion_goes_on_after_a_false_pause_and_arrives_as_if_it_had_not_been() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        for number in (1, 2):
            talk.hesitation.suspect("stop", sure=True)
            before = talk.robot.state().pose.x
            await talk.pass_time(0.3)
            assert talk.robot.state().pose.x == before
            talk.hearing.settle()
            await talk.pass_time(0.5)
            assert talk.robot.state().pose.x > before
            assert talk.bodies(events.MotionResumed)[-1] == events.MotionResumed("not_a_stop", 0.3, number)
        result = await talk.result()
        assert result.exit_code == ExitCode.DONE
        assert talk.robot.state().pose.x == pytest.approx(2.0, abs=0.02)
        assert not talk.bodies(events.InterruptRaised)

    converse(test)


def test_of_what_may_well_be_something_else_the_recogniser_is_asked_and_motion_goes_on() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.hesitation.suspect("stop", sure=False)
        assert not talk.robot.paused
        await talk.pass_time(0.1)
        assert talk.hearing.suspected == ["stop"]
        talk.hearing.settle()
        assert not talk.bodies(events.MotionPaused)
        assert not talk.bodies(events.MotionResumed)
        assert True not in talk.ducked

    converse(test)


@pytest.mark.parametrize("stop", [True, False])
def test_what_becomes_likelier_pauses_the_robot_until_it_is_known(stop: bool) -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.hesitation.suspect("停", sure=False)
        await talk.pass_time(0.2)
        talk.hearing.grow_likelier()
        assert talk.robot.state().twist.is_zero
        assert talk.bodies(events.MotionPaused) == [events.MotionPaused("word", "停")]
        await talk.pass_time(0.2)
        if stop:
            await asyncio.to_thread(talk.send, Heard("停"))
        talk.hearing.settle()
        result = await talk.result()
        assert result.exit_code == (ExitCode.INTERRUPTED if stop else ExitCode.DONE)
        assert talk.hesitation.false_pauses == (not stop)
        assert not talk.robot.paused
        assert talk.ducked[-1] is False

    converse(test)


@pytest.mark.parametrize("answers", [True, False])
def test_what_becomes_likelier_late_does_not_leave_the_voice_quiet(answers: bool) -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("colourless green ideas"))  # it takes a while to say why not
        await talk.until(events.SpeechStarted)
        talk.hesitation.suspect("停", sure=False)
        await talk.pass_time(PAUSE_LIMIT_S + 0.1)
        talk.hearing.grow_likelier()
        assert talk.ducked[-1] is True
        if answers:
            talk.hearing.settle()
        else:
            await talk.pass_time(PAUSE_LIMIT_S + 0.1)
        assert talk.ducked[-1] is False

    converse(test, voice=SlowVoice())


def test_what_becomes_likelier_once_the_robot_rests_pauses_nothing() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.hesitation.suspect("停", sure=False)
        await talk.pass_time(0.1)
        talk.send(Interrupt())
        await talk.result()
        talk.hearing.grow_likelier()
        assert not talk.bodies(events.MotionPaused)
        assert not talk.robot.paused
        assert True not in talk.ducked

    converse(test)


def test_an_interrupt_in_a_pause_is_an_interrupt_and_nothing_is_resumed() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.hesitation.suspect("stop", sure=True)
        await talk.pass_time(0.1)
        talk.send(Interrupt())
        assert not talk.robot.paused, "the new epoch may move"
        talk.hearing.settle()
        assert (await talk.result()).exit_code == ExitCode.INTERRUPTED
        at = talk.robot.state().pose.x
        await talk.pass_time(5.0)
        assert talk.robot.state().pose.x == at
        assert not talk.bodies(events.MotionResumed)
        talk.send(Say("go forward 1 metre"))
        await talk.result(2)
        assert talk.robot.state().pose.x == pytest.approx(at + 1.0, abs=0.02)

    converse(test)


def test_a_wake_in_a_pause_sends_the_arm_home_and_listens() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.hesitation.suspect("stop", sure=True)
        await talk.pass_time(0.1)
        talk.send(Wake("key"))
        await talk.until_state("LISTENING")
        assert len(talk.robot.arm_moves) == 1
        assert not talk.bodies(events.MotionResumed)

    converse(test)


def test_a_recogniser_that_never_answers_leaves_the_robot_standing() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.hesitation.suspect("stop", sure=True)
        at = talk.robot.state().pose.x
        await talk.pass_time(PAUSE_LIMIT_S - 0.1)
        assert not talk.results
        result = await talk.result()
        assert result.exit_code == ExitCode.FAILED
        assert UNDECIDED in result.message
        await talk.pass_time(5.0)
        assert talk.robot.state().pose.x == at
        assert not talk.bodies(events.MotionResumed)
        talk.hearing.settle()  # far too late
        assert not talk.bodies(events.MotionResumed)

    converse(test)


def test_after_a_pause_that_nobody_settled_the_next_one_pauses_again() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.hesitation.suspect("stop", sure=True)
        await talk.result()
        talk.send(Say("go forward 2 metres"))
        await talk.pass_time(1.0)
        assert not talk.robot.state().twist.is_zero
        talk.hesitation.suspect("stop", sure=True)
        assert talk.robot.paused
        talk.hearing.settle()

    converse(test)


def test_a_word_that_is_suspected_again_in_a_pause_is_the_same_pause() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.hesitation.suspect("stop", sure=True)
        await talk.pass_time(0.2)
        talk.hesitation.suspect("stop", sure=True)
        await talk.pass_time(0.2)
        talk.hearing.settle()
        assert len(talk.bodies(events.MotionPaused)) == 1
        assert talk.bodies(events.MotionResumed) == [events.MotionResumed("not_a_stop", 0.4, 1)]

    converse(test)


def test_while_it_only_speaks_it_is_quieter_and_nothing_is_paused() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("stop"))  # it answers
        await talk.until(events.SpeechStarted)
        assert talk.session.state == "SPEAKING"
        talk.hesitation.suspect("stop", sure=True)
        await talk.pass_time(0.2)
        assert talk.ducked == [True]
        assert not talk.robot.paused
        talk.hearing.settle()
        assert talk.ducked == [True, False]
        assert not talk.bodies(events.MotionPaused)
        assert not talk.bodies(events.MotionResumed)

    converse(test, voice=SlowVoice())


def test_a_voice_is_not_left_quiet_by_a_recogniser_that_never_answers() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("what can you do?"))
        await talk.until(events.SpeechStarted)
        talk.hesitation.suspect("stop", sure=True)
        await talk.pass_time(PAUSE_LIMIT_S + 0.1)
        assert talk.ducked == [True, False]

    converse(test, voice=SlowVoice())


def test_a_robot_at_rest_is_not_paused_and_nobody_is_asked() -> None:
    async def test(talk: Conversation) -> None:
        talk.hesitation.suspect("stop", sure=True)
        await talk.pass_time(0.1)
        assert not talk.robot.paused
        assert talk.hearing.suspected == []
        assert talk.ducked == []

    converse(test)


def test_without_anybody_who_could_confirm_it_motion_goes_on() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.hearing.overhear(False)
        talk.hesitation.suspect("stop", sure=True)
        assert not talk.robot.paused
        assert not talk.bodies(events.MotionPaused)

    converse(test)
