"""Who says the words that a head is trained with: every synthetic voice that this machine has.

All of them are programs or models of their own, used as such: eSpeak NG and Flite are run, piper is a child process,
and Kokoro (https://huggingface.co/hexgrad/Kokoro-82M, Apache-2.0) is a model that is told how to sound by a *style*, so
that two styles mixed are a third voice. What was said once is kept in the cache folder.

eSpeak and Kokoro speak Chinese as well; Kokoro in the styles of Chinese speakers where there are any (their names begin
with a z), and in all others, which have an accent.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import sys
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Final, Literal, Protocol

import numpy as np
import soxr
from numpy.typing import NDArray

from engine.errors import ModelError
from engine.wake.embedding import RATE
from engine.wake.training import mandarin
from engine.wake.training.programs import decoded, output

Sound = NDArray[np.float32]
"""Mono, 16 kHz, ±1."""
Language = Literal["en", "zh"]

_MIX: Final = "+"  # between the names of those that a voice is mixed of
_MIXED: Final = 12  # voices that are mixed from two styles
_WORDS_A_MINUTE: Final = 165
_ACCENTS: Final = ("en-us", "en-gb", "en-gb-scotland", "en-gb-x-rp", "en-gb-x-gbclan", "en-gb-x-gbcwmd", "en-029")
_VARIANTS: Final = tuple(
    "m1 m2 m3 m4 m5 m6 m7 m8 f1 f2 f3 f4 f5 klatt klatt3 klatt4 Alex Alicia Andrea Andy Annie adam anika aunty "  # noqa: SIM905
    "belinda benjamin boris caleb david Denis ed edward Gene grandma grandpa gustave Henrique Hugo iven john Lee linda "
    "Marco Mario max Michael Mike pablo paul pedro quincy rob robert shelby steph travis victor zac".split()
)
_FLITE: Final = ("awb", "kal16", "rms", "slt")


class Voice(Protocol):
    """One speaker."""

    @property
    def name(self) -> str:
        """``kokoro:af_heart``: the engine, and who."""
        ...

    @property
    def speakers(self) -> Sequence[str]:
        """Whom one hears: the same in every language and accent; more than one in a mixture."""
        ...

    @property
    def language(self) -> Language:
        """What it can say."""
        ...

    def say(self, text: str, pace: float) -> Sound:
        """Say it, at ``pace`` times the usual speed. Raises ``ModelError``."""
        ...


@dataclass(frozen=True, slots=True)
class Espeak:
    """A variant of eSpeak NG with an accent and a pitch of its own."""

    accent: str
    variant: str
    pitch: int  # 0…99

    @property
    def name(self) -> str:
        return f"espeak:{self.accent}+{self.variant}"

    @property
    def speakers(self) -> Sequence[str]:
        return (f"espeak:{self.variant}",)

    @property
    def language(self) -> Language:
        return "zh" if self.accent == mandarin.VOICE else "en"

    def say(self, text: str, pace: float) -> Sound:
        speed = str(round(_WORDS_A_MINUTE * pace))
        voice = f"{self.accent}+{self.variant}"
        command = ["espeak-ng", "-v", voice, "-s", speed, "-p", str(self.pitch), "--stdout", "--", text]
        return decoded(output(command))


@dataclass(frozen=True, slots=True)
class Flite:
    """A voice of Flite (http://cmuflite.org)."""

    speaker: str

    @property
    def name(self) -> str:
        return f"flite:{self.speaker}"

    @property
    def speakers(self) -> Sequence[str]:
        return (self.name,)

    @property
    def language(self) -> Language:
        return "en"

    def say(self, text: str, pace: float) -> Sound:
        with tempfile.NamedTemporaryFile(suffix=".wav") as file:  # it cannot write a WAV to a pipe
            command = ["flite", "-voice", self.speaker, "--setf", f"duration_stretch={1 / pace:.2f}", "-t", text]
            output([*command, "-o", file.name])
            return decoded(Path(file.name).read_bytes())


@dataclass(frozen=True, slots=True)
class Piper:
    """A voice of piper, which is under the GPL and stays a process of its own."""

    model: Path

    @property
    def name(self) -> str:
        return f"piper:{self.model.stem}"

    @property
    def speakers(self) -> Sequence[str]:
        return (self.name,)

    @property
    def language(self) -> Language:
        return "zh" if self.model.stem.startswith("zh") else "en"

    def say(self, text: str, pace: float) -> Sound:
        with tempfile.NamedTemporaryFile(suffix=".wav") as file:
            command = [sys.executable, "-m", "piper", "-m", str(self.model), "-f", file.name]
            output([*command, "--length-scale", f"{1 / pace:.2f}", "--", text])
            return decoded(Path(file.name).read_bytes())


class Kokoro:
    """The model behind all voices of Kokoro; loaded when the first of them speaks."""

    RATE: Final = 24_000

    def __init__(self, folder: Path) -> None:
        """``folder`` holds model.onnx and vocab.json."""
        self._folder = folder

    @cached_property
    def _session(self) -> Any:
        import onnxruntime

        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = max(1, (os.cpu_count() or 1) // 2)
        options.add_session_config_entry("session.intra_op.allow_spinning", "0")  # others need the processor
        return onnxruntime.InferenceSession(
            str(self._folder / "model.onnx"), options, providers=["CPUExecutionProvider"]
        )

    @cached_property
    def _tokens(self) -> Mapping[str, int]:
        return dict(json.loads((self._folder / "vocab.json").read_text(encoding="utf-8"))["vocab"])

    def say(self, phonemes: str, style: NDArray[np.float32], pace: float) -> Sound:
        tokens = [self._tokens[sign] for sign in phonemes if sign in self._tokens][:500]
        inputs = {
            "tokens": np.array([[0, *tokens, 0]], np.int64),
            "style": style[min(len(tokens), len(style)) - 1].reshape(1, 256),
            "speed": np.array([pace], np.float32),
        }
        sound = np.asarray(self._session.run(None, inputs)[0], np.float32).ravel()
        return np.asarray(soxr.resample(sound, self.RATE, RATE), np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class KokoroVoice:
    """One style of Kokoro, reading the phonemes of eSpeak NG."""

    model: Kokoro
    speaker: str
    style: NDArray[np.float32]  # (phonemes, 256)
    language: Language = "en"

    @property
    def name(self) -> str:
        return f"kokoro:{self.speaker}" if self.language == "en" else f"kokoro:{self.language}/{self.speaker}"

    @property
    def speakers(self) -> Sequence[str]:
        return tuple(f"kokoro:{speaker}" for speaker in self.speaker.split(_MIX))

    def say(self, text: str, pace: float) -> Sound:
        if self.language == "zh":
            named = output(["espeak-ng", "-q", "-x", "-v", mandarin.VOICE, "--", text])
            ending = {"！": "!", "？": "?", "，": ","}.get(text[-1:], ".")
            return self.model.say(mandarin.signs(named.decode("utf-8", "replace")) + ending, self.style, pace)
        accent = "en-gb" if self.speaker.startswith("b") else "en-us"
        return self.model.say(phonemes(text, accent), self.style, pace)


class Remembered:
    """Voices whose words are kept in a folder, so that the next head is made faster."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def say(self, voice: Voice, text: str, pace: float) -> Sound:
        key = hashlib.sha256(f"{voice.name}\n{pace:.2f}\n{text}".encode()).hexdigest()[:32]
        file = self._folder / f"{key}.npy"
        if (kept := _kept(file)) is not None:
            return kept
        sound = trimmed(voice.say(text, pace))
        partial = file.with_suffix(".partial")
        with suppress(OSError):  # a full disk: it is only made again
            self._folder.mkdir(parents=True, exist_ok=True)
            try:
                with partial.open("wb") as stream:
                    np.save(stream, (sound * 32767).astype(np.int16))
                partial.replace(file)
            finally:
                partial.unlink(missing_ok=True)
        return sound


def _kept(file: Path) -> Sound | None:
    """What a file holds; None where it is not there or not whole."""
    try:
        kept = np.load(file, allow_pickle=False)
    except Exception:  # noqa: BLE001 - what is damaged fails in many ways, and is only made again
        return None
    if not isinstance(kept, np.ndarray) or kept.ndim != 1 or kept.dtype != np.int16 or not kept.any():
        return None
    return np.asarray(kept / np.float32(32767), np.float32)


def phonemes(text: str, accent: str) -> str:
    """How a text is said, in IPA, on one line."""
    command = ["espeak-ng", "-q", "--ipa", "-v", accent, "--", text]
    return " ".join(output(command).decode("utf-8", "replace").split())


def find_voices(
    kokoro: Path | None, styles: Sequence[Path], piper: Sequence[Path], language: Language = "en"
) -> list[Voice]:
    """Every voice of a language there is. ``kokoro`` is the folder of its model, ``styles`` are files of its styles
    (.bin, or .npz with several), ``piper`` are models of piper."""
    accents = _ACCENTS if language == "en" else (mandarin.VOICE,)
    voices: list[Voice] = []
    if shutil.which("espeak-ng"):
        voices += [
            Espeak(accents[index % len(accents)], variant, 30 + 7 * index % 45)
            for index, variant in enumerate(_VARIANTS)
        ]
        if kokoro is not None:
            model = Kokoro(kokoro)
            spoken = {name: style for file in styles for name, style in _styles(file).items()}
            native = {name: style for name, style in spoken.items() if name.startswith("z")}
            found = native if language == "zh" and native else _with_mixed(spoken)
            voices += [KokoroVoice(model, name, style, language) for name, style in found.items()]
    if shutil.which("flite") and language == "en":
        voices += [Flite(speaker) for speaker in _FLITE]
    return [*voices, *(voice for voice in map(Piper, piper) if voice.language == language)]


def trimmed(sound: Sound) -> Sound:
    """From where it begins to where it ends, at a peak of 0.5."""
    peak = float(np.abs(sound).max(initial=0.0))
    if peak <= 1e-4:
        raise ModelError("A synthetic voice said nothing.", hint="Is espeak-ng installed with its data?")
    loud = np.flatnonzero(np.abs(sound) > 0.03 * peak)
    return np.asarray(sound[loud[0] : loud[-1] + 1] * (0.5 / peak), np.float32)


def _styles(file: Path) -> dict[str, NDArray[np.float32]]:
    if file.suffix == ".npz":
        with np.load(file, allow_pickle=False) as several:
            return {name: several[name].astype(np.float32).reshape(-1, 256) for name in several.files}
    return {file.stem: np.fromfile(file, np.float32).reshape(-1, 256)}


def _with_mixed(styles: dict[str, NDArray[np.float32]]) -> dict[str, NDArray[np.float32]]:
    """With few styles, mixtures of two are voices as well."""
    names, mixed = sorted(styles), dict(styles)
    pairs = [(a, b) for index, a in enumerate(names) for b in names[index + 1 :]]
    for a, b in pairs[: _MIXED if len(names) < _MIXED else 0]:
        mixed[f"{a}{_MIX}{b}"] = np.asarray((styles[a] + styles[b]) / 2, np.float32)
    return mixed
