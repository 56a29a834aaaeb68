"""The actions of a plan: what runs has the room, what comes next is in view, and what ended badly says why."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from engine import events as ev
from engine.commands import Command, Drop, Interrupt, Move, Say
from tests.tui import scripted
from tests.tui.desk import Desk, console
from tests.tui.scripted import ScriptedEngine, flat, robot_at
from tui.widgets.log import LogView
from tui.widgets.queue import ActionQueue, Waits
from tui.words.language import Language


def queue_of(desk: Desk) -> ActionQueue:
    return desk.app.query_one(ActionQueue)


@pytest.mark.parametrize("size", [(120, 40), (80, 24), (60, 16)])
async def test_what_runs_and_what_comes_next_are_in_view(size: tuple[int, int]) -> None:
    async with console(size=size) as desk:
        desk.engine.play(scripted.queueing())
        await desk.settled()
        assert "Bring the green bottle" in desk.text
        assert "Go to the charging dock" in desk.text
        assert "12.4 s" in desk.text


async def test_what_runs_says_how_far_it_is_in_all_words() -> None:
    async with console() as desk:
        desk.engine.play(scripted.queueing())
        await desk.settled()
        words = " ".join(desk.text.split())
        assert "holding the green bottle, 1.8 m to the" in words
        running = next(item for item in queue_of(desk).items if item.phase == "running")
        assert running.filled == 5, "five eighths"


async def test_the_pane_counts_what_ended_and_names_the_key_that_stops() -> None:
    async with console(keymap={"interrupt": "x"}) as desk:
        desk.engine.play(scripted.queueing())
        await desk.settled()
        assert "3 of 6 ended · 1 failed · x stops" in desk.text
        await desk.press("x")
        assert desk.engine.sent == [Interrupt()]
        desk.engine.publish(ev.ActionFinished("q4", "carry", {}, "interrupted", "interrupted", "Stopped by key.", 13.0))
        await desk.settled()
        assert "x stops" not in desk.text


async def test_when_nothing_runs_any_more_reasons_have_the_room() -> None:
    async with console(size=(120, 50)) as desk:
        desk.engine.play(scripted.queueing())
        await desk.settled()
        reason = "I could not find a red box in the living room, the hall and the kitchen."
        assert [item.whole for item in queue_of(desk).items] == [False, False, False, True, False, False]
        desk.engine.publish(ev.ActionFinished("q4", "carry", {}, "failed", "dropped", "It fell down.", 13.0))
        desk.engine.publish(ev.StateChanged("ACTING", "WAITING", "failed", ev.TurnResult(1, "failed", "It fell down.")))
        await desk.settled()
        shown = queue_of(desk).items
        assert [item.phase for item in shown] == ["failed", "uncertain", "ok", "failed", "interrupted", "interrupted"]
        assert [item.whole for item in shown] == [True, True, False, True, True, True]
        queue_of(desk).scroll_lines(-20)
        await desk.settled()
        words = " ".join(line[:62].strip("│ ") for line in desk.text.splitlines())
        assert "box in the living room" in " ".join(words.split())
        assert reason == shown[0].message


@pytest.mark.parametrize("size", [(120, 40), (80, 24)])
async def test_requests_that_wait_are_shown_until_they_begin(size: tuple[int, int]) -> None:
    async with console(size=size) as desk:
        desk.engine.play(scripted.acting())
        desk.engine.publish(ev.RequestsWaiting(("turn left", "come back")))
        await desk.settled()
        assert "○  turn left  waits" in desk.text
        assert "○  come back  waits" in desk.text
        assert "2 waiting · esc stops" in desk.text
        desk.engine.publish(ev.RequestsWaiting(("come back",)))
        await desk.settled()
        assert "turn left  waits" not in desk.text
        assert "1 waiting · esc stops" in desk.text


async def test_of_many_requests_that_wait_the_next_ones_are_shown_and_the_others_counted() -> None:
    async with console() as desk:
        desk.engine.publish(ev.RequestsWaiting(tuple(f"move {number}" for number in range(9))))
        await desk.settled()
        assert "move 2  waits" in desk.text
        assert "… and 6 more" in desk.text
        assert "9 waiting" in desk.text


WAITING = tuple(ev.WaitingRequest(f"R{number}", text) for number, text in enumerate(("beep", "nod", "go home"), 1))


def waits(*requests: ev.WaitingRequest) -> ev.RequestsWaiting:
    return ev.RequestsWaiting(tuple(one.text for one in requests), requests)


def listed(desk: Desk) -> list[tuple[str, bool]]:
    """What waits, as the pane lists it, and whether it is chosen."""
    return [(item.text, item.chosen) for item in queue_of(desk).items if isinstance(item, Waits)]


@asynccontextmanager
async def waiting(size: tuple[int, int] = (120, 40)) -> AsyncIterator[Desk]:
    """A console at whose actions somebody is, while three requests wait."""
    async with console(size=size) as desk:
        desk.engine.play(scripted.acting())
        desk.engine.publish(waits(*WAITING), turn=None)
        await desk.press("3")
        yield desk


@pytest.mark.parametrize("size", [(120, 40), (80, 24), (60, 20)])
async def test_the_actions_list_what_waits_and_name_the_keys_while_they_have_the_keyboard(
    size: tuple[int, int],
) -> None:
    async with waiting(size) as desk:
        assert listed(desk) == [("beep", True), ("nod", False), ("go home", False)]
        assert "› 1 beep" in desk.text
        assert "x drop · J move" in desk.text, "also where there is no room for all of them"
        assert "esc stops" in desk.text
        await desk.press("1")
        assert [chosen for _, chosen in listed(desk)] == [False, False, False]
        assert "x drop" not in desk.text


async def test_one_that_waits_is_chosen_and_dropped() -> None:
    async with waiting() as desk:
        await desk.press("down", "x")
        assert desk.engine.sent == [Drop("R2")]
        desk.engine.publish(ev.RequestEnded("R2", "nod", "dropped"), turn=None)
        desk.engine.publish(waits(WAITING[0], WAITING[2]), turn=None)
        await desk.settled()
        assert "■  nod  dropped" in desk.text
        assert listed(desk) == [("beep", False), ("go home", True)], "its neighbour is chosen then"


async def test_while_a_question_holds_what_waits_the_console_says_that_it_is_asking() -> None:
    async with console() as desk:
        desk.engine.play(scripted.acting())
        desk.engine.publish(waits(*WAITING), turn=None)
        desk.engine.publish(ev.ClarificationAsked("Shall I go to the bedroom?", "go to the bedrom"))
        result = ev.TurnResult(5, "clarify", "Shall I go to the bedroom?")
        desk.engine.publish(ev.StateChanged("ACTING", "WAITING", "clarify", result))
        for action in ("a2", "a3", "a4"):
            desk.engine.publish(ev.ActionFinished(action, "navigation", {}, "ok", None, "", 1.0))
        await desk.settled()
        assert "ASKING" in desk.text.splitlines()[0]
        assert "3 waiting · your answer first · esc stops" in desk.text
        desk.engine.publish(ev.StateChanged("WAITING", "PLANNING", "x"))
        await desk.settled()
        assert "ASKING" not in desk.text.splitlines()[0]
        assert "your answer first" not in desk.text


@pytest.mark.parametrize("there", [True, False])
@pytest.mark.parametrize(("number", "text"), [(1, "beep"), (2, "nod"), (3, "go home")])
async def test_a_click_chooses_the_request_that_is_clicked_on(number: int, text: str, *, there: bool) -> None:
    async with waiting() as desk:
        if not there:
            await desk.press("slash")
            queue_of(desk).scroll_lines(9)
            await desk.settled()
        row, line = next((y, line) for y, line in enumerate(desk.text.splitlines()) if f" {number} {text} " in line)
        await desk.pilot.click(offset=(line.index(text), row))
        await desk.settled()
        assert [what for what, chosen in listed(desk) if chosen] == [text]
        assert f"› {number} {text}" in desk.text.splitlines()[row], "nothing scrolls below the hand"
        await desk.press("x")
        assert desk.engine.sent == [Drop(f"R{number}")]


@pytest.mark.parametrize(
    ("keys", "sent"),
    [
        (("shift+down",), [Move("R1", "R3")]),
        (("J",), [Move("R1", "R3")]),
        (("down", "shift+down"), [Move("R2", None)]),
        (("shift+down", "shift+down", "shift+down"), [Move("R1", "R3"), Move("R1", None)]),
        (("shift+down", "shift+down", "shift+up"), [Move("R1", "R3"), Move("R1", None), Move("R1", "R3")]),
        (("down", "down", "shift+up"), [Move("R3", "R2")]),
        (("shift+up",), []),
        (("down", "down", "down", "shift+down"), []),
    ],
)
async def test_one_that_waits_is_moved_by_one_place(keys: tuple[str, ...], sent: list[Command]) -> None:
    async with waiting() as desk:
        await desk.press(*keys)
        assert desk.engine.sent == sent


async def test_one_that_waits_is_taken_back_into_the_line_and_waits_in_its_old_place_again() -> None:
    async with waiting() as desk:
        await desk.press("down", "enter")
        assert desk.engine.sent == [Drop("R2")]
        line = desk.app.main.line
        assert line.value == "", "it may have begun in this moment"
        desk.engine.publish(ev.RequestEnded("R2", "nod", "dropped"), turn=None)
        desk.engine.publish(waits(WAITING[0], WAITING[2]), turn=None)
        await desk.until(lambda: line.value == "nod")
        assert "dropped" not in desk.text, "it is not lost: it stands in the line"
        await desk.press(*" twice", "enter")
        said = desk.engine.sent[-1]
        assert isinstance(said, Say)
        assert (said.text, said.wait) == ("nod twice", True), "what runs goes on"
        again = ev.WaitingRequest("R4", "nod twice", said.id)
        desk.engine.publish(waits(WAITING[0], WAITING[2], again), turn=None)
        await desk.until(lambda: desk.engine.sent[-1] == Move("R4", "R3"))
        await desk.press(*"beep", "enter")
        assert desk.engine.sent[-1] == Say("beep"), "what is asked then is a request as usual"


async def test_who_empties_the_line_and_begins_anew_asks_for_something_else() -> None:
    async with waiting() as desk:
        await desk.press("enter")
        desk.engine.publish(ev.RequestEnded("R1", "beep", "dropped"), turn=None)
        await desk.until(lambda: desk.app.main.line.value == "beep")
        await desk.press(*["backspace"] * 4, *"nod", "enter")
        assert desk.engine.sent == [Drop("R1"), Say("nod")]


async def take_back(desk: Desk, number: int, *others: ev.WaitingRequest) -> None:
    """Take this one of three back, at which somebody is; the ``others`` wait then."""
    request = WAITING[number - 1]
    await desk.press("enter")
    assert desk.engine.sent[-1] == Drop(request.request)
    desk.engine.publish(ev.RequestEnded(request.request, request.text, "dropped"), turn=None)
    desk.engine.publish(waits(*others), turn=None)
    await desk.until(lambda: desk.app.main.line.value == request.text)
    await desk.settled()


async def test_the_log_keeps_how_one_that_was_taken_back_goes_back() -> None:
    async with waiting() as desk:
        await take_back(desk, 1, *WAITING[1:])
        told = [line.message for line in desk.app.drawing.model.log if line.source == "console"]
        assert told == ["enter puts it back into its place · empty the line to leave it out"]


async def test_what_the_palette_asks_for_is_not_what_was_taken_back() -> None:
    async with waiting() as desk:
        await take_back(desk, 1, *WAITING[1:])
        desk.app.main.line.send("list_skills()")  # as the palette does
        await desk.settled()
        said = desk.engine.sent[-1]
        assert isinstance(said, Say)
        assert (said.text, said.wait) == ("list_skills()", False)
        assert desk.app.main.line.value == "beep", "it still stands in the line"
        await desk.press("enter")
        back = desk.engine.sent[-1]
        assert isinstance(back, Say)
        assert (back.text, back.wait) == ("beep", True)


async def test_one_that_was_taken_back_goes_behind_all_others_by_the_key_that_adds() -> None:
    async with waiting() as desk:
        await take_back(desk, 1, *WAITING[1:])
        await desk.press("ctrl+j")
        said = desk.engine.sent[-1]
        assert said == Say("beep", wait=True)
        desk.engine.publish(waits(*WAITING[1:], ev.WaitingRequest("R4", "beep")), turn=None)
        await desk.settled()
        assert desk.engine.sent[-1] == said, "nobody moves it"
        assert "dropped" not in desk.text


async def test_one_that_was_taken_back_waits_before_the_next_that_still_does() -> None:
    async with waiting() as desk:
        await take_back(desk, 1, *WAITING[1:])
        await desk.press("enter")
        said = desk.engine.sent[-1]
        assert isinstance(said, Say)
        desk.engine.publish(waits(WAITING[2], ev.WaitingRequest("R4", "beep", said.id)), turn=None)
        await desk.until(lambda: desk.engine.sent[-1] == Move("R4", "R3"))


@pytest.mark.parametrize("keys", [("ctrl+u",), ("ctrl+u", "enter"), ("backspace",) * 9, ("ctrl+u", *"nod", "enter")])
async def test_one_that_was_taken_back_and_left_out_has_a_row(keys: tuple[str, ...]) -> None:
    async with waiting() as desk:
        await take_back(desk, 1, *WAITING[1:])
        assert "dropped" not in desk.text
        await desk.press(*keys)
        await desk.settled()
        assert desk.text.count("■  beep  dropped") == 1
        assert not any(isinstance(command, Say) and command.text == "beep" for command in desk.engine.sent)


@pytest.mark.parametrize("keys", [("enter",), ("ctrl+j",), ("ctrl+u",), ("backspace",) * 9])
async def test_what_stood_in_the_line_comes_back_when_that_which_was_taken_back_is_gone(keys: tuple[str, ...]) -> None:
    async with console(in_line=True) as desk:
        desk.engine.play(scripted.acting())
        desk.engine.publish(waits(*WAITING), turn=None)
        await desk.press(*"turn", "ctrl+g", "3")
        await take_back(desk, 1, *WAITING[1:])
        await desk.press(*keys)
        await desk.settled()
        line = desk.app.main.line
        assert (line.value, line.cursor_position, line.has_focus) == ("turn", 4, True)
        await desk.press(*" left", "enter")
        assert desk.engine.sent[-1] == Say("turn left")


def beside_the_log(desk: Desk) -> str:
    """What is on the screen but for the log, which keeps what was told."""
    log, rows = desk.app.main.query_one(LogView).region, desk.text.splitlines()
    inside = range(log.y, log.bottom)
    return "\n".join(row[: log.x] + row[log.right :] if y in inside else row for y, row in enumerate(rows))


@pytest.mark.parametrize("keys", [("enter",), ("ctrl+j",), ("ctrl+u",)])
@pytest.mark.parametrize("size", [(160, 40), (60, 20)])
async def test_how_it_goes_back_is_told_only_as_long_as_it_stands_in_the_line(
    size: tuple[int, int], keys: tuple[str, ...]
) -> None:
    words = "puts it back into its"
    async with console(size=size, notices=True) as desk:
        desk.engine.play(scripted.acting())
        desk.engine.publish(waits(*WAITING), turn=None)
        await desk.press("3")
        await take_back(desk, 1, *WAITING[1:])
        await desk.until(lambda: words in beside_the_log(desk))
        await desk.press(*keys)
        await desk.settled()
        await desk.pilot.pause()
        assert words not in beside_the_log(desk)


@pytest.mark.parametrize("keys", [("escape",), ("ctrl+x",), ("ctrl+g",), ("ctrl+g", "e")])
async def test_that_it_goes_back_into_its_place_is_told_no_longer_than_that_is_so(keys: tuple[str, ...]) -> None:
    words = "puts it back into its"
    async with waiting() as desk:
        await take_back(desk, 1, *WAITING[1:])
        assert words in desk.app.shown.notice
        await desk.press(*keys)
        assert words not in desk.app.shown.notice
        assert desk.app.main.line.value == WAITING[0].text, "it still stands in the line"


async def test_who_takes_a_second_one_back_puts_the_first_back_as_it_was() -> None:
    async with console(size=(60, 20), notices=True) as desk:
        desk.engine.play(scripted.acting())
        desk.engine.publish(waits(*WAITING), turn=None)
        await desk.press("3", "down")
        await take_back(desk, 2, WAITING[0], WAITING[2])
        await desk.press(*" twice", "ctrl+g", "3", "up", "enter")
        again, dropped = desk.engine.sent[-2:]
        assert isinstance(again, Say)
        assert (again.text, again.wait) == ("nod", True), "nobody has sent what became of it"
        assert dropped == Drop("R1")
        desk.engine.publish(ev.RequestEnded("R1", "beep", "dropped"), turn=None)
        nod = ev.WaitingRequest("R4", "nod", again.id)
        desk.engine.publish(waits(WAITING[2], nod), turn=None)
        await desk.until(lambda: desk.app.main.line.value == "beep")
        assert desk.engine.sent[-1] == Move("R4", "R3"), "into its place"
        desk.engine.publish(waits(nod, WAITING[2]), turn=None)
        await desk.until(lambda: "puts it back into its" in desk.text)
        await desk.settled()
        assert desk.text.count("puts it back into its") == 1, "it is told once"
        await desk.press("enter")
        beep = desk.engine.sent[-1]
        assert isinstance(beep, Say)
        desk.engine.publish(waits(nod, WAITING[2], ev.WaitingRequest("R5", "beep", beep.id)), turn=None)
        await desk.until(lambda: desk.engine.sent[-1] == Move("R5", "R4"))
        assert desk.app.main.line.value == ""
        assert "dropped" not in desk.text


async def test_who_takes_the_next_one_back_puts_the_first_before_those_that_are_left() -> None:
    async with console(size=(60, 20), notices=True) as desk:
        desk.engine.play(scripted.acting())
        desk.engine.publish(waits(*WAITING), turn=None)
        await desk.press("3")
        await take_back(desk, 1, *WAITING[1:])
        await desk.press("ctrl+g", "3", "enter")
        again, dropped = desk.engine.sent[-2:]
        assert isinstance(again, Say)
        assert (again.text, dropped) == ("beep", Drop("R2"))
        beep = ev.WaitingRequest("R4", "beep", again.id)
        desk.engine.publish(waits(*WAITING[1:], beep), turn=None)  # as it was before the second one was dropped
        await desk.until(lambda: desk.engine.sent[-1] == Move("R4", "R3"))


async def test_one_that_has_begun_meanwhile_is_not_taken_back() -> None:
    async with waiting() as desk:
        await desk.press("enter")
        assert isinstance(desk.engine.sent[-1], Drop)
        desk.engine.publish(ev.Ack("drop", False, "It has begun."), turn=None)
        await desk.settled()
        assert desk.app.main.line.value == ""
        assert "It has begun already" in desk.text
        desk.engine.publish(ev.RequestEnded("R1", "beep", "done"), turn="T2")
        await desk.settled()
        assert desk.app.main.line.value == ""


async def test_where_nothing_waits_the_keys_do_what_they_do_everywhere() -> None:
    async with console() as desk:
        desk.engine.play(scripted.done())
        await desk.press("3", "enter")
        assert desk.app.screen is not desk.app.main, "the page of the turn"


@pytest.mark.parametrize(
    ("ended", "told"),
    [
        (ev.RequestEnded("R1", "beep", "interrupted", "stop"), "beep  never begun: stop"),
        (ev.RequestEnded("R1", "beep", "interrupted", "by_hand"), "beep  never begun: driving by hand"),
        (ev.RequestEnded("R1", "beep", "replaced", "replaced"), "beep  replaced before it began"),
        (ev.RequestEnded("R1", "beep", "rejected"), "beep  not taken: the robot was busy"),
        (ev.RequestEnded("R1", "beep", "left"), "beep  left: what it was to follow was not done"),
    ],
)
async def test_every_request_that_came_to_nothing_leaves_a_row_that_says_why(ended: ev.RequestEnded, told: str) -> None:
    async with console() as desk:
        desk.engine.publish(ended, turn=None)
        await desk.settled()
        assert f"■  {told}" in desk.text


async def test_the_log_repeats_no_end_that_has_a_row_and_names_no_command_of_programs() -> None:
    async with console() as desk:
        before = len(desk.app.shown.model.log)
        desk.engine.publish(ev.Ack("say", False, "Dropped before it started."), turn=None)
        desk.engine.publish(ev.RequestEnded("R1", "beep", "dropped"), turn=None)
        desk.engine.publish(ev.Ack("limit_speed", False, "The robot is not there yet."), turn=None)
        await desk.settled()
        assert "■  beep  dropped" in desk.text
        assert [(one.source, one.message) for one in desk.app.shown.model.log[before:]] == [
            ("session", "The robot is not there yet.")
        ]


@pytest.mark.parametrize(
    ("state", "told"), [("PLANNING", "replaced while it was planned"), ("ACTING", "replaced by a newer request")]
)
async def test_a_turn_that_was_replaced_leaves_a_row_as_well(state: ev.State, told: str) -> None:
    async with console() as desk:
        desk.engine.publish(ev.TranscriptFinal("go home", "text", "", 1.0, 0.0, 0.0, 0.0, 0.0))
        desk.engine.publish(ev.InterruptRaised("replaced", "say", state))
        result = ev.TurnResult(130, "interrupted", "A newer command replaced this one.")
        desk.engine.publish(ev.StateChanged(state, "WAITING", "interrupted", result))
        desk.engine.publish(ev.RequestEnded("R1", "go home", "replaced", "replaced"))
        await desk.settled()
        assert desk.text.count(told) == 1
        assert f"■  go home  {told}" in desk.text


@pytest.mark.parametrize("size", [(120, 40), (80, 24), (60, 20), (60, 16)], ids=str)
@pytest.mark.parametrize("language", ["en", "zh"])
async def test_how_many_wait_is_told_whichever_pane_stands_in_front(size: tuple[int, int], language: Language) -> None:
    async with console(size=size, language=language) as desk:
        desk.engine.play(scripted.acting())
        desk.engine.publish(waits(*WAITING[:2]), turn=None)
        await desk.press("5")
        head = desk.text.splitlines()[0]
        assert (" 2 waiting " if language == "en" else "2 个在等待") in head
        assert "esc" in head
        desk.engine.publish(waits(), turn=None)
        await desk.settled()
        assert " 2 " not in desk.text.splitlines()[0]


# Adding to what waits


@pytest.mark.parametrize(("size", "shown"), [((120, 40), True), ((80, 24), True), ((60, 20), True)])
async def test_while_something_runs_a_key_adds_what_is_written_to_what_waits(
    size: tuple[int, int], *, shown: bool
) -> None:
    async with console(size=size, in_line=True) as desk:
        await desk.press(*"nod")
        assert "ctrl+j afterwards" not in desk.text, "nothing runs"
        desk.engine.play(scripted.acting())
        await desk.settled()
        assert ("ctrl+j afterwards" in desk.text.splitlines()[-1]) is shown
        await desk.press("ctrl+j")
        assert desk.engine.sent == [Say("nod", wait=True)]
        assert desk.app.main.line.value == ""
        assert "ctrl+j afterwards" not in desk.text, "nothing is written"
        await desk.press(*"beep", "enter")
        assert desk.engine.sent[1:] == [Say("beep")]
        assert desk.app.main.line.history[-2:] == ["nod", "beep"]


async def test_several_that_were_pasted_are_added_one_after_the_other() -> None:
    async with console(in_line=True) as desk:
        desk.engine.play(scripted.acting())
        desk.app.main.line.paste("nod\nbeep\ngo home\n")
        await desk.press("ctrl+j")
        assert desk.engine.sent == [Say("nod", then=("beep", "go home"), wait=True)]


async def test_the_key_that_adds_says_what_it_is_for_where_nothing_is_written() -> None:
    async with console(in_line=True) as desk:
        await desk.press("ctrl+j")
        assert "Nothing is written to be done afterwards" in desk.text
        assert desk.engine.sent == []


# A question of the robot that is given up


def ask_about_a_bedroom(desk: Desk, *, waiting: int) -> None:
    """The robot asks about a request, behind which so many others wait."""
    desk.engine.publish(ev.TranscriptFinal("go to the bedrom", "text", "", 1.0, 0.0, 0.0, 0.0, 0.0))
    desk.engine.publish(waits(*WAITING[:waiting]), turn=None)
    desk.engine.publish(ev.ClarificationAsked("Shall I go to the bedroom?", "go to the bedrom"))
    result = ev.TurnResult(5, "clarify", "Shall I go to the bedroom?")
    desk.engine.publish(ev.StateChanged("CLARIFYING", "WAITING", "clarify", result))


@pytest.mark.parametrize(
    ("ended", "told"),
    [
        (ev.QuestionEnded("go to the bedrom", "replaced"), "■  go to the bedrom  replaced while it was asked about"),
        (
            ev.QuestionEnded("go to the bedrom", "withdrawn", "interrupt"),
            "■  go to the bedrom  question withdrawn: the stop key",
        ),
        (ev.QuestionEnded("go to the bedrom", "declined"), "■  go to the bedrom  given up: the answer was no order"),
        (ev.QuestionEnded("go to the bedrom", "withdrawn"), "■  go to the bedrom  given up: it was not answered"),
        (ev.QuestionEnded("go to the bedrom", "answered"), ""),
    ],
)
async def test_a_question_that_is_given_up_leaves_a_row_that_says_why(ended: ev.QuestionEnded, told: str) -> None:
    async with console() as desk:
        ask_about_a_bedroom(desk, waiting=0)
        desk.engine.publish(ended)
        await desk.settled()
        words = " ".join(desk.text.split())
        assert (" ".join(told.split()) in words) if told else ("■" not in desk.text)


@pytest.mark.parametrize(
    ("number", "told"),
    [
        (0, "Question withdrawn"),
        (1, "Question withdrawn · 1 waiting request dropped"),
        (3, "Question withdrawn · 3 waiting requests dropped"),
    ],
)
async def test_the_key_that_stops_says_what_it_has_ended_while_the_robot_asks(number: int, told: str) -> None:
    async with console(size=(160, 40)) as desk:
        ask_about_a_bedroom(desk, waiting=number)
        await desk.settled()
        assert "ASKING" in desk.text.splitlines()[0]

        def stopped(command: Command) -> None:
            desk.engine.publish(ev.InterruptRaised("interrupt", "interrupt", "WAITING"), turn=None)
            desk.engine.publish(waits(), turn=None)
            desk.engine.publish(ev.QuestionEnded("go to the bedrom", "withdrawn", "interrupt"))

        desk.engine.on_command = stopped
        await desk.press("escape")
        await desk.until(lambda: told in desk.text.splitlines()[0])
        assert "Nothing to stop" not in desk.text
        assert "ASKING" not in desk.text.splitlines()[0]


async def test_after_a_no_the_robot_asks_about_nothing_any_more() -> None:
    async with console(size=(160, 40), in_line=True) as desk:
        ask_about_a_bedroom(desk, waiting=0)
        desk.engine.publish(ev.TranscriptFinal("no", "text", "", 1.0, 0.0, 0.0, 0.0, 0.0))
        desk.engine.publish(ev.QuestionEnded("go to the bedrom", "declined"))
        told = "I heard “no”, so I do nothing. What shall I do?"
        desk.engine.publish(ev.ClarificationAsked(told, "no", leaves_open=False))
        desk.engine.publish(ev.StateChanged("CLARIFYING", "WAITING", "clarify", ev.TurnResult(5, "clarify", told)))
        await desk.press(*"nod")
        assert "READY" in desk.text.splitlines()[0]
        assert "ctrl+j" not in desk.text.splitlines()[-1]

        def stopped(command: Command) -> None:
            desk.engine.publish(ev.InterruptRaised("interrupt", "interrupt", "WAITING"), turn=None)

        desk.engine.on_command = stopped
        await desk.press("escape")
        assert "Nothing to stop" in desk.text.splitlines()[0]
        assert "Question withdrawn" not in desk.text


async def test_while_the_robot_asks_a_key_adds_what_is_written_to_what_waits() -> None:
    async with console(in_line=True) as desk:
        ask_about_a_bedroom(desk, waiting=0)
        await desk.press(*"nod")
        assert "ctrl+j afterwards" in desk.text.splitlines()[-1]
        await desk.press("ctrl+j")
        assert desk.engine.sent == [Say("nod", wait=True)]


async def test_an_action_that_runs_takes_the_robots_time_as_one_that_has_ended() -> None:
    async with console(ScriptedEngine(robot=robot_at(0.0, 0.0, 0.0, t=100.0), floor=flat())) as desk:
        args = {"seconds": 60.0}
        desk.engine.publish(ev.ActionStarted("a1", 1, 1, "wait", args, "Wait for 60 s", 100.0))
        desk.engine.robot = robot_at(0.0, 0.0, 0.0, t=144.5)
        desk.engine.publish(ev.Log("info", "test", "it goes on"), after=5.8)
        await desk.settled()
        assert "44.5 s" in desk.text
        desk.engine.publish(ev.ActionFinished("a1", "wait", args, "ok", None, "", 60.0), after=0.1)
        await desk.settled()
        assert "60.0 s" in desk.text


async def test_who_quits_while_something_waits_is_asked_once_more() -> None:
    async with console(size=(80, 24)) as desk:
        desk.engine.publish(ev.ClarificationAsked("Which one?", "bring me the cup"))
        desk.engine.publish(waits(*WAITING), turn=None)
        await desk.settled()
        await desk.press("q")
        assert "q again quits, esc drops it" in desk.text
        desk.engine.publish(ev.QuestionEnded("bring me the cup", "withdrawn", "interrupt"))
        desk.engine.publish(waits(), turn=None)
        await desk.settled()
        assert "again quits" not in desk.text


async def test_the_key_that_sends_says_that_it_puts_back_what_was_taken_back() -> None:
    async with waiting() as desk:
        await take_back(desk, 1, *WAITING[1:])
        assert ("send", "put back") in [(hint.action, hint.word) for hint in desk.app.shown.hints]
        await desk.press("enter")
        await desk.press(*"nod")
        assert ("send", "send") in [(hint.action, hint.word) for hint in desk.app.shown.hints]
