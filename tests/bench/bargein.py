"""Talking to a robot that talks: whether it hears itself, and whether it hears somebody else meanwhile.

The robot says its own answers, in English and Chinese, through a simulated loudspeaker in simulated rooms (see
``tests.room``): several distances, latencies, reverberations and loudnesses, clocks that drift apart. *Own voice* is
what comes of that alone while everything listens: wakes, suspected and overheard stops, and, were it listening for a
command, utterances and transcripts. *Heard* is the share of wake words and stops that somebody says over it, at so many
dB above the echo, of as many voices as no head was trained with; *others* is the share of the frames of these words in
which speech is found after the robot's own has been faded out. *Without*: the same as the microphone hears it.

The cost is processor time for a second of sound while the robot speaks.
"""

from __future__ import annotations

import argparse
import asyncio
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np

import config
from config import paths
from config.schema import Settings
from engine.asr.recogniser import Recogniser, Transcript
from engine.audio.echo import EchoCanceller
from engine.audio.endpoint import Ended, Endpointer
from engine.audio.source import FRAME_SAMPLES, RATE, Samples
from engine.audio.vad import make_vad
from engine.errors import SaysoError
from engine.hearing.overhearing import Alert, Overhearing
from engine.parts.loading import make_recogniser, model_store
from engine.parts.words import load_spotters
from engine.planner.phrases.stopping import is_stop
from engine.wake.choice import STOPS
from engine.wake.training.voices import Espeak, Piper, Remembered, Voice, find_voices
from engine.wake.words import Spotter
from tests.bench.report import figures, print_report, report
from tests.bench.speech import frames
from tests.bench.wake_words import trained_by, unseen
from tests.room import VOICE, Room, Sound, Speaker, clean, convolved, decibels, loudness, mixed, said_in_turn, samples

ENGLISH = (
    "I am in the kitchen, next to the table.",
    "Moved 1.00 m forward.",
    "The red box is on the workbench in the study. The blue cup is on the low table in the living room.",
    "Stopped.",
    "I looked everywhere in the house and I did not find a yellow ball, so I came back to where I had been before.",
    "Which box do you mean, the red one or the blue one?",
    "I stopped 0.35 m before the study: something lies in the way.",
    "You can stop me at any time: say stop, or press escape.",
    "To wake me, say hey jarvis, or hey sayso.",
    "I do not know a place called garage. I know the kitchen, the study and the living room.",
)
CHINESE = (
    "我在厨房里，在桌子旁边。",
    "已停止。",
    "我找遍了整个房子，没有找到黄色的球。",
    "您是说红色的盒子还是蓝色的盒子？",
)
ROOMS = (
    Room(0.02, 0.2, -20.0, 0.0, 1),
    Room(0.06, 0.3, -10.0, 50.0, 2),
    Room(0.06, 0.3, 0.0, 0.0, 3),
    Room(0.12, 0.4, 0.0, 50.0, 4),
    Room(0.25, 0.5, 0.0, -50.0, 5),
    Room(0.08, 0.6, 6.0, 50.0, 6),
)
RATIOS = (10.0, 5.0, 0.0, -5.0)
PAUSE_S = 0.4
APART_S = 4.0
"""Between two words over the robot's voice."""
KNOWN_S = 12.0
"""For so long the robot has spoken before anybody talks over it."""


@dataclass
class Heard:
    """What came of a piece of sound: when, s of it."""

    spotted: dict[str, list[float]] = field(default_factory=dict)
    stops: list[float] = field(default_factory=list)
    speech: list[bool] = field(default_factory=list)  # of each frame
    own: int = 0  # words that were told to be the robot's own
    utterances: int = 0
    transcripts: list[str] = field(default_factory=list)


