"""The recorder process: ``python -m engine.audio.recorder``, started by :class:`engine.audio.microphone.Microphone`.

The microphone has a process of its own: here it can be looked for again and again without silencing anybody who plays
(``engine.audio.portaudio``), a driver that hangs or writes to stderr harms nobody, and no busy interpreter makes the
device lose sound. The process says what happens in messages with their length before them, and ends when the microphone
is lost or the engine goes.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
import os
import queue
import signal
import socket
import sys
from typing import Any

import msgspec
import numpy as np
import soxr
from numpy.typing import NDArray

from engine.audio import portaudio
from engine.audio.portaudio import Unusable
from engine.audio.source import FRAME_S, RATE, Samples, to_int16
from engine.errors import DeviceError
from engine.messages import packed

SILENT_S = 3.0
"""A microphone that delivers nothing for this long is gone: ALSA does not always say so when one is unplugged."""

FIRST_S = 6.0
"""One that has just been opened may take longer: Bluetooth wakes up, and some sound servers fill a buffer first."""

WAITING_BLOCKS = 64
"""Blocks (2 s) that may wait for an engine that does not read; older ones are lost and counted."""

NO_MICROPHONE = "Without one you can type, or watch the demo: sayso --demo."


class Opened(msgspec.Struct, frozen=True, tag=True):
    """The microphone runs and sounds."""

    name: str


class Looking(msgspec.Struct, frozen=True, tag=True):
    """It is not there yet; it will be looked for again."""


class Sound(msgspec.Struct, frozen=True, tag=True):
    """Some sound: 16 kHz mono signed 16-bit in this machine's byte order."""

    pcm: bytes
    overruns: int  # how often the device has lost sound so far
    unread: int  # blocks so far that the engine did not read in time


class Failed(msgspec.Struct, frozen=True, tag=True):
    """A ``DeviceError``, by its parts; the process ends after it. ``for_good``: looking again would not help."""

    message: str
    hint: str
    for_good: bool


Message = Opened | Looking | Sound | Failed
MESSAGES: msgspec.msgpack.Decoder[Message] = msgspec.msgpack.Decoder(Message)


class Recorder:
    """A microphone by (part of) its name or by index, through PortAudio; None is the system's default.

    Opened at 16 kHz where the device can, else at its own rate and resampled. Belongs to one thread, but for the two
    that PortAudio calls.
    """

    def __init__(self, device: str | int | None) -> None:
        self.name = "microphone"
        self.overruns = 0
        self.unread = 0
        self._device = device
        self._resampler: Any = None
        self._stream: Any = None
        self._starting = False
        self._blocks: queue.Queue[Samples | DeviceError] = queue.Queue(WAITING_BLOCKS)

    def open(self) -> None:
        """Open the device and let it run. Raises ``DeviceError``; :class:`Unusable` when trying again is in vain."""
        sounddevice = portaudio.load(
            Unusable(
                "The microphone cannot be used: the PortAudio library is missing.",
                hint="Install it (Debian, Ubuntu: apt install libportaudio2). " + NO_MICROPHONE,
            ),
            Unusable(
                "The microphone cannot be used: the Python package sounddevice is missing.",
                hint="Install it with pip. " + NO_MICROPHONE,
            ),
        )
        try:
            info = sounddevice.query_devices(self._device, "input")
        except ValueError as error:  # no such device, an ambiguous name, or one without inputs
            raise DeviceError(
                f"There is no microphone {self._device!r}: {str(error).splitlines()[0]}.", hint=_others(sounddevice)
            ) from error
        except sounddevice.PortAudioError as error:
            which = "" if self._device is None else f" {self._device!r}"
            raise DeviceError(f"There is no microphone{which}.", hint=_others(sounddevice)) from error
        self.name = f"microphone ({info['name']})"
        native, channels = round(info["default_samplerate"]), int(info["max_input_channels"])
        failure: Exception | None = None
        for rate, width in dict.fromkeys(((RATE, 1), (native, 1), (native, channels))):
            try:
                self._start(sounddevice, rate, width)
            except sounddevice.PortAudioError as error:
                failure = error
            else:
                return
        raise DeviceError(
            f"The {self.name} cannot be opened: {failure}", hint="Another program may be using it."
        ) from failure

    def read(self, limit_s: float = SILENT_S) -> Samples:
        """The next block of sound. Raises ``DeviceError`` when the microphone is lost, or says nothing for so long."""
        try:
            block = self._blocks.get(timeout=limit_s)
        except queue.Empty:
            raise DeviceError(
                f"The {self.name} delivers no sound.", hint="Check that it is plugged in. sayso keeps looking for it."
            ) from None
        if isinstance(block, DeviceError):
            raise block
        return block

    def _start(self, sounddevice: Any, rate: int, channels: int) -> None:
        """Open the device with one set of parameters and let it run."""
        self._resampler = soxr.ResampleStream(rate, RATE, 1, dtype="float32") if rate != RATE else None
        self._starting = True  # the end of a try is not the end of the microphone
        stream = sounddevice.InputStream(
            device=self._device,
            samplerate=rate,
            blocksize=round(rate * FRAME_S),  # smaller ones would only wait for the rest of their frame
            channels=channels,
            dtype="float32",
            callback=self._arrived,
            finished_callback=self._finished,
        )
        try:
            stream.start()
        except sounddevice.PortAudioError:
            with contextlib.suppress(sounddevice.PortAudioError):
                stream.close()
            raise
        self._starting = False
        self._stream = stream

    def _arrived(self, block: NDArray[np.float32], _count: int, _time: object, status: Any) -> None:
        """PortAudio's thread: take a block and return quickly."""
        if status.input_overflow:
            self.overruns += 1
        mono = block.mean(axis=1, dtype=np.float32)
        if self._resampler is not None:
            mono = self._resampler.resample_chunk(mono)
        self._put(to_int16(mono))

    def _finished(self) -> None:
        """PortAudio's thread: the stream ended, by us or because the device is gone."""
        if not self._starting:
            self._put(DeviceError(f"The {self.name} is gone.", hint="Plug it in again. sayso keeps looking for it."))

    def _put(self, block: Samples | DeviceError) -> None:
        if self._blocks.full():
            with contextlib.suppress(queue.Empty):
                self._blocks.get_nowait()
                self.unread += 1
        self._blocks.put_nowait(block)


