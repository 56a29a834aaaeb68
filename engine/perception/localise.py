"""Where the robot stands, from all that tells it.

A :class:`Localiser` weighs landmarks and walls against odometry, whose error grows with the way driven, as a Kalman
filter does, and learns by how much each axis of the odometry counts too far or too short. A tag tells everything, but
from afar it tells the heading, and with it the place across the line of sight, badly; and there are ways of some metres
without any. Walls are in sight nearly everywhere, but one looks like another: what contradicts odometry is not believed
of them, and of tags when a second picture agrees.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.perception.compass import Heading
from engine.perception.landmarks import Fix
from engine.perception.sighting import Sight
from engine.perception.walls import WallSighting
from engine.robot.geometry import Pose, wrap

SLIP: Final = 0.02
"""By what fraction an axis of odometry (forward, left, turning) may be wrong, at first…"""
RESIDUE: Final = 0.004
"""…and when that is known; and per square root of a metre or radian…"""
WALK: Final = 0.012
"""…what adds up by chance."""
IDLE: Final = 0.0005
"""rad and m per square root of a second: what the way between two pictures may have been longer than it looks."""
WEAR: Final = 0.0002
"""By how much that fraction may have changed from one picture to the next."""
UNTOUCHED: Final = (0.002, 0.002)
"""m and rad: smaller corrections are not worth making."""
JUMP: Final = (0.5, math.radians(30))
"""m and rad: a fix further off is believed when a second picture agrees…"""
AGREEING: Final = (0.15, math.radians(8))
"""…this well."""
_SURPRISE = 16.3  # χ² with three degrees of freedom, 99.9 %
_SURPRISE_OF_ONE = 10.8  # with one
_SURE = (0.02, math.radians(1.5))  # how well the robot knows at first where it was put


class Localiser:
    """What the robot knows about its own pose, and about its odometry, from one picture to the next. Not thread-safe.

    ``_scale`` is by how much more than odometry says the robot really moves forward, to the left, and turns, as a
    fraction; the covariance is that of x, y, yaw and these three.
    """

    def __init__(self) -> None:
        self._scale = np.zeros(3)
        self._covariance = np.diag([_SURE[0] ** 2, _SURE[0] ** 2, _SURE[1] ** 2, *[SLIP**2] * 3])
        self._last: tuple[float, Pose] | None = None  # when and where the robot last took a picture, as it believes
        self._doubt: tuple[Pose, Fix] | None = None  # a fix that contradicts odometry, and what was believed then

    @property
    def sigma(self) -> float:
        """Standard deviation of the position when the last picture was taken, m."""
        return math.sqrt(float(np.linalg.eigvalsh(self._covariance[:2, :2])[-1]))

    def update(
        self,
        t: float,
        believed: Pose,
        fix: Fix | None,
        heading: Heading | None = None,
        walls: Sequence[WallSighting] = (),
    ) -> Pose:
        """A picture was taken at ``believed``, landmarks in it told ``fix``, and the lidar the ``heading`` and the
        ``walls``: where the robot most probably was.

        That is ``believed`` itself where the difference does not matter. Whoever asks has to make the robot believe it.
        """
        pose = self._moved(t, believed)
        if fix is not None:
            pose = self._blend(believed, pose, fix)
        if heading is not None:
            pose = self._turned_to(pose, heading)
        for wall in walls:
            pose = self._off_wall(pose, wall)
        off = _between(believed, pose)
        if math.hypot(off[0], off[1]) < UNTOUCHED[0] and abs(off[2]) < UNTOUCHED[1]:
            pose = believed
        self._last = (t, pose)
        return pose

    def _moved(self, t: float, believed: Pose) -> Pose:
        """Odometry has gone on to ``believed``: where the robot is by what is known about odometry."""
        if self._last is None:
            return believed
        then, start = self._last
        turn = wrap(believed.yaw - start.yaw)
        forward, left = _turned(believed.x - start.x, believed.y - start.y, -start.yaw - turn / 2)
        real = 1 + self._scale
        yaw = start.yaw + turn * real[2]
        middle = start.yaw + turn * real[2] / 2
        dx, dy = _turned(forward * real[0], left * real[1], middle)
        c, s = math.cos(middle), math.sin(middle)
        change = np.eye(6)
        change[:3, 2] = -dy, dx, 1
        change[:3, 3:] = [
            [c * forward, -s * left, -dy * turn / 2],
            [s * forward, c * left, dx * turn / 2],
            [0, 0, turn],
        ]
        way = math.hypot(dx, dy)
        idle = IDLE**2 * max(t - then, 0.0)
        place = (RESIDUE * way) ** 2 + WALK**2 * way + idle
        heading = (RESIDUE * turn) ** 2 + WALK**2 * abs(turn) + idle
        self._covariance = change @ self._covariance @ change.T + np.diag([place, place, heading, *[WEAR**2] * 3])
        return Pose(start.x + dx, start.y + dy, wrap(yaw))

    def _blend(self, believed: Pose, pose: Pose, fix: Fix) -> Pose:
        off = _between(pose, fix.pose)
        spread = self._covariance[:3, :3] + fix.covariance
        surprise = float(off @ np.linalg.solve(spread, off))
        far = math.hypot(off[0], off[1]) > JUMP[0] or abs(off[2]) > JUMP[1]
        if far or surprise > _SURPRISE:
            if not self._confirmed(believed, fix):
                self._doubt = (believed, fix)
                return pose
            self._covariance[:3, :] = self._covariance[:, :3] = 0.0
            self._covariance[:3, :3] = fix.covariance
            self._doubt = None
            return fix.pose
        self._doubt = None
        return self._weighed(pose, off, fix.covariance, np.eye(3, 6))

    def _turned_to(self, pose: Pose, heading: Heading) -> Pose:
        return self._by_walls(pose, wrap(heading.yaw - pose.yaw), heading.sigma, np.eye(1, 6, 2))

    def _off_wall(self, pose: Pose, wall: WallSighting) -> Pose:
        x, y = _turned(wall.x, wall.y, pose.yaw)
        told = np.eye(1, 6, wall.axis)
        told[0, 2] = x if wall.axis else -y
        return self._by_walls(pose, wall.at - (pose.y + y if wall.axis else pose.x + x), wall.sigma, told)

    def _by_walls(self, pose: Pose, off: float, sigma: float, told: NDArray[np.float64]) -> Pose:
        """What contradicts odometry is no wall."""
        if off**2 > _SURPRISE_OF_ONE * (float((told @ self._covariance @ told.T)[0, 0]) + sigma**2):
            return pose
        return self._weighed(pose, np.array([off]), np.array([[sigma**2]]), told)

    def _weighed(
        self, pose: Pose, off: NDArray[np.float64], error: NDArray[np.float64], told: NDArray[np.float64]
    ) -> Pose:
        """``pose``, corrected by what was told, which is ``off`` from what it should be, and by what follows from that
        for the rest; ``error`` is the covariance of what was told, ``told`` how it depends on what is estimated."""
        gain = self._covariance @ told.T @ np.linalg.inv(told @ self._covariance @ told.T + error)
        self._covariance = self._covariance - gain @ told @ self._covariance
        step = gain @ off
        self._scale = np.clip(self._scale + step[3:], -3 * SLIP, 3 * SLIP)
        return Pose(pose.x + float(step[0]), pose.y + float(step[1]), wrap(pose.yaw + float(step[2])))

    def _confirmed(self, believed: Pose, fix: Fix) -> bool:
        """Whether the last doubtful fix, carried on by odometry, says the same."""
        if self._doubt is None:
            return False
        off = _between(carried(self._doubt[1].pose, self._doubt[0], believed), fix.pose)
        return math.hypot(off[0], off[1]) < AGREEING[0] and abs(off[2]) < AGREEING[1]


def carried(pose: Pose, before: Pose, after: Pose) -> Pose:
    """Where ``pose`` gets to by the motion from ``before`` to ``after``."""
    turn = wrap(pose.yaw - before.yaw)
    c, s = math.cos(turn), math.sin(turn)
    dx, dy = after.x - before.x, after.y - before.y
    return Pose(pose.x + c * dx - s * dy, pose.y + s * dx + c * dy, wrap(after.yaw + turn))


def replaced(sight: Sight, pose: Pose) -> Sight:
    """What was seen, as it lies on the map when the robot was at ``pose``."""
    old = sight.picture
    new = replace(old, pose=pose)
    turn = wrap(pose.yaw - old.pose.yaw)

    def moved(position: tuple[float, float, float]) -> tuple[float, float, float]:
        x, y, z = new.on_map(old.from_map(np.array([position])))[0]
        return float(x), float(y), float(z)

    def turned(direction: tuple[float, float, float]) -> tuple[float, float, float]:
        return *_turned(direction[0], direction[1], turn), direction[2]

    return Sight(
        new,
        tuple(
            replace(
                thing,
                position=moved(thing.position),
                yaw=None if thing.yaw is None else (thing.yaw + turn) % (math.pi / 2),
            )
            for thing in sight.objects
        ),
        tuple(replace(tag, position=moved(tag.position), normal=turned(tag.normal)) for tag in sight.tags),
    )


def _turned(x: float, y: float, angle: float) -> tuple[float, float]:
    c, s = math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y


def _between(a: Pose, b: Pose) -> NDArray[np.float64]:
    return np.array([b.x - a.x, b.y - a.y, wrap(b.yaw - a.yaw)])
