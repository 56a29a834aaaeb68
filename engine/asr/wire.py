"""What an engine and its recogniser process say to each other: messages with their length before them.

The engine asks (:class:`Transcribe`, :class:`Weigh`) and waits for the answer, and may say meanwhile that nobody needs
it any more (:class:`Cancel`). The process speaks first: it has loaded its model (:class:`Loaded`), or could not
(:class:`Failed`).
"""

from __future__ import annotations

import socket
from typing import Generic, TypeVar

import msgspec

from engine.asr.recogniser import Rejected, Transcript
from engine.messages import LENGTH_BYTES, packed

MAX_BYTES = 1 << 26
"""Longest message: 17 minutes of sound."""
_CHUNK = 1 << 16


class Transcribe(msgspec.Struct, frozen=True, tag=True):
    """One utterance. ``number`` counts up from 1."""

    number: int
    samples: bytes  # float32 of this machine, 16 kHz, ±1
    vocabulary: tuple[str, ...]
    quick: bool
    lead: tuple[str, bytes] | None = None  # the text, and int16 of this machine, 16 kHz


class Weigh(msgspec.Struct, frozen=True, tag=True):
    """How likely one of these texts is, and nothing else. ``number`` as above."""

    number: int
    samples: bytes
    texts: tuple[str, ...]


class Cancel(msgspec.Struct, frozen=True, tag=True):
    """Nobody needs the answer to this one any more; it comes nevertheless."""

    number: int


class Loaded(msgspec.Struct, frozen=True, tag=True):
    """The model is loaded and warm."""

    name: str = ""  # of the recogniser, with what is known of it by now


class Accepted(msgspec.Struct, frozen=True, tag=True):
    number: int
    transcript: Transcript


class Declined(msgspec.Struct, frozen=True, tag=True):
    number: int
    rejected: Rejected


class Weighed(msgspec.Struct, frozen=True, tag=True):
    number: int
    likelihood: float | None


class Failed(msgspec.Struct, frozen=True, tag=True):
    """A ``ModelError``, by its parts; the process ends after it."""

    message: str
    hint: str


Request = Transcribe | Weigh | Cancel
Answer = Loaded | Accepted | Declined | Weighed | Failed
T = TypeVar("T")


class Garbage(Exception):
    """The other side does not speak this language."""


class Wire(Generic[T]):
    """One end of the link; what arrives is of the type ``T`` that ``decoder`` reads."""

    def __init__(self, link: socket.socket, decoder: msgspec.msgpack.Decoder[T]) -> None:
        self._link = link
        self._decoder = decoder
        self._read = bytearray()

    def send(self, message: Request | Answer, limit: float | None = None) -> None:
        """Send within ``limit`` s. Raises ``OSError`` (``TimeoutError``) when the other side is gone (does not read)
        and ``ValueError`` for a message that is too long."""
        data = packed(message)
        if len(data) > LENGTH_BYTES + MAX_BYTES:
            raise ValueError(f"{len(data) - LENGTH_BYTES} bytes are too long for a message")
        self._link.settimeout(limit)
        self._link.sendall(data)

    def receive(self, limit: float | None = None) -> T | None:
        """The next message; None when nothing has come for ``limit`` s. Raises ``EOFError`` when the other side is
        gone, and :class:`Garbage`."""
        self._link.settimeout(limit)
        while (message := self._message()) is None:
            try:
                data = self._link.recv(_CHUNK)
            except TimeoutError:
                return None
            except OSError as error:  # it died with something unread
                raise EOFError from error
            if not data:
                raise EOFError
            self._read += data
        return message

    def _message(self) -> T | None:
        """Take a message out of what was read, if a whole one is there."""
        if len(self._read) < LENGTH_BYTES:
            return None
        end = LENGTH_BYTES + int.from_bytes(self._read[:LENGTH_BYTES], "little")
        if end > LENGTH_BYTES + MAX_BYTES:
            raise Garbage(f"a message of {end - LENGTH_BYTES} bytes")
        if len(self._read) < end:
            return None
        data = bytes(self._read[LENGTH_BYTES:end])
        del self._read[:end]
        try:
            return self._decoder.decode(data)
        except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
            raise Garbage(f"{data[:40]!r}: {error}") from error


REQUESTS: msgspec.msgpack.Decoder[Request] = msgspec.msgpack.Decoder(Request)
ANSWERS: msgspec.msgpack.Decoder[Answer] = msgspec.msgpack.Decoder(Answer)
