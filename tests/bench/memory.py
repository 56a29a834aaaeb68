"""Whether memory grows over a day of use: the console, fed with what hours bring, and a session under virtual time.

``--only whole`` (and no ``--only``) starts all of sayso in a terminal instead, with the recogniser tiny.en and no large
model, asks for something, and prints what its processes hold then: PSS, which counts shared pages once.

``python -m tests.bench.memory [--json] [--hours 8] [--only console|session|whole]`` prints memory at the end of each
hour that was simulated, and its growth per hour after the first: of what Python has allocated, and of the process, of
which the system may keep more than is used. Each minute has a turn: somebody listens for 8 s with 10 levels a second,
the robot drives for 20 s with 5 states a second, tells how far it is, logs, takes pictures and answers. With
``--blame`` the lines of code that hold most of what came after the first hour are printed too; what that takes counts
as resident.
"""

from __future__ import annotations

import argparse
import asyncio
import gc
import sys
import tempfile
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import psutil

from engine import events as ev
from engine.commands import Say, Wake
from engine.perception.sighting import Sight
from tests.bench.report import Figure, figures, print_report, report
from tests.board import Emulator
from tests.e2e.terminal import console as terminal
from tests.session.conversation import Conversation, converse
from tests.tui.scripted import ScriptedEngine, flat, robot_at, sight_of
from tui.app import SaysoApp

TURNS = 60
"""In an hour."""
PLACES = (("kitchen", 0.2, 2.0), ("living room", -3.0, 0.0), ("bedroom", 0.5, -2.0), ("study", 3.0, 2.0))
_NOTED = ("moved", "arm_moves")
"""What a kinematic robot notes of what it was told."""
REQUESTS = (
    "turn left 90 degrees", "where are you?", "go forward 1 metre", "raise your arm and nod", "go to the moon",
    "turn right 90 degrees, go back 1 metre",
)  # fmt: skip


@dataclass
class Growth:
    """Memory at the end of each hour, kB."""

    name: str
    allocated: list[float] = field(default_factory=list)
    resident: list[float] = field(default_factory=list)
    first: tracemalloc.Snapshot | None = None

    def measure(self, *, blame: bool) -> None:
        gc.collect()
        self.allocated.append(tracemalloc.get_traced_memory()[0] / 1000)
        self.resident.append(psutil.Process().memory_info().rss / 1000)
        hour, mb = len(self.allocated), (self.allocated[-1] / 1000, self.resident[-1] / 1000)
        print(f"{self.name}, hour {hour}: {mb[0]:.3f} MB allocated, {mb[1]:.1f} MB resident", file=sys.stderr)
        if not blame:
            return
        now = tracemalloc.take_snapshot()
        if self.first is None:
            self.first = now
            return
        grown = now.compare_to(self.first, "lineno")[:8]
        print(*(f"{item.size_diff / 1000:8.1f} kB  {item.traceback}" for item in grown), sep="\n", file=sys.stderr)

    @property
    def per_hour(self) -> dict[str, float]:
        """kB: after the first hour, and in the second half, when caches of a fixed size are full."""
        half = len(self.allocated) // 2
        return {
            f"{self.name}: {kind}, growth in kB an hour{when}": _slope(values[since:])
            for kind, values in (("allocated", self.allocated), ("resident", self.resident))
            for when, since in (("", 1), (", second half", half))
        }


def _slope(values: list[float]) -> float:
    return float(np.polyfit(range(len(values)), values, 1)[0]) if len(values) > 1 else 0.0


