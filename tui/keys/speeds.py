"""How fast one drives by hand, in the console and without it, and how fast the robot may drive at all."""

from __future__ import annotations

from typing import Final

SPEEDS: Final = (0.1, 0.2, 0.3, 0.5, 0.7)
"""m/s to choose from; the safety envelope and the robot's own limits may allow less."""
LIMITS: Final = (0.25, 0.5, 0.75, 1.0)
"""Speed limits to choose from, as shares of what the safety envelope allows."""
TURN: Final = 2.5
"""rad/s of turning for each m/s of the speed that is chosen."""


def limit_beside(share: float, step: int) -> float:
    """The speed limit so many steps faster than this one."""
    at = min(range(len(LIMITS)), key=lambda number: abs(LIMITS[number] - share))
    return LIMITS[max(0, min(len(LIMITS) - 1, at + step))]
