"""A whole sayso in a process of its own, for benchmarks: the real console on a pseudo-terminal, the real engine and
robot behind it, and somebody who says stop at its microphone.

:func:`rig` is the benchmark's end, :func:`main` the process. Between them are the terminal, on which keys are
pressed, and four pipes: commands as JSON lines, read as ``sayso engine`` reads them; a byte
for each wake, read in a thread of its own, as a wake module on a serial line is; a byte for each stop to be said; and
what happened and when, in the other direction. The robot's shared memory is mapped by both, and all times are
``time.monotonic()``, which the processes of one machine share.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import gc
import json
import os
import queue
import select
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from config import load
from engine.audio.simulated import SimulatedMicrophone
from engine.audio.source import FRAME_S, Frame
from engine.audio.wav import read_wav
from engine.commands import Wake
from engine.engine import Engine
from engine.events import Event
from engine.parts.loading import Sound
from engine.robot.host.memory import Memory
from engine.scheduling import raise_priority
from tests.bench.load import busy_recogniser
from tests.bench.speech import DEMO, SHARED, speech_bounds
from tests.bench.tui import Terminal, console
from tui.commands.engine import _read_commands

PIPES = ("commands", "wakes", "words", "reports")
PATIENCE_S = 20.0
"""How long anything may take before a benchmark gives up, s."""


# The benchmark's end


@dataclass(frozen=True, slots=True)
class Report:
    """Something happened at ``at`` (``time.monotonic()``)."""

    kind: str
    at: float


class Rig:
    """A running sayso, and everything that one can do to it."""

    def __init__(self, terminal: Terminal, pipes: Mapping[str, int]) -> None:
        self._terminal = terminal
        self._pipes = pipes
        self._reports: queue.SimpleQueue[Report] = queue.SimpleQueue()
        self.lost = 0  # requests for a drive to which the robot did not move
        self._closing = threading.Event()
        self._screen = threading.Thread(target=self._read_screen)
        self._screen.start()
        threading.Thread(target=self._read_reports, daemon=True).start()  # to the end of the pipe

    def become_ready(self) -> None:
        """Wait until everything is loaded."""
        self._expect("ready", 0.0)
        self.memory = memory_of(self._terminal.pid)

    def close(self) -> None:
        """Take no more notice of the terminal."""
        self._closing.set()
        self._screen.join()

    def show_camera(self) -> None:
        """The busiest screen: everything moves, and the picture of the camera with it."""
        os.write(self._terminal.master, b"c")

    def press_escape(self) -> None:
        os.write(self._terminal.master, b"\x1b")

    def wake(self) -> None:
        os.write(self._pipes["wakes"], b"\x01")

    def command(self, do: str, **fields: str) -> None:
        os.write(self._pipes["commands"], json.dumps({"do": do, **fields}).encode() + b"\n")

    def say_stop(self) -> float:
        """Somebody says stop. Returns when the word will have ended."""
        began = time.monotonic()
        os.write(self._pipes["words"], b"\x01")
        return self._expect("word", began)

    def drive(self) -> None:
        """Ask for a drive, towards where the robot started, and return once it is under way.

        An engine that this busy a machine kept from running for a quarter of a second finds its robot halted, and the
        request is lost with it; then it is made again, and ``lost`` counts that.
        """
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            ahead = self.memory.state.get()["pose"][0] < 0
            self.command("say", text="go forward 1 metre" if ahead else "go back 1 metre")
            if self.came_true(lambda: abs(self.memory.state.get()["twist"][0]) > 0.15, 3.0):
                return
            self.lost += 1
        raise SystemExit("The robot does not drive.")

    def when(self, kind: str, since: float, seconds: float) -> float | None:
        """When the first thing of this kind since then happened; None if it does not within so many seconds."""
        deadline = time.monotonic() + seconds
        with contextlib.suppress(queue.Empty):
            while report := self._reports.get(timeout=max(0.0, deadline - time.monotonic())):
                if report.kind == kind and report.at >= since:
                    return report.at
        return None

    def _expect(self, kind: str, since: float) -> float:
        if (at := self.when(kind, since, PATIENCE_S)) is None:
            screen = self._terminal.seen.decode(errors="replace")
            raise SystemExit(f"{PATIENCE_S:g} s without {kind!r} from the rig. Last on its terminal: {screen}")
        return at

    @staticmethod
    def came_true(condition: Callable[[], bool], seconds: float) -> bool:
        """Wait until it does, for so long at most. What is waited for is stamped by whoever does it."""
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline:
                return False
            time.sleep(0.0005)
        return True

    def _read_screen(self) -> None:
        with contextlib.suppress(OSError):  # it has been left
            while not self._closing.is_set():
                if select.select([self._terminal.master], [], [], 0.1)[0]:
                    self._terminal.seen[:] = os.read(self._terminal.master, 65536)

    def _read_reports(self) -> None:
        with open(self._pipes["reports"], encoding="utf-8", closefd=False) as lines:
            for line in lines:
                self._reports.put(Report(**json.loads(line)))


@contextlib.contextmanager
def rig(*, decoding: bool, camera: bool = False, settings: tuple[str, ...] = ()) -> Iterator[Rig]:
    """A running sayso that is driven to and fro; ``decoding``: beside a recogniser that never stops; ``camera``: it
    shows what the camera sees."""
    ours, theirs = {}, {}
    for name in PIPES:
        ends = os.pipe()
        theirs[name], ours[name] = ends if name != "reports" else reversed(ends)
        os.set_inheritable(theirs[name], True)
    arguments = [f"--{name}={end}" for name, end in theirs.items()]
    arguments += ["--decoding"] * decoding + [f"--set={setting}" for setting in settings]
    program = "import sys; from tests.bench.rig import main; sys.exit(main(sys.argv[1:]))"
    with (
        tempfile.TemporaryDirectory() as state,
        _environment("SAYSO_STATE_DIR", state),
        console(120, 40, *arguments, program=program) as terminal,
    ):
        for end in theirs.values():
            os.close(end)
        sayso = Rig(terminal, ours)
        try:
            sayso.become_ready()
            if camera:
                sayso.show_camera()
            yield sayso
        finally:
            sayso.close()  # from here on the terminal is read by who opened it
    for end in ours.values():
        os.close(end)


@contextlib.contextmanager
def _environment(name: str, value: str) -> Iterator[None]:
    kept = os.environ.get(name)
    os.environ[name] = value
    try:
        yield
    finally:
        if kept is None:
            del os.environ[name]
        else:
            os.environ[name] = kept


def memory_of(pid: int) -> Memory:
    """The memory that an engine shares with its robot process, mapped once more."""
    for link in Path(f"/proc/{pid}/fd").iterdir():
        if "sayso-robot" in str(link.readlink()):
            return Memory(os.open(link, os.O_RDWR))
    raise SystemExit("The rig has no robot: its shared memory was not found.")


# The process


class Speaker(SimulatedMicrophone):
    """A simulated microphone that tells, at the beginning of a word, when it will have ended.

    The end is that of the recorded voice (35 dB below its loudest part), in the time in which the frames of sound are
    due, not in the time in which a busy engine takes them.
    """

    def __init__(self, told: Callable[[str, float], None]) -> None:
        voices = [SHARED / "speech_synth" / f"{voice}_08_clean.wav" for voice in ("joe", "am_michael")]
        recordings = [DEMO / "stop.wav", *(path for path in voices if path.exists())]
        super().__init__(recordings, every_s=None)
        self._told_end = told
        self._word_ends = {path: speech_bounds(read_wav(path))[1] for path in recordings}
        self._said: Path | None = None
        self._origins: deque[float] = deque(maxlen=60)  # of stream time, as the last frames have it; late ones err
        self._loop: asyncio.AbstractEventLoop | None = None

    def say_next(self) -> None:
        """Thread-safe."""
        assert self._loop is not None, "not opened yet"
        self._loop.call_soon_threadsafe(self.speak)

    def speak(self) -> Path:
        self._said = super().speak()
        return self._said

    async def __aenter__(self) -> Speaker:
        self._loop = asyncio.get_running_loop()
        await super().__aenter__()
        return self

    async def __anext__(self) -> Frame:
        frame = await super().__anext__()
        self._origins.append(asyncio.get_running_loop().time() - frame.end)
        if (said := self._said) is not None:  # this is its first frame
            self._said = None
            self._told_end("word", min(self._origins) + frame.end - FRAME_S + self._word_ends[said])
        return frame


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="tests.bench.rig", description="Internal to the benchmarks.")
    for name in PIPES:
        parser.add_argument(f"--{name}", type=int, required=True, help="an inherited file descriptor")
    parser.add_argument("--decoding", action="store_true")
    parser.add_argument("--set", action="append", default=[])
    args = parser.parse_args(argv)
    gc.disable()  # as the command line does
    os.environ.setdefault("ESCDELAY", "25")
    from tui.app import run_console

    def tell(kind: str, at: float) -> None:
        os.write(args.reports, json.dumps({"kind": kind, "at": at}).encode() + b"\n")

    def see(event: Event) -> None:
        if event.kind == "listen.started":
            tell(event.kind, time.monotonic())

    settings = load(overrides=tuple(args.set))
    prompt = settings.robot.realtime_priority

    def start(dress: Any) -> Engine:
        dress(settings.console.theme, settings.console.fps, prompt=prompt)
        speaker = Speaker(tell)
        engine = Engine(settings, mode="console", sound=Sound("source", speaker))
        engine.start()
        engine.subscribe(see)
        in_thread(_read_commands, engine, args.commands, prompt)
        in_thread(each_byte, args.wakes, lambda: engine.send(Wake("serial")), prompt)
        in_thread(each_byte, args.words, speaker.say_next, False)
        in_thread(report_ready, engine)
        return engine

    def in_thread(work: Callable[..., None], *arguments: Any) -> None:
        threading.Thread(target=work, args=arguments, daemon=True).start()

    def each_byte(pipe: int, act: Callable[[], None], prompt: bool) -> None:
        if prompt:
            raise_priority()
        while os.read(pipe, 1):
            act()

    def report_ready(engine: Engine) -> None:
        parts = ("robot", "planner", "recogniser", "microphone")
        while not {part.name for part in engine.status() if part.state == "ready"} >= set(parts):
            time.sleep(0.05)
        tell("ready", time.monotonic())

    with busy_recogniser(prompt=prompt) if args.decoding else contextlib.nullcontext():
        return run_console(start)
