"""The sounder process: ``python -m engine.audio.sounder``, started by :class:`engine.audio.loudspeaker.Loudspeaker`.

PortAudio looks for devices once in a process (``engine.audio.portaudio``), its drivers write to stderr as they please
and can hang, and whoever feeds a device must never be late. So the loudspeaker has a process of its own. It asks the
engine for one block after the other, two ahead of what it hands to the device; a byte on a pipe, which no queue delays,
drops these two.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
import os
import signal
import socket
import sys
import threading
import time
from collections import deque
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from engine.audio import portaudio
from engine.audio.player import BLOCK_S, FADE_S
from engine.audio.portaudio import Unusable
from engine.audio.source import Samples
from engine.errors import DeviceError
from engine.messages import LENGTH_BYTES, packed

AHEAD: Final = 2
"""Blocks that wait here, so that an engine with a busy interpreter is in time."""
SHOWN: Final = "Answers are shown without one."
SOUGHT: Final = "Answers are shown until it is back; it is looked for."
_RATES: Final = (48_000, 44_100, 16_000)  # tried after the device's own
_LATEST_S: Final = 1.0  # a device that claims to sound later than that lies


class Opened(msgspec.Struct, frozen=True, tag=True):
    """The device is there, and rests."""

    name: str
    rate: int  # Hz


class Looking(msgspec.Struct, frozen=True, tag=True):
    """It is not there yet; it will be looked for again."""


class Wanted(msgspec.Struct, frozen=True, tag=True):
    """Another block. ``at``: when it will begin to sound (``time.monotonic``, which processes share)."""

    at: float


class Failed(msgspec.Struct, frozen=True, tag=True):
    """A ``DeviceError``, by its parts; the process ends after it. ``for_good``: looking again would not help."""

    message: str
    hint: str
    for_good: bool = False


class Block(msgspec.Struct, frozen=True, tag=True):
    """What was wanted. It is dropped when more than ``hushes`` bytes have come through the pipe."""

    hushes: int
    pcm: bytes  # mono signed 16-bit of this machine


class Run(msgspec.Struct, frozen=True, tag=True):
    """Sound, or rest."""

    on: bool


Report = Opened | Looking | Wanted | Failed
Order = Block | Run
REPORTS: msgspec.msgpack.Decoder[Report] = msgspec.msgpack.Decoder(Report)
ORDERS: msgspec.msgpack.Decoder[Order] = msgspec.msgpack.Decoder(Order)


class Sounder:
    """A loudspeaker by (part of) its name or by index, through PortAudio; None is the system's default."""

    def __init__(self, link: socket.socket, device: str | int | None) -> None:
        self.name = "loudspeaker"
        self.rate = 0
        self._link = link
        self._device = device
        self._stream: Any = None
        self._running = False
        self._blocks: deque[Samples] = deque()
        self._wanted = 0  # blocks that were asked for and have not come
        self._hushes = 0
        self._changing = threading.Lock()

    def open(self) -> None:
        """Find the device. Raises ``DeviceError``; :class:`Unusable` when trying again is in vain."""
        sounddevice = portaudio.load(
            Unusable(
                "There is no loudspeaker: the PortAudio library is missing.",
                hint="Install it (Debian, Ubuntu: apt install libportaudio2). " + SHOWN,
            ),
            Unusable(
                "There is no loudspeaker: the Python package sounddevice is missing.",
                hint="Install it with pip. " + SHOWN,
            ),
        )
        try:
            info = sounddevice.query_devices(self._device, "output")
        except (ValueError, sounddevice.PortAudioError) as error:  # none, an ambiguous name, or one without outputs
            which = "" if self._device is None else f" {self._device!r}"
            raise DeviceError(f"There is no loudspeaker{which}.", hint=_others(sounddevice)) from error
        self.name = f"loudspeaker ({info['name']})"
        most = int(info["max_output_channels"])
        rates = (round(info["default_samplerate"]), *_RATES)
        failure: Exception | None = None
        for rate, channels in dict.fromkeys((rate, width) for rate in rates for width in (1, min(2, most), most)):
            try:
                self._stream = sounddevice.OutputStream(
                    device=self._device,
                    samplerate=rate,
                    channels=channels,
                    dtype="int16",
                    blocksize=round(rate * BLOCK_S),
                    latency="low",
                    callback=self._fill,
                    finished_callback=self._finished,
                )
            except sounddevice.PortAudioError as error:
                failure = error
            else:
                self.rate = rate
                return
        raise DeviceError(
            f"The {self.name} cannot be opened: {failure}", hint="Another program may be using it."
        ) from failure

    def run(self, on: bool) -> None:
        """Sound, or rest."""
        if on == self._running:
            return
        self._running = on
        with self._changing:
            self._blocks.clear()
            self._wanted = 0
        if on:
            for _ in range(AHEAD):
                self._want(time.monotonic() + float(self._stream.latency))
        try:
            self._stream.start() if on else self._stream.stop()
        except Exception as error:  # noqa: BLE001 - sounddevice's own kind, which only open() imports
            self.fail(f"The {self.name} cannot be used: {error}.")

    def take(self, block: Block) -> None:
        """A block has come."""
        with self._changing:
            self._wanted = max(0, self._wanted - 1)
            if block.hushes >= self._hushes and self._running:
                self._blocks.append(np.frombuffer(block.pcm, np.int16))

    def hush(self) -> None:
        """Drop what waits, but for a fading moment of it."""
        with self._changing:
            self._hushes += 1
            first = self._blocks[0].astype(np.float32) if self._blocks else None
            self._blocks.clear()
            if first is not None:
                fade = min(len(first), round(FADE_S * self.rate))
                first[:fade] *= np.linspace(1, 0, fade, dtype=np.float32)
                first[fade:] = 0
                self._blocks.append(first.astype(np.int16))

    def fail(self, message: str) -> None:
        with contextlib.suppress(OSError):
            self._link.sendall(packed(Failed(message, SOUGHT)))
        os._exit(0)  # closing a stream whose driver has gone can hang; the kernel closes it as well

    def _fill(self, out: NDArray[np.int16], count: int, when: Any, status: object) -> None:
        """PortAudio's thread: give it the next block, and ask for another."""
        del status
        late = when.outputBufferDacTime - when.currentTime
        if not 0 < late < _LATEST_S:
            late = float(self._stream.latency)
        with self._changing:
            block = self._blocks.popleft() if self._blocks else None
            waiting = len(self._blocks) + self._wanted
        out[:] = 0 if block is None else block[:count, None]
        for ahead in range(waiting, AHEAD):
            self._want(time.monotonic() + late + (ahead + 1) * BLOCK_S)

    def _want(self, at: float) -> None:
        with self._changing:
            self._wanted += 1
        with contextlib.suppress(OSError):  # the engine has gone, which the main thread notices, too
            self._link.sendall(packed(Wanted(at)))

    def _finished(self) -> None:
        """PortAudio's thread: the stream ended, by us or because the device is gone."""
        if self._running:
            self.fail(f"The {self.name} is gone.")


