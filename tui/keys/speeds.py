"""How fast one drives by hand, in the console and without it."""

from __future__ import annotations

from typing import Final

SPEEDS: Final = (0.1, 0.2, 0.3, 0.5, 0.7)
"""m/s to choose from; the safety envelope and the robot's own limits may allow less."""
TURN: Final = 2.5
"""rad/s of turning for each m/s of the speed that is chosen."""
