"""A recording as a plot of its level over time, in characters: what ``sayso doctor --mic`` shows."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

from rich.text import Text

ROWS: Final = 8
TOP_DB: Final = 0.0
BOTTOM_DB: Final = -80.0
STEPS: Final = " ▁▂▃▄▅▆▇█"
_LABEL: Final = 7


def level_plot(levels: Sequence[float], voiced: Sequence[bool], noise_db: float, columns: int) -> Text:
    """Levels (dB relative to full scale) as bars, those with speech in green; a line marks the noise floor."""
    width = max(1, min(columns - _LABEL, len(levels)))
    bounds = [round(index * len(levels) / width) for index in range(width + 1)]
    bars = [max(levels[start:end]) for start, end in pairwise(bounds)]
    speech = [any(voiced[start:end]) for start, end in pairwise(bounds)]
    per_row = (TOP_DB - BOTTOM_DB) / ROWS
    floor_row = min(ROWS - 1, max(0, int((noise_db - BOTTOM_DB) / per_row)))
    plot = Text(no_wrap=True)
    for row in reversed(range(ROWS)):
        plot.append(f"{BOTTOM_DB + row * per_row:4.0f} │ ", style="dim")
        for level, spoken in zip(bars, speech, strict=True):
            filled = (level - BOTTOM_DB) / per_row - row
            step = STEPS[round(max(0.0, min(1.0, filled)) * (len(STEPS) - 1))]
            if step == " " and row == floor_row:
                plot.append("┄", style="dim")
            else:
                plot.append(step, style="green" if spoken else "blue")
        plot.append("\n")
    plot.append(f"{'dB':>4} └{'─' * (width + 1)}", style="dim")
    return plot
