"""The shape of a small thing from the part of it that faces the camera: ball, upright cylinder or box, and its middle.

All points are seen from a known place. Each shape is laid against them with its bottom on the surface; the one that
fits best, weighed by the proportions that such things have, names the kind, and gives the middle behind the front.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.perception.sighting import Kind

Flat = NDArray[np.float64]
"""Points on the floor plane, shape (n, 2), m."""

_YAWS: Final = np.deg2rad(np.arange(0, 90, 3.0))
_TALL: Final = 1.6  # height over width from which a thing is a bottle, or a tall box
_NECK: Final = 0.75  # width of a bottle's top over that of the whole, at most
_MOST: Final = 240  # points are enough for a fit


@dataclass(frozen=True, slots=True)
class Shape:
    """A thing's shape, base frame, m."""

    kind: Kind
    middle: tuple[float, float]
    width: float
    height: float
    yaw: float | None  # of a box's sides, rad modulo π/2
    error: float  # mean distance of the points from the shape, m


def fit(points: NDArray[np.float64], camera: NDArray[np.float64], surface: float, pixel: float) -> Shape:
    """The likeliest shape of a thing that stands at height ``surface``; ``pixel`` is what a pixel covers there, m."""
    if len(points) > _MOST:
        points = points[:: math.ceil(len(points) / _MOST)]
    view = points[:, :2].mean(axis=0) - camera[:2]
    away = view / max(float(np.linalg.norm(view)), 1e-6)
    across = np.array([-away[1], away[0]])
    height = float(points[:, 2].max()) - surface
    spread = points[:, :2] @ across
    width = float(np.ptp(spread)) + pixel
    tallness = height / width
    box = _box(points, camera, surface, width, height, pixel)
    if tallness > _TALL:
        body = points[points[:, 2] < surface + 0.6 * height]
        bottle = _cylinder("bottle", body if len(body) >= 3 else points, surface, height, away, across, pixel)
        top = spread[points[:, 2] > surface + 0.88 * height]
        narrow = not len(top) or float(np.ptp(top)) + pixel < _NECK * width
        return bottle if narrow or bottle.error <= box.error else box
    ball = _ball(points, surface, width, height, away, across, pixel)
    cup = _cylinder("cup", points, surface, height, away, across, pixel)
    # The fewer pixels, the more proportions say and the less the fit does.
    options = [
        (shape.error + 0.45 * pixel * abs(math.log(max(tall, 0.1) / usual)), shape)
        for shape, tall, usual in (
            (box, box.height / box.width, 1.0),
            (ball, tallness, 1.0),
            (cup, cup.height / cup.width, 1.33),
        )
    ]
    return min(options, key=lambda option: option[0])[1]


def _ball(
    points: NDArray[np.float64], surface: float, width: float, height: float, away: Flat, across: Flat, pixel: float
) -> Shape:
    """A sphere that rests on the surface: its radius is the height of its middle."""
    # |p − c|² = r² with c_z = surface + r is linear in (c_x, c_y, r, c_x² + c_y²); three rounds of Gauss–Newton do it.
    radius = max(width, height) / 2
    middle = away * (float((points[:, :2] @ away).min()) + radius) + across * _centre(points[:, :2] @ across)
    for _ in range(4):
        from_middle = points - np.array([*middle, surface + radius])
        distance = np.maximum(np.linalg.norm(from_middle, axis=1), 1e-6)
        wrong = distance - radius
        slope = np.column_stack((-from_middle[:, :2] / distance[:, None], -from_middle[:, 2] / distance - 1))
        slope = np.vstack((slope, [[0, 0, 0.3]]))
        target = np.append(-wrong, 0.3 * (max(width, height) / 2 - radius))
        step = np.linalg.lstsq(slope, target, rcond=None)[0]
        middle, radius = middle + step[:2], float(np.clip(radius + step[2], 0.005, 0.15))
    distance = np.linalg.norm(points - np.array([*middle, surface + radius]), axis=1)
    error = float(np.abs(distance - radius).mean())
    return Shape("ball", _pair(middle), 2 * radius, 2 * radius, None, error)


