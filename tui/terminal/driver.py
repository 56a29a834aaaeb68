"""A terminal driver that lets a key act the moment it arrives, and that outlives its terminal.

Textual's drivers read the keyboard in a thread of its own and queue each key for the user interface. When the link to
the terminal stalls, the interface waits for it, and so would a key in its queue. Stopping a robot cannot wait: this
driver shows each key to a callback in the reading thread, before it is queued.

The escape key is the byte that also begins every escape sequence, so a parser has to wait for what follows (25 ms and
more). This driver does not: a read of that byte alone is the key. Over a link that tears a sequence apart, an arrow
key may stop the robot, which is the right side to err on. A letter right behind it is a letter (:class:`LoneEscape`).

A terminal that is gone reads as an end of file or an error. Then a second callback is called, once, and whatever is
still written goes nowhere.

What a terminal reports when it is asked how it is (:data:`tui.terminal.link.ASK`) looks like keys to the parser. It is
told to a third callback instead, at the moment it comes, and what it answers to other questions to a fourth. Before the
terminal is given back, reports and answers that are still to come are waited for a moment: whoever reads the terminal
next would take them for typed, too.
"""

from __future__ import annotations

import codecs
import contextlib
import errno
import os
import select
import threading
from collections.abc import Callable, Iterable, Iterator
from typing import IO, Any, Final, Protocol, runtime_checkable

from textual import _time, events
from textual.driver import Driver
from textual.keys import Keys
from textual.message import Message

from tui.graphics.answers import KEY_S, Answers
from tui.terminal.bursts import Bursts
from tui.terminal.keyboard import ESCAPE, IDLE_S, READ_BYTES, SEQUENCE_S, LoneEscape
from tui.terminal.link import ASK, REPORT

GONE: Final = (errno.EIO, errno.EPIPE, errno.ENXIO)
"""What writing to a terminal that is gone fails with."""
LAST_REPORT_S: Final = 0.5
"""How long to wait for reports before the terminal is given back."""


@runtime_checkable
class AnsweringDriver(Protocol):
    """One whose terminal can be asked what it can do."""

    farewell: str
    """What is written before the terminal is given back."""

    def ask(self, question: str) -> None:
        """Ask the terminal something, with its device attributes behind (see ``tui.graphics.answers``)."""

    def write(self, data: str) -> None:
        """Write to the terminal."""


