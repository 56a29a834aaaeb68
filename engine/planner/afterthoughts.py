"""What somebody goes on with after a request that was complete: "go to the kitchen", and a moment later "and wave".

By then the robot is on its way. What only adds to the request is done after it; what makes another one of it ("pick up
the cup" … "in the kitchen") is done in its place. Only phrases decide: whoever talks to somebody else must not be drawn
into a request, nor may what a recogniser makes of noise.
"""

from __future__ import annotations

import re
from typing import Final

from engine.asr.agreement import first_words, normalised_words
from engine.hearing.readings import Afterthought
from engine.plan import ActionCall
from engine.planner.completeness import completeness
from engine.planner.not_an_order import what_counts
from engine.planner.phrases.phrases import Matched, PhrasePlanner, UnknownPlace
from engine.planner.phrases.stopping import is_stop
from engine.planner.readings.corrections import corrected
from engine.planner.request import Language

_FROM_HERE: Final = frozenset({"move_forward", "move_sideways", "move_left", "move_right"})
"""What leads elsewhere if it is begun anew."""

_GOES_ON: Final = re.compile(r"\W*(?:(?:and|then|also|afterwards)\b|然后|接着|接下来|之后|并且|再|还有)", re.IGNORECASE)
"""How somebody begins who has not said all."""


def afterthought(first: str, whole: str, phrases: PhrasePlanner, language: Language) -> Afterthought | None:
    """What was said after the request ``first``, as far as it belongs to it; ``whole`` is both together."""
    words = normalised_words(first)
    if normalised_words(whole)[: len(words)] != words:
        return None
    rest = whole[len(first_words(whole, len(words))) :].lstrip(" ,.，。、；;")
    before, after = _calls(first, phrases), _calls(whole, phrases)
    if not rest or before is None:
        return None
    if what_counts(rest) == "" and not is_stop(rest):  # "never mind"
        return Afterthought(whole, adds=False)
    if not any(corrected(rest, language)) and any(_calls(meant, phrases) for meant in corrected(whole, language)):
        return Afterthought(whole, adds=False)  # "no, to the bedroom"
    if completeness(whole, phrases) == "incomplete":
        return None
    added = _calls(rest, phrases)
    if after is None:
        asked = isinstance(phrases.plan(rest), UnknownPlace)  # which will be told
        thought = _GOES_ON.match(rest) and len(normalised_words(rest)) > 2  # about by large models, if there are any
        return Afterthought(rest, adds=True, clear=False) if asked or thought else None
    if after == before or added == before:  # a word of thanks; or it was said once more
        return None
    if after == (*before, *(added or ())):
        return Afterthought(rest, adds=True)
    return None if any(call.name in _FROM_HERE for call in before) else Afterthought(whole, adds=False)


def _calls(text: str, phrases: PhrasePlanner) -> tuple[ActionCall, ...] | None:
    found = phrases.plan(text)
    return found.calls if isinstance(found, Matched) and found.kind == "plan" else None
