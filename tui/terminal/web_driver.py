"""The driver of a console whose terminal is a tab of a browser (:mod:`tui.web.tab` is the other end of its pipes).

It keeps what :mod:`tui.terminal.driver` promises. A key is shown to a callback in the thread that reads, before it is
queued; a packet of the escape byte alone is that key, as a browser sends a sequence in one piece. A tab reports when it
has drawn a frame, as terminals do. A tab that is closed, and a server that is gone, are a terminal that is gone.
"""

from __future__ import annotations

import asyncio
import codecs
import errno
import os
import select
import signal
import sys
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

from textual.driver import Driver
from textual.drivers._byte_stream import ByteStream

from tui.terminal.keyboard import IDLE_S, READ_BYTES, SEQUENCE_S, LoneEscape

if TYPE_CHECKING:
    from textual._xterm_parser import XTermParser

GONE: Final = (errno.EPIPE, errno.ECONNRESET)
"""What writing to a server that is gone fails with."""


def tab_driver(
    base: type[Driver],
    parser_class: type[XTermParser],
    on_key: Callable[[str], None],
    on_hang_up: Callable[[], None],
    on_report: Callable[[], object],
) -> type[Driver]:
    """A driver like ``base``, which is Textual's for browsers and shows keys to ``on_key``; the rest is as in
    :func:`tui.terminal.driver.listening_driver`. ``parser_class`` tells its attribute ``on_report`` of reports."""

    class TabDriver(base):  # type: ignore[valid-type,misc]
        lone_escape: Callable[[], LoneEscape]
        reader: int | None = None
        """The thread that reads, as the system knows it."""

        def __init__(self, *args: Any, **kwargs: Any) -> None:
            super().__init__(*args, **kwargs)
            self.written = 0  # bytes that the server has taken
            self.fileno: int = os.dup(self.fileno)
            os.dup2(2, 1)  # what a library prints would be taken for a packet
            self._write = self._send

        def start_application_mode(self) -> None:
            """As Textual's, which would only leave when told to end: the robot is to stop first."""
            super().start_application_mode()
            loop = asyncio.get_running_loop()
            loop.remove_signal_handler(signal.SIGTERM)  # the console has its own
            loop.add_signal_handler(signal.SIGINT, on_hang_up)

        def _send(self, packet: bytes) -> None:
            """All of it; nothing where nobody is left to take it."""
            rest = memoryview(packet)
            try:
                while rest:
                    rest = rest[os.write(self.fileno, rest) :]
            except OSError as error:
                if error.errno not in GONE:
                    raise
            self.written += len(packet)

        def run_input_thread(self) -> None:
            """As Textual's, but for the escape key, the reports, and the end of the tab."""
            parser = parser_class(self._debug)
            parser.on_report = on_report  # type: ignore[attr-defined]
            packets = ByteStream()
            decode = codecs.getincrementaldecoder("utf-8")(errors="replace").decode
            assert sys.__stdin__ is not None
            source = sys.__stdin__.fileno()
            self.reader = threading.get_native_id()
            escape = self.lone_escape()
            while not self.exit_event.is_set():
                data = b""
                if select.select([source], [], [], SEQUENCE_S if escape.held else IDLE_S)[0]:
                    data = os.read(source, READ_BYTES)
                    if not data:
                        on_hang_up()
                        return
                else:
                    escape.overdue()
                for kind, payload in packets.feed(data) if data else ():
                    if kind != "D":
                        self._on_meta(kind, payload)
                        continue
                    typed = escape.taken(decode(payload))
                    for message in parser.feed(typed) if typed else ():
                        self.process_message(message)
                for message in parser.tick():
                    self.process_message(message)

        def on_meta(self, packet_type: str, payload: dict[str, object]) -> None:
            """As Textual's, which would queue the end behind what the interface has to do."""
            if packet_type == "quit":
                on_hang_up()
            else:
                super().on_meta(packet_type, payload)

    return TabDriver
