"""The known name that was probably meant by one that is not known: of a setting, a place, a skill, a model, a command.

Everything that reads names asks here, so that the same slip of the finger is understood everywhere.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Final

SIMILAR: Final = 0.6
"""How alike two names have to be, 0 to 1, as ``difflib`` counts it."""
_LONGEST: Final = 100
"""Characters of a name that are compared."""


def nearest(word: str, known: Iterable[str], cutoff: float = SIMILAR) -> str:
    """The one of ``known`` that is most like ``word``, letter case aside; empty where none is like it."""
    folded = {name.casefold(): name for name in known}
    close = difflib.get_close_matches(word.casefold()[:_LONGEST], folded, n=1, cutoff=cutoff)
    return folded[close[0]] if close else ""


def did_you_mean(word: str, known: Iterable[str], cutoff: float = SIMILAR) -> str:
    """The question for the nearest name, as a sentence; empty where none is near."""
    near = nearest(word, known, cutoff)
    return f"Did you mean {near}?" if near else ""
