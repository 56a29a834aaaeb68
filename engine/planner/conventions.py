"""What nobody has to say: how far a turn goes that was told without an angle, and how fast slow and fast are."""

from __future__ import annotations

from typing import Literal

Manner = Literal["slow", "fast"]

DRIVE_SPEED: dict[Manner | None, float] = {"slow": 0.1, None: 0.3, "fast": 0.5}
"""m/s. Slow and fast are those of the course example in which a robot backs away "slowly like a turtle"; the other is
the driving skills' own."""
TURN_SPEED: dict[Manner | None, float] = {"slow": 0.5, None: 1.0, "fast": 2.0}
"""rad/s; the middle one is the turning skills' own."""
A_BIT = 0.2
"""m, as in "back up a bit"."""
A_BIT_OF_A_TURN = 30.0
"""deg, as in "turn a little to the left"."""
QUARTER, HALF, FULL = 90.0, 180.0, 360.0
"""deg. "Turn left" is a quarter turn, "turn around" a half one."""
