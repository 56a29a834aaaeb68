"""``sayso transcribe``: the words in recordings, without a robot."""

from __future__ import annotations

import asyncio
from argparse import Namespace
from pathlib import Path
from typing import Any

from config.schema import Settings
from engine.asr.recogniser import Recogniser
from engine.audio.denoise import usable
from engine.audio.endpoint import Utterance
from engine.audio.vad import make_vad
from engine.audio.wav import WavSource
from engine.bus import Bus
from engine.clock import SystemClock
from engine.errors import ExitCode, SaysoError
from engine.events import TranscriptFinal, TranscriptRejected
from engine.hearing.hearing import Hearing
from engine.parts.loading import make_recogniser, vocabulary
from tui.commands.settings import load_settings
from tui.output import data, json_line, say


def run(arguments: Namespace) -> int:
    """One line (or JSON object) a file. Exit code of the first file that could not be read or held no words."""
    settings = load_settings(arguments)
    recogniser = make_recogniser(settings)
    code = int(ExitCode.DONE)
    for name in arguments.files:
        try:
            found = asyncio.run(_transcribe(Path(name), recogniser, settings))
        except SaysoError as error:
            found = {"file": name, "error": str(error)}
            say(f"sayso: {error}")
            code = code or int(error.exit_code)
        else:
            code = code or int(ExitCode.DONE if found["text"] else ExitCode.FAILED)
        if arguments.json:
            json_line(found)
        elif "text" in found:
            data(f"{name}: {found['text']}" if len(arguments.files) > 1 else str(found["text"]))
    return code


async def _transcribe(path: Path, recogniser: Recogniser, settings: Settings) -> dict[str, Any]:
    """Every utterance of one file, cut where the speaker pauses."""
    emit = Bus(SystemClock()).bound(turn=None, epoch=0)
    utterances: list[dict[str, Any]] = []
    hearing = Hearing(
        lambda: WavSource(path, pace="fast"),
        make_vad(settings.vad),
        settings.endpoint,
        recogniser,
        vocabulary=vocabulary(settings),
        suppression=usable(settings.audio.noise_suppression, say),
        gain_db=settings.audio.gain_db,
    )
    async with hearing:
        while True:
            heard = await hearing.listen(emit)
            if isinstance(heard, Utterance):
                answer = await hearing.transcribe(heard, emit)
                utterances.append(_described(heard, answer))
            elif heard.reason == "source_ended":
                break
        warnings = list(hearing.warnings)
    text = " ".join(utterance["text"] for utterance in utterances if utterance["accepted"])
    return {"file": str(path), "text": text, "utterances": utterances, "warnings": warnings}


def _described(heard: Utterance, answer: TranscriptFinal | TranscriptRejected) -> dict[str, Any]:
    described = {"start_s": round(heard.start, 2), "end_s": round(heard.end, 2), "text": answer.text}
    if isinstance(answer, TranscriptRejected):
        return described | {"accepted": False, "reason": answer.reason, "detail": answer.detail}
    return described | {
        "accepted": True,
        "language": answer.language,
        "confidence": answer.confidence,
        "avg_logprob": answer.avg_logprob,
        "no_speech_probability": answer.no_speech_probability,
        "decode_s": answer.decode_s,
    }
