"""When a console has done what it was told: every widget has answered its messages and the screen is drawn.

Textual's own pilot looks at the processor instead: it waits until the process has computed nothing for 20 ms. That
takes most of the time of a test, and on a busy machine, where a process stands still now and then, it is no sign.
"""

from __future__ import annotations

import textual.app
import textual.pilot
from textual._context import active_app
from textual.app import App
from textual.pilot import Pilot

_ROUNDS = 3
"""Messages are answered by messages: that often in a row there must have been none."""


async def all_is_done(min_sleep: float = 0, max_sleep: float = 1) -> None:
    """In the place of ``textual._wait.wait_for_idle``, with the same parameters; these are times, and not needed."""
    app = active_app.get()
    pilot: Pilot[None] = Pilot(app)
    quiet = 0
    while quiet < _ROUNDS and app.is_running:
        if not await pilot._wait_for_screen():
            return  # it is ending, or has a fault, which the test is told
        drawn = not _to_be_drawn(app)
        if not drawn:
            app.screen._on_timer_update()
        quiet = quiet + 1 if drawn and not _told(app) else 0


def _to_be_drawn(app: App[None]) -> bool:
    screen = app.screen
    return bool(screen._dirty_widgets or screen._layout_required or screen._repaint_required or screen._callbacks)


def _told(app: App[None]) -> bool:
    """Somebody has a message to answer."""
    return any(pump.message_queue_size for pump in (app, *app.screen.walk_children(with_self=True)))


def use() -> None:
    """From now on pilots wait like this."""
    for module in (textual.app, textual.pilot):
        module.wait_for_idle = all_is_done  # type: ignore[attr-defined]
