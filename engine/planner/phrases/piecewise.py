"""Requests of several clauses of which phrases understand all but one or two: only those are for a small model.

A small model plans one step well, and forgets one of four. So the clauses are planned one after the other as if they
were turns of a conversation, and the model is told what came before. Only where the clauses stand for themselves: what
depends on another clause ("before you go …", "but only if …") is planned as a whole.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from typing import Final

from engine.planner.phrases.phrases import Matched

_HANGS: Final = re.compile(
    r"\b(?:if|unless|whether|before|after|until|till|while|whenever|when|once|except|instead|otherwise|else|but|both|"
    r"each|either|neither|or|respectively|same|order|back|rest|others?|not|never|no|don't|without)\b"
    r"|如果|要是|假如|的话|否则|之前|之后|以后|直到|除了|不要|别|都|各",
    re.IGNORECASE,
)
_NO_VERB: Final = re.compile(
    r"(?:the|a|an|my|your|our|his|her|their|it|them|that|this|these|those|to|in|on|at|from|with|of|for|by|as|than|"
    r"red|orange|yellow|green|blue|purple|white|gr[ea]y|black|\d\S*|i|you|he|she|we|they|there|here|so|also|too|some|"
    r"any|all|every\w*|\w+ly)\b|\W*$",
    re.IGNORECASE,
)
"""How the second half of a clause begins that was cut in two ("the cup and | the plate")."""
MOST_CLAUSES: Final = 6
MOST_UNKNOWN: Final = 2
"""A model takes a second or two for each."""


def is_piecewise(text: str, pieces: Sequence[tuple[str, Matched | None]], nouns: Collection[str]) -> bool:
    """Whether ``text`` may be planned clause by clause, with a model for one or two of them. ``pieces``: its clauses,
    with what phrases make of them; ``nouns``: names of the house, with which no clause begins."""
    unknown = [piece.casefold() for piece, match in pieces if match is None]
    if not 2 <= len(pieces) <= MOST_CLAUSES or not 1 <= len(unknown) <= MOST_UNKNOWN or _HANGS.search(text):
        return False
    return not any(_NO_VERB.match(piece) or piece.startswith(tuple(nouns)) for piece in unknown)
