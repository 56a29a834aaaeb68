"""How soon the end of an utterance is noticed, and how often it is noticed too early.

Every clean recording is followed by silence, and given kitchen noise in several strengths; the delay is from the true
end of the voice to the decision. A *cut-off* is an end before the voice has ended, a *miss* an utterance that did not
start, or ended only at its greatest length. Joined recordings with a pause of 0.25–0.45 s between them show whether a
hesitation is cut off.

Then the same with the recogniser, as the engine listens: see ``tests.bench.turns``.
"""

from __future__ import annotations

import argparse
import asyncio
import time
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from config import load
from engine.audio.endpoint import Ended, Endpointer, Started
from engine.audio.source import FRAME_S, RATE, Samples
from engine.audio.vad import VoiceActivity, make_vad
from engine.parts.loading import at_home
from tests.bench import turns
from tests.bench.report import Report, figures, print_report, report
from tests.bench.speech import clips, frames, mixed, noise, silence, speech_bounds

LEAD_S, TAIL_S = 0.8, 3.0
LOUDNESS: tuple[float | None, ...] = (None, 10.0, 5.0, 0.0)


@dataclass
class Cell:
    """What happened to the recordings of one kind."""

    delays: list[float] = field(default_factory=list)
    n: int = 0
    early: int = 0
    missed: int = 0
    false_starts: int = 0


def utterances() -> Iterator[tuple[str, Samples, float, float]]:
    """Clean sounds: their kind, with lead and tail, and when the voice begins and ends."""
    clean = [clip.samples for clip in clips() if clip.snr_db is None]
    for samples in clean:
        begin, end = speech_bounds(samples)
        yield "single", np.concatenate((silence(LEAD_S), samples, silence(TAIL_S))), LEAD_S + begin, LEAD_S + end
    random = np.random.default_rng(7)
    for first, second in zip(clean[::2], clean[1::2], strict=False):
        pause = float(random.uniform(0.25, 0.45))
        a, b = speech_bounds(first), speech_bounds(second)
        voice = np.concatenate(
            (
                first[: round(a[1] * RATE)],
                silence(pause),
                second[round(b[0] * RATE) :],
            )
        )
        _, end = speech_bounds(voice)
        yield "joined", np.concatenate((silence(LEAD_S), voice, silence(TAIL_S))), LEAD_S + a[0], LEAD_S + end


def run(
    json: bool,
    backend: str = "auto",
    overrides: tuple[str, ...] = (),
    *,
    words: bool = True,
    kinds: tuple[str, ...] = turns.KINDS,
    loudness: tuple[float | None, ...] = turns.LOUDNESS,
) -> Report:
    """Measure with the settings in force, ``overrides``, and the given ``vad.backend``; without ``words``, without the
    recogniser. ``kinds`` and ``loudness`` (None: clean): of the turns with it."""
    settings = load(overrides=overrides)
    vad = make_vad(settings.vad.model_copy(update={"backend": backend}))
    cells: dict[str, Cell] = {}
    costs: list[float] = []
    sounds = list(utterances())
    for index, (kind, clean, begin, end) in enumerate(sounds):
        for snr in LOUDNESS:
            cell = cells.setdefault(f"{kind} {'clean' if snr is None else f'{snr:.0f} dB'}", Cell())
            sound = clean if snr is None else mixed(clean, noise(len(clean) / RATE, index), snr)
            cell.n += 1
            began = time.perf_counter()
            started, ended, decided = _listen(vad, Endpointer(settings.endpoint), sound)
            costs.append((time.perf_counter() - began) / (decided / FRAME_S) * 1000)
            if started is not None and started < begin - 0.25:
                cell.false_starts += 1
            elif ended is None or ended.utterance is None or ended.reason != "silence":
                cell.missed += 1
            elif decided < end:
                cell.early += 1
            else:
                cell.delays.append(decided - end)
    found = {f"delay, {name}": figures(cell.delays, "s") for name, cell in cells.items() if cell.delays}
    found["cost of a frame"] = figures(costs, "ms")
    ratios = {}
    for name, cell in cells.items():
        ratios[f"cut off early, {name}"] = cell.early / cell.n
        ratios[f"missed, {name}"] = cell.missed / cell.n
        ratios[f"started by noise, {name}"] = cell.false_starts / cell.n
    if words:
        more_found, more_ratios = turns.as_figures(asyncio.run(turns.measure(at_home(settings), loudness, kinds)))
        found, ratios = found | more_found, ratios | more_ratios
    result = report(f"endpoint ({vad.name})", len(sounds) * len(LOUDNESS), found, ratios)
    print_report(result, json)
    return result


def _listen(vad: VoiceActivity, endpointer: Endpointer, sound: Samples) -> tuple[float | None, Ended | None, float]:
    """When speech started, how it ended, and when that was decided (stream time, s)."""
    vad.reset()
    started = None
    at = 0.0
    for frame in frames(sound):
        at = frame.end
        found = endpointer.push(frame, vad.process(frame))
        if isinstance(found, Started):
            started = found.at
        elif found is not None:
            return started, found, at
    return started, None, at


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench endpoint", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--vad", choices=("auto", "silero", "webrtc"), default="auto", help="detector to measure")
    parser.add_argument("--without-words", action="store_true", help="only voice activity: quick")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a setting, e.g. asr.threads=2")
    parser.add_argument("--kind", choices=turns.KINDS, action="append", help="of turns with words; all otherwise")
    parser.add_argument(
        "--loudness", action="append", metavar="DB", help="of turns with words, or clean; all otherwise"
    )
    args = parser.parse_args(argv)
    loudness = turns.LOUDNESS
    if args.loudness:
        loudness = tuple(None if level == "clean" else float(level) for level in args.loudness)
    kinds = tuple(args.kind or turns.KINDS)
    run(args.json, args.vad, tuple(args.set), words=not args.without_words, kinds=kinds, loudness=loudness)


if __name__ == "__main__":
    main()
