"""Loose things: which of the pieces that stand in a picture are small things, and what each of them is.

A small thing stands on a surface, shows its own outline, and is no larger than a hand can hold. What is larger, carries
a table top, hangs on a wall or is the visible rest of something hidden is part of the house. Close to walls and
furniture of the map more is asked for, because that is where pieces of them show.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.perception.colours import CHROMATIC, DARK, colour_name, to_hsv
from engine.perception.pieces import Piece, take_apart
from engine.perception.piles import apart
from engine.perception.shapes import Shape, fit
from engine.perception.sighting import Colour, Kind, Sighting, TagSighting
from engine.perception.surfaces import Relief, relief
from engine.robot.camera import Picture
from engine.robot.floor_map import FloorMap

LARGEST: Final = 0.25
"""m that a small thing measures at most."""
SMALLEST: Final = 0.018
"""m that it stands out of its surface at least."""
FARTHEST: Final = 2.6
"""m from the camera beyond which nothing small is reported."""
_FIXED_NEAR, _FIXED_GROWS = 0.1, 0.05
"""m from walls and furniture within which a piece may belong to them, and how it grows with distance: odometry errs."""
_TOP_CUT, _TOP_CLEAR = 0.9, 0.3  # m away from which, near what is fixed, the upper edge cuts off no small thing
_FEWEST: Final = 4  # pixels
_SLIVER, _RIM = 3, 0.3  # pixels across, and how much of the outline ends at something nearer
_UPRIGHT: Final = 3  # times as high as wide, which no far bottle is that is so narrow
_COVERED: Final = 0.15  # of the outline, from which on it may be another thing than it looks
_FAR_PIXEL: Final = 0.01  # m that a pixel covers where thin strips are lost
_OVERHANG: Final = 0.55  # of its height, that a ball hides of its own lower half when it is seen from above
_CHEQUERED_FROM: Final = 12  # pixels from which a tag's pattern can be told from a box's faces
_PALE: Final = 0.25  # saturation of labels and caps


def find_things(picture: Picture, floor_map: FloorMap, tags: Sequence[TagSighting] = ()) -> tuple[Sighting, ...]:
    """All small things in the picture, the nearest first."""
    land = relief(picture)
    pieces = _bottles(take_apart(land, to_hsv(picture.rgb), widest=2 * LARGEST))
    fixed = _distance_to_fixed(floor_map)
    found: list[Sighting] = []
    for piece in pieces:
        surface = _support(piece, land, pieces) if _small(piece) else None
        if surface is not None and _plausible(piece, surface):
            sighting = _sighting(picture, floor_map, fixed, piece, surface, tags)
            if sighting is not None:
                found.extend(apart(sighting, tags))
    return tuple(sorted(found, key=lambda sighting: sighting.range))


def _support(piece: Piece, land: Relief, pieces: Sequence[Piece]) -> float | None:
    """Height of what it stands on; None when it hangs."""
    reach = 0.012 + 2 * piece.pixel
    for label in piece.around.under:
        height = land.heights[label]
        if piece.low - height < max(reach, _OVERHANG * (piece.high - height)):
            return height
    left, _, right, bottom = piece.box
    for other in pieces:  # on another thing?
        if other is piece or abs(other.high - piece.low) > reach or other.around.carries > 0.3:
            continue
        l2, top, r2, _ = other.box
        if min(right, r2) > max(left, l2) and top - 2 <= bottom and other.span < LARGEST:
            gap = np.linalg.norm(other.middle - piece.middle)
            if gap < 0.06:
                return other.high
    if "bottom" in piece.cut or piece.around.foot_hidden:
        below = [height for height in land.heights if height < piece.low + 0.005]
        if below and piece.low - max(below) < 0.06:
            return max(below)
    return None


def _small(piece: Piece) -> bool:
    """Whether it is as large as a small thing, in the picture and on the floor."""
    left, top, right, bottom = piece.box
    enough = piece.n >= _FEWEST and min(right - left, bottom - top) >= 2
    return enough and piece.span <= 1.2 * LARGEST and not {"left", "right"} <= piece.cut


def _plausible(piece: Piece, surface: float) -> bool:
    """As far as its height and its outline go."""
    high = piece.high - surface
    if not SMALLEST - 0.2 * piece.pixel < high < LARGEST:
        return False
    if piece.around.carries > 0.3 or piece.around.hidden > 0.5:
        return False
    # Else it is what shows of something beside a finger, or behind another thing.
    return not _is_sliver(piece) or piece.around.hidden <= _RIM


def _is_sliver(piece: Piece) -> bool:
    left, top, right, bottom = piece.box
    return min(right - left, bottom - top) <= _SLIVER


def _sighting(
    picture: Picture,
    floor_map: FloorMap,
    fixed: NDArray[np.float64],
    piece: Piece,
    surface: float,
    tags: Sequence[TagSighting],
) -> Sighting | None:
    camera = picture.mount.position
    shape = fit(piece.points, camera, surface, piece.pixel)
    height = shape.height
    middle = np.array([*shape.middle, surface + height / 2])
    away = float(np.linalg.norm(middle - camera))
    covered = piece.around.foot_hidden or piece.around.hidden > _COVERED
    complete = not piece.cut and not covered
    x, y, z = picture.on_map(middle[None])[0].tolist()
    if away > FARTHEST or shape.width > LARGEST:
        return None
    clearance = _clearance(floor_map, fixed, x, y)
    if surface < 0.02:
        doubtful = clearance < _FIXED_NEAR + _FIXED_GROWS * away
    else:
        doubtful = not _on_a_table(floor_map, x, y, surface)
    if doubtful and (not complete or piece.n < 10 or height > 3.5 * shape.width):
        return None
    left, top, right, bottom = piece.box
    upright = _is_sliver(piece) and bottom - top > _UPRIGHT * (right - left)
    if upright and clearance < 2 * (_FIXED_NEAR + _FIXED_GROWS * away):
        return None  # the edge of a wall, past which depth errs
    if "top" in piece.cut and (height > 3 * shape.width or (away > _TOP_CUT and clearance < _TOP_CLEAR)):
        return None
    tag = _tag_on(piece, tags)
    kind: Kind = shape.kind
    if tag is not None or (kind == "box" and _chequered(piece)):
        kind = "block"
    if kind != "block" and (height / shape.width < 0.3 or height / shape.width > 4):
        kind = "thing"
    return Sighting(
        kind,
        _colour(piece, kind, surface),
        piece.box,
        (x, y, z),
        _sigma(away, piece, complete),
        (shape.width, height),
        away,
        surface,
        _yaw(shape, picture, kind),
        tag,
        complete,
    )


def _sigma(away: float, piece: Piece, complete: bool) -> float:
    sigma = 0.003 + 0.4 * piece.pixel
    if not complete:
        sigma += 0.012
    return round(sigma + 0.002 * away, 4)


def _yaw(shape: Shape, picture: Picture, kind: Kind) -> float | None:
    if shape.yaw is None or kind not in ("box", "block"):
        return None
    return (shape.yaw + picture.pose.yaw) % (math.pi / 2)


def _tag_on(piece: Piece, tags: Sequence[TagSighting]) -> int | None:
    """The tag that is on this piece: its middle lies in the piece's picture."""
    left, top, right, bottom = piece.box
    for tag in tags:
        column, row = tag.corners.mean(axis=0)
        if left <= column <= right and top <= row <= bottom:
            return tag.id
    return None


