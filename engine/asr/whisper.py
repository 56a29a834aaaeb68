"""Whisper on this machine, through faster-whisper, made quick for short commands and deaf to what is no speech.

**Quick**: Whisper pads everything to 30 s, and the encoder pays for all of it. Here it gets a shorter window, and 30 s
only when the result of the short one is doubtful. **Deaf**: Whisper was trained on subtitles and writes *something*
for any sound, above all in silence. A transcript is only let through past gates on its mean log-probability, its
no-speech probability and the phrases that Whisper is known to invent.

Importing this module is cheap; faster-whisper is imported by :meth:`WhisperRecogniser.load`. An engine keeps both out
of its own process (``engine.asr.isolated``): loading and decoding hold the interpreter lock for tens of milliseconds.
"""

from __future__ import annotations

import contextlib
import logging
import math
import os
import re
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from config.schema import Asr
from engine.asr.gates import judge
from engine.asr.recogniser import Decoding, Rejected, Transcript
from engine.asr.sizes import title
from engine.asr.whole import Stretch
from engine.errors import ModelError
from engine.han import is_chinese
from engine.lead import Lead

RATE = 16_000
FULL_WINDOW_S = 30.0
"""What Whisper was trained on."""

MARGIN_S = 1.0
"""A window is at least this much longer than the sound: Whisper ends a sentence in the silence after it."""

SHORTEST_S = 0.2
"""Shorter sound holds no word."""

DOUBTFUL_LOGPROB = -0.6
"""A mean log-probability below this is worth a second try with the full window."""

UNCLEAR_LOGPROB = -0.25
"""A mean log-probability below this is worth it, too, in a thorough look: in noise the short window costs
words that the full one hears."""

REPETITIVE = 2.4
"""Compression ratio from which a text counts as a loop (Whisper's own threshold)."""

READINGS = 5
"""So many ways to read a sound are compared (the width of the beam) when the first made no sense…"""

NEARLY = 0.3
"""…and those whose mean log-probability is at most this much lower than the best's may have been said as well."""

TOKENS_PER_S = 8
"""No one speaks faster (English: 4 words a second, 1.5 tokens a word, with reserve); bounds the time of a loop."""

VOCABULARY_WORDS = 60
"""The prompt shares its 224 tokens with nothing else, but a long one slows every utterance down."""

READING_WORDS = 8
"""So many of these are told to whoever looks for other readings: a long list draws every noise to one of its words."""

LIKELIHOOD_WINDOW_S = 6.0
"""Window in which the likelihood of short texts is looked for: each of them pays for all of it."""

ENDINGS = "。!！.,，"
"""What may be written behind a text that was said, besides nothing."""

FILES = ("model.bin", "config.json", "tokenizer.json")


