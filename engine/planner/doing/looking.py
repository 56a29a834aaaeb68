"""Acts of looking and finding."""

from __future__ import annotations

import re
from typing import Final

from engine.han import is_chinese
from engine.perception.naming import is_choice
from engine.plan import Quantity
from engine.planner.doing import people
from engine.planner.doing.doing import WHERE_IT_IS, Doing, NowhereKnown, Open, Roles, Unable, is_floor
from engine.planner.doing.handling import is_rubbish, source_of
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
    if WHERE_IT_IS.fullmatch(words.casefold().strip()):
        return call("seewhat")
    found = doing.entity(words)
    if found.side:
        return (*turned(found.side), *call("seewhat"))
    if found.room is not None:
        return call("scan_room", found.room)
    if found.refers and not (doing.place or doing.named or doing.calls or is_thing):
        raise Open("where")
    if found.me or found.refers or (found.room is None and is_floor(words)):
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
    if not thing and not person and doing.sought:
        thing = "it"
    if person and not thing:
        found = doing.entity(person)
        if found.place is not None and not found.me:
            return call("navigation", doing.spot(person))
        if not found.me:
            return people.find(doing, roles)
        sought = found.thing or "person"
    elif not thing:
        raise Open("which_thing")
    elif _ANYTHING.fullmatch(thing.casefold()) or is_rubbish(thing):  # what there is
        return looked(doing, place) if place else call("seewhat")
    elif place and doing.entities.several(thing)[1] > 1 and (listed := _listed(doing, thing, place)):
        return listed  # "find three snacks in the kitchen"
    else:
        found = doing.entity(thing)
        if found.thing is None and found.place is not None:
            return call("navigation", doing.spot(thing))
        sought = doing.thing(thing)
    place = place or source_of(doing, roles, thing)
    for other in roles.all("place")[1:]:  # through all rooms it goes anyway: the first one of these comes first
        doing.spot(other)
    going = call("navigation", doing.spot(place)) if place and doing.entity(place).place else ()
    return (*going, *call("locate", sought))


_ANYTHING: Final = re.compile(r"(?:any|some|every)thing|what|什么|啥|东西|什么东西")


def count(doing: Doing, roles: Roles) -> Calls:
    if roles.words("person") and not roles.words("thing"):
        return people.count(doing, roles)
    things, places = roles.words("thing"), roles.words("place")
    roles.all("thing"), roles.all("person")
    if listed := _listed(doing, things, places):
        return listed
    return looked(doing, places) if places else call("seewhat")


def _listed(doing: Doing, things: str, place: str) -> Calls:
    """All things of a kind, or the biggest of them, at a place; nothing where the words are no kind of thing, or the
    place is none to look at."""
    kind, many = doing.entities.several(things) if things else ("", 0)
    where = doing.where(place) if place else None
    spot = (where.room or where.surface) if where is not None else ""
    if not kind or spot is None or (where is not None and (where.me or where.refers or where.side)):
        return ()
    most = (Quantity(many, ""),) if many > 1 and is_choice(kind) else ()
    return call("list_things", kind, *((spot, *most) if spot else ()))


def check(doing: Doing, roles: Roles) -> Calls:
    state, places = roles.words("state"), roles.all("place")
    if places:
        roles.all("thing"), roles.all("person")
        return tuple(made for place in places for made in looked(doing, place))
    words = roles.words("thing") or roles.words("person")
    if not words or state:
        raise Unable("state", state)
    return looked(doing, words)


def describe(doing: Doing, roles: Roles) -> Calls:
    if roles.words("person"):
        return people.describe(doing, roles)
    roles.words("topic")
    thing, place = roles.words("thing"), roles.words("place")
    if thing and (listed := _listed(doing, thing, place)) and (place or is_choice(str(listed[0].positional[0]))):
        return listed
    words = place or thing
    return looked(doing, words, is_thing=words == roles.words("thing")) if words else call("seewhat")


def report(doing: Doing, roles: Roles) -> Calls:
    """Where it is, what it can do, or what is to be seen there; other questions about itself are no actions."""
    topic = roles.words("topic")
    kind = topic_of(topic)
    asked = any(made.name == "ask_person" for made in doing.calls)
    if asked and kind in ("", "done"):
        return call("report_answer")
    if kind == "report_pose" and doing.calls and doing.calls[-1].name == "locate" and _WHERE_THAT_IS.search(topic):
        return ()  # what is looked for is told of
    if doing.calls and _WHEN_DONE.search(topic):
        return call("say", "完成了。" if is_chinese(doing.said) else "Done.")
    if kind in ("done", "stopped") and doing.calls:
        return ()  # what came of it is told in any case
    if kind in ("report_pose", "list_skills"):
        return call(kind)
    if kind not in ("", "seewhat"):
        raise Unable("act")
    looked = bool(doing.calls) and doing.calls[-1].name in _LOOKING
    return () if looked else call("seewhat")


_WHEN_DONE: Final = re.compile(
    r"\b(?:when|once|as soon as|after)\b.*\b(?:done|finished|ready|over|complete)|(?:做完|完成|弄好|放好)了?",
    re.IGNORECASE,
)
_WHERE_THAT_IS: Final = re.compile(
    r"\b(?:where(?:abouts)?|(?:which|what) room) (?:it|they|he|she|that)(?:'s|'re)?\b|(?:它|[他她])在?哪", re.IGNORECASE
)
_LOOKING: Final = frozenset({"seewhat", "scan_room", "locate"})
"""Actions that tell what they see."""
_TOPICS: Final = (
    ("holding", re.compile(r"\bh(?:o|e)ld|\bgrip|\bcarry|in your hand|拿着|手里|抓着")),
    ("battery", re.compile(r"batter|charge|power|juice|电")),
    ("stopped", re.compile(r"\bwhy\b|\bstop|wrong|fail|为什么|怎么停|出错|问题")),
    (
        "places",
        re.compile(r"\b(?:which|what|all the) (?:\w+ )?(?:rooms|places)\b(?!.*\bsee)|(?:哪些|什么|几个)(?:地方|房间)"),
    ),
    ("seewhat", re.compile(r"\bsee(?:s|ing)?\b|\blook|camera|in view|看|镜头")),
    ("report_pose", re.compile(r"\bwhere|position|location|coordinates?|room|standing|哪|位置|坐标")),
    ("list_skills", re.compile(r"\bable\b|can you do|abilit|skill|会做|本事|功能")),
    ("done", re.compile(r"\bd(?:o|id|one|oing)\b|\baction|\brecent|\bup to\b|\blast\b|finish|刚才|做了|干了|完成")),
)
"""What a question to the robot about itself is about, in the order in which it is tried."""


def topic_of(words: str) -> str:
    """What a question to the robot about itself is about: an action, or what is on record; empty for anything else."""
    about = words.casefold()
    return next((name for name, pattern in _TOPICS if pattern.search(about)), "")
