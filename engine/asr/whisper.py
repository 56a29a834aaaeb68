"""Whisper on this machine, through faster-whisper, made quick for short commands and deaf to what is no speech.

**Quick**: Whisper pads everything to 30 s, and the encoder pays for all of it. Here it gets a shorter window, and 30 s
only when the result of the short one is doubtful. **Deaf**: Whisper was trained on subtitles and writes *something*
for any sound, above all in silence. A transcript is only let through past gates on its mean log-probability, its
no-speech probability and the phrases that Whisper is known to invent.

Importing this module is cheap; faster-whisper is imported by :meth:`WhisperRecogniser.load`. An engine keeps both out
of its own process (``engine.asr.isolated``): loading and decoding hold the interpreter lock for tens of milliseconds.
"""

from __future__ import annotations

import logging
import math
import os
import re
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from config.schema import Asr
from engine.asr.recogniser import Decoding, Rejected, Transcript
from engine.errors import ModelError

RATE = 16_000
FULL_WINDOW_S = 30.0
"""What Whisper was trained on."""

MARGIN_S = 1.0
"""A window is at least this much longer than the sound: Whisper ends a sentence in the silence after it."""

SHORTEST_S = 0.2
"""Shorter sound holds no word."""

DOUBTFUL_LOGPROB = -0.6
"""A mean log-probability below this is worth a second try with the full window."""

REPETITIVE = 2.4
"""Compression ratio from which a text counts as a loop (Whisper's own threshold)."""

TOKENS_PER_S = 8
"""No one speaks faster (English: 4 words a second, 1.5 tokens a word, with reserve); bounds the time of a loop."""

VOCABULARY_WORDS = 60
"""The prompt shares its 224 tokens with nothing else, but a long one slows every utterance down."""

FILES = ("model.bin", "config.json", "tokenizer.json")

ARTEFACTS = frozenset(
    (
        "amara org",
        "bye",
        "bye bye",
        "i",
        "music",
        "oh",
        "please subscribe",
        "silence",
        "so",
        "subtitles by the amara org community",
        "thank you",
        "thank you for watching",
        "thank you so much for watching",
        "thank you very much",
        "thanks for watching",
        "the",
        "uh",
        "um",
        "you",
    )
)
"""What Whisper writes in noise and silence (normalised): credits and small talk of the subtitles it learnt from, and
single words that are no command."""


