"""A robot of ROS 2, behind a door to its graph, as a body of the host.

It is told velocities on its topic for them, at once when they change and ten times a second while it moves; where it
stands and what its lidar sees come on others. Where it has a navigation of its own, that finds its way; to stop is to
have the navigation give up *and* to be told zero, again and again until both have happened.

A guard beside it has a door of its own (:mod:`engine.robot.ros2.guard_main`). A connection that is cut, neither can
mend: then the robot's own time limit for velocities stops it, which every base controller of ROS has, and a navigation
is called back when the door is open again. When odometry is late, the host stands.
"""

from __future__ import annotations

import contextlib
import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.errors import DeviceError, ProcessError
from engine.robot.arm import ARM_JOINTS
from engine.robot.description import Description, RosOf
from engine.robot.geometry import ZERO, Pose, Twist, compose, inverse
from engine.robot.host.controller import added_up
from engine.robot.host.guard import Guard
from engine.robot.host.memory import Record
from engine.robot.lidar import Turn, outside
from engine.robot.ros2 import messages
from engine.robot.ros2.arm import RosArm
from engine.robot.ros2.navigation import Navigation
from engine.robot.surroundings import Surroundings
from engine.ros.door import Door, Message

REPEAT_S: Final = 0.1
"""Between two velocities that are the same."""
ENDING_S: Final = 0.02
"""Between two zeros while a navigation that was told to stop may still drive."""
REST_S: Final = 1.0
"""For so long a robot that stands is told so; then others may drive it."""
LATE_S: Final = 0.5
"""Without odometry for so long, nobody knows what the robot does."""
LOOK_S: Final = 0.5
"""Between two tries to start a guard."""
GUARD_S: Final = 20.0
"""In which a guard gives its first sign of life: it has a door to load."""
OPEN_LIMIT_S: Final = 20.0
"""In which a robot must have said where it is."""
SCAN_LIMIT_S: Final = 2.0
"""In which the first turn of its lidar has come; without one it is there all the same, and does not drive."""
_NAVIGATION_GOES_ON: Final = (
    "its navigation goes on although it was told to stop",
    "it is not known whether its navigation has stopped",
)
_ARM_GOES_ON: Final = ("its arm goes on although it was told to stop", "it is not known whether its arm has stopped")
_JUMP_M: Final = 0.2
"""By so much a pose may change at once."""
_ROLL_M: Final = 1.0
"""By so much while one host is gone and the next not there yet; a peer that is farther off has begun anew."""

Clock = Callable[[], float]


