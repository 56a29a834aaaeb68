"""How often a known command becomes another one or none, and how many commands are made of what is none.

*Known*: the recordings that are plain commands, and the commands below in synthetic voices, each clean and in kitchen
noise. They are listened to as the engine does it (see ``tests.bench.listening``), and planned without large models.
*Wrong* is another plan than that of the words: the robot would do something else. *Not understood* is no plan: it would
ask, or say so.

*No commands*: a kitchen's noise in several strengths, music, other talk (sentences of everyday life, and everyday words
in no order, by several voices), and mixtures (talk in the noise of a kitchen, and over music), listened to for
``--minutes`` each by somebody who has been woken again as soon as a turn has ended. Every plan with an action in it is
*invented*, and is printed with what was heard; one that only stops the robot is a *false stop*, of which an hour of
other speech may have one.
"""

from __future__ import annotations

import argparse
import asyncio
import random
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from config import load, paths
from engine.asr.transcription import Found
from engine.audio.source import FRAME_S, RATE, Frame, Samples
from engine.errors import SaysoError
from engine.parts.loading import at_home, model_store
from engine.wake.training.texts import COMMANDS, SENTENCES, rambling
from engine.wake.training.voices import Espeak, Flite, Piper, Remembered, Voice, find_voices
from tests.bench.listening import Clockwork, Ears, planned
from tests.bench.report import Report, figures, print_report, report
from tests.bench.speech import clips, frames, mixed, noise, silence
from tests.bench.turns import LEAD_S, TAIL_S

LOUDNESS: tuple[float | None, ...] = (None, 10.0)
PASS_S = 0.25
"""What a pass takes; here it only matters that it takes something."""
NOTHING = ("noise", "music", "talk", "mixed")
LOUD = (300.0, 1000.0, 3000.0)
"""Root of the mean square of noise and music: from hardly heard to as loud as somebody near."""
SCALE = 2 ** (np.array([0, 2, 4, 7, 9, 12, 14, 16]) / 12)
OTHER_TALK = tuple(text for text in SENTENCES if not text.startswith(("Turn the music", "Never mind")))
"""Sentences that ask nothing of anybody who could be a robot."""
RAMBLINGS = 400
"""So many more of everyday words in no order, among them many that commands are made of."""


def run(
    json: bool,
    minutes: float,
    voices: int,
    overrides: tuple[str, ...] = (),
    *,
    loudness: Sequence[float | None] = LOUDNESS,
    nothing: Sequence[str] = NOTHING,
) -> Report:
    """Measure with the settings in force: known commands in each ``loudness`` (None: clean), and ``nothing``."""
    return asyncio.run(_run(json, minutes, voices, overrides, loudness, nothing))


async def _run(
    json: bool,
    minutes: float,
    voices: int,
    overrides: tuple[str, ...],
    loudness: Sequence[float | None],
    nothing: Sequence[str],
) -> Report:
    ears = Ears.of(at_home(load(overrides=overrides)))
    remembered = Remembered(paths().cache / "wake")
    speakers = _speakers()
    ratios: dict[str, float] = {}
    known = [(clip.text, clip.samples) for clip in clips() if clip.snr_db is None]
    for voice in speakers[:voices]:
        known += [(text, _int16(remembered.say(voice, text, 1.0))) for text in COMMANDS]
    known = [(text, sound) for text, sound in known if ears.planner.completeness(text) == "complete"]
    for snr in loudness:
        name = "clean" if snr is None else f"{snr:.0f} dB"
        _tell(f"{len(known)} known commands, {name}…")
        for what, count in (await _known(ears, known, snr)).items():
            ratios[f"{what}, {name}"] = count / len(known)
    lengths = []
    for name in nothing if minutes else ():
        _tell(f"{minutes:g} min of {name}…")
        sound = _no_command(name, minutes, _said_to_others(remembered, [*speakers, *_others()]))
        tally, seconds = await _nothing(ears, sound)
        lengths.append(seconds / 60)
        ratios |= {f"{what}, {name}": count for what, count in tally.items()}
    found = {"no commands": figures(lengths, "min")} if lengths else {}
    result = report(f"commands ({ears.recogniser.name})", len(known), found, ratios)
    print_report(result, json)
    return result


