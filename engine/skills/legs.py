"""Keeping hold of somebody by the lidar, which sees their legs all round the robot, also behind it."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.robot.floor_map import FloorMap
from engine.robot.robot import Robot

_NEAR: Final = 0.45  # m around where somebody is expected, in which their legs are
_AHEAD_S: Final = 0.6  # s for which they are taken to walk on as they did when they do not show
_WALL: Final = 0.12  # m around what the map has, which is not they
_RANGE: Final = 5.0  # m
_SMOOTH: Final = 0.35  # part of a surprise that goes into the velocity
_FASTEST: Final = 1.6  # m/s


class Legs:
    """Where one person is. :meth:`update` is called in every tick."""

    def __init__(self, robot: Robot, at: tuple[float, float]) -> None:
        """``at``: where they are now, map frame, m."""
        state = robot.state()
        self._robot = robot
        self.at = at
        """Where they were seen last, map frame, m."""
        self.seen_t = state.t
        """When, robot time, s."""
        self._velocity = (0.0, 0.0)
        self._scan_t = -math.inf
        self._work_t = state.work_t

    @property
    def unseen_s(self) -> float:
        """For how long they have not been seen, s."""
        return self._robot.state().t - self.seen_t

    @property
    def away(self) -> float:
        """From the robot's centre, m."""
        pose = self._robot.state().pose
        return math.dist(self.at, (pose.x, pose.y))

    @property
    def velocity(self) -> tuple[float, float]:
        """m/s, map frame."""
        return self._velocity

    @property
    def speed(self) -> float:
        """m/s."""
        return math.hypot(*self._velocity)

    def update(self) -> bool:
        """Take in the newest scan; whether they are seen."""
        scan, state = self._robot.scan(), self._robot.state()
        if scan.t == self._scan_t:
            return self.unseen_s < _AHEAD_S
        self._scan_t = scan.t
        points = scan.on_map(state.pose, _RANGE)
        points = points[_loose(points, self._robot.floor_map)]
        since = max(1e-3, min(scan.t - self.seen_t, _AHEAD_S))
        expected = (self.at[0] + self._velocity[0] * since, self.at[1] + self._velocity[1] * since)
        reach = _NEAR + 0.3 * min(1.0, scan.t - self.seen_t)
        apart = np.hypot(points[:, 0] - expected[0], points[:, 1] - expected[1])
        mine = points[apart < reach]
        if not len(mine):
            return self.unseen_s < _AHEAD_S
        nearest = mine[np.argmin(np.hypot(mine[:, 0] - expected[0], mine[:, 1] - expected[1]))]
        mine = mine[np.hypot(mine[:, 0] - nearest[0], mine[:, 1] - nearest[1]) < _NEAR]
        x, y = (float(value) for value in mine.mean(axis=0))
        vx, vy = ((x - self.at[0]) / since, (y - self.at[1]) / since)
        fast = math.hypot(vx, vy) / _FASTEST
        if fast > 1:
            vx, vy = vx / fast, vy / fast
        old = self._velocity
        self._velocity = (old[0] + _SMOOTH * (vx - old[0]), old[1] + _SMOOTH * (vy - old[1]))
        self.at, self.seen_t = (x, y), scan.t
        return True

    def moved_to(self, at: tuple[float, float]) -> None:
        """The camera has seen them there."""
        self.at, self.seen_t = at, self._robot.state().t


def _loose(points: NDArray[np.float64], floor: FloorMap) -> NDArray[np.bool_]:
    """Which points (map frame, shape (n, 2), m) belong to nothing that the map has."""
    reach = round(_WALL / floor.resolution)
    rows, columns = floor.occupied.shape
    cells = np.floor((points - floor.origin) / floor.resolution).astype(int)
    free = np.ones(len(points), dtype=np.bool_)
    for dx in range(-reach, reach + 1):
        for dy in range(-reach, reach + 1):
            x, y = np.clip(cells[:, 0] + dx, 0, columns - 1), np.clip(cells[:, 1] + dy, 0, rows - 1)
            free &= ~floor.occupied[y, x]
    return free
