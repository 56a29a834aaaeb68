"""The protocol that every robot speaks, and what it tells of itself; frames are those of ``geometry.py``.

Two rules hold for every robot. **Stop wins**: :meth:`Robot.stop` may be called from any thread, never blocks, and
takes effect in the robot's next control tick. **Epochs**: every command carries the epoch it belongs to, and the robot
ignores commands of any epoch but the one last given to ``stop`` (1 before that), so a late command of an interrupted
plan cannot move anything.

Beside them a robot can **pause**: whoever suspects that it is to stop has it stand at once, and lets it go on when that
was an error. A pause belongs to its epoch, ends with it, and becomes a halt when nobody decides: it errs on the side of
standing still.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from engine.robot.arm import ArmModel, Joints
from engine.robot.camera import Picture
from engine.robot.company import Company
from engine.robot.floor_map import FloorMap
from engine.robot.geometry import Pose, Twist

Capability = Literal["base", "arm", "camera", "voice"]

PAUSE_LIMIT_S: Final = 1.5
"""A pause that nobody has ended after this makes the robot halt, s."""
EMERGENCY_STOP: Final = "the emergency stop is pressed"
"""Why it has halted then."""
SLOWEST: Final = 0.1
"""The smallest speed limit, as a share of what the envelope allows: slower, a drive would count as held back."""
UNDECIDED: Final = "somebody may have said stop, and this could not be checked"
"""Why it has halted then."""


@dataclass(frozen=True, slots=True)
class BatteryState:
    """What a battery gives."""

    volts: float
    charge: float  # about how much is left, 0…1
    low: bool  # it wants to be charged


Faring = Literal["going", "arrived", "failed", "canceled", "rejected", "no_server", "timed_out", "lost", "bad_type"]
"""How a robot that finds its way itself fares: under way, there, or why not (``engine.ros.door.Code``)."""


@dataclass(frozen=True, slots=True)
class Going:
    """Where a robot that finds its way itself was last told to go."""

    ticket: int  # what ``Robot.go`` gave
    how: Faring
    left: float  # m that are left of its way, where it tells; else nan
    code: int = 0  # its own number for what went wrong (nav2_msgs)
    why: str = ""  # in words, where it says any


@dataclass(frozen=True, slots=True)
class RobotState:
    """One snapshot of the robot."""

    t: float  # s, the robot's own clock: simulated time in the simulation
    epoch: int  # the epoch whose commands the robot accepts
    pose: Pose  # as the robot believes: odometry
    twist: Twist  # measured, base frame
    command: Twist  # what the motors are told in this tick, after the safety envelope
    joints: Joints  # measured
    joint_targets: Joints
    gripper: float  # measured opening, 0 closed … 1 open
    light: tuple[int, int, int]  # RGB 0…255
    blocked: str | None  # what the obstacle stop reacts to, in words ("obstacle 0.05 m ahead")
    halted: str | None  # why the robot stopped itself ("heartbeat lost"), None in normal operation
    halted_in: int | None = None  # the epoch in which it did; only a newer one lets it move again
    grip: float = 0.0  # what the gripper is told, as ``gripper``: less than that while it presses on something
    paused: bool = False  # it stands until it is resumed
    paused_s: float = 0.0  # s of ``t`` in which it was paused
    estop: bool = False  # the emergency stop is pressed
    speed_limit: float = 1.0  # share of the envelope's speeds that is allowed now
    battery: BatteryState | None = None  # where something measures it
    going: Going | None = None  # of a robot that finds its way itself
    arm_fault: str = ""  # why an arm that finds its own way did not carry out its last motion, in words for people

    @property
    def work_t(self) -> float:
        """The clock that stands while the robot is paused, s: whoever gives it so much time for something means this
        one."""
        return self.t - self.paused_s

    @property
    def held_back(self) -> str | None:
        """Why it does not move, for people. A robot takes a moment to notice that its emergency stop is released."""
        released = self.halted == EMERGENCY_STOP and not self.estop
        return (None if released else self.halted) or self.blocked

    @property
    def moving(self) -> bool:
        """The base still moves or is told to (3 mm/s and 0.6°/s count as rest)."""
        t = self.twist
        return not self.command.is_zero or math.hypot(t.vx, t.vy) > 0.003 or abs(t.wz) > 0.01


@dataclass(frozen=True, slots=True)
class Scan:
    """One turn of the lidar: ``ranges[i]`` is the distance in m from the robot's centre in direction ``angles[i]``
    (rad, base frame); inf where nothing was hit within range."""

    t: float
    angles: NDArray[np.float64]  # shape (n,)
    ranges: NDArray[np.float64]  # shape (n,)

    def on_map(self, pose: Pose, within: float) -> NDArray[np.float64]:
        """What was hit within so many m, seen from ``pose``: points in the map frame, shape (n, 2)."""
        near = self.ranges < within
        angles, ranges = self.angles[near] + pose.yaw, self.ranges[near]
        return np.column_stack((pose.x + ranges * np.cos(angles), pose.y + ranges * np.sin(angles)))


@dataclass(frozen=True, slots=True)
class Footprint:
    """The hull, seen from above, as a rectangle centred on the robot."""

    length: float  # m, along x
    width: float  # m, along y

    @property
    def radius(self) -> float:
        """Of the circle around the rectangle, m."""
        return math.hypot(self.length, self.width) / 2


class Robot(Protocol):
    """A robot, as the engine sees it. Opened by ``start``, closed by ``close``."""

    @property
    def name(self) -> str:
        """For people: ``simulated robot (flat)``."""
        ...

    @property
    def capabilities(self) -> frozenset[Capability]:
        """What this robot has; skills that need more are not offered."""
        ...

    @property
    def footprint(self) -> Footprint: ...

    @property
    def floor_map(self) -> FloorMap: ...

    @property
    def arm(self) -> ArmModel:
        """The geometry of its arm and of the camera on it."""
        ...

    @property
    def navigates(self) -> bool:
        """Whether it may find its way itself (``go``)."""
        ...

    @property
    def company(self) -> Company | None:
        """The people around it where a simulation plays them; real ones hear the loudspeaker."""
        ...

    async def start(self) -> None:
        """Connect, or start the process. Raises ``RobotError`` or ``DeviceError``.

        After a loss it may be called again: the robot then stands where it was.
        """
        ...

    async def close(self) -> None:
        """Stop the robot and release everything."""
        ...

    def stop(self, epoch: int) -> None:
        """Halt all motion and accept only commands of ``epoch`` from now on. Thread-safe, never blocks.

        The base goes to zero velocity, the arm holds where it is, the gripper keeps its grip.
        """
        ...

    def press(self, pressed: bool) -> None:
        """Press the emergency stop, or release it. While it is pressed nothing moves, in no epoch, and it stays so over
        a loss of the robot; after it was released, a new epoch is needed. Thread-safe, never blocks."""
        ...

    def limit_speed(self, share: float) -> None:
        """Drive no faster than this share, ``SLOWEST`` … 1, of what the safety envelope allows; what drives already
        gets slower, and no epoch changes that. A robot that finds its way itself chooses its speed on the way there.
        Thread-safe, never blocks."""
        ...

    def pause(self, epoch: int) -> int:
        """Come to rest as gently as it drives, and stand until :meth:`resume`, the arm where it is. Thread-safe, never
        blocks. What is commanded meanwhile waits, velocities are forgotten, and no tick comes.

        It only holds while ``epoch`` is in force. A robot that is still paused after ``PAUSE_LIMIT_S`` halts. Gives
        the token for :meth:`resume`; of several pauses the newest counts.
        """
        ...

    def resume(self, token: int) -> None:
        """Go on; nothing happens when that pause is not the one in force any more. Thread-safe, never blocks."""
        ...

    def heartbeat(self) -> None:
        """Tell the robot that the engine lives; without it the robot halts by itself, and stays halted until a new
        epoch begins. Thread-safe."""
        ...

    def state(self) -> RobotState:
        """The newest snapshot; thread-safe and cheap. Raises ``RobotError`` when the robot is gone."""
        ...

    def scan(self) -> Scan:
        """The newest lidar scan; thread-safe."""
        ...

    async def look(self) -> Picture:
        """Take a picture now. Raises ``CameraError`` when the camera does not deliver one.

        In a simulation at full speed no time passes meanwhile.
        """
        ...

    def relocate(self, believed: Pose, true: Pose) -> None:
        """When the robot believed to be at ``believed`` it was at ``true`` (map frame): odometry goes on from there.
        Moves nothing."""
        ...

    def drive(self, twist: Twist, epoch: int) -> None:
        """Set the velocity; it dies after the command lifetime, so repeat it every tick."""
        ...

    def go(self, goal: Pose, epoch: int) -> int:
        """Have a robot that ``navigates`` go to ``goal`` (map frame) by itself, as ``state().going`` tells; gives the
        ticket by which it does. It ends with the epoch, and with whatever else the base is told."""
        ...

    def move_arm(self, joints: Sequence[float], epoch: int, *, speed: float = 1.0) -> None:
        """Move all joints towards ``joints`` at no more than ``speed`` rad/s."""
        ...

    def set_gripper(self, opening: float, epoch: int) -> None:
        """Open (1) or close (0) the gripper."""
        ...

    def set_light(self, rgb: tuple[int, int, int], epoch: int) -> None:
        """Set the colour of the light."""
        ...

    def beep(self, seconds: float, epoch: int) -> None:
        """Sound the buzzer."""
        ...

    async def tick(self) -> RobotState:
        """Wait for the next control period (20 ms of robot time) in which the robot is not paused, and return the state
        then.

        In a simulation at full speed, time passes only while somebody waits here.
        Raises ``RobotError`` when the robot is gone.
        """
        ...
