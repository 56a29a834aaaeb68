"""The thread that listens to a wake module: it opens the port, calls at once, and finds the module again.

Which module it is need not be known: frames of all kinds are looked for, and one of them is proof enough. Until then
nothing is written to any port, not even the handshake that one kind of module likes: what hangs on a port that nobody
has named may be a motor board, for which any bytes may be a command. Handshakes begin with us only where the settings
name that module; a module's own handshake is answered wherever it comes from, because by then it is known.

For the same reason ``auto`` and VID:PID may open several ports at first. The one from which the first wake comes is the
module's, and the others are let go. They are opened for nobody else meanwhile; name the port where that matters. When
the module is unplugged, what was there beside it is left alone; what comes then is listened to, and only one that is
known to be the module is greeted.
"""

from __future__ import annotations

import contextlib
import os
import selectors
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

from config.schema import SerialWake
from engine.commands import Wake
from engine.errors import DeviceError, SaysoError
from engine.framing import Framer
from engine.scheduling import raise_priority
from engine.serial_port import Port, PortError, Reason, at
from engine.wake.ai_voice import AiVoice
from engine.wake.csk4002 import Csk4002
from engine.wake.iflytek import IflytekRing
from engine.wake.module import Called, Frame, Module, Told
from engine.wake.ports import Known, Wanted, opened, wanted

READ_BYTES: Final = 4096
PAUSES_S: Final = (0.1, 0.2, 0.5, 1.0, 2.0)
"""Between two looks for a module that is not there, s; the last one again and again."""
QUIET_S: Final = 1.0
"""After a frame that wakes nobody was told of, others are only counted for so long, s."""
NOISE_BYTES: Final = 1024
"""So many bytes without a frame among them come from something that is no wake module."""

MODULES: Final[tuple[Module, ...]] = (AiVoice(), Csk4002(), IflytekRing(), AiVoice(bilingual=True))
GUESSED: Final[tuple[Module, ...]] = MODULES[:3]
"""Those that are known by their frames."""


@dataclass(frozen=True, slots=True)
class Listening:
    """Ports are open; ``detail`` says which, and what is on them as far as that is known."""

    detail: str


@dataclass(frozen=True, slots=True)
class Lost:
    """There is no module (any more). ``over``: a fault of ours is why, and the reader has ended by it."""

    error: SaysoError
    over: bool = False


@dataclass(frozen=True, slots=True)
class Remark:
    """Something for the log; ``odd``: something is wrong."""

    text: str
    odd: bool = False


News = Listening | Lost | Remark


@dataclass(slots=True)
class _Line:
    """An open port, and what is known about what hangs on it."""

    path: str
    port: Any  # serial.Serial
    is_at: Port
    framers: tuple[tuple[Module, Framer[Frame]], ...]
    module: Module | None  # None: no frame has come yet
    without_frame: int | None = 0  # bytes so far; None: there was one, or it has been said that there is none
    refused: bool = False  # it did not take what it was sent, and that has been said

    @property
    def fd(self) -> int:
        return int(self.port.fileno())

    def __str__(self) -> str:
        return self.path if self.module is None else f"{self.module.name} on {self.path}"


