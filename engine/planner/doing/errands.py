"""What acts mean beside one another: people tell one errand in two acts ("get the ball, then put it on the bed")."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from engine.planner.doing.doing import Doing
from engine.understanding.meaning import Do, If, Node, Repeat, Role

FOLLOW_AND_CLEAR: Final = "follow_and_clear"
"""The act of following a line and taking away what lies on it, which people tell in two."""
_IN_THE_WAY: Final = re.compile(r"\bway\b|\bpath\b|block|obstacle|obstruct|挡|障碍|拦")
_GOING: Final = frozenset({"go", "come", "go_back", "charge", "look", "meet", "wait"})
"""Acts that go somewhere else, so that a place is left by them."""


def as_errands(nodes: Sequence[Do | If | Repeat], doing: Doing) -> tuple[Do | If | Repeat, ...]:
    """The nodes with those made one that are one errand."""
    made: list[Do | If | Repeat] = []
    for node in nodes:
        last = made[-1] if made else None
        if isinstance(last, Do) and isinstance(node, Do):
            if last.act in ("guide", "follow") and node.act in ("find", "meet", "fact") and _is_where(last, node):
                place = next(role for role in node.roles if role.name == "place")
                made[-1] = replace(last, roles=(*last.roles, replace(place, name="source")))
                continue
            if last.act == "leave" and node.act in _GOING:
                made.pop()  # whoever goes elsewhere has left
            elif last.act == "follow" and _clears_the_way(node, doing):
                made[-1] = replace(last, act=FOLLOW_AND_CLEAR)
                continue
            elif (
                last.act in ("bring", "pick_up")
                and node.act in ("put", "throw_away", "bring")
                and _several(last, node, doing)
            ):
                made[-1] = _with_things(last.roles, node)
                continue
            elif (
                last.act == "put"
                and node.act in ("put", "bring")
                and not last.words("place")
                and node.words("place")
                and _same_thing(last, node, doing)
            ):
                made[-1] = _with_things([role for role in last.roles if role.name == "thing"], node)
                continue
            elif {last.act, node.act} <= _PLACES and _goes_along(last, node, doing):
                node = replace(node, roles=(*node.roles, *(role for role in last.roles if role.name == "place")))
            elif last.act == "put" and node.act == "put" and _is_moved(last, node, doing):
                where = [replace(role, name="source") if role.name == "place" else role for role in last.roles]
                made[-1] = _with_things(where, node)
                continue
            elif last.act == "pick_up" and node.act in ("pick_up", "bring") and not _same_thing(last, node, doing):
                made[-1] = replace(last, act="bring")  # only one fits into the hand
                node = replace(node, act="bring")
            elif last.act == "bring" and _same_thing(last, node, doing):
                made.pop()
                made += _errand(
                    last, node, doing, placed=any(one.words("place") for one in made if isinstance(one, Do))
                )
                continue
        made.append(node)
    return tuple(made)


def brought(nodes: Sequence[Node], said: str) -> tuple[Node, ...]:
    """The nodes with what is fetched "for me" as what is brought, where nothing else becomes of it."""
    *before, last = nodes or (Do("stop"),)
    if not isinstance(last, Do) or last.act != "pick_up" or len(last.all("thing")) != 1 or not _FOR_ME.search(said):
        return tuple(nodes)
    return (*before, replace(last, act="bring"))


_FOR_ME: Final = re.compile(r"\b(?:get|grab|fetch)\b.*\bfor (?:me|us)\b|(?:给|帮)我.*拿来", re.IGNORECASE)


_PLACES: Final = frozenset({"put", "bring"})


def _goes_along(first: Do, second: Do, doing: Doing) -> bool:
    """Whether it goes to the same place: "the ball in the wardrobe, and the yellow box too"."""
    if not first.words("place") or any(role.name != "thing" for role in second.roles) or not second.roles:
        return False
    return _TOO.match(doing.said, max(role.end for role in second.roles)) is not None


_TOO: Final = re.compile(r",? ?(?:too|as well|also)\b|也(?:一样|是)?", re.IGNORECASE)


def _is_where(first: Do, second: Do) -> bool:
    """Whether it says where somebody is found: "guide Anna to the exit, you may find her at the desk"."""
    who, place = second.words("person"), second.words("place")
    return bool(place) and not first.words("source") and _PRONOUN.fullmatch(who.casefold()) is not None


_PRONOUN: Final = re.compile(r"him|her|them|he|she|they|[他她]们?")


def _with_things(roles: Sequence[Role], then: Do) -> Do:
    """The act with these roles instead of the things that it names itself ("it")."""
    return replace(then, roles=(*roles, *(role for role in then.roles if role.name != "thing")))


def _errand(fetch: Do, then: Do, doing: Doing, *, placed: bool) -> tuple[Do, ...]:
    """What is done with a thing that is fetched, where the next act says more: "take the ball to the bedroom, put it on
    the bed" picks it up only; what has been brought is not put down once more."""
    picked = tuple(role for role in fetch.roles if role.name in ("thing", "source"))
    says_where, says_more = (
        any(words and not doing.entity(words).refers for words in (act.words("place"), act.words("person")))
        for act in (fetch, then)
    )
    match then.act:
        case "put" if placed and not says_where and doing.entity(then.words("place") or "it").refers:
            return (Do("pick_up", picked), then)  # where something was put before
        case "put" if not says_more:
            return (fetch,)
        case "bring" if not says_where:
            return (_with_things(picked, then),)
        case "throw_away" if says_where:
            return (fetch, then)
        case "put" | "throw_away":
            return (Do("pick_up", picked), then)
    return (fetch, then)


def _is_moved(first: Do, second: Do, doing: Doing) -> bool:
    """Whether the first place is where the thing is: "that ball on the bed, put it on the shelf"."""
    it = second.words("thing")
    return bool(it) and doing.entity(it).refers and not first.words("source") and _same_thing(first, second, doing)


def _several(take: Do, then: Do, doing: Doing) -> bool:
    """Whether several things are taken that the next act puts somewhere: "get all that is red and put it there"."""
    if any(take.words(name) for name in ("place", "person")) or not doing.entity(then.words("thing") or "it").refers:
        return False
    return len(take.all("thing")) > 1 or doing.entity(take.words("thing") or "it").every


def _clears_the_way(act: Do, doing: Doing) -> bool:
    """Whether it takes away all that lies there."""
    words = act.words("thing")
    if act.act not in ("tidy", "push", "throw_away") or act.words("place"):
        return False
    found = doing.entity(words or "it")
    return _IN_THE_WAY.search(words.casefold()) is not None or (found.every and found.thing in (None, "thing"))


def _same_thing(first: Do, second: Do, doing: Doing) -> bool:
    """Whether both are about one thing, which the second may call "it"."""
    if len(first.all("thing")) != 1 or first.until is not None:
        return False
    found = doing.entity(second.words("thing") or "it")
    return found.refers or found.thing == doing.entity(first.words("thing")).thing is not None
