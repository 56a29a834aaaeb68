"""A console at which a test sits: it presses keys, lets the engine speak, and reads the screen."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass

from rich.cells import cell_len
from textual.pilot import Pilot

from engine.handle import EngineHandle
from tests.tui.pictures import svg_of
from tests.tui.scripted import ScriptedEngine, flat, robot_at
from tui.app import SaysoApp
from tui.widgets.log import LogView
from tui.words.language import Language, Telling, speak

PAUSES = 10_000
"""After so many turns without the awaited thing, a test fails."""


@dataclass
class Desk:
    """A running console, the engine behind it, and a hand on its keys."""

    app: SaysoApp
    engine: ScriptedEngine
    pilot: Pilot[None]

    async def until(self, condition: Callable[[], object]) -> None:
        """Let the console work until the condition holds."""
        for _ in range(PAUSES):
            if condition():
                return
            await asyncio.sleep(0.002)  # others' turn: the screen, its timers and the engine's threads
        raise AssertionError("The console did not get there.")

    async def settled(self) -> None:
        """Let the console show everything that has happened."""
        await self.pilot.pause()  # whatever was told to the console has asked for a frame then…
        await self.until(self._all_is_shown)  # …which has been drawn
        await self.pilot.pause()

    def _all_is_shown(self) -> bool:
        """What is drawn is what is known: all of it at one moment, as a frame may bring news that ask for another one,
        and the log comes behind at a pace of its own."""
        log, drawing = self.app.screen_stack[0].query_one(LogView), self.app.drawing
        known = drawing.view.model is drawing.model and drawing.model.t >= self.engine.t
        return known and not drawing.due and log.known == drawing.model.log and self._is_laid_out

    @property
    def _is_laid_out(self) -> bool:
        """Textual lays out and paints by a timer, for which a pause of the pilot's does not wait."""
        screen = self.app.screen
        layout = screen._layout_required or screen._scroll_required or screen._recompose_required
        return not (layout or screen._repaint_required or screen._dirty_widgets)

    async def press(self, *keys: str) -> None:
        """Press keys, one after the other, and let the console show what came of them."""
        await self.settled()  # who presses keys has seen what there was to see
        await self.pilot.press(*keys)
        await self.settled()

    async def click(self, words: str) -> None:
        """Click on these words, the first of that kind on the screen, and let the console show what came of it."""
        await self.settled()
        rows = self.text.splitlines()
        y = next(number for number, row in enumerate(rows) if words in row)
        await self.pilot.click(offset=(cell_len(rows[y].partition(words)[0]), y))
        await self.settled()

    async def picture(self) -> str:
        """The screen once it has come to rest."""
        await self.settled()
        before, now = "", svg_of(self.app)
        while before != now:
            await self.settled()
            before, now = now, svg_of(self.app)
        return now

    @property
    def shown_problem(self) -> str:
        """The words of the panel about what failed; nothing when it is not shown."""
        problem = self.app.shown.model.problem
        return "" if problem is None else f"{problem.title} {problem.message}"

    @property
    def text(self) -> str:
        """The characters on the screen."""
        strips = self.app.screen._compositor.render_strips()
        return "\n".join(strip.text for strip in strips)


@asynccontextmanager
async def console(
    engine: ScriptedEngine | None = None,
    *,
    size: tuple[int, int] = (120, 40),
    start: Callable[[], EngineHandle] | None = None,
    keymap: Mapping[str, str] | None = None,
    theme: str = "sayso-dark",
    language: Language = "en",
    wording: Telling | None = None,
    one_line: bool = False,
    in_line: bool = False,
    notices: bool = False,
) -> AsyncIterator[Desk]:
    """A console on a terminal of this size. Its clock stands still: durations come from events alone.

    ``in_line``: the keyboard is in the line, as it is from the start; else the test has gone to the panes by a key, so
    that letters are keys. ``notices``: those that lie over the screen are drawn."""
    engine = engine or ScriptedEngine(robot=robot_at(-1.35, 0.05, 0.4), floor=flat())
    app = SaysoApp(
        start or (lambda: engine),
        fps=30,
        clock=lambda: 0.0,
        keymap=keymap,
        theme=theme,
        language=language,
        one_line=one_line,
    )
    try:
        async with app.run_test(size=size, notifications=notices) as pilot:
            desk = Desk(app, engine, pilot)
            app.speak(language, wording)
            if start is None:
                await desk.until(lambda: app.shown.started and app.shown.parts == engine.parts)
            await desk.settled()
            if not in_line and app.main.line.has_focus:
                await desk.press("ctrl+g")
            yield desk
    finally:
        speak("en")  # other tests of this process look at words without a console
