"""The live microphone, through PortAudio (sounddevice).

No device is touched, and sounddevice is not imported, before the source is opened: on Linux the mere import fails
where PortAudio is not installed. Every failure becomes a ``DeviceError`` that says what to do.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from types import TracebackType
from typing import Any

import numpy as np
import soxr
from numpy.typing import NDArray

from engine.audio.source import FRAME_S, RATE, Frame, FrameQueue, Framer, to_int16
from engine.errors import DeviceError

WAITING_FRAMES = 64
"""Frames (2 s) that may wait for a reader; older ones are lost and counted."""

SILENT_S = 3.0
"""A microphone that delivers nothing for this long is gone: ALSA does not always say so when one is unplugged."""

NO_MICROPHONE = "Without one you can type, or watch the demo: sayso --demo."


class Microphone:
    """A microphone by (part of) its name or by index; None is the system's default.

    Opened at 16 kHz where the device can, else at its own rate and resampled. Opening and reading raise
    ``DeviceError``.
    """

    live = True

    def __init__(self, device: str | int | None = None) -> None:
        self.name = "microphone"
        self._device = device
        self._queue = FrameQueue(WAITING_FRAMES)
        self._framer = Framer()
        self._resampler: Any = None
        self._stream: Any = None
        self._overruns = 0
        self._closing = threading.Event()

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sound lost by the device or by us."""
        found = []
        if self._overruns:
            found.append(f"{self.name}: the device lost sound {self._overruns} times.")
        if self._queue.dropped:
            found.append(f"{self.name}: {self._queue.dropped * FRAME_S:.1f} s of sound were not read in time.")
        return tuple(found)

    async def __aenter__(self) -> Microphone:
        await asyncio.to_thread(self._open)
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._closing.set()
        self._queue.close()
        if self._stream is not None:
            stream, self._stream = self._stream, None
            await asyncio.to_thread(stream.close)

    def __aiter__(self) -> Microphone:
        return self

    async def __anext__(self) -> Frame:
        try:
            async with asyncio.timeout(SILENT_S):
                return await self._queue.get()
        except TimeoutError as error:
            raise DeviceError(
                f"The {self.name} delivers no sound any more.", hint="Check that it is plugged in."
            ) from error

    def _open(self) -> None:
        sounddevice = _import_sounddevice()
        try:
            info = sounddevice.query_devices(self._device, "input")
        except ValueError as error:  # no such device, an ambiguous name, or one without inputs
            raise DeviceError(
                f"There is no microphone {self._device!r}: {str(error).splitlines()[0]}.", hint=_choices(sounddevice)
            ) from error
        except sounddevice.PortAudioError as error:
            which = "" if self._device is None else f" {self._device!r}"
            raise DeviceError(f"There is no microphone{which}.", hint=_choices(sounddevice)) from error
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

    def _start(self, sounddevice: Any, rate: int, channels: int) -> None:
        """Open the device with one set of parameters and let it run."""
        self._resampler = soxr.ResampleStream(rate, RATE, 1, dtype="float32") if rate != RATE else None
        stream = sounddevice.InputStream(
            device=self._device,
            samplerate=rate,
            channels=channels,
            dtype="float32",
            callback=self._arrived,
            finished_callback=self._finished,
        )
        try:
            stream.start()
        except sounddevice.PortAudioError:
            self._closing.set()  # the end of this try is not the end of the microphone
            with contextlib.suppress(sounddevice.PortAudioError):
                stream.close()
            self._closing.clear()
            raise
        self._stream = stream

    def _arrived(self, block: NDArray[np.float32], _count: int, _time: object, status: Any) -> None:
        """PortAudio's thread: take a block and return quickly."""
        if status.input_overflow:
            self._overruns += 1
        mono = block.mean(axis=1, dtype=np.float32)
        if self._resampler is not None:
            mono = self._resampler.resample_chunk(mono)
        for frame in self._framer.push(to_int16(mono)):
            self._queue.put(frame)

    def _finished(self) -> None:
        """PortAudio's thread: the stream ended, by us or because the device is gone."""
        if not self._closing.is_set():
            self._queue.end(DeviceError(f"The {self.name} is gone.", hint="Plug it in again, then wake the robot."))


def _import_sounddevice() -> Any:
    try:
        import sounddevice
    except OSError as error:
        raise DeviceError(
            "The microphone cannot be used: the PortAudio library is missing.",
            hint="Install it (Debian, Ubuntu: apt install libportaudio2). " + NO_MICROPHONE,
        ) from error
    except ImportError as error:
        raise DeviceError(
            "The microphone cannot be used: the Python package sounddevice is missing.",
            hint="Install it with pip. " + NO_MICROPHONE,
        ) from error
    return sounddevice


def _choices(sounddevice: Any) -> str:
    names = [
        f"{index}: {device['name']}"
        for index, device in enumerate(sounddevice.query_devices())
        if device["max_input_channels"] > 0
    ]
    return f"Set audio.device to one of: {'; '.join(names)}." if names else NO_MICROPHONE
