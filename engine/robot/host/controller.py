"""What every body is driven by: the safety envelope of the base, the motion of the arm, and where the robot believes it
is.

It knows nothing of processes, clocks or shared memory, so that a test can hold one in its hand. A body advances in
steps of 2 ms; every fifth step is a control period, in which the safety envelope decides what the base motors are told.
:meth:`Controller.stop` acts at once, between two steps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from config.schema import Limits
from engine.robot.clearance import Points
from engine.robot.company import Company
from engine.robot.geometry import UNMOVED, ZERO, Pose, Twist, compose, inverse, wrap
from engine.robot.host.arm_motion import ArmMotion, Ranges
from engine.robot.host.body import STEP_S, ArmMover, Body, Navigator
from engine.robot.host.envelope import SCAN_LIFETIME, Envelope, into_base_frame, into_map_frame
from engine.robot.host.memory import Record
from engine.robot.host.sent_arm import SentArm
from engine.robot.lidar import RAYS, points
from engine.robot.robot import Footprint

CONTROL_STEPS: Final = 5
"""Steps per control period (10 ms)."""
SCAN_STEPS: Final = 25
"""Steps between two looks for a turn of the lidar (50 ms)."""
LONGEST_BEEP_S: Final = 5.0
BLIND: Final = Twist(0.25, 0.25, 1.0)
"""Fastest without a lidar, m/s and rad/s: a person steps aside or catches it."""

_SAME_M, _SAME_RAD = 0.05, 0.05
_REST_SPEED, _REST_TURN = 0.003, 0.01  # m/s, rad/s: what RobotState.moving counts as rest


class Controller:
    """One body under control."""

    def __init__(
        self,
        body: Body,
        start: Pose,
        limits: Limits,
        footprint: Footprint,
        ranges: Ranges,
        edges: Points,
        last: Record | None = None,
        *,
        blind: bool = False,
        navigator: Navigator | None = None,
        arm_mover: ArmMover | None = None,
        company: Company | None = None,
    ) -> None:
        """``start`` is where the body's odometry begins; ``ranges`` are those of the arm's joints, ``edges`` points on
        the map that the hull may not cross. ``last`` is the state that the body goes on from, standing still. A body
        that is ``blind`` has no lidar: it stops short of the edges alone, and drives no faster than ``BLIND``.
        ``navigator`` is the body where it finds its way itself: what is in its way is its own business then.
        ``arm_mover`` is the body where its arm does. ``company`` are the people around it where the body plays them."""
        if blind:
            limits = limits.model_copy(
                update={
                    "linear_speed": min(limits.linear_speed, BLIND.vx),
                    "angular_speed": min(limits.angular_speed, BLIND.wz),
                }
            )
        self.body = body
        self.company = company
        self.arm = ArmMotion(body, ranges) if arm_mover is None else SentArm(body, arm_mover, ranges)
        self._navigator = navigator
        self._goal: tuple[Pose, int] | None = None  # it goes there by itself: where on the map, and the ticket
        self._rests = False  # on its way there, until it is resumed
        self._sent_with = UNMOVED  # the correction under which it was sent there
        self._envelope = Envelope(limits, footprint)
        self._edges = edges
        self._blind = blind
        self._correction = UNMOVED
        self._pose = self._added = start  # the latter is its own motion, without the correction
        self._steps = 0
        self._told = ZERO
        self._ranges: NDArray[np.float64] = np.full(RAYS, np.inf)
        self._scan_time = -math.inf
        self._seen: Points = np.empty((0, 2))  # by the lidar, map frame
        self._around: Points = np.empty((0, 2))  # that and the edges, as far as it can matter before the next scan
        self._near = self._envelope.reach + math.sqrt(2) * limits.linear_speed * SCAN_LIFETIME
        self._blocked: str | None = None
        self._light_rgb = (0, 0, 0)
        self._buzzer_until = 0.0
        if last is not None:
            self._correction, self._pose = Pose(*last["correction"].tolist()), Pose(*last["pose"].tolist())
            self._added = added_up(last)
            self.arm.resume_grip(float(last["grip"]))
            red, green, blue = last["light"].tolist()
            self.shine((red, green, blue))
            self._buzzer_until = float(last["buzzer_until"])
        self._scan()

    # Commands. Each returns False when its values are unusable; nothing moves then.

    def drive(self, twist: Twist) -> bool:
        """Drive until the command lifetime is over."""
        self._give_up()
        if self._blind and (over := math.hypot(twist.vx, twist.vy) / BLIND.vx) > 1:
            twist = Twist(twist.vx / over, twist.vy / over, twist.wz)
        return self._envelope.command(twist, self.t)

    def limit_speed(self, share: float) -> None:
        """Drive no faster than this share of the limits' speeds. A body that finds its way itself chooses its speed."""
        self._envelope.limit_speed(share)

    def go(self, goal: Pose, ticket: int) -> bool:
        """Have the body go there by itself, map frame."""
        if self._navigator is None:
            return False
        self._envelope.halt()
        self._goal, self._rests, self._sent_with = (goal, ticket), False, self._correction
        self._navigator.go(compose(inverse(self._correction), goal), ticket)
        return True

    def move_arm(self, joints: Sequence[float], speed: float) -> bool:
        """Move the arm's joints, at no more than ``speed`` rad/s."""
        return self.arm.move(joints, speed)

    def grip(self, opening: float) -> bool:
        """Open or close the gripper."""
        return self.arm.grip(opening)

    def shine(self, rgb: tuple[int, int, int]) -> None:
        """Set the light."""
        self._light_rgb = rgb
        self.body.shine(rgb)

    def beep(self, seconds: float) -> None:
        """Sound the buzzer."""
        seconds = min(seconds, LONGEST_BEEP_S)
        self._buzzer_until = self.t + seconds
        self.body.beep(seconds)

    def correct(self, correction: Pose) -> None:
        """Believe from now on to be where odometry is after this rigid motion of the map; nothing moves. It is always
        the whole of it, so giving it twice does no harm."""
        before, self._correction = self._pose, correction
        self._pose = self._corrected()
        # What was seen stays where it is around the robot.
        self._seen = into_map_frame(into_base_frame(self._seen, before), self._pose)
        self._look_around()
        if self._goal is not None and not self._rests and _are_apart(correction, self._sent_with):
            self._send_again(*self._goal)

    def stop(self, *, anew: bool = False) -> None:
        """Base to zero velocity now, arm where it is, gripper as it grips. ``anew``: it may have been moved since, or
        have been without power."""
        self._give_up()
        self.pause()
        self.arm.hold(anew=anew)
        self.resume()

    def pause(self) -> None:
        """Base to zero velocity now, arm and gripper where they are, until :meth:`resume`."""
        self._halt_navigator()
        self._envelope.halt()
        self._blocked = None
        self._tell(ZERO)
        self.arm.paused = True

    def rest(self) -> None:
        """The same, but the base comes to rest as gently as it drives."""
        self._halt_navigator()
        self._envelope.command(ZERO, self.t)
        self.arm.paused = True

    def resume(self) -> None:
        """The arm goes on to its goal, the base with its next command, and a body that finds its way itself to where it
        was to go."""
        self.arm.paused = False
        if self._goal is not None and self._rests:
            self.go(*self._goal)

    def _send_again(self, goal: Pose, ticket: int) -> None:
        """It goes on to the same place on the map, which is another one for its odometry by now."""
        if self._navigator is not None and self._navigator.give_up():
            self.go(goal, ticket)

    def _halt_navigator(self) -> None:
        """Have it rest on its way; where it has ended, there is nothing to go on with."""
        if self._goal is None or self._navigator is None or self._rests:
            return
        self._rests = self._navigator.give_up()
        if not self._rests:
            self._goal = None

    def _give_up(self) -> None:
        self._halt_navigator()
        self._goal, self._rests = None, False

    # Time

    @property
    def t(self) -> float:
        """Robot time, s."""
        return self.body.t

    def step(self) -> None:
        """Advance by one step of the body."""
        if self._steps % SCAN_STEPS == 0:
            self._scan()
        if self._steps % CONTROL_STEPS == 0:
            self._control()
        self.arm.step(STEP_S)
        self.body.step()
        self._steps += 1
        if self._steps % CONTROL_STEPS == 0:  # here, so that who reads the state next reads where it is now
            self._added = self.body.odometry()
            self._pose = self._corrected()

    def _control(self) -> None:
        obstacles = None if self._envelope.idle else self._obstacles()
        shaped = self._envelope.shape(self.t, CONTROL_STEPS * STEP_S, obstacles)
        self._blocked = shaped.blocked
        self._tell(shaped.twist)

    def _tell(self, twist: Twist) -> None:
        self._told = twist
        self.body.drive(twist)

    # Readings

    @property
    def twist(self) -> Twist:
        """Measured velocity, base frame."""
        return self.body.twist

    @property
    def command(self) -> Twist:
        """What the motors are told."""
        return self._told

    @property
    def blocked(self) -> str | None:
        return self._blocked

    @property
    def at_rest(self) -> bool:
        twist = self.twist
        return math.hypot(twist.vx, twist.vy) <= _REST_SPEED and abs(twist.wz) <= _REST_TURN

    @property
    def ranges(self) -> NDArray[np.float64]:
        """The newest scan (see ``engine.robot.lidar``), m."""
        return self._ranges

    @property
    def scan_time(self) -> float:
        """When the newest scan was taken, robot time."""
        return self._scan_time

    def fill(self, record: Record) -> None:
        """Write the readings into a record of ``memory.STATE``; epoch and halted are not ours."""
        pose, twist, told, correction = self._pose, self.twist, self._told, self._correction
        record["t"] = self.t
        record["pose"] = (pose.x, pose.y, pose.yaw)
        record["correction"] = (correction.x, correction.y, correction.yaw)
        record["twist"] = (twist.vx, twist.vy, twist.wz)
        record["command"] = (told.vx, told.vy, told.wz)
        record["joints"], record["joint_targets"] = self.arm.joints, self.arm.targets
        record["gripper"], record["grip"] = self.arm.opening, self.arm.grip_target
        record["light"] = self._light_rgb
        record["buzzer_until"] = self._buzzer_until
        record["blocked"] = (self._blocked or "").encode()
        record["arm_fault"] = self.arm.fault.encode()[:96]
        self.body.fill(record)
        if self._rests:
            record["going_how"] = b"going"

    # Seeing

    def _scan(self) -> None:
        ranges = self.body.scan()
        if ranges is None:
            if self._blind:
                self._look_around()
            return
        self._ranges, self._scan_time = ranges, self.t
        self._seen = into_map_frame(points(ranges), self._pose)
        self._look_around()

    def _look_around(self) -> None:
        everything = np.concatenate((self._seen, self._edges))
        apart = everything - (self._pose.x, self._pose.y)
        self._around = everything[np.einsum("ij,ij->i", apart, apart) < self._near**2]

    def _obstacles(self) -> Points | None:
        """What must not be driven into, base frame: the newest scan and the edges of the workspace."""
        if not self._blind and self.t - self._scan_time > SCAN_LIFETIME:
            return None
        return into_base_frame(self._around, self._pose)

    def _corrected(self) -> Pose:
        return self._added if self._correction == UNMOVED else compose(self._correction, self._added)


def _are_apart(one: Pose, other: Pose) -> bool:
    """Whether a goal under the one is another place than under the other."""
    return math.dist((one.x, one.y), (other.x, other.y)) > _SAME_M or abs(wrap(one.yaw - other.yaw)) > _SAME_RAD


def added_up(last: Record) -> Pose:
    """What the motion of a robot had added up to in its last state, without the correction."""
    return compose(inverse(Pose(*last["correction"].tolist())), Pose(*last["pose"].tolist()))
