"""Whoever lies: long and low, on what the map has or on the floor.

On the floor it is a head or shoes that tell somebody from what was put there: with a head at one end of it, seen from
aside; with one of these in front of something long that is none of it, seen from an end.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.perception.clothes import colour, is_dark, is_skin, looks_like_a_head
from engine.perception.figure import Body
from engine.perception.sighting import Colour
from engine.robot.camera import Points

_LOW, _LONG = 0.5, 0.6  # m that somebody who lies rises above the bed at most, and measures from end to end at least
_FEWEST: Final = 12  # pixels that tell anything
_WHOLE, _HEAD_SHARE = 1.0, 0.3  # m that somebody on the floor measures; part of an end that a head is
_NARROW, _WIDE = 0.2, 1.25  # m across, more or less from an end
_NEAR, _BEHIND = 0.15, 0.3  # of the length: what is at the near end, and where the rest begins
_MOSTLY, _HARDLY = 0.65, 0.2  # of the pixels there


def lies(body: Body, seat: float) -> bool:
    """Whether it is long and low."""
    return float(np.percentile(body.z, 98)) - seat < _LOW and length(body.points) > _LONG


def lies_on_the_floor(body: Body) -> bool:
    """Whether it is long and flat there, and somebody."""
    if float(np.percentile(body.z, 98)) > _LOW or len(body.points) < 4 * _FEWEST:
        return False
    return _from_aside(body) or _from_an_end(body)


def _from_aside(body: Body) -> bool:
    """A head is at one end, skin and hair, and none in the middle."""
    if length(body.points) < _WHOLE:
        return False
    along = _along(body)
    ends = (body.hsv[along < 0.15], body.hsv[along > 0.85])
    middle = body.hsv[(along > 0.3) & (along < 0.7)]
    if min(map(len, (*ends, middle))) < _FEWEST:
        return False
    return max(map(looks_like_a_head, ends)) > _HEAD_SHARE and float(np.mean(is_skin(middle))) < _HEAD_SHARE


def _from_an_end(body: Body) -> bool:
    """A head is nearest, or shoes, which hide much of what is behind; the far end is neither."""
    if not _NARROW < (float(np.ptp(body.columns)) + 1) * body.pixel < _WIDE:
        return False
    away = np.hypot(body.points[:, 0], body.points[:, 1])
    near, far = np.percentile(away, (0.5, 99.5))
    if far - near < _LONG:
        return False
    part = (away - near) / (far - near)
    front, behind, end = body.hsv[part < _NEAR], body.hsv[part > _BEHIND], body.hsv[part > 1 - _NEAR]
    if min(len(front), len(behind)) < _FEWEST:
        return False
    head = np.mean(is_skin(front)) > _MOSTLY and np.mean(is_skin(behind)) < _HARDLY
    shoes = np.mean(is_dark(front)) > _MOSTLY and np.mean(is_dark(end)) < _HARDLY and is_skin(behind).any()
    return bool(head or shoes)


def _along(body: Body) -> NDArray[np.float64]:
    """How far along each point is from one end to the other, 0 to 1."""
    along = _on_axis(body.points)
    low, high = np.percentile(along, (0.5, 99.5))
    return np.asarray((along - low) / (high - low))


def _on_axis(points: Points) -> NDArray[np.float64]:
    """How far along the longest line on the floor each point is, from the middle, m."""
    flat = points[:, :2] - points[:, :2].mean(axis=0)
    return np.asarray(flat @ np.linalg.svd(flat, full_matrices=False)[2][0])


def length(points: Points) -> float:
    """From end to end along the floor, m."""
    low, high = np.percentile(_on_axis(points), (1, 99))
    return float(high - low)


def clothes_lying(body: Body) -> tuple[Colour | None, Colour | None]:
    """The colours of shirt and trousers, from the end where the head is."""
    part = _along(body)
    if np.ptp(body.columns) * body.pixel < 0.5 * length(body.points):
        return None, None  # they are seen from an end, which is all that shows
    if looks_like_a_head(body.hsv[part > 0.88]) > looks_like_a_head(body.hsv[part < 0.12]):
        part = 1 - part
    return colour(body.hsv[(part > 0.2) & (part < 0.4)]), colour(body.hsv[(part > 0.63) & (part < 0.86)])
