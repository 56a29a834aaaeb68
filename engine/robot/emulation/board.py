"""A Rosmaster board to test on: the frames of the real one, and the simulated robot behind them.

Bytes come in, bytes go out; :mod:`engine.robot.emulation.line` puts it on a pseudo-terminal. It is as careless as the
real one: it knows no limits and drives on at the last speed that it was told.
"""

from __future__ import annotations

import math
import random
import struct
import time
from dataclasses import dataclass
from typing import Final, Literal, get_args

from engine.framing import Framer
from engine.robot.arm import ARM_JOINTS
from engine.robot.description import Description
from engine.robot.geometry import ZERO, Pose, Twist
from engine.robot.host.body import STEP_S
from engine.robot.rosmaster import frames
from engine.robot.rosmaster.frames import Order, ToBoard
from engine.robot.rosmaster.odometry import counts_of
from engine.robot.rosmaster.servos import Pulses, Servos
from engine.robot.sim.simulated import SimulatedBody

Fault = Literal["silence", "garbage", "stall", "brownout", "servos", "reset"]
"""silence: it sends nothing; garbage: a tenth of what it sends is wrong; stall: nobody takes its bytes or reads them;
brownout: the battery gives 8 V and the motors stand; servos: they do not say where they are; reset: it begins anew, as
when it is switched on."""
FAULTS: Final[tuple[Fault, ...]] = get_args(Fault)

REPORT_STEPS: Final = 5
"""Steps between two reports, of which there are four kinds in turn (10 ms)."""
FULL_V, BROWNOUT_V = 12.4, 8.0
DRAIN_V_S: Final = 0.0004
"""V that the battery loses in a second of standing; ten times that in one of driving."""
CHARGE_V_S: Final = 0.2
"""V that it gains in a second at the dock; a real one takes hours."""
DOCK_M: Final = 0.3
"""As near as this the robot stands at its dock."""
BOOT_S: Final = 0.4
"""s that it says nothing after a reset. (A real one behind a CH341 takes up to 1.5.)"""
_VERSION: Final = (3, 5)


@dataclass(frozen=True, slots=True)
class BoardState:
    """What somebody sees who stands beside the robot."""

    t: float
    x: float
    y: float
    yaw: float
    told: Twist
    speed: Twist
    joints: tuple[float, ...]
    gripper: float
    volts: float
    zeros: int
    """Motion frames that told it to stand, since it was switched on."""
    zero_at: float
    """When the last one came that ended a motion, s of ``time.monotonic()``."""
    orders: int
    """Frames that were understood, since it was switched on."""


