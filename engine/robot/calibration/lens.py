"""The lens by pictures of a board: the angle of view of a pinhole camera, which is all that :class:`Lens` knows.

Pixels are square and the line of sight is in the middle. No distortion is put right anywhere, so none is measured to be
put right; but the same pictures tell how far a lens bends lines, so that a person can be told.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from engine.robot.calibration.chessboard import Chessboard, Pixels
from engine.robot.camera import Lens

MOST_UNSURE: Final = math.radians(0.5)
"""rad; what is known worse was not seen in enough ways."""
MOST_BENT: Final = math.radians(1)
"""rad; a lens that bends lines by more is worth a warning."""
POOR: Final = 0.002
"""Of the picture's width: so is a residual that is greater."""
_LONGEST: Final = math.log(10)
"""Of a focal length by half the height, or the other way round: beyond, the search ran away, for want of tilts."""
_BARREL: Final = (
    cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_FIX_PRINCIPAL_POINT | cv2.CALIB_FIX_ASPECT_RATIO
    | cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3
)  # fmt: skip
_PINHOLE: Final = _BARREL | cv2.CALIB_FIX_K1


@dataclass(frozen=True, slots=True)
class FoundLens:
    """What was measured."""

    lens: Lens
    unsure: float  # rad, one standard deviation of the view
    error: float  # px between where corners are seen and where they should be, root mean square
    bend: float  # rad by which that is beside which is seen at the left or the right rim of the picture

    @property
    def view(self) -> float:
        """Up and down, rad."""
        return 2 * math.atan(self.lens.height / 2 / self.lens.fy)

    @property
    def poor(self) -> bool:
        """Whether the pictures do not go well with each other."""
        return self.error > POOR * self.lens.width


def lens_by(board: Chessboard, guess: Lens, views: Sequence[Pixels]) -> FoundLens:
    """The lens that makes these pictures of the board; ``guess`` is where to begin, and has their size."""
    straight, barrel = (_fitted(board, guess, views, flags) for flags in (_PINHOLE, _BARREL))
    lens = Lens(guess.width, guess.height, straight.focal, straight.focal, guess.cx, guess.cy)
    half = guess.height / 2
    ran_away = abs(math.log(straight.focal / half)) > _LONGEST
    unsure = math.inf if ran_away else 2 * half / (half**2 + straight.focal**2) * straight.spread
    rim = guess.width / 2
    return FoundLens(lens, unsure, straight.error, abs(barrel.angle(rim) - straight.angle(rim)))


@dataclass(frozen=True, slots=True)
class _Fit:
    """A lens as OpenCV fits it."""

    error: float  # px
    focal: float  # px
    spread: float  # of the focal length, px
    k1: float

    def angle(self, radius: float) -> float:
        """Between the line of sight and what is seen so many pixels beside the middle, rad."""
        matrix, bent = np.diag((self.focal, self.focal, 1.0)), np.array((self.k1, 0.0, 0.0, 0.0, 0.0))
        return math.atan(float(cv2.undistortPoints(np.array([[[radius, 0.0]]]), matrix, bent)[0, 0, 0]))


def _fitted(board: Chessboard, guess: Lens, views: Sequence[Pixels], flags: int) -> _Fit:
    points = [board.points.astype(np.float32)] * len(views)
    pictures = [view.astype(np.float32)[:, None] for view in views]
    error, matrix, bent, _, _, spread, _, _ = cv2.calibrateCameraExtended(
        points, pictures, (guess.width, guess.height), guess.matrix, np.zeros(5), flags=flags
    )
    return _Fit(float(error), float(matrix[1, 1]), float(spread[1, 0]), float(bent.ravel()[0]))
