"""Pictures as pixels: what a terminal is asked, what is sent to one that has graphics, and what is left on it."""

from __future__ import annotations

import os
import queue
import threading
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from textual.geometry import Region

from tests.tui.paper import CELL, PLACE, SIZE, Paper, far_off
from tests.tui.scripted import sight_of
from tests.tui.told import PATIENCE_S
from tests.tui.unshown import unshown
from tui.graphics.answers import ANSWER_S, KEY_S, Answers
from tui.graphics.asking import Asking, Cell, Graphics, GraphicsChoice, Protocol, cell_of
from tui.graphics.pixels import Inks, indexed, marked
from tui.graphics.surface import LIMIT_BYTES, Surface
from tui.graphics.tiles import Extent
from tui.terminal.driver import listening_driver

SIGHT = sight_of()
PICTURE = SIGHT.picture.rgb
INKS = Inks(frame=(0, 255, 255), name=(0, 0, 0), plate=(255, 255, 0))

XTERM = "\x1b[?64;1;2;4;6;9;15;16;17;18;21;22;28c"
KITTY = "\x1b[?62;52;c"
OK = "\x1b_Gi=31;OK\x1b\\"


def both(paper: Paper, surface: Surface, *, hurt: tuple[Region, ...] = (), place: Region | None = PLACE) -> int:
    """A frame: text, and the picture behind it. Gives the bytes of the picture."""
    for region in hurt:
        paper.overwrite(region)
    sent = surface.behind(place, hurt)
    paper.feed(sent)
    return len(sent)


def shown(paper: Paper, surface: Surface, rgb: NDArray[np.uint8]) -> list[int]:
    """Show a picture until it is as fine as it becomes; gives the bytes of each."""
    sent: list[int] = []
    while not sent or sent[-1]:
        assert len(sent) < 6, sent
        surface.paint(rgb, (), SIZE, INKS)
        sent.append(both(paper, surface))
    return sent


# What is sent


@pytest.mark.parametrize("protocol", ["sixel", "kitty"])
def test_the_picture_on_the_terminal_is_what_the_camera_sees(protocol: Protocol) -> None:
    paper, surface = Paper(), Surface(Graphics(protocol, CELL))
    shown(paper, surface, PICTURE)
    assert far_off(paper.seen(), PICTURE) < 0.05
    assert far_off(paper.seen(), np.ascontiguousarray(PICTURE[:, ::-1])) > 0.3, "and it would be noticed"
    noise = np.random.default_rng(1).integers(-5, 6, PICTURE.shape)
    assert surface.paint(np.clip(PICTURE + noise, 0, 255).astype(np.uint8), (), SIZE, INKS) < 500
    after = PICTURE.copy()
    after[40:60, 30:50] = (255, 0, 0)
    shown(paper, surface, after)
    assert far_off(paper.seen(), after) < 0.05


@pytest.mark.parametrize("protocol", ["sixel", "kitty"])
def test_a_picture_that_changes_as_a_whole_costs_no_more_than_it_may_and_becomes_fine_when_it_stands(
    protocol: Protocol,
) -> None:
    paper, surface = Paper(), Surface(Graphics(protocol, CELL))
    rough = np.random.default_rng(2).normal(0, 4, PICTURE.shape)
    turned = np.clip(np.roll(PICTURE, 60, axis=1) + rough, 0, 255).astype(np.uint8)
    shown(paper, surface, PICTURE)
    assert surface.paint(turned, (), SIZE, INKS) <= LIMIT_BYTES
    shown(paper, surface, turned)
    assert far_off(paper.seen(), turned) < 0.05


def test_of_a_sixel_picture_only_what_has_changed_or_was_overwritten_is_sent() -> None:
    paper, surface = Paper(), Surface(Graphics("sixel", CELL))
    whole = max(shown(paper, surface, PICTURE))
    after = PICTURE.copy()
    after[:20, :20] = (255, 0, 0)
    assert max(shown(paper, surface, after)) < whole / 4
    assert far_off(paper.seen(), after) < 0.05
    hurt = Region(70, 15, 20, 2)
    assert 0 < both(paper, surface, hurt=(hurt, Region(0, 0, 5, 5))) < whole / 3
    assert far_off(paper.seen(), after) < 0.05


