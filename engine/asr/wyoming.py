"""A server that speaks Wyoming, as those of Home Assistant do (wyoming-faster-whisper, for one).

The sound of an utterance goes there in one connection of its own, as the servers are used to, and the transcript comes
back in it.
"""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from engine.asr.remote import RATE, Heard
from engine.wyoming import server_fault, talking

if TYPE_CHECKING:
    from wyoming.event import Eventable

LIMIT_S: Final = 20.0
"""Longest wait for a transcript, s."""
_CHUNK: Final = 1600  # samples: 0.1 s


class WyomingTranscription:
    """See ``Elsewhere``."""

    def __init__(self, server: str, limit_s: float = LIMIT_S) -> None:
        """``server``: tcp://HOST:PORT or unix:///PATH."""
        self.name = f"Wyoming at {server}"
        self._server = server
        self._fault = server_fault(server, "asr.server")
        self._limit_s = limit_s

    async def ask(self, samples: NDArray[np.int16], vocabulary: Sequence[str], language: str | None) -> Heard:
        from wyoming.asr import Transcript

        async with talking(self._server, self._fault, self._limit_s) as talk, asyncio.timeout(self._limit_s):
            await talk.say(*_request(samples, vocabulary, language))
            while not Transcript.is_type((event := await talk.hear()).type):
                pass  # it may tell more than it was asked
            found = Transcript.from_event(event)
            if not isinstance(found.text, str):
                raise TypeError("it is no text")
            return Heard(found.text.strip(), found.language if isinstance(found.language, str) else None)

    async def close(self) -> None:
        """Every connection is closed after its answer."""


def _request(samples: NDArray[np.int16], vocabulary: Sequence[str], language: str | None) -> list[Eventable]:
    from wyoming.asr import Transcribe
    from wyoming.audio import AudioChunk, AudioStart, AudioStop

    pieces = (samples[at : at + _CHUNK].astype("<i2").tobytes() for at in range(0, len(samples), _CHUNK))
    return [
        Transcribe(language=language, transcript_names=list(vocabulary) or None),
        AudioStart(rate=RATE, width=2, channels=1),
        *(AudioChunk(rate=RATE, width=2, channels=1, audio=piece) for piece in pieces),
        AudioStop(),
    ]
