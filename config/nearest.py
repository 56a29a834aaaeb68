"""The known name that was probably meant by one that is not known: of a setting, a place, a skill, a model, a command.

Everything that reads names asks here, so that the same slip of the finger is understood everywhere. A name is near when
it is alike as a whole, or when it begins alike and only few characters are wrong. The second counts for short names, of
which one character is a large part: half of a Chinese name of two.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Final

SIMILAR: Final = 0.6
"""How alike two names have to be, 0 to 1, as ``difflib`` counts it."""
_LONGEST: Final = 100
"""Characters of a name that are compared."""
_SHORT: Final = 8
"""Characters of a name of which one is a large part."""


def nearest(word: str, known: Iterable[str], cutoff: float = SIMILAR) -> str:
    """The one of ``known`` that is most like ``word``, letter case aside; empty where none is like it."""
    plain, folded = word.casefold()[:_LONGEST], {name.casefold(): name for name in known}
    if close := difflib.get_close_matches(plain, folded, n=1, cutoff=cutoff):
        return folded[close[0]]
    begin_alike = [name for name in folded if plain and name.startswith(plain[0]) and len(name) <= _SHORT]
    slips = {name: count for name in begin_alike if (count := _slips(plain, name)) <= _allowed(plain, name)}
    fewest = [name for name, count in slips.items() if count == min(slips.values())]
    return folded[fewest[0]] if len(fewest) == 1 else ""  # of several, none is meant more than another


def _allowed(word: str, name: str) -> int:
    """How many characters may be wrong."""
    longer = max(len(word), len(name))
    return 0 if longer < 2 or (longer < 3 and name.isascii()) else 1 if longer < 6 else 2


def _slips(word: str, name: str) -> int:
    """How many characters are wrong, missing or too many (Levenshtein)."""
    row = list(range(len(name) + 1))
    for done, said in enumerate(word, 1):
        before, row[0] = row[0], done
        for at, meant in enumerate(name, 1):
            before, row[at] = row[at], min(before + (said != meant), row[at] + 1, row[at - 1] + 1)
    return row[-1]


def did_you_mean(word: str, known: Iterable[str], cutoff: float = SIMILAR) -> str:
    """The question for the nearest name, as a sentence; empty where none is near."""
    near = nearest(word, known, cutoff)
    return f"Did you mean {near}?" if near else ""
