"""What stands in a picture, taken apart: pieces that depth and colour hold together, and what surrounds each.

Two neighbouring pixels belong together when their points are close in space and their colours alike. A piece knows how
its sides end: against something farther away (its own outline), against something nearer that hides the rest, or at
the picture's edge. A piece that carries a table top is the table.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.perception.colours import CHROMATIC, DARK, Hsv
from engine.perception.sighting import PixelBox
from engine.perception.surfaces import NO_SURFACE, Field, Mask, Relief

FEWEST: Final = 2
"""Pixels that a piece has at least; far bottles fall into small ones."""
_GAP: Final = 0.018  # m between neighbouring pixels of one thing, and one and a half pixels more
_HUE: Final = 22.0  # degrees between neighbouring pixels of one colour
_PALE: Final = 0.2  # saturation below which a pixel is white, grey or black for certain


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What lies around a piece in the picture."""

    hidden: float  # fraction of the outline, above and at the sides, that ends at something nearer
    foot_hidden: bool  # most of its lower end lies behind something nearer
    under: tuple[int, ...]  # labels of the surfaces right below, the commonest first
    carries: float  # fraction of the columns in which a table top lies right on it


@dataclass(frozen=True, eq=False)  # without slots, for what is reckoned once: pieces are compared in pairs
class Piece:
    """Pixels that belong together. ``n`` is their number."""

    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    points: NDArray[np.float64]  # base frame, m, shape (n, 3)
    hsv: Hsv  # shape (n, 3)
    pixel: float  # m that a pixel covers there
    cut: frozenset[str]  # edges of the picture that it touches: left, right, top, bottom
    look_around: Callable[[], Surroundings]  # takes time, and of most pieces the size says enough

    @property
    def n(self) -> int:
        return len(self.rows)

    @cached_property
    def around(self) -> Surroundings:
        return self.look_around()

    @cached_property
    def box(self) -> PixelBox:
        left, right = self.columns.min(), self.columns.max() + 1
        return int(left), int(self.rows.min()), int(right), int(self.rows.max()) + 1

    @cached_property
    def low(self) -> float:
        return float(self.points[:, 2].min())

    @cached_property
    def high(self) -> float:
        return float(self.points[:, 2].max())

    @cached_property
    def span(self) -> float:
        """Diagonal of the rectangle around it on the floor, m."""
        return _span(self.points)

    @cached_property
    def coloured(self) -> bool:
        """Whether a good part of it has a colour."""
        return bool(np.count_nonzero(self.hsv[:, 1] > CHROMATIC) >= 0.3 * self.n)

    @cached_property
    def middle(self) -> NDArray[np.float64]:
        """Mean of its points on the floor, base frame, m."""
        middle: NDArray[np.float64] = self.points[:, :2].mean(axis=0)
        return middle

    def joined(self, other: Piece) -> Piece:
        """Both as one; their common border no longer hides anything."""
        more = max(self, other, key=lambda piece: piece.n)
        lower = min(self, other, key=lambda piece: piece.low)

        def look_around() -> Surroundings:
            return replace(lower.around, hidden=more.around.hidden)

        return Piece(
            np.concatenate((self.rows, other.rows)),
            np.concatenate((self.columns, other.columns)),
            np.concatenate((self.points, other.points)),
            np.concatenate((self.hsv, other.hsv)),
            more.pixel,
            self.cut | other.cut,
            look_around,
        )


def take_apart(relief: Relief, hsv: Hsv, widest: float = math.inf) -> list[Piece]:
    """All pieces of what stands, whatever they are, that span less than ``widest`` m on the floor."""
    points, standing = relief.points, relief.standing
    if not standing.any():
        return []
    beside = standing[:, :-1] & standing[:, 1:]
    above = standing[:-1] & standing[1:]
    with np.errstate(invalid="ignore"):
        beside &= _together(points[:, :-1], points[:, 1:], relief.pixel[:, 1:], hsv[:, :-1], hsv[:, 1:])
        above &= _together(points[:-1], points[1:], relief.pixel[1:], hsv[:-1], hsv[1:])
    labels, count = _components(standing, beside, above)
    order = np.argsort(labels, axis=None, kind="stable")
    ends = np.cumsum(np.bincount(labels.ravel(), minlength=count))
    found = []
    for label in range(1, count):
        if ends[label] - ends[label - 1] >= FEWEST:
            rows, columns = np.divmod(order[ends[label - 1] : ends[label]], labels.shape[1])
            points = relief.points[rows, columns]
            if _span(points) < widest:
                found.append(_piece(relief, hsv, points.astype(np.float64), rows, columns))
    return found


