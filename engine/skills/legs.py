"""Keeping hold of somebody by the lidar, which sees their legs all round the robot, also behind it."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.robot.floor_map import FloorMap
from engine.robot.robot import Robot

_NEAR: Final = 0.45  # m around where somebody is expected, in which their legs are
_AHEAD_S: Final = 1.2  # s for which they are taken to walk on as they did when they do not show
_WALL: Final = 0.12  # m around what the map has, which is not they
_RANGE: Final = 5.0  # m
_SMOOTH: Final = 0.35  # part of a surprise that goes into the velocity
_FASTEST: Final = 1.6  # m/s
_KEEP_S: Final = 8.0  # s for which scans are kept
_EVERY_S: Final = 0.2  # s between two that are
_WENT: Final = 0.7  # m that they have gone since: what stood there then and stands there now is not they
_SAME: Final = 0.15  # m
_CROSSED: Final = 0.6  # m around them, in which something else makes it doubtful who is who
_APART: Final = 0.4  # m from them, from which it was somebody else


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
        self.others: NDArray[np.float64] = np.empty((0, 2))
        """What stands about and is not they, and not on the map: points of the map frame, m."""
        self.crossed = False
        """Somebody or something else has been so near that these may be other legs now."""
        self._velocity = (0.0, 0.0)
        self._scan_t = -math.inf
        self._before: list[tuple[float, NDArray[np.float64], tuple[float, float]]] = []  # scans, and where they were

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
        others = self._others(scan.t, points)
        if not self._before or scan.t - self._before[-1][0] > _EVERY_S:
            self._before.append((scan.t, points, self.at))
        self.others = points[others | (np.hypot(points[:, 0] - self.at[0], points[:, 1] - self.at[1]) > _NEAR + 0.2)]
        near = others & (np.hypot(points[:, 0] - self.at[0], points[:, 1] - self.at[1]) < _CROSSED)
        self.crossed = self.crossed or bool(near.any())
        points = points[~others]
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

    def _others(self, t: float, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which points stood there already when they were elsewhere."""
        self._before = [scan for scan in self._before if t - scan[0] < _KEEP_S]
        found = np.zeros(len(points), dtype=np.bool_)
        old = next((scan for scan in reversed(self._before) if math.dist(scan[2], self.at) > _WENT), None)
        if old is None or not len(old[1]) or not len(points):
            return found
        _, then, at = old
        then = then[np.hypot(then[:, 0] - at[0], then[:, 1] - at[1]) > _APART]
        if len(then):
            apart = np.hypot(*(points[:, None] - then[None]).transpose(2, 0, 1)).min(axis=1)
            found = apart < _SAME
        return found

    def is_sure(self) -> None:
        """The camera has seen that it is they."""
        self.crossed = False

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
