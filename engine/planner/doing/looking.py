"""Acts of looking and finding."""

from __future__ import annotations

from engine.planner.doing.doing import Doing, NowhereKnown, Open, Roles, Unable
from engine.planner.doing.handling import source_of
from engine.planner.doing.moving import anybody, turned
from engine.planner.phrases.said import Calls, call


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
