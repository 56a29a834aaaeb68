"""Requests about several things or places at once: "all the cups but the blue one", "go to every room and look"."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import takewhile
from typing import Final

from engine.planner.doing.doing import Doing, Open, Unable
from engine.planner.doing.handling import is_rubbish
from engine.planner.doing.people import are_several
from engine.planner.entities import Entities, Entity
from engine.skills.vocabulary import BIN
from engine.understanding.acts import RoleName
from engine.understanding.meaning import Condition, Do, If, Node, Repeat, Role

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
_ALL_SEEN: Final = re.compile(
    r"(?:all of |both of )?(?:them|those|these)(?: all| both)?|'?em|它们|[那这]些", re.IGNORECASE
)
"""All that a condition has found."""
_EVERYWHERE: Final[tuple[RoleName, ...]] = ("place", "thing", "person")


def with_each(act: Do, doing: Doing) -> Do:
    """The act with a role for each of "blocks 1 and 2", and with "him" as the thing that it is where nobody else was
    spoken of."""
    roles: list[Role] = []
    for role in _of_their_kind(act.roles, doing):
        found = _NUMBERED.fullmatch(role.words.casefold().strip()) if role.name == "thing" else None
        if found is not None:
            kind = found["kind"] or found["zh"]
            roles += [replace(role, words=f"{kind} {number}") for number in _NUMBER.findall(found["numbers"])]
        elif role.name == "thing" and _PERSONAL.fullmatch(role.words.casefold()) and not doing.who:
            roles.append(replace(role, words="it") if doing.named or doing.in_hand else role)
        else:
            roles.append(role)
    return replace(act, roles=tuple(roles))


def _of_their_kind(roles: Sequence[Role], doing: Doing) -> Sequence[Role]:
    """The roles with the kind of a thing that only has a colour: "the green and the yellow box"."""
    things = [role for role in roles if role.name == "thing"]
    kind = next((thing for role in things[1:] if (thing := doing.entities.of(role.words).thing)), "")

    def whole(role: Role) -> Role:
        colour = doing.entities.of(role.words).thing or "" if role in things[:-1] and kind else ""
        return (
            replace(role, words=f"{colour.removesuffix('thing')}{kind.split()[-1]}")
            if colour.endswith(" thing")
            else role
        )

    return [whole(role) for role in roles]


_NUMBER: Final = re.compile(r"\d+|one|two|three|four|five|[一二三四五]")
_NUMBERED: Final = re.compile(
    rf"(?:the )?(?:(?P<kind>block|cube|box|tag)(?:e?s)?(?: numbers?)?|(?P<zh>方块|积木))"
    rf"(?P<numbers> ?(?:{_NUMBER.pattern})(?:(?:号|, (?:and )?| and | & |和|、|跟| or )+(?:{_NUMBER.pattern}))+)号?"
    r"(?:,? all)?"
)
_PERSONAL: Final = re.compile(r"him|her|he|she|[他她]")


def one_by_one(act: Do, doing: Doing) -> Do:
    """The act with the things of this house that "all the cups but the blue one" are; as it is where it has no such
    group, and for what a skill does with all things of a colour."""
    to_a_place = act.act == "tidy" and bool(act.words("place"))
    if doing.seen and (to_a_place or act.act in _WITH_THINGS) and any(map(_ALL_SEEN.fullmatch, act.all("thing"))):
        left_out = {name for words in act.all("except") for name in doing.entities.fitting(words)}
        each = tuple(Role("thing", name, 0, 0) for name in doing.seen if name not in left_out)
        others = (role for role in act.roles if role.name not in ("thing", "except"))
        return replace(act, act="put" if to_a_place else act.act, roles=(*each, *others)) if len(each) > 1 else act
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


def looked_first(nodes: Sequence[Node], entities: Entities) -> tuple[Node, ...]:
    """The nodes with a look before what is done with all that lies somewhere: which things those are, nobody knows
    before. "Put everything on the desk on the shelf"."""
    made: list[Node] = []
    for node in nodes:
        if (
            made
            and isinstance(node, Do)
            and isinstance(last := made[-1], Do)
            and (one := _at_once(last, node, entities))
        ):
            made[-1] = one
        else:
            made.append(node)
    return tuple(_looked_first(node, entities) if isinstance(node, Do) else node for node in made)


def _at_once(first: Do, then: Do, entities: Entities) -> Do | None:
    """One act of two: "collect the boxes and put them on the shelf", "take that ball away and put it on the shelf";
    None where they are two."""
    things, it = first.all("thing"), then.all("thing")
    places = [role.name for role in first.roles if role.name not in ("thing", "source")]
    if first.act not in ("pick_up", "tidy") or places or len(things) != 1 or len(it) > 1:
        return None
    several = entities.of(things[0]).every or _WHATEVER.match(things[0].casefold())
    if (
        then.act not in _WITH_THINGS
        or not (not it or it == things or entities.of(it[0]).refers)
        or not (several or first.act == "tidy")
    ):
        return None
    return replace(then, roles=(*first.roles, *(role for role in then.roles if role.name != "thing")))


def _looked_first(act: Do, entities: Entities) -> Do | If:
    things = [role for role in act.roles if role.name == "thing"]
    moves = act.act in _WITH_THINGS or (act.act == "tidy" and act.words("place"))
    if not moves or len(things) != 1 or act.words("person") not in ("", "me") or act.until is not None:
        return act
    words = things[0].words
    group = entities.of(words)
    source = act.words("source") or (group.at.words if group.at is not None and group.at.known else "")
    spot = entities.of(source) if source else None
    if spot is not None and spot.place is not None and spot.place == entities.of(act.words("place") or "me").place:
        return act  # "pop both cups on the counter", of which a reader has made cups that are on the counter
    if spot is None or not (spot.place or spot.surface or spot.room) or spot.me or spot.surface == BIN:
        return act
    whatever = _WHATEVER.match(words.casefold())
    kind = words[whatever.end() :].strip(" ,") if whatever is not None else words
    if whatever is None and not group.every:
        return act
    if is_rubbish(words) or is_rubbish(kind) or (act.act in ("tidy", "throw_away") and _LYING.search(words)):
        return act
    if not kind or entities.of(kind).thing in (None, "thing"):
        kind = "something"
    kind = entities.near(kind)  # without "all": those are meant which are there
    where = replace(things[0], name="place", words=source)
    others = tuple(
        replace(role, words="them") if role is things[0] else role for role in act.roles if role.name != "source"
    )
    return If(Condition("seen", (replace(things[0], words=kind), where)), (replace(act, roles=others),), ())


_WHATEVER: Final = re.compile(
    r"(?:which(?:ever)? (?:one )?of (?:(?:the|those|these|my) )?(?:(?:two|three|both) )?\b|"
    r"(?:what(?:ever)?|everything|anything)(?:'s| is| else)?(?: (?:that|which)(?:'s| is))?$)"
)
"""What says that all of them, or the one of them, are meant which are there."""
_LYING: Final = re.compile(r"\b(?:lying|strewn|scattered|floor|ground)\b|地上|散落")


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
    left = list(_at_each(nodes, doing))
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


def _at_each(nodes: Sequence[Do | If | Repeat], doing: Doing) -> Sequence[Do | If | Repeat]:
    """The nodes with what is done at each of several places: "go to the desk and the sofa, and beep at each"."""
    journeys = list(takewhile(lambda node: isinstance(node, Do) and node.act == "go", nodes))
    places = [role for act in journeys if isinstance(act, Do) for role in act.roles if role.name == "place"]
    there = [node for node in nodes[len(journeys) :] if isinstance(node, Do) and _is_there(node)]
    if len(places) < 2 or not there or len(journeys) + len(there) != len(nodes):
        return nodes
    if not _AT_EACH.search(doing.said, max(place.end for place in places)):
        return nodes
    return [node for place in places for node in (Do("go", (place,)), *there)]


_AT_EACH: Final = re.compile(
    r"\b(?:at|in|on) (?:each|every)\b|\b(?:each|every) (?:time|stop)\b|\bwherever you (?:stop|arrive)\b|每到|每个地方",
    re.IGNORECASE,
)


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
