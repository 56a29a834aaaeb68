"""What interruptions do to a turn: the robot first, then the books, then whatever was asked for."""

from __future__ import annotations

import asyncio

import pytest

from engine import events
from engine.commands import Command, EndTask, Interrupt, Quit, Say, Snapshot, Wake
from engine.errors import DeviceError, ExitCode
from engine.events import State
from engine.parts.part import Part
from engine.plan import Plan
from engine.planner.happened import in_words
from engine.planner.request import Noted, Ran, Said
from engine.robot.arm import ARM_INITIAL
from engine.session.session import TurnOver
from tests.session.conversation import Conversation, SlowVoice, converse


async def driving(talk: Conversation, text: str = "go forward 10 metres then turn left") -> None:
    """Ask for a long drive and let it run for two seconds."""
    talk.send(Say(text))
    await talk.until(events.ActionStarted)
    await talk.pass_time(2.0)
    assert not talk.robot.state().twist.is_zero


def test_a_plain_request_is_planned_driven_and_reported() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("go forward 1 metre"))
        result = await talk.result()
        assert result.exit_code == ExitCode.DONE
        assert abs(talk.robot.state().pose.x - 1.0) < 0.02
        finished = talk.bodies(events.ActionFinished)
        assert [(body.name, body.outcome) for body in finished] == [("move_forward", "ok")]
        (started,) = talk.bodies(events.ActionStarted)
        assert started.robot_t is not None
        assert 0 < finished[0].duration_s <= talk.robot.state().t - started.robot_t + 0.001
        assert talk.session.state == "WAITING"

    converse(test)


def test_an_interrupt_stops_the_robot_before_the_call_returns() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.send(Interrupt())
        assert talk.robot.state().twist.is_zero  # no loop, no queue, no waiting in between
        assert (await talk.result()).exit_code == ExitCode.INTERRUPTED

    converse(test)


def test_an_interrupted_action_ends_once_and_the_next_one_never_starts() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.send(Interrupt())
        await talk.result()
        await talk.pass_time(5.0)
        finished = talk.bodies(events.ActionFinished)
        assert [(body.name, body.outcome, body.error_code) for body in finished] == [
            ("move_forward", "interrupted", "cancelled")
        ]
        assert len(talk.bodies(events.ActionStarted)) == 1
        assert "at x 0.60 m" in finished[0].message  # it says where the robot is now

    converse(test)


def test_nothing_of_an_old_epoch_moves_the_robot_again() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        before = talk.epoch.current
        talk.send(Interrupt())
        stopped = asyncio.get_running_loop().time()
        await talk.pass_time(30.0)
        assert all(when <= stopped for when, _, _ in talk.robot.moved)
        assert all(epoch <= before for _, epoch, _ in talk.robot.moved)

    converse(test)


def test_the_interruption_is_on_record_after_the_stop_and_with_the_new_epoch() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.send(Interrupt())
        await talk.result()
        raised = next(event for event in talk.seen if isinstance(event.body, events.InterruptRaised))
        assert raised.epoch == talk.epoch.current
        assert isinstance(raised.body, events.InterruptRaised)
        assert (raised.body.scope, raised.body.state) == ("interrupt", "ACTING")

    converse(test)


def test_stop_as_text_stops_without_a_plan_and_answers() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.send(Say("Stop!"))
        assert talk.robot.state().twist.is_zero
        assert (await talk.result(1)).exit_code == ExitCode.INTERRUPTED
        assert (await talk.result(2)).exit_code == ExitCode.DONE
        assert len(talk.bodies(events.PlanMade)) == 1

    converse(test)


@pytest.mark.parametrize("drives", [True, False])
def test_a_wake_without_a_microphone_stops_the_robot_and_says_both(drives: bool) -> None:
    async def test(talk: Conversation) -> None:
        microphone = talk.session._needs.hearing
        assert isinstance(microphone, Part)
        microphone.fail(DeviceError("There is no microphone.", hint="Type."))
        if drives:
            await driving(talk)
        talk.send(Wake("key"))
        assert talk.robot.state().twist.is_zero
        error = await talk.until(events.ErrorRaised)
        stopped = " The robot has stopped what it was doing." if drives else ""
        assert (error.message, error.hint) == (f"There is no microphone.{stopped}", "Type.")
        assert (await talk.result(1 + drives)).message == f"There is no microphone.{stopped} Type."

    converse(test)


