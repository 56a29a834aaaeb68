"""What only tells something: "Dad went to the kitchen". A model would take it for an order, because it names one."""

from __future__ import annotations

import re
from typing import Final

from engine.planner.readings.consequences import POLITE, VERBS

_CLAUSE: Final = re.compile(r"[,.;:!?]+\s*|\b(?:and|but|so|then|because)\b\s*", re.IGNORECASE)
_ORDERS: Final = re.compile(
    rf"{POLITE}(?:{VERBS})\b|.*\b(?:(?:can|could|would|will|won't|might) you|please|let's|time (?:to|for)|"
    r"you(?:'d| had)? (?:can|could|should|must|may|better|have to|need to|ought to|get to)|"
    r"(?:want|need|like) (?:you|the|my|a|an|some))\b",
    re.IGNORECASE,
)
_PAST: Final = re.compile(
    r"(?:\w+'?\w* ){1,5}?(?!(?:need|speed|indeed|exceed|proceed|instead|hundred)\b)(?:[a-z]{2,}ed|went|came|"
    r"drove|took|brought|put|got|saw|heard|was|were|had|did|gave|made|found|left|threw|held|ran|thought|knew|told|said|"
    r"fell|broke|kept|stood|sat|sang|wrote|read|has been|have been)\b",
    re.IGNORECASE,
)


def only_tells(text: str) -> bool:
    """Whether ``text`` tells of what was, and no clause of it is an order."""
    clauses = [clause for clause in _CLAUSE.split(text.replace("’", "'")) if clause]
    return not any(map(_ORDERS.match, clauses)) and any(map(_PAST.match, clauses))
