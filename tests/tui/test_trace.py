"""The trace of the microphone: one looks and knows why the robot did or did not hear."""

from __future__ import annotations

import pytest

from engine import events as ev
from tests.tui import conversation as talk
from tests.tui.conversation import Scene
from tests.tui.desk import console
from tests.tui.scripted import PARTS_LOADING, ScriptedEngine, Step
from tui.shown.facts import Level
from tui.shown.trace import MAX_TRACE, Mark, Trace, after
from tui.widgets.mic import MicStrip


def trace_of(*scenes: Scene) -> Trace:
    """The trace once these scenes were played."""
    engine, trace = ScriptedEngine(), Trace()

    def fold(event: ev.Event) -> None:
        nonlocal trace
        trace = after(trace, event)

    engine.subscribe(fold)
    talk.play(engine, scenes)
    return trace


def marks(trace: Trace) -> list[tuple[str, str, str]]:
    return [(item.sign, item.word, item.detail) for item in trace.items if isinstance(item, Mark)]


@pytest.mark.parametrize(
    ("scene", "told"),
    [
        (
            talk.SPOKEN,
            [
                ("wake", "woken by key", ""),
                ("endpoint", "end of speech", "1.7 s of speech"),
                ("understood", "understood", "confidence 85 %"),
            ],
        ),
        (
            talk.UNHEARD,
            [
                ("wake", "woken by the module", ""),
                ("endpoint", "end of speech", "1.3 s of speech"),
                ("rejected", "not understood clearly", "mean log-probability −1.4 “goat the kitten”"),
            ],
        ),
        (talk.NOBODY, [("wake", "woken by key", ""), ("rejected", "nobody spoke", "loudest −53 dB")]),
    ],
)
def test_every_recording_says_how_it_began_how_it_ended_and_what_came_of_it(
    scene: Scene, told: list[tuple[str, str, str]]
) -> None:
    assert marks(trace_of(scene)) == told


def test_marks_stand_where_they_happened() -> None:
    items = trace_of(talk.SPOKEN).items
    assert isinstance(items[0], Mark)
    assert all(isinstance(item, Level) for item in items[1:-2])
    assert [item.speech_probability > 0.5 for item in items[1:-2] if isinstance(item, Level)].index(True) == 7


def test_one_recording_follows_the_other_on_the_same_trace() -> None:
    trace = trace_of(talk.SPOKEN, talk.UNHEARD)
    assert [mark[0] for mark in marks(trace)] == ["wake", "endpoint", "understood", "wake", "endpoint", "rejected"]
    assert len(trace_of(*[talk.NOBODY] * 9).items) == MAX_TRACE


def test_levels_that_come_while_nobody_listens_are_no_part_of_it() -> None:
    late = Scene(
        "T1", 2, (Step(0.1, ev.ListenLevel(-20.0, -10.0, 0.9, True)), Step(0.0, ev.ListenEnded("silence", 1, 1)))
    )
    assert trace_of(late).items == ()


def test_a_stop_that_was_overheard_is_marked_with_its_words() -> None:
    heard = ev.TranscriptFinal("stop now", "overheard", "", 0.0, 0.0, 0.0, 0.0, 0.0)
    assert marks(trace_of(Scene("T1", 2, (Step(0.1, heard),)))) == [("understood", "overheard", "“stop now”")]


@pytest.mark.parametrize("size", [(120, 40), (80, 24)])
async def test_the_strip_says_in_words_why_something_was_not_heard(size: tuple[int, int]) -> None:
    async with console(size=size) as desk:
        talk.play(desk.engine, [talk.SPOKEN, talk.UNHEARD])
        await desk.settled()
        assert "✗ not understood clearly" in desk.text
        assert ("mean log-probability −1.4 “goat the kitten”" in desk.text) == (size[0] == 120)
        assert "◆✓▼" in desk.text


async def test_the_strip_goes_on_saying_what_was_heard_until_the_next_wake() -> None:
    async with console(size=(80, 24)) as desk:
        assert "○ not listening" in desk.text
        talk.play(desk.engine, [talk.SPOKEN])
        await desk.settled()
        assert "✓ understood" in desk.text
        talk.play(desk.engine, [Scene("T2", 3, (*talk.woken(), *talk.speech(1.0, before=0.3, silence=0.0)))])
        await desk.settled()
        assert "✓ understood" not in desk.text
        assert "● speech" in desk.text


async def test_a_missing_microphone_is_told_before_all_that_was_heard() -> None:
    async with console(ScriptedEngine(parts=PARTS_LOADING)) as desk:
        talk.play(desk.engine, [talk.SPOKEN])
        await desk.settled()
        assert "▲ No microphone" in desk.text


async def test_a_trace_that_stands_still_is_not_drawn_again(monkeypatch: pytest.MonkeyPatch) -> None:
    async with console() as desk:
        talk.play(desk.engine, [talk.SPOKEN])
        await desk.settled()
        strip, drawn = desk.app.query_one(MicStrip), []
        monkeypatch.setattr(strip, "refresh", lambda *regions, **_: drawn.extend(regions))
        strip.update_from(desk.app.shown.model.trace, notice="", trouble=False)
        drawn.clear()  # another notice
        strip.update_from(desk.app.shown.model.trace, notice="", trouble=False)
        assert drawn == []
