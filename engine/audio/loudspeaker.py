"""The loudspeaker. A process of its own plays (``engine.audio.sounder``); this is the end that feeds it.

No device is touched, and sounddevice is not imported, in this process. Every failure becomes a ``DeviceError`` that
says what to do. A loudspeaker that is lost stays lost: whoever wants it back opens it again, which can wait for it.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import threading
from collections.abc import Callable
from typing import BinaryIO, Final

import msgspec

from engine.audio.player import BLOCK_S, Pull
from engine.audio.portaudio import Unusable
from engine.audio.sounder import REPORTS, SOUGHT, Block, Failed, Looking, Opened, Report, Run, Wanted
from engine.child import Child
from engine.errors import DeviceError, ProcessError, SaysoError
from engine.messages import LENGTH_BYTES, packed

ANSWER_S: Final = 10.0
"""A sounder that says nothing for so long when it is started hangs."""
STALLED_S: Final = 3.0
"""A loudspeaker that runs and takes no sound for so long hangs, s: no driver says so when its sound server is frozen.
One that was just started has twice as long: Bluetooth wakes up."""
_LOOKS: Final = 6  # within that time
_SOUNDER: Final = "engine.audio.sounder"
_EPITAPH_S: Final = 1.0  # from the end of the link to the end of the process


class Loudspeaker:
    """A loudspeaker by (part of) its name or by index; None is the system's default."""

    def __init__(self, device: str | int | None = None, *, stalled_s: float = STALLED_S) -> None:
        self.name = "loudspeaker"
        self.rate = 48_000
        self._device = msgspec.json.encode(device).decode()
        self._stalled_s = stalled_s
        self._child: Child | None = None
        self._reports: BinaryIO | None = None
        self._hush = -1  # the pipe's end where a byte silences it
        self._hushes = 0
        self._patient = False  # it is waited for
        self._pull: Pull | None = None
        self._lost: Callable[[SaysoError], None] = lambda error: None
        self._feeding: threading.Thread | None = None
        self._taken = 0  # blocks
        self._watching: asyncio.Task[None] | None = None

    @property
    def pid(self) -> int | None:
        """Of the sounder process, if there is one."""
        return self._child.pid if self._child is not None else None

    async def open(self, pull: Pull, lost: Callable[[SaysoError], None], *, patient: bool = False) -> None:
        self._pull, self._lost, self._patient = pull, lost, patient
        starting = asyncio.ensure_future(asyncio.to_thread(self._open))
        try:
            await asyncio.shield(starting)
        except asyncio.CancelledError:
            self._patient = False
            if self._child is not None:
                self._child.kill()
            with contextlib.suppress(DeviceError):
                await starting  # or nobody would end what it starts
            await self.close()
            raise

    async def start(self) -> None:
        self._send(packed(Run(True)))
        self._watching = asyncio.create_task(self._watch(), name="loudspeaker")

    async def stop(self) -> None:
        await self._look_away()
        self._send(packed(Run(False)))

    def hush(self) -> None:
        self._hushes += 1  # whoever stops the robot does so one after the other
        if self._hush >= 0:
            with contextlib.suppress(OSError):  # it has gone, and is silent
                os.write(self._hush, b"!")

    async def close(self) -> None:
        await self._look_away()
        await asyncio.to_thread(self._close)

    async def _watch(self) -> None:
        """While it runs it takes a block every 20 ms, whatever there is to play. Looks are counted, not time: a loop
        that was away has not looked."""
        taken, idle, patience = self._taken, 0, 2 * _LOOKS
        while idle < patience:
            await asyncio.sleep(self._stalled_s / _LOOKS)
            idle += 1
            if self._taken != taken:
                taken, idle, patience = self._taken, 0, _LOOKS
        self._lost(DeviceError(f"The {self.name} takes no sound.", hint=SOUGHT))

    async def _look_away(self) -> None:
        watching, self._watching = self._watching, None
        if watching is not None:
            watching.cancel()
            await asyncio.gather(watching, return_exceptions=True)

    def _open(self) -> None:
        try:
            theirs, ours = os.pipe()
        except OSError as error:
            raise DeviceError(f"The loudspeaker process cannot be started: {error}.") from error
        self._hushes = 0
        try:
            arguments = (f"--device={self._device}", f"--hush={theirs}", *(("--patient",) if self._patient else ()))
            self._child = child = Child("loudspeaker", _SOUNDER, arguments, shared=(theirs,))
            self._hush = ours
            os.set_blocking(ours, False)
        except ProcessError as error:
            os.close(ours)
            raise DeviceError(error.message) from error
        finally:
            os.close(theirs)
        self._reports = child.link.makefile("rb")
        child.link.settimeout(ANSWER_S)
        try:
            while isinstance(report := self._report(), Looking) and self._patient:
                pass
        except OSError as error:  # TimeoutError is one of them
            self._close()
            raise DeviceError("The loudspeaker hangs.", hint=SOUGHT) from error
        if not isinstance(report, Opened):
            why = _failure(report) if isinstance(report, Failed) else self._loss()
            self._close()
            raise why
        child.link.settimeout(None)
        self.name, self.rate = report.name, report.rate
        self._feeding = threading.Thread(target=self._feed, args=(child,), name="loudspeaker", daemon=True)
        self._feeding.start()

    def _feed(self, child: Child) -> None:
        """Give the process what it wants, until one of us ends."""
        assert self._pull is not None
        count = round(BLOCK_S * self.rate)
        try:
            while report := self._report():
                match report:
                    case Wanted(at):
                        self._taken += 1
                        hushes = self._hushes  # before the look at what there is to play
                        block = packed(Block(hushes, self._pull(count, at).tobytes()))
                        with contextlib.suppress(OSError):  # it has gone, and what it said before is still to be read
                            child.link.sendall(block)
                    case Failed() as failed:
                        self._lost(_failure(failed))
                        return
        except (OSError, ValueError):  # its end; ours closes the file as well
            pass
        if self._child is child:
            self._lost(self._loss())

    def _report(self) -> Report | None:
        """What it says next; None at its end. Raises ``OSError``."""
        assert self._reports is not None
        length = self._reports.read(LENGTH_BYTES)
        data = self._reports.read(int.from_bytes(length, "little")) if length else b""
        return REPORTS.decode(data) if data else None

    def _send(self, data: bytes) -> None:
        if self._child is not None:
            with contextlib.suppress(OSError):  # it has gone, and whoever feeds it says so
                self._child.link.sendall(data)

    def _loss(self) -> DeviceError:
        child = self._child
        why = child.epitaph(wait=_EPITAPH_S) if child is not None else None
        return DeviceError(why or "The loudspeaker process closed its connection.", hint=SOUGHT)

    def _close(self) -> None:
        child, self._child = self._child, None
        if child is None:
            return
        hush, self._hush = self._hush, -1
        child.kill()
        if self._feeding is not None:
            self._feeding.join()
            self._feeding = None
        if self._reports is not None:
            self._reports.close()
        os.close(hush)
        child.release()


def _failure(failed: Failed) -> DeviceError:
    kind = Unusable if failed.for_good else DeviceError
    return kind(failed.message, hint=failed.hint)
