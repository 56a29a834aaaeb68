"""What somebody wears: the colours of their shirt and trousers, and what of them is neither.

A colour is told only where enough pixels of it show. Skin and brown hair have hues of their own, and are less vivid
than dyed cloth of these hues.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.perception.colours import Hsv, colour_name
from engine.perception.sighting import Colour

_FEWEST: Final = 12  # pixels that tell a colour
_SKIN: Final = ((5, 45), (0.2, 0.65))  # degrees of hue, and saturation, of skin and of hair that is not black
_DARK: Final = 0.25  # brightness of shoes at most


def colour(hsv: Hsv) -> Colour | None:
    """Of the pixels of one piece; None of too few."""
    return colour_name(hsv, np.zeros(len(hsv), dtype=np.bool_)) if len(hsv) >= _FEWEST else None


def is_skin(hsv: Hsv) -> NDArray[np.bool_]:
    """Or brown hair."""
    hue, saturation, _ = hsv.T
    (reddest, yellowest), (palest, strongest) = _SKIN
    return np.asarray((hue > reddest) & (hue < yellowest) & (saturation > palest) & (saturation < strongest))


def is_dark(hsv: Hsv) -> NDArray[np.bool_]:
    """As shoes are, and neither skin nor brown hair."""
    return np.asarray(~is_skin(hsv) & (hsv[:, 2] < _DARK))


def looks_like_a_head(hsv: Hsv) -> float:
    """How much of one end of somebody is skin and hair, less what is as dark as shoes: from -1 to 1."""
    return float(np.mean(is_skin(hsv)) - np.mean(is_dark(hsv))) if len(hsv) else 0.0
