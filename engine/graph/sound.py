"""Sound that comes from a graph: 16 kHz mono, and whether somebody begins to speak in it."""

from __future__ import annotations

import base64
import binascii
from array import array
from typing import Any, Final, Literal

import numpy as np

from engine.audio.source import FRAME_S, RATE, Framer
from engine.audio.vad import VoiceActivity
from engine.errors import UsageError
from engine.ros.door import Message

Encoding = Literal["int16", "uint8"]
TYPES: Final[dict[Encoding, str]] = {
    "int16": "std_msgs/msg/Int16MultiArray",
    "uint8": "std_msgs/msg/UInt8MultiArray",
}
LONGEST_S: Final = 10.0
"""Of sound in one message, s; usual are 0.1."""
START_FRAMES: Final = 3
"""Frames of speech in a row (0.1 s) that are no click."""
END_FRAMES: Final = 16
"""Frames without speech (0.5 s) after which somebody begins anew."""

_MOST: Final = round(LONGEST_S * RATE)


def pcm_in(message: Message, encoding: Encoding) -> bytes:
    """The samples of a message as signed 16-bit little-endian. Raises ``UsageError``."""
    data = message.get("data")
    if encoding == "uint8":
        found = _bytes(data)
        if len(found) % 2:
            raise UsageError("It holds an odd number of bytes; samples have two.")
        return found
    return _integers(data, "<i2", -(1 << 15), (1 << 15) - 1, _MOST)


def _bytes(data: Any) -> bytes:
    if isinstance(data, str) and len(data) <= 3 * _MOST:  # rosbridge writes bytes so
        try:
            data = base64.b64decode(data, validate=True)
        except (binascii.Error, ValueError) as error:
            raise UsageError(f"Its data are not base64: {error}.") from error
    if isinstance(data, bytes | bytearray):
        if len(data) > 2 * _MOST:
            raise _too_long()
        return bytes(data)
    return _integers(data, "u1", 0, 255, 2 * _MOST)


def _integers(data: Any, type: str, low: int, high: int, most: int) -> bytes:
    if isinstance(data, array):
        data = np.asarray(data)
    if isinstance(data, np.ndarray):
        length, fits = data.size, data.ndim == 1 and data.dtype.kind in "iu"
    elif isinstance(data, list | tuple):
        length, fits = len(data), len(data) <= most and all(isinstance(value, int) for value in data)
    else:
        raise UsageError("Its data are no list of numbers.")
    if length > most:
        raise _too_long()
    if not fits or (length and (min(data) < low or max(data) > high)):
        raise UsageError(f"Its data are no list of whole numbers from {low} to {high}.")
    return np.asarray(data, dtype=np.int64).astype(type).tobytes()


def _too_long() -> UsageError:
    return UsageError(f"It holds more than {LONGEST_S:g} s of sound.")


class Onset:
    """Notices that somebody begins to speak. Not thread-safe; costs about a millisecond for 0.1 s of sound."""

    def __init__(self, vad: VoiceActivity) -> None:
        self._vad = vad
        self._framer = Framer()
        self._speech = 0  # frames in a row
        self._quiet = END_FRAMES

    def push(self, pcm: bytes) -> float | None:
        """Take the next sound; how long before its end somebody began to speak, s, or None."""
        began: float | None = None
        for frame in self._framer.push(np.frombuffer(pcm, dtype="<i2").astype(np.int16)):
            if began is not None:
                began += FRAME_S
            if self._vad.process(frame).speech:
                self._speech += 1
                if self._speech == START_FRAMES and self._quiet >= END_FRAMES:
                    began = START_FRAMES * FRAME_S
                if self._speech >= START_FRAMES:
                    self._quiet = 0
            else:
                self._speech = 0
                self._quiet += 1
        return began