def record(link: socket.socket, device: str | int | None, *, patient: bool) -> Failed:
    """Open the microphone and send what it hears until it is lost; what to say last. ``patient``: wait for one that is
    not there. Raises ``OSError`` when the engine has gone."""
    for look in itertools.count(1):
        recorder = Recorder(device)
        try:
            recorder.open()
            block = recorder.read(FIRST_S)  # a device that only pretends to run is not there
            break
        except DeviceError as error:
            if not patient or isinstance(error, Unusable):
                return _failed(error)
        send(link, Looking())
        portaudio.look_again(look)
    send(link, Opened(recorder.name))
    while True:
        send(link, Sound(block.tobytes(), recorder.overruns, recorder.unread))
        try:
            block = recorder.read()
        except DeviceError as error:
            return _failed(error)


def send(link: socket.socket, message: Message) -> None:
    """Send one message. Raises ``OSError`` when the engine has gone."""
    link.sendall(packed(message))


def _failed(error: DeviceError) -> Failed:
    return Failed(error.message, error.hint, isinstance(error, Unusable))


def _others(sounddevice: Any) -> str:
    return portaudio.choices(sounddevice, "input", "audio.device") or NO_MICROPHONE


def main(argv: list[str]) -> int:
    """Record until the microphone or the engine is gone."""
    parser = argparse.ArgumentParser(prog="python -m engine.audio.recorder", description="Internal to sayso.")
    parser.add_argument("--link", type=int, required=True, help="an inherited file descriptor")
    parser.add_argument("--device", default="null", help="a name, an index or null, JSON")
    parser.add_argument("--patient", action="store_true", help="wait for a microphone that is not there")
    args = parser.parse_args(argv)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the engine's business
    link = socket.socket(fileno=args.link)
    portaudio.leave_with(link)
    device = msgspec.json.decode(args.device, type=str | int | None)
    with contextlib.suppress(OSError):  # the engine has gone
        send(link, record(link, device, patient=args.patient))
    link.close()
    os._exit(0)  # closing a stream whose driver has gone can hang; the kernel closes it as well


if __name__ == "__main__":
    main(sys.argv[1:])
