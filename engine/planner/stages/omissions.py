"""What a model left out: a place or a thing that is named in the request and nowhere in the plan.

A person may name things that nothing is to be done with, so this is only worth asking the model once more.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from engine.plan import Action
from engine.planner.grounding.grounds import resolved
from engine.planner.grounding.mentions import Thing
from engine.planner.grounding.statement import Statement, said_names
from engine.skills.vocabulary import BIN, FLOOR, Vocabulary

_OFTEN_NO_PLACES: Final = frozenset({"me", "us", "i", "user", "start", "home", "我", "家"})


def left_out(actions: Sequence[Action], text: str, vocabulary: Vocabulary) -> str:
    """The words of ``text`` that the plan has nothing of; empty where it has something of all."""
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
