"""Piper (https://github.com/OHF-Voice/piper1-gpl): a neural voice, one language a file, faster than anybody listens.

Its licence is the GPL, so it is an extra that one installs oneself (``pip install 'sayso[voice]'``), and it is only
ever imported by the voice process (``engine.tts.worker``), never by the engine.

It does not tell when each word ends. But it tells into which sounds it turns a word, and those last about equally long.
"""

from __future__ import annotations

import importlib.util
import json
import os
from collections.abc import Callable, Iterator
from itertools import accumulate
from pathlib import Path
from typing import Any, Final

import numpy as np

from engine.errors import ModelError
from engine.tts.sentences import Sentence
from engine.tts.synthesis import QUIET, Piece, Said, Samples

THREADS: Final = min(2, os.cpu_count() or 1)
"""More make a short sentence no faster."""
INSTALL: Final = "Install it: pip install 'sayso[voice]' (it is under the GPL)."
SILENT: Final = 60
"""Of 32768: what is not louder is no beginning of a sound, however soft it is."""
_LEAD_S: Final = 0.01
_PAUSE: Final = 3  # sounds that a comma or a full stop lasts as long as
_SIGNS: Final = frozenset(" .,;:!?ˈˌ")  # phonemes that are no sounds


def is_installed() -> bool:
    """Whether there is piper on this machine; does not import it."""
    return importlib.util.find_spec("piper") is not None


class Piper:
    """One voice. Blocking; belongs to the voice process."""

    def __init__(self, file: str, speed: float) -> None:
        """``file``: the voice's .onnx, beside which its .onnx.json lies."""
        self._file = Path(file)
        self._speed = speed
        self._voice: Any = None
        self._wishes: Any = None

    def load(self) -> None:
        try:
            import onnxruntime
            from piper.config import PiperConfig, SynthesisConfig
            from piper.voice import PiperVoice
        except ImportError as error:
            raise ModelError(f"piper cannot be used: {error}.", hint=INSTALL) from error
        try:
            told = json.loads(Path(f"{self._file}.json").read_text(encoding="utf-8"))
            config = PiperConfig.from_dict(told)
            options = onnxruntime.SessionOptions()
            options.intra_op_num_threads = THREADS
            options.add_session_config_entry("session.intra_op.allow_spinning", "0")  # others need the processor
            session = onnxruntime.InferenceSession(
                str(self._file), sess_options=options, providers=["CPUExecutionProvider"]
            )
        except Exception as error:  # whatever a damaged file does to its readers
            hint = "Run: sayso models verify, or set voice.model to another voice."
            raise ModelError(f"The voice {self._file} cannot be loaded: {error}", hint=hint) from error
        self._voice = PiperVoice(session=session, config=config)
        self._wishes = SynthesisConfig(length_scale=(config.length_scale or 1.0) / self._speed)
        list(self._voice.synthesize("Ready.", self._wishes))  # the first time takes longer

    def speak(self, sentence: Sentence, cancelled: Callable[[], bool]) -> Iterator[Piece]:
        text, _ = sentence.joined()
        if not any(char.isalnum() for char in text):
            return
        sounds, rate = [], self._voice.config.sample_rate
        for chunk in self._voice.synthesize(text, self._wishes):  # one for what piper takes for a sentence
            if cancelled():
                return
            sounds.append(chunk.audio_int16_array)
        if sounds:
            sound = _from_its_beginning(np.concatenate(sounds), rate)
            yield Piece(sound, rate, self._said(sentence, sound, rate))

    def _said(self, sentence: Sentence, sound: Samples, rate: int) -> tuple[Said, ...]:
        """When each word ends, as far as one can tell from how many sounds it has."""
        lengths = [self._length(word.said) for word in sentence.words]
        whole = sum(lengths)
        loud = np.flatnonzero(np.abs(sound.astype(np.int32)) > QUIET * 32768)
        if not whole or not len(loud):
            return ()
        begin, end = float(loud[0]) / rate, float(loud[-1] + 1) / rate
        ends = (begin + (end - begin) * so_far / whole for so_far in accumulate(lengths))
        return tuple(Said(count, at) for count, at in enumerate(ends, 1))

    def _length(self, word: str) -> int:
        phonemes = [phoneme for group in self._voice.phonemize(word) for phoneme in group] if word else []
        pause = _PAUSE if word and not word[-1].isalnum() else 0
        return sum(phoneme not in _SIGNS for phoneme in phonemes) + pause


def _from_its_beginning(sound: Samples, rate: int) -> Samples:
    """Without the silence before it, a twentieth of a second that everybody would wait for."""
    begins = np.flatnonzero(np.abs(sound.astype(np.int32)) > SILENT)
    return sound[max(0, int(begins[0]) - round(_LEAD_S * rate)) :] if len(begins) else sound
