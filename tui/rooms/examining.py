"""Where the page of the doctor is opened, and what it examines with; its modules are read when it is opened."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from tui.rooms.keeping import Keeping
from tui.words import strings

if TYPE_CHECKING:
    from tui.doctor.examiner import Examiner
    from tui.doctor.finding import Finding
    from tui.stage import Stage


class Examining:
    """Opens the page, and has what is behind it. In the UI thread, but for what is examined."""

    def __init__(self, stage: Stage, keeping: Keeping) -> None:
        self._stage = stage
        self._keeping = keeping
        self._make: Callable[[], Examiner] | None = None
        self._examiner: Examiner | None = None

    def know(self, make: Callable[[], Examiner]) -> None:
        """The settings are read: there is something to examine. Thread-safe."""
        self._make = make

    def toggle(self) -> None:
        """Open the page, which examines everything, or leave it."""
        from tui.screens.doctor import DoctorScreen

        stage = self._stage
        if isinstance(stage.screen, DoctorScreen):
            stage.step_back()
        elif self._make is None:
            self._keeping.tell(strings.NOTHING_TO_EXAMINE)
        else:
            stage.come_back()
            stage.open_page(DoctorScreen(stage.acting, stage.shown, self._examine))

    def _examine(self, begins: Callable[[str], object]) -> Iterator[Finding]:
        """In a thread of the page."""
        if self._examiner is None and self._make is not None:
            self._examiner = self._make()
        if self._examiner is not None:
            handle = self._stage.handle
            yield from self._examiner.examine(handle.status() if handle is not None else (), begins)
