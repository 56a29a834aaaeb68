"""``sayso robot drive``: by hand from the keyboard, without the rest of sayso.

A terminal tells that a key was pressed, again and again while it is held down. Each time the robot is told to drive,
for as long as the command lifetime; so it stands a moment after the key was let go, or the line has broken.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import os
import sys
import termios
import tty
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from engine.errors import ExitCode, UsageError
from engine.robot.geometry import heading_in_degrees
from tui.keys.speeds import SPEEDS, TURN
from tui.output import say

if TYPE_CHECKING:
    from config.schema import Settings
    from engine.parts.estop import EmergencyStop
    from engine.robot.robot import Robot, RobotState

_WAYS: Final = {
    "w": (1, 0, 0), "s": (-1, 0, 0), "a": (0, 0, 1), "d": (0, 0, -1), ",": (0, 1, 0), ".": (0, -1, 0),
    "\x1b[A": (1, 0, 0), "\x1b[B": (-1, 0, 0), "\x1b[D": (0, 0, 1), "\x1b[C": (0, 0, -1),
    "\x1bOA": (1, 0, 0), "\x1bOB": (-1, 0, 0), "\x1bOD": (0, 0, 1), "\x1bOC": (0, 0, -1),
}  # fmt: skip
"""Forward, left and turn, by what the keyboard sends."""
HELP: Final = (
    "w s or ↑ ↓ drive, a d or ← → turn, , . aside, + - speed, space stops, x emergency stop, r releases, q quits"
)


def run(settings: Settings) -> int:
    """Drive until ``q``, or until the keyboard is gone. Raises ``RobotError``, ``DeviceError`` or ``SceneError``."""
    if not sys.stdin.isatty():
        raise UsageError(
            "Driving by hand needs a keyboard.", hint='Programs drive with {"do":"drive"} through `sayso engine`.'
        )
    say(f"sayso: {HELP}")
    with _every_key():
        return asyncio.run(_drive(settings))


@contextlib.contextmanager
def _every_key() -> Iterator[None]:
    """Keys arrive at once, and are not shown."""
    before = termios.tcgetattr(0)
    tty.setcbreak(0)
    try:
        yield
    finally:
        termios.tcsetattr(0, termios.TCSADRAIN, before)


async def _drive(settings: Settings) -> int:
    from config import paths
    from engine.parts.estop import EmergencyStop
    from engine.robot.bodies import make_robot
    from engine.robot.watch import beat

    robot = make_robot(settings.robot.model_copy(update={"speed": "real"}))
    estop = EmergencyStop(paths().estop, robot.press, lambda pressed: hand.press(pressed))
    hand = _Hand(robot, estop)
    await robot.start()
    loop = asyncio.get_running_loop()
    loop.add_reader(0, hand.read)
    tasks = [
        asyncio.create_task(beat(robot)),
        asyncio.create_task(estop.keep()),
        asyncio.create_task(hand.show()),
        asyncio.create_task(hand.ended.wait()),
    ]
    try:
        done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        for task in done:
            task.result()  # a robot that is gone says so
    finally:
        loop.remove_reader(0)
        robot.stop(hand.epoch + 1)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await robot.close()
        say("")
    return int(ExitCode.DONE)


class _Hand:
    """Keys in, velocities out."""

    def __init__(self, robot: Robot, estop: EmergencyStop) -> None:
        self._robot = robot
        self._estop = estop
        self._step = 1
        self.epoch = 1
        self.ended = asyncio.Event()

    def read(self) -> None:
        """What the keyboard has sent."""
        data = os.read(0, 256)
        if not data:
            self.ended.set()
            return
        keys = data.decode(errors="replace")
        while keys:
            key = next((known for known in _WAYS if keys.startswith(known)), keys[0])
            keys = keys[len(key) :]
            self._take(key)

    def _take(self, key: str) -> None:
        from engine.robot.geometry import Twist

        speed = SPEEDS[self._step]
        match key:
            case _ if key in _WAYS:
                ahead, left, turn = _WAYS[key]
                if self._robot.state().halted:
                    self._begin_anew()
                self._robot.drive(Twist(ahead * speed, left * speed, turn * speed * TURN), self.epoch)
            case "+" | "=":
                self._step = min(len(SPEEDS) - 1, self._step + 1)
            case "-":
                self._step = max(0, self._step - 1)
            case " ":
                self._begin_anew()
            case "x":
                self.press(True)
            case "r":
                self.press(False)
            case "q" | "\x04":
                self.ended.set()
            case _:
                pass

    def press(self, pressed: bool) -> None:
        """Press the emergency stop, or release it."""
        self._estop.press(pressed)
        self._begin_anew()

    def _begin_anew(self) -> None:
        self.epoch += 1
        self._robot.stop(self.epoch)

    async def show(self) -> None:
        """How it stands, on one line."""
        while True:
            print(f"\r{_line(self._robot.state(), SPEEDS[self._step])}\x1b[K", end="", flush=True)  # noqa: T201
            await asyncio.sleep(0.1)


def _line(state: RobotState, speed: float) -> str:
    pose, twist = state.pose, state.twist
    why = "E-STOP: r releases" if state.estop else state.held_back or ""
    volts = f"  {state.battery.volts:.1f} V" if state.battery else ""
    return (
        f"{speed:g} m/s  x {pose.x:.2f} y {pose.y:.2f} {heading_in_degrees(pose.yaw):3.0f}°"
        f"  {twist.vx:5.2f} {twist.vy:5.2f} m/s {math.degrees(twist.wz):4.0f}°/s"
        f"{volts}  {why}"
    )
