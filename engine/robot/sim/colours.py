"""Colours by name, as they are written in scene files and spoken about: ``red``, ``oak``, ``#d8d2c4``.

The names of loose objects' colours are the words people use for them; the rest are materials of the furniture.
"""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator

PALETTE: dict[str, str] = {
    "red": "#d33a33",
    "green": "#3c9c4e",
    "blue": "#2f6fc4",
    "yellow": "#ecc02f",
    "orange": "#ea7d25",
    "purple": "#7d4fa8",
    "white": "#f3f1ea",
    "grey": "#8d9095",
    "black": "#26282b",
    "oak": "#c49a6c",
    "walnut": "#7b5438",
    "birch": "#dcc39a",
    "linen": "#d9d0c0",
    "sage": "#8fa58a",
    "slate": "#566270",
    "petrol": "#2f6672",
    "terracotta": "#bd6b4c",
    "cardboard": "#b98f5f",
    "steel": "#b4bac0",
    "leaf": "#4f8a4c",
}

_HEX = re.compile(r"#[0-9a-fA-F]{6}")


def _known(colour: str) -> str:
    if colour not in PALETTE and not _HEX.fullmatch(colour):
        raise ValueError(f"{colour!r} is no colour; write #rrggbb or one of {', '.join(PALETTE)}")
    return colour


Colour = Annotated[str, AfterValidator(_known)]
"""A name of the palette or ``#rrggbb``."""


def rgba(colour: str, *, shade: float = 1.0) -> tuple[float, float, float, float]:
    """Red, green, blue and alpha in 0…1; ``shade`` below 1 darkens, above 1 lightens."""
    text = PALETTE.get(colour, colour)
    red, green, blue = (min(1.0, int(text[i : i + 2], 16) / 255 * shade) for i in (1, 3, 5))
    return red, green, blue, 1.0
