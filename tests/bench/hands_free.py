"""A wake word and a request in one breath, said to a whole sayso in real time.

A headless engine hears sound that comes in as from a microphone, a frame every 32 ms, from voices that the head of the
wake word was not trained with; clean and in a kitchen's noise. *Woken* is the share of takes in which the word was
heard. Of those, *planned* is the share in which the plan is that of the words (without large models, which something
misunderstood might reach), and *to the letter* that in which the transcript is as well.

"Last word → motion" is from the end of the voice (35 dB below its loudest part), when that sound is due, to the first
velocity that the robot process is told, and "last word → transcript" to when that is read from the engine. *Plain* are
commands that are complete as they stand; after "turn left" a number is waited for. What a real microphone delays comes
on top.
"""

from __future__ import annotations

import argparse
import asyncio
import base64
import queue
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import cycle, islice
from pathlib import Path
from typing import Any

import numpy as np

import config
from config import paths
from engine.asr.agreement import normalised_words
from engine.audio.source import FRAME_S, FRAME_SAMPLES, RATE, Samples
from engine.errors import SaysoError
from engine.planner.build import build_planner, build_registry
from engine.robot.host.memory import STOP_EPOCH, Memory
from engine.wake.training.voices import Remembered, Sound, Voice, find_voices
from tests.bench.listening import planned
from tests.bench.report import figures, print_report, report
from tests.bench.rig import memory_of
from tests.bench.speech import mixed, noise, silence, speech_bounds
from tests.bench.wake_words import SPEECH, natural, trained_by, unseen
from tests.e2e.engine import Engine, engine

PHRASES = ("hey jarvis", "hey sayso")
DRIVES = ("go to the kitchen", "turn left", "go to the bedroom", "turn around", "go to the study", "turn right")
OTHERS = ("end the current task", "open the gripper", "what do you see", "where are you", "raise your arm")
CONDITIONS = {"clean": None, "10 dB": 10.0}
LEAD_S, TAIL_S, BETWEEN_S = 1.5, 2.5, 0.5
PATIENCE_S = 60.0


class Room:
    """Somebody at a microphone: frames reach the engine when they are due, silent ones where nothing is said."""

    def __init__(self, send: Callable[..., None]) -> None:
        self._send = send
        self._said: queue.SimpleQueue[tuple[Samples, queue.SimpleQueue[float]]] = queue.SimpleQueue()
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def say(self, sound: Samples) -> float:
        """Returns, once all has been said, when its first sample was due (``time.monotonic()``)."""
        began: queue.SimpleQueue[float] = queue.SimpleQueue()
        self._said.put((sound, began))
        return began.get(timeout=PATIENCE_S)

    def close(self) -> None:
        self._closing.set()
        self._thread.join()

    def _run(self) -> None:
        due = time.monotonic()
        left, began, told = np.zeros(0, np.int16), 0.0, None
        nothing = silence(FRAME_S)[:FRAME_SAMPLES]
        while not self._closing.is_set():
            if len(left) < FRAME_SAMPLES:
                if told is not None:
                    told.put(began)
                    told = None
                if not self._said.empty():
                    (left, told), began = self._said.get(), due
            frame, left = (left[:FRAME_SAMPLES], left[FRAME_SAMPLES:]) if told is not None else (nothing, left)
            due += FRAME_S
            time.sleep(max(0.0, due - time.monotonic()))
            self._send(do="audio", pcm=base64.b64encode(frame.tobytes()).decode())


class Watch:
    """What the engine tells, and when the robot was first told to move."""

    def __init__(self, running: Engine) -> None:
        self.events: list[tuple[float, str, dict[str, Any]]] = []
        self.moved: float | None = None
        self._engine = running
        self._memory: Memory = memory_of(running.process.pid)
        self._closing = threading.Event()
        self._came = threading.Condition()
        for work in (self._read, self._look):
            threading.Thread(target=work, daemon=True).start()

    def forget(self) -> None:
        self.events, self.moved = [], None

    def first(self, kind: str) -> tuple[float, dict[str, Any]] | None:
        """The first event of a kind that is remembered: when it was read, and its body."""
        return next(((at, body) for at, found, body in tuple(self.events) if found == kind), None)

    def wait_for(self, kind: str) -> None:
        """Until an event of a kind is remembered. Raises ``SystemExit`` where none comes."""
        with self._came:
            if not self._came.wait_for(lambda: self.first(kind) is not None, PATIENCE_S):
                raise SystemExit(f"{PATIENCE_S:g} s without {kind}.")

    def close(self) -> None:
        self._closing.set()

    def _read(self) -> None:
        for event in self._engine.each():
            with self._came:
                self.events.append((time.monotonic(), event["kind"], event["body"]))
                self._came.notify_all()

    def _look(self) -> None:
        while not self._closing.wait(0.001):
            told = self._memory.drive.get()
            if self.moved is None and told["epoch"] == self._memory.ints[STOP_EPOCH] and np.any(told["twist"]):
                self.moved = time.monotonic()


