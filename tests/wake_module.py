"""A wake module for tests: its protocol on a pseudo-terminal, behind a path that stays when it is plugged in again."""

from __future__ import annotations

import os
import pty
import select
import time
import tty
from pathlib import Path
from types import TracebackType

from engine.wake import ai_voice, iflytek

AI_VOICE_WAKE = ai_voice.frame(*ai_voice.WAKE)
CSK4002_WAKE = b"$B000#"
LIMIT_S = 30.0


def ring_wake(angle: object = 137, number: int = 7) -> bytes:
    """The wake of the microphone ring: JSON within JSON."""
    info = b'{\\"ivw\\":{\\"angle\\":%s,\\"beam\\":3,\\"keyword\\":\\"hello\\"}}' % str(angle).encode()
    message = b'{"type":"aiui_event","content":{"eventType":4,"info":"%s"}}' % info
    return iflytek.frame(iflytek.MESSAGE, number, message)


class WakeModule:
    """The far end of a serial line. ``path`` is what a computer opens."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "ttyWake"
        self._master = self._slave = -1

    def __enter__(self) -> WakeModule:
        return self.plug()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.unplug()

    def plug(self) -> WakeModule:
        """Be there."""
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        self.path.symlink_to(os.ttyname(self._slave))
        return self

    def unplug(self) -> None:
        """Be gone, and the device with it."""
        if self._master >= 0:
            os.close(self._master)
            os.close(self._slave)
            self._master = self._slave = -1
            self.path.unlink()

    def say(self, *pieces: bytes) -> None:
        """Send bytes, each piece in a write of its own."""
        for piece in pieces:
            os.write(self._master, piece)

    def heard(self) -> bytes:
        """What the computer has sent so far and nobody has read."""
        heard = b""
        while select.select([self._master], [], [], 0)[0]:
            heard += os.read(self._master, 4096)
        return heard

    def hear(self, wanted: bytes) -> bytes:
        """What the computer sent, once ``wanted`` is in it."""
        heard, until = b"", time.monotonic() + LIMIT_S
        while wanted not in heard:
            if not select.select([self._master], [], [], max(0.0, until - time.monotonic()))[0]:
                raise AssertionError(f"waited for {wanted!r}, heard {heard!r}")
            heard += os.read(self._master, 4096)
        return heard
