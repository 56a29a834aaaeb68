"""How a robot is made, as a file says it: hull, drive, arm, camera, lidar and board.

The files that come with sayso are in ``assets/robots``; people put their own beside their configuration, or anywhere.
What a robot has decides which skills it is offered for; what it may do at most lies below the safety envelope.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from importlib import resources
from pathlib import Path
from typing import Literal, Self

import numpy as np
import yaml
from pydantic import Field, ValidationError, field_validator, model_validator

from config import paths
from config.editing import NotEditable, Value, with_value
from config.nearest import did_you_mean
from config.schema import Section
from config.writing import write_whole
from engine import yaml_file
from engine.errors import UsageError
from engine.robot.arm import ARM_JOINTS, ArmModel
from engine.robot.camera import Mount
from engine.robot.geometry import Point, Twist
from engine.robot.robot import Capability, Footprint
from engine.yaml_file import BadFile

Drive = Literal["mecanum", "differential", "ackermann"]
FOLDER = "robots"


class Hull(Section):
    """The hull, seen from above, as a rectangle centred on the robot."""

    length: float = Field(gt=0.05, le=3, description="m, along the way it drives.")
    width: float = Field(gt=0.05, le=3, description="m.")


class Speeds(Section):
    """What the drive can do at most; the safety envelope allows less."""

    forward: float = Field(gt=0, le=3, description="m/s.")
    sideways: float = Field(ge=0, le=3, description="m/s; 0 where the wheels cannot.")
    turn: float = Field(gt=0, le=10, description="rad/s.")

    def within(self, twist: Twist) -> Twist:
        """What the drive can do of this: never more than these, and in proportion along the floor."""
        vy = twist.vy if self.sideways else 0.0
        over = max(abs(twist.vx) / self.forward, abs(vy) / self.sideways if self.sideways else 0.0, 1.0)
        return Twist(twist.vx / over, vy / over, max(-self.turn, min(self.turn, twist.wz)))


class Wheels(Section):
    """What odometry is added up from. Counts of the encoders are read in the order front left, rear left, front right,
    rear right, positive when a wheel rolls forward."""

    radius: float = Field(gt=0.005, le=0.5, description="m.")
    base: float = Field(gt=0.01, le=2, description="m, front axle to rear axle.")
    track: float = Field(gt=0.01, le=2, description="m, left wheels to right wheels.")
    counts: float = Field(gt=0, description="Of an encoder, for one turn of the wheel.")


class Battery(Section):
    """The battery, by what it gives under load."""

    full: float = Field(default=12.6, gt=0, le=60, description="V.")
    low: float = Field(default=10.2, gt=0, le=60, description="V at which it wants to be charged.")
    empty: float = Field(default=9.3, gt=0, le=60, description="V below which it does not drive.")

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if not self.empty < self.low < self.full:
            raise ValueError("empty is less than low, and low less than full")
        return self

    def charge(self, volts: float) -> float:
        """About how much is left, 0 to 1."""
        return max(0.0, min(1.0, (volts - self.empty) / (self.full - self.empty)))


class Board(Section):
    """The motor board."""

    kind: Literal["rosmaster"]
    car_type: int = Field(ge=1, le=5, description="What the board calls this robot: X3 1, X3 Plus 2, X1 4, R2 5.")
    battery: Battery = Battery()
    stops_by_itself: bool | None = Field(
        default=None, description="Whether it stops when the line falls silent, as `sayso doctor --wheels-up` found."
    )


class Servo(Section):
    """A servo, and how its angle goes with that of a joint: servo = zero + sign · joint."""

    number: int = Field(ge=1, le=6)
    zero: float = Field(default=90, ge=0, le=270, description="deg of the servo where the joint is at 0.")
    sign: Literal[1, -1] = 1


class JointOf(Section):
    """A joint of the arm."""

    range: tuple[float, float] = Field(description="deg.")
    servo: Servo | None = None

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if not self.range[0] < self.range[1]:
            raise ValueError("a range goes from less to more")
        return self


class Gripper(Section):
    """The gripper, and the angles of its servo."""

    opens: float = Field(gt=0, le=0.3, description="m between the fingers at most.")
    servo: int = Field(default=6, ge=1, le=6)
    closed: float = Field(default=180, ge=0, le=270, description="deg of the servo.")
    open: float = Field(default=30, ge=0, le=270, description="deg of the servo.")


def _check_joints(joints: Mapping[str, object]) -> None:
    if tuple(joints) != ARM_JOINTS:
        raise ValueError(f"the joints are, in this order: {', '.join(ARM_JOINTS)}")


class ArmOf(Section):
    """The arm: lengths in m, places in the base frame (shoulder) and in the wrist's (eye)."""

    shoulder: Point = Field(description="Where the shoulder axis crosses the yaw axis.")
    upper: float = Field(gt=0, description="Shoulder to elbow.")
    fore: float = Field(gt=0, description="Elbow to wrist.")
    hand: float = Field(gt=0, description="Wrist to the point between the fingertips.")
    eye: Point = Field(default=(0.0, 0.0, 0.0), description="The camera's place on the wrist, where it is there.")
    joints: dict[str, JointOf]
    gripper: Gripper

    @model_validator(mode="after")
    def _all_joints(self) -> Self:
        _check_joints(self.joints)
        return self


