"""How the console ends: left by a key, with the terminal, by a signal or by a fault of its own.

However it ends, the robot stops first, the engine gets a moment to end as well, and the exit code tells why.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
from collections.abc import Callable
from types import FrameType
from typing import TYPE_CHECKING, Final

from engine.commands import Quit
from engine.errors import ExitCode
from tui.messages import HungUp
from tui.output import ENDING
from tui.words import strings

if TYPE_CHECKING:
    from rich.text import Text

    from tui.stage import Stage

LEAVE_LIMIT_S: Final = 3.0
"""How long an orderly end may take when the terminal is gone or the process is to end."""


class Leaving:
    """Ends the console. :meth:`hang_up` may be called in any thread, the others in the main thread."""

    def __init__(self, stage: Stage) -> None:
        self.asked = False
        """The user wants to leave while something is not finished, and is asked whether that is meant."""
        self.unsubscribe: Callable[[], None] | None = None
        """Ends what the engine tells the console."""
        self.secrets: tuple[str, ...] = ()
        """What a report of a fault does not tell."""
        self._stage = stage
        self._fault: BaseException | None = None  # of the console itself: the first one
        self._exit_code = ExitCode.DONE
        self._left = threading.Event()
        self._closing: list[Callable[[], None]] = []

    def watch(self) -> None:
        """From now on, signals that end other programs end this one in order."""
        for number in ENDING:
            signal.signal(number, self._signalled)

    def at_the_end(self, close: Callable[[], None]) -> None:
        """Once the console is left, files are closed by this."""
        self._closing.append(close)

    def failed(self, code: ExitCode) -> None:
        """Something failed for good; the first failure gives the exit code."""
        if self._exit_code is ExitCode.DONE:
            self._exit_code = code

    def leave(self) -> None:
        """Quit: the robot has stopped when the console goes."""
        stage = self._stage
        stage.send(Quit())
        unsubscribe, self.unsubscribe = self.unsubscribe, None
        if stage.engine_hangs:
            self._exit_code = self._exit_code or ExitCode.FAILED
        elif unsubscribe is not None:
            unsubscribe()
        stage.exit(return_code=int(self._exit_code))

    def hang_up(self) -> None:
        """The terminal is gone, or a signal ends us (``ENDING``). In any thread: the robot stops first."""
        self._exit_code = ExitCode.INTERRUPTED
        self._stage.send(Quit())
        self._stage.post_message(HungUp())
        threading.Thread(target=self._leave_for_sure, name="leave", daemon=True).start()

    def fault(self, error: BaseException) -> None:
        """A fault of the console itself: the robot stops, and the first one is written down at the end."""
        if self._fault is None:
            self._fault = error
            with contextlib.suppress(Exception):  # this fault is the one to be told
                self._stage.send(Quit())

    def noted(self, error: BaseException) -> str:
        """A fault of the engine's start: written down at the end as well; gives what can be shown of it."""
        from config.secrets import masked

        self._fault = self._fault or error
        return masked(repr(error), self.secrets, os.environ)

    def traceback(self, error: BaseException) -> Text:
        """Without the values of local variables and other secrets."""
        from rich.text import Text

        from config.secrets import told

        return Text(told(error, self.secrets))

    def run(self) -> int:
        """Run the console until somebody leaves and the engine has ended, too; gives the exit code of the process."""
        stage = self._stage
        try:
            stage.run()
        except Exception as error:
            self._fault = self._fault or error
            stage.send(Quit())
            raise
        finally:
            if self._fault is not None:
                self._write_down(self._fault)
        self._left.set()
        for close in self._closing:
            close()
        code, limit = stage.return_code or 0, time.monotonic() + LEAVE_LIMIT_S
        while stage.handle is not None and not stage.handle.join(0.1):
            if stage.engine_hangs or time.monotonic() > limit:
                os._exit(code)  # the interpreter would wait for threads that hang
        return code

    def _write_down(self, error: BaseException) -> None:
        """The fault, where it can be found, and on stderr where that is."""
        from config.folders import paths
        from config.secrets import told
        from tui.kept.crash import write
        from tui.output import say

        try:
            line = strings.CRASH_WRITTEN.format(write(paths().state, told(error, self.secrets)))
        except OSError as trouble:
            line = strings.CRASH_LOST.format(trouble.strerror)
        say(line)

    def _signalled(self, number: int, frame: FrameType | None) -> None:
        """In a thread of its own: the one that was interrupted by the signal may hold what stopping needs."""
        threading.Thread(target=self.hang_up, name="hang-up", daemon=True).start()

    def _leave_for_sure(self) -> None:
        """The interface may wait for a terminal that takes nothing any more."""
        if not self._left.wait(LEAVE_LIMIT_S):
            os._exit(self._exit_code)