class Ros2Body:
    """A :class:`engine.robot.host.body.Body`. What it hears comes in the door's thread, one value at a time."""

    lag = 0.0

    def __init__(
        self,
        door: Door,
        description: Description,
        start: Pose,
        last: Record | None = None,
        *,
        guard: Callable[[], Guard] | None = None,
        clock: Clock = time.monotonic,
        wall: Clock = time.time,
    ) -> None:
        """Wait until the robot has said where it is. ``door`` is closed with it; ``guard`` starts one, None: it has
        none. Raises ``DeviceError``."""
        assert description.ros is not None, "checked by whoever has chosen this body"
        self._door, self._about, self._description = door, description.ros, description
        self._clock, self._wall = clock, wall
        self._began = clock() - (float(last["t"]) if last is not None else 0.0)
        self._heard: tuple[float, Pose, Twist] | None = None  # the newest odometry, and when it came
        self._origin = start  # of the frame in which the peer adds up, on the map
        self._before: Pose | None = None  # where another host had it, in that frame
        if last is not None:
            self._origin, self._before = added_up(last), Pose(*last["own_pose"].tolist())
        self._located: Pose | None = None  # the same, where the peer finds itself on its map
        self._frame = "odom"  # in which it adds up
        self._navigation: Navigation | None = None
        if self._about.navigation is not None:
            self._navigation = Navigation(door, self._about.navigation, clock, astray=last is not None)
        self._start_guard = guard
        self._guard: Guard | None = None
        self._guard_looked = -math.inf
        self._arm: RosArm | None = None
        if self._about.arm is not None:
            self._arm = RosArm(door, self._about.arm, clock, astray=last is not None)
        moving = ((self._navigation, _NAVIGATION_GOES_ON), (self._arm, _ARM_GOES_ON))
        self._moving = [(part.action, words) for part, words in moving if part is not None]
        self._fastest = 1.5 * (description.speeds.forward + description.speeds.sideways)
        about = description.lidar
        self._around = Surroundings(about.at, about.nearest) if about is not None else None
        self._turns: deque[Turn] = deque(maxlen=1)
        self._volts = 0.0
        self._here = start
        self._told, self._told_at, self._stood_at = ZERO, -math.inf, clock()
        door.subscribe(self._about.odometry, messages.ODOMETRY, self._take_odometry)
        if self._about.map_frame is not None:
            door.subscribe(self._about.tf, messages.TF, self._take_frames)
        if description.lidar is not None and self._about.scan is not None:
            door.subscribe(self._about.scan, messages.SCAN, self._take_scan)
        if self._about.battery is not None:
            door.subscribe(self._about.battery, messages.BATTERY, self._take_battery, every_s=1.0)
        limit = clock() + OPEN_LIMIT_S
        self._look_after_guard(clock())
        while self.trouble:
            if clock() > limit:
                why = self.trouble
                self.close()
                raise DeviceError(f"The robot cannot be driven: {why}.", hint="Are the robot and its bridge running?")
            for action, _ in self._moving:
                action.look_after()
            self._look_after_guard(clock())
            time.sleep(0.01)
        limit = min(limit, clock() + SCAN_LIMIT_S)
        while self._about.scan is not None and self._around is not None and not self._turns and clock() < limit:
            self._look_after_guard(clock())
            time.sleep(0.01)

    # What a body is

    @property
    def trouble(self) -> str:
        if shut := self._door.trouble:
            return shut
        if self._heard is None or self._clock() - self._heard[0] > LATE_S:
            return f"no odometry comes on {self._about.odometry}"
        if self._start_guard is not None and not (self._guard is not None and self._guard.watches):
            return "the guard process is not there"
        if self._arm is not None and not self._arm.is_known:
            return "no positions of its joints arrive"
        for action, (goes_on, may_go_on) in self._moving:
            if action.is_stubborn:
                return goes_on
            if action.is_astray:
                return may_go_on
        return ""

    @property
    def t(self) -> float:
        return self._clock() - self._began

    @property
    def guard_pid(self) -> int:
        return self._guard.pid if self._guard is not None else 0

    @property
    def twist(self) -> Twist:
        return self._heard[2] if self._heard is not None else ZERO

    @property
    def joints(self) -> tuple[float, ...]:
        return self._arm.joints if self._arm is not None else (0.0,) * len(ARM_JOINTS)

    @property
    def opening(self) -> float:
        return self._arm.opening if self._arm is not None else 0.0

    def step(self) -> None:
        now = self._clock()
        self._look_after_guard(now)
        ending = False
        if self._navigation is not None:
            self._navigation.action.look_after()
            if ending := self._navigation.action.is_ending or self._navigation.action.is_astray:
                self._stood_at = now
        if self._arm is not None:
            self._arm.step()
        moves = not self._told.is_zero
        if now - self._told_at >= (ENDING_S if ending else REPEAT_S) and (moves or now - self._stood_at < REST_S):
            self._tell(now)

    def drive(self, twist: Twist) -> None:
        if self._navigation is not None and self._navigation.action.is_wanted:
            return  # others drive it
        limited = self._description.speeds.within(twist) if not self.trouble else ZERO
        if limited == self._told:
            return
        now = self._clock()
        self._told = limited
        if limited.is_zero:
            self._stood_at = now
        self._tell(now)

    def go(self, goal: Pose, ticket: int) -> None:
        """See :class:`engine.robot.host.body.Navigator`."""
        assert self._navigation is not None, "it is told to where it has one"
        self._told, self._stood_at = ZERO, -math.inf  # from now on others drive it
        if self._located is not None and self._about.map_frame is not None:
            self._navigation.go(goal, self._about.map_frame, ticket)
        else:
            self._navigation.go(compose(inverse(self._origin), goal), self._frame, ticket)

    def give_up(self) -> bool:
        """See :class:`engine.robot.host.body.Navigator`."""
        assert self._navigation is not None, "it is told to where it has one"
        was_on_its_way = self._navigation.give_up()
        now = self._clock()
        self._told, self._stood_at = ZERO, now
        self._tell(now)
        return was_on_its_way

    def place_arm(self, joints: Sequence[float], opening: float) -> None:
        """Its arm finds its own way: :meth:`send_arm`."""

    def send_arm(self, joints: Sequence[float], speed: float) -> None:
        """See :class:`engine.robot.host.body.ArmMover`."""
        if self._arm is not None:
            self._arm.send(joints, speed)

    def send_gripper(self, opening: float) -> None:
        """See :class:`engine.robot.host.body.ArmMover`."""
        if self._arm is not None:
            self._arm.grip(opening)

    @property
    def arm_fault(self) -> str:
        """See :class:`engine.robot.host.body.ArmMover`."""
        return self._arm.fault if self._arm is not None else ""

    def hold_arm(self) -> None:
        """See :class:`engine.robot.host.body.ArmMover`."""
        if self._arm is not None:
            self._arm.hold()

    def shine(self, rgb: tuple[int, int, int]) -> None:
        """It has no light."""

    def beep(self, seconds: float) -> None:
        """It makes no sound."""

    def odometry(self) -> Pose:
        heard = self._heard
        assert heard is not None, "it was waited for"
        pose = compose(self._located or self._origin, heard[1])
        if self._around is not None:
            self._around.was(heard[0], pose)
        self._here = pose
        return pose

    def scan(self) -> NDArray[np.float64] | None:
        if not self._turns or self._around is None:
            return None
        return self._around.scan(self._turns.pop(), self._clock(), self._here)

    def fill(self, record: Record) -> None:
        record["volts"] = self._volts
        if self._heard is not None:
            pose = self._heard[1]
            record["own_pose"] = (pose.x, pose.y, pose.yaw)
        if self._navigation is not None:
            self._navigation.fill(record)

    def close(self) -> None:
        """Where a goal may be under way, the guard speaks last: a server may take late what was sent before."""
        if self._navigation is not None:
            self._navigation.give_up()
        self.hold_arm()
        self._told = ZERO
        self._tell(self._clock())
        speaks = any(action.may_move for action, _ in self._moving)
        self._door.close()
        self._end_guard(speaks=speaks)

    # Its guard

    def _look_after_guard(self, now: float) -> None:
        """Tell it that the host lives, and have another one where it is gone."""
        if self._start_guard is None or (self._guard is not None and self._guard.beat(now)):
            return
        self._end_guard()
        if now - self._guard_looked < LOOK_S:
            return
        self._guard_looked = now
        with contextlib.suppress(ProcessError, OSError):  # ``trouble`` tells, and there is another try
            self._guard = self._start_guard()

    def _end_guard(self, *, speaks: bool = False) -> None:
        """One that ``speaks`` tells the robot to rest for a while, and leaves by itself."""
        guard, self._guard = self._guard, None
        if guard is not None and speaks:
            guard.release()
        elif guard is not None:
            guard.discard()

    # What it tells

    def _tell(self, now: float) -> None:
        self._told_at = now
        told = messages.velocity(self._told, self._about, self._wall())
        self._door.publish(self._about.velocity, messages.velocity_type(self._about), told)

    # What it hears, in the door's thread

    def _take_odometry(self, message: Message) -> None:
        found = messages.odometry(message)
        if found is None:
            return
        now, (pose, twist) = self._clock(), found
        if (before := self._heard) is None:
            then = self._before
            rolled = then is not None and math.dist((pose.x, pose.y), (then.x, then.y)) < _ROLL_M
            self._origin = compose(self._origin, inverse(then if rolled and then is not None else pose))
        elif math.dist((pose.x, pose.y), (before[1].x, before[1].y)) > self._fastest * (now - before[0]) + _JUMP_M:
            self._origin = compose(compose(self._origin, before[1]), inverse(pose))  # the peer has begun anew
        self._heard = (now, pose, twist)
        self._frame = messages.frame(message) or self._frame

    def _take_frames(self, message: Message) -> None:
        for parent, child, pose in messages.transforms(message):
            if (parent, child) == (self._about.map_frame, self._frame):
                self._located = pose

    def _take_scan(self, message: Message) -> None:
        found, about = messages.scan_points(message), self._description.lidar
        if found is None or about is None:
            return
        points, after = found
        turned = math.radians(about.turned)
        c, s = math.cos(turned), math.sin(turned)
        points = points @ np.array([[c, s], [-s, c]]) + about.at
        foreign = outside(points, self._description.hull.length, self._description.hull.width)
        took = float(after[-1]) if len(after) else 0.0
        self._turns.append(Turn(points[foreign], (self._clock() - took + after)[foreign]))

    def _take_battery(self, message: Message) -> None:
        self._volts = messages.volts(message) or self._volts


def guard_of(door: str, about: RosOf) -> Guard:
    """A guard that has a way of its own to a robot of ROS 2. Raises ``ProcessError``."""
    arguments = [f"--door={door}", f"--about={about.model_dump_json()}"]
    return Guard("engine.robot.ros2.guard_main", arguments, start_s=GUARD_S)
