"""What is written of a change: the changed characters where they stand, and nothing else."""

from __future__ import annotations

import gc
import io
import re

from rich.console import Console
from rich.segment import Segment
from textual._compositor import ChopsUpdate
from textual.strip import Strip

from engine import events as ev
from tests.tui.desk import console
from tui.terminal.spans import cropped

CONSOLE = Console(file=io.StringIO(), force_terminal=True, color_system="truecolor", width=20)
LINE = {0: Strip([Segment("abcdefgh")]), 8: Strip([Segment("ijkl"), Segment("mnop")])}
CHOPS = [LINE, LINE, LINE]
ENDS = [[8, 16]] * 3


def written(*spans: tuple[int, int, int]) -> list[tuple[int, int, str]]:
    """Row, column and text of each piece that is written."""
    update = cropped(ChopsUpdate(CHOPS, list(spans), ENDS))
    assert isinstance(update, ChopsUpdate)
    pieces = re.findall(r"\x1b\[(\d+);(\d+)H([^\x1b]*)", update.render_segments(CONSOLE))
    return [(int(row) - 1, int(column) - 1, text) for row, column, text in pieces]


def test_a_span_begins_where_it_begins_and_ends_where_it_ends() -> None:
    assert written((1, 3, 5)) == [(1, 3, "de")]
    assert written((0, 10, 13)) == [(0, 10, "klm")]


def test_a_span_over_two_panes_is_written_in_two_pieces() -> None:
    assert written((2, 6, 10)) == [(2, 6, "gh"), (2, 8, "ij")]
    assert written((2, 0, 16)) == [(2, 0, "abcdefgh"), (2, 8, "ijklmnop")]


def test_every_span_is_written_in_its_row() -> None:
    assert written((0, 0, 1), (1, 15, 16)) == [(0, 0, "a"), (1, 15, "p")]


def test_what_ends_where_a_span_begins_is_not_written() -> None:
    assert written((0, 8, 9)) == [(0, 8, "i")]
    assert written((0, 7, 8)) == [(0, 7, "h")]


def test_a_span_that_cuts_a_wide_character_has_all_of_it() -> None:
    wide = {0: Strip([Segment("a去厨房b")]), 8: Strip([Segment("cdefghij")])}
    update = cropped(ChopsUpdate([wide], [(0, 2, 4)], [[8, 16]]))
    assert isinstance(update, ChopsUpdate)
    assert "去厨" in update.render_segments(CONSOLE)
    assert "\x1b[1;2H" in update.render_segments(CONSOLE), "where the first of them begins"


def test_anything_else_is_displayed_as_it_is() -> None:
    assert cropped(None) is None
    assert cropped("words") == "words"


async def test_what_was_drawn_is_gone_without_a_garbage_collection() -> None:
    """Collections hold the interpreter lock, for which those that stop the robot have to wait."""
    async with console() as desk:
        await desk.settled()
        gc.collect()
        gc.disable()
        gc.set_debug(gc.DEBUG_SAVEALL)
        try:
            for number in range(5):
                desk.engine.publish(ev.Log("info", "engine", f"line {number}"))
                await desk.settled()
            gc.collect()
            assert not [thing for thing in gc.garbage if isinstance(thing, Strip)]
        finally:
            gc.set_debug(0)
            gc.garbage.clear()
            gc.enable()