class WakeReader:
    """Listens until it is closed. ``wake`` and ``tell`` are called in its thread, ``wake`` before anything else is done
    with what came. ``prompt``: the thread goes before others, where the system allows it."""

    def __init__(
        self, settings: SerialWake, wake: Callable[[Wake], None], tell: Callable[[News], None], *, prompt: bool
    ) -> None:
        assert settings.port is not None, "else there is nothing to listen to"
        self._setting = settings.port
        self._named = next((module for module in MODULES if module.name == settings.protocol), None)
        self._phrase = settings.phrase
        self._wake = wake
        self._tell = tell
        self._prompt = prompt
        self._lines: dict[str, _Line] = {}
        self._settled = False  # it is known which port is the module's, and that one is open
        self._known: Known | None = None  # which one that is or was
        self._trouble: Reason | None = None  # what has been said about why there is no module
        self._suspected: Reason | None = None  # why the last look found none
        self._pauses = 0  # looks for a module that found none
        self._next_look = 0.0  # monotonic
        self._quiet_until = 0.0  # monotonic
        self._untold = 0  # frames since then
        self._selector = selectors.SelectSelector()  # kqueue takes no terminals
        self._stop_read, self._stop_write = -1, -1
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Begin; returns at once."""
        self._stop_read, self._stop_write = os.pipe()
        self._thread = threading.Thread(target=self._run, name="wake-module", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End, and let the ports go. Not in the reader's own thread."""
        if self._thread is not None:
            os.close(self._stop_write)
            self._thread.join()  # returns at once: closing the pipe wakes its select
            os.close(self._stop_read)
            self._thread = None

    # In the thread

    def _run(self) -> None:
        if self._prompt:
            raise_priority()
        self._selector.register(self._stop_read, selectors.EVENT_READ)
        try:
            while self._turn():
                pass
        except Exception as error:  # noqa: BLE001 - nobody listens to the module any more: that must be told
            fault = SaysoError(f"Listening to the wake module failed: {error!r}.", hint="Please report it.")
            self._tell(Lost(fault, over=True))
        finally:
            for line in tuple(self._lines.values()):
                self._close(line)
            self._selector.close()

    def _turn(self) -> bool:
        """Look for the module if need be, and take what comes; False when this is to end."""
        if not self._settled and time.monotonic() >= self._next_look:  # not for every packet: it goes through all ports
            self._look()
            self._next_look = time.monotonic() + PAUSES_S[min(self._pauses, len(PAUSES_S)) - 1]
        pause = None if self._settled else max(0.0, self._next_look - time.monotonic())
        for key, _ in self._selector.select(pause):
            if key.fd == self._stop_read:
                return False
            if key.data.path in self._lines:  # else another one has just been found to be the module
                self._take(key.data)
        return True

    def _look(self) -> None:
        """Open the ports that may be the module's and are not open yet."""
        self._pauses += 1
        news, error = False, None
        if self._known is not None:
            self._known = self._known.looked_for()
        try:
            found = wanted(self._setting, self._known)
        except PortError as absent:
            found, error = Wanted((), certain=False), absent
        for path in found.paths:
            if path not in self._lines:
                try:
                    self._open(path, greet=found.certain or self._known is None)
                    news = True
                except PortError as refused:
                    error = refused
        if found.certain and (line := self._lines.get(found.paths[0])) is not None:
            self._settle(line)
        if news:
            self._pauses = 1
            self._tell_lines()
        elif not self._lines and error is not None:
            self._tell_trouble(error)

    def _tell_trouble(self, error: PortError) -> None:
        """Say once why there is no module. A port that has just appeared may belong to nobody for a moment, so that
        after a loss the reason has to be the same twice."""
        if error.reason != self._trouble and (self._trouble is None or error.reason == self._suspected):
            self._trouble = error.reason
            self._tell(Lost(error))
        self._suspected = error.reason

    def _open(self, path: str, *, greet: bool) -> None:
        modules = GUESSED if self._named is None else (self._named,)
        line = _Line(path, opened(path), at(path), tuple((module, Framer(module)) for module in modules), self._named)
        self._lines[path] = line
        self._selector.register(line.fd, selectors.EVENT_READ, line)
        if self._named is not None and greet:
            self._send(line, self._named.greeting)

    def _close(self, line: _Line) -> None:
        del self._lines[line.path]
        self._selector.unregister(line.fd)
        with contextlib.suppress(OSError):  # it may have been unplugged
            line.port.close()

    def _lose(self, line: _Line) -> None:
        """A port is gone. Where it was one of several that might have been the module's, nothing is lost."""
        self._close(line)
        if self._lines:
            self._tell_lines()
            return
        if self._settled and self._known is not None:
            self._known = self._known.lost()
        news = self._settled or self._known is None  # else it has been missed for a while
        self._settled, self._pauses, self._next_look, self._trouble = False, 0, 0.0, "absent"
        if news:
            hint = "Plug it in again. sayso finds it by itself."
            self._tell(Lost(DeviceError(f"The wake module is gone: {line} was unplugged.", hint=hint)))

    def _take(self, line: _Line) -> None:
        """Act on what has come: first of all wake."""
        try:
            data = os.read(line.fd, READ_BYTES)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:  # an unplugged device has always nothing to read, or an error
            self._lose(line)
            return
        frames = [(module, frame) for module, framer in line.framers for frame in framer.push(data)]
        calls = [(module, frame) for module, frame in frames if isinstance(frame, Called)]
        if calls:
            newest = calls[-1][1]
            self._wake(Wake("serial", newest.phrase, newest.angle_deg))
        for _, frame in frames:
            self._send(line, frame.reply)
        if calls and self._phrase is not None:
            self._send(line, calls[-1][0].play(self._phrase) or b"")
        if frames:
            self._learn(line, frames, called=bool(calls))
        elif line.without_frame is not None and self._settled:
            self._wonder(line, len(data))

    def _learn(self, line: _Line, frames: Sequence[tuple[Module, Frame]], *, called: bool) -> None:
        """There is a module, and this is what it said."""
        module = frames[-1][0]
        news = module is not line.module or (called and not self._settled)
        line.module, line.without_frame = module, None
        if called:
            self._settle(line)
        if news:
            self._tell_lines()
        for _, frame in frames:
            if isinstance(frame, Told):
                self._mention(frame)

    def _settle(self, line: _Line) -> None:
        """This is the module's port: let the others go."""
        for other in tuple(self._lines.values()):
            if other is not line:
                self._close(other)
        self._settled, self._known = True, Known(line.is_at)

    def _wonder(self, line: _Line, count: int) -> None:
        """Bytes, and no frame among them."""
        assert line.without_frame is not None
        line.without_frame += count
        if line.without_frame > NOISE_BYTES:
            line.without_frame = None
            text = f"What comes from {line.path} are no frames of a wake module; is wake.serial.port the right one?"
            self._tell(Remark(text, odd=True))

    def _mention(self, frame: Told) -> None:
        """A frame that wakes nobody, for the log; a module that never stops talking gets one line a second."""
        now = time.monotonic()
        if now < self._quiet_until:
            self._untold += 1
            return
        more = f" ({self._untold} frames since the last line)" if self._untold else ""
        self._quiet_until, self._untold = now + QUIET_S, 0
        self._tell(Remark(f"the module said: {frame.what}{more}"))

    def _send(self, line: _Line, data: bytes) -> None:
        """Write without waiting: a port that takes nothing must not keep the next wake from being heard."""
        if not data:
            return
        written = 0
        with contextlib.suppress(OSError):  # that it is gone shows when it is read
            written = os.write(line.fd, data)
        if written < len(data) and not line.refused:
            line.refused = True
            self._tell(Remark(f"{line} does not take what it is sent.", odd=True))

    def _tell_lines(self) -> None:
        """Say what is listened to. After a loss that is the module that was lost, and nothing else is worth a word."""
        if self._settled or self._known is None:
            self._trouble = None
            self._tell(Listening(", ".join(map(str, self._lines.values()))))
