"""Where the robot believes it is: its own motion added up, with the errors of a real base if wanted.

Every axis has a scale error of its own for the whole session, like a wheel that is slightly too large, and a random
walk that grows with the way driven. Both come from the seed, so that a session can be repeated.
"""

from __future__ import annotations

import math

import numpy as np

from engine.robot.geometry import Pose, compose, wrap


class Odometry:
    """Adds up motion. ``noise`` is the relative error (standard deviation of the scale error); 0 is exact."""

    def __init__(self, start: Pose, *, noise: float, seed: int) -> None:
        self._noise = noise
        self._rng = np.random.default_rng(seed)
        # Beyond two standard deviations a base would have been calibrated.
        self._scale = 1 + noise * np.clip(self._rng.standard_normal(3), -2, 2)
        self._true = self._added = start

    def resume(self, true: Pose, added: Pose) -> None:
        """Go on from where the robot is, and where its motion added up to."""
        self._true, self._added = true, added

    def update(self, true: Pose) -> Pose:
        """The robot is at ``true`` now; returns where its motion adds up to."""
        if self._noise == 0:
            self._true = self._added = true
            return true
        before, self._true = self._true, true
        c, s = math.cos(before.yaw), math.sin(before.yaw)
        dx, dy = true.x - before.x, true.y - before.y
        moved = np.array([c * dx + s * dy, c * dy - s * dx, wrap(true.yaw - before.yaw)])
        # A walk whose spread after a metre (or radian) is half the relative error.
        walk = 0.5 * self._noise * np.sqrt(np.abs(moved)) * self._rng.standard_normal(3)
        forward, left, turned = (float(v) for v in moved * self._scale + walk)
        self._added = compose(self._added, Pose(forward, left, turned))
        return self._added
