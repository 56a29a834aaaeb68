"""From a blow to a robot that stands: what happens when the engine is paused, hangs, is killed, or its terminal goes.

The robot drives in real time; at a random moment the blow falls. *zero* is when its motors are told to stand, *rest*
when it stands, both stamped by the robot process itself and read from its memory. Paused and hung engines are noticed
by their missing heartbeat, killed ones and closed terminals at once.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.bench.report import Figure, figures, print_report, report
from tests.e2e.body import Body, until
from tests.e2e.engine import Engine, engine
from tests.e2e.terminal import console

TO_AND_FRO = ("go to the kitchen", "go to the bedroom")
LONGEST_DRIVE = 0.8  # s at speed before the blow
HANG_S = 1.0
HANGS = f"""
import sys, time, engine.engine
start = engine.engine.Engine.start
def hanging(self):
    start(self)
    def hang(event):
        if event.kind == "ack" and event.body.do == "snapshot":
            print(time.monotonic(), file=sys.stderr, flush=True)
            time.sleep({HANG_S})
    self.subscribe(hang)
engine.engine.Engine.start = hanging
"""
"""An engine whose thread hangs for a while over a snapshot, and says when that began."""

Sample = tuple[float, float, float]
"""Seconds from the blow to zero and to rest, and the speed at the blow, m/s."""


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench watchdog", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--n", type=int, default=20, help="how many blows of each kind")
    args = parser.parse_args(argv)
    found: dict[str, Figure] = {}
    over = 0
    for name, strike in (("paused", paused), ("hung", hung), ("killed", killed), ("closed terminal", closed)):
        samples = strike(args.n)
        found[f"zero ({name})"] = figures([sample[0] * 1e3 for sample in samples], "ms")
        found[f"rest ({name})"] = figures([sample[1] * 1e3 for sample in samples], "ms")
        found[f"speed ({name})"] = figures([sample[2] for sample in samples], "m/s")
        over += sum(sample[1] > 0.3 for sample in samples)
    print_report(report("watchdog", args.n, found, {"rest later than 300 ms": over / (4 * args.n)}), args.json)


def paused(n: int) -> list[Sample]:
    """SIGSTOP, again and again, to the same engine."""

    def strike(running: Engine) -> float:
        blow = time.monotonic()
        running.process.send_signal(signal.SIGSTOP)
        return blow

    def mend(running: Engine) -> None:
        running.process.send_signal(signal.SIGCONT)

    return again_and_again(n, strike, mend)


def hung(n: int) -> list[Sample]:
    """A loop that stands still."""

    def strike(running: Engine) -> float:
        running.send(do="snapshot")
        assert running.process.stderr is not None
        return float(running.process.stderr.readline())

    return again_and_again(n, strike, lambda running: None, before=HANGS)


def again_and_again(
    n: int, strike: Callable[[Engine], float], mend: Callable[[Engine], None], *, before: str = ""
) -> list[Sample]:
    """Blows from which the same engine recovers. ``strike`` returns the moment of the blow."""
    samples = []
    with folder() as state, engine(state, before=before) as running:
        running.until_loaded()
        body = Body(running.process.pid)
        for number in range(n):
            running.send(do="say", text=TO_AND_FRO[number % 2])
            at_speed(body, number)
            samples.append(sample(body, lambda: strike(running)))
            mend(running)
            running.until("state.changed", lambda changed: changed["result"])
            until(lambda: not body.halted, "the robot is released")
    return samples


def killed(n: int) -> list[Sample]:
    """SIGKILL, each time to a new engine."""
    samples = []
    for number in range(n):
        with folder() as state, engine(state) as running:
            running.until_loaded()
            body = Body(running.process.pid)
            running.send(do="say", text=TO_AND_FRO[0])
            at_speed(body, number)
            samples.append(sample(body, lambda running=running: now_and(running.process.kill)))  # type: ignore[misc]
    return samples


def closed(n: int) -> list[Sample]:
    """A terminal that is closed, each time that of a new console."""
    samples = []
    for number in range(n):
        with folder() as state, console(state=state) as terminal:
            terminal.until(lambda: "✓ robot" in terminal.text and "◌" not in terminal.text)
            body = Body(terminal.pid)
            terminal.type("/")
            terminal.type(TO_AND_FRO[0] + "\r")
            terminal.until(lambda: body.driving)  # noqa: B023
            at_speed(body, number)
            samples.append(sample(body, lambda: now_and(terminal.hang_up)))
            terminal.wait()
    return samples


def at_speed(body: Body, seed: int) -> None:
    """Wait until the robot drives, and a moment longer."""
    body.until_driving()
    time.sleep(random.Random(seed).uniform(0, LONGEST_DRIVE))


def sample(body: Body, strike: Callable[[], float]) -> Sample:
    speed = body.twist.vx
    zero, rest = body.until_resting(strike())
    return zero, rest, speed


def now_and(strike: Callable[[], None]) -> float:
    """The moment just before the blow."""
    blow = time.monotonic()
    strike()
    return blow


@contextmanager
def folder() -> Iterator[Path]:
    """A folder for one session's state."""
    with tempfile.TemporaryDirectory(prefix=f"sayso-{os.getpid()}-") as path:
        yield Path(path)


if __name__ == "__main__":
    main()
