"""What a picture shows that the map has not: points that stand out of the floor, or of furniture whose height is known.

Odometry errs, so that what is near mapped furniture may belong to it. Points well away from it, or well above, are
certain; those that touch it are taken in only where they go on from certain ones without a step in depth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.robot.camera import Picture, Points
from engine.robot.floor_map import FloorMap

FARTHEST: Final = 5.0
"""m from the base's centre."""
_ENOUGH = 160  # pixels across a picture that are looked at
_ROBOT = 0.32  # m from the base's centre that the robot itself takes
_CERTAIN, _DOUBTFUL = 0.15, 0.05  # m around what is mapped that may belong to it, and that is taken for it
_ABOVE = 0.06  # m over a floor or a top from which something stands out
_CELL, _HALF = 0.05, 128  # m, cells from the middle of the grid that things are told apart in
_HANGS, _BESIDE = 0.8, 0.35  # m: what begins higher hangs, beside something that is not farther away
_STEP = 0.08  # m by which the depth changes at most from pixel to pixel of one surface
_GROWTH = 0.3  # m that a surface is followed from what is certain


@dataclass(frozen=True, slots=True, eq=False)
class Loose:
    """Some pixels of a picture, one in ``step`` of each row and column, that show what the map has not."""

    step: int  # pixels
    shape: tuple[int, int]  # rows and columns of those that are looked at
    rows: NDArray[np.intp]  # in that grid
    columns: NDArray[np.intp]
    points: Points  # base frame, m
    under: NDArray[np.float32]  # height of what the map has there, m; 0 is the floor
    label: NDArray[np.int32]  # equal for what stands together; 0 belongs to nothing
    count: int  # one more than the highest label
    own: NDArray[np.bool_]  # in that grid, where the robot's own hand hides what is behind it

    def take(self, mine: NDArray[np.bool_]) -> Loose:
        """Only those."""
        return replace(
            self, rows=self.rows[mine], columns=self.columns[mine], points=self.points[mine], under=self.under[mine],
            label=self.label[mine],
        )  # fmt: skip


