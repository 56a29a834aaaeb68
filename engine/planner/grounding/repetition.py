"""Whether an action comes more often in a plan than anybody said."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import Final

from engine.plan import Action
from engine.planner.grounding.grounds import Grounds

_TIMES: Final = {"again": 2, "both": 2, "square": 4, "rectangle": 4, "two": 2, "再": 2, "又": 2, "正方形": 4}
_UNCOUNTED: Final = frozenset(
    {"navigation", "seewhat", "locate", "scan_room", "place_in_bin", "place_object", "putdown"}
)
"""What may come again without being said again: each thing that is fetched has its own."""


def too_often(grounds: Grounds, actions: Sequence[Action]) -> int | None:
    """The index of the first action that comes more often than was said."""
    counts: Counter[str] = Counter()
    most = _most_repeats(grounds)
    for index, action in enumerate(actions):
        if action.name in _UNCOUNTED:
            continue
        counts[str(action)] += 1
        if counts[str(action)] > most:
            return index
    return None


def _most_repeats(grounds: Grounds) -> float:
    """How often the same action may come: as often as all numbers together say, or once in each clause."""
    if grounds.asks_for_everywhere() or grounds.asks_for_whatever():
        return math.inf
    said = [abs(value) for statement in grounds.said for value, unit in statement.quantities if unit == "times"]
    said += [abs(value) for statement in grounds.said for value in statement.numbers]
    said += [times for statement in grounds.said for word, times in _TIMES.items() if word in statement.text]
    clauses = sum(statement.clauses for statement in grounds.said)
    return max(clauses, sum(said) + clauses - len(grounds.said))
