"""What an engine and its voice process say to each other: messages with their length before them.

The process speaks first: it has loaded its voice (:class:`Loaded`), or could not (:class:`Failed`). Then the engine
asks for one sentence after the other (:class:`Speak`), and gets its sound in pieces (:class:`Sound`) and its end
(:class:`Done`). It may say meanwhile that nobody needs it any more (:class:`Cancel`); the end comes nevertheless.
"""

from __future__ import annotations

import msgspec

from engine.tts.sentences import Sentence
from engine.tts.synthesis import Said

MAX_BYTES = 1 << 26
"""Longest message: 12 minutes of sound."""


class Speak(msgspec.Struct, frozen=True, tag=True):
    """One sentence. ``number`` counts up from 1."""

    number: int
    sentence: Sentence


class Cancel(msgspec.Struct, frozen=True, tag=True):
    """Nobody needs this one, or any before it, any more."""

    number: int


class Loaded(msgspec.Struct, frozen=True, tag=True):
    """The voice is loaded and warm."""


class Sound(msgspec.Struct, frozen=True, tag=True):
    """A piece of the sound of a sentence."""

    number: int
    samples: bytes  # mono signed 16-bit of this machine
    rate: int  # Hz
    said: tuple[Said, ...]


class Done(msgspec.Struct, frozen=True, tag=True):
    """That was all of it."""

    number: int


class Failed(msgspec.Struct, frozen=True, tag=True):
    """A ``ModelError``, by its parts; the process ends after it."""

    message: str
    hint: str


Request = Speak | Cancel
Answer = Loaded | Sound | Done | Failed
REQUESTS: msgspec.msgpack.Decoder[Request] = msgspec.msgpack.Decoder(Request)
ANSWERS: msgspec.msgpack.Decoder[Answer] = msgspec.msgpack.Decoder(Answer)