def loose(picture: Picture, floor_map: FloorMap) -> Loose:
    """All of it, taken apart by where it stands."""
    step = max(1, round(picture.depth.shape[1] / _ENOUGH))
    sparse = np.zeros(picture.depth.shape, dtype=np.bool_)
    sparse[::step, ::step] = np.isfinite(picture.depth[::step, ::step]) & (picture.depth[::step, ::step] > 0)
    rows, columns = (at // step for at in np.nonzero(sparse))
    points = picture.points(sparse)
    away = np.hypot(points[:, 0], points[:, 1])
    shape = sparse[::step, ::step].shape
    own = np.zeros(shape, dtype=np.bool_)
    own[rows, columns] = away <= _ROBOT
    near = (points[:, 2] > _ABOVE) & (away < FARTHEST) & (away > _ROBOT)
    rows, columns, points, away = rows[near], columns[near], points[near], away[near]
    cells, inside = _cells(picture.on_map(points), floor_map)
    tops = _tops(floor_map)
    at = cells[:, 1], cells[:, 0]
    certain = inside & (points[:, 2] > _grown(tops, _CERTAIN, floor_map)[at] + _ABOVE)
    doubtful = inside & (points[:, 2] > _grown(tops, _DOUBTFUL, floor_map)[at] + _ABOVE / 2 + 0.01 * away)
    label, count = _apart(points, certain)
    found = Loose(step, (shape[0], shape[1]), rows, columns, points, tops[at], label, count, own)
    followed = _followed(found, doubtful & ~certain, picture)
    return replace(found, label=followed).take(followed > 0)


def _tops(floor_map: FloorMap) -> NDArray[np.float32]:
    """How high what is mapped is, m; very high where nobody knows."""
    if floor_map.tops is None:
        return np.where(floor_map.occupied, _HIGH, 0).astype(np.float32)
    return np.minimum(floor_map.tops, np.float32(_HIGH))


_HIGH = 99.0


def _grown(tops: NDArray[np.float32], by: float, floor_map: FloorMap) -> NDArray[np.float32]:
    """The highest within ``by`` m of each cell."""
    reach = math.ceil(by / floor_map.resolution)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    return np.asarray(cv2.dilate(tops, disc), dtype=np.float32)


def _cells(points: Points, floor_map: FloorMap) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """In which cell of the map each point of the map frame is, and whether it is on the map at all."""
    cells = np.floor((points[:, :2] - floor_map.origin) / floor_map.resolution).astype(np.intp)
    rows, columns = floor_map.occupied.shape
    inside = (cells >= 0).all(axis=1) & (cells[:, 0] < columns) & (cells[:, 1] < rows)
    cells[~inside] = 0
    return cells, inside


def _apart(points: Points, certain: NDArray[np.bool_]) -> tuple[NDArray[np.int32], int]:
    """A number for every certain point, equal for what stands together on the floor, and one more than the highest."""
    grid = np.zeros((2 * _HALF, 2 * _HALF), dtype=np.uint8)
    cells = np.clip(np.floor(points[:, :2] / _CELL).astype(int) + _HALF, 0, 2 * _HALF - 1)
    grid[cells[certain, 1], cells[certain, 0]] = 1
    # Legs are a hand's breadth apart.
    count, labels = cv2.connectedComponents(cv2.dilate(grid, np.ones((3, 3), dtype=np.uint8)), connectivity=8)
    found = np.asarray(labels, dtype=np.int32)[cells[:, 1], cells[:, 0]]
    found[~certain] = 0
    for label in range(1, count):
        _attach(found, points, label)
    return found, int(count)


def _attach(labels: NDArray[np.int32], points: Points, label: int) -> None:
    """What hangs in the air belongs to what it hangs beside: an arm behind a head shows only above it."""
    mine = labels == label
    if not mine.any() or points[mine, 2].min() < _HANGS:
        return
    others = np.flatnonzero((labels > 0) & ~mine)
    some = points[mine][:: max(1, np.count_nonzero(mine) // 40), :2]
    away = np.linalg.norm(points[others, None, :2] - some[None], axis=2).min(axis=1, initial=math.inf)
    beside = labels[others[away < _BESIDE]]
    if len(beside) and np.count_nonzero(labels == (other := np.bincount(beside).argmax())) > np.count_nonzero(mine):
        labels[mine] = other


def _followed(found: Loose, doubtful: NDArray[np.bool_], picture: Picture) -> NDArray[np.int32]:
    """The labels, and those of the doubtful points that go on from what has one."""
    label = np.zeros(found.shape, dtype=np.int32)
    open_ = np.zeros(found.shape, dtype=np.bool_)
    label[found.rows, found.columns] = found.label
    open_[found.rows, found.columns] = doubtful
    depth = np.where(label > 0, picture.depth[:: found.step, :: found.step], np.float32(0))
    depth[open_] = picture.depth[:: found.step, :: found.step][open_]
    if not doubtful.any() or found.count < 2:
        return found.label
    pixel = float(np.median(depth[open_])) * found.step / picture.lens.fx
    for _ in range(min(60, round(_GROWTH / max(pixel, 1e-3)))):
        before = np.count_nonzero(label)
        for axis, shift in ((0, 1), (0, -1), (1, 1), (1, -1)):
            beside, beside_depth = np.roll(label, shift, axis), np.roll(depth, shift, axis)
            edge = (0 if shift > 0 else -1) if axis == 0 else (slice(None), 0 if shift > 0 else -1)
            beside[edge] = 0
            joined = open_ & (label == 0) & (beside > 0) & (np.abs(beside_depth - depth) < _STEP)
            label[joined] = beside[joined]
        if np.count_nonzero(label) == before:
            break
    return label[found.rows, found.columns]
