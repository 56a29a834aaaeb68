"""Bars in characters: as long as their stage, on an axis that stands still, in whatever width there is."""

from __future__ import annotations

import asyncio

import pytest
from hypothesis import given
from hypothesis import strategies as st
from textual.app import App, ComposeResult

from tests.tui import conversation as talk
from tests.tui.conversation import Scene
from tests.tui.scripted import Step
from tests.tui.test_turns import after, turn_of, until_acting
from tui.shown.timeline import AXES, Bar, Stretch, axis, bars, cells
from tui.shown.turn import Sample
from tui.widgets.sound import FLOOR_DB, Wave, envelope, wave
from tui.widgets.timeline import Timeline, head, total


def drawn(bar: Bar, columns: int) -> str:
    return "".join(cell.char for cell in cells(bar, columns))


def bar(*stretches: Stretch, axis_s: float = 10.0) -> Bar:
    return Bar("plan", stretches, 0, axis_s)


def test_a_bar_ends_to_an_eighth_of_a_cell() -> None:
    assert [drawn(bar(Stretch(0.0, n / 8), axis_s=2.0), 2) for n in range(9)] == [
        "▏ ", "▏ ", "▎ ", "▍ ", "▌ ", "▋ ", "▊ ", "▉ ", "█ ",
    ]  # fmt: skip


def test_a_bar_begins_where_its_stage_does() -> None:
    assert drawn(bar(Stretch(3.0, 6.0)), 10) == "   ███    "
    assert drawn(bar(Stretch(3.5, 6.0)), 10) == "   ▐██    "


def test_what_took_no_time_is_still_seen() -> None:
    assert drawn(bar(Stretch(5.0, 5.0)), 10) == "     ▏    "
    assert drawn(bar(Stretch(10.0, 10.0)), 10) == "         ▕"


def test_silence_is_a_line_and_speech_is_solid() -> None:
    assert drawn(bar(Stretch(0.0, 3.0, "rest"), Stretch(3.0, 6.0)), 10) == "───███    "


def test_what_goes_on_beyond_the_axis_says_so() -> None:
    assert drawn(bar(Stretch(5.0, 30.0)), 10) == "     ████›"


@given(
    st.lists(st.tuples(st.floats(0, 400), st.floats(0, 400), st.sampled_from(["work", "again", "rest"])), max_size=6),
    st.sampled_from(AXES),
    st.integers(1, 200),
)
def test_every_bar_fills_exactly_its_columns(
    stretches: list[tuple[float, float, str]], axis_s: float, columns: int
) -> None:
    pieces = tuple(Stretch(a, a + b, look) for a, b, look in stretches)  # type: ignore[arg-type]
    line = drawn(bar(*pieces, axis_s=axis_s), columns)
    assert len(line) == columns
    assert bool(line.strip()) or not any(piece.look != "rest" for piece in pieces)


def test_the_axis_is_a_round_time_that_holds_the_thinking_and_not_all_of_the_driving() -> None:
    spoken, by_model = after(talk.SPOKEN, talk.BY_MODEL).kept
    assert (axis(spoken, spoken.ended or 0.0), axis(by_model, by_model.ended or 0.0)) == (10.0, 15.0)
    typed = turn_of(until_acting())
    assert [axis(typed, typed.began + seconds) for seconds in (0.5, 1.5, 9.0, 200.0)] == [1.0, 2.0, 10.0, 10.0]


def test_a_running_stage_is_drawn_anew_twice_a_second_and_no_oftener() -> None:
    turn = turn_of(until_acting())
    seen = {bars(turn, turn.began + 20 + frame / 8) for frame in range(80)}
    assert len(seen) == 21
    assert all(shown[-1].running for shown in seen)


def test_actions_in_a_row_can_be_told_apart() -> None:
    (turn,) = after(talk.BY_MODEL).kept
    act = next(bar for bar in bars(turn, 0.0) if bar.stage == "act")
    assert [stretch.look for stretch in act.stretches] == ["work", "again"]


def test_the_line_above_the_bars_says_how_it_went_and_how_long_one_waited() -> None:
    turns = after(talk.SPOKEN, talk.REFUSED, talk.ASKED_BACK, talk.UNHEARD, talk.NOBODY, talk.BY_MODEL).kept
    told = [(line.number, line.outcome, line.total) for turn in turns for line in (head(turn, shown=False),)]
    assert told == [
        (1, "done", "941 ms to motion"),
        (2, "refused", "1 ms to answer"),
        (3, "clarify", "2125 ms to answer"),
        (4, "unheard", ""),
        (5, "unheard", ""),
        (6, "interrupted", "4552 ms to motion"),
    ]


async def test_a_timeline_that_gets_more_room_shows_older_turns_without_any_news() -> None:
    class Room(App[None]):
        def compose(self) -> ComposeResult:
            yield Timeline(lambda action: None)

    async with Room().run_test(size=(80, 6)) as pilot:
        timeline = pilot.app.query_one(Timeline)
        turns = after(*talk.ALL).kept
        timeline.update_from(turns, None, 0.0)
        await pilot.pause()
        few = len(timeline.items)
        await pilot.resize_terminal(80, 60)
        async with asyncio.timeout(10):
            while timeline.size.height < 60:  # Textual lays out by a timer
                await pilot.pause()
        await pilot.pause()
        assert len(timeline.items) == sum(1 + len(list(bars(turn, 0.0))) for turn in turns) > few


def test_a_turn_that_moves_says_so_before_it_is_over() -> None:
    turn = turn_of(until_acting(), talk.driving(0.05))
    assert (turn.open, total(turn)) == (True, "60 ms to motion")


def test_a_turn_that_was_cut_before_a_word_does_not_claim_that_nobody_was_heard() -> None:
    scene = Scene(
        "T1",
        2,
        (*talk.woken(), Step(0.5, talk.interrupted("LISTENING")), talk.over("LISTENING", "interrupted", "", 130)),
    )
    (turn,) = after(scene).kept
    assert head(turn, shown=False).text == "nothing was said yet"


def test_the_envelope_runs_straight_between_the_floor_and_full_scale() -> None:
    samples = (Sample(0.1, -70, FLOOR_DB, False), Sample(0.2, -10, 0.0, True))
    assert [envelope(samples, share) for share in (0.0, 0.25, 0.5, 1.0)] == [0.0, 0.25, 0.5, 1.0]
    assert envelope((Sample(0.1, 9, 20.0, True),), 0.5) == pytest.approx(1.0)


def test_while_somebody_pauses_the_bar_of_the_recording_goes_on_as_a_line() -> None:
    turn = turn_of(*talk.woken(), *talk.speech(1.5, before=0.5, silence=0.5))
    (record,) = [bar for bar in bars(turn, turn.samples[-1].t + 0.6) if bar.stage == "record"]
    assert [stretch.look for stretch in record.stretches] == ["rest", "work", "rest"]
    assert head(turn, shown=True).text == "listening…"


def test_the_picture_of_a_recording_that_goes_on_grows_in_half_seconds_and_is_whole_at_its_end() -> None:
    shown = [
        list(wave(turn_of(*talk.woken(), *list(talk.speech(1.0, before=0.0, silence=0.0))[:n]))) for n in range(11)
    ]
    counts = [len(rows[1].samples) if rows and isinstance(rows[1], Wave) else 0 for rows in shown]
    assert counts == [0, 0, 0, 0, 0, 5, 5, 5, 5, 5, 10]
    (turn,) = after(talk.SPOKEN).kept
    assert {len(row.samples) for row in wave(turn) if isinstance(row, Wave)} == {len(turn.samples)} == {31}
