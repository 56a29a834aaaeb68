"""Keeping hold of one person among others by the lidar, which sees their legs all round the robot, also behind it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.robot.robot import Robot
from engine.skills.walkers import AHEAD_S, Walker, Walkers

_CROSSED: Final = 0.6  # m around them, in which somebody else makes it doubtful who is who
_LEFT: Final = 0.8  # m from them, where somebody is not beside them any more
_CLEARED_S: Final = 8.0  # s for which it counts that the camera has seen somebody else
_LATELY_S: Final = 0.3  # s without the lidar, after which the camera tells better where they are


class Legs:
    """Where one person is. :meth:`update` is called in every tick."""

    def __init__(self, robot: Robot, at: tuple[float, float]) -> None:
        """``at``: where they are now, map frame, m."""
        self._robot = robot
        self._all = Walkers(robot)
        self._mine = self._all.add(at)
        self._sure = Walker(at, robot.state().t)  # as the camera saw them last
        self._beside: list[Walker] = []  # who was there when the camera saw that it is they
        self.crossed = False
        """Somebody or something else has been so near that these may be other legs now."""

    @property
    def at(self) -> tuple[float, float]:
        """Where they were seen last, map frame, m."""
        return self._mine.at

    @property
    def expected(self) -> tuple[float, float]:
        """Where they should be by now, map frame, m."""
        return self._mine.expected(self._robot.state().t)

    @property
    def unseen_s(self) -> float:
        """For how long they have not been seen, s."""
        return self._robot.state().t - self._mine.seen_t

    @property
    def away(self) -> float:
        """From the robot's centre, m."""
        pose = self._robot.state().pose
        return math.dist(self.at, (pose.x, pose.y))

    @property
    def velocity(self) -> tuple[float, float]:
        """m/s, map frame."""
        return self._mine.velocity

    @property
    def speed(self) -> float:
        """m/s."""
        return math.hypot(*self.velocity)

    @property
    def others(self) -> NDArray[np.float64]:
        """What stands about and is not they, and not on the map: points of the map frame, shape (n, 2), m."""
        return self._all.points_beside(self._mine)

    def update(self) -> bool:
        """Take in the newest scan; whether they are seen."""
        if self._all.update():
            if self._mine not in self._all.everybody:  # out of sight for too long
                self._all.everybody.append(self._mine)
            self._beside = [one for one in self._beside if math.dist(one.at, self._mine.at) < _LEFT]
            self.crossed = self.crossed or any(one not in self._beside for one in self._near())
        return self.unseen_s < AHEAD_S

    def is_sure(self) -> None:
        """The camera has seen that it is they. Who is beside them now makes it doubtful when they come back."""
        self.crossed = False
        self._beside = self._near()

    def _near(self) -> list[Walker]:
        since = self._mine.seen_t - _LATELY_S
        others = (one for one in self._all.everybody if one is not self._mine and one.seen_t >= since)
        return [one for one in others if math.dist(one.at, self._mine.at) < _CROSSED]

    def moved_to(self, at: tuple[float, float]) -> None:
        """The camera has seen them there: those whom the lidar sees there are they."""
        now = self._robot.state().t
        found = self._all.add(at)
        if found is self._mine and self.unseen_s > _LATELY_S:
            found.at, found.seen_t = at, now
        self._mine = found
        found.known_t = -math.inf
        self._sure = replace(found, at=at, seen_t=now)

    def is_somebody_else(self, at: tuple[float, float]) -> None:
        """The camera has seen somebody else there, or nobody. If it was they by the lidar, they are expected from now
        on where they would have walked since the camera saw them last."""
        found = self._all.add(at)
        found.known_t = self._robot.state().t
        if found is self._mine:
            self._mine = replace(self._sure, hidden=True)
            self._all.everybody.append(self._mine)

    def candidates(self) -> list[Walker]:
        """Who else may be they: everybody whom the lidar sees and the camera has not, the nearest to where they are
        expected first."""
        now, at = self._robot.state().t, self.expected
        unknown = [
            one
            for one in self._all.everybody
            if one is not self._mine and now - one.known_t > _CLEARED_S and now - one.seen_t < AHEAD_S
        ]
        return sorted(unknown, key=lambda one: math.dist(one.at, at))