def turn_of(engine: ScriptedEngine, number: int) -> None:
    """One minute: somebody asks for something, and the robot does it."""
    turn, epoch = f"T{number}", number + 1
    name, x, y = PLACES[number % len(PLACES)]
    text, action, args = f"go to the {name} for the {number}. time", f"a{number}", {"place": name}

    def tell(body: ev.Body, after: float = 0.0) -> None:
        engine.publish(body, after=after, turn=turn, epoch=epoch)

    tell(ev.WakeHeard("key"))
    tell(ev.StateChanged("WAITING", "LISTENING", "wake"))
    tell(ev.ListenStarted("microphone"))
    for step in range(80):
        loud = 20 < step < 60
        tell(ev.ListenLevel(-20.0 - step % 7 if loud else -55.0, -12.0, 0.9 if loud else 0.1, loud), 0.1)
    tell(ev.TranscriptPartial(text[:12], 3))
    tell(ev.ListenEnded("silence", 8.0, 4.0))
    tell(ev.StateChanged("LISTENING", "TRANSCRIBING", "silence"))
    tell(ev.TranscriptFinal(text, "speech", "en", 0.93, -0.1, 0.02, 8.0, 0.3), 0.3)
    tell(ev.StateChanged("TRANSCRIBING", "PLANNING", "transcript"))
    messages = (ev.MessageView("user", f"{text} " * 20),)
    tell(ev.ModelAsked("execution", "local", 1, "0" * 16, 9000, messages, f'{{"plan": "{text}"}}', 1.2))
    tell(ev.PlanMade(text, (f"Go to the {name}.",), (ev.ActionView("navigation", args),), "On my way.", "local"), 0.2)
    tell(ev.ActionQueued(action, 1, 1, "navigation", args))
    tell(ev.StateChanged("PLANNING", "ACTING", "plan"))
    tell(ev.ActionStarted(action, 1, 1, "navigation", args))
    for step in range(100):
        way = step / 100
        pose = ev.PoseView(x * way + number % 13 / 10, y * way, way)
        tell(ev.RobotStateView(engine.t, pose, ev.TwistView(0.5, 0, 0), (0.0,) * 5, 1.0, True, None), 0.2)
        if step % 5 == 0:
            path = tuple((x * more / 20, y * more / 20) for more in range(step // 5, 20))
            tell(ev.ActionProgress(action, "navigation", way, f"{3 - 3 * way:.1f} m to the {name}", path))
        if step % 20 == 0:
            tell(ev.CameraFrame(160, 120))
            tell(ev.PerceptionResult(f"red box number {number}, blue cup"))
            tell(ev.Log("info", "robot", f"note {step} of turn {number}"))
    tell(ev.ActionFinished(action, "navigation", args, "ok", None, "", 20.0, {"x": x, "y": y, "turn": number}))
    answer = f"I am in the {name} for the {number}. time."
    tell(ev.SpeechStarted(answer, True))
    tell(ev.SpeechEnded(answer, answer, "ok"), 2.0)
    tell(ev.StateChanged("ACTING", "WAITING", "done", ev.TurnResult(0, "done", answer)))
    if number % 20 == 19:
        tell(ev.TaskEnded("asked"))


async def console(hours: int, measure: Callable[[], None]) -> int:
    """The console on no terminal, with the camera shown; gives the number of events."""
    engine = ScriptedEngine(robot=robot_at(-1.35, 0.05, 0.4), floor=flat(), lidar=True)
    app = SaysoApp(lambda: engine, clock=lambda: engine.t)
    noise = np.random.default_rng(1)
    seen = sight_of()
    async with app.run_test(size=(160, 50)) as pilot:
        while not app.shown.started:
            await pilot.pause()
        app.viewing.show(True)
        for number in range(hours * TURNS):
            turn_of(engine, number)
            engine.looks.clear()  # what only a test keeps
            for _ in range(3):
                app.viewing.seen(_noisy(seen, noise))
                app.drawing.now()
                await pilot.pause()
            if number % TURNS == TURNS - 1:
                measure()
    return engine._seq


def _noisy(sight: Sight, noise: np.random.Generator) -> Sight:
    """Another picture of the same."""
    rgb = sight.picture.rgb
    other = np.clip(rgb + noise.integers(-20, 20, rgb.shape), 0, 255).astype(np.uint8)
    return replace(sight, picture=replace(sight.picture, rgb=other))


def session(hours: int, measure: Callable[[], None]) -> int:
    """A session whose task never ends; gives the number of events."""

    async def day(talk: Conversation) -> int:
        count = 0
        for number in range(hours * TURNS):
            request = REQUESTS[number % len(REQUESTS)]
            if number % 3:
                talk.send(Say(f"{request}"))
            else:
                talk.send(Wake("key"))
                await talk.until_state("LISTENING")
                await talk.pass_time(4.0)
                talk.hearing.speak(request)
            await talk.pass_time(3600 / TURNS)
            count += len(talk.seen)
            for noted in (
                talk.seen,
                talk.planner.asked,
                talk.hearing.suspected,
                *map(vars(talk.robot).__getitem__, _NOTED),
            ):
                noted.clear()  # what only a test keeps
            if number % TURNS == TURNS - 1:
                measure()
        return count

    return converse(day)


def wholes() -> dict[str, Figure]:
    """MB of every process of a running sayso, by what it is, and of all: with a motor board, and in the simulation with
    each kind of camera."""
    found = {
        f"{name}: {part}": figure
        for name, options in (("simulated", ()), ("simulated, rays", ("--set", "robot.camera.backend=rays")))
        for part, figure in whole(*options).items()
    }
    with tempfile.TemporaryDirectory() as folder, Emulator(Path(folder)) as board:
        options = ("--set", "robot.kind=rosmaster", "--set", f"robot.port={board.path}")
        return found | {f"motor board: {part}": figure for part, figure in whole(*options).items()}


def whole(*options: str) -> dict[str, Figure]:
    """The same with these options."""
    options = ("--set", "asr.model=tiny.en", *options)
    with tempfile.TemporaryDirectory() as folder, terminal(*options, state=Path(folder)) as running:
        running.until(lambda: "✓ robot" in running.text and "◌" not in running.text)
        running.type("/")
        running.type("turn left 90 degrees\r")
        running.until(lambda: "Turned" in running.text)
        processes = [psutil.Process(running.pid), *psutil.Process(running.pid).children(recursive=True)]
        held = {_named(process): process.memory_full_info().pss / 1e6 for process in processes}
    return {name: figures([size], "MB") for name, size in (*held.items(), ("all", sum(held.values())))}


def _named(process: psutil.Process) -> str:
    """The module that it runs, in short."""
    line = process.cmdline()
    module = line[line.index("-m") + 1] if "-m" in line else "engine and console"
    return module.removeprefix("engine.")


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench memory", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--hours", type=int, default=8, help="to simulate; the first one warms up")
    parser.add_argument("--only", choices=("console", "session", "whole"))
    parser.add_argument("--blame", action="store_true", help="tell which lines of code hold more and more")
    args = parser.parse_args(argv)
    tracemalloc.start()
    found: dict[str, Figure] = {}
    ratios: dict[str, float] = {}
    count = 0
    if args.only in (None, "whole"):
        found |= wholes()
    for name in () if args.only == "whole" else (args.only,) if args.only else ("session", "console"):
        growth = Growth(name)

        def measure(growth: Growth = growth) -> None:
            growth.measure(blame=args.blame)

        fed = session(args.hours, measure) if name == "session" else asyncio.run(console(args.hours, measure))
        count += fed
        found |= {
            f"{name}: allocated": figures(growth.allocated, "kB"),
            f"{name}: resident": figures(growth.resident, "kB"),
        }
        ratios |= {f"{name}: events": float(fed), **growth.per_hour}
    print_report(report("memory", count, found, ratios), args.json)


if __name__ == "__main__":
    main()