class Ears:
    """Everything that listens, without the engine around it."""

    def __init__(self, settings: Settings, spotters: Sequence[Spotter], recogniser: Recogniser) -> None:
        self._settings = settings
        self._spotters = spotters
        self._recogniser = recogniser
        self._worker = ThreadPoolExecutor(1)

    async def hear(
        self, left: Samples, others: Samples, alone: Sequence[bool] = (), *, listening: bool = True
    ) -> Heard:
        """Hear a recording: what was subtracted from, and what was faded; and whether words are the robot's own, frame
        by frame. ``listening``: for commands as well."""
        heard, now = Heard(), 0.0
        alert = Alert(make_vad(self._settings.vad), is_stop, lambda words: heard.stops.append(now))
        overhearing = Overhearing(alert, self._recogniser, self._worker)
        overhearing.switch(True)
        vad, endpointer = make_vad(self._settings.vad), Endpointer(self._settings.endpoint)
        for spotter in self._spotters:
            spotter.reset()
        for number, (plain, faded) in enumerate(zip(frames(left), frames(others), strict=True)):
            now = plain.end
            overhearing.push(plain, faded)
            for spotter in self._spotters:
                for spotted in spotter.push(plain.samples):
                    if number < len(alone) and alone[number]:
                        heard.own += 1
                        continue
                    heard.spotted.setdefault(spotted.phrase, []).append(now)
            found = vad.process(faded)
            heard.speech.append(found.speech)
            ended = endpointer.push(faded, found) if listening else None
            if isinstance(ended, Ended):
                if ended.utterance is not None:
                    heard.utterances += 1
                    sound = ended.utterance.samples * np.float32(1 / 32768)
                    told = await asyncio.to_thread(self._recogniser.transcribe, sound)
                    heard.transcripts += [f"{now:.1f} s: {told.text}"] if isinstance(told, Transcript) else []
                endpointer = Endpointer(self._settings.endpoint)
            while overhearing.busy:
                await asyncio.get_running_loop().run_in_executor(self._worker, lambda: None)
                await asyncio.sleep(0)
        overhearing.switch(False)
        return heard

    def close(self) -> None:
        self._worker.shutdown()


def answers(settings: Settings) -> list[Sound]:
    """What the robot says, by every voice that it has here."""
    store, remembered = model_store(settings), Remembered(paths().cache / "wake")
    voices: list[Voice] = [Espeak("en-us", "m3", 45)]
    try:
        store.find("piper-joe")
        voices.insert(0, Piper(store.file("piper-joe")))
    except SaysoError as error:
        print(f"No piper: {error}")
    said = [remembered.say(voice, text, 1.0) for voice in voices for text in ENGLISH]
    said += [remembered.say(Espeak("cmn", "m3", 45), text, 1.0) for text in CHINESE]
    return [np.asarray(sound, np.float64) for sound in said]


