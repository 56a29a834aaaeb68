"""When a console has done what it was told: every widget has answered its messages and the screen is drawn.

Textual's own pilot looks at the processor instead: it waits until the process has computed nothing for 20 ms. That
takes most of the time of a test, and on a busy machine, where a process stands still now and then, it is no sign.
It also sends every widget a message, at every key and pause, to learn that the messages before have been answered;
whether a widget waits for the next one can be seen without.
"""

from __future__ import annotations

import asyncio
from typing import Final

import textual.app
import textual.pilot
from textual._context import active_app
from textual.app import App
from textual.message_pump import MessagePump
from textual.pilot import Pilot
from textual.screen import Screen

_ROUNDS: Final = 3
"""Messages are answered by messages: that often in a row there must have been none."""
_TURNS: Final = 200
"""Others get their turn at once, so often; after that a millisecond later, as somebody waits for a thread."""
_LIMIT: Final = 30_000
"""A test whose console is busy for so many turns fails."""


async def all_is_done(min_sleep: float = 0, max_sleep: float = 1) -> None:
    """In the place of ``textual._wait.wait_for_idle``, with the same parameters; these are times, and not needed."""
    await _rests(active_app.get())


async def _wait_for_screen(pilot: Pilot[None], timeout: float = 30.0) -> bool:
    """In the place of the pilot's own: False when the console ends, or has a fault, which the test is told."""
    return await _rests(pilot.app)


async def _rests(app: App[None]) -> bool:
    quiet = 0
    for turn in range(_LIMIT):
        if not app.is_running or app._exception_event.is_set():
            return False
        if quiet == _ROUNDS:
            return True
        await asyncio.sleep(0 if turn < _TURNS else 0.001)
        if any(map(_is_busy, (app, *app.screen.walk_children(with_self=True)))):
            quiet = 0
        elif app._resize_event is not None:
            app._check_resize()
            quiet = 0
        elif _to_be_drawn(app.screen):
            app.screen._on_timer_update()
            quiet = 0
        else:
            quiet += 1
    raise AssertionError("The console does not come to rest.")


def _is_busy(pump: MessagePump) -> bool:
    """Whether it has a message, or is answering one: then it does not wait for the next."""
    queue = pump._message_queue
    return bool(queue.values) or not (queue.ready_event._waiters or pump._closed)  # type: ignore[attr-defined]


def _to_be_drawn(screen: Screen[object]) -> bool:
    layout = screen._layout_required or screen._scroll_required or screen._recompose_required
    return bool(layout or screen._repaint_required or screen._dirty_widgets or screen._callbacks)


def use() -> None:
    """From now on pilots wait like this."""
    for module in (textual.app, textual.pilot):
        module.wait_for_idle = all_is_done  # type: ignore[attr-defined]
    Pilot._wait_for_screen = _wait_for_screen  # type: ignore[method-assign]
