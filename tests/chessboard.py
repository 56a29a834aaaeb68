"""A chessboard as a camera would see it: drawn where it is to be seen, by a lens and a place that a test knows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.robot.calibration.chessboard import Chessboard, Pixels
from engine.robot.camera import Lens, Mount, Points

BOARD = Chessboard()
LENS = Lens.of_view(640, 480, math.radians(52))
FPS = 10
_DOTS = 4000
"""A metre of the sheet, in pixels of what it is drawn from."""
_FINER = 2
"""Times as fine as the picture: edges are as soft as a camera's."""

Picture = NDArray[np.uint8]
Placed = tuple[Points, Points]
"""A board's axes as columns and its middle, optical frame, m: x to its right, y down, z away from who looks at it."""


def held(right: float = 0, down: float = 0, away: float = 0.55, *, yaw: float = 0, pitch: float = 0) -> Placed:
    """A board before a camera. Turned by so many degrees, ``yaw`` brings its left edge nearer, ``pitch`` the upper."""
    about_y = cv2.Rodrigues((0.0, -math.radians(yaw), 0.0))[0]
    about_x = cv2.Rodrigues((math.radians(pitch), 0.0, 0.0))[0]
    return np.asarray(about_y @ about_x, dtype=np.float64), np.array([right, down, away])


def on_the_floor(mount: Mount, ahead: float = 0.7, aside: float = 0.03, turned: float = 10) -> Placed:
    """A board that lies before the robot; ``turned`` is in degrees."""
    c, s = math.cos(math.radians(turned)), math.sin(math.radians(turned))
    axes = np.column_stack(((s, -c, 0.0), (-c, -s, 0.0), (0.0, 0.0, -1.0)))  # its right is the robot's
    return mount.rotation.T @ axes, mount.into(np.array([[ahead, aside, 0.0]]))[0]


def corners(placed: Placed, lens: Lens = LENS, board: Chessboard = BOARD) -> Pixels:
    """Where the corners are to be seen, as OpenCV counts pixels."""
    axes, middle = placed
    return lens.project(board.points @ axes.T + middle) - 0.5


def picture(placed: Placed | None, lens: Lens = LENS, board: Chessboard = BOARD) -> Picture:
    """A picture of a grey room, BGR, with a board in it or none."""
    finer = Lens.of_view(_FINER * lens.width, _FINER * lens.height, 2 * math.atan(lens.height / 2 / lens.fy))
    fine = np.full((finer.height, finer.width), 130, dtype=np.uint8)
    if placed is not None:
        axes, middle = placed
        sheet, to_board = _sheet(board)
        homography = finer.matrix @ np.column_stack((axes[:, 0], axes[:, 1], middle)) @ to_board
        size = finer.width, finer.height
        cv2.warpPerspective(sheet, homography, size, fine, cv2.INTER_LINEAR, cv2.BORDER_TRANSPARENT)
    grey = cv2.resize(fine, (lens.width, lens.height), interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR), dtype=np.uint8)


def _sheet(board: Chessboard) -> tuple[Picture, NDArray[np.float64]]:
    """The printed page, and what brings its pixels into the board's plane, m."""
    white = 0.015
    columns, rows = (np.arange(round((n * board.square + 2 * white) * _DOTS)) for n in (board.columns, board.rows))
    column, row = (((dots + 0.5) / _DOTS - white) // board.square for dots in np.meshgrid(columns, rows))
    inside = (column >= 0) & (column < board.columns) & (row >= 0) & (row < board.rows)
    sheet = np.where(inside & ((column + row) % 2 == 0), 25, 235).astype(np.uint8)
    left, top = (0.5 / _DOTS - white - n * board.square / 2 for n in (board.columns, board.rows))
    return sheet, np.array([[1 / _DOTS, 0, left], [0, 1 / _DOTS, top], [0, 0, 1]])


def ways() -> Iterator[Placed]:
    """As many ways to hold a board as are wanted, as a person does who was told how."""
    for yaw, pitch in ((30, 0), (-30, 0), (0, 30), (0, -30), (25, -25), (-25, -25)):
        yield held(0.02, 0.01, 0.5, yaw=yaw, pitch=pitch)
    for right, down in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        yield held(0.17 * right, 0.13 * down, 0.55, yaw=15 * right, pitch=-15 * down)
    yield held(away=0.4)
    yield held(away=0.8)


def still(placed: Iterable[Placed | None], count: int = 3) -> Iterator[Picture]:
    """Each of them for so many pictures."""
    for one in placed:
        for _ in range(count):
            yield picture(one)


def film(path: Path, pictures: Iterable[Picture]) -> Path:
    """A film that a camera can be replaced with."""
    writer: cv2.VideoWriter | None = None
    for one in pictures:
        height, width = one.shape[:2]
        writer = writer or cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), FPS, (width, height))
        writer.write(one)
    assert writer is not None, "a film has pictures"
    writer.release()
    return path
