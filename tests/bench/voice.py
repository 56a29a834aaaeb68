"""The voice: how soon the first sound of an answer is there, how fast it is made, and how soon it is silent.

"Text → first audio" is from the text of an answer to the first block with something to hear that is handed to the
output, "text → first piece" from there to the synthesiser's first sound. "Stop → silence" is from a stop in another
thread to the end of the last block with something to hear; the output is a clock, so what a device keeps in its own
buffers comes on top. ``--device`` plays through the loudspeaker instead: of what it has been handed, a stop drops what
does not sound yet, which these figures do not see. The real-time factor is the time to make a sentence by the time it
sounds. ``--load`` measures beside a recogniser that never stops.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import time
from collections import defaultdict
from contextlib import aclosing

import numpy as np

from config import load
from config.schema import Settings
from engine.audio.clocked import ClockedOutput
from engine.audio.loudspeaker import Loudspeaker
from engine.audio.player import Output, Player
from engine.audio.source import Samples
from engine.parts.loading import make_synthesiser
from engine.speaking import SpokenVoice
from engine.tts.sentences import sentences
from engine.tts.synthesis import Synthesiser
from tests.bench.load import busy_recogniser
from tests.bench.report import Report, figures, print_report, report

ANSWERS = (
    "Stopped.",
    "Moved 1.00 m forward.",
    "I am in the kitchen, next to the table.",
    "The red box is on the workbench in the study. The blue cup is on the low table in the living room.",
    "I looked everywhere in the house and I did not find a yellow ball, so I came back to where I had been before.",
    "Which box do you mean, the red one or the blue one?",
)
AUDIBLE = 200
"""Of 32768: a louder sample can be heard."""
SETTLE_S = 1.0
"""Until what was cut off is silent, and nobody makes any more of it."""

Found = defaultdict[str, list[float]]


class Watched(Player):
    """A player that notes when it handed over something to hear, and until when that sounds."""

    def __init__(self, output: Output) -> None:
        super().__init__(output)
        self.first: float | None = None
        self.last = 0.0

    async def until_first(self) -> float:
        """Wait for something to hear; when it began, monotonic s."""
        while self.first is None:  # noqa: ASYNC110 - looked at, lest the measured loop be woken by each block
            await asyncio.sleep(0.005)
        return self.first

    def pull(self, count: int, sounds_at: float) -> Samples:
        block = super().pull(count, sounds_at)
        loud = np.flatnonzero(np.abs(block.astype(np.int32)) > AUDIBLE)
        if len(loud):
            now = time.monotonic()
            self.first = now if self.first is None else self.first
            self.last = now + float(loud[-1] + 1) / self.rate
        return block


async def answers(voice: SpokenVoice, player: Watched, n: int, found: Found) -> None:
    """Say all answers ``n`` times."""
    for text in ANSWERS * n:
        player.first = None
        asked = time.monotonic()
        saying = asyncio.create_task(voice.say(text, lambda heard: None))
        found["text → first audio"].append(await player.until_first() - asked)
        player.stop(player.epoch + 1)
        saying.cancel()
        await asyncio.gather(saying, return_exceptions=True)
        await asyncio.sleep(SETTLE_S)


async def speed(synthesiser: Synthesiser, n: int, found: Found) -> None:
    """Make every sentence ``n`` times."""
    for text in ANSWERS * n:
        for number, sentence in enumerate(sentences(text)):
            began, first, length = time.perf_counter(), None, 0.0
            async with aclosing(synthesiser.synthesise(sentence)) as pieces:
                async for piece in pieces:
                    first = first or time.perf_counter() - began
                    length += len(piece.samples) / piece.rate
            if first is not None and length:
                if number == 0:
                    found["text → first piece"].append(first)
                found["real-time factor"].append((time.perf_counter() - began) / length)


async def stops(voice: SpokenVoice, player: Watched, n: int, found: Found) -> None:
    """Stop in the midst of an answer, at another moment each time, from another thread."""
    random = np.random.default_rng(5)
    for _ in range(n):
        player.first = None
        saying = asyncio.create_task(voice.say(ANSWERS[4], lambda heard: None))
        await player.until_first()
        await asyncio.sleep(float(random.uniform(0.3, 1.5)))
        stopped = await asyncio.to_thread(_stop, player)
        await asyncio.sleep(SETTLE_S)
        found["stop → silence"].append(max(0.0, player.last - stopped))
        saying.cancel()
        await asyncio.gather(saying, return_exceptions=True)


def _stop(player: Player) -> float:
    now = time.monotonic()
    player.stop(player.epoch + 1)
    return now


async def measure(settings: Settings, n: int, device: bool) -> tuple[str, Found]:
    found: Found = defaultdict(list)
    player = Watched(Loudspeaker(settings.voice.device) if device else ClockedOutput(48_000))
    voice = SpokenVoice(player)
    synthesiser = make_synthesiser(settings)
    try:
        began = time.perf_counter()
        await synthesiser.load()
        found["load"].append(time.perf_counter() - began)
        voice.settle(synthesiser)
        await player.open()
        await speed(synthesiser, n, found)
        await answers(voice, player, n, found)
        await stops(voice, player, 4 * n, found)
    finally:
        await synthesiser.close()
        await player.close()
    return f"{synthesiser.name}, {player.name}", found


def run(
    json: bool, n: int = 5, overrides: tuple[str, ...] = (), *, device: bool = False, loaded: bool = False
) -> Report:
    """Measure the configured voice."""
    with busy_recogniser(prompt=True) if loaded else contextlib.nullcontext():
        name, found = asyncio.run(measure(load(overrides=overrides), n, device))
    units = {"real-time factor": "s/s"}
    shown = {key: figures(values, units.get(key, "s")) for key, values in found.items()}
    in_time = sum(value <= 0.3 for value in found["text → first audio"]) / len(found["text → first audio"])
    result = report(f"voice ({name})", n * len(ANSWERS), shown, {"first audio within 0.3 s": in_time})
    print_report(result, json)
    return result


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench voice", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--n", type=int, default=5, help="how often each answer is said")
    parser.add_argument("--device", action="store_true", help="through the loudspeaker of the settings")
    parser.add_argument("--load", action="store_true", help="beside a recogniser that never stops")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="a setting, e.g. voice.speed=1.2"
    )
    args = parser.parse_args(argv)
    run(args.json, args.n, tuple(args.set), device=args.device, loaded=args.load)


if __name__ == "__main__":
    main()
