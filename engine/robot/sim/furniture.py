"""What each kind of furniture is made of: plain boxes, cylinders and ellipsoids around its own centre on the floor.

Everything the robot could run into shows itself in the plane of the lidar (0.10 m above the floor): legs are at
least 4 cm wide and closed fronts reach down to 5 cm. Overhanging tops are either above the robot or closed below.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

from engine.robot.sim.scene_parts import FurniturePiece

FLAT = frozenset({"rug"})
"""Kinds that lie on the floor and can be driven over."""


@dataclass(frozen=True, slots=True)
class Solid:
    """One primitive; centre and half sizes in the frame of the piece, m. A cylinder stands upright: its half sizes
    are radius, radius, half height."""

    centre: tuple[float, float, float]
    half: tuple[float, float, float]
    colour: str
    shade: float = 1.0
    shape: Literal["box", "cylinder", "ellipsoid"] = "box"


def solids(piece: FurniturePiece) -> tuple[Solid, ...]:
    """The primitives of a piece before it is turned and placed."""
    return tuple(_BUILDERS[piece.kind](piece))


def parts_of(piece: FurniturePiece) -> Iterator[tuple[float, float, float, float, float]]:
    """What a piece covers where the map has it, part by part: x_min, y_min, x_max, y_max, map frame, and the top, m."""
    turn = math.radians(piece.turn)
    c, s = round(math.cos(turn)), round(math.sin(turn))
    for solid in solids(piece):
        (x, y, z), (half_x, half_y, half_z) = solid.centre, solid.half
        at_x, at_y = piece.at[0] + c * x - s * y, piece.at[1] + s * x + c * y
        out_x, out_y = abs(c) * half_x + abs(s) * half_y, abs(s) * half_x + abs(c) * half_y
        yield at_x - out_x, at_y - out_y, at_x + out_x, at_y + out_y, z + half_z


def _slab(
    piece: FurniturePiece,
    x: tuple[float, float],
    y: tuple[float, float],
    z: tuple[float, float],
    colour: str | None = None,
    shade: float = 1.0,
) -> Solid:
    """A box given by its extent, x and y as fractions −1…1 of the piece's half size, z in m."""
    length, depth, _ = piece.size
    return Solid(
        ((x[0] + x[1]) * length / 4, (y[0] + y[1]) * depth / 4, (z[0] + z[1]) / 2),
        ((x[1] - x[0]) * length / 4, (y[1] - y[0]) * depth / 4, (z[1] - z[0]) / 2),
        colour or piece.colour,
        shade,
    )


def _legs(piece: FurniturePiece, top: float, wide: float = 0.05) -> list[Solid]:
    length, depth, _ = piece.size
    half = wide / 2
    return [
        Solid(
            (sx * (length / 2 - half), sy * (depth / 2 - half), top / 2), (half, half, top / 2), piece.colour, shade=0.8
        )
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]


def _table(piece: FurniturePiece) -> list[Solid]:
    top = piece.size[2]
    return [_slab(piece, (-1, 1), (-1, 1), (top - 0.03, top)), *_legs(piece, top - 0.03, 0.06)]


def _low_table(piece: FurniturePiece) -> list[Solid]:
    """A chest-like table whose closed sides reach down to the floor, so that the lidar sees its edge."""
    top = piece.size[2]
    return [
        _slab(piece, (-1, 1), (-1, 1), (top - 0.02, top)),
        _slab(piece, (-0.98, 0.98), (-0.98, 0.98), (0.0, top - 0.02), shade=0.75),
    ]


def _seat(piece: FurniturePiece, cushions: int) -> list[Solid]:
    """Sofa and armchair: base, back, two arms, cushions."""
    length, depth, height = piece.size
    arm, back = 0.14, 0.18
    x0 = 1 - 2 * arm / length
    y1 = 1 - 2 * back / depth
    parts = [
        _slab(piece, (-1, 1), (-1, 1), (0.03, 0.26), shade=0.85),
        _slab(piece, (-x0, x0), (y1, 1), (0.26, height)),
        _slab(piece, (-1, -x0), (-1, 1), (0.26, 0.72 * height)),
        _slab(piece, (x0, 1), (-1, 1), (0.26, 0.72 * height)),
    ]
    for i in range(cushions):
        left, right = (-x0 + 2 * x0 * (i + j) / cushions for j in (0.03, 0.97))
        parts.append(_slab(piece, (left, right), (-0.96, y1), (0.26, 0.38), shade=1.12))
        parts.append(_slab(piece, (left, right), (y1 - 0.22, y1), (0.38, height - 0.06), piece.accent))
    return parts


