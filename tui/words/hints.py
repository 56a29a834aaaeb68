"""Keys and what they do, on little room: what does not fit is left out as a whole, and nothing is cut in two.

The last one stays in any case and where it is: it is the one that stops the robot, or leaves the page.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from rich.cells import cell_len

JOINT: Final = " · "
Acting = Callable[[str], str | None]
"""The key of an action, as people read it, where it acts now; None: it is text there, or has none."""
EDGES: Final = 6
"""Columns of a frame that are not there for the words in it: its corners, a line, and a blank on either side."""


def fitting(hints: str, columns: int, last: int = 1) -> str:
    """As many of these hints, parted by `` · ``, as so many columns have room for: first of all the ``last`` ones, then
    the others from the first on."""
    parts = hints.split(JOINT)
    order = [*range(len(parts) - 1, len(parts) - 1 - last, -1), *range(len(parts) - last)]
    kept: set[int] = set()
    for number in order:
        wanted = JOINT.join(part for at, part in enumerate(parts) if at in kept or at == number)
        if kept and cell_len(wanted) > columns:
            break
        kept.add(number)
    return JOINT.join(part for at, part in enumerate(parts) if at in kept)
