"""``sayso transcribe``: the words in recordings, without a robot."""

from __future__ import annotations

import asyncio
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from config.schema import Settings
from engine.asr.recogniser import Rejected
from engine.asr.whole import Stretch, WholeRecogniser
from engine.audio.denoise import NoiseSuppressor, usable
from engine.audio.gain import Gain
from engine.audio.vad import make_vad
from engine.audio.wav import WavSource
from engine.errors import ExitCode, SaysoError
from engine.parts.loading import make_recogniser, vocabulary
from tui.commands.settings import load_settings
from tui.output import data, json_line, say

NEAR_S: Final = 0.5
"""A voice so close to a stretch may be that of its words: recognisers are not exact about times, s."""


def run(arguments: Namespace) -> int:
    """One line (or JSON object) a file. Exit code of the first file that could not be read or held no words."""
    settings = load_settings(arguments)
    recogniser = make_recogniser(settings)
    code = int(ExitCode.DONE)
    for name in arguments.files:
        try:
            found = _transcribe(Path(name), recogniser, settings)
        except SaysoError as error:
            found = {"file": name, "error": str(error)}
            say(f"sayso: {error}")
            code = code or int(error.exit_code)
        else:
            for warning in found["warnings"]:
                say(f"sayso: {warning}")
            if not found["text"]:
                say(f"sayso: no speech was found in {name}.")
                code = code or int(ExitCode.FAILED)
        if arguments.json:
            json_line(found)
        elif found.get("text"):
            data(f"{name}: {found['text']}" if len(arguments.files) > 1 else str(found["text"]))
    return code


@dataclass(frozen=True, slots=True)
class _Recording:
    """What is in a file."""

    samples: NDArray[np.float32]  # 16 kHz, ±1
    spoken: NDArray[np.float64]  # where there is a voice, s from the beginning, in order
    warnings: tuple[str, ...]

    def is_spoken(self, stretch: Stretch) -> bool:
        first, last = np.searchsorted(self.spoken, (stretch.start - NEAR_S, stretch.end + NEAR_S))
        return bool(last > first)


def _transcribe(path: Path, recogniser: WholeRecogniser, settings: Settings) -> dict[str, Any]:
    """What is said in one file. Where no voice is, nothing is said, whatever the recogniser writes. Raises
    ``SaysoError``."""
    recording = asyncio.run(_recording(path, settings))
    stretches = recogniser.stretches(recording.samples, vocabulary(settings)) if len(recording.spoken) else ()
    utterances = [_described(stretch, heard=recording.is_spoken(stretch)) for stretch in stretches]
    text = " ".join(utterance["text"] for utterance in utterances if utterance["accepted"])
    return {"file": str(path), "text": text, "utterances": utterances, "warnings": list(recording.warnings)}


async def _recording(path: Path, settings: Settings) -> _Recording:
    suppressor = NoiseSuppressor(usable(settings.audio.noise_suppression, say))
    gain, voice = Gain(settings.audio.gain_db), make_vad(settings.vad)
    frames: list[NDArray[np.int16]] = []
    spoken: list[float] = []
    async with WavSource(path, pace="fast") as source:
        async for frame in source:
            plain = gain.apply(suppressor.apply(frame))
            frames.append(plain.samples)
            if voice.process(plain).speech:
                spoken.append(plain.end)
        warnings: Sequence[str] = source.warnings
    samples = np.concatenate(frames) * np.float32(1 / 32768) if frames else np.zeros(0, np.float32)
    return _Recording(samples, np.array(spoken), tuple(warnings))


def _described(stretch: Stretch, *, heard: bool) -> dict[str, Any]:
    found, decoding = stretch.found, stretch.found.decoding
    described = {"start_s": round(stretch.start, 2), "end_s": round(stretch.end, 2), "text": found.text}
    if isinstance(found, Rejected):
        return described | {"accepted": False, "reason": found.reason, "detail": found.detail}
    if not heard:
        return described | {"accepted": False, "reason": "no_speech", "detail": "There is no voice."}
    assert decoding is not None
    return described | {
        "accepted": True,
        "language": decoding.language,
        "confidence": found.confidence,
        "avg_logprob": decoding.avg_logprob,
        "no_speech_probability": decoding.no_speech_probability,
        "decode_s": decoding.decode_s,
    }