class WhisperRecogniser:
    """A CTranslate2 Whisper model in a folder of this machine; nothing is ever downloaded."""

    takes_lead = True

    def __init__(self, folder: Path, settings: Asr) -> None:
        self._folder = folder
        self._settings = settings
        self._threads = settings.threads or max(1, (os.cpu_count() or 1) // 2)
        self._model: Any = None
        self._first: tuple[_Sound, tuple[str, ...], _Result] | None = None  # the last short pass
        self._spoken: tuple[NDArray[np.float32], str] | None = None  # the last sound whose language was looked for
        self.name = self._name = f"{title(folder)} (int8, {self._threads} thread{'s' if self._threads > 1 else ''})"

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
                    hint="Set asr.model to a folder with a CTranslate2 model, or to a name from `sayso models list`.",
                )
        model = _open_model(self._folder, self._threads)
        if self._settings.language not in ("auto", *model.supported_languages):
            raise ModelError(
                f"The speech model {self._folder.name} does not know the language {self._settings.language!r}.",
                hint="Set asr.language to another one, or asr.model to a multilingual model.",
            )
        self._model = model
        for loudness in (0, 1e-3):  # the first one takes longer; and the same sound would not be encoded again
            sound = np.random.default_rng(0).normal(0, loudness, RATE).astype(np.float32)
            began = time.perf_counter()
            self._decode(_Sound(sound), (), self._settings.window_s, lambda: False)
            took = time.perf_counter() - began
        self.name = f"{self._name}, {self._settings.language}, {took:.1f} s a pass"

    def transcribe(
        self,
        samples: NDArray[np.float32],
        vocabulary: Sequence[str] = (),
        cancelled: Callable[[], bool] = lambda: False,
        *,
        quick: bool = False,
        lead: Lead | None = None,
    ) -> Transcript | Rejected:
        """Recognise one utterance; see ``Recogniser``."""
        began = time.perf_counter()
        self.load()
        audio_s = len(samples) / RATE
        if audio_s < SHORTEST_S:
            return Rejected("too_short", f"{audio_s:.2f} s of sound is too short for a word.")
        sound = _Sound(samples, lead)
        needed_s = len(sound.whole) / RATE + MARGIN_S
        short = needed_s <= self._settings.window_s  # as commands are
        window_s = min(FULL_WINDOW_S, max(self._settings.window_s, needed_s))
        result = self._first_look(sound, tuple(vocabulary), window_s, cancelled)
        may_gain = not self._is_hopeless(result) and window_s < FULL_WINDOW_S
        doubtful = result.doubtful and may_gain
        looks = [result]
        if may_gain and (doubtful or result.avg_logprob < UNCLEAR_LOGPROB) and not quick and not cancelled():
            looks.append(second := self._decode(sound, vocabulary, FULL_WINDOW_S, cancelled))
            window_s = FULL_WINDOW_S
            if second.avg_logprob > result.avg_logprob and (doubtful or not self._is_hopeless(second)):
                result = second
        decoding = Decoding(
            language=result.language,
            avg_logprob=result.avg_logprob,
            no_speech_probability=result.no_speech_probability,
            audio_s=audio_s,
            decode_s=time.perf_counter() - began,
            window_s=window_s,
            doubtful=doubtful and quick,
            only_reading=quick and short,
        )
        found = judge(result.text, decoding, self._settings, vocabulary)
        if isinstance(found, Rejected) and found.reason == "empty" and lead is not None:
            return replace(found, reason="no_speech", detail=f"Nothing was said after “{lead.text}”.")
        if isinstance(found, Rejected) or quick or cancelled() or not short:
            return found
        others = self._others(sound, vocabulary, found, looks, window_s, cancelled)
        return replace(found, decoding=replace(decoding, decode_s=time.perf_counter() - began), others=others)

    def stretches(self, samples: NDArray[np.float32], vocabulary: Sequence[str] = ()) -> Iterator[Stretch]:
        """Decode a whole recording in Whisper's own way, 30 s after 30 s; see ``WholeRecogniser``."""
        self.load()
        language = self._language_of(samples[: round(FULL_WINDOW_S * RATE)])
        self._model.window_frames = math.ceil(FULL_WINDOW_S * self._model.frames_per_second)
        self._model.compares = False
        self._model.cancelled = lambda: False
        began = time.perf_counter()
        segments, info = self._model.transcribe(
            samples,
            language=language,
            beam_size=READINGS,
            temperature=0.0,
            condition_on_previous_text=False,  # what is misheard once would be written on and on
            no_speech_threshold=None,
            log_prob_threshold=None,
            compression_ratio_threshold=None,
        )
        for segment in segments:
            unsure = segment.avg_logprob < DOUBTFUL_LOGPROB  # where it is sure, only the window began with silence
            decoding = Decoding(
                language=info.language,
                avg_logprob=segment.avg_logprob,
                no_speech_probability=segment.no_speech_prob if unsure else 0.0,
                audio_s=segment.end - segment.start,
                decode_s=time.perf_counter() - began,
                window_s=FULL_WINDOW_S,
            )
            found = judge(segment.text.strip(), decoding, self._settings, vocabulary)
            if isinstance(found, Transcript) and segment.compression_ratio > REPETITIVE:
                found = Rejected("low_confidence", "The recogniser repeats the same words.", found.text, decoding)
            yield Stretch(segment.start, segment.end, found)
            began = time.perf_counter()

    def likelihood(
        self, samples: NDArray[np.float32], texts: Sequence[str], cancelled: Callable[[], bool] = lambda: False
    ) -> float | None:
        """How likely it is that one of the texts was said and nothing else; see ``Recogniser``."""
        self.load()
        language = "zh" if is_chinese(texts[0]) else "en"
        spoken = self._model.model.is_multilingual or language == "en"
        if not spoken or len(samples) < SHORTEST_S * RATE or cancelled():
            return None
        self._model.window_frames = math.ceil(LIKELIHOOD_WINDOW_S * self._model.frames_per_second)
        likelihood: float = self._model.likelihood(samples, texts, language)
        return likelihood

    def close(self) -> None:
        """Nothing runs elsewhere."""

    def _is_hopeless(self, result: _Result) -> bool:
        """It is no speech: another look would not save it."""
        return result.no_speech_probability > self._settings.max_no_speech

    def _first_look(
        self, sound: _Sound, vocabulary: tuple[str, ...], window_s: float, cancelled: Callable[[], bool]
    ) -> _Result:
        """A pass with a short window; after a quick one, whoever looks twice need not look at the same again."""
        last, self._first = self._first, None
        if last is not None and last[1] == vocabulary and last[0] == sound:
            return last[2]
        result = self._decode(sound, vocabulary, window_s, cancelled)
        if sound.said is not None and result.doubtful and not cancelled():  # speech there is, but perhaps in the lead
            alone = self._decode(_Sound(sound.request), vocabulary, window_s, cancelled)
            result = alone if self._is_hopeless(alone) else result
        if not cancelled():
            self._first = sound, vocabulary, result
        return result

    def _others(
        self,
        sound: _Sound,
        vocabulary: Sequence[str],
        found: Transcript,
        looks: Sequence[_Result],
        window_s: float,
        cancelled: Callable[[], bool],
    ) -> tuple[str, ...]:
        """Other readings of a short sound, which pass the same gates: the right one is often the second or third. What
        the ``looks`` at it saw is among them."""
        self._model.readings = []
        self._decode(sound, vocabulary, window_s, cancelled, readings=READINGS)
        readings: list[tuple[str, float]] = self._model.readings
        least = max(found.decoding.avg_logprob, readings[0][1]) - NEARLY if readings else 0.0
        others: list[str] = []
        for text, logprob in (*readings, *((look.text, look.avg_logprob) for look in looks)):
            decoding = replace(found.decoding, avg_logprob=logprob)
            passed = judge(text, decoding, self._settings, vocabulary)
            if logprob >= least and isinstance(passed, Transcript) and text not in (found.text, *others):
                others.append(text)
        return tuple(others)

    def _decode(
        self,
        sound: _Sound,
        vocabulary: Sequence[str],
        window_s: float,
        cancelled: Callable[[], bool],
        *,
        readings: int = 1,
    ) -> _Result:
        """One pass with an encoder window of ``window_s``: greedy, or with a beam for several readings."""
        self._model.window_frames = math.ceil(window_s * self._model.frames_per_second)
        self._model.compares = readings > 1
        language = self._language_of(sound.request)
        if is_chinese(sound.said or "") and language != "zh":  # it would be an invitation to write Chinese
            sound = _Sound(sound.request)
        if language is not None:  # a list in another language would be an invitation to write it
            vocabulary = [noun for noun in vocabulary if is_chinese(noun) == (language == "zh")]
        words = VOCABULARY_WORDS if readings == 1 else READING_WORDS
        segments, info = self._model.transcribe(
            sound.whole,
            language=language,
            beam_size=readings,
            temperature=0.0,
            no_repeat_ngram_size=3,
            condition_on_previous_text=False,
            without_timestamps=True,
            initial_prompt=_prompt(vocabulary[:words]),
            prefix=sound.said,
            max_new_tokens=16 + math.ceil(TOKENS_PER_S * len(sound.whole) / RATE),
            no_speech_threshold=None,  # the gates are ours: faster-whisper's would drop the text without a reason
            log_prob_threshold=None,
            compression_ratio_threshold=None,
        )
        found = []
        self._model.cancelled = cancelled
        with contextlib.suppress(_Cancelled):
            for segment in segments:
                found.append(segment)
                if cancelled():
                    break
        return _Result.of(found, info.language, sound.said or "", self._model.tokens_of(sound.said))

    def _language_of(self, samples: NDArray[np.float32]) -> str | None:
        """The one that is set, or the likeliest of those that are spoken here: of a short command alone, Whisper
        believes it to be in any of a hundred."""
        if self._settings.language != "auto":
            return self._settings.language
        if not self._model.model.is_multilingual:
            return None
        if self._spoken is not None and np.array_equal(self._spoken[0], samples):
            return self._spoken[1]
        features = self._model.feature_extractor(samples)[..., :-1]  # which is what transcribing encodes: see encode()
        _, _, found = self._model.detect_language(features=features)
        chances: dict[str, float] = dict(found)
        language = max(self._settings.languages, key=lambda language: chances.get(language, 0.0))
        self._spoken = samples, language
        return language


