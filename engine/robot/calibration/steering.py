"""By how much a robot turns on its way though it is told to drive straight, from drives ahead and back.

A drive back undoes the turn of the drive ahead, and what the gyroscope drifts by meanwhile has the same sign in both:
their difference holds the pull alone.
"""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Drive:
    """One drive, as odometry tells it."""

    ahead: float  # m by the encoders; negative: back
    turned: float  # rad by the board's attitude, counter-clockwise


@dataclass(frozen=True, slots=True)
class Pull:
    """What was measured."""

    mean: float  # rad counter-clockwise per metre ahead
    spread: float  # of the runs, rad/m; one standard deviation


def pull_of(runs: Sequence[tuple[Drive, Drive]]) -> Pull:
    """The pull by two or more runs, each a drive ahead and one back."""
    pulls = [(ahead.turned - back.turned) / (ahead.ahead - back.ahead) for ahead, back in runs]
    return Pull(statistics.mean(pulls), statistics.stdev(pulls))
