"""Where the robot believes it is: its own motion added up, with the errors of a real base if wanted.

Every axis has a scale error of its own for the whole session, like a wheel that is slightly too large, and a random
walk that grows with the way driven. Both come from the seed, so that a session can be repeated.

Somebody who knows better, by a landmark for example, gives a *correction*: the rigid motion that takes what was added
up to where that is on the map. It is always the whole of it, so giving it twice does no harm.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from engine.robot.geometry import Pose, wrap

UNCORRECTED = Pose(0.0, 0.0, 0.0)


class Odometry:
    """Adds up motion. ``noise`` is the relative error (standard deviation of the scale error); 0 is exact."""

    def __init__(self, start: Pose, *, noise: float, seed: int) -> None:
        self._noise = noise
        self._rng = np.random.default_rng(seed)
        # Beyond two standard deviations a base would have been calibrated.
        self._scale = 1 + noise * np.clip(self._rng.standard_normal(3), -2, 2)
        self._true = start
        self._added = start  # without the correction
        self.correction = UNCORRECTED
        self.pose = start

    def resume(self, true: Pose, believed: Pose, correction: Pose) -> None:
        """Go on from where the robot is and where it believes it is, by this correction."""
        self._true, self.pose, self.correction = true, believed, correction
        self._added = compose(inverse(correction), believed)

    def correct(self, correction: Pose) -> Pose:
        """From now on the correction is this; returns where the robot believes it is."""
        self.correction = correction
        self.pose = self._corrected()
        return self.pose

    def update(self, true: Pose) -> Pose:
        """The robot is at ``true`` now; returns where it believes it is."""
        if self._noise == 0:
            self._true = self._added = true
            self.pose = self._corrected()
            return self.pose
        before, self._true = self._true, true
        c, s = math.cos(before.yaw), math.sin(before.yaw)
        dx, dy = true.x - before.x, true.y - before.y
        moved = np.array([c * dx + s * dy, c * dy - s * dx, wrap(true.yaw - before.yaw)])
        # A walk whose spread after a metre (or radian) is half the relative error.
        walk = 0.5 * self._noise * np.sqrt(np.abs(moved)) * self._rng.standard_normal(3)
        forward, left, turned = (float(v) for v in moved * self._scale + walk)
        self._added = compose(self._added, Pose(forward, left, turned))
        self.pose = self._corrected()
        return self.pose

    def _corrected(self) -> Pose:
        return self._added if self.correction == UNCORRECTED else compose(self.correction, self._added)


def believed(record: Any, correction: Any) -> Pose:
    """The pose of a state or a picture under the correction that is in force by now, of which whoever took it may
    not have known; both are records of the shared memory."""
    pose, known, now = (tuple(part.tolist()) for part in (record["pose"], record["correction"], correction["pose"]))
    return Pose(*pose) if known == now else compose(Pose(*now), compose(inverse(Pose(*known)), Pose(*pose)))


def compose(first: Pose, then: Pose) -> Pose:
    """``then``, which is told in the frame of ``first``, in the frame that ``first`` is told in."""
    c, s = math.cos(first.yaw), math.sin(first.yaw)
    return Pose(first.x + c * then.x - s * then.y, first.y + s * then.x + c * then.y, wrap(first.yaw + then.yaw))


def inverse(pose: Pose) -> Pose:
    """What ``compose`` makes nothing of: the outer frame, told in the frame of ``pose``."""
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    return Pose(-c * pose.x - s * pose.y, s * pose.x - c * pose.y, wrap(-pose.yaw))