def _chequered(piece: Piece) -> bool:
    """Whether grey changes from pixel to pixel all over, as on a tag that is too far away to be read."""
    if piece.n < _CHEQUERED_FROM or np.median(piece.hsv[:, 1]) > _PALE:
        return False
    left, top, right, bottom = piece.box
    value = np.full((bottom - top, right - left), np.nan)
    value[piece.rows - top, piece.columns - left] = piece.hsv[:, 2]
    for axis in (0, 1):  # shading gets darker in one direction, a pattern in both
        steps = np.diff(value, axis=axis)
        steps = steps[np.isfinite(steps)]
        if min(np.count_nonzero(steps > 0.05), np.count_nonzero(steps < -0.05)) > 0.15 * len(steps):
            return True
    return False


def _colour(piece: Piece, kind: Kind, surface: float) -> Colour:
    if kind == "block":
        return "white"
    pixels = piece.hsv
    share = (piece.points[:, 2] - surface) / (piece.high - surface)
    above = np.ones(piece.n, dtype=np.bool_) if kind == "ball" else share > 0.93
    if kind == "bottle":  # not its label and not its cap
        strong = (pixels[:, 1] > CHROMATIC) & (pixels[:, 2] > DARK)
        body = (share < 0.16) | ((share > 0.7) & (share < 0.84))
        chosen = strong if np.count_nonzero(strong) >= 0.2 * piece.n else body
        if np.count_nonzero(chosen) >= 3:
            pixels, above = pixels[chosen], above[chosen]
    return colour_name(pixels, above)


