"""Whether a place, a room or a surface of a plan has a ground."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

from engine.errors import PlanError
from engine.planner.grounding.grounds import Grounds, resolved
from engine.planner.grounding.questions import WHERE_PUT, Question, as_it_stands
from engine.skills.places import ZERO_SYMBOL
from engine.skills.vocabulary import BIN, FLOOR

_BACK: Final = re.compile(
    r"\b(?:back|return|here|me|i|we|bring|fetch|give|hand|us|my|start\w*|home|zero|remember\w*|origin\w*|previous|saved|"
    r"initial)\b"
    r"|回|这|我|给|拿来|带来|过来|起点|原点|原来|出发|记住"
)
_CHARGING: Final = re.compile(r"\b(?:re)?charg(?:e|ed|ing)\b|充")
_CHARGERS: Final = ("charger", "charging dock", "charging station", "recharge", "充电")
_AWAY: Final = re.compile(r"\b(?:away|bin|trash|rubbish|garbage|waste\w*|dispose|clean|litter)\b|扔|垃圾|丢")
_DOWN: Final = re.compile(r"\b(?:floor|ground|down|here|drop)\b|地|放下|这")


def is_grounded_place(grounds: Grounds, symbol: str) -> bool:
    """Whether this place, by its symbol, was meant."""
    if symbol == ZERO_SYMBOL:
        return grounds.says(_BACK)
    if grounds.says_symbol(symbol) or grounds.asks_for_everywhere():
        return True
    resolve = grounds.vocabulary.resolvers()["place"]
    if grounds.says(_BACK) and resolved(resolve, "me") == symbol:
        return True
    if grounds.says(_CHARGING) and any(resolved(resolve, word) == symbol for word in _CHARGERS):
        return True
    return grounds.names(symbol, grounds.vocabulary.places(), resolve)


def is_grounded_room(grounds: Grounds, name: str) -> bool:
    """Whether this room was meant."""
    return grounds.names(name, grounds.vocabulary.rooms(), grounds.vocabulary.room)


def about_surface(grounds: Grounds, value: str) -> Question | None:
    """What to ask about where things are put; None where that has a ground."""
    if (value == BIN and grounds.says(_AWAY)) or (value == FLOOR and grounds.says(_DOWN)):
        return None
    vocabulary = grounds.vocabulary
    words = (*vocabulary.surfaces(), *vocabulary.rooms(), *vocabulary.places())
    if grounds.names(value, words, vocabulary.surface) or (len(value) == 1 and grounds.says_symbol(value)):
        return None
    return _which_of(grounds, words) or WHERE_PUT


def _which_of(grounds: Grounds, words: Iterable[str]) -> Question | None:
    """The question that a word has which means several surfaces."""
    for word in words:
        if any(statement.says(word) for statement in grounds.said):
            try:
                grounds.vocabulary.surface(word)
            except PlanError as error:
                if error.code == "ambiguous":
                    return as_it_stands(error.message)
    return None
