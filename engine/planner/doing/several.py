"""Requests about several things or places at once: "all the cups but the blue one", "go to every room and look"."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from engine.planner.doing.doing import Doing, Open, Unable
from engine.planner.doing.people import are_several
from engine.planner.entities import Entity
from engine.understanding.acts import RoleName
from engine.understanding.meaning import Do, If, Repeat, Role

_THERE: Final = frozenset({
    "look", "count", "describe", "check", "find", "read", "say", "beep", "light", "light_off", "nod", "shake", "wave",
    "applaud", "greet", "answer", "wait", "turn_around", "remember", "arm_up", "arm_down",
})  # fmt: skip
"""Acts that are done at each place that the robot goes to, where no other place is said."""
_WITH_THINGS: Final = frozenset({"bring", "put", "throw_away"})
"""Acts that are done with one thing after the other."""
_OF_ROOMS: Final = frozenset({"go", "clean", "tidy", "look"})
"""Acts whose thing may be the rooms themselves."""
_BOTH: Final = re.compile(r"both\b")
_EVERYWHERE: Final[tuple[RoleName, ...]] = ("place", "thing", "person")


def with_each(act: Do, doing: Doing) -> Do:
    """The act with a role for each of "blocks 1 and 2", and with "him" as the thing that it is where nobody else was
    spoken of."""
    roles: list[Role] = []
    for role in act.roles:
        found = _NUMBERED.fullmatch(role.words.casefold().strip()) if role.name == "thing" else None
        if found is not None:
            kind = found["kind"] or found["zh"]
            roles += [replace(role, words=f"{kind} {number}") for number in _NUMBER.findall(found["numbers"])]
        elif role.name == "thing" and _PERSONAL.fullmatch(role.words.casefold()) and not doing.who:
            roles.append(replace(role, words="it") if doing.named or doing.in_hand else role)
        else:
            roles.append(role)
    return replace(act, roles=tuple(roles))


_NUMBER: Final = re.compile(r"\d+|one|two|three|four|five|[一二三四五]")
_NUMBERED: Final = re.compile(
    rf"(?:the )?(?:(?P<kind>block|cube|box|tag)(?:e?s)?(?: numbers?)?|(?P<zh>方块|积木))"
    rf"(?P<numbers> ?(?:{_NUMBER.pattern})(?:(?:号|, (?:and )?| and | & |和|、|跟| or )+(?:{_NUMBER.pattern}))+)号?"
)
_PERSONAL: Final = re.compile(r"him|her|he|she|[他她]")


def one_by_one(act: Do, doing: Doing) -> Do:
    """The act with the things of this house that "all the cups but the blue one" are; as it is where it has no such
    group, and for what a skill does with all things of a colour."""
    to_a_place = act.act == "tidy" and bool(act.words("place"))
    if are_several(doing, act.words("person")):  # each of them gets one: "drinks to everyone"
        return act
    if act.words("source") and doing.seen:
        seen = [name for words in act.all("thing") for name in _members(doing, words, ()) if name in doing.seen]
        if len(seen) == 1:  # of these there is only one
            return replace(act, roles=(*(r for r in act.roles if r.name != "thing"), Role("thing", seen[0], 0, 0)))
    if act.words("source") and any(_is_group(doing, words, act) for words in act.all("thing")):
        raise Unable("every", act.words("thing"))  # which of them lie there, nobody knows yet
    if not (act.act in _WITH_THINGS or to_a_place) or not any(_is_group(doing, one, act) for one in act.all("thing")):
        return act
    without = act.all("except")
    roles: list[Role] = []
    for role in act.roles:
        if role.name == "thing" and _is_group(doing, role.words, act):
            roles += [replace(role, words=name) for name in _members(doing, role.words, without)]
        elif role.name != "except":
            roles.append(role)
    named = [doing.entity(role.words).thing if role.name == "thing" else None for role in roles]
    roles = [role for at, role in enumerate(roles) if named[at] is None or named[at] not in named[:at]]
    return replace(act, act="put" if to_a_place else act.act, roles=tuple(roles))


def _is_group(doing: Doing, words: str, act: Do) -> bool:
    found = doing.entity(words)
    if found.every and _BOTH.match(words.casefold()) and len(doing.entities.members(found)) > 2:
        raise Open("which_thing")
    of_colour = bool(found.thing and found.thing.endswith(" thing")) and not act.words("except")
    return (found.every or bool(act.words("except"))) and bool(doing.entities.members(found)) and not of_colour


def _members(doing: Doing, words: str, without: Sequence[str]) -> tuple[str, ...]:
    group = doing.entity(words)
    names = doing.entities.members(group)
    left_out = {name for other in without for name in _left_out(doing, other, group)}
    if without and not left_out & set(names):
        raise Unable("role", without[0])
    return tuple(name for name in names if name not in left_out)


def _left_out(doing: Doing, words: str, group: Entity) -> tuple[str, ...]:
    """What "the blue one" is of "all the cups"."""
    found = doing.entity(words)
    kind = (group.thing or "").split()[-1:]
    if found.thing and found.thing.endswith(" thing") and kind:
        found = replace(found, thing=f"{found.thing.removesuffix('thing')}{kind[0]}")  # "the blue one" of the cups
    return doing.entities.members(found) or ((found.thing,) if found.thing else ())


def spread(nodes: Sequence[Do | If | Repeat], doing: Doing) -> tuple[Do | If | Repeat, ...]:
    """The nodes with one journey for each room, where all are meant; what is done there is done in each."""
    made: list[Do | If | Repeat] = []
    left = list(nodes)
    while left:
        act = left.pop(0)
        rooms = _rooms_of(act, doing) if isinstance(act, Do) else ()
        if not isinstance(act, Do) or not rooms:
            made.append(act)
            continue
        there: list[Do] = []
        while act.act == "go" and left and isinstance(node := left[0], Do) and _is_there(node):
            there.append(node)
            del left[0]
        if there and there[0].act == "look" and not there[0].roles:
            act = there.pop(0)  # a look at a room goes there
        for room in rooms:
            made += [_at(act, Role("place", room, 0, 0)), *there]
    return tuple(made)


def _rooms_of(act: Do, doing: Doing) -> tuple[str, ...]:
    """The rooms that "every room" are, but for those that are not meant; nothing where no act goes to all rooms."""
    named = any(doing.entities.rooms_meant(words) for name in _EVERYWHERE for words in act.all(name))
    if not named or act.act == "patrol" or act.until is not None:
        return ()
    left_out = {words: doing.entity(words).room for words in act.all("except")}
    if unknown := next((words for words, room in left_out.items() if room is None), None):
        raise Unable("role", unknown)
    return tuple(room for room in doing.entities.rooms() if room not in left_out.values())


def _is_there(act: Do) -> bool:
    return act.act in _THERE and not act.words("place") and act.until is None


def _at(act: Do, room: Role) -> Do:
    """The act in one room instead of in all of them."""
    gone = {"except", "place"} | ({"thing"} if act.act in _OF_ROOMS else set())
    return replace(act, roles=(room, *(role for role in act.roles if role.name not in gone)))
