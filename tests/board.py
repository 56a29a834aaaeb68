"""A motor board for tests: in virtual time, without a process, or as a process of its own on a pseudo-terminal."""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType
from typing import Any

import psutil

from engine.framing import Framer
from engine.robot.description import Description, described
from engine.robot.emulation.board import EmulatedBoard
from engine.robot.geometry import Twist
from engine.robot.host.body import STEP_S
from engine.robot.rosmaster import frames
from engine.robot.rosmaster.body import RosmasterBody
from engine.robot.rosmaster.frames import Order, ToBoard
from engine.robot.sim.simulated import SimulatedBody
from engine.serial_port import PortError
from tests.children import children
from tests.e2e.sayso import command
from tests.sim.rig import flat, settings

LIMIT_S = 60.0


class Bench:
    """A body and an emulated board on one table. Time passes while somebody asks for it: 1 ms each time.

    It is the body's clock, and opens its line.
    """

    def __init__(self, model: str = "emulated", *, pull: float = 0.0) -> None:
        self.description: Description = described(model)
        self.simulated = SimulatedBody(flat(), settings(), pictures=False)
        self.board = EmulatedBoard(self.simulated, self.description, pull=pull)
        self.plugged = True
        self.takes = 4096
        """How many bytes the line takes before the board has read them."""
        self.noise = b""
        """What the body hears before the next report."""
        self.said = bytearray()
        """All that the body has written."""
        self.t = 0.0
        self._stepped = 0.0
        self._to_board, self._to_body = bytearray(), bytearray()

    # The body's clock and line

    def __call__(self) -> float:
        self.t += 0.001
        while self._stepped + STEP_S <= self.t:
            self._stepped += STEP_S
            self.board.step()
            if not self.board.stalled:
                self.board.receive(bytes(self._to_board))
                self._to_board.clear()
                self._to_body += self.board.send()
        return self.t

    def open(self, path: str) -> Bench:
        if not self.plugged:
            raise PortError("absent", f"There is no serial port {path}.")
        self._to_board.clear()
        self._to_body.clear()
        return self

    def fileno(self) -> int:
        return -1

    def read(self) -> bytes:
        self._must_be_there()
        data = self.noise + bytes(self._to_body)
        self.noise = b""
        self._to_body.clear()
        return data

    def write(self, data: bytes) -> int:
        self._must_be_there()
        taken = data[: max(0, self.takes - len(self._to_board))]
        self._to_board += taken
        self.said += taken
        return len(taken)

    def forget(self) -> None:
        self._to_board.clear()

    def close(self) -> None:
        pass

    def _must_be_there(self) -> None:
        if not self.plugged:
            raise OSError("gone")

    # For tests

    def body(self, **more: Any) -> RosmasterBody:
        """A body that has opened this."""
        start = self.simulated.true_pose
        return RosmasterBody(
            "/dev/ttyTest", self.description, start, guarded=False, clock=self, open_line=self.open, **more
        )

    def orders(self) -> list[Order]:
        """What the body has written since this was asked last."""
        found = Framer(ToBoard()).push(bytes(self.said))
        self.said.clear()
        return found

    def speeds(self) -> list[Twist]:
        """The velocities among that."""
        return [speed_in(order) for order in self.orders() if order.function == frames.MOTION]


def speed_in(order: Order) -> Twist:
    """The velocity that a motion frame tells."""
    values = [int.from_bytes(order.data[at : at + 2], "little", signed=True) / 1000 for at in (1, 3, 5)]
    return Twist(*values)


def run(body: RosmasterBody, seconds: float) -> None:
    """Let the body step for so long."""
    until = body.t + seconds
    while body.t < until:
        body.step()


class Emulator:
    """``sayso robot emulate`` as a process. ``path`` is the port."""

    def __init__(self, folder: Path, *arguments: str, model: str = "x3plus") -> None:
        self.path = folder / "board"
        self.state: dict[str, Any] = {}
        """The newest; empty before the first."""
        self._held = b""
        self._process = subprocess.Popen(
            command("robot", "emulate", model, "--json", f"--port={self.path}", *arguments),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )

    def __enter__(self) -> Emulator:
        self.until(lambda state: True)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            pipe.close()
        self.path.unlink(missing_ok=True)

    @property
    def pid(self) -> int:
        return self._process.pid

    def tell(self, line: str) -> None:
        """Have something go wrong, or right again."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{line}\n".encode())
        self._process.stdin.flush()

    def until(self, condition: Any) -> dict[str, Any]:
        """The first state from now on that fulfils this."""
        found = self.comes_to(condition, LIMIT_S)
        assert found is not None, f"the board never came to that; its last state was {self.state}"
        return found

    def comes_to(self, condition: Any, limit_s: float) -> dict[str, Any] | None:
        """The same; None if there is none in time."""
        since = time.monotonic()
        until = since + limit_s
        while time.monotonic() < until:
            for state in self.states(until):
                if state["at"] >= since and condition(state):
                    return state
        return None

    def states(self, until: float) -> list[dict[str, Any]]:
        """Those that have come; waits for one until then."""
        assert self._process.stdout is not None
        fd = self._process.stdout.fileno()
        if not select.select([fd], [], [], max(0.0, until - time.monotonic()))[0]:
            return []
        piece = os.read(fd, 1 << 16)
        assert piece, "the emulator has ended"
        *lines, self._held = (self._held + piece).split(b"\n")
        found = [json.loads(line) for line in lines]
        if found:
            self.state = found[-1]
        return found


class Turning:
    """:mod:`tests.turning` as a process: a robot that turns on the spot through an emulated board."""

    def __init__(self, port: Path, model: str = "x3plus", lidar: Path | None = None) -> None:
        self._held = b""
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.turning", str(port), model, *([str(lidar)] if lidar is not None else [])],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            cwd=Path(__file__).parents[1],
            start_new_session=True,
        )

    def __enter__(self) -> Turning:
        self.until("ready")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        below = self.engine.children(recursive=True)
        self._process.kill()
        self._process.wait()
        for child in below:
            if child.is_running() and child.status() == psutil.STATUS_STOPPED:
                child.kill()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            pipe.close()

    @property
    def engine(self) -> psutil.Process:
        return psutil.Process(self._process.pid)

    @property
    def host(self) -> psutil.Process:
        (found,) = children("engine.robot.host_main", self._process.pid)
        return found

    @property
    def guard(self) -> psutil.Process:
        (found,) = children("engine.robot.host.guard_main", self._process.pid)
        return found

    def say(self, order: str) -> None:
        """``go`` or ``stop``."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{order}\n".encode())
        self._process.stdin.flush()

    def until(self, event: str, limit_s: float = LIMIT_S) -> dict[str, Any]:
        """The next event of this kind."""
        assert self._process.stdout is not None
        fd, until = self._process.stdout.fileno(), time.monotonic() + limit_s
        while time.monotonic() < until:
            line, newline, rest = self._held.partition(b"\n")
            if newline:
                self._held = rest
                found: dict[str, Any] = json.loads(line)
                if found["event"] == event:
                    return found
            elif select.select([fd], [], [], max(0.0, until - time.monotonic()))[0]:
                piece = os.read(fd, 1 << 16)
                assert piece, "it has ended"
                self._held += piece
        raise AssertionError(f"no {event} within {limit_s:g} s")