class WhisperRecogniser:
    """A CTranslate2 Whisper model in a folder of this machine; nothing is ever downloaded."""

    def __init__(self, folder: Path, settings: Asr) -> None:
        self._folder = folder
        self._settings = settings
        self._threads = settings.threads or max(1, (os.cpu_count() or 1) // 2)
        self._model: Any = None
        self.name = f"{folder.name} (int8, {self._threads} thread{'s' if self._threads > 1 else ''})"

    def load(self) -> None:
        """Load the model and run it once, so that the first command is as quick as the next. About 1 s.

        Raises ``ModelError`` when files are missing or damaged, or the model does not speak the language.
        """
        if self._model is not None:
            return
        for name in FILES:
            if not (self._folder / name).is_file():
                raise ModelError(
                    f"The speech model in {self._folder} is incomplete: {name} is missing.",
                    hint="Run `sayso models pull`.",
                )
        model = _open_model(self._folder, self._threads)
        if self._settings.language not in ("auto", *model.supported_languages):
            raise ModelError(
                f"The speech model {self._folder.name} does not know the language {self._settings.language!r}.",
                hint="Set asr.language to another one, or asr.model to a multilingual model.",
            )
        self._model = model
        self._decode(np.zeros(RATE, np.float32), None, self._settings.window_s, lambda: False)

    def transcribe(
        self,
        samples: NDArray[np.float32],
        vocabulary: Sequence[str] = (),
        cancelled: Callable[[], bool] = lambda: False,
        *,
        quick: bool = False,
    ) -> Transcript | Rejected:
        """Recognise one utterance; see ``Recogniser``."""
        began = time.perf_counter()
        self.load()
        audio_s = len(samples) / RATE
        if audio_s < SHORTEST_S:
            return Rejected("too_short", f"{audio_s:.2f} s of sound is too short for a word.")
        prompt = _prompt(vocabulary)
        window_s = min(FULL_WINDOW_S, max(self._settings.window_s, audio_s + MARGIN_S))
        result = self._decode(samples, prompt, window_s, cancelled)
        hopeless = result.no_speech_probability > self._settings.max_no_speech  # a second look would not save it
        done = quick or hopeless or not result.doubtful
        if not done and window_s < FULL_WINDOW_S and not cancelled():
            second = self._decode(samples, prompt, FULL_WINDOW_S, cancelled)
            window_s = FULL_WINDOW_S
            if second.avg_logprob > result.avg_logprob:
                result = second
        decoding = Decoding(
            language=result.language,
            avg_logprob=result.avg_logprob,
            no_speech_probability=result.no_speech_probability,
            audio_s=audio_s,
            decode_s=time.perf_counter() - began,
            window_s=window_s,
        )
        return judge(result.text, decoding, self._settings, vocabulary)

    def close(self) -> None:
        """Nothing runs elsewhere."""

    def _decode(
        self, samples: NDArray[np.float32], prompt: str | None, window_s: float, cancelled: Callable[[], bool]
    ) -> _Result:
        """One greedy pass with an encoder window of ``window_s``."""
        self._model.window_frames = math.ceil(window_s * self._model.frames_per_second)
        language = None if self._settings.language == "auto" else self._settings.language
        segments, info = self._model.transcribe(
            samples,
            language=language,
            beam_size=1,
            temperature=0.0,
            no_repeat_ngram_size=3,
            condition_on_previous_text=False,
            without_timestamps=True,
            initial_prompt=prompt,
            max_new_tokens=16 + math.ceil(TOKENS_PER_S * len(samples) / RATE),
            no_speech_threshold=None,  # the gates are ours: faster-whisper's would drop the text without a reason
            log_prob_threshold=None,
            compression_ratio_threshold=None,
        )
        found = []
        for segment in segments:
            found.append(segment)
            if cancelled():
                break
        return _Result.of(found, info.language)


class _Result:
    """The segments of one pass, put together."""

    __slots__ = ("avg_logprob", "doubtful", "language", "no_speech_probability", "text")

    def __init__(self, text: str, language: str, logprob: float, no_speech: float, compression: float) -> None:
        self.text = text
        self.language = language
        self.avg_logprob = logprob
        self.no_speech_probability = no_speech
        self.doubtful = logprob < DOUBTFUL_LOGPROB or compression > REPETITIVE

    @classmethod
    def of(cls, segments: Sequence[Any], language: str) -> _Result:
        if not segments:  # only specials were written: nothing was said, and no number tells how sure that is
            return cls("", language, 0.0, 1.0, 0.0)
        tokens = sum(len(segment.tokens) + 1 for segment in segments)
        return cls(
            " ".join(segment.text.strip() for segment in segments).strip(),
            language,
            sum(segment.avg_logprob * (len(segment.tokens) + 1) for segment in segments) / tokens,
            max(segment.no_speech_prob for segment in segments),
            max(segment.compression_ratio for segment in segments),
        )


def judge(text: str, decoding: Decoding, settings: Asr, vocabulary: Sequence[str]) -> Transcript | Rejected:
    """Let a text through as a transcript, or say why it is none."""
    words = _normalised(text)
    if not words:
        return Rejected("empty", "No words were recognised.", text, decoding)
    if decoding.no_speech_probability > settings.max_no_speech:
        detail = f"The sound is no speech with probability {decoding.no_speech_probability:.2f}."
        return Rejected("no_speech", detail, text, decoding)
    if decoding.avg_logprob < settings.min_logprob:
        detail = f"Too uncertain: mean log-probability {decoding.avg_logprob:.2f} is below {settings.min_logprob:g}."
        return Rejected("low_confidence", detail, text, decoding)
    if words in ARTEFACTS:
        return Rejected("artefact", f"{text!r} is what the recogniser writes in noise.", text, decoding)
    if _echoes(words, vocabulary):
        return Rejected("artefact", "Only the list of expected words came back.", text, decoding)
    return Transcript(text, min(1.0, math.exp(decoding.avg_logprob)), decoding)


def _normalised(text: str) -> str:
    """Lower-case words without punctuation and stage directions such as ``[Music]``."""
    spoken = re.sub(r"\[[^\]]*\]|\([^)]*\)|♪[^♪]*♪?", " ", text)
    return " ".join(re.findall(r"[^\W_]+(?:['’][^\W_]+)*", spoken.casefold()))


def _echoes(words: str, vocabulary: Sequence[str]) -> bool:
    """Whether ``words`` are three or more of the expected ones with nothing but articles between them."""
    nouns = sorted((_normalised(noun) for noun in vocabulary), key=len, reverse=True)
    if not nouns:
        return False
    left, count = re.subn(rf"\b(?:{'|'.join(map(re.escape, nouns))})\b", " ", words)
    return count >= 3 and not set(left.split()) - {"the", "a", "and"}


def _prompt(vocabulary: Sequence[str]) -> str | None:
    """Nouns as a list, as they might stand in a text; None without any."""
    return ", ".join(vocabulary[:VOCABULARY_WORDS]) + "." if vocabulary else None


def _open_model(folder: Path, threads: int) -> Any:
    """A ``faster_whisper.WhisperModel`` whose encoder window is ``window_frames`` long (10 ms each)."""
    os.environ["HF_HUB_OFFLINE"] = "1"  # before the import: huggingface_hub reads it once
    import ctranslate2
    from faster_whisper import WhisperModel

    logging.getLogger("faster_whisper").setLevel(logging.WARNING)
    ctranslate2.set_log_level(logging.ERROR)

    class WindowedModel(WhisperModel):  # type: ignore[misc]
        window_frames = 3000

        def encode(self, features: NDArray[np.float32]) -> Any:
            # faster-whisper pads every stretch to 30 s just before it calls this; the encoder takes less
            return super().encode(np.ascontiguousarray(features[..., : self.window_frames]))

    try:
        return WindowedModel(str(folder), device="cpu", compute_type="int8", cpu_threads=threads, local_files_only=True)
    except Exception as error:  # tokenizers raises bare Exception for a damaged file, CTranslate2 several others
        raise ModelError(
            f"The speech model in {folder} cannot be loaded: {error}",
            hint="Run `sayso models verify`, then `sayso models pull`.",
        ) from error
