"""What answers on a port: listened to for a moment, without moving anything."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from engine.errors import DeviceError
from engine.framing import Framer
from engine.robot.geometry import ZERO, Twist
from engine.robot.host.guard import guard_of_port
from engine.robot.rosmaster import frames
from engine.robot.rosmaster.frames import ArmAt, Attitude, CarType, FromBoard, Report, Speed, Version
from engine.robot.rosmaster.line import SerialLine


@dataclass(frozen=True, slots=True)
class Inspected:
    """What was found."""

    version: str
    """Of what runs on the board; empty where it does not tell."""
    car_type: int | None
    volts: float
    """Of the battery; 0 where it does not tell."""
    servos: tuple[int, ...]
    """Positions; a negative one did not answer."""
    attitude: bool
    """Whether it tells which way it points."""
    reports: int
    """Frames that came."""


def inspect(port: str, seconds: float) -> Inspected:
    """Ask whatever is on ``port`` for so long. Raises ``DeviceError``, of which ``PortError`` is one."""
    line = SerialLine(port)
    framer: Framer[Report] = Framer(FromBoard())
    version, volts, attitude, reports = "", 0.0, False, 0
    car_type: int | None = None
    servos: tuple[int, ...] = ()
    began = asked = time.monotonic()
    try:
        _ask(line)
        while (now := time.monotonic()) - began < seconds:
            if now - asked > seconds / 3:
                asked = now
                _ask(line)
            if not (data := line.read()):
                time.sleep(0.005)
            for report in framer.push(data):
                reports += 1
                match report:
                    case Version(major, minor):
                        version = f"{major}.{minor}"
                    case CarType(number):
                        car_type = number
                    case Speed(_, measured):
                        volts = measured
                    case ArmAt(pulses):
                        servos = pulses
                    case Attitude():
                        attitude = True
                    case _:
                        pass
    except OSError as error:
        raise DeviceError(f"{port} was unplugged: {error.strerror}.") from error
    finally:
        line.close()
    return Inspected(version, car_type, volts, servos, attitude, reports)


TRIES: Final = 5
HELD_UP_S: Final = 0.08
"""From this long without a sign of life on, a guard may have told the board to stand, and nothing was learned."""


@dataclass(frozen=True, slots=True)
class Silence:
    """What a board did when the line fell silent while it drove."""

    moved: bool
    """Whether it reported motion before; else nothing was learned."""
    stopped_after: float | None
    """s from the last frame to rest; None: it went on driving, until it was told to stand."""


def fall_silent(
    port: str,
    car_type: int,
    stop: Callable[[], bool],
    *,
    speed: float = 0.15,
    drive_s: float = 1.0,
    wait_s: float = 2.0,
) -> Silence:
    """Drive, say nothing any more, and watch: only with the wheels off the floor. It is told to stand in the end,
    whatever becomes of this process, and at once when ``stop`` says so. Raises ``DeviceError`` or ``ProcessError``."""
    for _ in range(TRIES):
        found = _fall_silent(port, car_type, stop, speed, drive_s, wait_s)
        if found is not None:
            return found
    raise DeviceError("This machine is too busy to find out.", hint="Close other programs, and try again.")


def _fall_silent(
    port: str, car_type: int, stop: Callable[[], bool], speed: float, drive_s: float, wait_s: float
) -> Silence | None:
    """One try; None where this process was held up for so long that its guard may have spoken."""
    line, framer = SerialLine(port), Framer[Report](FromBoard())
    guard = guard_of_port(line.fileno(), frames.motion(car_type, ZERO))
    moved, speed_now, heard = False, 0.0, False
    beaten, held_up = time.monotonic(), 0.0

    def listen(seconds: float) -> None:
        nonlocal speed_now, heard, beaten, held_up
        until = time.monotonic() + seconds
        while (now := time.monotonic()) < until:
            guard.beat(now)
            beaten, held_up = now, max(held_up, now - beaten)
            if stop():
                raise DeviceError("The emergency stop is pressed.", hint="sayso robot release")
            for report in framer.push(line.read()):
                if isinstance(report, Speed):
                    speed_now, heard = abs(report.twist.vx), True
            time.sleep(0.005)

    try:
        _ask(line)
        for _ in range(round(drive_s / 0.05)):
            line.write(frames.motion(car_type, Twist(speed)))
            listen(0.05)
            moved = moved or speed_now > speed / 3
        began = time.monotonic()
        while heard and moved and time.monotonic() - began < wait_s:
            listen(0.05)
            if speed_now < speed / 10 or held_up > HELD_UP_S:
                break
        if held_up > HELD_UP_S:
            return None
        return Silence(moved, time.monotonic() - began if moved and speed_now < speed / 10 else None)
    except OSError as error:
        raise DeviceError(f"{port} was unplugged: {error.strerror}.") from error
    finally:
        with contextlib.suppress(OSError):
            for _ in range(5):
                line.write(frames.motion(car_type, ZERO))
                time.sleep(0.02)
        line.close()
        guard.discard()


def _ask(line: SerialLine) -> None:
    for frame in (
        frames.auto_report(True),
        frames.request(frames.VERSION),
        frames.request(frames.CAR_TYPE),
        frames.request(frames.ARM, 1),
    ):
        line.write(frame)