def _cylinder(
    kind: Kind, points: NDArray[np.float64], surface: float, height: float, away: Flat, across: Flat, pixel: float
) -> Shape:
    """An upright cylinder: what is not on its top lies on a circle, whose width the outline gives."""
    flat = points[:, :2]
    ahead, aside = flat @ away, flat @ across
    side = points[:, 2] < surface + height - max(0.004, 0.35 * pixel)
    radius = (float(np.ptp(aside)) + pixel) / 2
    middle = away * (float(ahead.min()) + radius) + across * _centre(aside)
    if np.count_nonzero(side) >= 5:
        for _ in range(3):
            from_middle = flat[side] - middle
            distance = np.maximum(np.linalg.norm(from_middle, axis=1), 1e-6)
            slope = np.column_stack((-from_middle / distance[:, None], -np.ones(len(distance))))
            weight = 0.15 * math.sqrt(len(distance))
            slope = np.vstack((slope, [[0, 0, weight]]))
            outline = (float(np.ptp(aside)) + pixel) / 2
            target = np.append(radius - distance, weight * (outline - radius))
            step = np.linalg.lstsq(slope, target, rcond=None)[0]
            middle, radius = middle + step[:2], float(np.clip(radius + step[2], 0.005, 0.13))
    distance = np.linalg.norm(flat - middle, axis=1)
    off = np.where(side, np.abs(distance - radius), np.maximum(distance - radius, 0))
    return Shape(kind, _pair(middle), 2 * radius, height, None, float(off.mean()))


def _box(
    points: NDArray[np.float64], camera: NDArray[np.float64], surface: float, width: float, height: float, pixel: float
) -> Shape:
    """A box with square sides: what is not on its top lies on the sides that look at the camera."""
    c, s = np.cos(_YAWS)[:, None], np.sin(_YAWS)[:, None]
    x, y = points[:, 0][None], points[:, 1][None]
    u, v = c * x + s * y, c * y - s * x  # shape (yaws, n)
    eye_u = c[:, 0] * camera[0] + s[:, 0] * camera[1]
    eye_v = c[:, 0] * camera[1] - s[:, 0] * camera[0]
    side = points[:, 2] < surface + height - max(0.003, 0.25 * pixel)
    near_u, middle_u, size_u = _extent(u, eye_u, pixel)
    near_v, middle_v, size_v = _extent(v, eye_v, pixel)
    off = np.minimum(np.abs(u - near_u[:, None]), np.abs(v - near_v[:, None]))
    error = np.where(side[None], off, 0).mean(axis=1) if side.any() else np.zeros(len(_YAWS))
    # Many yaws fit few points: the smallest rectangle is the box.
    best = int(np.argmin(error + 0.05 * (size_u + size_v)))
    edges = np.array([size_u[best], size_v[best]])
    edge = height if np.all(np.abs(edges - height) < 0.25 * height + 1.5 * pixel) else float(edges.max())
    place = []
    for value, eye, near, middle, size in (
        (u[best], eye_u[best], near_u[best], middle_u[best], size_u[best]),
        (v[best], eye_v[best], near_v[best], middle_v[best], size_v[best]),
    ):
        outside = not value.min() <= eye <= value.max()
        length = edge if abs(edge - size) < 0.25 * edge + 1.5 * pixel else size
        place.append(near + math.copysign(length / 2, near - eye) if outside else middle)
    cos, sin = math.cos(_YAWS[best]), math.sin(_YAWS[best])
    middle_xy = (cos * place[0] - sin * place[1], sin * place[0] + cos * place[1])
    yaw = float(_YAWS[best]) if len(points) >= 12 else None
    return Shape("box", middle_xy, edge, height, yaw, float(error[best]))


def _extent(value: Flat, eye: Flat, pixel: float) -> tuple[Flat, Flat, Flat]:
    """For every yaw: the side next to the camera, the middle, and the size along one axis."""
    low, high = value.min(axis=1), value.max(axis=1)
    near = np.where(np.abs(low - eye) < np.abs(high - eye), low, high)
    return near, (low + high) / 2, high - low + 0.7 * pixel


def _centre(values: Flat) -> float:
    return float(values.min() + values.max()) / 2


def _pair(place: Flat) -> tuple[float, float]:
    return float(place[0]), float(place[1])
