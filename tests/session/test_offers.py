"""Continue, undo and again: what is offered after a turn, and what comes of it."""

from __future__ import annotations

import math

import pytest

from engine import events
from engine.commands import EndTask, Here, Interrupt, Say, Snapshot
from engine.errors import ExitCode
from engine.robot.arm import ARM_INITIAL, ARM_UP
from engine.robot.geometry import Pose
from tests.session.conversation import Conversation, converse


async def done(talk: Conversation, text: str) -> str:
    """Ask for something and wait for its end; the id of its turn."""
    number = len(talk.results) + 1
    talk.send(Say(text))
    await talk.result(number)
    await talk.pass_time(0.1)
    return turns(talk)[-1]


async def cut(talk: Conversation, text: str, name: str, after: float) -> str:
    """Ask for something and stop it, some time after the action of this name has begun."""
    begun, number = len(talk.bodies(events.ActionStarted)), len(talk.results) + 1
    talk.send(Say(text))
    while not any(body.name == name for body in talk.bodies(events.ActionStarted)[begun:]):
        await talk.pass_time(0.05)
    await talk.pass_time(after)
    talk.send(Interrupt())
    await talk.result(number)
    await talk.pass_time(0.1)
    return turns(talk)[-1]


def turns(talk: Conversation) -> list[str]:
    return [event.turn or "" for event in talk.seen if isinstance(event.body, events.TranscriptFinal)]


def offers(talk: Conversation) -> events.OffersMade:
    return talk.bodies(events.OffersMade)[-1]


def names(talk: Conversation) -> list[str]:
    return [body.name for body in talk.bodies(events.ActionStarted)]


def stands_at(talk: Conversation, pose: Pose) -> bool:
    now = talk.robot.state().pose
    return now.distance_to(pose) < 0.05 and abs(math.remainder(now.yaw - pose.yaw, 2 * math.pi)) < 0.05


def test_what_was_driven_is_undone_by_going_back_through_the_navigator() -> None:
    async def test(talk: Conversation) -> None:
        await done(talk, "turn left 45 degrees")
        start = talk.robot.state().pose
        turn = await done(talk, "go forward 2 metres, turn left 90 degrees, go forward 1 metre")
        assert not stands_at(talk, start)
        assert offers(talk).undo == turn
        await done(talk, "undo")
        assert stands_at(talk, start)
        assert names(talk)[-1] == "return_to"
        assert talk.results[-1].exit_code == ExitCode.DONE

    converse(test)


@pytest.mark.parametrize("words", ["undo", "Undo that.", "撤销"])
def test_a_turn_that_was_stopped_half_way_is_undone_from_where_the_robot_is(words: str) -> None:
    async def test(talk: Conversation) -> None:
        turn = await cut(talk, "go forward 3 metres, then wave", "move_forward", 3.0)
        assert 0.5 < talk.robot.state().pose.x < 2.0
        assert (offers(talk).undo, offers(talk).resume, offers(talk).again) == (turn, turn, turn)
        await done(talk, words)
        assert stands_at(talk, Pose(0.0, 0.0, 0.0))

    converse(test)


def test_light_and_arm_go_back_to_what_they_were() -> None:
    async def test(talk: Conversation) -> None:
        await done(talk, "make the light blue")
        await done(talk, "make the light red and raise your arm")
        assert (talk.robot.state().light, talk.robot.state().joints) == ((255, 0, 0), ARM_UP)
        await done(talk, "undo that")
        assert (talk.robot.state().light, talk.robot.state().joints) == ((0, 0, 255), ARM_INITIAL)
        await done(talk, "undo that")  # the undoing was a plan like any other
        assert (talk.robot.state().light, talk.robot.state().joints) == ((255, 0, 0), ARM_UP)

    converse(test)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("remember this place", "I cannot undo remembering this place."),
        ("beep", "Nothing is to be undone: all is as it was."),
        ("go forward 1 metre and remember this place", "I cannot undo remembering this place."),
    ],
)
def test_what_has_no_way_back_is_not_offered_and_says_why(text: str, why: str) -> None:
    async def test(talk: Conversation) -> None:
        await done(talk, text)
        pose = talk.robot.state().pose
        assert (offers(talk).undo, offers(talk).no_undo) == (None, why)
        await done(talk, "undo")
        assert talk.results[-1].message == why
        assert stands_at(talk, pose)

    converse(test)


