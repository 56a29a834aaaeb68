"""Questions about single places in a picture: how far away is what is there, and which thing is it?"""

from __future__ import annotations

from typing import Final

import numpy as np

from engine.perception.sighting import PixelBox, Sight, Sighting
from engine.robot.camera import Picture

_PATCH: Final = 1  # pixels to either side
_OVERLAP: Final = 0.1  # of the boxes, intersection over union, that makes a thing the one that is meant


def distance_at(picture: Picture, x: float, y: float) -> float | None:
    """How far from the camera is what the pixel at column ``x``, row ``y`` shows, m along the line of sight: the median
    of nine pixels. None outside the picture and where nothing is in range."""
    height, width = picture.depth.shape
    if not (0 <= x < width and 0 <= y < height):
        return None
    column, row = int(x), int(y)
    rows = slice(max(0, row - _PATCH), row + _PATCH + 1)
    columns = slice(max(0, column - _PATCH), column + _PATCH + 1)
    depth = picture.depth[rows, columns]
    known = depth[np.isfinite(depth) & (depth > 0)]
    if not known.size:
        return None
    ray = picture.lens.rays(np.array([[x, y]]))[0]
    return float(np.median(known) * np.linalg.norm(ray))


def thing_in_box(sight: Sight, x1: float, y1: float, x2: float, y2: float) -> Sighting | None:
    """The thing that a box in the picture means: the one whose own box it matches best; else the only one whose middle
    lies in it; None when that is no thing or several. The corners may come in any order."""
    wanted = (min(x1, x2), min(y1, y2), max(x1, x2), max(y1, y2))
    best = max(sight.objects, key=lambda thing: _overlap(thing.box, wanted), default=None)
    if best is not None and _overlap(best.box, wanted) >= _OVERLAP:
        return best
    inside = [thing for thing in sight.objects if _holds(wanted, thing.box)]
    return inside[0] if len(inside) == 1 else None


def _overlap(box: PixelBox, other: tuple[float, float, float, float]) -> float:
    """Intersection over union."""
    width = min(box[2], other[2]) - max(box[0], other[0])
    height = min(box[3], other[3]) - max(box[1], other[1])
    if width <= 0 or height <= 0:
        return 0.0
    common = width * height
    areas = (box[2] - box[0]) * (box[3] - box[1]) + (other[2] - other[0]) * (other[3] - other[1])
    return common / (areas - common)


def _holds(wanted: tuple[float, float, float, float], box: PixelBox) -> bool:
    x, y = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2
    return wanted[0] <= x <= wanted[2] and wanted[1] <= y <= wanted[3]