def test_a_sixel_picture_never_leaves_its_place() -> None:
    place = Region(3, 2, 13, 5)
    for height in (15, 16, 17, 18, 21, 23):
        cell = Cell(7, height)
        paper, surface = Paper(20, 10, cell), Surface(Graphics("sixel", cell))
        surface.paint(np.full_like(PICTURE, 200), (), Extent(13, 5), INKS)
        both(paper, surface, place=place)
        assert (paper.seen(place) > 150).all()
        paper.overwrite(place)
        assert not paper.pixels.any()


def test_a_kitty_picture_is_taken_away_when_it_is_not_to_be_seen_and_sent_again_in_its_new_place() -> None:
    paper, surface = Paper(), Surface(Graphics("kitty"))
    surface.paint(PICTURE, (), SIZE, INKS)
    both(paper, surface)
    assert len(paper.placed) == 1
    both(paper, surface, place=None)
    assert not paper.placed
    elsewhere = PLACE.translate((3, 3))
    both(paper, surface, place=elsewhere)
    assert far_off(paper.seen(elsewhere), PICTURE) < 0.05
    for place in (None, PLACE, None, elsewhere):
        both(paper, surface, place=place)
        assert len(paper.placed) == (place is not None)
    assert both(paper, surface, hurt=(Region(0, 0, 120, 40),), place=elsewhere), "all is drawn anew"
    assert len(paper.placed) == 1
    surface.clear()
    both(paper, surface, place=elsewhere)
    assert not paper.placed


def test_frames_and_names_are_pixels_of_the_picture() -> None:
    for name, box in (("red box", (20, 30, 60, 50)), ("tag 3", (0, 0, 160, 120)), ("cup", (158, 1, 160, 3))):
        rgb = np.zeros((120, 160, 3), dtype=np.uint8)
        thing = replace(SIGHT.objects[0], box=box)
        marked(rgb, (thing,), 160, 120, INKS)
        assert (rgb[box[1], box[0] : box[2]].max(axis=1) > 0).all(), name
        assert (rgb == INKS.plate).all(axis=2).any()
        assert (rgb == INKS.frame).all(axis=2).any()


def test_few_colours_are_those_that_are_frequent() -> None:
    rgb = np.zeros((4, 4, 3), dtype=np.uint8)
    rgb[:2], rgb[2], rgb[3, 3] = (200, 0, 0), (0, 200, 0), (190, 10, 0)
    few = indexed(rgb, 3)
    assert len(few.colours) == 3
    assert few.rgb[3, 3].tolist() == [200, 0, 0]
    assert (indexed(rgb, 256).rgb == rgb).all()


# What a terminal is asked


def found(
    choice: GraphicsChoice, *answers: str, cell: Cell | None = None, environ: Mapping[str, str] | None = None
) -> Graphics | None:
    asking = Asking(choice, environ or {"TERM": "xterm-256color"}, cell)
    if not asking.begin():
        assert asking.over
    for answer in answers:
        asking.answered(answer)
    return asking.found if asking.over else None


def test_only_what_the_terminal_says_itself_is_believed() -> None:
    assert found("auto", "\x1b[6;20;10t", XTERM, XTERM) == Graphics("sixel", Cell(10, 20))
    assert found("auto", XTERM, XTERM) is None, "sixel needs the size of a character"
    assert found("auto", XTERM, XTERM, cell=CELL) == Graphics("sixel", CELL)
    assert found("auto", KITTY, OK, KITTY) == Graphics("kitty")
    assert found("auto", "\x1b[6;20;10t", XTERM, OK, XTERM) == Graphics("kitty", CELL), "which costs less"
    assert found("auto", KITTY, "\x1b_Gi=31;ENOTSUPPORTED\x1b\\", KITTY) is None
    assert found("auto", "\x1b[?1;2c", cell=CELL) is None
    assert found("auto", cell=CELL) is None, "it never answers"
    assert found("auto", "\x1b[6;0;10t", XTERM, XTERM) is None