def test_nothing_is_undone_before_anything_was_done() -> None:
    async def test(talk: Conversation) -> None:
        await done(talk, "undo")
        assert talk.results[-1].message == "There is nothing that I could undo."
        assert not names(talk)

    converse(test)


def test_a_robot_that_was_put_elsewhere_on_the_map_knows_no_way_back() -> None:
    async def test(talk: Conversation) -> None:
        await done(talk, "go forward 1 metre")
        talk.send(Here(2.0, 1.0, 0.0, "here"))
        assert (await talk.until(events.Ack, lambda body: body.id == "here")).ok
        assert offers(talk).undo is None
        await done(talk, "undo")
        assert talk.results[-1].message.startswith("I was put elsewhere on the map since")
        turn = await done(talk, "go forward 1 metre")
        assert offers(talk).undo == turn, "what is done from there on has a way back"

    converse(test)


@pytest.mark.parametrize("words", ["continue", "go on", "继续"])
def test_what_a_stop_cut_goes_on_from_where_the_robot_is(words: str) -> None:
    async def test(talk: Conversation) -> None:
        turn = await cut(talk, "turn left 90 degrees, go forward 3 metres, beep", "move_forward", 2.0)
        assert offers(talk).resume == turn
        await done(talk, words)
        assert stands_at(talk, Pose(0.0, 3.0, math.pi / 2))
        assert names(talk) == ["move_left", "move_forward", "move_forward", "beep"]
        assert offers(talk).resume is None, "nothing is left"

    converse(test)


@pytest.mark.parametrize(
    ("text", "at"),
    [
        ("turn right 90 degrees", Pose(0.0, 0.0, -math.pi / 2)),
        ("go backward 2 metres", Pose(-2.0, 0.0, 0.0)),
        ("move 1 metre to the left", Pose(0.0, 1.0, 0.0)),
        ("move 1 metre to the right", Pose(0.0, -1.0, 0.0)),
    ],
)
def test_what_is_left_of_a_motion_is_what_was_not_done(text: str, at: Pose) -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say(text))
        await talk.until(events.ActionStarted)
        await talk.pass_time(0.9)
        talk.send(Interrupt())
        await talk.result()
        assert not stands_at(talk, at)
        await done(talk, "continue")
        assert stands_at(talk, at)

    converse(test)


@pytest.mark.parametrize("words", ["again", "do that again", "再来一次"])
def test_again_does_the_plan_once_more(words: str) -> None:
    async def test(talk: Conversation) -> None:
        turn = await done(talk, "go forward 1 metre")
        assert offers(talk).again == turn
        await done(talk, words)
        assert stands_at(talk, Pose(2.0, 0.0, 0.0))

    converse(test)


def test_what_is_not_done_leaves_the_offers_as_they_were() -> None:
    async def test(talk: Conversation) -> None:
        turn = await done(talk, "go forward 1 metre")
        await done(talk, "what are you holding?")
        assert (offers(talk).undo, offers(talk).again) == (turn, turn)
        talk.send(Snapshot("now"))
        snapshot = (await talk.until(events.Ack, lambda body: body.id == "now")).snapshot
        assert snapshot is not None
        assert snapshot["offers"]["undo"] == turn

    converse(test)


def test_a_new_task_offers_nothing_of_the_old_one() -> None:
    async def test(talk: Conversation) -> None:
        await done(talk, "go forward 1 metre")
        talk.send(EndTask())
        await talk.until(events.TaskEnded)
        await talk.pass_time(0.1)
        assert offers(talk) == events.OffersMade()

    converse(test)


def test_undoing_is_stopped_like_anything_else() -> None:
    async def test(talk: Conversation) -> None:
        await done(talk, "go forward 3 metres")
        await cut(talk, "undo", "return_to", 2.0)
        assert talk.robot.state().twist.is_zero
        assert 0.3 < talk.robot.state().pose.x < 2.9
        await done(talk, "continue")
        assert stands_at(talk, Pose(0.0, 0.0, 0.0))

    converse(test)


def test_undo_while_something_runs_stops_that_and_goes_back() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("go forward 3 metres"))
        await talk.until(events.ActionStarted)
        await talk.pass_time(3.0)
        await done(talk, "undo")
        await talk.result(2)
        assert stands_at(talk, Pose(0.0, 0.0, 0.0))

    converse(test)
