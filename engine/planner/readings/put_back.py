"""Putting something back where it was taken: known only where that was said when it was to be taken.

What the robot saw on the way is not asked: a thing that was found elsewhere than it was said to be is not put "back"
to where it was not. Where nobody has said from where, the question where to put it stays.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from engine.plan import Plan
from engine.planner.request import Happened, Said
from engine.planner.text.language import alternatives
from engine.skills.vocabulary import Vocabulary

_BACK: Final = re.compile(
    r"(?P<polite>(?:[\w']+,? ){0,6}?)(?:put|place|set|bring|take|return|leave) (?P<it>it|that|this|the [\w ]+?)"
    r"(?: back| down)?(?: again)? (?:to )?(?:where|the place where|from where|exactly where|right where|wherever) "
    r"(?:you|it|we|i) (?:got|found|took|picked|had|was|came|stood|lay|belonged|collected|fetched|grabbed)"
    r"(?: it| that| this)?(?: up)?(?: from| before)?\W*"
    r"|(?:请)?(?:把)?(?P<zh>它|那个|这个)?(?:放|拿|送)回(?:原处|原位|原来的地方|去原来的地方|原地)\W*",
    re.IGNORECASE,
)


def put_back(text: str, holding: str, happened: Sequence[Happened], vocabulary: Vocabulary) -> str:
    """``text`` with the name of where the thing was taken from, where it is held and that was said; else unchanged."""
    if not holding or (found := _BACK.fullmatch(text.strip())) is None:
        return text
    if found["it"] and found["it"].startswith("the ") and found["it"].removeprefix("the ") not in holding:
        return text
    source = _source(holding, happened, vocabulary)
    if not source:
        return text
    return f"放到{source}上" if found["it"] is None else f"put it on the {source}"


def _source(thing: str, happened: Sequence[Happened], vocabulary: Vocabulary) -> str:
    """From where the thing was to be taken when it was; empty where nobody said so."""
    names = alternatives(name for name in vocabulary.surfaces() if len(name) > 1)
    said = re.compile(
        rf"(?:\b(?:from|off|off of|out of|that is on|that's on|on)(?: top of)? (?:the |my |our )?(?P<en>{names})\b)|"
        rf"从(?P<zh>{names})",
        re.IGNORECASE,
    )
    for at in range(len(happened) - 1, -1, -1):
        plan = happened[at]
        if isinstance(plan, Plan) and any(a.name == "pick_object" and thing in a.args.values() for a in plan.actions):
            words = next((before.text for before in reversed(happened[:at]) if isinstance(before, Said)), "")
            # whatever was put somewhere since, or in the same breath, was not taken from there
            sources = {found["en"] or found["zh"] for found in said.finditer(words)}
            placed = any(action.name.startswith("place_") for action in plan.actions)
            return sources.pop() if len(sources) == 1 and not placed else ""
    return ""
