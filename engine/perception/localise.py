"""Where the robot stands, from the tags that are fixed to the house.

One tag tells everything: how far it is, in which direction, and by the way its face looks also the robot's own
heading. Several are laid on the map together by least squares, after those that contradict the others are left out.
A :class:`Localiser` weighs such a fix against odometry, whose error grows with the way driven, as a Kalman filter does,
and learns by how much each axis of the odometry counts too far or too short. What contradicts both has to be seen twice
before it is believed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.perception.sighting import Sight, TagSighting
from engine.robot.camera import Picture
from engine.robot.robot import Landmark, Pose, wrap

Covariance = NDArray[np.float64]
"""Of x, y and yaw in the map frame: m and rad, shape (3, 3)."""

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
_SURE = (0.02, math.radians(1.5))  # how well the robot knows at first where it was put

_HEADING = math.radians(0.3)  # of a face whose depth is seen, for a tag of 20 pixels
_HEADING_BY_CORNERS = math.radians(5)  # without depth: a small tag looks nearly the same when tilted the other way
_HEIGHT = 0.06  # m that a tag may seem too high or too low
_UPRIGHT = 0.35  # of the normal that may point up or down
_SHARPEST = 0.25  # of the normal towards the robot: flatter views are not believed
_RIGHT_SIZE = 1.01
_OUTLIER = 4.0  # standard deviations


@dataclass(frozen=True, slots=True, eq=False)
class Fix:
    """Where the base was when the picture was taken."""

    pose: Pose
    covariance: Covariance
    tags: int  # by how many tags

    @property
    def sigma(self) -> float:
        """Standard deviation of the position along its worse axis, m."""
        return math.sqrt(float(np.linalg.eigvalsh(self.covariance[:2, :2])[-1]))

    @property
    def sigma_yaw(self) -> float:
        """Of the heading, rad."""
        return math.sqrt(float(self.covariance[2, 2]))


@dataclass(frozen=True, slots=True)
class _Mark:
    """A landmark and how the robot sees it, base frame."""

    landmark: Landmark
    x: float  # m
    y: float
    facing: float  # rad, direction of its face
    sigma: float  # m
    sigma_facing: float  # rad

    @property
    def pose(self) -> Pose:
        """Where the robot is if this alone counts."""
        yaw = wrap(self.landmark.yaw - self.facing)
        c, s = math.cos(yaw), math.sin(yaw)
        return Pose(self.landmark.x - c * self.x + s * self.y, self.landmark.y - s * self.x - c * self.y, yaw)


def where(tags: Sequence[TagSighting], picture: Picture, landmarks: Sequence[Landmark]) -> Fix | None:
    """The robot's pose by the landmarks in a picture; None without any that can be trusted."""
    marks = [mark for mark in (_mark(tag, picture, landmarks) for tag in tags) if mark is not None]
    if not marks:
        return None
    groups = [[other for other in marks if _fits(mark.pose, other, slack=mark)] for mark in marks]
    agreed = max(groups, key=lambda group: (len(group), -sum(mark.sigma for mark in group)))
    if len(marks) > 1 and len(agreed) == 1:
        return None  # each says something else
    return _lay(agreed)


def _mark(tag: TagSighting, picture: Picture, landmarks: Sequence[Landmark]) -> _Mark | None:
    """A sighting of a landmark; None for what only has its number, such as a block."""
    landmark = next((each for each in landmarks if each.id == tag.id), None)
    if landmark is None or not 1 / _RIGHT_SIZE < tag.size / landmark.size < _RIGHT_SIZE:
        return None
    place = picture.from_map(np.array([tag.position]))[0]
    if abs(place[2] - landmark.z) > _HEIGHT + tag.sigma or abs(tag.normal[2]) > _UPRIGHT:
        return None
    facing = wrap(math.atan2(tag.normal[1], tag.normal[0]) - picture.pose.yaw)
    towards = wrap(math.atan2(-place[1], -place[0]) - facing)
    if math.cos(towards) < _SHARPEST:
        return None
    pixels = picture.lens.fx * tag.size / max(tag.range, 0.05)
    heading = (_HEADING if _has_depth(tag, picture) else _HEADING_BY_CORNERS) * max(1.0, 20 / pixels)
    return _Mark(landmark, float(place[0]), float(place[1]), facing, tag.sigma, heading)


def _has_depth(tag: TagSighting, picture: Picture) -> bool:
    column, row = tag.corners.mean(axis=0).astype(int)
    height, width = picture.depth.shape
    return 0 <= row < height and 0 <= column < width and math.isfinite(picture.depth[row, column])


def _fits(pose: Pose, mark: _Mark, slack: _Mark) -> bool:
    """Whether the robot at ``pose``, which ``slack`` told, may well see ``mark`` as it does."""
    turn = math.hypot(mark.sigma_facing, slack.sigma_facing)
    away = math.hypot(mark.x - slack.x, mark.y - slack.y)
    reach = math.hypot(mark.sigma, slack.sigma) + away * slack.sigma_facing
    x, y, facing = _off(pose, mark)
    return math.hypot(x, y) < _OUTLIER * reach and abs(facing) < _OUTLIER * turn


def _off(pose: Pose, mark: _Mark) -> tuple[float, float, float]:
    """Where ``mark`` seems to be from ``pose``, minus where it is: x, y and facing on the map."""
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    x = pose.x + c * mark.x - s * mark.y - mark.landmark.x
    y = pose.y + s * mark.x + c * mark.y - mark.landmark.y
    return x, y, wrap(pose.yaw + mark.facing - mark.landmark.yaw)


def _lay(marks: Sequence[_Mark]) -> Fix:
    """The pose from which all of them are where they should be, as nearly as their errors allow."""
    pose = min(marks, key=lambda mark: mark.sigma).pose
    weights = np.array([[1 / mark.sigma, 1 / mark.sigma, 1 / mark.sigma_facing] for mark in marks]).ravel()
    while True:
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        off = np.array([_off(pose, mark) for mark in marks]).ravel()
        slopes = np.concatenate(
            [
                np.array([[1, 0, -s * mark.x - c * mark.y], [0, 1, c * mark.x - s * mark.y], [0, 0, 1.0]])
                for mark in marks
            ]
        )
        weighed = slopes * weights[:, None]
        covariance: Covariance = np.linalg.inv(weighed.T @ weighed)
        step = covariance @ weighed.T @ (off * weights)
        pose = Pose(pose.x - float(step[0]), pose.y - float(step[1]), wrap(pose.yaw - float(step[2])))
        if float(np.abs(step).max()) < 1e-6:
            return Fix(pose, covariance, len(marks))


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

    def update(self, t: float, believed: Pose, fix: Fix | None) -> Pose:
        """A picture was taken at ``believed``, and landmarks in it told ``fix``: where the robot most probably was.

        That is ``believed`` itself where the difference does not matter. Whoever asks has to make the robot believe it.
        """
        pose = self._moved(t, believed)
        if fix is not None:
            pose = self._blend(believed, pose, fix)
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
        gain = self._covariance[:, :3] @ np.linalg.inv(spread)
        self._covariance = self._covariance - gain @ self._covariance[:3, :]
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
