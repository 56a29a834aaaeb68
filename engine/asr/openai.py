"""Any service that speaks OpenAI's ``POST {base_url}/audio/transcriptions``: OpenAI, or one on a machine of yours.

(https://platform.openai.com/docs/api-reference/audio/createTranscription) It is asked for ``verbose_json``, in which
Whisper says how sure it was; a service that does not know that form is asked for ``json`` from then on.
"""

from __future__ import annotations

import io
import wave
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Final, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError, ValidatorFunctionWrapHandler, WrapValidator

from engine.asr.remote import RATE, Heard
from engine.errors import ModelError, SaysoError

VOCABULARY_WORDS: Final = 60
_BAD_REQUEST: Final = (400, 422)
T = TypeVar("T")


class Service(Protocol):
    """Whoever carries a recording there and the answer back; see ``engine.llm.recordings``."""

    @property
    def name(self) -> str: ...

    async def send(self, path: str, wav: bytes, fields: Mapping[str, str]) -> Any:
        """The answer, read as JSON. Raises ``SaysoError``; one with a ``status`` is a refusal."""
        ...

    async def close(self) -> None: ...


def _or_nothing(value: Any, read: ValidatorFunctionWrapHandler) -> Any:
    """None for what cannot be read."""
    try:
        return read(value)
    except ValidationError:
        return None


AsFarAsReadable = Annotated[T | None, WrapValidator(_or_nothing)]
"""What is worth having, and no reason to throw a text away."""


class _Segment(BaseModel):
    model_config = ConfigDict(allow_inf_nan=False)

    tokens: AsFarAsReadable[tuple[int, ...]] = None
    avg_logprob: AsFarAsReadable[Annotated[float, Field(ge=-100, le=0)]] = None
    no_speech_prob: AsFarAsReadable[Annotated[float, Field(ge=0, le=1)]] = None


class _Answer(BaseModel):
    """As far as it is of use here; services add what they like."""

    text: str
    language: AsFarAsReadable[str] = None
    segments: AsFarAsReadable[tuple[AsFarAsReadable[_Segment], ...]] = None


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
        answer = await self._service.send("/audio/transcriptions", wav, {**fields, "response_format": "json"})
        self._form = "json"  # it was the form that it did not take
        return answer

    def _read(self, told: Any) -> Heard:
        try:
            answer = _Answer.model_validate(told)
        except ValidationError:
            raise ModelError(
                f"The answer of the platform {self._service.name} cannot be read: it is no transcription.",
                hint=f"Check that platforms.{self._service.name} is a service that transcribes.",
            ) from None
        segments = [segment for segment in answer.segments or () if segment is not None]
        sure = [(len(s.tokens or ()) + 1, s.avg_logprob) for s in segments if s.avg_logprob is not None]
        silent = [s.no_speech_prob for s in segments if s.no_speech_prob is not None]
        return Heard(
            answer.text.strip(),
            answer.language,
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
