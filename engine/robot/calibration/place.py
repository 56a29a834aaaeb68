"""Where a camera is over the floor, by one picture of a board that lies on it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from engine.robot.calibration.chessboard import Chessboard, Pixels
from engine.robot.calibration.views import placed
from engine.robot.camera import Lens


@dataclass(frozen=True, slots=True)
class CameraPlace:
    """As a description tells it, where the camera is fixed to the base."""

    height: float  # m over the floor
    down: float  # rad by which it looks down
    askew: float  # rad by which it is turned about its line of sight, clockwise; no description tells that


def place_by(board: Chessboard, lens: Lens, corners: Pixels, thickness: float = 0.0) -> CameraPlace:
    """The place that makes this picture of the board; its squares are ``thickness`` above the floor, m."""
    axes, middle = placed(board, lens, corners)
    up = axes[:, 2]
    right, below, ahead = up.tolist()
    return CameraPlace(thickness - float(up @ middle), math.asin(-ahead), math.atan2(-right, -below))