class EmulatedBoard:
    """One board, in the robot that ``description`` tells of, whose body is ``body``."""

    def __init__(
        self,
        body: SimulatedBody,
        description: Description,
        *,
        stops_after: float | None = None,
        pull: float = 0.0,
        dock: Pose | None = None,
        seed: int = 0,
    ) -> None:
        """``stops_after``: it stands by itself when no motion frame has come for so long, s; None: it never does.
        ``pull``: by how much it turns on the way ahead without being told to, rad/m. ``dock``: where it is charged."""
        assert description.board is not None, "checked by whoever emulates"
        self._body = body
        self._description = description
        self._random = random.Random(seed)
        self._stops_after = math.inf if stops_after is None else stops_after
        self._pull = pull
        self._dock = dock
        self._told_at = 0.0
        self._servos = Servos(description.arm) if description.arm is not None else None
        self._car_type = description.board.car_type
        self._faults: set[Fault] = set()
        self._volts = FULL_V
        self._steps = 0
        self._zeros = self._orders = 0
        self._zero_at = 0.0
        body.place_arm(body.joints, body.opening)
        self._switch_on(boot_s=0.0)

    def _switch_on(self, boot_s: float) -> None:
        self._framer: Framer[Order] = Framer(ToBoard())
        self._told = ZERO
        self._counts = [0.0, 0.0, 0.0, 0.0]
        self._yaw = self._body.true_pose.yaw
        self._reports = False
        self._torque = True
        self._boots_until = self._body.t + boot_s
        self._out = bytearray()
        self._body.drive(ZERO)
        self._pulses: tuple[int, ...] | None = self._measured() if self._servos is not None else None

    # Faults

    def begin(self, fault: Fault) -> None:
        """Have this go wrong from now on; a reset is over at once."""
        if fault == "reset":
            self._switch_on(BOOT_S)
            return
        self._faults.add(fault)
        if fault == "brownout":
            self._body.drive(ZERO)
            self._told = ZERO

    def end(self, fault: Fault) -> None:
        """Have this go right again. Who comes back from a brown-out begins anew."""
        if fault in self._faults:
            self._faults.discard(fault)
            if fault == "brownout":
                self._switch_on(BOOT_S)

    @property
    def stalled(self) -> bool:
        """Whether it neither reads nor writes."""
        return "stall" in self._faults

    # The line

    def receive(self, data: bytes) -> None:
        """Bytes that have come."""
        for order in self._framer.push(data):
            if self._body.t >= self._boots_until and "brownout" not in self._faults:
                self._orders += 1
                self._obey(order)

    def send(self) -> bytes:
        """Bytes that go out."""
        data = bytes(self._out)
        self._out.clear()
        if "silence" in self._faults or self._body.t < self._boots_until:
            return b""
        if "garbage" in self._faults and data:
            data = bytes(b if self._random.random() < 0.9 else self._random.randrange(256) for b in data)
        return data

    def step(self) -> None:
        """Let ``STEP_S`` pass."""
        self._body.step()
        self._steps += 1
        if self._body.t - self._told_at > self._stops_after and not self._told.is_zero:
            self._told = ZERO
            self._body.drive(ZERO)
        turned = counts_of(self._description, self._body.twist, STEP_S)
        self._counts = [count + more for count, more in zip(self._counts, turned, strict=True)]
        self._use_battery()
        if self._reports and self._steps % REPORT_STEPS == 0:
            self._report(self._steps // REPORT_STEPS % 4)

    @property
    def state(self) -> BoardState:
        body, pose = self._body, self._body.true_pose
        return BoardState(
            round(body.t, 3), pose.x, pose.y, pose.yaw, self._told, body.twist, body.joints, body.opening,
            self._battery, self._zeros, self._zero_at, self._orders,
        )  # fmt: skip

    def give(self, volts: float) -> None:
        """Have a battery that gives so much."""
        self._volts = volts

    # What it does

    def _use_battery(self) -> None:
        pose, dock = self._body.true_pose, self._dock
        if dock is not None and math.dist((pose.x, pose.y), (dock.x, dock.y)) < DOCK_M:
            self._volts = min(FULL_V, self._volts + CHARGE_V_S * STEP_S)
        else:
            self._volts -= DRAIN_V_S * STEP_S * (1 if self._told.is_zero else 10)

    @property
    def _battery(self) -> float:
        return BROWNOUT_V if "brownout" in self._faults else self._volts

    def _obey(self, order: Order) -> None:
        data = order.data
        try:
            match order.function:
                case frames.MOTION:
                    _, *speeds = struct.unpack("<B3h", data)
                    self._drive(Twist(*(speed / 1000 for speed in speeds)))
                case frames.AUTO_REPORT:
                    self._reports = bool(data[0])
                case frames.RGB:
                    self._body.shine((data[1], data[2], data[3]))
                case frames.CAR_TYPE:
                    self._car_type = data[0]
                case frames.TORQUE:
                    self._torque = bool(data[0])
                case frames.SERVO:
                    number, pulse, _ = struct.unpack("<B2h", data)
                    if self._pulses is not None and 1 <= number <= frames.SERVOS:
                        self._turn((*self._pulses[: number - 1], pulse, *self._pulses[number:]))
                case frames.ARM:
                    one, two, three, four, five, six, _ = struct.unpack("<7h", data)
                    self._turn((one, two, three, four, five, six))
                case frames.REQUEST:
                    self._answer(data[0])
                case _:
                    pass
        except (struct.error, IndexError):
            pass  # a frame of the right sum and the wrong length: the real one does nothing either

    def _drive(self, twist: Twist) -> None:
        if twist.is_zero:
            self._zeros += 1
            if not self._told.is_zero:
                self._zero_at = time.monotonic()
        self._told, self._told_at = twist, self._body.t
        self._body.drive(Twist(twist.vx, twist.vy, twist.wz + self._pull * twist.vx))

    def _turn(self, pulses: tuple[int, ...]) -> None:
        if self._servos is None or not self._torque:
            return
        self._pulses = pulses
        self._body.place_arm(self._servos.angles(pulses), self._servos.opening(pulses))

    def _measured(self) -> Pulses:
        assert self._servos is not None, "whoever asks knows that there are some"
        return self._servos.pulses(self._body.joints[: len(ARM_JOINTS)], self._body.opening)

    def _answer(self, function: int) -> None:
        match function:
            case frames.ARM if self._servos is not None and "servos" not in self._faults:
                self._put(frames.ARM, struct.pack("<6h", *self._measured()))
            case frames.VERSION:
                self._put(frames.VERSION, bytes(_VERSION))
            case frames.CAR_TYPE:
                self._put(frames.CAR_TYPE, bytes((self._car_type,)))
            case _:
                pass

    def _report(self, kind: int) -> None:
        match kind:
            case 0:
                twist = self._body.twist
                speeds = (_short(1000 * value) for value in (twist.vx, twist.vy, twist.wz))
                self._put(frames.SPEED, struct.pack("<3hB", *speeds, round(10 * self._battery)))
            case 1:
                self._put(frames.RAW, bytes(18))
            case 2:
                turned = math.remainder(self._body.true_pose.yaw - self._yaw, 2 * math.pi)
                self._put(frames.ATTITUDE, struct.pack("<3h", 0, 0, _short(10000 * turned)))
            case _:
                counts = (math.floor(count + 0.5) for count in self._counts)
                wrapped = ((count + (1 << 31)) % (1 << 32) - (1 << 31) for count in counts)
                self._put(frames.ENCODERS, struct.pack("<4i", *wrapped))

    def _put(self, kind: int, data: bytes) -> None:
        self._out += frames.report_bytes(kind, data)


def _short(value: float) -> int:
    return max(-32768, min(32767, round(value)))
