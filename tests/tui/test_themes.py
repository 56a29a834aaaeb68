"""The console in other colours: themes by name, one of high contrast, and none at all."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from rich.segment import Segment
from textual.color import Color
from textual.theme import BUILTIN_THEMES

from engine.errors import UsageError
from tests.tui import conversation as talk
from tests.tui import scripted
from tests.tui.desk import Desk, console
from tests.tui.scripted import ScriptedEngine, flat, robot_at
from tui.cli import build_parser
from tui.commands.console import run
from tui.looks.contrast import FRAMES, WORDS, ratio


def inks(desk: Desk) -> Iterator[tuple[Segment, Color, Color]]:
    """Everything on the screen with the colour that it has, and that of its ground."""
    for strip in desk.app.screen._compositor.render_strips():
        for segment in strip:
            if segment.style is not None and segment.style.color is not None and segment.style.bgcolor is not None:
                ink, ground = segment.style.color, segment.style.bgcolor
                yield segment, Color.from_rich_color(ink), Color.from_rich_color(ground)


def faintest(desk: Desk, *, words: bool) -> float:
    """The lowest contrast of a word, or of a frame."""
    return min(
        ratio(ink, ground)
        for segment, ink, ground in inks(desk)
        if (any(map(str.isalnum, segment.text)) if words else segment.text.startswith(("─", "│", "╭", "╰")))
    )


@pytest.mark.parametrize("keys", [(), ("enter",), ("question_mark",), ("ctrl+p",), ("slash", "g", "o")], ids=str)
async def test_in_high_contrast_no_word_and_no_frame_is_faint_on_any_page(keys: tuple[str, ...]) -> None:
    engine = ScriptedEngine(robot=robot_at(-1.35, 0.05, 0.4, speed=0.5), floor=flat())
    async with console(engine, theme="sayso-contrast") as desk:
        talk.play(engine, talk.ALL)
        engine.play(scripted.queueing())
        await desk.press(*keys)
        assert faintest(desk, words=True) >= WORDS
        assert faintest(desk, words=False) >= FRAMES


async def test_the_usual_theme_has_fainter_words_which_is_why_there_is_another() -> None:
    async with console() as desk:
        desk.engine.play(scripted.queueing())
        await desk.settled()
        assert faintest(desk, words=True) < WORDS


async def test_every_theme_is_chosen_by_its_name() -> None:
    async with console(size=(80, 24)) as desk:
        for theme in ("sayso-light", "sayso-contrast", *BUILTIN_THEMES):
            desk.app.dress(theme, 30)
            await desk.until(lambda theme=theme: desk.app.theme == theme)  # type: ignore[misc]
            await desk.settled()
            assert "READY" in desk.text


async def test_a_name_that_no_theme_has_is_told_with_the_nearest_one() -> None:
    async with console() as desk:
        desk.app.dress("sayso-contrst", 30)
        await desk.until(lambda: any("sayso-contrst" in line.message for line in desk.app.shown.model.log))
        assert desk.app.theme == "sayso-dark"
        assert desk.app.shown.model.log[-1].message.endswith("Did you mean sayso-contrast?")
        await desk.settled()
        assert "There is no theme 'sayso-contrst'" in desk.text.splitlines()[0]


@pytest.mark.parametrize("given", [["--theme", "sayso-lihgt"], ["--set", "console.theme=sayso-lihgt"]])
def test_an_option_that_names_no_theme_is_an_error_at_start(given: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tui.commands.console.why_not_usable", lambda *_: "")
    with pytest.raises(UsageError, match="There is no theme called 'sayso-lihgt'") as error:
        run(build_parser().parse_args(given))
    assert error.value.hint.startswith("Did you mean sayso-light? There are: sayso-dark, ")
    assert "nord" in error.value.hint


@pytest.mark.parametrize("theme", ["sayso-dark", "sayso-contrast"])
async def test_with_no_color_there_is_none_and_the_state_is_still_a_sign_and_a_word(
    theme: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    engine = ScriptedEngine(robot=robot_at(-1.35, 0.05, 0.4, speed=0.5), floor=flat())
    async with console(engine, theme=theme) as desk:
        engine.play(scripted.failed())
        await desk.settled()
        colours = {colour for _, *both in inks(desk) for colour in both}
        assert len(colours) > 2
        assert all(max(colour.rgb) - min(colour.rgb) <= 2 for colour in colours)
        assert "✗ FAILED" in desk.text
