"""A terminal driver that lets a key act the moment it arrives, and that outlives its terminal.

Textual's drivers read the keyboard in a thread of its own and queue each key for the user interface. When the link to
the terminal stalls, the interface waits for it, and so would a key in its queue. Stopping a robot cannot wait: this
driver shows each key to a callback in the reading thread, before it is queued.

The escape key is the byte that also begins every escape sequence, so a parser has to wait for what follows (25 ms and
more). This driver does not: a read of that byte alone is the key. Over a link that tears a sequence apart, an arrow
key may stop the robot, which is the right side to err on.

A terminal that is gone reads as an end of file or an error. Then a second callback is called, once, and whatever is
still written goes nowhere.
"""

from __future__ import annotations

import codecs
import contextlib
import errno
import os
import select
import threading
from collections.abc import Callable
from typing import IO, Any, Final

from textual import events
from textual.driver import Driver
from textual.message import Message

ESCAPE: Final = b"\x1b"
READ_BYTES: Final = 4096
GONE: Final = (errno.EIO, errno.EPIPE, errno.ENXIO)
"""What writing to a terminal that is gone fails with."""
IDLE_S: Final = 0.1
"""How often the reading thread looks whether it is to end."""
SEQUENCE_S: Final = 0.03
"""How long to wait for the rest of a sequence, which is not much longer than the parser does."""


def listening_driver(
    base: type[Driver], on_key: Callable[[str], None], on_hang_up: Callable[[], None] = lambda: None
) -> type[Driver]:
    """A driver like ``base`` that calls ``on_key`` with the name of each key, and ``on_hang_up`` when the terminal is
    gone, both in the reading thread."""

    class ListeningDriver(base):  # type: ignore[valid-type,misc]
        _acted = False  # the last read was an escape key, which has acted

        def process_message(self, message: Message) -> None:
            if isinstance(message, events.Key) and not (self._acted and message.key == "escape"):
                on_key(message.key)
            super().process_message(message)

    try:
        from textual.drivers.linux_driver import LinuxDriver
    except ImportError:  # no POSIX terminal here
        return ListeningDriver
    if not issubclass(base, LinuxDriver):
        return ListeningDriver

    from textual._xterm_parser import XTermParser

    class TerminalDriver(ListeningDriver):
        _file: Any
        reader: int | None = None
        """The thread that reads, as the system knows it."""

        def __init__(self, *args: Any, **kwargs: Any) -> None:
            super().__init__(*args, **kwargs)
            self._file = _Lasting(self._file)

        def run_input_thread(self) -> None:
            """As Textual's, but for the escape key and the end of the terminal."""
            parser = XTermParser(self._debug)
            decode = codecs.getincrementaldecoder("utf-8")(errors="replace").decode
            incomplete = False
            self.reader = threading.get_native_id()
            while not self.exit_event.is_set():
                if select.select([self.fileno], [], [], SEQUENCE_S if incomplete else IDLE_S)[0]:
                    data = self._read()
                    if not data:
                        on_hang_up()
                        return
                    self._acted = incomplete = data == ESCAPE
                    if self._acted:
                        on_key("escape")
                    for message in parser.feed(decode(data)):
                        self.process_message(message)
                else:
                    incomplete = False
                for message in parser.tick():
                    self.process_message(message)

        def _read(self) -> bytes:
            """What was typed; nothing when the terminal is gone."""
            with contextlib.suppress(OSError):
                return os.read(self.fileno, READ_BYTES)
            return b""

    return TerminalDriver


class _Lasting:
    """A file on a terminal; when the terminal is gone it leads nowhere, and nobody who writes to it has to know."""

    def __init__(self, file: IO[str]) -> None:
        self._file = file

    def write(self, text: str) -> int:
        try:
            return self._file.write(text)
        except OSError as error:
            self._tolerate(error)
            return len(text)

    def flush(self) -> None:
        try:
            self._file.flush()
        except OSError as error:
            self._tolerate(error)

    def fileno(self) -> int:
        return self._file.fileno()

    @staticmethod
    def _tolerate(error: OSError) -> None:
        if error.errno not in GONE:
            raise error
        nothing = os.open(os.devnull, os.O_WRONLY)
        for stream in (1, 2):  # both, so that the interpreter's last flush does not fail either
            os.dup2(nothing, stream)
        os.close(nothing)
