"""What stands around a robot that drives while its lidar turns: every point lies where it was seen from.

What is nearer than a lidar measures looks to it like nothing at all. So points that have come that near stay, until
something is measured in their direction, or the robot has moved away from them.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.robot.geometry import Pose
from engine.robot.lidar import RAYS, Turn, ranges_of

POSES: Final = 100
"""How many of the last are remembered, one of each control period."""
OLD_S: Final = 0.3
"""A turn whose last point is older than this is over."""
MARGIN_M: Final = 0.1
"""By so much farther than the nearest that a lidar measures, a point counts as near."""

Points = NDArray[np.float64]


class Surroundings:
    """Those of one robot, in the frame in which its odometry adds up."""

    def __init__(self, at: tuple[float, float], nearest: float) -> None:
        """``at`` is the lidar's place in the base frame; it measures nothing nearer than ``nearest``, m."""
        self._at = np.array(at)
        self._reach = nearest + MARGIN_M
        self._been: deque[tuple[float, float, float, float]] = deque(maxlen=POSES)
        self._near: Points = np.empty((0, 2))

    def was(self, t: float, pose: Pose) -> None:
        """Where the robot was at ``t``, s; asked for in the order of time."""
        self._been.append((t, pose.x, pose.y, pose.yaw))

    def scan(self, turn: Turn, now: float, here: Pose) -> NDArray[np.float64] | None:
        """The scan (``engine.robot.lidar``) that a turn is to the robot that is ``here`` by ``now``; None where the
        turn is too old, or nobody knows from where it was seen."""
        if not self._been or not len(turn.times) or now - float(turn.times[-1]) > OLD_S:
            return None
        known = turn.times >= self._been[0][0]
        turn = Turn(turn.points[known], turn.times[known])
        if not len(turn.times):
            return None
        seen = np.concatenate((points := turn.seen_from(np.array(self._been), here), self._still_near(points, here)))
        near = seen[np.hypot(*(seen - self._at).T) < self._reach]
        self._near = _out_of(here, near)
        return ranges_of(seen)

    def _still_near(self, seen: Points, here: Pose) -> Points:
        """Near points of before, in directions in which nothing was measured now."""
        kept = _into(here, self._near)
        kept = kept[np.hypot(*(kept - self._at).T) < self._reach]
        measured = np.zeros(RAYS, dtype=bool)
        measured[_rays(seen - self._at)] = True
        wide = measured | np.roll(measured, 1) | np.roll(measured, -1)
        found: Points = kept[~wide[_rays(kept - self._at)]]
        return found


def _rays(points: Points) -> NDArray[np.intp]:
    turn = np.arctan2(points[:, 1], points[:, 0]) * (RAYS / (2 * math.pi))
    return np.rint(turn).astype(np.intp) % RAYS


def _out_of(pose: Pose, points: Points) -> Points:
    """From the frame of a robot at ``pose`` to that in which the pose is."""
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    found: Points = points @ np.array([[c, s], [-s, c]]) + (pose.x, pose.y)
    return found


def _into(pose: Pose, points: Points) -> Points:
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    found: Points = (points - (pose.x, pose.y)) @ np.array([[c, -s], [s, c]])
    return found
