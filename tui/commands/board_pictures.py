"""Pictures of a chessboard, taken by themselves while a person moves it, who is told what to do next."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from engine.errors import CameraError, ExitCode
from engine.robot.calibration.views import WANTED, Flaw, Views, flaw_of
from tui.output import say

if TYPE_CHECKING:
    from engine.robot.calibration.chessboard import Chessboard, Pixels, View
    from engine.robot.camera import Lens
    from engine.robot.usb_camera import Capture

TELL_S: Final = 3.0
"""For so long nothing comes of the pictures before it is said why."""
STALE_S: Final = 0.5
"""A camera hands out some pictures from before it was asked: those of so long count for nothing."""
_FLAWS: Final[dict[Flaw, str]] = {
    "unseen": "the board is not seen, or not all of it",
    "moving": "hold it still",
    "blurred": "the picture is not sharp, or the board too far away",
}


class TooLong(CameraError):
    """The pictures that are needed did not come in time."""

    code = "timeout"
    exit_code = ExitCode.TIMEOUT


class BoardPictures:
    """A camera before which a board is held."""

    def __init__(self, capture: Capture, board: Chessboard, limit_s: float) -> None:
        """Take a first picture, of which nothing but the size is used. ``limit_s``: how long :meth:`held` and
        :meth:`lying` try. Raises ``CameraError``."""
        self._capture = capture
        self._board = board
        self._limit_s = limit_s
        self._count = 0
        self.height, self.width = capture.read().shape[:2]

    def held(self, guess: Lens) -> list[Pixels]:
        """Pictures of a board that is held in enough ways. Raises ``CameraError``, of which :class:`TooLong` is one."""
        views, told = Views(self._board, guess), self._now
        try:
            for now, view in self._views():
                verdict = views.look(view)
                if views.complete:
                    say(f"sayso: {WANTED} of {WANTED}")
                    break
                if verdict == "taken":
                    say(f"sayso: {len(views.taken)} of {WANTED}; {views.advice}")
                elif now - told > TELL_S:
                    say(f"sayso: {views.advice if verdict == 'like before' else _FLAWS[verdict]}")
                else:
                    continue
                told = now
        except CameraError as error:
            raise type(error)(f"{error.message} {views.reason}") from error
        return views.taken

    def lying(self) -> Pixels:
        """A picture of a board that lies where it is. Raises the same."""
        told, before, flaw = self._now, None, None
        try:
            for now, view in self._views():
                flaw = flaw_of(view, before, self.width)
                if flaw is None and view is not None:
                    return view.corners
                before = view
                if now - told > TELL_S:
                    say(f"sayso: {_FLAWS[flaw or 'unseen']}")
                    told = now
        except CameraError as error:
            raise type(error)(f"{error.message} On the floor, {_FLAWS[flaw or 'unseen']}.") from error
        raise AssertionError("it looks until it finds it, or the time is over")

    @property
    def _now(self) -> float:
        """s; in a film, where nobody waits, by its pictures."""
        return self._count * self._capture.pace if self._capture.pace else time.monotonic()

    def _views(self) -> Iterator[tuple[float, View | None]]:
        """Boards as they are seen, or not, from now on. Raises ``CameraError``."""
        began = self._now
        while (now := self._now) - began < self._limit_s:
            bgr = self._capture.read()
            self._count += 1
            if now - began >= STALE_S:
                yield now, self._board.find(bgr)
        raise TooLong(f"{self._limit_s:g} s are over.")
