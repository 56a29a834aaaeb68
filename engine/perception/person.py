"""People: figures that stand on the floor, sit or lie where the map has a seat or a bed, and nowhere else.

Whatever rises from what is mapped is taken apart by where it stands (:mod:`engine.perception.loose`). A figure is as
wide as a person, reaches up to where a child's head is at least, or out of the picture, and fills its outline from the
feet upwards; chairs that were moved are low and open between their legs, doors and boards are flat, and cartons and
plants have no heads.
Colours only tell how people are dressed, and a head from what is below it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.perception import figure, lying
from engine.perception.colours import Hsv, colour_name, to_hsv
from engine.perception.figure import Body
from engine.perception.loose import Loose, loose
from engine.perception.sighting import Colour, Figure, Sighting
from engine.robot.camera import Picture, Points
from engine.robot.floor_map import FloorMap

WIDTHS: Final = (0.16, 0.8)
"""m across, without and with moving arms; one that points is not counted."""
SMALLEST: Final = 0.95
"""m that somebody is tall at least, which backs of chairs are not; less shows where the picture ends above."""
_CUT = 0.3  # m that must show of somebody whom the picture's upper edge cuts
_FROM_FLOOR = 0.35  # m: what begins higher hangs, unless the picture's lower edge cuts it, or something hides it
_END = 0.15  # m from its lowest or highest point, where it reaches down or up
_SITS = 0.4  # m that somebody rises above a seat at least
_FLOOR = 0.06  # m above which something stands out
_LEGS, _FILLED = (0.1, 0.34), 0.42  # m above the floor, and how much of their width legs fill there
_FLAT = 0.012  # m that a board is uneven at most
_FEWEST = 40  # pixels
_TALL_PART = 0.25  # m that a trunk or a leg measures up and down; less is an arm that points
_BULGE = 0.5  # of the width above the knees
_NARROW = 0.62  # of the shoulders' width: a head


def find_people(picture: Picture, floor_map: FloorMap) -> tuple[Sighting, ...]:
    """Everybody in the picture, the nearest first."""
    all_of_it = loose(picture, floor_map)
    if all_of_it.count < 2:
        return ()
    hsv = to_hsv(picture.rgb[:: all_of_it.step, :: all_of_it.step])
    found = []
    for label in range(1, all_of_it.count):
        mine = all_of_it.label == label
        if np.count_nonzero(mine) < _FEWEST:
            continue
        for part in _people_in(all_of_it.take(mine), picture):
            sighting = _sighting(picture, part, hsv)
            if sighting is not None:
                found.append(sighting)
    return tuple(sorted(found, key=lambda person: person.range))


def _pixel(found: Loose, picture: Picture) -> float:
    """m that one of the pixels covers there."""
    away = float(np.median(np.linalg.norm(found.points - picture.mount.position, axis=1)))
    return away * found.step / picture.lens.fx


def _people_in(found: Loose, picture: Picture) -> Iterator[Loose]:
    """Those who stand so close together that they are one cluster: columns that reach far up and down are trunks."""
    pixel = _pixel(found, picture)
    counts = np.bincount(found.columns) * pixel
    if float(np.ptp(found.points[:, 2])) < _SITS:
        yield found  # they lie
        return
    trunk = counts > _TALL_PART
    edges = np.flatnonzero(np.diff(np.concatenate(([0], trunk.astype(int), [0]))))
    runs = [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True) if (b - a) * pixel > WIDTHS[0]]
    wide = [(a, b) for a, b in runs if (b - a) * pixel > WIDTHS[1]]
    if len(runs) < 2 and not wide:
        yield found
        return
    ends = [(a + b) // 2 for (_, a), (b, _) in pairwise(runs)]
    for low, high in zip([0, *ends], [*ends, len(counts) + 1], strict=True):
        yield found.take((found.columns >= low) & (found.columns < high))


def _sighting(picture: Picture, found: Loose, hsv: Hsv) -> Sighting | None:
    if len(found.points) < _FEWEST:
        return None
    pixel, covered = _pixel(found, picture), _hidden_above(picture, found)
    body = Body.of(found, hsv[found.rows, found.columns], pixel, covered=covered)
    seat = figure.seat_under(body)
    if seat is not None and lying.lies(body, seat):
        return _lying(picture, body, found, seat)
    if seat is None and lying.lies_on_the_floor(body):
        return _lying(picture, body, found, 0.0)
    if not _is_figure(picture, body, found, seat):
        return None
    return _upright(picture, body, found, seat)


def _is_figure(picture: Picture, body: Body, found: Loose, seat: float | None) -> bool:
    low, high = float(body.z.min()), float(body.z.max())
    if seat is not None:
        if high - seat < _SITS and not body.cut:
            return False
    else:
        shows_below = body.rows.max() < found.shape[0] - 1 and not _hidden_below(picture, found)
        if low > _FROM_FLOOR and shows_below:
            return False
        if high < SMALLEST and not (body.cut and high - low > _CUT):
            return False
        if low < _LEGS[1] and _filled(body) <= _FILLED:
            return False
    if _extent(body) < WIDTHS[0] or _across(body) > WIDTHS[1] or _unevenness(body.points) < _FLAT:
        return False
    if seat is None and _bulges(body):
        return False
    return body.cut or body.covered or _has_head(body)


def _bulges(body: Body) -> bool:
    """Whether it is far narrower below the knees than above them, as a plant is over its pot."""
    below, above = (
        [np.ptp(body.columns[body.rows == line]) + 1 for line in np.unique(body.rows[part]).tolist()]
        for part in (body.clear & (body.z > 0.24) & (body.z < 0.4), body.clear & (body.z > 0.42) & (body.z < 0.52))
    )
    return bool(below) and bool(above) and min(below) < _BULGE * max(above)


def _hidden_below(picture: Picture, found: Loose) -> bool:
    """Whether something nearer is before the lower part of what reaches down farthest: legs, and not hands."""
    return _goes_on_behind(picture, found, found.points[:, 2] < found.points[:, 2].min() + _END, 1)


def _hidden_above(picture: Picture, found: Loose) -> bool:
    """Whether something nearer is before what would be above the highest part."""
    return _goes_on_behind(picture, found, found.points[:, 2] > found.points[:, 2].max() - _END, -1)


def _goes_on_behind(picture: Picture, found: Loose, end: NDArray[np.bool_], down: int) -> bool:
    """Whether most columns of this end go on behind something nearer, ``down`` the picture (1) or up (−1)."""
    depth = picture.depth[:: found.step, :: found.step]
    last = found.shape[0] - 1
    columns = np.unique(found.columns[end])
    nearer = 0
    for column in columns.tolist():
        rows = found.rows[found.columns == column]
        edge = int(rows.max() if down > 0 else rows.min())
        beyond = depth[min(max(edge + 2 * down, 0), last), column]
        nearer += bool(0 < beyond < depth[edge, column] - 0.15)
    return nearer > 0.5 * len(columns)


def _across(body: Body) -> float:
    """Width as the robot sees it, m, of what reaches up and down; a few stray columns do not count."""
    counts = np.bincount(body.columns - body.columns.min()) * body.pixel
    return float(np.count_nonzero(counts > min(_TALL_PART, 0.5 * counts.max())) * body.pixel)


def _extent(body: Body) -> float:
    """From the leftmost to the rightmost pixel, m."""
    return float(np.ptp(body.columns) + 1) * body.pixel


def _unevenness(points: Points) -> float:
    """How far the points are from one upright plane, m."""
    off = points[:, :2] - points[:, :2].mean(axis=0)
    return float(np.linalg.svd(off, full_matrices=False)[1][-1] / math.sqrt(len(points)))


def _filled(body: Body) -> float:
    """How much of its width the figure fills, on the average over the lines of pixels below the knees; where these do
    not show, over its lowest part."""
    low = max(_LEGS[0], float(body.z.min()))
    legs = (body.z > low) & (body.z < low + _LEGS[1] - _LEGS[0])
    legs &= body.clear
    if not legs.any():
        return 1.0  # as far as can be seen
    lines = np.unique(body.rows[legs])
    widest = np.ptp(body.columns[legs]) + 1
    return float(np.count_nonzero(legs) / (len(lines) * widest))


def _has_head(body: Body) -> bool:
    """Whether the upper end is narrower than what is below, or of another colour."""
    top = body.z > body.z.max() - 0.13
    below = (body.z < body.z.max() - 0.3) & (body.z > body.z.max() - 0.6)
    if np.count_nonzero(top) < 4 or not below.any():
        return True  # too far away to tell
    lines = np.unique(body.rows[top])
    head = np.median([np.ptp(body.columns[body.rows == line]) + 1 for line in lines.tolist()])
    rest = np.ptp(body.columns[below]) + 1
    if head < _NARROW * rest:
        return True
    differs = np.abs(_mean(body.hsv[top]) - _mean(body.hsv[below])).max()
    return bool(differs > 0.14)


def _mean(hsv: Hsv) -> NDArray[np.float64]:
    """A colour as a point: equal distances look equally different, more or less."""
    hue, saturation, value = np.deg2rad(hsv[:, 0]), hsv[:, 1], hsv[:, 2]
    return np.asarray(np.median(np.stack((saturation * np.cos(hue), saturation * np.sin(hue), value)), axis=1))


def _upright(picture: Picture, body: Body, found: Loose, seat: float | None) -> Sighting:
    built = figure.build(body, seat)
    shirt, trousers = figure.clothes(body, built)
    looks = figure.facing(body, built)
    gesture, hand = figure.gesture(body, built, looks)
    seen = Figure(
        posture=built.posture,
        gesture=gesture,
        shirt=shirt,
        trousers=trousers,
        hand=_placed(picture, hand) if hand is not None else None,
        facing=None if looks is None else math.remainder(looks + picture.pose.yaw, math.tau),
    )
    return _seen(picture, body, found, seen, built.axis, 0.0 if seat is None else seat)


def _lying(picture: Picture, body: Body, found: Loose, seat: float) -> Sighting:
    shirt, trousers = lying.clothes_lying(body)
    x, y = body.points[:, :2].mean(axis=0)
    return _seen(picture, body, found, Figure("lying", None, shirt, trousers), (float(x), float(y)), seat)


def _seen(
    picture: Picture, body: Body, found: Loose, seen: Figure, middle: tuple[float, float], surface: float
) -> Sighting:
    height, width = found.shape
    away = math.hypot(*middle)
    low, high = float(body.z.min()), float(body.z.max())
    place = np.array([*middle, (low + high) / 2])
    left, top = int(body.columns.min()), int(body.rows.min())
    right, bottom = int(body.columns.max()) + 1, int(body.rows.max()) + 1
    step = found.step
    return Sighting(
        kind="person",
        colour=seen.shirt or seen.trousers or _any_colour(body),
        box=(left * step, top * step, right * step, bottom * step),
        position=_placed(picture, place),
        sigma=0.05 + 0.02 * away,
        size=(
            lying.length(body.points) if seen.posture == "lying" else min(_extent(body), WIDTHS[1]),
            high - min(low, _FLOOR),
        ),
        range=float(np.linalg.norm(place - picture.mount.position)),
        surface=surface,
        complete=left > 0 and top > 0 and right < width and bottom < height,
        figure=seen,
    )


def _any_colour(body: Body) -> Colour:
    upper = body.z >= np.percentile(body.z, 50)
    return colour_name(body.hsv[upper], np.zeros(np.count_nonzero(upper), dtype=np.bool_))


def _placed(picture: Picture, point: NDArray[np.float64]) -> tuple[float, float, float]:
    """A point of the base frame on the map."""
    x, y, z = picture.on_map(point[None])[0].tolist()
    return x, y, z