def _others(sounddevice: Any) -> str:
    return portaudio.choices(sounddevice, "output", "voice.device") or SHOWN


def opened(link: socket.socket, device: str | int | None, *, patient: bool) -> Sounder | Failed:
    """A sounder that has found its device. ``patient``: wait for one that is not there. Raises ``OSError`` when the
    engine has gone."""
    for look in itertools.count(1):
        sounder = Sounder(link, device)
        try:
            sounder.open()
            return sounder
        except DeviceError as error:
            if not patient or isinstance(error, Unusable):
                return Failed(error.message, error.hint, isinstance(error, Unusable))
        link.sendall(packed(Looking()))
        portaudio.look_again(look)
    raise AssertionError("it looks for ever")


def _listen(pipe: int, sounder: Sounder) -> None:
    while (hushes := os.read(pipe, 4096)) and hushes:
        for _ in hushes:
            sounder.hush()


def main(argv: list[str]) -> int:
    """Sound until the device or the engine is gone."""
    parser = argparse.ArgumentParser(prog="python -m engine.audio.sounder", description="Internal to sayso.")
    parser.add_argument("--link", type=int, required=True, help="an inherited file descriptor")
    parser.add_argument("--hush", type=int, required=True, help="another one")
    parser.add_argument("--device", default="null", help="a name, an index or null, JSON")
    parser.add_argument("--patient", action="store_true", help="wait for a loudspeaker that is not there")
    args = parser.parse_args(argv)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the engine's business
    link = socket.socket(fileno=args.link)
    portaudio.leave_with(link)
    device = msgspec.json.decode(args.device, type=str | int | None)
    with contextlib.suppress(OSError):  # the engine has gone
        sounder = opened(link, device, patient=args.patient)
        if isinstance(sounder, Failed):
            link.sendall(packed(sounder))
            os._exit(0)
        threading.Thread(target=_listen, args=(args.hush, sounder), daemon=True).start()
        link.sendall(packed(Opened(sounder.name, sounder.rate)))
        orders = link.makefile("rb")
        while length := orders.read(LENGTH_BYTES):
            match ORDERS.decode(orders.read(int.from_bytes(length, "little"))):
                case Block() as block:
                    sounder.take(block)
                case Run(on):
                    sounder.run(on)
    os._exit(0)  # as in Sounder.fail


if __name__ == "__main__":
    main(sys.argv[1:])