class _Cancelled(Exception):
    """Nobody needs the text of what has been encoded."""


class _Sound:
    """A request, and the sound to recognise: the request with what was said right before it, which is known."""

    __slots__ = ("request", "said", "whole")

    def __init__(self, request: NDArray[np.float32], lead: Lead | None = None) -> None:
        self.request = self.whole = request
        self.said: str | None = None
        """What the text has to begin with."""
        if lead is not None:
            self.whole = np.concatenate((lead.samples * np.float32(1 / 32768), request))
            self.said = lead.text.title() + ","  # as in subtitles; the comma is where the request begins

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Sound) and self.said == other.said and np.array_equal(self.whole, other.whole)

    __hash__ = None  # type: ignore[assignment]


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
    def of(cls, segments: Sequence[Any], language: str, said: str, known: int) -> _Result:
        """``said`` is what the text had to begin with, ``known`` how many tokens that was."""
        if not segments:  # only specials were written: nothing was said, and no number tells how sure that is
            return cls("", language, 0.0, 1.0, 0.0)
        tokens = sum(len(segment.tokens) + 1 for segment in segments) - known  # nothing was uncertain in those
        return cls(
            after(said, " ".join(segment.text.strip() for segment in segments)),
            language,
            sum(segment.avg_logprob * (len(segment.tokens) + 1) for segment in segments) / tokens,
            max(segment.no_speech_prob for segment in segments),
            max(segment.compression_ratio for segment in segments),
        )


