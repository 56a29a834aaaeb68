"""Journeys to places that the map does not have: what is asked or told about them.

A name may mean several pieces of furniture, or one that is no place of its own but stands in a room that is.
"""

from __future__ import annotations

import re
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


def meant(text: str, vocabulary: Vocabulary, language: Language) -> NoPlan | None:
    """The question whether a place is meant by a request that is no more than its letter on the map, the beginning of
    its name, or its name misspelt; None where it is none of these, or that of too many places."""
    said = _FRAME.sub("", text.casefold()).strip()
    if not said or len(said) > _LONGEST:
        return None
    symbols = _meant(said, vocabulary)
    names = [name for symbol in symbols if (name := _name_in(vocabulary, symbol, language))]
    if not 0 < len(names) <= MOST_MEANT:
        return None
    words = SAID[language]
    if len(names) > 1:
        question = words["which_of"].format(names=words["or"].join(names))
        return NoPlan(text, "did_you_mean", question, ExitCode.CLARIFY, suggestions=tuple(names), options=tuple(names))
    question = words["did_you_mean"].format(near=names[0])
    offer = (ActionCall("navigation", (names[0],)),)
    return NoPlan(text, "did_you_mean", question, ExitCode.CLARIFY, suggestions=tuple(names), offer=offer)


MOST_MEANT: Final = 3
"""Of more places nobody is asked which one is meant."""
_LONGEST: Final = 30
"""Characters of the longest name that is looked for."""
_FRAME: Final = re.compile(r"^\W*(?:(?:the|a|my|our)\b\W*)?|\W*(?:\bplease\W*)?$")


def _meant(said: str, vocabulary: Vocabulary) -> list[str]:
    """The symbols of the places that may be meant; a name goes before other words for a place."""
    symbol_of = vocabulary.resolvers()["place"]
    if vocabulary.is_symbol(said):
        return [symbol_of(said)]
    words = vocabulary.places()
    names = [word for word in words if vocabulary.place_name(symbol_of(word)).casefold() == word]
    for known in (names, words):
        if begun := [word for word in known if word.startswith(said) and len(said) > said.isascii()]:
            return list(dict.fromkeys(map(symbol_of, begun)))
    if near := nearest(said, words, NEAR):
        return [symbol_of(near)]
    pair = said.split() if said.count(" ") == 1 else []  # one word beside a name: "zzz kitchen"
    return list(dict.fromkeys(symbol_of(word) for word in pair if word in words))


def _name_in(vocabulary: Vocabulary, symbol: str, language: Language) -> str:
    """What a place is called in a language."""
    words = vocabulary.words_for(vocabulary.place_name(symbol))
    return next((word for word in words if word.isascii() == (language == "en")), next(iter(words), ""))


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
