"""A robot with a Rosmaster motor board, as a body of the host.

The board drives at the last speed that it was told until it is told another, so this keeps telling: at once when the
speed changes, twenty times a second when it does not. Frames that are written into a stalled line would come late; a
zero is put before everything that waits. Beside it a guard holds the same port (``engine.robot.host.guard``).

Whenever the line is gone, silent or stalled, or the guard is, this says so (``trouble``), and the host stands. It opens
the port again as soon as that is there.
"""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from engine.errors import DeviceError, ProcessError
from engine.framing import Framer
from engine.robot.arm import ARM_JOINTS
from engine.robot.description import Description
from engine.robot.geometry import ZERO, Pose, Twist
from engine.robot.host.controller import added_up
from engine.robot.host.guard import Guard, guard_of_port
from engine.robot.host.memory import Record
from engine.robot.rosmaster import frames
from engine.robot.rosmaster.frames import ArmAt, Attitude, Encoders, FromBoard, Report, Speed
from engine.robot.rosmaster.line import Line, Opener, SerialLine
from engine.robot.rosmaster.odometry import Odometry
from engine.robot.rosmaster.servos import Servos
from engine.robot.surroundings import Surroundings
from engine.serial_port import PortError

if TYPE_CHECKING:
    from engine.robot.usb_lidar import UsbLidar

REPEAT_S: Final = 0.05
"""Between two motion frames of the same speed."""
SILENCE_S: Final = 0.25
"""From this long without a report, the board counts as silent; it sends one every 10 ms."""
EMPTY_S: Final = 0.15
"""For so long the battery must give too little to count as empty: a start takes some volts for a moment."""
STALL_S: Final = 0.15
"""From this long without a byte that could be written, the line counts as stalled."""
ARM_S: Final = 0.02
"""Between two frames to the servos; they are given twice that to get there."""
SLEW: Final = 80
"""Most by which a servo's position changes from one frame to the next, 5.7 rad/s: whatever goes wrong, no arm jumps."""
LAG: Final = 0.5
"""By how much a servo's reading may be behind what it was told, rad: it is asked ten times a second."""
ARM_QUERY_S: Final = 0.1
"""Between two questions where the servos are. While they have never answered, none is moved: nobody knows how far."""
ASK_S: Final = 0.4
"""Between two tries to have the board report."""
STEERING: Final = math.radians(30)
"""To which front wheels can be steered."""
LOOK_S: Final = 0.1
"""Between two tries to open the port, or to start a guard."""
OPEN_LIMIT_S: Final = 4.0
"""In which a board must report after its port was opened: some reset for 1.5 s."""
NO_GUARD: Final = "the guard process was lost"
BUSY_LIMIT_S: Final = 1.5
"""In which a guard of ours that was left behind lets go of the port."""

Clock = Callable[[], float]