def test_a_new_command_replaces_the_running_one_by_default() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.send(Say("turn left 90 degrees"))
        assert (await talk.result(1)).outcome == "interrupted"
        assert (await talk.result(2)).outcome == "done"

    converse(test)


def test_a_new_command_waits_its_turn_where_the_setting_says_queue() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("go forward 1 metre"))
        talk.send(Say("turn left 90 degrees"))
        assert (await talk.result(1)).outcome == "done"
        assert (await talk.result(2)).outcome == "done"
        assert [body.name for body in talk.bodies(events.ActionFinished)] == ["move_forward", "move_left"]

    converse(test, "session.busy=queue")


@pytest.mark.parametrize("command", [Interrupt(), EndTask(), Wake("key"), Say("stop")])
def test_what_waits_never_starts_when_somebody_interrupts_in_the_moment_in_which_a_turn_ends(command: Command) -> None:
    async def test(talk: Conversation) -> None:
        await drive_with_others_waiting(talk, command)
        await talk.until(events.StateChanged, lambda body: body.state != "ACTING")
        await talk.pass_time(30)
        assert [body.name for body in talk.bodies(events.ActionStarted)] == ["move_forward"]
        assert len(talk.bodies(events.PlanMade)) == 1
        assert talk.robot.state().twist.is_zero

    converse(test, "session.busy=queue")


def test_what_is_asked_in_the_moment_in_which_a_turn_ends_comes_after_what_waits_already() -> None:
    async def test(talk: Conversation) -> None:
        await drive_with_others_waiting(talk, Say("raise your arm"))
        await talk.result(4)
        started = [body.name for body in talk.bodies(events.ActionStarted)]
        assert started == ["move_forward", "beep", "move_left", "arm_up"]

    converse(test, "session.busy=queue")


async def drive_with_others_waiting(talk: Conversation, command: Command) -> None:
    """A drive, with two requests behind it, and then ``command``, once the drive has ended but nobody knows yet."""
    talk.send(Say("go forward 0.2 metres"))
    await talk.until_state("ACTING")
    for text in ("beep", "turn left 90 degrees"):
        talk.send(Say(text))
    inbox = talk.session._inbox
    put = inbox.put

    def between(news: TurnOver) -> None:
        inbox.put = put  # type: ignore[method-assign]
        talk.send(command)  # another thread, in this very moment
        put(news)

    inbox.put = between  # type: ignore[method-assign]


def test_what_waits_is_dropped_by_an_interruption() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.send(Say("turn left 90 degrees", id="second"))
        await talk.pass_time(0.5)
        talk.send(Interrupt())
        ack = await talk.until(events.Ack, lambda body: body.id == "second")
        assert not ack.ok
        await talk.pass_time(10.0)
        assert len(talk.bodies(events.PlanMade)) == 1

    converse(test, "session.busy=queue")


def test_what_waits_is_told_whenever_that_changes() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        for text in ("turn left 90 degrees", "beep"):
            talk.send(Say(text))
        talk.send(Snapshot())
        snapshot = (await talk.until(events.Ack, lambda body: body.do == "snapshot")).snapshot
        assert snapshot is not None
        assert snapshot["waiting"] == ["turn left 90 degrees", "beep"]
        await talk.result(3)
        assert [body.texts for body in talk.bodies(events.RequestsWaiting)] == [
            ("turn left 90 degrees",),
            ("turn left 90 degrees", "beep"),
            ("beep",),
            (),
        ]
        assert not talk.bodies(events.RequestsDropped)

    converse(test, "session.busy=queue")


@pytest.mark.parametrize("command", [Interrupt(), EndTask(), Wake("key"), Say("stop")])
def test_an_interruption_tells_which_waiting_requests_it_dropped(command: Command) -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        for text in ("turn left 90 degrees", "beep"):
            talk.send(Say(text))
        await talk.until(events.RequestsWaiting, lambda body: len(body.texts) == 2)
        talk.send(command)
        assert (await talk.until(events.RequestsDropped)).texts == ("turn left 90 degrees", "beep")
        await talk.until(events.RequestsWaiting, lambda body: not body.texts)

    converse(test, "session.busy=queue")