async def _known(ears: Ears, known: list[tuple[str, Samples]], snr: float | None) -> Counter[str]:
    tally: Counter[str] = Counter({"wrong": 0, "not understood": 0})
    for index, (text, voice) in enumerate(known):
        clean = np.concatenate((silence(LEAD_S), voice, silence(TAIL_S)))
        sound = clean if snr is None else mixed(clean, noise(len(clean) / RATE, index), snr)
        heard = (await ears.listen(Clockwork(_cost), frames(sound))).text
        wanted, found = await planned(ears.planner, text), await planned(ears.planner, heard)
        if found != wanted:
            tally["wrong" if found else "not understood"] += 1
            _tell(f"{'clean' if snr is None else snr} {text!r} was heard as {heard!r}: {', '.join(map(str, found))}")
    return tally


async def _nothing(ears: Ears, sound: Iterator[Samples]) -> tuple[Counter[str], float]:
    """Turns that led to a transcript, to a plan, or to a stop, and how long it was listened, s."""
    transcripts, invented, stops = "turns with a transcript", "commands invented", "false stops"
    tally: Counter[str] = Counter({transcripts: 0, invented: 0, stops: 0})
    at = 0.0
    for piece in sound:
        stream = iter(frames(piece))
        clock, left = Clockwork(_cost), round(len(piece) / RATE / FRAME_S)
        while left > 0:
            counted = _Counted(stream)
            text = (await ears.listen(clock, counted)).text
            left -= max(1, counted.count)
            tally[transcripts] += bool(text)
            if text and (found := await planned(ears.planner, text)):
                actions = [*map(str, found)]
                tally[stops if set(actions) == {"stop()"} else invented] += 1
                _tell(f"{at:.0f} s: invented {', '.join(actions)} from {text!r}")
        at += len(piece) / RATE
    return tally, at


class _Counted:
    """Frames, and how many of them were taken."""

    def __init__(self, frames: Iterator[Frame]) -> None:
        self.count = 0
        self._frames = frames

    def __iter__(self) -> Iterator[Frame]:
        for frame in self._frames:
            self.count += 1
            yield frame


def _cost(found: Found) -> float:
    return 0.0 if isinstance(found, SaysoError) or found.decoding is None else PASS_S


def _speakers() -> list[Voice]:
    """Those that take little time to speak."""
    joe = model_store(load()).folder / "piper-joe" / "en_US-joe-medium.onnx"
    voices = find_voices(None, (), ())
    quick: list[Voice] = [Piper(joe)] if joe.exists() else []
    quick += [voice for voice in voices if isinstance(voice, Flite) and voice.speaker != "kal16"]
    return quick or voices[:4]


def _others() -> Sequence[Voice]:
    """More voices, for those who talk to others."""
    return [voice for voice in find_voices(None, (), ()) if isinstance(voice, Espeak)][::8]


def _kitchen(minutes: float) -> Iterator[Samples]:
    """Noise of a kitchen, half a minute each, in several strengths."""
    for index in range(round(2 * minutes)):
        yield _as_loud(noise(30, index), LOUD[index % len(LOUD)])


def _music(minutes: float) -> Iterator[Samples]:
    """A tune over chords and a beat, half a minute each."""
    for index in range(round(2 * minutes)):
        yield _as_loud(_tune(index), LOUD[index % len(LOUD)])


def _no_command(name: str, minutes: float, talk: Iterable[Samples]) -> Iterator[Samples]:
    """Sound that holds no command."""
    match name:
        case "noise":
            return _kitchen(minutes)
        case "music":
            return _music(minutes)
        case "talk":
            return _talk(talk, minutes)
    return _mixtures(_talk(talk, minutes))


