"""The local model: how soon it is there, how fast it reads and writes, and how soon it is silent.

"First answer" is from a process that does not exist to a whole answer, with the instructions that an English session
begins with: read anew ("cold"), or known from the last start ("restored"). "Cancel → silent" is from the cancellation
of a question to the last processor time that its process takes, looked at every 5 ms: cancelled while it writes, and
while it reads. ``--load`` measures again beside a recogniser that never stops.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import tempfile
from collections import defaultdict
from pathlib import Path
from time import perf_counter

import psutil

from config import load
from config.schema import Settings
from engine.llm.chat import Ask, Message, Reply
from engine.llm.local import LocalChat
from engine.parts.loading import at_home, gguf_of, make_models
from engine.planner.build import build_planner
from tests.bench.load import busy_recogniser
from tests.bench.report import Figure, figures, print_report, report

PLATFORM = "local"
LOOK_S = 0.005
SILENCE_S = 0.3
"""So long without processor time is silence."""
STORY = "Tell me a long story about a robot."
TICK_S = 0.01  # what the kernel counts processor time in

Samples = defaultdict[str, list[float]]


def opening(settings: Settings) -> tuple[Message, ...]:
    """What questions to the execution layer begin with."""
    models = make_models(settings, lambda words: None)
    assert models is not None
    assert models.local is not None, "the profile that is measured runs a model on this machine"
    return build_planner(settings, models=models).beginnings(models.local)[0]


async def starts(settings: Settings, head: tuple[Message, ...], n: int, cache: Path, found: Samples) -> None:
    """First answers of new processes; the first of them has nothing to go by."""
    for number in range(n + 1):
        chat = local(settings, cache)
        began = perf_counter()
        try:
            await chat.load()
            found["load"].append(perf_counter() - began)
            await chat.prepare(head)
            found["instructions, restored" if number else "instructions, cold"].append(perf_counter() - began)
            await question(chat, head, "go to the kitchen", 24)
            found["first answer, restored" if number else "first answer, cold"].append(perf_counter() - began)
        finally:
            await chat.close()


def local(settings: Settings, cache: Path) -> LocalChat:
    return LocalChat(PLATFORM, settings.platforms[PLATFORM], gguf_of(settings, PLATFORM), cache)


async def question(chat: LocalChat, head: tuple[Message, ...], text: str, limit: int) -> Reply:
    return await chat.reply(Ask((*head, Message("user", text)), shared=len(head), max_tokens=limit))


async def speeds(chat: LocalChat, head: tuple[Message, ...], n: int, found: Samples) -> None:
    """Tokens read and written in a second."""
    for number in range(n):
        words = " ".join(f"{number} and {count}" for count in range(60))
        began = perf_counter()
        reply = await question(chat, head, words, 1)
        found["read"].append((reply.prompt_tokens - reply.cached_tokens) / (perf_counter() - began))
        first: list[float] = []
        ask = Ask((*head, Message("user", STORY)), shared=len(head), max_tokens=48, seed=number)
        reply = await chat.reply(ask, lambda piece, first=first: first.append(perf_counter()))  # type: ignore[misc]
        found["written"].append((reply.reply_tokens - 1) / (perf_counter() - first[0]))


async def cancelled(chat: LocalChat, head: tuple[Message, ...], number: int, *, reading: bool) -> float:
    """Seconds from a cancellation to the last sign of work."""
    begun = asyncio.Event()
    if reading:
        text = f"{number}: " + " ".join(f"{number} and {count}" for count in range(200))
        task = asyncio.create_task(question(chat, head, text, 8))
        asyncio.get_running_loop().call_later(0.5 + 0.037 * (number % 8), begun.set)
    else:
        ask = Ask((*head, Message("user", STORY)), shared=len(head), max_tokens=400)
        task = asyncio.create_task(chat.reply(ask, lambda piece: begun.set()))
    await begun.wait()
    assert chat.pid is not None
    process = psutil.Process(chat.pid)
    task.cancel()
    began = last = perf_counter()
    worked = sum(process.cpu_times()[:2])
    with contextlib.suppress(asyncio.CancelledError):
        await task
    while perf_counter() - last < SILENCE_S:
        await asyncio.sleep(LOOK_S)
        now = sum(process.cpu_times()[:2])
        if now - worked >= TICK_S / 2:
            worked, last = now, perf_counter()
    return last - began


async def measure(
    settings: Settings, head: tuple[Message, ...], n: int, cache: Path, found: Samples, beside: str
) -> None:
    chat = local(settings, cache)
    try:
        await chat.prepare(head)
        spoken: Samples = defaultdict(list)
        await speeds(chat, head, max(2, n // 5), spoken)
        for number in range(n):
            spoken["cancel → silent, writing"].append(await cancelled(chat, head, number, reading=False))
            spoken["cancel → silent, reading"].append(await cancelled(chat, head, number, reading=True))
        found |= {f"{name}{beside}": samples for name, samples in spoken.items()}
    finally:
        await chat.close()


def unit(name: str, samples: list[float]) -> Figure:
    if name.startswith(("read", "written")):
        return figures(samples, "tok/s")
    if name.startswith("cancel"):
        return figures((seconds * 1e3 for seconds in samples), "ms")
    return figures(samples, "s")


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench model", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--n", type=int, default=20, help="how often a question is cancelled, in each stage")
    parser.add_argument("--load", action="store_true", help="also beside a busy recogniser")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a setting")
    args = parser.parse_args(argv)
    settings = at_home(load(overrides=("planner.profile=local", *args.set)))
    head = opening(settings)
    found: Samples = defaultdict(list)
    with tempfile.TemporaryDirectory() as folder:
        cache = Path(folder)
        asyncio.run(starts(settings, head, 3, cache, found))
        asyncio.run(measure(settings, head, args.n, cache, found, ""))
        if args.load:
            with busy_recogniser(prompt=True):
                asyncio.run(measure(settings, head, args.n, cache, found, ", recogniser busy"))
    ratios = {"instructions, characters": sum(len(message.text) for message in head)}
    print_report(report("model", args.n, {name: unit(name, it) for name, it in found.items()}, ratios), args.json)


if __name__ == "__main__":
    main()
