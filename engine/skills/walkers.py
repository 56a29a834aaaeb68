"""Everybody whom the lidar sees, kept apart: each scan is shared out among those who were there before.

The lidar sees legs, all round the robot, and not whose they are. A point belongs to whoever is expected nearest to it;
points that nobody is expected near are somebody, or something, new. So two people who pass each other keep their own
legs, and one who is hidden behind another is not taken for them. What stands about and is not on the map counts as
well: it is somebody who never walks.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.robot.floor_map import FloorMap
from engine.robot.robot import Robot

AHEAD_S: Final = 1.2
"""s for which somebody is taken to walk on as they did while they do not show."""
HIDDEN_S: Final = 4.0
"""The same while something stands between."""
_REACH: Final = 0.45  # m around where somebody is expected, in which their legs are
_WIDER: Final = 0.3  # m/s by which that grows while they do not show, up to a second
_BODY: Final = 0.35  # m from one point of somebody to the next
_WALL: Final = 0.12  # m around what the map has, which is nobody
_RANGE: Final = 5.0  # m
_SMOOTH: Final = 0.35  # part of a surprise that goes into the velocity
_FASTEST: Final = 1.6  # m/s
_BESIDE: Final = 0.25  # rad to each side, in which something nearer hides who is behind it


@dataclass(slots=True, eq=False)
class Walker:
    """A person, or a thing, that stands on the floor; two that stand alike are still two."""

    at: tuple[float, float]
    """Where the lidar saw their legs last, map frame, m."""
    seen_t: float
    """When, robot time, s."""
    velocity: tuple[float, float] = (0.0, 0.0)
    """m/s, map frame."""
    hidden: bool = False
    """Something nearer stands in the way to where they are expected."""
    known_t: float = -math.inf
    """When the camera saw last that it is somebody else than who is wanted, or nobody, robot time, s."""

    def expected(self, t: float) -> tuple[float, float]:
        """Where they should be at ``t``, map frame, m."""
        ahead = min(max(0.0, t - self.seen_t), HIDDEN_S if self.hidden else AHEAD_S)
        return self.at[0] + ahead * self.velocity[0], self.at[1] + ahead * self.velocity[1]

    def seen(self, t: float, at: tuple[float, float]) -> None:
        """The lidar saw them there."""
        since = max(1e-3, min(t - self.seen_t, HIDDEN_S if self.hidden else AHEAD_S))
        vx, vy = (at[0] - self.at[0]) / since, (at[1] - self.at[1]) / since
        fast = max(1.0, math.hypot(vx, vy) / _FASTEST)
        old = self.velocity
        self.velocity = (old[0] + _SMOOTH * (vx / fast - old[0]), old[1] + _SMOOTH * (vy / fast - old[1]))
        self.at, self.seen_t, self.hidden = at, t, False


class Walkers:
    """All of them. :meth:`update` is called in every tick."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._scan_t = -math.inf
        self.everybody: list[Walker] = []
        self.points: NDArray[np.float64] = np.empty((0, 2))
        """What the newest scan has hit that is not on the map: map frame, shape (n, 2), m."""
        self.whose: NDArray[np.intp] = np.empty(0, dtype=np.intp)
        """To whom of :attr:`everybody` each of these points belongs."""

    def update(self) -> bool:
        """Take in the newest scan; whether it is another one than the last."""
        scan, pose = self._robot.scan(), self._robot.state().pose
        if scan.t == self._scan_t:
            return False
        self._scan_t = scan.t
        hit = scan.on_map(pose, _RANGE)
        self.points = hit[_loose(hit, self._robot.floor_map)]
        self.everybody = [one for one in self.everybody if scan.t - one.seen_t < HIDDEN_S + 1.0]
        self.whose = _share(self.points, scan.t, self.everybody)
        for group in _groups(self.points, self.whose):
            middle = self.points[group].mean(axis=0)
            self.everybody.append(Walker((float(middle[0]), float(middle[1])), scan.t))
            self.whose[group] = len(self.everybody) - 1
        for index, one in enumerate(self.everybody):
            mine = self.points[self.whose == index]
            if len(mine):
                one.seen(scan.t, (float(mine[:, 0].mean()), float(mine[:, 1].mean())))
            else:
                one.hidden = _is_hidden(one.expected(scan.t), hit, (pose.x, pose.y))
        return True

    def add(self, at: tuple[float, float]) -> Walker:
        """Somebody who is known to be there; whom the lidar sees there already, or a new one."""
        now = self._robot.state().t
        near = [one for one in self.everybody if math.dist(one.expected(now), at) < _REACH]
        if near:
            return min(near, key=lambda one: math.dist(one.expected(now), at))
        self.everybody.append(Walker(at, now))
        return self.everybody[-1]

    def points_beside(self, who: Walker) -> NDArray[np.float64]:
        """What was hit that is not on the map, and not they: map frame, shape (n, 2), m."""
        index = next((i for i, one in enumerate(self.everybody) if one is who), -1)
        beside: NDArray[np.float64] = self.points[self.whose != index]
        return beside


def _share(points: NDArray[np.float64], t: float, everybody: Sequence[Walker]) -> NDArray[np.intp]:
    """To whom each point belongs; −1 where it is nobody's so far."""
    if not everybody or not len(points):
        return np.full(len(points), -1, dtype=np.intp)
    expected = np.array([one.expected(t) for one in everybody])
    reach = np.array([_REACH + _WIDER * min(1.0, t - one.seen_t) for one in everybody])
    apart = np.hypot(*(points[:, None] - expected[None]).transpose(2, 0, 1))
    nearest: NDArray[np.intp] = apart.argmin(axis=1)
    nearest[apart[np.arange(len(points)), nearest] > reach[nearest]] = -1
    return nearest


def _groups(points: NDArray[np.float64], whose: NDArray[np.intp]) -> list[NDArray[np.intp]]:
    """The points of nobody so far, those of one body together: indices."""
    left = np.flatnonzero(whose < 0)
    groups: list[NDArray[np.intp]] = []
    while len(left):
        group = left[:1]
        while True:
            apart = np.hypot(*(points[left][:, None] - points[group][None]).transpose(2, 0, 1)).min(axis=1)
            grown = left[apart < _BODY]
            if len(grown) == len(group):
                break
            group = grown
        groups.append(group)
        left = np.setdiff1d(left, group)
    return groups


def _is_hidden(place: tuple[float, float], hit: NDArray[np.float64], here: tuple[float, float]) -> bool:
    """Whether something was hit nearer, in the direction of a place."""
    if not len(hit):
        return False
    dx, dy = hit[:, 0] - here[0], hit[:, 1] - here[1]
    ahead = math.atan2(place[1] - here[1], place[0] - here[0])
    aside = np.abs((np.arctan2(dy, dx) - ahead + math.pi) % (2 * math.pi) - math.pi)
    away = math.dist(place, here)
    return bool(((aside < min(_BESIDE, 0.2 / max(away, 0.1))) & (np.hypot(dx, dy) < away - 0.2)).any())


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