class CameraOf(Section):
    """The camera."""

    depth: bool = Field(description="Whether it measures distances; without, those of known things are guessed.")
    view: float = Field(gt=10, lt=170, description="deg, up and down.")
    on_arm: bool = Field(default=True, description="Whether it is at arm.eye on the wrist, or fixed to the base.")
    at: Point = Field(default=(0.1, 0.0, 0.3), description="Its place in the base frame, m, where it is fixed there.")
    down: float = Field(default=15, ge=-90, le=90, description="deg by which it looks down, where it is fixed.")

    @property
    def mount(self) -> Mount:
        """Where it is, base frame, where it is fixed there."""
        down = math.radians(self.down)
        right, below = (0.0, -1.0, 0.0), (-math.sin(down), 0.0, -math.cos(down))
        ahead = (math.cos(down), 0.0, -math.sin(down))
        return Mount(np.column_stack((right, below, ahead)), np.array(self.at))


class LidarOf(Section):
    """The lidar."""

    model: str | None = Field(
        default=None, description="What reads it: a model of lds2d, such as RPLIDAR-A1; none in a simulation."
    )
    at: tuple[float, float] = Field(default=(0.0, 0.0), description="Its place in the base frame, m.")
    turned: float = Field(default=0.0, ge=-360, le=360, description="deg to the left, of where it calls 0°.")
    clockwise: bool = Field(default=True, description="Whether its angles grow to the right, seen from above.")
    range: float = Field(default=12.0, gt=0, le=100, description="m; what is farther is not believed.")
    nearest: float = Field(default=0.15, ge=0, le=1, description="m; what is nearer, it does not see.")


class RosJointOf(Section):
    """A joint in a graph of ROS 2, and how its angle goes with ours: theirs = zero + sign · ours."""

    name: str
    zero: float = Field(default=0, ge=-7, le=7, description="rad of theirs where ours is at 0.")
    sign: Literal[1, -1] = 1


class RosGripperOf(Section):
    """A gripper in a graph of ROS 2."""

    action: str = Field(description="It is moved by this: an action GripperCommand.")
    joint: str | None = Field(default=None, description="Its name among the joints.")
    closed: float = Field(description="Its position there, m or rad.")
    open: float = Field(description="The same.")
    effort: float = Field(default=0, ge=0, description="Most that it presses with; 0: what it is made for.")

    @model_validator(mode="after")
    def _moves(self) -> Self:
        if self.closed == self.open:
            raise ValueError("closed and open are one and the same position")
        return self


class RosArmOf(Section):
    """The arm in a graph of ROS 2; what it is like stands in ``arm``."""

    trajectory: str = Field(
        default="/arm_controller/follow_joint_trajectory",
        description="It is moved by this: an action FollowJointTrajectory.",
    )
    states: str = Field(default="/joint_states", description="It says here where its joints are: JointState.")
    joints: dict[str, RosJointOf]
    gripper: RosGripperOf | None = None

    @model_validator(mode="after")
    def _all_joints(self) -> Self:
        _check_joints(self.joints)
        return self


