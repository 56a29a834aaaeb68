"""From the last byte of a wake on the serial line to the robot listening, in a whole ``sayso engine``.

The module is a pseudo-terminal that speaks all three protocols in turn; the end is the event ``listen.started``, read
from the engine's stdout, so that what it takes to write and read a line is in the figure. *idle*: the robot stands and
nobody talks to it; *again*: it is listening already, and starts anew; *driving*: it stops first. Everything once on a
machine that has nothing else to do, and once with ``--load`` processes that multiply matrices and a recogniser that
decodes all the time.

Ratios are the 99th percentile over the budget, 50 ms, and the share of wakes after which nobody listened.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import queue
import random
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from engine.scheduling import raise_priority
from tests.bench.load import busy_machine, busy_recogniser
from tests.bench.report import figures, print_report, report
from tests.e2e.engine import Engine, engine
from tests.wake_module import AI_VOICE_WAKE, CSK4002_WAKE, WakeModule, ring_wake

BUDGET_MS = 50.0
LIMIT_S = 2.0
"""s after a wake from which it counts as lost."""
PATIENCE_S = 60.0
"""s for anything else."""
WAKES = {"ai_voice": AI_VOICE_WAKE, "csk4002": CSK4002_WAKE, "iflytek": ring_wake()}


class Sayso:
    """A running engine, and when it said what."""

    def __init__(self, running: Engine, module: WakeModule) -> None:
        self._running = running
        self.module = module
        self._said: queue.SimpleQueue[tuple[dict[str, Any], float]] = queue.SimpleQueue()
        threading.Thread(target=self._read, daemon=True).start()  # to the end of stdout

    def _read(self) -> None:
        raise_priority()
        assert self._running.process.stdout is not None
        for line in self._running.process.stdout:
            at = time.monotonic()
            self._said.put((json.loads(line), at))

    def when(self, kind: str, met: Callable[[dict[str, Any]], object] = bool, seconds: float = LIMIT_S) -> float | None:
        """When it next said something of this kind; None if it does not within so many seconds."""
        until = time.monotonic() + seconds
        with contextlib.suppress(queue.Empty):
            while True:
                event, at = self._said.get(timeout=max(0.0, until - time.monotonic()))
                if event["kind"] == kind and met(event["body"]):
                    return at
        return None

    def expect(self, kind: str, met: Callable[[dict[str, Any]], object] = bool) -> None:
        """Wait for something that has to come."""
        if self.when(kind, met, PATIENCE_S) is None:
            raise SystemExit(f"{PATIENCE_S:g} s without {kind!r}.")

    def rest(self) -> None:
        """Stop everything."""
        self._running.send(do="interrupt")
        self.expect("ack", lambda body: body["do"] == "interrupt")

    def drive(self, back: bool) -> None:
        self._running.send(do="say", text=f"go {'back' if back else 'forward'} 1 metre")
        self.expect("robot.state", lambda body: abs(body["twist"]["vx"]) > 0.1)

    def wake(self, protocol: str) -> float | None:
        """Wake, and return how long it takes until it listens, s."""
        began = time.monotonic()
        self.module.say(WAKES[protocol])
        at = self.when("listen.started")
        return None if at is None else at - began


@contextlib.contextmanager
def sayso() -> Iterator[Sayso]:
    """A running engine with a wake module of which it does not know what it is."""
    with ExitStack() as stack:
        state = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        module = stack.enter_context(WakeModule(state))
        running = stack.enter_context(engine(state, "", "--set", f"wake.serial.port={module.path}"))
        found = Sayso(running, module)
        ready: set[str] = set()

        def all_ready(body: dict[str, Any]) -> bool:
            ready.add(body["source"])
            return ready >= {"wake", "robot", "recogniser"}

        found.expect("log", all_ready)
        yield found


def measure(running: Sayso, n: int) -> tuple[dict[str, list[float]], int]:
    """Seconds by what was going on and by protocol, and how many wakes were lost."""
    chance, lost = random.Random(0), 0
    taken: dict[str, list[float]] = {}
    for trial in range(n):
        for protocol in WAKES:
            for doing in ("idle", "again", "driving"):
                if doing != "again":
                    running.rest()
                if doing == "driving":
                    running.drive(back=bool(trial % 2))
                time.sleep(chance.uniform(0.0, 0.1))
                seconds = running.wake(protocol)
                if seconds is None:
                    lost += 1
                else:
                    taken.setdefault(f"{doing}, {protocol}", []).append(seconds)
    return taken, lost


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench wake", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--n", type=int, default=30, help="wakes by each protocol in each situation")
    parser.add_argument("--load", type=int, default=2, help="other processes that keep the processor busy")
    args = parser.parse_args(argv)
    found, ratios = {}, {}
    if hasattr(os, "sched_setscheduler"):
        raise_priority()  # who looks at the clock and then writes must not be kept waiting in between
    for machine in ("quiet", "busy"):
        with ExitStack() as stack:
            running = stack.enter_context(sayso())
            if machine == "busy":
                stack.enter_context(busy_machine(args.load))
                stack.enter_context(busy_recogniser(prompt=True))
            taken, lost = measure(running, args.n)
        for name, seconds in taken.items():
            figure = found[f"{name} ({machine})"] = figures((s * 1e3 for s in seconds), "ms")
            ratios[f"{name} ({machine}): p99 / budget of {BUDGET_MS:g} ms"] = figure["p99"] / BUDGET_MS
        ratios[f"wakes without listening ({machine})"] = lost / (9 * args.n)
    print_report(report("wake", args.n, found, ratios), args.json)


if __name__ == "__main__":
    main()
