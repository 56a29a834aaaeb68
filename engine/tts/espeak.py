"""eSpeak NG (https://github.com/espeak-ng/espeak-ng): a small voice for more than a hundred languages.

It is part of most systems' packages (``apt install espeak-ng``) and under the GPL, so its library is only ever loaded
by the voice process (``engine.tts.worker``), never by the engine. It says of each word when it begins.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import functools
from bisect import bisect_right
from collections.abc import Callable, Iterator
from typing import Any, Final

import numpy as np

from engine.errors import ModelError
from engine.tts.sentences import Sentence
from engine.tts.synthesis import Piece, Said, Samples

INSTALL: Final = "Install it (Debian, Ubuntu: apt install espeak-ng; macOS: brew install espeak-ng)."
ENGLISH: Final = "en-us"
CHINESE: Final = "cmn"
PACE: Final = 165
"""Words a minute at speed 1; its own default of 175 is a little fast."""

# speak_lib.h of eSpeak NG 1.51
_SYNCHRONOUS, _CHARACTERS, _UTF8, _RATE, _WORD, _OK = 2, 1, 1, 1, 1, 0


class _Event(ctypes.Structure):
    _fields_ = (
        ("type", ctypes.c_int),
        ("unique_identifier", ctypes.c_uint),
        ("text_position", ctypes.c_int),  # counts from 1
        ("length", ctypes.c_int),
        ("audio_position", ctypes.c_int),  # ms
        ("sample", ctypes.c_int),
        ("user_data", ctypes.c_void_p),
        ("id", ctypes.c_char * 8),
    )


_HEARD = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(ctypes.c_short), ctypes.c_int, ctypes.POINTER(_Event))


@functools.cache
def library() -> str | None:
    """The name of eSpeak's library, where it is installed; does not load it."""
    return ctypes.util.find_library("espeak-ng")


def is_installed() -> bool:
    return library() is not None


class Espeak:
    """eSpeak with one voice of each language. Blocking; belongs to the voice process."""

    def __init__(self, voice: str, speed: float) -> None:
        """``voice``: for what is not Chinese; nothing for the usual one."""
        self._voice = voice or ENGLISH
        self._speed = speed
        self._library: Any = None
        self._rate = 0
        self._hear = _HEARD(self._heard)  # kept: the library calls it
        self._pieces: list[Samples] = []
        self._began: list[tuple[int, float]] = []  # position in the text, s
        self._cancelled: Callable[[], bool] = lambda: False

    def load(self) -> None:
        name = library()
        if name is None:
            raise ModelError("espeak-ng is not installed.", hint=INSTALL)
        try:
            self._library = ctypes.CDLL(name)
        except OSError as error:
            raise ModelError(f"espeak-ng cannot be used: {error}.", hint=INSTALL) from error
        self._rate = int(self._library.espeak_Initialize(_SYNCHRONOUS, 0, None, 0))
        if self._rate <= 0:
            raise ModelError("espeak-ng cannot be used: its data are missing.", hint=INSTALL)
        self._library.espeak_SetSynthCallback(self._hear)
        self._library.espeak_SetParameter(_RATE, round(PACE * self._speed), 0)
        for voice in (self._voice, CHINESE):
            self._choose(voice)

    def speak(self, sentence: Sentence, cancelled: Callable[[], bool]) -> Iterator[Piece]:
        text, begins = sentence.joined()
        self._choose(CHINESE if sentence.chinese else self._voice)
        self._pieces, self._began, self._cancelled = [], [], cancelled
        data = text.encode("utf-8", "replace").replace(b"\0", b" ") + b"\0"
        self._library.espeak_Synth(data, ctypes.c_size_t(len(data)), 0, _CHARACTERS, 0, _UTF8, None, None)
        if self._pieces and not cancelled():  # all of it comes within milliseconds
            sound = np.concatenate(self._pieces)
            yield Piece(sound, self._rate, self._said(begins, len(sound) / self._rate))

    def _choose(self, voice: str) -> None:
        if self._library.espeak_SetVoiceByName(voice.encode()) != _OK:
            hint = "Set voice.speaker to one that `espeak-ng --voices` lists."
            raise ModelError(f"espeak-ng has no voice {voice!r}.", hint=hint)

    def _heard(self, samples: Any, count: int, events: Any) -> int:
        """In the midst of espeak_Synth: some sound, and what happens in it. Not 0: enough."""
        if count > 0 and samples:
            self._pieces.append(np.ctypeslib.as_array(samples, (count,)).copy())
        index = 0
        while events[index].type:
            if events[index].type == _WORD:
                self._began.append((events[index].text_position - 1, events[index].audio_position / 1000))
            index += 1
        return int(self._cancelled())

    def _said(self, begins: tuple[int, ...], length: float) -> tuple[Said, ...]:
        """A word has ended when the next one begins, and the last one when there is no more."""
        found: list[Said] = []
        for position, at in self._began:
            before = bisect_right(begins, position) - 1
            if before > (found[-1].count if found else 0):
                found.append(Said(before, at))
        return (*found, Said(len(begins), length))
