"""Acts of looking, finding and following what is seen, and what a condition looks at."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Final

from engine.planner.doing.doing import Doing, NowhereKnown, Open, Roles, Unable
from engine.planner.doing.handling import source_of
from engine.planner.doing.moving import anybody, turned
from engine.planner.phrases.said import Calls, call
from engine.understanding.meaning import Condition, Do

_TOLD: Final = re.compile(
    r"\b(?:i|we|you(?:'re| are)?|further|told|someone|somebody|he|she|they)\b.*"
    r"\b(?:say|says|said|tell|tells|told|call|calls|shout|stop|stops|whistle|notice|otherwise)|"
    r"further notice|otherwise|我.*(?:说|叫|喊|让)|叫停|喊停|另行通知"
)
"""That somebody says so: what ends everything anyway."""
_ITSELF: Final = re.compile(r"you(?:rself)?|your (?:hands?|gripper|claw|arm)|你(?:自己|手里|手上|手)?|机器人")
_ITSELF_HOLDS: Final = re.compile(
    r"(?:you|you're|you are|you've|you have) (?:already |still )?((?:got |hold|carry|grip).*)|"
    r"你(?:手里|手上)?((?:拿|抓|夹).*)"
)
_EMPTY: Final = re.compile(r"empty|free|nothing|空|没")
_HOLDING: Final = re.compile(r"hold|carry|grip|got|in your (?:hand|grip)|拿|抓|夹|空手|手里|empty[- ]?handed")
_HELD_THING: Final = re.compile(r".*?(?:holding|carrying|hold|carry|got)|in your (?:hands?|gripper|grip)|[拿抓夹]着?")
_ANYTHING: Final = re.compile(r"(?:any|some|no)thing.*|things?|stuff|(?:什么|任何)?东西|什么|空|.*handed")
_GOES_ON: Final = frozenset({"follow", "patrol", "dance"})
"""Acts that go on until something ends them."""


def untimed(act: Do) -> Do:
    """The act without "until", where its skill ends just then; else as it is."""
    until = act.until
    if until is None or until.words("times"):
        return act
    if until.kind == "event" and _TOLD.search(until.words("topic").casefold()):
        if act.act in _GOES_ON:
            return replace(act, until=None)
        if act.act == "wait" and not act.words("time"):
            return replace(act, act="stop", until=None)
    if until.kind == "seen" and act.act in ("turn_left", "turn_right", "turn", "turn_around", "look"):
        sought = tuple(role for role in until.roles if role.name in ("thing", "person"))
        if sought and not act.roles and not until.words("place"):
            return Do("find", sought)
    return act


def look(doing: Doing, roles: Roles) -> Calls:
    person, thing = roles.words("person"), roles.words("thing")
    places = roles.all("place") or roles.all("thing")
    if person and not places and not doing.entity(person).me and not anybody(person.casefold()):
        raise Unable("person", person)
    made: Calls = ()
    for words in places:
        made += looked(doing, words, is_thing=words == thing)
    return made or call("seewhat")


def looked(doing: Doing, words: str, *, is_thing: bool = False) -> Calls:
    found = doing.entity(words)
    if found.side:
        return (*turned(found.side), *call("seewhat"))
    if found.room is not None:
        return call("scan_room", found.room)
    if found.me or found.refers:
        return call("seewhat")
    if found.place is not None:
        return (*call("navigation", doing.spot(words)), *call("seewhat"))
    if found.thing is not None or is_thing:
        return (*call("navigate_to_object", doing.thing(words)), *call("seewhat"))
    if any(word in words.casefold() for word in ("around", "about", "room", "surroundings", "四周", "周围", "房间")):
        return call("scan_room")
    raise NowhereKnown(doing.entities.near(words))


def find(doing: Doing, roles: Roles) -> Calls:
    thing, person, place = roles.words("thing"), roles.words("person"), roles.words("place")
    if person and not thing:
        found = doing.entity(person)
        if found.place is not None and not found.me:
            return call("navigation", doing.spot(person))
        if not found.me and not anybody(person.casefold()):
            raise Unable("person", person)
        sought = found.thing or "person"
    elif not thing:
        raise Open("which_thing")
    else:
        found = doing.entity(thing)
        if found.thing is None and found.place is not None:
            return call("navigation", doing.spot(thing))
        sought = doing.thing(thing)
    place = place or source_of(doing, roles, thing)
    going = call("navigation", doing.spot(place)) if place and doing.entity(place).place else ()
    return (*going, *call("locate", sought))


def count(doing: Doing, roles: Roles) -> Calls:
    roles.all("thing"), roles.all("person")
    return looked(doing, roles.words("place")) if roles.words("place") else call("seewhat")


def check(doing: Doing, roles: Roles) -> Calls:
    state, place = roles.words("state"), roles.words("place")
    if place:
        roles.all("thing"), roles.all("person")
        return looked(doing, place)
    words = roles.words("thing") or roles.words("person")
    if not words or state:
        raise Unable("state", state)
    return looked(doing, words)


def describe(doing: Doing, roles: Roles) -> Calls:
    roles.words("topic")
    words = roles.words("place") or roles.words("thing")
    if roles.words("person"):
        raise Unable("act")
    return looked(doing, words, is_thing=words == roles.words("thing")) if words else call("seewhat")


def of_itself(doing: Doing, condition: Condition) -> bool | None:
    """Whether a condition about what the robot holds is met; None for any other condition."""
    said, thing = condition.words("state").casefold(), condition.words("thing")
    who = condition.words("person").casefold()
    if condition.kind == "event" and (topic := _ITSELF_HOLDS.fullmatch(condition.words("topic").casefold())):
        who, said = "you", topic[1] or topic[2]
    if not _ITSELF.fullmatch(who or thing.casefold()) or condition.words("place"):
        return None
    if condition.kind not in ("is", "is_not", "event") or not (_HOLDING.search(said) or _EMPTY.fullmatch(said)):
        return None
    thing = thing if who else ""
    named = thing or _HELD_THING.sub("", said).strip()
    holds = bool(doing.in_hand)
    if _EMPTY.search(said):
        holds = not holds
    elif holds and named and not _ANYTHING.fullmatch(named):
        holds = doing.held(doing.thing(named))
    return holds == (condition.kind != "is_not")


def seen(doing: Doing, condition: Condition) -> tuple[str, Calls]:
    """The thing that a condition is about, and the calls after which it is known whether it is there. Raises the
    exceptions above."""
    thing, person, place = condition.words("thing"), condition.words("person"), condition.words("place")
    if condition.words("times"):
        raise Unable("until")
    if condition.kind in ("is", "is_not"):
        raise Unable("state", condition.words("state"))
    if condition.kind == "event":
        raise Unable("event", condition.words("topic"))
    if person and not anybody(person.casefold()):
        raise Unable("person", person)
    found = doing.entities.of(thing) if thing else None
    at = found.at.words if not place and found is not None and found.at is not None and found.at.known else place
    going = call("navigation", doing.spot(at)) if at else ()
    looked_for = "person" if person else (doing.thing(thing) if thing else "thing")
    return looked_for, (*going, *call("seewhat"))