def _together(a: Field, b: Field, pixel: Field, first: Hsv, second: Hsv) -> Mask:
    x, y, z = (a[..., axis] - b[..., axis] for axis in range(3))
    close = x * x + y * y + z * z < (_GAP + 1.5 * pixel) ** 2
    strong_a, strong_b = _strong(first), _strong(second)
    pale_a, pale_b = first[..., 1] < _PALE, second[..., 1] < _PALE
    turn = np.abs((first[..., 0] - second[..., 0] + 180) % 360 - 180)
    apart = (strong_a & strong_b & (turn > _HUE)) | (strong_a & pale_b) | (pale_a & strong_b)
    alike: Mask = close & ~apart
    return alike


def _strong(pixels: Hsv) -> Mask:
    found: Mask = (pixels[..., 1] > CHROMATIC) & (pixels[..., 2] > DARK)
    return found


def _components(mask: Mask, beside: Mask, above: Mask) -> tuple[NDArray[np.int32], int]:
    """Connected components of a grid whose neighbours are joined only where ``beside`` and ``above`` say so: the joints
    become pixels of a picture of twice the size."""
    height, width = mask.shape
    grid = np.zeros((2 * height - 1, 2 * width - 1), dtype=np.uint8)
    grid[::2, ::2] = mask
    grid[::2, 1::2] = beside
    grid[1::2, ::2] = above
    count, labels = cv2.connectedComponents(grid, connectivity=4)
    return np.asarray(labels[::2, ::2], dtype=np.int32), count


def _span(points: NDArray[np.floating]) -> float:
    return float(np.hypot(*np.ptp(points[:, :2], axis=0)))


def _piece(
    relief: Relief,
    hsv: Hsv,
    points: NDArray[np.float64],
    rows: NDArray[np.intp],
    columns: NDArray[np.intp],
) -> Piece:
    height, width = relief.standing.shape
    pixel = float(np.median(relief.pixel[rows, columns]))
    edges = (
        ("left", columns.min() == 0),
        ("right", columns.max() == width - 1),
        ("top", rows.min() == 0),
        ("bottom", rows.max() == height - 1),
    )
    cut = frozenset(name for name, touches in edges if touches)
    look_around = partial(_surroundings, relief, rows, columns, _GAP + 2 * pixel)
    return Piece(rows, columns, points, hsv[rows, columns], pixel, cut, look_around)


def _surroundings(relief: Relief, rows: NDArray[np.intp], columns: NDArray[np.intp], gap: float) -> Surroundings:
    height, width = relief.standing.shape
    mask = np.zeros((height, width), dtype=np.bool_)
    mask[rows, columns] = True
    ends, hidden = [0, 0, 0, 0], [0, 0, 0, 0]
    for side, (down, right) in enumerate(((0, -1), (0, 1), (-1, 0), (1, 0))):
        r, c = rows + down, columns + right
        inside = (r >= 0) & (r < height) & (c >= 0) & (c < width)
        inside[inside] &= ~mask[r[inside], c[inside]]
        r, c = r[inside], c[inside]
        nearer = relief.range[r, c] < relief.range[rows[inside], columns[inside]] - gap
        ends[side], hidden[side] = len(r), int(np.count_nonzero(nearer))
    return Surroundings(
        sum(hidden[:3]) / max(sum(ends[:3]), 1),
        hidden[3] > 0.5 * ends[3],
        _under(relief, mask, rows, columns),
        _carries(relief, mask, rows, columns, gap),
    )


def _under(relief: Relief, mask: Mask, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> tuple[int, ...]:
    """The surfaces that the picture shows right below the piece: what it stands on or overhangs."""
    below = rows + 1
    inside = below < mask.shape[0]
    inside[inside] &= ~mask[below[inside], columns[inside]]
    labels = relief.surface[below[inside], columns[inside]]
    known = labels[labels != NO_SURFACE]
    counts = np.bincount(known) if len(known) else np.zeros(0, dtype=int)
    return tuple(int(label) for label in np.argsort(-counts) if counts[label])


def _carries(relief: Relief, mask: Mask, rows: NDArray[np.intp], columns: NDArray[np.intp], gap: float) -> float:
    above = rows - 1
    inside = above >= 0
    inside[inside] &= ~mask[above[inside], columns[inside]]
    r, c = above[inside], columns[inside]
    on_top = relief.surface[r, c] > 0
    close = np.linalg.norm(relief.points[r, c] - relief.points[rows[inside], columns[inside]], axis=1) < gap
    return np.count_nonzero(on_top & close) / max(len(np.unique(columns)), 1)
