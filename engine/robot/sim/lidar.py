"""The lidar: a horizontal fan of rays cast in the simulation, which sees everything but the robot itself."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from engine.robot.geometry import Pose
from engine.robot.lidar import DIRECTIONS, RAYS
from engine.robot.sim.body import UNSEEN
from engine.robot.sim.dimensions import LIDAR_HEIGHT, LIDAR_RANGE


class Lidar:
    """Casts the rays of one scan after another."""

    def __init__(self, model: Any, data: Any) -> None:
        self._model, self._data = model, data
        self._groups = np.ones(6, dtype=np.uint8)
        self._groups[UNSEEN] = 0
        self._geoms = np.empty(RAYS, dtype=np.int32)
        self._distances = np.empty(RAYS)
        self._rays = np.zeros((RAYS, 3))

    def ranges(self, pose: Pose) -> NDArray[np.float64]:
        """Distances from the robot's centre at its true ``pose``, m; inf where nothing is within range."""
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        self._rays[:, :2] = DIRECTIONS @ np.array([[c, s], [-s, c]])
        mujoco.mj_multiRay(
            self._model,
            self._data,
            np.array([pose.x, pose.y, LIDAR_HEIGHT]),
            self._rays.reshape(-1),
            self._groups,
            True,
            -1,
            self._geoms,
            self._distances,
            None,
            RAYS,
            LIDAR_RANGE,
        )
        return np.where(self._distances < 0, np.inf, self._distances)
