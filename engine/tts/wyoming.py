"""A voice that speaks Wyoming, as those of Home Assistant do (wyoming-piper, for one).

A sentence is asked for in one connection of its own, as the servers are used to, and its sound comes back in pieces
while it is made. It does not tell when words end, and how fast it speaks is its own affair.
"""

from __future__ import annotations

from collections.abc import AsyncGenerator
from typing import TYPE_CHECKING, Final

import numpy as np

from engine.errors import one_line
from engine.tts.sentences import Sentence
from engine.tts.synthesis import Piece
from engine.wyoming import Trouble, server_fault, talking

if TYPE_CHECKING:
    from wyoming.audio import AudioChunk

LIMIT_S: Final = 20.0
"""Longest silence of a server that was asked for a sentence, s."""
LONGEST_S: Final = 120.0
"""A sentence that lasts longer is none, s."""


class WyomingVoice:
    """One voice of one server; see ``Synthesiser``."""

    def __init__(self, server: str, speaker: str | None = None, limit_s: float = LIMIT_S) -> None:
        """``server``: tcp://HOST:PORT or unix:///PATH; ``speaker``: a voice as the server calls it; None: its usual."""
        self.name = f"Wyoming at {server}" + (f" ({speaker})" if speaker else "")
        self._server = server
        self._speaker = speaker
        self._fault = server_fault(server, "voice.server")
        self._limit_s = limit_s

    async def load(self) -> None:
        """Nothing is sent before there is something to say."""

    async def synthesise(self, sentence: Sentence) -> AsyncGenerator[Piece]:
        """See ``Synthesiser``. Raises ``ModelError``."""
        from wyoming.audio import AudioChunk, AudioStop
        from wyoming.tts import Synthesize, SynthesizeVoice

        text, _ = sentence.joined()
        voice = SynthesizeVoice(name=self._speaker) if self._speaker else None
        length = 0.0
        async with talking(self._server, self._fault, self._limit_s) as talk:
            await talk.say(Synthesize(text, voice))
            while not AudioStop.is_type((event := await talk.hear()).type):
                if AudioChunk.is_type(event.type):
                    piece = _piece(AudioChunk.from_event(event))
                    length += len(piece.samples) / piece.rate
                    if length > LONGEST_S:
                        raise Trouble(f"does not come to the end of a sentence within {LONGEST_S:g} s of sound")
                    yield piece
            if not length and sentence.audible:
                raise Trouble("sent no sound of a sentence")

    async def close(self) -> None:
        """Every connection is closed after its sentence."""


def _piece(chunk: AudioChunk) -> Piece:
    if (chunk.width, chunk.channels) not in ((2, 1), (2, 2)) or not 8000 <= chunk.rate <= 192_000:
        sound = f"{chunk.rate} Hz, {chunk.width} bytes, {chunk.channels} channels"
        raise Trouble(f"sends sound of a kind that is not understood here ({one_line(sound, 80)})")
    samples = np.frombuffer(chunk.audio, "<i2").reshape(-1, chunk.channels)
    return Piece(samples.mean(axis=1).astype(np.int16), chunk.rate)
