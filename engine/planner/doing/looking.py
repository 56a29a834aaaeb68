"""Acts of looking, finding and following what is seen, and what a condition looks at."""

from __future__ import annotations

from engine.planner.doing.doing import Doing, NowhereKnown, Open, Roles, Unable
from engine.planner.doing.handling import source_of
from engine.planner.doing.moving import anybody, turned
from engine.planner.phrases.said import Calls, call
from engine.understanding.meaning import Condition


def look(doing: Doing, roles: Roles) -> Calls:
    person, thing = roles.words("person"), roles.words("thing")
    words = roles.words("place") or thing
    if person and not words and not doing.entity(person).me and not anybody(person.casefold()):
        raise Unable("person", person)
    if not words:
        return call("seewhat")
    return looked(doing, words, is_thing=words == thing)


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
    roles.words("thing"), roles.words("person")
    return looked(doing, roles.words("place")) if roles.words("place") else call("seewhat")


def check(doing: Doing, roles: Roles) -> Calls:
    state, place = roles.words("state"), roles.words("place")
    if place:
        roles.words("thing"), roles.words("person")
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


def seen(doing: Doing, condition: Condition) -> tuple[str, Calls]:
    """The thing that a condition is about, and the calls after which it is known whether it is there. Raises the
    exceptions above."""
    thing, person, place = condition.words("thing"), condition.words("person"), condition.words("place")
    if condition.kind not in ("seen", "unseen"):
        raise Unable("condition")
    if person and not anybody(person.casefold()):
        raise Unable("person", person)
    found = doing.entities.of(thing) if thing else None
    at = found.at.words if not place and found is not None and found.at is not None and found.at.known else place
    going = call("navigation", doing.spot(at)) if at else ()
    looked_for = "person" if person else (doing.thing(thing) if thing else "thing")
    return looked_for, (*going, *call("seewhat"))
