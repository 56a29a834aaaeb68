"""Journeys to places that the map does not have: what is asked or told about them.

A name may mean several pieces of furniture, or one that is no place of its own but stands in a room that is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from config.nearest import nearest
from engine.errors import ExitCode
from engine.plan import ActionCall
from engine.planner.request import Language, NoPlan
from engine.planner.sentences import SAID
from engine.skills.vocabulary import Vocabulary

NEAR: Final = 0.75
"""How alike two names have to be, 0 to 1, as ``difflib`` counts it."""


def unknown(text: str, name: str, known: Sequence[str], language: Language) -> NoPlan:
    """That nobody knows it: the offer to go to the one of ``known`` whose name is nearest, else which places there
    are."""
    if near := nearest_place(name, known):
        question = SAID[language]["nearest"].format(name=name, near=near)
        return NoPlan(text, "unknown_place", question, ExitCode.CLARIFY, suggestions=(near,), offer=_going(near))
    answer = SAID[language]["unknown_place"].format(name=name, known=", ".join(known))
    return NoPlan(text, "unknown_place", answer, suggestions=tuple(known))


def nearest_place(name: str, known: Sequence[str]) -> str:
    """The one of ``known`` that ``name`` may be a misspelling of; empty where none is near. A word in front that is
    misspelt as well ("teh kichen") may be an article."""
    words = name.casefold().split()
    found = (nearest(said, known, NEAR) for said in (" ".join(words), " ".join(words[1:])) if said)
    return next(filter(None, found), "")


def room_instead(text: str, name: str, vocabulary: Vocabulary, language: Language) -> NoPlan | None:
    """The offer to go to the room in which that piece of furniture stands; None where it is none."""
    symbol = vocabulary.room_of(name)
    words = vocabulary.words_for(symbol) if symbol else ()
    room = next((word for word in words if word.isascii() == (language == "en")), "")
    if not room:
        return None
    question = SAID[language]["no_place_there"].format(name=name, room=room)
    return NoPlan(text, "no_place_there", question, ExitCode.CLARIFY, offer=_going(room))


def _going(place: str) -> tuple[ActionCall, ...]:
    return (ActionCall("navigation", (place,)),)