@pytest.mark.parametrize("busy", ["interrupt", "queue"])
def test_requests_that_were_asked_for_at_once_are_done_one_after_the_other(busy: str) -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("go forward 1 metre", "it", then=("turn left 90 degrees", "end the task", "beep")))
        await talk.until(events.TaskEnded)
        assert [body.name for body in talk.bodies(events.ActionFinished)] == ["move_forward", "move_left"]
        await talk.until(events.ActionFinished, lambda body: body.name == "beep")
        assert [body.ok for body in talk.bodies(events.Ack) if body.id == "it"] == [True] * 4
        assert not talk.bodies(events.InterruptRaised)

    converse(test, f"session.busy={busy}")


def test_a_new_command_drops_what_was_to_follow_the_one_that_it_replaces() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("go forward 10 metres", then=("beep", "turn left 90 degrees")))
        await talk.until(events.ActionStarted)
        talk.send(Say("raise your arm", then=("lower your arm",)))
        assert (await talk.until(events.RequestsDropped)).texts == ("beep", "turn left 90 degrees")
        assert (await talk.result(2)).outcome == "done"
        assert (await talk.result(3)).outcome == "done"
        assert [body.name for body in talk.bodies(events.ActionStarted)] == ["move_forward", "arm_up", "arm_down"]

    converse(test)


def test_requests_that_were_asked_for_at_once_are_turned_away_at_once() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.send(Say("turn left 90 degrees", id="second", then=("beep",)))
        assert not (await talk.until(events.Ack, lambda body: body.id == "second")).ok
        await talk.result()
        assert [body.name for body in talk.bodies(events.ActionStarted)] == ["move_forward", "move_left"]
        assert not talk.bodies(events.RequestsWaiting)

    converse(test, "session.busy=reject")


def test_a_new_command_is_turned_away_where_the_setting_says_reject() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.send(Say("turn left 90 degrees", id="second"))
        ack = await talk.until(events.Ack, lambda body: body.id == "second")
        assert not ack.ok
        assert not talk.robot.state().twist.is_zero

    converse(test, "session.busy=reject")


def test_end_task_stops_sends_the_arm_home_and_begins_a_new_cycle() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("raise your arm"))
        await talk.result(1)
        await driving(talk)
        talk.send(EndTask())
        await talk.until(events.TaskEnded)
        await talk.pass_time(0.1)
        assert talk.robot.state().joints == ARM_INITIAL
        assert talk.robot.state().twist.is_zero
        assert talk.session.state == "IDLE"
        talk.send(Snapshot(id="after"))
        ack = await talk.until(events.Ack, lambda body: body.id == "after")
        assert ack.snapshot is not None
        assert (ack.snapshot["cycle"], ack.snapshot["history"]) == (2, [])

    converse(test)


def test_a_sentence_that_ends_the_task_does_what_the_key_does() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.send(Say("End the current task."))
        assert talk.robot.state().twist.is_zero
        await talk.until(events.TaskEnded)
        assert talk.session.state == "IDLE"

    converse(test)


def test_the_history_says_what_ran_what_was_cut_and_what_never_started() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("turn left 90 degrees, go forward 10 metres, beep"))
        await talk.until(events.ActionStarted, lambda body: body.name == "move_forward")
        await talk.pass_time(1.0)
        talk.send(Interrupt())
        await talk.result()
        talk.send(Snapshot(id="now"))
        ack = await talk.until(events.Ack, lambda body: body.id == "now")
        assert ack.snapshot is not None
        history = ack.snapshot["history"]
        assert [entry["outcome"] for entry in history if "action" in entry] == ["ok", "interrupted"]
        assert history[-1]["never_started"] == ["beep(0.2)"]

    converse(test)


def test_the_next_request_tells_the_planner_what_ran_what_was_cut_where_and_what_never_started() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("turn left 90 degrees, go forward 10 metres, beep"))
        await talk.until(events.ActionStarted, lambda body: body.name == "move_forward")
        await talk.pass_time(1.0)
        talk.send(Say("turn right 90 degrees"))
        await talk.result(2)
        assert talk.planner.asked[0].happened == ()
        said, plan, *rest = talk.planner.asked[1].happened
        assert said == Said("turn left 90 degrees, go forward 10 metres, beep")
        assert isinstance(plan, Plan)
        assert list(map(str, plan.actions)) == ["move_left(90, 1)", "move_forward(10, 0.3)", "beep(0.2)"]
        assert [in_words(entry) for entry in rest if isinstance(entry, Ran | Noted)] == [
            "move_left(90, 1) ok. Turned 90° left.",
            "Interruption: the user gave another command.",
            "move_forward(10, 0.3) interrupted. Driving 10 metres forward: stopped at x 0.00 m, y 0.30 m.",
            "Never started: beep(0.2).",
        ]

    converse(test)