def speaking(said: Sequence[Sound], seconds: float, turn: int = 0) -> Sound:
    """The robot speaks for so long."""
    order = [said[(turn + 7 * index) % len(said)] for index in range(len(said))]
    return np.resize(said_in_turn(order, pause_s=PAUSE_S), round(seconds * RATE) // FRAME_SAMPLES * FRAME_SAMPLES)


async def own_voice(
    ears: Ears, said: Sequence[Sound], minutes: float, *, cancelling: bool, found: dict[str, list[float]]
) -> dict[str, float]:
    """What the robot's own voice alone comes to; counts."""
    counts = {"wakes": 0.0, "suspected stops": 0.0, "overheard stops": 0.0, "utterances": 0.0, "transcripts": 0.0}
    counts["words known to be its own"] = 0.0
    for number, room in enumerate(ROOMS):
        played = speaking(said, minutes * 60 / len(ROOMS), 5 * number)
        heard = mixed(room.echo(played))
        left = others = heard
        alone: list[bool] = []
        if cancelling:
            began = time.process_time()
            left, others = clean(EchoCanceller(Speaker(samples(played))), heard, latency_s=0.04, alone=alone)
            found["cost of a second"].append((time.process_time() - began) / len(heard) * RATE * 1000)
            known = slice(round(min(KNOWN_S, len(heard) / RATE / 2) * RATE), None)
            found[f"echo removed, {room.echo_db:g} dB"].append(decibels(heard[known], left[known]))
            found[f"removed and faded, {room.echo_db:g} dB"].append(decibels(heard[known], others[known]))
        came = await ears.hear(left, others, alone)
        counts["suspected stops"] += sum(len(came.spotted.pop(word, ())) for word in STOPS.values())
        counts["wakes"] += sum(map(len, came.spotted.values()))
        counts["overheard stops"] += len(came.stops)
        counts["words known to be its own"] += came.own
        counts["utterances"] += came.utterances
        counts["transcripts"] += len(came.transcripts)
        if came.spotted or came.stops or came.transcripts:
            how = "with" if cancelling else "without"
            print(f"{how}, {room}: {came.spotted}, {came.stops}, {came.transcripts}", file=sys.stderr, flush=True)
    return counts


def words_over(
    said: Sequence[Sound], words: Sequence[Sound], ratio: float | None
) -> tuple[Sound, Samples, list[float]]:
    """Words that somebody says while the robot speaks: what is played and heard, and when each word ends, s. Without a
    ratio the robot is silent."""
    seconds = KNOWN_S + APART_S * len(words) + 2
    played = speaking(said, seconds)
    people = np.zeros(len(played))
    ends = []
    for index, word in enumerate(words):
        near = convolved(np.pad(word, (0, RATE // 4)), _near(index))
        near *= VOICE / loudness(near)
        first = round((KNOWN_S + APART_S * index) * RATE)
        people[first : first + len(near)] += near
        ends.append((first + len(word)) / RATE)
    room = replace(ROOMS[3], echo_db=-(ratio or 0.0))
    return played, mixed(people) if ratio is None else mixed(people, room.echo(played)), ends


def _near(seed: int) -> Sound:
    """Somebody a step away."""
    random = np.random.default_rng(seed)
    tail = random.normal(0, 0.02, RATE // 4) * 10 ** (-3 * np.arange(RATE // 4) / (RATE // 4))
    tail[0] = 1.0
    return tail


def caught(ends: Sequence[float], times: Sequence[float], late_s: float) -> float:
    return sum(any(-0.5 < at - end < late_s for at in times) for end in ends) / len(ends)


async def over(
    ears: Ears, said: Sequence[Sound], phrase: str, words: Sequence[Sound], ratios: dict[str, float]
) -> None:
    """How much of what somebody says over the robot's voice is heard."""
    for ratio in (None, *RATIOS):
        played, heard, ends = words_over(said, words, ratio)
        alone: list[bool] = []
        cleaned = clean(EchoCanceller(Speaker(samples(played))), heard, latency_s=0.04, alone=alone)
        for name, (left, others) in {"with": cleaned, "without": (heard, heard)}.items():
            if ratio is None and name == "without":
                continue
            came = await ears.hear(left, others, alone if name == "with" else (), listening=False)
            level = "no echo" if ratio is None else f"{ratio:+g} dB"
            ratios[f"“{phrase}” heard, {level}, {name}"] = caught(ends, came.spotted.get(phrase, ()), 0.8)
            if phrase == "stop":
                ratios[f"“stop” overheard, {level}, {name}"] = caught(ends, came.stops, 1.2)
            if name == "with":
                spoken = [
                    np.mean(came.speech[round((end - len(word) / RATE) / 0.032) : round(end / 0.032)])
                    for end, word in zip(ends, words, strict=True)
                ]
                ratios[f"“{phrase}” others, {level}"] = float(np.mean(spoken))


async def measure(settings: Settings, minutes: float, n: int, only: str | None, json: bool) -> None:
    found: dict[str, list[float]] = {"cost of a second": []}
    for room in ROOMS:
        found |= {f"echo removed, {room.echo_db:g} dB": [], f"removed and faded, {room.echo_db:g} dB": []}
    ratios: dict[str, float] = {}
    remembered = Remembered(paths().cache / "wake")
    said = answers(settings)
    recogniser = make_recogniser(settings)
    recogniser.load()
    ears = Ears(settings, load_spotters(settings, ["hey jarvis", "hey sayso"], stops=True), recogniser)
    try:
        if only in (None, "own"):
            for name, cancelling in (("with", True), ("without", False)):
                length = minutes if cancelling else minutes / 10
                counts = await own_voice(ears, said, length, cancelling=cancelling, found=found)
                ratios |= {f"own voice, {length:g} min {name}: {what}": count for what, count in counts.items()}
        if only in (None, "words"):
            voices = unseen(find_voices(None, (), ()), trained_by("hey sayso") | trained_by("stop"))[:n]
            for phrase in ("hey jarvis", "hey sayso", "stop"):
                words = [remembered.say(voice, f"{phrase}.", 1.0).astype(np.float64) for voice in voices]
                await over(ears, said, phrase, words, ratios)
    finally:
        ears.close()
        recogniser.close()
    units = {"cost of a second": "ms"}
    shown = {name: figures(values, units.get(name, "dB")) for name, values in found.items() if values}
    print_report(report("bargein", n, shown, ratios), json)


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench bargein", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--minutes", type=float, default=10.0, help="how long the robot speaks")
    parser.add_argument("--n", type=int, default=60, help="voices at most")
    parser.add_argument("--only", choices=("own", "words"), help="a part of it")
    args = parser.parse_args(argv)
    asyncio.run(measure(config.load(), args.minutes, args.n, args.only, args.json))


if __name__ == "__main__":
    main()
