"""What a model left out: a clause of the request that plainly asks for something, a place or a thing that is named in
it and nowhere in the plan.

A person may name things that nothing is to be done with, so this is only worth asking the model once more.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Final

from engine.plan import Action, ActionCall
from engine.planner.grounding.grounds import resolved
from engine.planner.grounding.mentions import Thing
from engine.planner.grounding.statement import Statement, said_names
from engine.skills.vocabulary import BIN, FLOOR, Vocabulary

PLAIN: Final = frozenset(
    {
        "move_forward", "move_sideways", "move_left", "move_right", "set_cmdvel", "wait", "beep", "light", "say",
        "dance", "drift", "arm_up", "arm_down", "arm_nod", "arm_shake", "arm_applaud", "servo1_move", "report_pose",
        "get_current_pose",
    }
)  # fmt: skip
"""Skills that one clause asks for, whatever the others say."""
_OFTEN_NO_PLACES: Final = frozenset({"me", "us", "i", "user", "start", "home", "我", "家"})


def left_out(
    actions: Sequence[Action], text: str, clauses: Sequence[tuple[str, Sequence[ActionCall]]], vocabulary: Vocabulary
) -> str:
    """The words of ``text`` that the plan has nothing of; empty where it has something of all. ``clauses``: those that
    were understood by themselves, with what they ask for."""
    planned = Counter(action.name for action in actions)
    for words, calls in clauses:
        wanted = Counter(call.name for call in calls if call.name in PLAIN)
        if wanted - planned:
            return words
        planned -= wanted
    said, values = Statement(text), {str(value) for action in actions for value in action.args.values()}
    reached = {part for value in values for part in value.split(",")}
    reached |= {BIN} if any(action.name == "place_in_bin" for action in actions) else set()
    for word in said_names(said, (*vocabulary.rooms(), *vocabulary.places(), *vocabulary.surfaces())):
        meant = {resolved(vocabulary.resolvers()[kind], word) for kind in ("place", "surface", "room")} - {None, FLOOR}
        if meant and word not in _OFTEN_NO_PLACES and not meant & reached:
            return word
    things = [Thing.of(value) for value in values]
    for mention in said.mentions:
        if mention.has_kind and mention.colour and not any(thing.fits(mention) for thing in things):
            return f"{mention.colour} {mention.noun}"
    return ""