class RosCameraOf(Section):
    """Topics of a camera in a graph of ROS 2; what it is like stands in ``camera``."""

    image: str = Field(description="Its colours: Image, or CompressedImage.")
    compressed: bool = Field(default=False, description="Whether that is CompressedImage.")
    info: str | None = Field(default=None, description="Its lens: CameraInfo; null: camera.view tells.")
    depth: str | None = Field(default=None, description="Distances of the same pixels: Image; null: none are measured.")


class RosOf(Section):
    """A robot's topics in a graph of ROS 2."""

    velocity: str = Field(default="/cmd_vel", description="It is told velocities here: Twist, or TwistStamped.")
    stamped: bool = Field(default=False, description="Whether that is TwistStamped.")
    frame: str = Field(default="base_link", description="Of a TwistStamped.")
    odometry: str = Field(default="/odom", description="It says here where it is: Odometry.")
    navigation: str | None = Field(
        default="/navigate_to_pose",
        description="Finds its way: an action NavigateToPose, such as Nav2's; null, or none there: sayso drives.",
    )
    map_frame: str | None = Field(
        default="map", description="In which it finds itself on its map; null: where it starts is what is known."
    )
    tf: str = Field(default="/tf", description="It says here where its frames are: TFMessage.")
    scan: str | None = Field(default="/scan", description="Of its lidar: LaserScan.")
    battery: str | None = Field(default="/battery_state", description="Of its battery: BatteryState.")
    arm: RosArmOf | None = Field(default=None, description="Its arm; null: none.")
    camera: RosCameraOf | None = Field(default=None, description="Its camera; null: none.")
    volts: Battery | None = Field(
        default=None, description="What its battery gives when it is full, low and empty; null: low is not noticed."
    )


