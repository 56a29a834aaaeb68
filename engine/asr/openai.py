"""Any service that speaks OpenAI's ``POST {base_url}/audio/transcriptions``: OpenAI, or one on a machine of yours.

(https://platform.openai.com/docs/api-reference/audio/createTranscription) It is asked for ``verbose_json``, in which
Whisper says how sure it was; a service that does not know that form is asked for ``json`` from then on.
"""

from __future__ import annotations

import io
import wave
from collections.abc import Mapping, Sequence
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, ValidationError

from engine.asr.remote import RATE, Heard
from engine.errors import ModelError, SaysoError

VOCABULARY_WORDS: Final = 60
_FULL_NAMES: Final = {"english": "en", "chinese": "zh", "mandarin": "zh", "cantonese": "zh", "german": "de"}
_BAD_REQUEST: Final = (400, 422)


class Service(Protocol):
    """Whoever carries a recording there and the answer back; see ``engine.llm.recordings``."""

    @property
    def name(self) -> str: ...

    async def send(self, path: str, wav: bytes, fields: Mapping[str, str]) -> Any:
        """The answer, read as JSON. Raises ``SaysoError``; one with a ``status`` is a refusal."""
        ...

    async def close(self) -> None: ...


class _Segment(BaseModel):
    model_config = ConfigDict(allow_inf_nan=False)

    tokens: tuple[int, ...] = ()
    avg_logprob: float | None = None
    no_speech_prob: float | None = None


class _Answer(BaseModel):
    """As far as it is of use here; services add what they like."""

    text: str
    language: str | None = None
    segments: tuple[_Segment, ...] | None = None


class OpenAITranscription:
    """See ``Elsewhere``."""

    def __init__(self, service: Service, model: str) -> None:
        """``model`` as the service calls it."""
        self._service = service
        self._model = model
        self._form = "verbose_json"
        self.name = f"{service.name} ({model})"

    async def ask(self, samples: NDArray[np.int16], vocabulary: Sequence[str], language: str | None) -> Heard:
        fields = {"model": self._model, "temperature": "0"}
        if language is not None:
            fields["language"] = language
        if vocabulary:
            fields["prompt"] = ", ".join(vocabulary[:VOCABULARY_WORDS]) + "."
        return self._read(await self._answer(as_wav(samples), fields))

    async def close(self) -> None:
        await self._service.close()

    async def _answer(self, wav: bytes, fields: Mapping[str, str]) -> Any:
        try:
            return await self._service.send("/audio/transcriptions", wav, {**fields, "response_format": self._form})
        except SaysoError as refusal:
            if self._form == "json" or getattr(refusal, "status", None) not in _BAD_REQUEST:
                raise
        self._form = "json"
        return await self._service.send("/audio/transcriptions", wav, {**fields, "response_format": self._form})

    def _read(self, told: Any) -> Heard:
        try:
            answer = _Answer.model_validate(told)
        except ValidationError:
            raise ModelError(
                f"The answer of the platform {self._service.name} cannot be read: it is no transcription.",
                hint=f"Check that platforms.{self._service.name} is a service that transcribes.",
            ) from None
        segments = answer.segments or ()
        sure = [(len(s.tokens) + 1, s.avg_logprob) for s in segments if s.avg_logprob is not None]
        silent = [s.no_speech_prob for s in segments if s.no_speech_prob is not None]
        language = answer.language.strip().casefold() if answer.language else None
        return Heard(
            answer.text.strip(),
            _FULL_NAMES.get(language, language) if language else None,
            sum(n * logprob for n, logprob in sure) / sum(n for n, _ in sure) if sure else None,
            max(silent, default=None),
        )


def as_wav(samples: NDArray[np.int16]) -> bytes:
    """A WAV file with 16 kHz mono sound."""
    file = io.BytesIO()
    with wave.open(file, "wb") as out:
        out.setnchannels(1)
        out.setsampwidth(2)
        out.setframerate(RATE)
        out.writeframes(samples.astype("<i2").tobytes())
    return file.getvalue()
