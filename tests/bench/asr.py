"""How well and how fast speech is recognised, and whether noise and silence stay what they are.

Word errors are counted over all recordings; a rejected one counts as if nothing had been written. *Not speech* (kitchen
noise, silence, white noise, hum) goes the whole way, through voice activity, endpointing and the recogniser's gates,
and also straight into the recogniser; none of it may come out as a transcript.

With ``--snr`` only words are counted: of the clean recordings, said in the noise of a kitchen or a fan, of which as
much is taken away as the settings say (``--set audio.noise_suppression=low``).
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from config import load
from config.schema import Settings
from engine.asr.recogniser import Recogniser, Transcript
from engine.audio.denoise import NoiseSuppressor, usable
from engine.audio.endpoint import Ended, Endpointer, Utterance
from engine.audio.source import RATE, Samples
from engine.audio.vad import VoiceActivity, make_vad
from engine.errors import SaysoError
from engine.parts.loading import make_recogniser, vocabulary
from tests.bench.report import Figure, Report, figures, print_report, report
from tests.bench.speech import Clip, clips, frames, hum, mixed, noise, silence
from tests.bench.wer import errors, normalised

SHORT_S = (2.0, 3.0)
"""Clips whose decoding time is compared between the windows, s."""


BACKGROUNDS: Final = {"kitchen": noise, "fan": hum}
LEAD_S = 2.0
"""What is heard of a noise before somebody speaks, s, so that whatever suppresses it knows it…"""
PRE_ROLL_S = 0.3
"""…and how much of that is recognised as well."""


def run(json: bool, overrides: tuple[str, ...] = (), *, snr_db: float | None = None, noises: str = "kitchen") -> Report:
    """Measure with the settings in force and ``overrides`` (``asr.threads=2``); with ``snr_db`` in one of the
    ``BACKGROUNDS``."""
    settings = load(overrides=overrides)
    nouns = vocabulary(settings)
    recogniser = make_recogniser(settings)
    recogniser.load()
    recordings = clips()
    if snr_db is not None:
        clean = (clip for clip in recordings if clip.snr_db is None)
        recordings = [_said_in(settings, clip, noises, snr_db, seed) for seed, clip in enumerate(clean)]
    found, ratios = _accuracy(recogniser, recordings, nouns)
    if snr_db is None:
        found |= (windows := _windows(settings, recogniser, recordings, nouns))
        short, full = (figure["median"] for figure in windows.values())
        ratios["30 s window / short window"] = full / short
        ratios |= _not_speech(settings, recogniser, nouns)
    result = report(f"asr ({recogniser.name})", len(recordings), found, ratios)
    print_report(result, json)
    return result


def _said_in(settings: Settings, clip: Clip, noises: str, snr_db: float, seed: int) -> Clip:
    """The recording in a noise, less what is taken out of that."""
    speech = np.concatenate((silence(LEAD_S), clip.samples, silence(PRE_ROLL_S)))
    sound = mixed(speech, np.resize(BACKGROUNDS[noises](len(speech) / RATE, seed), len(speech)), snr_db)
    suppressor = NoiseSuppressor(usable(settings.audio.noise_suppression, _refuse))
    heard = np.concatenate([suppressor.apply(frame).samples for frame in frames(sound)])
    return replace(clip, samples=heard[round((LEAD_S - PRE_ROLL_S) * RATE) :], snr_db=snr_db)


def _refuse(words: str) -> None:
    raise SaysoError(words)


def _accuracy(
    recogniser: Recogniser, recordings: list[Clip], nouns: tuple[str, ...]
) -> tuple[dict[str, Figure], dict[str, float]]:
    wrong: dict[str, int] = defaultdict(int)
    words: dict[str, int] = defaultdict(int)
    logprobs, no_speech, times = [], [], []
    rejected = exact = 0
    for clip in recordings:
        answer = recogniser.transcribe(_float(clip.samples), nouns)
        reference = normalised(clip.text)
        mistakes = errors(reference, normalised(answer.text) if isinstance(answer, Transcript) else [])
        rejected += not isinstance(answer, Transcript)
        exact += mistakes == 0
        for group in ("all", f"{clip.voice}, {'clean' if clip.snr_db is None else f'{clip.snr_db:.0f} dB'}"):
            wrong[group] += mistakes
            words[group] += len(reference)
        if answer.decoding is not None:
            logprobs.append(answer.decoding.avg_logprob)
            no_speech.append(answer.decoding.no_speech_probability)
            times.append(answer.decoding.decode_s / answer.decoding.audio_s)
    found = {
        "mean log-probability of speech": figures(logprobs, "nat"),
        "no-speech probability of speech": figures(no_speech, "1"),
        "decoding time per second of sound": figures(times, "s/s"),
    }
    ratios = {f"word error rate, {group}": wrong[group] / words[group] for group in words}
    ratios["recordings without an error"] = exact / len(recordings)
    ratios["recordings rejected"] = rejected / len(recordings)
    return found, ratios


def _windows(
    settings: Settings, recogniser: Recogniser, recordings: list[Clip], nouns: tuple[str, ...]
) -> dict[str, Figure]:
    short = [clip for clip in recordings if SHORT_S[0] <= len(clip.samples) / RATE <= SHORT_S[1]]
    full = make_recogniser(_with_full_window(settings))
    full.load()
    return {
        f"decode of 2–3 s, {settings.asr.window_s:g} s window": _latency(recogniser, short, nouns),
        "decode of 2–3 s, 30 s window": _latency(full, short, nouns),
    }


def _latency(recogniser: Recogniser, short: list[Clip], nouns: tuple[str, ...]) -> Figure:
    answers = [recogniser.transcribe(_float(clip.samples), nouns) for clip in short]
    return figures([answer.decoding.decode_s for answer in answers if answer.decoding is not None], "s")


def _not_speech(settings: Settings, recogniser: Recogniser, nouns: tuple[str, ...]) -> dict[str, float]:
    vad = make_vad(settings.vad)
    passed = straight = total = started = 0
    for sound in _noises():
        total += 1
        straight += isinstance(recogniser.transcribe(_float(sound), nouns), Transcript)
        for utterance in _utterances(vad, settings, sound):
            started += 1
            passed += isinstance(recogniser.transcribe(_float(utterance.samples), nouns), Transcript)
    return {
        "not speech: clips": total,
        "not speech: utterances that voice activity found": started,
        "not speech: accepted in the whole chain": passed,
        "not speech: accepted by the recogniser alone": straight,
    }


def _noises() -> Iterator[Samples]:
    """Sound in which nobody speaks, in lengths from 1 to 25 s."""
    random = np.random.default_rng(3)
    yield noise(25, 0)
    for index in range(20):
        yield noise(float(random.uniform(1, 5)), index)
    for seconds in (0.5, 1.0, 3.0):
        yield np.zeros(round(seconds * RATE), np.int16)
        yield silence(seconds)
    for decibels in (-60, -40, -30, -20):
        white = random.normal(0, 32768 * 10 ** (decibels / 20), 3 * RATE)
        yield np.clip(white, -32768, 32767).astype(np.int16)
    time = np.arange(3 * RATE) / RATE
    yield (3000 * np.sin(2 * np.pi * 50 * time)).astype(np.int16)
    yield (9000 * np.sin(2 * np.pi * 880 * time) * (time % 1 < 0.3)).astype(np.int16)


def _utterances(vad: VoiceActivity, settings: Settings, sound: Samples) -> Iterator[Utterance]:
    vad.reset()
    endpointer = Endpointer(settings.endpoint)
    for frame in frames(sound):
        found = endpointer.push(frame, vad.process(frame))
        if isinstance(found, Ended):
            if found.utterance is not None:
                yield found.utterance
            endpointer = Endpointer(settings.endpoint)
    if (last := endpointer.finish().utterance) is not None:
        yield last


def _float(samples: Samples) -> np.ndarray[tuple[int], np.dtype[np.float32]]:
    return samples.astype(np.float32) / np.float32(32768)


def _with_full_window(settings: Settings) -> Settings:
    return settings.model_copy(update={"asr": settings.asr.model_copy(update={"window_s": 30.0})})


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench asr", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a setting, e.g. asr.threads=2")
    parser.add_argument("--snr", type=float, metavar="DB", help="the clean recordings, in a noise that is so loud")
    parser.add_argument("--noise", choices=BACKGROUNDS, default="kitchen", help="which; default: kitchen")
    args = parser.parse_args(argv)
    run(args.json, tuple(args.set), snr_db=args.snr, noises=args.noise)


if __name__ == "__main__":
    main()
