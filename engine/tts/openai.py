"""Any service that speaks OpenAI's ``POST {base_url}/audio/speech``: OpenAI itself, or one on a machine of yours.

(https://platform.openai.com/docs/api-reference/audio/createSpeech) It is asked for ``pcm``, which it sends while it
makes it: 24 kHz, 16-bit, mono, little-endian. One that answers with a WAV file nevertheless is understood, too. It does
not tell when words end.
"""

from __future__ import annotations

from collections.abc import AsyncGenerator, Mapping
from contextlib import aclosing
from typing import Any, Final, Protocol

import numpy as np

from engine.errors import ModelError
from engine.tts.sentences import Sentence
from engine.tts.synthesis import Piece

RATE: Final = 24_000
"""Hz, of ``pcm``."""
USUAL_SPEAKER: Final = "alloy"
"""A voice that OpenAI has, and that compatible services know by this name."""
_NO_SOUND: Final = frozenset({"application/json", "text/html", "text/plain"})
_PACKED: Final = frozenset(
    {"application/ogg"}
    | {f"audio/{kind}" for kind in ("aac", "aacp", "flac", "mp3", "mp4", "mpeg", "ogg", "opus", "webm", "x-flac")}
)
"""Media types of sound that would have to be unpacked; played as it is, it is noise at full loudness."""
_HEADER_BYTES: Final = 65_536  # a WAV file whose sound begins later is none
_PCM: Final = 1  # format tag of a WAV file (RIFF, "WAVEFORMATEX")
_EXTENSIBLE: Final = 0xFFFE


class Answer(Protocol):
    """What a service sends back."""

    @property
    def kind(self) -> str:
        """Its media type."""
        ...

    @property
    def pieces(self) -> AsyncGenerator[bytes]:
        """Its bytes, as they come. Raises ``SaysoError``."""
        ...


class Service(Protocol):
    """Whoever carries questions there and answers back; see ``engine.llm.bytes``."""

    @property
    def name(self) -> str: ...

    async def ask(self, path: str, body: Mapping[str, Any]) -> Answer: ...

    async def warm(self) -> None: ...

    async def close(self) -> None: ...


class ServiceVoice:
    """One voice of one platform."""

    def __init__(self, service: Service, model: str, speaker: str, speed: float = 1.0) -> None:
        """``model`` and ``speaker`` as the service calls them; ``speed`` 1 is its own."""
        self._service = service
        self._body: dict[str, Any] = {"model": model, "voice": speaker, "response_format": "pcm"}
        if speed != 1.0:  # not every service takes it
            self._body["speed"] = speed
        self.name = f"{service.name} ({model}, {speaker})"

    async def load(self) -> None:
        """Nothing is sent before there is something to say."""
        await self._service.warm()

    async def synthesise(self, sentence: Sentence) -> AsyncGenerator[Piece]:
        """See ``Synthesiser``. Raises ``SaysoError``."""
        text, _ = sentence.joined()
        answer = await self._service.ask("/audio/speech", {**self._body, "input": text})
        if answer.kind in _NO_SOUND | _PACKED:
            await answer.pieces.aclose()
            raise self._unreadable(f"it is of the kind {answer.kind}, not sound in PCM")
        sound, heard = _Sound(), False
        async with aclosing(answer.pieces) as pieces:
            async for data in pieces:
                try:
                    piece = sound.add(data)
                except ValueError as error:
                    raise self._unreadable(str(error)) from error
                except Exception as error:  # noqa: BLE001 - whatever the service sent
                    raise self._unreadable(f"it is nothing that was expected ({type(error).__name__})") from None
                if len(piece.samples):
                    heard = True
                    yield piece
        if not heard and sentence.audible:
            raise self._unreadable("the service sent no sound")

    async def close(self) -> None:
        await self._service.close()

    def _unreadable(self, why: str) -> ModelError:
        message = f"The answer of the platform {self._service.name} cannot be played: {why}."
        return ModelError(message, hint=f"Check that platforms.{self._service.name} is a service for speech.")


class _Sound:
    """PCM, or a WAV file, as it comes."""

    def __init__(self) -> None:
        self._data = b""
        self._rate = RATE
        self._begun = False  # the sound itself has

    def add(self, data: bytes) -> Piece:
        """The sound in what came. Raises ``ValueError`` for what is none."""
        self._data += data
        if not self._begun and len(self._data) >= 4:
            if (kind := _packed_as(self._data)) is not None:
                raise ValueError(f"it is {kind}, not sound in PCM")
            self._begun = not self._data.startswith(b"RIFF") or self._skip_header()
        if not self._begun:
            return Piece(np.zeros(0, np.int16), self._rate)
        whole = len(self._data) // 2 * 2
        samples = np.frombuffer(self._data[:whole], "<i2").astype(np.int16)
        self._data = self._data[whole:]
        return Piece(samples, self._rate)

    def _skip_header(self) -> bool:
        """Read the chunks before the sound; False while more of them are to come."""
        at = 12
        while len(self._data) >= at + 8:
            name, length = self._data[at : at + 4], int.from_bytes(self._data[at + 4 : at + 8], "little")
            if name == b"data":
                self._data = self._data[at + 8 :]
                return True
            if name == b"fmt " and len(self._data) >= at + 24:
                head = self._data[at + 8 :]
                tag, channels = int.from_bytes(head[:2], "little"), int.from_bytes(head[2:4], "little")
                self._rate, bits = int.from_bytes(head[4:8], "little"), int.from_bytes(head[14:16], "little")
                if tag not in (_PCM, _EXTENSIBLE) or channels != 1 or bits != 16 or not 8000 <= self._rate <= 192_000:
                    raise ValueError(f"it is a WAV file with {channels} channels of {bits} bits at {self._rate} Hz")
            at += 8 + length + length % 2
        if len(self._data) > _HEADER_BYTES:
            raise ValueError("it is a WAV file without sound")
        return False


def _packed_as(data: bytes) -> str | None:
    """What sound that would have to be unpacked begins like, whatever its media type; None for PCM and WAV files."""
    for beginning, kind in ((b"ID3", "MP3"), (b"OggS", "Ogg"), (b"fLaC", "FLAC"), (b"\x1aE\xdf\xa3", "WebM")):
        if data.startswith(beginning):
            return kind
    # A frame of MPEG audio: 12 bits that are set, one for the version, two for the layer (ISO/IEC 11172-3, 2.4.1.3, and
    # 13818-7, 6.2.1, for AAC). In PCM that is a first sample of one of eight values beyond ±1000; silence, -1, is not.
    if data[0] == 0xFF and data[1] & 0xF0 == 0xF0:
        return {0b01: "MP3", 0b00: "AAC"}.get(data[1] >> 1 & 0b11)
    return None
