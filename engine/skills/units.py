"""Units that arguments may be written in, and their conversion to the unit a parameter has."""

from __future__ import annotations

import math
from typing import Literal

from engine.errors import PlanError
from engine.plan import Quantity

Unit = Literal["m", "deg", "s", "m/s", "rad/s", ""]

_FACTORS: dict[Unit, dict[str, float]] = {
    "m": {"m": 1, "cm": 0.01, "mm": 0.001, "km": 1000, "ft": 0.3048, "in": 0.0254, "米": 1, "厘米": 0.01},
    "deg": {"deg": 1, "°": 1, "rad": 180 / math.pi, "turn": 360, "度": 1},
    "s": {"s": 1, "ms": 0.001, "min": 60, "h": 3600, "秒": 1, "分钟": 60},
    "m/s": {"m/s": 1, "cm/s": 0.01, "km/h": 1 / 3.6},
    "rad/s": {"rad/s": 1, "deg/s": math.pi / 180, "°/s": math.pi / 180},
    "": {},
}
_SPELLINGS = {
    "metre": "m", "metres": "m", "meter": "m", "meters": "m",
    "centimetre": "cm", "centimetres": "cm", "centimeter": "cm", "centimeters": "cm",
    "degree": "deg", "degrees": "deg", "degs": "deg", "radian": "rad", "radians": "rad", "turns": "turn",
    "sec": "s", "secs": "s", "second": "s", "seconds": "s", "minute": "min", "minutes": "min",
    "mps": "m/s", "m/sec": "m/s", "rad/sec": "rad/s", "degrees/s": "deg/s",
}  # fmt: skip


def convert(quantity: Quantity, unit: Unit, parameter: str) -> float:
    """``quantity`` in ``unit``; a bare number is in ``unit`` already. Raises :class:`PlanError` for another kind."""
    if not quantity.unit:
        return quantity.value
    written = quantity.unit.casefold()
    factor = _FACTORS[unit].get(_SPELLINGS.get(written, written))
    if factor is None:
        wanted = f"is in {unit}" if unit else "has no unit"
        raise PlanError(f"{parameter} {wanted}; {quantity.value:g} {quantity.unit} cannot be converted to it.")
    return quantity.value * factor