def _sofa(piece: FurniturePiece) -> list[Solid]:
    return _seat(piece, cushions=max(2, round(piece.size[0] / 0.75)))


def _armchair(piece: FurniturePiece) -> list[Solid]:
    return _seat(piece, cushions=1)


def _chair(piece: FurniturePiece) -> list[Solid]:
    height = piece.size[2]
    return [
        _slab(piece, (-1, 1), (-1, 1), (0.43, 0.46)),
        _slab(piece, (-1, 1), (0.86, 1), (0.46, height)),
        *_legs(piece, 0.43, 0.045),
    ]


def _bed(piece: FurniturePiece) -> list[Solid]:
    height = piece.size[2]
    return [
        _slab(piece, (-1, 1), (-1, 1), (0.03, 0.24)),
        _slab(piece, (-1, 1), (0.96, 1), (0.24, height)),
        _slab(piece, (-0.96, 0.96), (-0.97, 0.95), (0.24, 0.42), "white"),
        _slab(piece, (-0.99, 0.99), (-0.98, 0.3), (0.30, 0.45), piece.accent),
        _slab(piece, (-0.99, 0.99), (0.3, 0.42), (0.30, 0.46), piece.accent, 1.2),
        _slab(piece, (-0.84, -0.08), (0.52, 0.9), (0.42, 0.53), "white", 0.97),
        _slab(piece, (0.08, 0.84), (0.52, 0.9), (0.42, 0.53), "white", 0.97),
    ]


def _wardrobe(piece: FurniturePiece) -> list[Solid]:
    height = piece.size[2]
    return [
        _slab(piece, (-1, 1), (-0.92, 1), (0.0, height)),
        _slab(piece, (-0.98, -0.01), (-1, -0.92), (0.05, height - 0.03), shade=1.08),
        _slab(piece, (0.01, 0.98), (-1, -0.92), (0.05, height - 0.03), shade=1.08),
        _slab(piece, (-0.12, -0.07), (-1, -0.985), (0.45 * height, 0.6 * height), "steel"),
        _slab(piece, (0.07, 0.12), (-1, -0.985), (0.45 * height, 0.6 * height), "steel"),
    ]


_BOOKS = ("red", "petrol", "linen", "sage", "terracotta", "slate", "yellow", "green")


def _shelf(piece: FurniturePiece) -> list[Solid]:
    """Closed plinth, sides and back; boards every 0.32 m with books on all but the lowest."""
    length, _, height = piece.size
    side = 0.05 / length
    parts = [
        _slab(piece, (-1, 1), (-1, 1), (0.0, 0.14)),
        _slab(piece, (-1, -1 + side), (-1, 1), (0.14, height)),
        _slab(piece, (1 - side, 1), (-1, 1), (0.14, height)),
        _slab(piece, (-1, 1), (0.9, 1), (0.14, height), shade=0.8),
        _slab(piece, (-1, 1), (-1, 1), (height - 0.025, height)),
    ]
    level, count = 0.14 + 0.32, 0
    while level < height - 0.2:
        parts.append(_slab(piece, (-1, 1), (-1, 0.9), (level, level + 0.025)))
        at = -1 + side + 0.02
        while at < 0.6 - 0.25 * (count % 3):
            thick = 0.04 + 0.025 * ((count * 7) % 3)
            tall = 0.17 + 0.03 * ((count * 5) % 4)
            colour = _BOOKS[count % len(_BOOKS)]
            parts.append(
                _slab(piece, (at, at + 2 * thick / length), (-0.6, 0.85), (level + 0.025, level + tall), colour)
            )
            at += 2 * thick / length + 0.004
            count += 1
        count += 1
        level += 0.32
    return parts


def _desk(piece: FurniturePiece) -> list[Solid]:
    """A desk with a drawer block on the right and a screen."""
    top = piece.size[2]
    return [
        _slab(piece, (-1, 1), (-1, 1), (top - 0.03, top)),
        _slab(piece, (-0.98, -0.9), (-0.95, 0.95), (0.0, top - 0.03), shade=0.8),
        _slab(piece, (0.42, 0.98), (-0.9, 0.95), (0.0, top - 0.03), "white"),
        _slab(piece, (-0.35, 0.35), (0.5, 0.56), (top + 0.1, top + 0.45), "black"),
        _slab(piece, (-0.05, 0.05), (0.55, 0.65), (top, top + 0.2), "steel"),
        _slab(piece, (-0.25, 0.25), (-0.5, -0.15), (top, top + 0.02), "grey"),
    ]


