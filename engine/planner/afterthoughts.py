"""What somebody goes on with after a request that was complete: "go to the kitchen", and a moment later "and wave".

By then the robot is on its way. What only adds to the request is done after it; what makes another one of it ("pick up
the cup" … "in the kitchen") is done in its place. No large model decides: whoever talks to somebody else must not be
drawn into a request, nor may what a recogniser makes of noise.
"""

from __future__ import annotations

from typing import Final, Protocol

from engine.asr.agreement import first_words, normalised_words
from engine.hearing.readings import Afterthought
from engine.plan import Plan
from engine.planner.accounted import times_corrected
from engine.planner.completeness import completeness
from engine.planner.not_an_order import what_counts
from engine.planner.phrases.joints import goes_on
from engine.planner.phrases.stopping import is_stop
from engine.planner.request import NoPlan

_FROM_HERE: Final = frozenset({"move_forward", "move_sideways", "move_left", "move_right"})
"""What leads elsewhere if it is begun anew."""


class Plain(Protocol):
    """What comes of a request by itself, or after another one; no large model is asked."""

    def __call__(self, text: str, before: str = "") -> Plan | NoPlan | None: ...


def afterthought(first: str, whole: str, plain: Plain) -> Afterthought | None:
    """What was said after the request ``first``, as far as it belongs to it; ``whole`` is both together."""
    words = normalised_words(first)
    if normalised_words(whole)[: len(words)] != words:
        return None
    rest = whole[len(first_words(whole, len(words))) :].lstrip(" ,.，。、；;")
    before, after = _actions(plain(first)), _actions(plain(whole))
    if not rest or not before or is_stop(rest):
        return None
    if what_counts(rest) == "":  # "never mind"
        return Afterthought(whole, adds=False)
    if completeness(whole, plain) == "incomplete":
        return None
    alone, after_it = plain(rest), plain(rest, first)
    added = _actions(after_it)
    if not after:
        asked = isinstance(alone, NoPlan) and alone.code == "unknown_place"  # which will be told
        thought = goes_on(rest) and len(normalised_words(rest)) > 2  # for a large model, if there is one
        return Afterthought(rest, adds=True, clear=False) if asked or thought else None
    if after == before or added == before:  # a word of thanks; or it was said once more
        return None
    if times_corrected(whole) > times_corrected(first):  # "no, to the bedroom"
        return Afterthought(whole, adds=False)
    if after == (*before, *added):
        return Afterthought(rest, adds=True)
    return None if any(action.partition("(")[0] in _FROM_HERE for action in before) else Afterthought(whole, adds=False)


def _actions(found: Plan | NoPlan | None) -> tuple[str, ...]:
    """The actions of a plan, as they are written."""
    return tuple(map(str, found.actions)) if isinstance(found, Plan) else ()