def test_an_interrupted_answer_is_recorded_up_to_the_last_word_that_was_played() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("go to the moon"))
        await talk.until(events.SpeechStarted)
        await talk.pass_time(1.0)
        talk.send(Interrupt())
        await talk.result()
        (ended,) = talk.bodies(events.SpeechEnded)
        assert (ended.outcome, ended.heard) == ("interrupted", "I don't know a")
        talk.send(Say("beep"))
        await talk.result(2)
        told = Noted("The robot said, before it was cut off: I don't know a")
        assert told in talk.planner.asked[1].happened

    converse(test, voice=SlowVoice())


def test_the_time_limit_of_a_turn_stops_the_robot_and_exits_with_4() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("go forward 10 metres"))
        assert (await talk.result()).exit_code == ExitCode.TIMEOUT
        assert talk.robot.state().twist.is_zero
        assert talk.bodies(events.ActionFinished)[0].outcome == "interrupted"

    converse(test, "session.turn_limit_s=3")


def test_a_lost_robot_leaves_an_uncertain_outcome_and_exit_code_3() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.robot.lost = True
        assert (await talk.result()).exit_code == ExitCode.MISSING
        assert [body.outcome for body in talk.bodies(events.ActionFinished)] == ["uncertain"]

    converse(test)


def test_quitting_in_mid_drive_ends_the_action_first() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.send(Quit())
        assert talk.robot.state().twist.is_zero
        assert (await talk.result()).outcome == "interrupted"

    converse(test)


def test_quitting_when_done_lets_the_drive_end() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("go forward 1 metre"))
        talk.send(Quit(drain=True))
        assert (await talk.result()).outcome == "done"
        await talk.until(events.Ack, lambda body: body.do == "quit")

    converse(test)


def test_nothing_moves_for_what_is_unknown_incomplete_or_out_of_range() -> None:
    async def test(talk: Conversation) -> None:
        expected = {
            "go to the moon": ExitCode.FAILED,
            "sing me a song": ExitCode.FAILED,
            "go forward": ExitCode.CLARIFY,
            "go forward 5 kilometres": ExitCode.REFUSED,
        }
        for number, (text, code) in enumerate(expected.items(), 1):
            talk.send(Say(text))
            assert (await talk.result(number)).exit_code == code, text
        assert talk.robot.moved == []
        assert talk.bodies(events.ActionQueued) == []

    converse(test)


@pytest.mark.parametrize("state", ["ACTING", "FEEDBACK"])
@pytest.mark.parametrize("command", [Wake("key"), Say("stop"), Say("beep"), Interrupt(), EndTask()])
def test_what_comes_while_a_dialogue_is_being_finished_finds_a_new_cycle_and_open_ears(
    command: Command, state: State
) -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("raise your arm"))
        await talk.result(1)
        await talk.wake_and_say("raise your arm and end the task")
        await talk.until(events.ActionFinished, lambda body: body.name == "finish_dialogue")
        await talk.until_state(state)
        moved = len(talk.robot.arm_moves)
        talk.send(command)
        await talk.until(events.TaskEnded)
        talk.send(Interrupt())
        talk.send(Snapshot(id="now"))
        ack = await talk.until(events.Ack, lambda body: body.id == "now")
        assert ack.snapshot is not None
        assert ack.snapshot["cycle"] >= 2
        homeward = isinstance(command, Wake | EndTask)  # after anything else the arm stays where it was stopped
        assert len(talk.robot.arm_moves) - moved == int(homeward)

    converse(test, voice=SlowVoice())


def test_a_dialogue_that_finishes_undisturbed_sends_the_arm_home() -> None:
    async def test(talk: Conversation) -> None:
        await talk.wake_and_say("raise your arm and end the task")
        await talk.until(events.TaskEnded)
        assert talk.robot.state().joints == ARM_INITIAL
        assert talk.session.state == "IDLE"

    converse(test, voice=SlowVoice())
