"""What in a picture lies flat and what stands out of it.

Depth gives every pixel a place in the base frame. Floor is what is at height 0; a table top is a horizontal patch too
large for a small thing, at any height. What is neither stands: things, walls, legs, and the sides of furniture.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.robot.camera import Lens, Picture

Mask = NDArray[np.bool_]
Field = NDArray[np.float32]
"""A number for every pixel, or several along the last axis; single precision is a tenth of a micrometre here."""

NO_SURFACE: Final = -1
FLOOR: Final = 0
"""Label of the floor; table tops count from 1."""

HIGHEST: Final = 0.6
"""m: surfaces above cannot be seen from above."""
_SMALLEST: Final = 0.012  # m² of a horizontal patch that is no thing's upper side
_WIDE: Final = 0.16  # m that it measures at least from corner to corner
_BIN: Final = 0.01  # m, of the histogram of heights
_FLAT: Final = 0.2  # slope up to which a patch counts as horizontal
_HAND: Final = ((-0.06, 0.06), (0.012, 0.07), (0.0, 0.155))
"""Optical frame: where the fingers are, and what they hold. A camera on the hand always sees them in the same place."""
_HULL: Final = (0.17, 0.14)
"""Half length and width of the robot's own body, base frame, m."""


@dataclass(frozen=True, slots=True, eq=False)
class Relief:
    """A picture as a landscape. Arrays have the picture's shape."""

    points: Field  # base frame, m, shape (height, width, 3); inf or nan without depth
    range: Field  # from the camera, m
    pixel: Field  # m that one pixel covers there, across the line of sight
    surface: NDArray[np.int32]  # label of the surface that a pixel shows, or NO_SURFACE
    heights: tuple[float, ...]  # of the surfaces, by label, m
    standing: Mask  # what stands out of a surface, without the robot itself


def tolerance(distance: Field) -> Field:
    """How far from its surface a point still counts as part of it, m: errors of the joints grow with distance."""
    found: Field = 0.006 + 0.004 * distance
    return found


def relief(picture: Picture) -> Relief:
    """Tell what lies from what stands."""
    height, width = picture.depth.shape
    rays, lengths = _rays(picture.lens)
    seen = np.isfinite(picture.depth) & (picture.depth > 0)
    depth = np.where(seen, picture.depth, np.float32(np.nan))
    turned = picture.mount.rotation.astype(np.float32) @ rays.reshape(3, -1)
    # One coordinate after the other in memory: nearly all that follows asks for one of them.
    planes = turned.reshape(3, height, width) * depth + picture.mount.position.astype(np.float32)[:, None, None]
    points: Field = np.moveaxis(planes, 0, -1)
    distance = depth * lengths
    pixel = np.asarray(depth / picture.lens.fx, dtype=np.float32)
    with np.errstate(invalid="ignore"):
        own = _own(rays * depth, points)
        z = points[..., 2]
        surface = np.full(depth.shape, NO_SURFACE, dtype=np.int32)
        surface[np.abs(z) < tolerance(distance)] = FLOOR
        surface[z < 0] = FLOOR
        heights = [0.0]
        for top, region in _tops(picture, points, depth, own | (surface == FLOOR)):
            surface[region] = len(heights)
            heights.append(top)
        surface[own | ~seen] = NO_SURFACE
        standing = seen & ~own & (surface == NO_SURFACE)
    return Relief(points, distance, pixel, surface, tuple(heights), standing)


@lru_cache(maxsize=4)
def _rays(lens: Lens) -> tuple[Field, Field]:
    """Through all pixel centres, shape (3, height, width), and their lengths."""
    rays = np.ascontiguousarray(lens.grid().T).reshape(3, lens.height, lens.width)
    return rays.astype(np.float32), np.linalg.norm(rays, axis=0).astype(np.float32)


def _own(optical: Field, points: Field) -> Mask:
    """What is the robot itself, or in its hand."""
    own = np.ones(points.shape[:2], dtype=np.bool_)
    for axis, (low, high) in enumerate(_HAND):
        own &= (optical[axis] > low) & (optical[axis] < high)
    body: Mask = (np.abs(points[..., 0]) < _HULL[0]) & (np.abs(points[..., 1]) < _HULL[1]) & (points[..., 2] > 0.02)
    return own | body


def _tops(picture: Picture, points: Field, depth: Field, other: Mask) -> list[tuple[float, Mask]]:
    """Table tops: their heights and the pixels that show them."""
    z = points[..., 2]
    candidates = ~other & (z > 0.02) & (z < min(HIGHEST, picture.mount.position[2]))
    if not candidates.any():
        return []
    flat = candidates & _level(points)
    if not flat.any():
        return []
    # A pixel covers depth² / (f² |cos|) of a level plane, where cos is against the unnormalised ray.
    fall = np.abs((z - picture.mount.position[2]) / depth)
    area = np.where(flat, depth**2 / (picture.lens.fx * picture.lens.fy * np.maximum(fall, 1e-3)), 0.0)
    bins = int(HIGHEST / _BIN) + 2
    index = np.clip((np.where(flat, z, 0) / _BIN).astype(int), 0, bins - 1)
    histogram = np.bincount(index.ravel(), weights=area.ravel(), minlength=bins)
    found: list[tuple[float, Mask]] = []
    taken = np.zeros(depth.shape, dtype=np.bool_)
    near = cv2.getStructuringElement(cv2.MORPH_RECT, (3, 3))
    for start in np.argsort(-histogram)[:6]:
        window = flat & ~taken & (np.abs(index - start) <= 1)
        if area[window].sum() < _SMALLEST:
            continue
        top = float(np.median(z[window]))
        level = flat & ~taken & (np.abs(z - top) < 0.008)
        count, labels = cv2.connectedComponents(level.astype(np.uint8), connectivity=8)
        sizes = np.bincount(labels.ravel(), weights=area.ravel(), minlength=count)
        sizes[0] = 0
        # Seen at a flat angle a pixel covers much: a cup's upper side could pass for a table if it were not so narrow.
        wide = [label for label in np.flatnonzero(sizes > 0.25 * _SMALLEST) if _span(points, labels == label) > _WIDE]
        if not wide or sizes[wide].max() < _SMALLEST:
            continue
        large = np.isin(labels, wide)
        region = cv2.dilate(large.astype(np.uint8), near, iterations=2).astype(np.bool_)
        region &= ~other & (np.abs(z - top) < 0.009)
        found.append((top, region))
        taken |= region
    return found


def _span(points: Field, mask: Mask) -> float:
    """Diagonal of the rectangle around the points on the floor, m."""
    return float(np.hypot(*np.ptp(points[mask][:, :2], axis=0)))


def _level(points: Field) -> Mask:
    """Where the picture shows something horizontal: height hardly changes towards the pixel below or above."""
    x, y, z = (np.diff(points[..., axis], axis=0) for axis in range(3))
    gentle = z * z < _FLAT**2 * (x * x + y * y)
    level = np.zeros(points.shape[:2], dtype=np.bool_)
    level[:-1] |= gentle
    level[1:] |= gentle
    return level
