"""The emulated board on a pseudo-terminal, in real time.

A path leads to the terminal, so that it keeps its name when the cable is pulled out and put back. What is to go wrong
comes as lines of text, what the robot does goes out as states; who runs this decides where from and where to.
"""

from __future__ import annotations

import contextlib
import os
import pty
import select
import time
import tty
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final, Protocol

from engine.errors import DeviceError, UsageError
from engine.robot.emulation.board import FAULTS, BoardState, EmulatedBoard
from engine.robot.emulation.lidar import EmulatedLidar
from engine.robot.host.body import STEP_S

STATE_S: Final = 0.05
"""Between two states that are told."""
COMMANDS: Final = (
    *(f"{fault} on" for fault in FAULTS if fault != "reset"),
    *("reset", "unplug", "plug", "volts V", "quit"),
)
"""What it understands; a fault ends with ``off``. ``unplug lidar`` and ``plug lidar`` are for the other cable."""
_LEAST_DEBT: Final = 0.1
"""s that real time may run ahead before it is let go."""


class Commands(Protocol):
    """Where commands come from."""

    def fileno(self) -> int:
        """Something to wait for."""
        ...

    def lines(self) -> list[str] | None:
        """Those that have come; None when no more will."""
        ...


class Device(Protocol):
    """What is at the other end of a line."""

    def receive(self, data: bytes) -> None: ...
    def send(self) -> bytes: ...


class Line:
    """The pseudo-terminal behind ``path``. Whoever makes it closes it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.master: int | None = None
        self._slave = -1

    def plug(self) -> None:
        """Be there. Raises :class:`DeviceError`."""
        if self.master is not None:
            return
        if self.path.exists():  # a link that leads nowhere is what a killed emulator leaves
            raise DeviceError(f"There is a {self.path} already.", hint="Name another path with --port.")
        try:
            self.master, self._slave = pty.openpty()
            tty.setraw(self._slave)
            os.set_blocking(self.master, False)
            self.path.unlink(missing_ok=True)
            self.path.symlink_to(os.ttyname(self._slave))
        except OSError as error:
            self.unplug()
            raise DeviceError(f"No terminal at {self.path}: {error}.") from error

    def unplug(self) -> None:
        """Be gone, and the device with it."""
        master, self.master = self.master, None
        if master is None:
            return
        os.close(master)
        os.close(self._slave)
        with contextlib.suppress(OSError):
            self.path.unlink()

    def exchange(self, device: Device) -> None:
        """What has come to the device, and what it sends back. A line that nobody reads loses it, as real ones do."""
        if self.master is None:
            device.send()
            return
        with contextlib.suppress(BlockingIOError):
            device.receive(os.read(self.master, 4096))
        if data := device.send():
            with contextlib.suppress(BlockingIOError):
                os.write(self.master, data)


def run(
    line: Line,
    board: EmulatedBoard,
    commands: Commands,
    tell: Callable[[BoardState], object],
    eyes: tuple[Line, EmulatedLidar] | None = None,
) -> None:
    """Run until told to quit, or until no more commands can come; ``eyes`` is a lidar on the robot, and its line.
    Raises :class:`DeviceError`."""
    cables = {"": line, **({"lidar": eyes[0]} if eyes is not None else {})}
    try:
        for cable in cables.values():
            cable.plug()
        deadline, told = time.monotonic(), 0.0
        while True:
            now = time.monotonic()
            if now - deadline > _LEAST_DEBT:
                deadline = now
            if now >= deadline:
                deadline += STEP_S
                board.step()
                if not board.stalled:
                    line.exchange(board)
                if eyes is not None:
                    eyes[1].step()
                    eyes[0].exchange(eyes[1])
                if now - told >= STATE_S:
                    told = now
                    tell(board.state)
                continue
            waits = [commands.fileno(), *([] if line.master is None or board.stalled else [line.master])]
            ready = select.select(waits, [], [], max(0.0, deadline - time.monotonic()))[0]
            if line.master in ready:
                line.exchange(board)
            if commands.fileno() in ready:
                lines = commands.lines()
                if lines is None or any(obey(text, cables, board) for text in lines):
                    return
    finally:
        for cable in cables.values():
            cable.unplug()


def obey(text: str, cables: Mapping[str, Line], board: EmulatedBoard) -> bool:
    """Do what a line of text says; whether to quit. Raises :class:`UsageError`."""
    words = text.split()
    match words:
        case ["quit"]:
            return True
        case ["unplug" | "plug" as what, *which] if (cable := cables.get(" ".join(which))) is not None:
            (cable.plug if what == "plug" else cable.unplug)()
        case ["reset"]:
            board.begin("reset")
        case ["volts", number] if number.replace(".", "", 1).isdecimal():
            board.give(float(number))
        case [fault, "on" | "off" as switch] if fault in FAULTS:
            chosen = next(known for known in FAULTS if known == fault)
            (board.begin if switch == "on" else board.end)(chosen)
        case []:
            pass
        case _:
            raise UsageError(
                f"{text.strip()!r} is nothing an emulated board knows.", hint=f"It knows: {'; '.join(COMMANDS)}."
            )
    return False