def after(said: str, text: str) -> str:
    """A text without what it had to begin with, as a sentence of its own, and without a comma at its end, which a list
    of nouns taught Whisper. Where nothing follows what came first, Whisper likes to write it, or the beginning of it,
    once more."""
    text = text.strip().rstrip(" ,，")
    if not said:
        return text
    known = re.findall(r"\w+", said.casefold())
    again = r"\W+".join(known)
    rest = re.sub(rf"^(?:{again}\b\W*)+", "", text, flags=re.IGNORECASE)
    left = re.findall(r"\w+", rest.casefold())
    if left == known[: len(left)]:
        return ""
    return rest[:1].upper() + rest[1:]


def _prompt(vocabulary: Sequence[str]) -> str | None:
    """Nouns as a list, as they might stand in a text; None without any."""
    return ", ".join(vocabulary) + "." if vocabulary else None


def _open_model(folder: Path, threads: int) -> Any:
    """A ``faster_whisper.WhisperModel`` whose encoder window is ``window_frames`` long (10 ms each)."""
    import ctranslate2
    from faster_whisper import WhisperModel
    from faster_whisper.audio import pad_or_trim
    from faster_whisper.tokenizer import Tokenizer

    logging.getLogger("faster_whisper").setLevel(logging.WARNING)
    ctranslate2.set_log_level(logging.ERROR)

    class WindowedModel(WhisperModel):  # type: ignore[misc]
        window_frames = 3000
        last: tuple[NDArray[np.float32], Any] | None = None
        compares = False  # several readings, which are kept
        cancelled: Callable[[], bool] = staticmethod(lambda: False)
        readings: list[tuple[str, float]] = []  # noqa: RUF012 (of the last pass, with their mean log-probabilities)

        def encode(self, features: NDArray[np.float32]) -> Any:
            # faster-whisper pads every stretch to 30 s just before it calls this; the encoder takes less
            taken = np.ascontiguousarray(features[..., : self.window_frames])
            if self.last is None or not np.array_equal(self.last[0], taken):  # else the language was found in it
                self.last = taken, super().encode(taken)
            return self.last[1]

        def tokens_of(self, text: str | None) -> int:
            """How many tokens a text takes that has to come first."""
            return len(self.hf_tokenizer.encode(f" {text}", add_special_tokens=False).ids) if text else 0

        def likelihood(self, samples: NDArray[np.float32], texts: Sequence[str], language: str) -> float:
            """The largest log-probability of a text and an end behind it, of all that could be written."""
            tokenizer = Tokenizer(self.hf_tokenizer, self.model.is_multilingual, task="transcribe", language=language)
            ends = [tokenizer.eot, *(tokenizer.encode(sign)[0] for sign in ENDINGS)]
            start = [*tokenizer.sot_sequence, tokenizer.no_timestamps]
            # Whisper begins with a space in languages that have any
            written = [tokenizer.encode(text if is_chinese(text) else f" {text}") for text in texts]
            # what is the beginning of another text costs nothing: its end is asked on the way
            rows = [row for row in written if not any(row == other[: len(row)] != other for other in written)]
            longest = max(map(len, rows))
            heard = self.encode(pad_or_trim(self.feature_extractor(samples)[..., :-1]))
            heard = np.asarray(heard.to(ctranslate2.DataType.float32))
            found = self.model.generate(
                ctranslate2.StorageView.from_array(np.repeat(heard, len(rows), axis=0)),
                # of equal length; what follows a text is asked before what is written in its place here
                [[*start, *tokens, *tokens[-1:] * (longest - len(tokens))] for tokens in rows],
                beam_size=1,
                max_length=2 * (len(start) + longest + 1),  # half of it is what may be written
                return_logits_vocab=True,
                suppress_blank=False,
                suppress_tokens=[],
            )
            chances = []
            for row, result in zip(rows, found, strict=True):
                steps = [np.asarray(step, np.float32).ravel() for step in result.logits[0][: len(row) + 1]]
                steps = [step - np.logaddexp.reduce(step) for step in steps]
                said = np.cumsum([step[token] for step, token in zip(steps, row, strict=False)])
                chances += [
                    float(said[len(tokens) - 1] + np.logaddexp.reduce(steps[len(tokens)][ends]))
                    for tokens in written
                    if row[: len(tokens)] == tokens
                ]
            return max(chances)

        def generate_with_fallback(self, encoder_output: Any, prompt: list[int], tokenizer: Any, options: Any) -> Any:
            if self.cancelled():
                raise _Cancelled
            # faster-whisper's own throws all readings but the best away; falling back is our business anyway
            if not self.compares:
                return super().generate_with_fallback(encoder_output, prompt, tokenizer, options)
            (found,) = self.model.generate(
                encoder_output,
                [prompt],
                beam_size=options.beam_size,
                num_hypotheses=options.beam_size,
                no_repeat_ngram_size=options.no_repeat_ngram_size,
                max_length=len(prompt) + options.max_new_tokens,
                return_scores=True,
                return_no_speech_prob=True,
                suppress_blank=options.suppress_blank,
                suppress_tokens=options.suppress_tokens,
            )
            known = self.tokens_of(options.prefix)
            self.readings = [
                (
                    after(options.prefix or "", tokenizer.decode(tokens)),
                    score * len(tokens) / (len(tokens) - known + 1),
                )
                for tokens, score in zip(found.sequences_ids, found.scores, strict=True)
            ]
            return found, self.readings[0][1], 0.0, 1.0

    try:
        return WindowedModel(str(folder), device="cpu", compute_type="int8", cpu_threads=threads, local_files_only=True)
    except Exception as error:  # tokenizers raises bare Exception for a damaged file, CTranslate2 several others
        raise ModelError(
            f"The speech model in {folder} cannot be loaded: {error}",
            hint="Run `sayso models verify`, then `sayso models pull`.",
        ) from error
