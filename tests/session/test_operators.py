"""What operators of real robots expect: an emergency stop that only a release ends, driving by hand, a low battery."""

from __future__ import annotations

import pytest

from engine import events
from engine.commands import Command, Drive, EndTask, EStop, Heard, Here, Interrupt, LimitSpeed, Release, Say, SetVolume
from engine.errors import ExitCode
from engine.robot.geometry import Pose
from engine.robot.robot import BatteryState
from engine.session.turn import PRESSED
from tests.session.conversation import Conversation, converse


async def driving(talk: Conversation) -> None:
    talk.send(Say("go forward 10 metres then turn left"))
    await talk.until(events.ActionStarted)
    await talk.pass_time(2.0)
    assert not talk.robot.state().twist.is_zero


# The emergency stop


@pytest.mark.parametrize("press", [EStop(), Say("emergency stop!"), Say("急停"), Heard("Emergency stop!")])
def test_the_emergency_stop_stops_at_once_and_stays(press: EStop | Say | Heard) -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.send(press)
        assert talk.robot.state().twist.is_zero
        assert talk.robot.state().estop
        assert (await talk.result()).exit_code == ExitCode.INTERRUPTED
        await talk.pass_time(1.0)
        before = talk.robot.state().pose
        talk.send(Say("go forward 1 metre"))
        await talk.until(events.ActionFinished, lambda body: body.outcome == "failed")
        assert talk.robot.state().pose == before

    converse(test)


def test_what_would_move_is_refused_with_the_reason_and_what_would_not_is_done() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(EStop(id="it"))
        assert (await talk.until(events.Ack, lambda body: body.id == "it")).message == PRESSED
        talk.send(Say("raise your arm"))
        assert (await talk.result()).message == "The emergency stop is pressed: release it first."
        talk.send(Say("what can you do"))
        assert (await talk.result(2)).outcome == "done"

    converse(test)


def test_a_release_lets_it_move_again_and_nothing_of_before_goes_on() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.send(EStop())
        await talk.result()
        talk.send(Release())
        await talk.pass_time(5.0)
        assert not talk.robot.state().estop
        before = talk.robot.state().pose
        await talk.pass_time(5.0)
        assert talk.robot.state().pose == before
        talk.send(Say("go forward 1 metre"))
        assert (await talk.result(2)).outcome == "done"
        assert talk.robot.state().pose.distance_to(before) == pytest.approx(1.0, abs=0.05)

    converse(test)


@pytest.mark.parametrize("words", ["release the emergency stop", "Please release the e-stop.", "解除急停"])
def test_words_do_not_release_it_and_the_answer_says_what_does(words: str) -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say(words))
        asked = await talk.result()
        assert (asked.outcome, asked.message) in (
            ("done", "The emergency stop is not pressed."),
            ("done", "急停没有按下。"),
        )
        talk.send(EStop())
        talk.send(Say(words))
        answer = await talk.result(2)
        assert answer.outcome == "refused"
        assert "ctrl+o" in answer.message
        assert talk.robot.state().estop

    converse(test)


def test_what_the_robot_refused_to_begin_takes_nothing_from_what_is_offered() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.send(EStop())
        await talk.result()
        offered = talk.bodies(events.OffersMade)[-1].resume
        assert offered
        talk.send(Say("continue"))
        assert (await talk.result(2)).message.startswith("The emergency stop is pressed: release it first.")
        await talk.pass_time(0.1)
        assert talk.bodies(events.OffersMade)[-1].resume == offered
        talk.send(Release())
        before = talk.robot.state().pose
        talk.send(Say("continue"))
        assert (await talk.result(3)).outcome == "done"
        assert talk.robot.state().pose.distance_to(before) > 0.3

    converse(test)


def test_no_stop_or_interrupt_releases_it() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(EStop())
        for command in (Interrupt(), Say("stop"), Say("never mind")):
            talk.send(command)
            await talk.pass_time(2.0)
        assert talk.robot.state().estop

    converse(test)


def test_said_after_a_wake_it_is_pressed_as_well() -> None:
    async def test(talk: Conversation) -> None:
        await talk.wake_and_say("emergency stop")
        result = await talk.result()
        assert result.message == PRESSED
        assert talk.robot.state().estop

    converse(test)


# By hand


def test_by_hand_it_drives_while_commands_come_and_no_longer() -> None:
    async def test(talk: Conversation) -> None:
        for _ in range(20):
            talk.send(Drive(vx=0.2))
            await talk.pass_time(0.05)
        assert talk.robot.state().pose.x == pytest.approx(0.2, abs=0.03)
        await talk.pass_time(0.3)
        assert talk.robot.state().twist.is_zero
        assert [body.do for body in talk.bodies(events.Ack)] == ["drive"], "one for the beginning"

    converse(test)


