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


_BASE: Final = frozenset({"move_forward", "move_sideways", "move_left", "move_right", "set_cmdvel", "drift"})
"""What goes on and on where a model has lost its way: each time has to be said."""


def too_often(grounds: Grounds, actions: Sequence[Action]) -> int | None:
    """The index of the first action that comes more often than was said."""
    counts: Counter[str] = Counter()
    for index, action in enumerate(actions):
        if action.name in _UNCOUNTED:
            continue
        counts[str(action)] += 1
        if counts[str(action)] > _most_repeats(grounds, action):
            return index
    return None


def _most_repeats(grounds: Grounds, action: Action) -> float:
    """How often it may come: as often as all numbers together say that are not its own, or once in each clause."""
    if action.name not in _BASE and (grounds.asks_for_everywhere() or grounds.asks_for_whatever()):
        return math.inf
    own = [abs(value) for value in action.args.values() if isinstance(value, (int, float))]
    said = [abs(value) for statement in grounds.said for value, unit in statement.quantities if unit == "times"]
    bare = [abs(value) for statement in grounds.said for value in statement.numbers]
    said += [value for value in bare if not any(math.isclose(value, size, rel_tol=0.02) for size in own)]
    said += [times for statement in grounds.said for word, times in _TIMES.items() if word in statement.text]
    clauses = sum(statement.clauses for statement in grounds.said)
    return max(clauses, sum(said) + clauses - len(grounds.said))