def _bottles(pieces: list[Piece]) -> list[Piece]:
    """Labels and caps put back on their bottles: pale pieces on the axis of coloured ones."""
    merged = list(pieces)
    waiting = [piece for piece in pieces if not piece.coloured and piece.span < 0.12]
    while waiting:
        pale = waiting.pop(0)
        strong = [other for other in merged if other is not pale and other.coloured and _on_one_axis(pale, other)]
        reach = 0.012 + pale.pixel
        above = [other for other in strong if other.low > pale.high - reach]
        below = [other for other in strong if other.high < pale.low + reach]
        if above and below:
            chosen = [above[0], below[0]]
        elif above and (pale.pixel > _FAR_PIXEL or _foot_out_of_sight(pale)) and _tapers(above[0]):
            chosen = above[:1]  # the strip below the label is too far away, behind a finger, or off the picture
        else:
            chosen = [other for other in below if pale.span < 0.75 * max(other.span, 0.01)][:1]
        if not chosen:
            continue
        whole = pale
        for other in chosen:
            whole = whole.joined(other)
        merged = [piece for piece in merged if piece is not pale and all(piece is not other for other in chosen)]
        merged.append(whole)
    return merged


def _foot_out_of_sight(piece: Piece) -> bool:
    return "bottom" in piece.cut or piece.around.foot_hidden


def _tapers(piece: Piece) -> bool:
    """Whether its upper end is narrower than its lower one."""
    left, top, right, _ = piece.box
    upper = piece.columns[piece.rows == top]
    return len(np.unique(upper)) < 0.75 * (right - left)


def _on_one_axis(first: Piece, second: Piece) -> bool:
    if second.span > 0.2 or first.high < second.low - 0.02 or second.high < first.low - 0.02:
        return False
    l1, t1, r1, b1 = first.box
    l2, t2, r2, b2 = second.box
    offset = abs((l1 + r1) - (l2 + r2)) / 2
    if offset > 0.3 * max(r1 - l1, r2 - l2) + 1 or t1 > b2 + 1 or t2 > b1 + 1:
        return False
    return float(np.linalg.norm(first.middle - second.middle)) < 0.04 + second.pixel


def _distance_to_fixed(floor_map: FloorMap) -> NDArray[np.float64]:
    """Of every cell of the map to the next wall or piece of furniture, m."""
    free = (~floor_map.occupied).astype(np.uint8)
    cells: NDArray[np.float64] = cv2.distanceTransform(free, cv2.DIST_L2, 3).astype(np.float64)
    return cells * floor_map.resolution


def _on_a_table(floor_map: FloorMap, x: float, y: float, surface: float) -> bool:
    """Whether the map knows a surface of this height there."""
    return any(
        furniture.holds(x, y, margin=-_FIXED_NEAR) and abs(furniture.height - surface) < 0.03
        for furniture in floor_map.furniture
    )


def _clearance(floor_map: FloorMap, distance: NDArray[np.float64], x: float, y: float) -> float:
    column = math.floor((x - floor_map.origin[0]) / floor_map.resolution)
    row = math.floor((y - floor_map.origin[1]) / floor_map.resolution)
    rows, columns = distance.shape
    return float(distance[row, column]) if 0 <= row < rows and 0 <= column < columns else 0.0