def test_a_person_goes_before_a_plan_and_the_plan_is_told() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.send(Drive(wz=0.5))
        result = await talk.result()
        assert (result.outcome, result.message) == ("interrupted", "Somebody drives by hand.")
        (raised,) = talk.bodies(events.InterruptRaised)
        assert raised.scope == "by_hand"
        assert talk.robot.state().twist.wz == 0.5
        assert talk.robot.state().twist.vx == 0

    converse(test)


def test_a_request_goes_before_a_hand_that_is_gone() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Drive(vx=0.2))
        await talk.pass_time(1.0)
        talk.send(Say("turn left 90 degrees"))
        assert (await talk.result()).outcome == "done"

    converse(test)


def test_by_hand_nothing_moves_either_while_the_emergency_stop_is_pressed() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(EStop())
        talk.send(Drive(vx=0.2, id="it"))
        ack = await talk.until(events.Ack, lambda body: body.id == "it")
        assert (ack.ok, ack.message) == (False, "The emergency stop is pressed: release it first.")
        assert talk.robot.state().twist.is_zero

    converse(test)


# Where it is


def test_a_person_tells_the_robot_where_it_is() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Here(1.0, 2.0, 0.5, id="it"))
        assert (await talk.until(events.Ack, lambda body: body.id == "it")).ok
        assert talk.robot.relocated == [(Pose(0.0, 0.0, 0.0), Pose(1.0, 2.0, 0.5))]

    converse(test)


@pytest.mark.parametrize(("x", "y"), [(100.0, 0.0), (1e308, 0.0)])
def test_nobody_puts_it_where_the_map_ends(x: float, y: float) -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Here(x, y, id="it"))
        ack = await talk.until(events.Ack, lambda body: body.id == "it")
        assert (ack.ok, ack.message) == (False, "That is not on the map.")
        assert talk.robot.relocated == []

    converse(test)


def test_nobody_puts_it_elsewhere_while_it_drives() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        talk.send(Here(1.0, 2.0, id="it"))
        assert not (await talk.until(events.Ack, lambda body: body.id == "it")).ok
        assert not talk.robot.state().twist.is_zero

    converse(test)


# The battery


def test_on_a_low_battery_nothing_is_begun_that_goes_on_and_on() -> None:
    async def test(talk: Conversation) -> None:
        talk.robot.battery = BatteryState(10.0, 0.2, low=True)
        talk.send(Say("patrol"))
        assert (await talk.result()).message == "My battery is low (10 V): charge me first."
        talk.send(Say("go forward 1 metre"))
        assert (await talk.result(2)).outcome == "done"
        talk.send(Say("how full is your battery?"))
        assert (await talk.result(3)).message == "My battery is about 20 % full."

    converse(test)


def test_presses_and_releases_count_in_the_order_in_which_people_gave_them() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(EStop())
        talk.send(Release())
        talk.send(EStop())
        await talk.pass_time(1.0)
        assert talk.robot.state().estop
        talk.send(Release())
        assert not talk.robot.state().estop, "at once, as it was pressed"

    converse(test)


@pytest.mark.parametrize("asked", [Say("turn left 90 degrees"), EndTask(), Say("wait 4 seconds, then turn left")])
def test_what_was_said_while_it_was_pressed_moves_nothing_after_the_release(asked: Command) -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("raise your arm"))
        await talk.result()
        talk.send(EStop())
        talk.send(asked)
        talk.send(Release())
        moved, arm = len(talk.robot.moved), len(talk.robot.arm_moves)
        await talk.pass_time(20.0)
        assert (len(talk.robot.moved), len(talk.robot.arm_moves)) == (moved, arm)

    converse(test)


def test_a_hand_ends_what_was_asked_for_while_it_drove() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Drive(vx=0.2))
        await talk.pass_time(0.1)
        talk.send(Say("turn left 180 degrees"))
        talk.send(Drive())
        await talk.pass_time(10.0)
        assert abs(talk.robot.state().pose.yaw) < 0.1

    converse(test, "session.busy=queue")


# The speed limit


def test_a_speed_limit_reaches_a_robot_that_drives_and_interrupts_nothing() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        epoch = talk.epoch.current
        talk.send(LimitSpeed(0.25, id="slow"))
        assert (await talk.until(events.Ack, lambda body: body.id == "slow")).ok
        assert talk.robot.speed_limit == 0.25
        assert talk.epoch.current == epoch
        assert not talk.robot.state().twist.is_zero
        assert not talk.bodies(events.ActionFinished)

    converse(test)


# The volume


def test_another_volume_reaches_the_loudspeaker_and_interrupts_nothing() -> None:
    async def test(talk: Conversation) -> None:
        await driving(talk)
        epoch = talk.epoch.current
        talk.send(SetVolume(0.5, id="quiet"))
        assert (await talk.until(events.Ack, lambda body: body.id == "quiet")).ok
        assert talk.volumes == [0.5]
        assert talk.epoch.current == epoch
        assert not talk.bodies(events.ActionFinished)

    converse(test)