def test_old_terminals_are_not_asked_what_they_would_print() -> None:
    asking = Asking("auto", {"TERM": "xterm"})
    assert "\x1b_" not in asking.begin()
    assert asking.answered("\x1b[?6c") == ""
    assert asking.over


@pytest.mark.parametrize("environ", [{"TMUX": "/tmp/x,1,0"}, {"STY": "1"}, {"TERM": "screen"}, {"NO_COLOR": "1"}])
def test_a_terminal_in_a_terminal_is_not_asked_unless_somebody_knows_better(environ: dict[str, str]) -> None:
    asking = Asking("auto", environ, CELL)
    assert asking.begin() == ""
    assert asking.over
    assert asking.found is None
    assert found("kitty", environ=environ) == Graphics("kitty")
    assert found("sixel", cell=CELL, environ=environ) == Graphics("sixel", CELL)
    assert found("sixel", "\x1b[6;20;10t", "\x1b[?1;2c", environ=environ) == Graphics("sixel", CELL)


def test_the_size_of_a_character_may_be_known_from_the_system() -> None:
    assert cell_of(100, 50, 1000, 1000) == CELL
    assert cell_of(100, 50, 0, 0) is None
    assert cell_of(0, 0, 0, 0) is None


# Answers are no keys


def test_answers_are_taken_out_of_what_is_typed_wherever_the_line_tears_them() -> None:
    stream = f"a{XTERM}b{OK}\x1b[Ac{KITTY}d"
    for tear in range(len(stream)):
        told: list[str] = []
        answers = Answers(told.append, clock=lambda: 0.0)
        answers.expect()
        answers.expect()
        typed = answers.taken(stream[:tear]) + answers.taken(stream[tear:])
        assert typed == "ab\x1b[Acd"
        assert told == [XTERM, OK, KITTY]
        assert not answers.awaited
        assert answers.taken("\x1b") == "\x1b", "nothing is held back any more"


def test_what_turns_out_to_be_typed_is_held_back_for_a_moment_only() -> None:
    now = 0.0
    answers = Answers(lambda answer: None, clock=lambda: now)
    assert answers.taken("\x1b[?6") == "\x1b[?6", "nothing was asked"
    answers.expect()
    assert answers.taken("x\x1b") == "x"
    assert answers.overdue() == ""
    now += KEY_S
    assert answers.overdue() == "\x1b"
    assert answers.taken("\x1b[6") == ""
    assert answers.taken("~") == "\x1b[6~", "page down"
    assert answers.taken("\x1b_Gi=31") == ""
    now += KEY_S
    assert answers.overdue() == "", "nobody types that"
    now += ANSWER_S
    assert answers.overdue() == "\x1b_Gi=31"


def test_the_driver_tells_answers_and_no_key_and_the_escape_key_acts_at_once_while_it_waits_for_them() -> None:
    acted: queue.SimpleQueue[str] = queue.SimpleQueue()
    inside, outside = os.pipe()

    driver = listening_driver(
        unshown(inside, acted), acted.put, on_answer=lambda answer: acted.put(f"answer {answer}")
    )()  # type: ignore[call-arg]
    driver.ask("?")
    assert acted.get(timeout=PATIENCE_S) == "?"
    thread = threading.Thread(target=driver.run_input_thread)
    thread.start()
    for data, wanted in (
        (b"\x1b", ["escape", "(escape)"]),
        (b"\x1b[A", ["up", "(up)"]),
        (OK.encode(), [f"answer {OK}"]),
        (b"a" + XTERM.encode() + b"b", [f"answer {XTERM}", "a", "(a)", "b", "(b)"]),
        (b"\x1b", ["escape", "(escape)"]),
    ):
        os.write(outside, data)
        assert [acted.get(timeout=PATIENCE_S) for _ in wanted] == wanted
    assert acted.empty()
    os.close(outside)
    thread.join(PATIENCE_S)
    os.close(inside)
    assert not thread.is_alive()
