"""Names for colours, from pixels: hue tells chromatic colours apart, brightness the rest.

Shading scales red, green and blue alike, so that hue and saturation hardly change from one side of a thing to the
other; brightness does. White, grey and black are therefore judged by a thing's well-lit pixels.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.perception.sighting import Colour

Hsv = NDArray[np.float32]
"""Hue in degrees, saturation and brightness in 0…1, along the last axis."""

CHROMATIC: Final = 0.33
"""Saturation from which a pixel has a colour; wood and linen have less than toys, and paint more."""
DARK: Final = 0.13
"""Brightness below which hue is noise."""

_HUES: Final[tuple[tuple[float, Colour], ...]] = (
    (14, "red"), (36, "orange"), (70, "yellow"), (170, "green"), (242, "blue"), (320, "purple"), (361, "red"),
)  # fmt: skip
"""Upper ends of the hues, degrees."""
_LIT: Final = 80  # percentile of brightness that stands for the lit part of a side
_WHITE_ABOVE, _WHITE_ASIDE, _BLACK = 0.70, 0.59, 0.28
"""Lit brightness that parts white from grey, on upper sides, which the light falls on, and on upright ones; and grey
from black. A grey of 0.58 reaches 0.64 above and 0.53 aside, a white has at least 0.80 and 0.64."""


def to_hsv(rgb: NDArray[np.uint8]) -> Hsv:
    """Of a picture, shape (height, width, 3)."""
    import cv2  # slow to import, and not every program that knows colours has pictures

    return np.asarray(cv2.cvtColor(rgb.astype(np.float32) / 255, cv2.COLOR_RGB2HSV), dtype=np.float32)


def hue_name(hue: float) -> Colour:
    """The name of a hue, degrees."""
    return next(name for end, name in _HUES if hue % 360 < end)


def colour_name(pixels: Hsv, above: NDArray[np.bool_]) -> Colour:
    """The colour of most of these pixels, shape (n, 3); ``above`` tells which of them look upwards."""
    hue, saturation, value = pixels.T
    chromatic = (saturation > CHROMATIC) & (value > DARK)
    if np.count_nonzero(chromatic) >= 0.5 * len(pixels):
        # Hues are a circle: reds lie on both sides of 0.
        angle = np.deg2rad(hue[chromatic])
        return hue_name(float(np.rad2deg(np.arctan2(np.median(np.sin(angle)), np.median(np.cos(angle)))) % 360))
    aside = np.count_nonzero(~above) >= max(3, 0.2 * len(pixels))
    lit = float(np.percentile(value[~above] if aside else value, _LIT))
    return "white" if lit > (_WHITE_ASIDE if aside else _WHITE_ABOVE) else "black" if lit < _BLACK else "grey"
