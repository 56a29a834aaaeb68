"""The protocol that every robot speaks, and the facts it deals in.

Frames: *map* is fixed to the floor, x east, y north, yaw counter-clockwise from x. *base* is fixed to the robot, x
forward, y left. Units are SI and radians throughout.

Two rules hold for every robot. **Stop wins**: :meth:`Robot.stop` may be called from any thread, never blocks, and
takes effect in the robot's next control tick. **Epochs**: every command carries the epoch it
belongs to, and the robot ignores commands of any epoch but the one last given to ``stop`` (1 before that), so a late
command of an interrupted plan cannot move anything.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from engine.robot.arm import ArmModel
    from engine.robot.camera import Picture

Capability = Literal["base", "arm", "camera", "voice"]

ARM_JOINTS = ("yaw", "shoulder", "elbow", "wrist", "roll")
"""The five joints of the arm from base to gripper; with the gripper they are the six servos."""

Joints = tuple[float, float, float, float, float]
"""rad, in the order of ``ARM_JOINTS``; all zero is straight up, positive shoulder/elbow/wrist lean forward."""

ARM_INITIAL: Joints = (0.0, -1.1, 1.85, 1.05, 0.0)
"""The folded pose that the arm starts in and returns to: inside the hull, the camera looking ahead."""
ARM_UP: Joints = (0.0, 0.0, 0.0, 0.0, 0.0)
"""Straight up."""
ARM_DOWN: Joints = (0.0, 0.88, 1.5, 0.76, 0.0)
"""Reaching down in front of the hull, the gripper pointing at the floor."""


def wrap(angle: float) -> float:
    """``angle`` in (-π, π], rad."""
    return math.pi - (math.pi - angle) % (2 * math.pi)


@dataclass(frozen=True, slots=True)
class Pose:
    """Where the robot stands, map frame."""

    x: float  # m
    y: float  # m
    yaw: float  # rad, in (-π, π]

    def distance_to(self, other: Pose) -> float:
        """Straight-line distance, m."""
        return math.hypot(other.x - self.x, other.y - self.y)


@dataclass(frozen=True, slots=True)
class Twist:
    """Velocity of the base, base frame."""

    vx: float = 0.0  # m/s, forward
    vy: float = 0.0  # m/s, to the left
    wz: float = 0.0  # rad/s, counter-clockwise

    @property
    def is_zero(self) -> bool:
        return self.vx == 0.0 and self.vy == 0.0 and self.wz == 0.0


ZERO = Twist()


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


@dataclass(frozen=True, slots=True)
class Footprint:
    """The hull, seen from above, as a rectangle centred on the robot."""

    length: float  # m, along x
    width: float  # m, along y

    @property
    def radius(self) -> float:
        """Of the circle around the rectangle, m."""
        return math.hypot(self.length, self.width) / 2


@dataclass(frozen=True, slots=True)
class FloorMap:
    """What is fixed on the floor: walls and furniture, as the map drawn when the house was mapped."""

    resolution: float  # m per cell
    origin: tuple[float, float]  # map coordinates of the outer corner of cell [0, 0], m
    occupied: NDArray[np.bool_]  # shape (rows, columns); row is y, column is x
    rooms: tuple[Room, ...] = ()
    furniture: tuple[Furniture, ...] = ()
    doors: tuple[Doorway, ...] = ()
    tags: tuple[Landmark, ...] = ()


@dataclass(frozen=True, slots=True)
class Room:
    """A named rectangle of floor, map frame, m."""

    name: str
    x_min: float
    y_min: float
    x_max: float
    y_max: float

    def holds(self, x: float, y: float) -> bool:
        """Whether the point lies in the room, border included."""
        return self.x_min <= x <= self.x_max and self.y_min <= y <= self.y_max


@dataclass(frozen=True, slots=True)
class Furniture:
    """A named piece of furniture as a rectangle on the floor, map frame, m."""

    name: str
    x_min: float
    y_min: float
    x_max: float
    y_max: float
    height: float = 0.0  # of its top; 0 where that is not known
    kind: str = ""  # bin, low_table, …

    def holds(self, x: float, y: float, *, margin: float = 0.0) -> bool:
        """Whether the point lies on it, at least ``margin`` m from its edges."""
        return self.x_min + margin <= x <= self.x_max - margin and self.y_min + margin <= y <= self.y_max - margin


@dataclass(frozen=True, slots=True)
class Doorway:
    """A gap in a wall between two rooms."""

    between: tuple[str, str]
    x: float  # of its middle, map frame, m
    y: float
    width: float  # m


@dataclass(frozen=True, slots=True)
class Landmark:
    """An AprilTag of the family 36h11 that is fixed to the house, by which a robot can tell where it is."""

    id: int
    x: float  # of its middle, map frame, m
    y: float
    z: float
    yaw: float  # direction in which its face looks, map frame, rad; it hangs upright
    size: float  # edge of the black square, m


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
        """Wait for the next control period (20 ms of robot time) and return the state then.

        In a simulation at full speed, time passes only while somebody waits here.
        Raises ``RobotError`` when the robot is gone.
        """
        ...