class Description(Section):
    """One kind of robot."""

    name: str
    source: str = Field(description="Where the numbers are from, and what of them was measured.")
    drive: Drive
    hull: Hull
    speeds: Speeds
    wheels: Wheels | None = None
    board: Board | None = None
    ros: RosOf | None = Field(default=None, description="Of a robot of ROS 2, what its topics are called.")
    arm: ArmOf | None = None
    camera: CameraOf | None = None
    trim: float = Field(
        default=0, ge=-0.5, le=0.5, description="rad of turn per metre ahead, added to what the motors are told."
    )
    dock: str | None = Field(
        default=None, description="Where it is charged when it stands there: the name of a place of its house."
    )
    calibrated: dict[str, str] = Field(default_factory=dict, description="What was measured, when, and how well.")
    lidar: LidarOf | None = Field(
        default=None, description="Without one nothing is seen in the way: it drives slowly then."
    )

    @field_validator("lidar", mode="before")
    @classmethod
    def _yes_or_no(cls, lidar: object) -> object:
        """Descriptions used to say only whether there is one."""
        return {} if lidar is True else None if lidar is False else lidar

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.drive != "mecanum" and self.speeds.sideways:
            raise ValueError(f"a {self.drive} drive cannot go sideways: speeds.sideways is 0")
        if self.board is not None and self.ros is not None:
            raise ValueError("a robot has a board or speaks ROS 2: one of board and ros")
        if self.ros is not None:
            for part in ("arm", "camera"):
                if getattr(self.ros, part) is not None and getattr(self, part) is None:
                    raise ValueError(f"ros.{part} names topics, and {part} does not tell what it is like")
            if self.arm is not None and self.ros.arm is None:
                raise ValueError("an arm in a graph of ROS 2 needs ros.arm: its joints, and what moves them")
        if self.board is not None:
            if self.wheels is None:
                raise ValueError("a board needs wheels: odometry is added up from them")
            if self.arm is not None and any(joint.servo is None for joint in self.arm.joints.values()):
                raise ValueError("on a board, every joint needs a servo")
        return self

    @property
    def kind(self) -> Literal["sim", "rosmaster", "ros2"]:
        """What ``robot.kind`` has to be for it."""
        return "rosmaster" if self.board is not None else "ros2" if self.ros is not None else "sim"

    @property
    def footprint(self) -> Footprint:
        return Footprint(self.hull.length, self.hull.width)

    @property
    def capabilities(self) -> frozenset[Capability]:
        """What skills can be offered for."""
        has: set[Capability] = {"base", "voice"}
        if self.arm is not None:
            has.add("arm")
        if self.camera is not None:
            has.add("camera")
        return frozenset(has)

    def eye(self, joints: Sequence[float]) -> Mount:
        """Where the camera is, base frame, with the arm at these joints, rad. The robot must have one."""
        assert self.camera is not None
        yaw, shoulder, elbow, wrist, roll = joints
        return self.arm_model.camera((yaw, shoulder, elbow, wrist, roll)) if self.camera.on_arm else self.camera.mount

    @property
    def battery(self) -> Battery | None:
        """What is known of its battery, where one is measured."""
        if self.board is not None:
            return self.board.battery
        return self.ros.volts if self.ros is not None else None

    @property
    def ranges(self) -> tuple[tuple[float, float], ...]:
        """Of the joints, rad; where there is no arm, none of them moves."""
        if self.arm is None:
            return ((0.0, 0.0),) * len(ARM_JOINTS)
        return tuple((math.radians(j.range[0]), math.radians(j.range[1])) for j in self.arm.joints.values())

    @property
    def arm_model(self) -> ArmModel:
        """The geometry of the arm; of none where there is none."""
        arm = self.arm
        if arm is None:
            return ArmModel((0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0, self.ranges, (0.0, 0.0, 0.0))
        return ArmModel(arm.shoulder, arm.upper, arm.fore, arm.hand, arm.gripper.opens, self.ranges, arm.eye)


def known() -> tuple[str, ...]:
    """Names of the descriptions: those that come with sayso, and this user's own."""
    return tuple(sorted({path.stem for folder in (_folder(), paths().robots) for path in folder.glob("*.yaml")}))


def described(name: str) -> Description:
    """The description of this name, or in this file; this user's own goes before one that comes with sayso. Raises
    :class:`UsageError`."""
    path = file_of(name)
    if not _is_file(path):
        hint = did_you_mean(name, known()) or f"There are: {', '.join(known())}; or give a file."
        raise UsageError(f"There is no robot called {name!r}.", hint=hint)
    return _read(path.resolve(), path.stat().st_mtime_ns)


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a name that is too long, or has a zero in it
        return False


def file_of(name: str) -> Path:
    """The file that a name means, which need not be there."""
    if name.endswith((".yaml", ".yml")) or "/" in name:
        return Path(name).expanduser()
    own = paths().robots / f"{name}.yaml"
    return own if _is_file(own) else _folder() / f"{name}.yaml"


def note(name: str, found: Mapping[str, Value]) -> Path:
    """Write what was found out about a robot into its description, by dotted keys; the rest of the file stays as it is.
    One that comes with sayso becomes this user's own first. Gives the file. Raises :class:`UsageError`."""
    described(name)
    source = file_of(name)
    target = paths().robots / source.name if source.parent == _folder() else source
    try:
        text = source.read_text("utf-8")
        for key, value in found.items():
            text = with_value(text, tuple(key.split(".")), value)
        Description.model_validate(yaml.safe_load(text))
        write_whole(target, text.encode(), mode=0o644)
    except NotEditable as error:
        raise UsageError(f"{target} cannot be changed: {error}.") from error
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(map(str, first["loc"]))
        raise UsageError(f"That fits no description, so nothing was written: {key}: {first['msg']}.") from error
    except OSError as error:
        raise UsageError(f"{target} cannot be written: {error.strerror}.") from error
    return target


@lru_cache(maxsize=16)
def _read(path: Path, changed: int) -> Description:
    try:
        return Description.model_validate(yaml_file.read(path))
    except (FileNotFoundError, BadFile) as error:
        raise UsageError(f"{path} cannot be read: {error}.") from error
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(map(str, first["loc"])) or "the file"
        raise UsageError(f"{path}: {key}: {first['msg']}.", hint="`sayso robot show x3plus` is an example.") from error


def _folder() -> Path:
    return Path(str(resources.files("assets") / FOLDER))