@dataclass
class Tally:
    """What became of the takes with one wake word in one condition."""

    counts: Counter[str] = field(default_factory=Counter)
    transcript_s: list[float] = field(default_factory=list)
    motion_s: list[float] = field(default_factory=list)
    plain_s: list[float] = field(default_factory=list)  # of those, the plain commands


@contextmanager
def listening(phrase: str) -> Iterator[tuple[Engine, Watch, Room]]:
    """An engine that is woken by ``phrase``, and somebody in front of it."""
    options = ("--set", f"wake.words=[{phrase}]", "--set", "models.fetch=false")
    with tempfile.TemporaryDirectory() as state, engine(Path(state), "", *options) as running:
        running.until_loaded("wake words")
        watch, room = Watch(running), Room(running.send)
        try:
            yield running, watch, room
        finally:
            room.close()
            watch.close()


def take(voice: Sound, snr_db: float | None, seed: int) -> tuple[Samples, float]:
    """A sentence with silence or noise around it, and when its voice ends in that, s."""
    loud = voice * np.float32(SPEECH / np.sqrt(np.mean(voice**2)))
    spoken = (np.clip(loud, -1, 1) * 32767).astype(np.int16)
    sound = np.concatenate((silence(LEAD_S), spoken, silence(TAIL_S)))
    if snr_db is not None:
        sound = mixed(sound, noise(len(sound) / RATE, seed)[: len(sound)], snr_db)
    return sound, LEAD_S + speech_bounds(spoken)[1]


def run(phrase: str, voices: Sequence[Voice], takes: int) -> dict[str, Tally]:
    """Say it ``takes`` times in each condition, to an engine of its own."""
    tallies = {condition: Tally() for condition in CONDITIONS}
    settings = config.load()
    planner = build_planner(settings, build_registry(settings))
    remembered = Remembered(paths().cache / "bench")
    requests = [request for pair in zip(cycle(DRIVES), OTHERS) for request in pair] + [DRIVES[-1]]
    with listening(phrase) as (running, watch, room):
        for index, request in enumerate(islice(cycle(requests), takes)):
            text = f"{phrase.title()}, {request}."
            said = remembered.say(voices[index % len(voices)], text, 1.0)
            for condition, snr in CONDITIONS.items():
                sound, end = take(said, snr, index)
                watch.forget()
                ended = room.say(sound) + end
                wake, final = watch.first("wake.heard"), watch.first("transcript.final")
                heard = str(final[1]["text"]) if final is not None else ""
                wanted = asyncio.run(planned(planner, request))
                found = asyncio.run(planned(planner, heard)) if heard else ()
                tally = tallies[condition]
                right = wake is not None and found == wanted
                tally.counts.update(
                    all=1,
                    woken=wake is not None,
                    planned=right,
                    letter=normalised_words(heard) == normalised_words(request),
                )
                if final is not None and right:
                    tally.transcript_s.append(final[0] - ended)
                if watch.moved is not None and right and request in DRIVES:
                    tally.motion_s.append(watch.moved - ended)
                    if planner.completeness(request) == "complete":
                        tally.plain_s.append(watch.moved - ended)
                if not right:
                    why = f"was heard as {heard!r}" if wake is not None else "did not wake"
                    print(f"{condition}: {text!r} {why} ({voices[index % len(voices)].name})", file=sys.stderr)
                watch.forget()
                running.send(do="end_task")
                watch.wait_for("task.ended")
                room.say(silence(BETWEEN_S))
    return tallies


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench hands_free", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--takes", type=int, default=22, help="of each phrase in each condition")
    parser.add_argument("--phrase", action="append", help="a wake word; several times for several")
    parser.add_argument(
        "--voices", type=Path, action="append", default=[], help="a folder of Kokoro styles or piper voices"
    )
    args = parser.parse_args(argv)
    shown, ratios, count = {}, {}, 0
    every = find_voices(*natural(args.voices))
    for phrase in args.phrase or PHRASES:
        voices = unseen([voice for voice in every if not voice.name.startswith("espeak")] or every, trained_by(phrase))
        if not voices:
            raise SaysoError(f"No voice here is one that “{phrase}” was not trained with.")
        for condition, tally in run(phrase, voices, args.takes).items():
            name, counts = f"“{phrase}”, {condition}", tally.counts
            count += counts["all"]
            ratios[f"{name}: woken"] = counts["woken"] / counts["all"]
            ratios[f"{name}: planned, of those"] = counts["planned"] / max(1, counts["woken"])
            ratios[f"{name}: to the letter, of those"] = counts["letter"] / max(1, counts["woken"])
            if tally.transcript_s:
                shown[f"{name}: last word → transcript"] = figures(tally.transcript_s, "s")
            if tally.motion_s:
                shown[f"{name}: last word → motion"] = figures(tally.motion_s, "s")
            if tally.plain_s:
                shown[f"{name}: the same, plain"] = figures(tally.plain_s, "s")
    print_report(report("hands_free", count, shown, ratios), args.json)


if __name__ == "__main__":
    main()