class RosmasterBody:
    """A :class:`engine.robot.host.body.Body` behind a serial port."""

    def __init__(
        self,
        port: str,
        description: Description,
        start: Pose,
        last: Record | None = None,
        *,
        guarded: bool = True,
        clock: Clock = time.monotonic,
        open_line: Opener = SerialLine,
        lidar: UsbLidar | None = None,
    ) -> None:
        """Open the port and wait until the board reports. ``start`` is where odometry begins, ``last`` the state to go
        on from. ``lidar`` is closed with it, and has the same clock. Raises ``DeviceError``; of a port that cannot be
        opened, ``PortError``."""
        assert description.board is not None, "checked by whoever has chosen this body"
        self._path = port
        self._description = description
        self._car_type = description.board.car_type
        self._guarded = guarded
        self._guard_looked = -math.inf
        self._rest = frames.motion(self._car_type, ZERO)
        self._clock = clock
        self._open_line = open_line
        self._began = clock() - (float(last["t"]) if last is not None else 0.0)
        self._line: Line | None = None
        self._guard: Guard | None = None
        self._framer: Framer[Report] = Framer(FromBoard())
        self._heard = self._asked = self._written = self._looked = -math.inf
        self._left = b""  # of a frame that was written in part
        self._told, self._told_at = ZERO, -math.inf
        self._servos = Servos(description.arm) if description.arm is not None else None
        self._placed: tuple[int, ...] | None = None  # what the servos were told last
        self._read_when: tuple[int, ...] | None = None  # what they had been told when they said where they were
        self._read_at = -math.inf
        self._to_place: tuple[int, ...] | None = None
        self._placed_at = self._arm_asked = -math.inf
        self._joints: tuple[float, ...] = (0.0,) * len(ARM_JOINTS)
        self._opening = 0.0
        self._light: tuple[int, int, int] | None = None
        self._twist, self._twist_at = ZERO, -math.inf
        self._odometry = Odometry(description, start if last is None else added_up(last))
        self._lidar = lidar
        about = description.lidar
        self._around = Surroundings(about.at, about.nearest) if about is not None else None
        self.volts = 0.0
        self._battery = description.board.battery
        self._sagged: float | None = None  # since when
        self.trouble = "the board has not been opened"
        if last is not None:
            self._joints, self._opening = tuple(last["joints"].tolist()), float(last["gripper"])
        self._open_first()

    def _open_first(self) -> None:
        """Wait for the board, for as long as its reset takes."""
        limit = self._clock() + BUSY_LIMIT_S
        while self._line is None:
            try:
                self._open(self._clock())
            except PortError as error:
                if error.reason != "busy" or self._clock() > limit:
                    raise
                time.sleep(0.05)
        limit = self._clock() + OPEN_LIMIT_S
        while self.trouble or (self._servos is not None and self._servos.known is None and self._clock() < limit - 2.0):
            if self._clock() > limit:
                why = self.trouble
                self.close()
                raise DeviceError(
                    f"No Rosmaster board can be driven on {self._path}: {why}.",
                    hint="Is the robot switched on? `sayso robot check` looks closer.",
                )
            self.step()
            time.sleep(0.002)

    # What a body is

    @property
    def t(self) -> float:
        return self._clock() - self._began

    @property
    def twist(self) -> Twist:
        """As the board says; where it says nothing, what it was told."""
        return self._twist if self._clock() - self._twist_at < SILENCE_S else self._told

    @property
    def joints(self) -> tuple[float, ...]:
        return self._joints

    @property
    def lag(self) -> float:
        return LAG

    @property
    def guard_pid(self) -> int:
        return self._guard.pid if self._guard is not None else 0

    @property
    def opening(self) -> float:
        return self._opening

    def step(self) -> None:
        now = self._clock()
        if self._line is None:
            if now - self._looked >= LOOK_S:
                with contextlib.suppress(PortError):
                    self._open(now)
            return
        was = self.trouble
        try:
            self._hear(self._line, now)
            self._say(self._line, now)
        except OSError:
            self._lose(f"{self._path} was unplugged", now)
            return
        self._look_after(self._line, now, was)

    def drive(self, twist: Twist) -> None:
        limited = self._within(twist) if not self.trouble else ZERO
        if limited == self._told:
            return
        self._told = limited
        if self._line is not None:
            with contextlib.suppress(OSError):  # the next step finds out
                self._tell_speed(self._line, self._clock())

    def place_arm(self, joints: Sequence[float], opening: float) -> None:
        if self._servos is None:
            return
        self._to_place = self._servos.pulses(joints, opening)

    def shine(self, rgb: tuple[int, int, int]) -> None:
        self._light = rgb
        self._send(frames.light(*rgb))

    def beep(self, seconds: float) -> None:
        self._send(frames.beep(round(1000 * seconds)))

    def odometry(self) -> Pose:
        pose = self._odometry.pose
        if self._lidar is not None and self._around is not None:
            self._around.was(self._clock(), pose)
        return pose

    def scan(self) -> NDArray[np.float64] | None:
        turn = self._lidar.newest() if self._lidar is not None else None
        if turn is None or self._around is None:
            return None
        return self._around.scan(turn, self._clock(), self._odometry.pose)

    def fill(self, record: Record) -> None:
        record["volts"] = self.volts

    def close(self) -> None:
        self._lose("it has been closed", self._clock())
        if self._lidar is not None:
            self._lidar.close()

    # The port

    def _open(self, now: float) -> None:
        """Raises :class:`PortError`. The board may be driving: before anything else it is told to stand."""
        self._looked = now
        line = self._open_line(self._path)
        with contextlib.suppress(OSError):  # the next step finds out
            line.write(self._rest)
        self._line = line
        self._framer = Framer(FromBoard())
        self._left, self._told = b"", ZERO
        self._heard, self._asked, self._written, self._told_at = -math.inf, -math.inf, now, -math.inf
        if self._servos is not None:  # it may have sunk, or been bent
            self._servos.forget()
        self._placed = self._to_place = None
        self.trouble = f"the board on {self._path} has not answered yet"
        self._begin_guard(line, now)

    def _lose(self, why: str, now: float) -> None:
        self.trouble = why
        self._told, self._twist, self._looked = ZERO, ZERO, now
        line, self._line = self._line, None
        if line is not None:
            with contextlib.suppress(OSError):  # gone indeed
                if self._left:
                    line.forget()  # nothing goes before it
                line.write(self._rest)
            line.close()
        self._end_guard()

    def _begin_guard(self, line: Line, now: float) -> None:
        """Have a guard; where none can be started, the board stands until one can."""
        if not self._guarded:
            return
        self._guard_looked = now
        try:
            self._guard = guard_of_port(line.fileno(), self._rest)
        except (ProcessError, OSError):
            self._complain(NO_GUARD)

    def _end_guard(self) -> None:
        guard, self._guard = self._guard, None
        if guard is not None:
            guard.discard()

    def _look_after(self, line: Line, now: float, was: str) -> None:
        """Whether everything is as it must be for driving; trouble that there ``was`` before this step may be over, for
        the host has seen it."""
        if self._guarded and not (self._guard is not None and self._guard.beat(now)):
            self._complain(NO_GUARD)
            if now - self._guard_looked >= LOOK_S:
                self._end_guard()
                self._begin_guard(line, now)
        elif self._left and now - self._written > STALL_S:
            self._complain(f"{self._path} takes no bytes")
        elif now - self._heard > SILENCE_S:
            self._complain(f"the board on {self._path} is silent")
        elif self._sagged is not None and now - self._sagged > EMPTY_S:
            self._complain(f"the battery is empty ({self.volts:.1f} V)")
        elif was and self.trouble and (self._guard is None or self._guard.watches):
            self.trouble = ""

    def _complain(self, why: str) -> None:
        if not self.trouble:
            self.trouble = why
            self._told, self._twist, self._told_at = ZERO, ZERO, -math.inf  # and the next step says so

    # What it tells

    def _hear(self, line: Line, now: float) -> None:
        for report in self._framer.push(line.read()):
            self._heard = now
            self._take(report, now)

    def _take(self, report: Report, now: float) -> None:
        match report:
            case Speed(twist, volts):
                self._odometry.speed(twist, now - self._twist_at)
                self._twist, self._twist_at = twist, now
                self.volts = volts
                if volts >= self._battery.empty or volts == 0:
                    self._sagged = None
                elif self._sagged is None:
                    self._sagged = now
            case Attitude(_, _, yaw):
                self._odometry.attitude(yaw, now)
            case Encoders(counts):
                self._odometry.encoders(counts, now)
            case ArmAt(pulses) if self._servos is not None:
                self._take_arm(self._servos, pulses)
            case _:
                pass

    def _take_arm(self, servos: Servos, pulses: Sequence[int]) -> None:
        """Where the servos are; whoever moves the arm begins there."""
        were_known = servos.known is not None
        servos.read(pulses)
        if (known := servos.known) is None:
            return
        if not were_known:
            self._placed, self._to_place = known, None
            self._complain("the arm has only now said where it is")
        self._read_when, self._read_at = self._placed, self._clock()
        self._joints, self._opening = servos.angles(known), servos.opening(known)

    def _reckon(self, servos: Servos, now: float) -> None:
        """Where the arm is between two readings: as far from the last one as it was told to go since. A camera on it
        would else look from where it was."""
        known, placed, then = servos.known, self._placed, self._read_when
        if known is None or placed is None or then is None or now - self._read_at > 2 * ARM_QUERY_S:
            return
        told = zip(servos.angles(known), servos.angles(placed), servos.angles(then), strict=True)
        self._joints = tuple(at + to - since for at, to, since in told)

    # What it is told

    def _say(self, line: Line, now: float) -> None:
        self._push(line, now)
        if now - self._heard > SILENCE_S and now - self._asked >= ASK_S:
            self._asked = now
            self._greet(line, now)
        if now - self._told_at >= REPEAT_S:
            self._tell_speed(line, now)
        if self._servos is None or self.trouble:
            return
        wanted, at = self._to_place, self._placed
        if wanted is not None and at is not None and wanted != at and now - self._placed_at >= ARM_S:
            following = tuple(a + max(-SLEW, min(SLEW, w - a)) for w, a in zip(wanted, at, strict=True))
            if self._write(line, frames.arm(following, round(2000 * ARM_S)), now):
                self._placed, self._placed_at = following, now
                self._reckon(self._servos, now)
        elif now - self._arm_asked >= ARM_QUERY_S:
            self._arm_asked = now
            self._write(line, frames.request(frames.ARM, 1), now)

    def _greet(self, line: Line, now: float) -> None:
        """What a board must know that was just switched on."""
        self._write(line, frames.auto_report(True), now)
        if self._servos is not None:
            self._write(line, frames.torque(True), now)
            self._write(line, frames.request(frames.ARM, 1), now)
        if self._light is not None:
            self._write(line, frames.light(*self._light), now)

    def _tell_speed(self, line: Line, now: float) -> None:
        """A zero goes before everything that still waits to be written."""
        if self._told.is_zero and self._left:
            line.forget()
            self._left = b""
        if self._write(line, frames.motion(self._car_type, self._trimmed(self._told)), now):
            self._told_at = now

    def _send(self, frame: bytes) -> None:
        if self._line is not None:
            with contextlib.suppress(OSError):  # the next step finds out
                self._write(self._line, frame, self._clock())

    def _write(self, line: Line, frame: bytes, now: float) -> bool:
        """Write a frame, or nothing while a part of another still waits."""
        if self._left:
            return False
        self._left = frame
        self._push(line, now)
        return True

    def _push(self, line: Line, now: float) -> None:
        if not self._left:
            self._written = now
        elif count := line.write(self._left):
            self._left, self._written = self._left[count:], now

    def _trimmed(self, twist: Twist) -> Twist:
        """What the motors are told to have the robot move like this, though it pulls to a side; rest stays rest."""
        turn = self._description.trim * twist.vx
        return self._within(Twist(twist.vx, twist.vy, twist.wz + turn)) if turn else twist

    def _within(self, twist: Twist) -> Twist:
        """What this robot's drive can do."""
        limited, wheels = self._description.speeds.within(twist), self._description.wheels
        if self._description.drive != "ackermann":
            return limited
        assert wheels is not None, "a board has wheels"
        turn = abs(limited.vx) * math.tan(STEERING) / wheels.base  # as far as the front wheels can be steered
        return Twist(limited.vx, limited.vy, max(-turn, min(turn, limited.wz)))
