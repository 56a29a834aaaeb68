"""Keys and what they do, on little room. A hint is a sentence with actions in braces, as ``{map} points``; it is shown
with their keys, where these act now, and left out where none of them does.

What does not fit is left out as a whole, and nothing is cut in two. The last one stays in any case and where it is: it
is the one that stops the robot, or leaves the page.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from string import Formatter
from typing import Final

from rich.cells import cell_len

JOINT: Final = " · "
Acting = Callable[[str], str | None]
"""The key of an action, as people read it, where it acts now; None: it is text there, does nothing, or has none."""
EDGES: Final = 6
"""Columns of a frame that are not there for the words in it: its corners, a line, and a blank on either side."""
_BOUNDLESS: Final = 10_000


def hint_line(hints: str, acting: Acting, columns: int = _BOUNDLESS, last: int = 1, **values: object) -> str:
    """Of these hints, parted by `` · ``, those whose keys act now, as many as so many columns have room for: first of
    all those among the ``last`` ones, then the others from the first on. ``values`` stand for what is no action."""
    return _fitted([_part(part, acting, values) for part in hints.split(JOINT)], columns, last)


def fitting(words: str, columns: int, last: int = 1) -> str:
    """As :func:`hint_line`, of words that name no keys."""
    return _fitted(words.split(JOINT), columns, last)


def _fitted(parts: Sequence[str], columns: int, last: int) -> str:
    """As many as there is room for; empty ones are none."""
    order = [*range(len(parts) - 1, len(parts) - 1 - last, -1), *range(len(parts) - last)]
    kept: set[int] = set()
    for number in order:
        if not parts[number]:
            continue
        wanted = JOINT.join(part for at, part in enumerate(parts) if at in kept or at == number)
        if kept and cell_len(wanted) > columns:
            break
        kept.add(number)
    return JOINT.join(part for at, part in enumerate(parts) if at in kept)


def sentence(words: str, acting: Acting, **values: object) -> str:
    """These words with the keys of the actions in them; empty where one of these does not act now."""
    keys = {action: acting(action) for action in _actions(words, frozenset(values))}
    return "" if None in keys.values() else words.format(**keys, **values)


def _part(words: str, acting: Acting, values: Mapping[str, object]) -> str:
    """One hint, with those of its keys that act; empty where it has keys and none does."""
    keys = {action: acting(action) or "" for action in _actions(words, frozenset(values))}
    if keys and not any(keys.values()):
        return ""
    told = words.format(**keys, **values)
    return told if all(keys.values()) else " ".join(told.split())  # without the gap where a key is left out


@lru_cache(maxsize=256)
def _actions(words: str, values: frozenset[str]) -> tuple[str, ...]:
    """The actions that are named in a hint."""
    return tuple(name for _, name, _, _ in Formatter().parse(words) if name and name not in values)