def listening_driver(
    base: type[Driver],
    on_key: Callable[[str], None],
    on_hang_up: Callable[[], None] = lambda: None,
    on_report: Callable[[], object] = lambda: None,
    on_answer: Callable[[str], object] = lambda answer: None,
    passing: Callable[[str], str] = lambda data: data,
) -> type[Driver]:
    """A driver like ``base`` that calls ``on_key`` with the name of each key, ``on_hang_up`` when the terminal is gone,
    ``on_report`` when the terminal reports that it is well, and ``on_answer`` with what it answers to questions, all in
    the reading thread. Of what is to be written, ``passing`` says what is."""

    class ListeningDriver(base):  # type: ignore[valid-type,misc]
        def process_message(self, message: Message) -> None:
            if isinstance(message, events.Key):
                on_key(message.key)
            super().process_message(message)

        def lone_escape(self) -> LoneEscape:
            """To take the escape key out of what is read."""
            queue = super().process_message  # it has acted already
            return LoneEscape(lambda: on_key("escape"), lambda: queue(events.Key("escape", "\x1b")))

    from textual._xterm_parser import XTermParser

    class ReportParser(XTermParser):
        on_report: Callable[[], object]

        def _sequence_to_key_events(self, sequence: str, alt: bool = False) -> Iterable[events.Key]:
            """As Textual's, which would take the pieces of a report for keys that were typed."""
            if sequence not in REPORT:
                return super()._sequence_to_key_events(sequence, alt)
            self.on_report()
            return (events.Key(Keys.Ignore, sequence),)

    if base.__module__ == "textual.drivers.web_driver":  # its modules are not for a terminal to load
        from tui.terminal.web_driver import tab_driver

        return tab_driver(ListeningDriver, ReportParser, on_key, on_hang_up, on_report)
    try:
        from textual.drivers.linux_driver import LinuxDriver
    except ImportError:  # no POSIX terminal here
        return ListeningDriver
    if not issubclass(base, LinuxDriver):
        return ListeningDriver

    class TerminalDriver(ListeningDriver):
        _file: Any
        reader: int | None = None
        """The thread that reads, as the system knows it."""

        def __init__(self, *args: Any, **kwargs: Any) -> None:
            super().__init__(*args, **kwargs)
            self._file = _Lasting(self._file)
            self.farewell = ""
            self._answers = Answers(on_answer)
            self._awaited = 0  # reports that are still to come
            self._reports = False  # one has come
            self._all_came = threading.Condition()

        @property
        def writer(self) -> int | None:
            """The thread that writes, as the system knows it."""
            return self._writer_thread.native_id if self._writer_thread is not None else None

        @property
        def written(self) -> int:
            """How many bytes the terminal has taken."""
            return int(self._file.written)

        def write(self, data: str) -> None:
            if data == ASK:
                with self._all_came:
                    self._awaited += 1
            super().write(passing(data))

        def ask(self, question: str) -> None:
            self._answers.expect()
            self.write(question)

        def _report(self) -> None:
            with self._all_came:
                self._awaited, self._reports = max(0, self._awaited - 1), True
                self._all_came.notify_all()
            on_report()

        def stop_application_mode(self) -> None:
            """As Textual's, when all is quiet."""
            if self.farewell:
                self.write(self.farewell)
            if self._reports:
                with self._all_came:
                    self._all_came.wait_for(lambda: not self._awaited, LAST_REPORT_S)
            super().stop_application_mode()

        def run_input_thread(self) -> None:
            """As Textual's, but for the escape key and the end of the terminal."""
            parser = ReportParser(self._debug)
            parser.on_report = self._report
            decode = codecs.getincrementaldecoder("utf-8")(errors="replace").decode
            escape, bursts = self.lone_escape(), Bursts()
            incomplete, read_at = False, 0.0
            self.reader = threading.get_native_id()
            while not self.exit_event.is_set():
                waits = incomplete or escape.held or bursts.held
                pause = KEY_S if self._answers.held else SEQUENCE_S if waits else IDLE_S
                if select.select([self.fileno], [], [], pause)[0]:
                    data = self._read()
                    if not data:
                        self._reports = False  # none will come
                        on_hang_up()
                        return
                    incomplete = data.endswith(ESCAPE)
                    if data.startswith(ESCAPE):
                        self._process(bursts.overdue())
                    read_at = _time.get_time()
                    typed = self._answers.taken(escape.taken(decode(data)))
                else:
                    self._process(bursts.overdue())
                    escape.overdue()
                    typed = self._answers.overdue()
                    incomplete = bool(typed)
                parsed: Iterable[Message] = parser.feed(typed) if typed else ()
                if escape.held:  # which has acted, although the keys before it are parsed only now
                    parsed = _read(parsed, read_at)
                self._process(bursts.taken(parsed))
                self._process(bursts.taken(parser.tick()))

        def _process(self, messages: Iterable[Message]) -> None:
            for message in messages:
                self.process_message(message)

        def _read(self) -> bytes:
            """What was typed; nothing when the terminal is gone."""
            with contextlib.suppress(OSError):
                return os.read(self.fileno, READ_BYTES)
            return b""

    return TerminalDriver


def _read(messages: Iterable[Message], at: float) -> Iterator[Message]:
    """These were read at this time."""
    for message in messages:
        message.time = at
        yield message


class _Lasting:
    """A file on a terminal; when the terminal is gone it leads nowhere, and nobody who writes to it has to know."""

    def __init__(self, file: IO[str]) -> None:
        self._file = file
        self._buffered = 0
        self.written = 0  # bytes

    def write(self, text: str) -> int:
        try:
            self._buffered += len(text.encode())
            return self._file.write(text)
        except OSError as error:
            self._tolerate(error)
            return len(text)

    def flush(self) -> None:
        try:
            self._file.flush()
            self.written, self._buffered = self.written + self._buffered, 0
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
