"""A coloured tape on the floor: which points of it a picture shows, and how it runs ahead of the robot.

Tape is what has its colour, lies flat on the floor and is narrow. The line is traced through these points in short
steps, from the one nearest to the robot; a short gap, a thing that stands on the tape for example, does not end it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.perception.colours import CHROMATIC, DARK, Hsv, hue_name, to_hsv
from engine.perception.sighting import Colour
from engine.robot.camera import Picture, Points

Spots = NDArray[np.float64]
"""Points on the floor, one a row: shape (n, 2), m."""

WIDEST: Final = 0.09
"""m; what is wider is a rug."""
SHORTEST: Final = 0.12
"""m; what is shorter is no line."""
GAP: Final = 0.16
"""m of tape that may be hidden or worn off."""
FARTHEST: Final = 3.0
"""m from the base's centre."""

_FLAT = 0.012  # m above or below the floor, and 1 % of the distance
_STEP = 0.04  # m
_BEND = math.cos(math.radians(60))  # of the sharpest bend at one step
_TANGENT = 0.15  # m of line that give its direction
_FEWEST = 12  # pixels
_PALE, _BRIGHT, _DIM = 0.22, 0.68, 0.3  # saturation and brightness of tapes without colour


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """How a tape runs, base frame."""

    colour: Colour
    points: Spots  # along the tape, the one nearest to the robot first
    offset: float  # m by which the robot would have to move to its left to stand on the line, drawn out straight
    heading: float  # rad, direction of the tape at its nearest point
    curvature: float  # 1/m, to the left, over what is seen
    ends: bool  # bare floor shows beyond the last point
    confidence: float  # 0…1: how much of the traced length really showed tape

    @property
    def nearest(self) -> tuple[float, float]:
        """The nearest point that is seen."""
        return float(self.points[0, 0]), float(self.points[0, 1])

    @property
    def length(self) -> float:
        """Of what is seen, m."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())


def tape_points(picture: Picture, colour: Colour) -> Spots:
    """What a picture shows of tapes of this colour: points in the map frame."""
    spots = _tape(picture, colour)
    return picture.on_map(np.column_stack((spots, np.zeros(len(spots)))))[:, :2]


def find_line(picture: Picture, colour: Colour) -> Line | None:
    """The tape of this colour, the nearest if there are several; None when there is none."""
    spots = _tape(picture, colour)
    if len(spots) < _FEWEST:
        return None
    start = spots[np.hypot(spots[:, 0], spots[:, 1]).argmin()]
    near = _within(spots, start, 2 * _STEP)
    axis = _axis(near, along=np.array([1.0, 0.0]))
    here = near.mean(axis=0)
    # Away from the robot; where it looks at the tape from the side, to where more of it is ahead.
    ahead, behind = (_trace(spots, here, way) for way in (axis, -axis))
    traced, shown = max((ahead, behind), key=lambda found: (len(found[0]), found[0][-1, 0]))
    length = float(np.linalg.norm(np.diff(traced, axis=0), axis=1).sum())
    if length < SHORTEST:
        return None
    count = max(2, min(len(traced), round(_TANGENT / _STEP) + 1))
    near = _within(spots, traced[count - 1], _TANGENT)  # those nearer are cut off askew by the picture's edge
    tangent = _axis(near, along=traced[count - 1] - traced[0])
    heading, (x, y) = math.atan2(tangent[1], tangent[0]), near.mean(axis=0)
    last = traced[-1] - traced[-count]
    bend = math.remainder(math.atan2(last[1], last[0]) - heading, 2 * math.pi)
    return Line(
        colour,
        traced,
        offset=float(y * math.cos(heading) - x * math.sin(heading)),
        heading=heading,
        curvature=bend / length if len(traced) > count else 0.0,
        ends=_bare_beyond(picture, traced),
        confidence=shown / (len(traced) - 1),
    )


def _tape(picture: Picture, colour: Colour) -> Spots:
    """Points of tape on the floor, base frame."""
    import cv2  # slow to import, and not every program that knows the skills has pictures

    top = _horizon(picture)
    wanted = np.zeros(picture.depth.shape, dtype=np.bool_)
    if top < len(wanted):
        wanted[top:] = _has_colour(to_hsv(picture.rgb[top:]), colour)
    wanted &= np.isfinite(picture.depth)
    if not wanted.any():
        return np.empty((0, 2))
    points = picture.points(wanted)
    flat = np.abs(points[:, 2]) < _FLAT + 0.01 * np.hypot(points[:, 0], points[:, 1])
    wanted[wanted] = flat
    points = points[flat]
    labels = cv2.connectedComponents(wanted.astype(np.uint8), connectivity=8)[1][wanted]
    areas = _areas(picture, points)
    kept = np.zeros(len(points), dtype=np.bool_)
    for label in range(1, int(labels.max(initial=0)) + 1):
        part = labels == label
        kept |= part & _narrow(points[part], float(areas[part].sum()))
    kept &= np.hypot(points[:, 0], points[:, 1]) < FARTHEST
    return points[kept, :2]


def _narrow(points: Points, area: float) -> bool:
    """Whether a patch of floor is a strip. Its length is taken as the diagonal around it, which a bend makes short."""
    length = float(np.linalg.norm(np.ptp(points[:, :2], axis=0)))
    return area < WIDEST * max(length, WIDEST)


def _areas(picture: Picture, points: Points) -> NDArray[np.float64]:
    """Of floor that each pixel shows, m²."""
    off = points - picture.mount.position
    depth = off @ picture.mount.rotation[:, 2]
    steep: NDArray[np.float64] = np.maximum(np.abs(off[:, 2]), 1e-6)
    return depth**3 / (picture.lens.fx * picture.lens.fy) / steep


def _horizon(picture: Picture) -> int:
    """The first row that can show the floor; the camera does not lean to the side."""
    height = len(picture.depth)
    rays = picture.lens.rays(np.column_stack((np.full(height, picture.lens.cx), np.arange(height) + 0.5)))
    down = (rays @ picture.mount.rotation.T)[:, 2] < -0.03
    return int(down.argmax()) if down.any() else height


def _has_colour(hsv: Hsv, colour: Colour) -> NDArray[np.bool_]:
    hue, saturation, value = hsv[..., 0], hsv[..., 1], hsv[..., 2]
    if colour in ("white", "grey", "black"):
        bright = value > _BRIGHT if colour == "white" else value < _DIM
        found: NDArray[np.bool_] = (saturation < _PALE) & bright
        if colour == "grey":
            found = (saturation < _PALE) & (value >= _DIM) & (value <= _BRIGHT)
        return found
    vivid: NDArray[np.bool_] = (saturation > CHROMATIC) & (value > DARK)
    vivid[vivid] = _hues(colour)[hue[vivid].astype(int) % 360]
    return vivid


@cache
def _hues(colour: Colour) -> NDArray[np.bool_]:
    """Which whole degrees of hue have this name."""
    return np.array([hue_name(hue) == colour for hue in range(360)])


def _within(spots: Spots, middle: NDArray[np.float64], radius: float) -> Spots:
    found: Spots = spots[((spots - middle) ** 2).sum(axis=1) < radius**2]
    return found


def _axis(spots: Spots, along: NDArray[np.float64]) -> NDArray[np.float64]:
    """The direction in which the points extend most, that way round which goes ``along``."""
    off = spots - spots.mean(axis=0)
    axis: NDArray[np.float64] = np.linalg.svd(off, full_matrices=False)[2][0]
    return axis if axis @ along >= 0 else -axis


def _trace(spots: Spots, start: NDArray[np.float64], direction: NDArray[np.float64]) -> tuple[Spots, int]:
    """Points a step apart from ``start`` on in ``direction``, and how many of the steps led over tape."""
    traced, shown = [start], 0
    while True:
        off = spots - traced[-1]
        way = np.hypot(off[:, 0], off[:, 1])
        front = (off @ direction > _BEND * way) & (way > _STEP / 2)
        close = front & (way < 1.5 * _STEP)
        if np.count_nonzero(close) >= 2:
            shown += 1
        else:
            nearest = float(way[front].min(initial=math.inf))
            if nearest > GAP:
                return np.array(traced), shown
            close = front & (way < nearest + _STEP)
        step = off[close].mean(axis=0)
        length = float(np.hypot(*step))
        if length < _STEP / 4:
            return np.array(traced), shown
        direction = 0.5 * direction + 0.5 * step / length
        direction /= np.hypot(*direction)
        traced.append(traced[-1] + step)


def _bare_beyond(picture: Picture, traced: Spots) -> bool:
    """Whether the floor after the last point is in the picture, near enough to show tape, and nothing hides it."""
    away = float(np.hypot(*traced[-1]))
    pixel = away**2 / picture.lens.fy / float(picture.mount.position[2])  # of floor, along the line of sight
    if pixel > GAP / 2 or away > FARTHEST - GAP:
        return False
    way = traced[-1] - traced[-2]
    way = way / np.hypot(*way)
    beyond = np.column_stack((traced[-1] + np.outer((0.05, 0.1, GAP), way), np.zeros(3)))
    pixels = picture.pixels(beyond)
    depth = picture.mount.into(beyond)[:, 2]
    height, width = picture.depth.shape
    for (column, row), expected in zip(pixels, depth, strict=True):
        if not (1 <= column < width - 1 and 1 <= row < height - 1):  # not a number is not inside either
            return False
        if abs(float(picture.depth[int(row), int(column)]) - float(expected)) > 0.03 + 0.03 * float(expected):
            return False
    return True
