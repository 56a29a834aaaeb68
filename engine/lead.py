"""What is known to have been said right before a request: a wake word, which runs into it without a border."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Lead:
    """Its sound helps to understand what follows: a cut would hit one of both words."""

    text: str  # "hey jarvis"
    samples: NDArray[np.int16]  # shape (n,), mono, 16 kHz, up to where the request begins
