"""Continue, undo and again: what is offered stands where the turn stands, with its key, and the key asks for it."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from engine import events as ev
from engine.commands import Say
from tests.tui import conversation as talk
from tests.tui import scripted
from tests.tui.desk import Desk, console
from tui.widgets.queue import ActionQueue
from tui.widgets.timeline import Offered, Timeline

STANDS = ev.RobotStateView(
    0.0, ev.PoseView(0.0, 0.0, 0.0), ev.TwistView(0.0, 0.0, 0.0), (), 0.0, False, None, estop=True
)
ALL = ev.OffersMade("T1", "T1", "T1", "T1")


def below_turns(desk: Desk) -> list[str]:
    return [item.words for item in desk.app.query_one(Timeline).items if isinstance(item, Offered)]


@pytest.mark.parametrize("size", [(200, 55), (120, 40), (80, 24), (60, 20)])
async def test_what_is_offered_stands_on_the_row_of_its_turn_with_its_keys(size: tuple[int, int]) -> None:
    async with console(size=size) as desk:
        desk.engine.play(scripted.done())
        desk.engine.publish(ALL, turn=None)
        await desk.settled()
        assert str(desk.app.query_one(ActionQueue).border_subtitle) == "k continue · u undo · a again"
        await desk.press("t")
        assert below_turns(desk) == ["k continue · u undo · a again"]
        await desk.press("enter")
        assert "k continue · u undo · a again" in desk.text, "and on its page"


async def test_only_what_applies_is_offered_and_why_not_is_said_on_the_page() -> None:
    async with console() as desk:
        desk.engine.play(scripted.done())
        desk.engine.publish(ev.OffersMade(again="T1", acted="T1", no_undo="I cannot undo clean_room()."), turn=None)
        await desk.settled()
        assert below_turns(desk) == ["a again"]
        await desk.press("enter")
        assert "No undo: I cannot undo clean_room()." in desk.text
        await desk.press("enter", "u")
        assert not desk.engine.sent
        assert "I cannot undo clean_room()." in desk.text


async def test_nothing_is_offered_while_the_robot_is_at_something() -> None:
    async with console() as desk:
        desk.engine.play(scripted.acting())
        desk.engine.publish(ALL, turn=None)
        await desk.press("u")
        assert below_turns(desk) == []
        assert not desk.engine.sent
        assert "The robot is at something: esc stops it." in desk.text


async def test_while_the_emergency_stop_is_pressed_nothing_is_offered_and_the_key_says_what_releases_it() -> None:
    async with console() as desk:
        desk.engine.play(scripted.done())
        desk.engine.publish(ALL, turn=None)
        desk.engine.publish(STANDS, turn=None)
        await desk.press("k")
        assert below_turns(desk) == []
        assert not desk.engine.sent
        assert "The emergency stop is pressed: ctrl+o releases it." in desk.text
        desk.engine.publish(replace(STANDS, estop=False), turn=None)
        await desk.press("k")
        assert desk.engine.sent == [Say("continue")], "it has not been used up"


@pytest.mark.parametrize("state", ["ACTING", "IDLE"])
async def test_an_emergency_stop_leaves_a_row_in_the_conversation(state: ev.State) -> None:
    async with console() as desk:
        desk.engine.publish(ev.InterruptRaised("estop", "estop", state), turn=None)
        await desk.settled()
        assert "■  stopped  the emergency stop" in desk.text


@pytest.mark.parametrize(("key", "word"), [("k", "continue"), ("u", "undo"), ("a", "again")])
async def test_a_key_asks_for_it_in_its_word(key: str, word: str) -> None:
    async with console() as desk:
        desk.engine.play(scripted.done())
        desk.engine.publish(ALL, turn=None)
        await desk.press(key)
        assert desk.engine.sent == [Say(word)]


@pytest.mark.parametrize(
    ("key", "why"), [("k", "No stop has cut"), ("u", "nothing that could be"), ("a", "no plan yet")]
)
async def test_a_key_for_what_is_not_offered_says_why(key: str, why: str) -> None:
    async with console() as desk:
        await desk.press(key)
        assert not desk.engine.sent
        assert why in desk.text


async def test_the_palette_has_them_too() -> None:
    async with console() as desk:
        desk.engine.play(scripted.done())
        desk.engine.publish(ALL, turn=None)
        await desk.press("ctrl+p", *"undo", "enter")
        await desk.until(lambda: desk.engine.sent == [Say("undo")])


async def test_in_chinese_the_word_that_is_asked_is_chinese() -> None:
    async with console(language="zh") as desk:
        desk.engine.play(scripted.done())
        desk.engine.publish(ALL, turn=None)
        await desk.settled()
        assert below_turns(desk) == ["k 继续 · u 撤销 · a 再来一次"]
        await desk.press("a")
        assert desk.engine.sent == [Say("再来一次")]


# Turns that come while somebody looks at an older one


def one_more(desk: Desk, number: int) -> None:
    """A turn begins and ends."""
    turn = f"N{number}"
    desk.engine.publish(talk.typed(f"request {number}"), after=1.0, turn=turn)
    desk.engine.publish(ev.StateChanged("WAITING", "PLANNING", "a request was understood"), turn=turn)
    step = talk.over("PLANNING", "done", "Done.")
    desk.engine.publish(step.body, turn=turn)


def shown_turn(desk: Desk) -> str:
    turn = desk.app.shown.turn
    return turn.text if turn is not None else "the newest"


@pytest.mark.parametrize("size", [(120, 40), (80, 24)])
async def test_who_looks_at_an_older_turn_stays_there_and_the_mark_counts_all_that_are_new(
    size: tuple[int, int],
) -> None:
    async with console(size=size) as desk:
        for number in range(3):
            one_more(desk, number)
        await desk.press("[")
        assert shown_turn(desk) == "request 1"
        one_more(desk, 3)
        one_more(desk, 4)
        await desk.settled()
        assert shown_turn(desk) == "request 1"
        assert "2 new" in desk.text
        await desk.press("[")
        assert shown_turn(desk) == "request 0"
        assert "2 new" in desk.text, "another older one has shown none of them"
        one_more(desk, 5)
        await desk.press("enter")
        assert "request 0" in desk.text
        assert "3 new" in desk.text, "on the page as well"
        await desk.press("]", "]", "]", "]", "]", "enter")
        assert shown_turn(desk) == "the newest"
        assert "new" not in str(desk.app.query_one(Timeline).border_subtitle)


async def test_a_turn_that_is_looked_at_stays_although_it_is_too_old_to_be_kept() -> None:
    async with console() as desk:
        for number in range(3):
            one_more(desk, number)
        await desk.press("[", "[")
        for number in range(3, 50):
            one_more(desk, number)
        await desk.settled()
        assert shown_turn(desk) == "request 0"
        assert "request 0" in desk.text
        assert "47 new" in desk.text
        await desk.press("]")
        assert shown_turn(desk) == "request 10", "the oldest that is kept"


async def test_who_asks_for_something_new_follows_again() -> None:
    async with console() as desk:
        for number in range(3):
            one_more(desk, number)
        await desk.press("[")
        one_more(desk, 3)
        await desk.press("slash", *"beep", "enter")
        assert shown_turn(desk) == "the newest"
        one_more(desk, 4)
        await desk.settled()
        assert "new" not in str(desk.app.query_one(Timeline).border_subtitle)
