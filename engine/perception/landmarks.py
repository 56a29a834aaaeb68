"""Where the robot stands, from the tags that are fixed to the house.

One tag tells everything: how far it is, in which direction, and by the way its face looks also the robot's own
heading. Several are laid on the map together by least squares, after those that contradict the others are left out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.perception.sighting import TagSighting
from engine.robot.camera import Picture
from engine.robot.floor_map import Landmark
from engine.robot.geometry import Pose, wrap

Covariance = NDArray[np.float64]
"""Of x, y and yaw in the map frame: m and rad, shape (3, 3)."""

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
