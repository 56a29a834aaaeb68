"""What answers on a port: listened to for a moment, without moving anything."""

from __future__ import annotations

import time
from dataclasses import dataclass

from engine.errors import DeviceError
from engine.framing import Framer
from engine.robot.rosmaster import frames
from engine.robot.rosmaster.frames import ArmAt, CarType, FromBoard, Report, Speed, Version
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
    reports: int
    """Frames that came."""


def inspect(port: str, seconds: float) -> Inspected:
    """Ask whatever is on ``port`` for so long. Raises ``DeviceError``, of which ``PortError`` is one."""
    line = SerialLine(port)
    framer: Framer[Report] = Framer(FromBoard())
    version, volts, reports = "", 0.0, 0
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
                    case _:
                        pass
    except OSError as error:
        raise DeviceError(f"{port} was unplugged: {error.strerror}.") from error
    finally:
        line.close()
    return Inspected(version, car_type, volts, servos, reports)


def _ask(line: SerialLine) -> None:
    for frame in (
        frames.auto_report(True),
        frames.request(frames.VERSION),
        frames.request(frames.CAR_TYPE),
        frames.request(frames.ARM, 1),
    ):
        line.write(frame)