def _counter(piece: FurniturePiece) -> list[Solid]:
    """A kitchen counter: cupboards every 0.6 m, a worktop, a sink and a hob."""
    length, _, top = piece.size
    parts = [
        _slab(piece, (-1, 1), (-0.94, 1), (0.0, top - 0.04), "white", 0.9),
        _slab(piece, (-1, 1), (-1, 1), (top - 0.04, top)),
        _slab(piece, (0.3, 0.62), (-0.6, 0.6), (top - 0.001, top + 0.004), "steel", 0.8),
        _slab(piece, (0.44, 0.48), (0.6, 0.68), (top, top + 0.25), "steel"),
        _slab(piece, (-0.7, -0.3), (-0.7, 0.7), (top - 0.001, top + 0.004), "black"),
    ]
    doors = max(1, round(length / 0.6))
    for i in range(doors):
        left, right = (-1 + 2 * (i + j) / doors for j in (0.03, 0.97))
        parts.append(_slab(piece, (left, right), (-1, -0.94), (0.05, top - 0.06), piece.accent))
    return parts


def _bin(piece: FurniturePiece) -> list[Solid]:
    """Open at the top, so that things can be put in."""
    height = piece.size[2]
    wall = 0.1
    return [
        _slab(piece, (-1, 1), (-1, 1), (0.0, 0.01), shade=0.6),
        _slab(piece, (-1, 1), (-1, -1 + wall), (0.01, height)),
        _slab(piece, (-1, 1), (1 - wall, 1), (0.01, height)),
        _slab(piece, (-1, -1 + wall), (-1 + wall, 1 - wall), (0.01, height), shade=0.92),
        _slab(piece, (1 - wall, 1), (-1 + wall, 1 - wall), (0.01, height), shade=0.92),
    ]


def _dock(piece: FurniturePiece) -> list[Solid]:
    height = piece.size[2]
    return [
        _slab(piece, (-1, 1), (-1, 1), (0.0, height)),
        _slab(piece, (-0.5, -0.2), (-1.04, -1), (0.06, 0.09), "yellow"),
        _slab(piece, (0.2, 0.5), (-1.04, -1), (0.06, 0.09), "yellow"),
        _slab(piece, (-0.08, 0.08), (-1.04, -1), (0.7 * height, 0.8 * height), "green"),
    ]


def _plant(piece: FurniturePiece) -> list[Solid]:
    length, _, height = piece.size
    radius = length / 2
    crown = (height - 0.25) / 2
    return [
        Solid((0, 0, 0.13), (radius * 0.85, radius * 0.85, 0.13), piece.colour, shape="cylinder"),
        Solid((0, 0, 0.265), (radius * 0.75, radius * 0.75, 0.006), "walnut", 0.6, "cylinder"),
        Solid((0, 0, 0.3 + crown), (radius, radius, crown), "leaf", shape="ellipsoid"),
        Solid((0.05, -0.06, 0.42 + crown), (radius * 0.7, radius * 0.7, crown * 0.7), "leaf", 1.15, "ellipsoid"),
    ]


def _carton(piece: FurniturePiece) -> list[Solid]:
    height = piece.size[2]
    return [
        _slab(piece, (-1, 1), (-1, 1), (0.0, height)),
        _slab(piece, (-1.002, 1.002), (-0.12, 0.12), (0.6 * height, height + 0.001), "linen"),
    ]


def _rug(piece: FurniturePiece) -> list[Solid]:
    return [
        _slab(piece, (-1, 1), (-1, 1), (0.0, 0.003)),
        _slab(piece, (-0.92, 0.92), (-0.9, 0.9), (0.0, 0.0035), piece.accent),
        _slab(piece, (-0.86, 0.86), (-0.82, 0.82), (0.0, 0.004), shade=1.08),
    ]


_BUILDERS: dict[str, Callable[[FurniturePiece], list[Solid]]] = {
    "table": _table,
    "low_table": _low_table,
    "sofa": _sofa,
    "armchair": _armchair,
    "chair": _chair,
    "bed": _bed,
    "wardrobe": _wardrobe,
    "shelf": _shelf,
    "desk": _desk,
    "counter": _counter,
    "bin": _bin,
    "dock": _dock,
    "plant": _plant,
    "carton": _carton,
    "rug": _rug,
}
