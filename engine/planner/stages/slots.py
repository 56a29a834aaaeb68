"""Words that a model put where another kind of word belongs: a thing in a place's slot, a room in a thing's.

What a word is decides which skill serves: a piece of furniture is gone to and looked at, a room is searched, a thing is
gone up to. Only exact names are moved; what no kind of word knows is left for the question about it.
"""

from __future__ import annotations

from engine.plan import ActionCall
from engine.planner.grounding.grounds import resolved
from engine.planner.phrases.said import Calls
from engine.skills.registry import NOT_SAID
from engine.skills.vocabulary import BIN, Vocabulary


def by_kind(calls: Calls, vocabulary: Vocabulary) -> Calls:
    """``calls`` with each word in a skill that takes words of its kind."""
    return tuple(found for call in calls for found in _served(call, vocabulary))


def _served(call: ActionCall, vocabulary: Vocabulary) -> Calls:
    resolve = vocabulary.resolvers()

    def is_a(kind: str, word: str) -> bool:
        return word != NOT_SAID and resolved(resolve[kind], word) is not None

    match call.name, call.positional:
        case "navigation", (str(word),) if not is_a("place", word):
            return _gone_to(word, vocabulary) if is_a("surface", word) else _of_thing(call, word, is_a("object", word))
        case (("navigate_to_object" | "locate" | "scan_room"), (str(word),)) if not is_a(_KINDS[call.name], word):
            return _looked_for(call, word, vocabulary)
        case "carry", (str(thing), str(place), *rest) if not is_a("object", thing) and is_a("object", place):
            swapped = ActionCall("carry", (place, thing, *rest))
            return _served(swapped, vocabulary) if is_a("place", thing) or is_a("surface", thing) else (call,)
        case "carry", (str(thing), str(place)) if not is_a("place", place) and is_a("surface", place):
            put = (
                ActionCall("place_in_bin") if vocabulary.surface(place) == BIN else ActionCall("place_object", (place,))
            )
            return (ActionCall("pick_object", (thing,)), put)
    return (call,)


_KINDS = {"navigate_to_object": "object", "locate": "object", "scan_room": "room"}
"""The kind of word that each of them takes."""


def _looked_for(call: ActionCall, word: str, vocabulary: Vocabulary) -> Calls:
    """A search, or a way, to something of another kind."""
    resolve = vocabulary.resolvers()
    if resolved(resolve["room"], word) is not None and call.name == "locate":
        return (ActionCall("scan_room", (word,)),)
    looks = () if call.name == "navigate_to_object" else (ActionCall("seewhat"),)
    if resolved(resolve["place"], word) is not None:
        return (ActionCall("navigation", (word,)), *looks)
    if resolved(resolve["surface"], word) is not None:
        return (*_gone_to(word, vocabulary), *looks)
    return _of_thing(call, word, resolved(resolve["object"], word) is not None)


def _gone_to(surface: str, vocabulary: Vocabulary) -> Calls:
    """The way to a piece of furniture without a place of its own: to the room that it stands in."""
    room = vocabulary.room_of(vocabulary.surface(surface))
    return (ActionCall("navigation", (room or surface,)),)


def _of_thing(call: ActionCall, word: str, is_thing: bool) -> Calls:
    name = "locate" if call.name == "scan_room" else "navigate_to_object"
    return (ActionCall(name, (word,)) if is_thing else call,)
