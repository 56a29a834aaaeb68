"""Slips of small models that the words of the request set right, without asking again.

They turn to the wrong side, look where they stand instead of where they were told to, tidy by a colour that nobody
named, and fetch a thing without bringing it. Nothing is added here that was not said.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from engine.plan import ActionCall, Quantity
from engine.planner.conventions import QUARTER
from engine.planner.grounding.grounds import resolved
from engine.planner.grounding.statement import Statement, said_names
from engine.planner.phrases.said import Calls
from engine.planner.stages.slots import by_kind
from engine.skills.places import ZERO_SYMBOL
from engine.skills.registry import NOT_SAID
from engine.skills.vocabulary import Vocabulary

_LEFT: Final = re.compile(r"\bleft(?:wards?)?\b|\b(?:anti|counter)[ -]?clockwise\b|左|逆时针")
_RIGHT: Final = re.compile(
    r"(?<!all )\bright(?:wards?)?\b(?! (?:now|away|here|there|next|behind|in|at|up|after|before|over|across|by|on|off|"
    r"then|beside|into|to (?!the right)))|(?<!anti)(?<!anti[ -])(?<!counter)(?<!counter[ -])\bclockwise\b"
    r"|右|顺时针"
)
_AND_BACK: Final = re.compile(r"\b(?:back|return|undo|opposite|other|both|either|again)\b|回|另一|相反|再")
_FOR_ME: Final = re.compile(
    r"\b(?:bring|fetch|give|hand|pass|get|grab) (?:me|us|it to me|that to me)\b|\b(?:to|over) (?:me|here)\b"
    r"|给我|拿来|带来|递来|过来"
)
_TAKES: Final = re.compile(r"\b(?:take|get|grab|pick|lift|collect|hold|retrieve)\b|[拿捡抓取]")
_TAKES_TO: Final = re.compile(
    r"\b(?:to|into|onto|away|there(?! is| are)|somewhere|elsewhere|back|for|put|place|move|carry|bring|deliver|"
    r"give|hand|me|us|him|her)\b|[到给放送搬去]|那"
)
_SOMEWHAT: Final = re.compile(
    r"\b(?:bit|little|some|somewhat|slightly|few|more|further|again|enough|much|far|degrees?|angle|amount)\b|点|些|多少|再|度"
)
_OTHER_SIDE: Final = {"move_left": "move_right", "move_right": "move_left"}
_GOES: Final = frozenset({"navigation", "navigate_to_object", "carry", "patrol"})


def mended(calls: Calls, text: str, vocabulary: Vocabulary) -> Calls:
    """``calls`` as the request ``text`` meant them, as far as that is certain."""
    said = Statement(text)
    calls = by_kind(calls, vocabulary)
    for mend in (_to_the_side, _where_to_look, _without_colour, _brought, _only_taken, _a_quarter, _once):
        calls = mend(calls, said, vocabulary)
    return calls


def _to_the_side(calls: Calls, said: Statement, vocabulary: Vocabulary) -> Calls:
    """Where one side alone was said, everything goes to that one."""
    left, right = _LEFT.search(said.text) is not None, _RIGHT.search(said.text) is not None
    if left == right or _AND_BACK.search(said.text):
        return calls
    wrong = "move_right" if left else "move_left"

    def mend(call: ActionCall) -> ActionCall:
        if call.name == wrong:
            return replace(call, name=_OTHER_SIDE[wrong])
        match call.name, call.positional:
            case "move_sideways", (Quantity(distance, unit), *more) if (distance < 0) == left:
                return replace(call, positional=(Quantity(-distance, unit), *more))
        return call

    return tuple(map(mend, calls))


def _where_to_look(calls: Calls, said: Statement, vocabulary: Vocabulary) -> Calls:
    """A look goes to the one place that was said, where the plan goes nowhere at all."""
    looks = [call for call in calls if call.name in ("seewhat", "scan_room") and not call.positional]
    if len(looks) != 1 or any(call.name in _GOES or call.positional for call in calls):
        return calls
    names = said_names(said, (*vocabulary.rooms(), *vocabulary.places()))
    if len(names) != 1:
        return calls
    at, (name,) = calls.index(looks[0]), names
    look: Calls = (ActionCall("scan_room", (name,)),)
    if resolved(vocabulary.room, name) is None:
        look = (ActionCall("navigation", (name,)), ActionCall("seewhat"))
    return (*calls[:at], *look, *calls[at + 1 :])


def _without_colour(calls: Calls, said: Statement, vocabulary: Vocabulary) -> Calls:
    """Who named no colour wants the whole room tidied, or one thing put away."""
    things = [f"{mention.noun} {mention.tag}".strip() for mention in said.mentions if mention.has_kind]
    if any(mention.colour for mention in said.mentions) or len(things) > 1:
        return calls
    if things:
        match calls:
            case (ActionCall("tidy", (_, str(where))),):
                return (ActionCall("pick_object", (things[0],)), ActionCall("place_object", (where,)))
        return calls
    clean = ActionCall("clean_room", said_names(said, vocabulary.rooms())[:1])
    return tuple(clean if call.name == "tidy" and NOT_SAID in call.positional[:1] else call for call in calls)


def _brought(calls: Calls, said: Statement, vocabulary: Vocabulary) -> Calls:
    """What is fetched for the user is brought to them."""
    if _FOR_ME.search(said.text) is None:
        return calls
    match calls:
        case (ActionCall("pick_object", (thing,)), *rest) if _only_ends(rest):
            return (ActionCall("carry", (thing, ZERO_SYMBOL)),)
        case (ActionCall("navigation", (str(place),)), ActionCall("pick_object", (thing,)), *rest) if _only_ends(rest):
            surface = resolved(vocabulary.surface, place)
            return (ActionCall("carry", (thing, ZERO_SYMBOL, *((surface,) if surface is not None else ()))),)
    return calls


def _a_quarter(calls: Calls, said: Statement, vocabulary: Vocabulary) -> Calls:
    """ "Turn left" is a quarter of a turn, unless some other amount is spoken of."""
    if said.numbers or said.quantities or _SOMEWHAT.search(said.text) is not None:
        return calls
    sides = {"move_left": _LEFT, "move_right": _RIGHT}
    return tuple(
        replace(call, positional=(Quantity(QUARTER, "deg"), *call.positional[1:]))
        if call.name in sides and call.positional[:1] == (NOT_SAID,) and sides[call.name].search(said.text)
        else call
        for call in calls
    )


def _only_taken(calls: Calls, said: Statement, vocabulary: Vocabulary) -> Calls:
    """Who takes something and names no place for it only picks it up."""
    if _TAKES.search(said.text) is None or _TAKES_TO.search(said.text) is not None:
        return calls
    return tuple(
        ActionCall("pick_object", call.positional[:1])
        if call.name == "carry" and call.positional[1:2] == (NOT_SAID,) and call.positional[0] != NOT_SAID
        else call
        for call in calls
    )


def _only_ends(calls: Sequence[ActionCall]) -> bool:
    """Whether they do nothing but bring something to an end that has been picked up."""
    return all(
        call.name in ("putdown", "open_gripper", "finishtask") or call == ActionCall("navigation", (ZERO_SYMBOL,))
        for call in calls
    )


def _once(calls: Calls, said: Statement, vocabulary: Vocabulary) -> Calls:
    """Going along a line and clearing it is one thing, and so is going to the place where one is."""
    kept: list[ActionCall] = []
    for call in calls:
        if kept and kept[-1].name == "follow_line" and call.name == "follow_line_clear":
            kept[-1] = call if call.positional else replace(call, positional=kept[-1].positional)
        elif not (kept and call.name in _GOES and call == kept[-1]):
            kept.append(call)
    return tuple(kept)
