"""The chessboard that is held before a camera: how it is made, where its corners are in a picture, and how to print it.

Corners are those between four squares, row by row; the board lies in its own plane z = 0. (Which end of the board they
begin at, OpenCV does not say. Nothing here depends on it: a board that is turned by half lies in the same plane.)
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.robot.camera import Points

Pixels = NDArray[np.float64]
"""Places in a picture, one a row: shape (n, 2), as OpenCV counts them (a pixel's centre is at whole numbers)."""

PAGE_MM: Final = (297.0, 210.0)
"""A4, on its side."""
_MARGIN_MM: Final = 12.0
"""White that has to stay around the board: printers leave some, and without it the outer squares are not found."""

_NOT_MEASURED: Final = 9999.0
"""What OpenCV says where it could not."""


@dataclass(frozen=True, slots=True)
class View:
    """A board as one picture shows it."""

    corners: Pixels
    blur: float  # px from black to white, across an edge; OpenCV calls what is below 3 sharp


@dataclass(frozen=True, slots=True)
class Chessboard:
    """How one is made."""

    columns: int = 10  # squares
    rows: int = 7
    square: float = 0.025  # m

    @property
    def inner(self) -> tuple[int, int]:
        """Corners in a row and in a column."""
        return self.columns - 1, self.rows - 1

    @property
    def points(self) -> Points:
        """The corners, board frame, around the middle of the board."""
        across, along = (np.arange(count) - (count - 1) / 2 for count in self.inner)
        x, y = np.meshgrid(self.square * across, self.square * along)
        return np.column_stack((x.ravel(), y.ravel(), np.zeros(x.size)))

    def find(self, bgr: NDArray[np.uint8]) -> View | None:
        """Where it is in a picture; None where not all of it is seen."""
        grey = np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
        found, corners = cv2.findChessboardCornersSB(grey, self.inner, flags=cv2.CALIB_CB_NORMALIZE_IMAGE)
        if not found:
            return None
        return View(_finer(grey, corners.reshape(-1, 2)), _blur(grey, self.inner, corners))

    @property
    def fits(self) -> bool:
        """Whether it fits on a page."""
        across, along = PAGE_MM
        size = 1000 * self.square
        return self.columns * size <= across - 2 * _MARGIN_MM and self.rows * size <= along - 2 * _MARGIN_MM

    def sheet(self) -> str:
        """The page to print, as an SVG in millimetres."""
        (width, height), size = PAGE_MM, 1000 * self.square
        left, top = (width - self.columns * size) / 2, (height - self.rows * size) / 2
        black = "".join(
            f"M{left + column * size:g} {top + row * size:g}h{size:g}v{size:g}h{-size:g}z"
            for row in range(self.rows)
            for column in range(self.columns)
            if (row + column) % 2 == 0
        )
        told = (
            f"Print at 100 % on A4. {self.columns} × {self.rows} squares of {size:g} mm, "
            f"which are {self.columns * size:g} mm together: measure that."
        )
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}mm" height="{height:g}mm" '
            f'viewBox="0 0 {width:g} {height:g}">\n'
            f'<rect width="{width:g}" height="{height:g}" fill="white"/>\n'
            f'<path d="{black}"/>\n'
            f'<text x="{width / 2:g}" y="{height - 5:g}" font-family="sans-serif" font-size="3.5" '
            f'text-anchor="middle">{told}</text>\n</svg>\n'
        )


def _finer(grey: NDArray[np.uint8], corners: Any) -> Pixels:
    """The corners by the edges that cross there: twice as exact as they are found at first."""
    apart = float(np.linalg.norm(np.diff(corners, axis=0), axis=1).min())
    window = max(2, min(5, int(apart / 3)))  # which no other corner may reach into
    until = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.01)
    found = cv2.cornerSubPix(grey, corners[:, None].copy(), (window, window), (-1, -1), until)
    return np.asarray(found, dtype=np.float64).reshape(-1, 2)


def _blur(grey: NDArray[np.uint8], inner: tuple[int, int], corners: Any) -> float:
    """px from black to white, across the edges that lie or those that stand, whichever is more; infinite where the
    squares are too small to tell."""
    measured: list[Any] = [
        cv2.estimateChessboardSharpness(grey, inner, corners, vertical=upright)[0] for upright in (False, True)
    ]
    return max((float(one[0]) for one in measured if one[0] < _NOT_MEASURED), default=math.inf)