def _mixtures(talk: Iterator[Samples]) -> Iterator[Samples]:
    """Talk in noise, and over music, from well understood to hardly."""
    for index, voices in enumerate(talk):
        seconds = len(voices) / RATE
        behind = noise(seconds, index) if index % 2 else np.resize(_tune(index), len(voices))
        yield mixed(voices, behind, (15.0, 10.0, 5.0)[index % 3])


def _said_to_others(remembered: Remembered, speakers: Sequence[Voice]) -> Iterator[Samples]:
    """Each sentence by another voice, until all voices have said all."""
    texts = (*OTHER_TALK, *rambling(RAMBLINGS, random.Random(3)))
    for turn, _ in enumerate(speakers):
        for index, text in enumerate(texts):
            yield _int16(remembered.say(speakers[(index + turn) % len(speakers)], text, 1.0))


def _talk(sentences: Iterable[Samples], minutes: float) -> Iterator[Samples]:
    """People who talk to others: one sentence after the other, with pauses of 0.2–1.5 s."""
    chance = np.random.default_rng(11)
    left, piece = minutes * 60 * RATE, [silence(LEAD_S)]
    for sentence in sentences:
        piece += [sentence, silence(float(chance.uniform(0.2, 1.5)))]
        length = sum(map(len, piece))
        if length >= min(left, 30 * RATE):
            yield np.concatenate(piece)
            left, piece = left - length, [silence(LEAD_S)]
        if left <= 0:
            return


def _tune(seed: int) -> Samples:
    chance = np.random.default_rng(seed)
    beat = float(chance.uniform(0.25, 0.5))
    time = np.arange(round(30 * RATE)) / RATE
    sound = np.zeros(len(time))
    root = float(chance.uniform(110, 220))
    for start in np.arange(0, 30 - 2 * beat, beat):
        length = beat * float(chance.choice((1, 1, 2)))
        part = slice(round(start * RATE), round((start + length) * RATE))
        note = time[part] - start
        pitches = [(2 * root * float(chance.choice(SCALE)), 1.0)]
        pitches += [(root * float(step), 0.4) for step in SCALE[[0, 2, 3]]]
        for pitch, level in pitches:
            for overtone in range(1, 6):
                sound[part] += level / overtone**1.5 * np.sin(2 * np.pi * pitch * overtone * note) * np.exp(-3 * note)
        drum = slice(part.start, part.start + round(0.05 * RATE))
        sound[drum] += chance.normal(0, 0.8, drum.stop - drum.start)
    return (sound * 8000).clip(-32768, 32767).astype(np.int16)


def _as_loud(sound: Samples, level: float) -> Samples:
    scaled = sound * (level / np.sqrt(np.mean(sound.astype(np.float64) ** 2)))
    quieter: Samples = np.clip(scaled, -32768, 32767).astype(np.int16)
    return quieter


def _int16(sound: np.ndarray[tuple[int], np.dtype[np.float32]]) -> Samples:
    return (sound * 32767).astype(np.int16)


def _tell(line: str) -> None:
    sys.stderr.write(line + "\n")
    sys.stderr.flush()


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench commands", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument(
        "--minutes", type=float, default=20.0, help="of noise, of music, of talk, and of mixtures; 0: none"
    )
    parser.add_argument("--voices", type=int, default=3, help="synthetic ones that say commands")
    parser.add_argument("--loudness", action="append", metavar="DB", help="of known commands, or clean; both otherwise")
    parser.add_argument("--nothing", choices=NOTHING, action="append", help="what is no command; all otherwise")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a setting, e.g. asr.threads=2")
    args = parser.parse_args(argv)
    loudness = [None if level == "clean" else float(level) for level in args.loudness or ()] or LOUDNESS
    nothing = args.nothing or NOTHING
    run(args.json, args.minutes, args.voices, tuple(args.set), loudness=loudness, nothing=nothing)


if __name__ == "__main__":
    main()
