"""Acts on things: picking up, putting, bringing, tidying."""

from __future__ import annotations

import re
from typing import Final

from engine.han import is_chinese
from engine.perception.naming import is_choice
from engine.plan import Quantity
from engine.planner import amounts
from engine.planner.doing import people
from engine.planner.doing.doing import Doing, NowhereKnown, Open, Roles, Unable, is_everywhere, is_this_room
from engine.planner.doing.moving import colour_of
from engine.planner.phrases.said import Calls, call
from engine.skills.places import ZERO_SYMBOL
from engine.skills.vocabulary import BIN, FLOOR
from engine.understanding.meaning import Do


def source_of(doing: Doing, roles: Roles, thing: str) -> str:
    """Where the thing is said to be, in the speaker's words."""
    words = roles.words("source")
    if words:
        return words
    at = doing.entities.of(thing).at if thing else None
    return at.words if at is not None and (at.place or at.surface or at.room) else ""


def fetched(doing: Doing, words: str, source: str) -> Calls:
    """Go where it is said to be, and pick it up, unless it is held."""
    thing = doing.thing_from(words, source)
    if doing.held(thing):
        return ()
    down: Calls = ()
    if doing.in_hand:
        if not doing.instead_of or not doing.entities.may_be(doing.instead_of, doing.in_hand):
            raise Unable("full", doing.in_hand)
        down = call("putdown")  # "I meant the blue one"
    going = call("navigation", doing.spot(source)) if source and doing.entity(source).place else ()
    return (*down, *going, *call("pick_object", thing))


def pick_up(doing: Doing, roles: Roles) -> Calls:
    things = roles.all("thing") or _it(doing)
    if len(things) > 1:
        raise Unable("full", things[0])
    if _is_rubbish(doing, things[0]):  # nobody wants to have it
        return throw_away(doing, roles)
    if (given := _GIVEN.fullmatch(" ".join(things[0].split()))) is not None:
        return people.take(doing, "", given["who"] or given["zh"])
    source = source_of(doing, roles, things[0])
    if source and _is_somebody(doing, source):
        return people.take(doing, doing.thing(things[0]), source)
    return fetched(doing, things[0], source)


_GIVEN: Final = re.compile(
    r"(?:what(?:ever)?|everything|anything|the (?:thing|things|one)) (?:that |which )?(?P<who>[\w' -]+?) "
    r"(?:gives|hands|passes|give|is giving|is going to give|will give|wants to give)(?: to)?(?: you)?(?: to you)?|"
    r"(?P<zh>.{1,6}?)(?:递|交|拿|送)?给你的(?:东西)?",
    re.IGNORECASE,
)
"""What a person gives to the robot."""


def _is_somebody(doing: Doing, words: str) -> bool:
    """Whether a thing is to be had from a person: somebody known, or a name that is no place here."""
    found = doing.entities.of(words)
    if any((found.place, found.surface, found.room, found.refers, found.me)):
        return False
    return doing.entities.is_known(words) or (words[:1].isupper() and doing.entities.is_name(words))


def _it(doing: Doing) -> tuple[str, ...]:
    """What is meant where no thing is said: the one that was named last."""
    if not doing.named:
        raise Open("which_thing")
    return ("it",)


_ITS_TRAY: Final = re.compile(r"(?:(?:into|in|on) )?its (?:own )?tray|[它其]的?托盘里?")
_TRAY: Final = re.compile(
    r"(?:(?:into|in|on) )?(?:its|the|the right|the proper) (?:own )?(?:tray|box|place)|[它的对应]*(?:托盘|盘子)里?"
)
"""Where a block is sorted into, which its tag decides."""


def put(doing: Doing, roles: Roles) -> Calls:
    block = doing.entity(roles.words("thing") or "it").thing or doing.named
    if _ITS_TRAY.fullmatch(roles.words("place").casefold()) and amounts.number(block or "") is not None:
        return sort(doing, roles)
    things, place, source = roles.all("thing"), roles.words("place"), roles.words("source")
    unnamed = all(doing.entity(words).refers for words in things) and not (doing.named or doing.holding)
    if not place and unnamed:
        return call("putdown")
    made: Calls = ()
    for words in things or ("it",):
        if (doing.entity(words).refers or not things) and doing.in_hand and not made:
            doing.named = doing.in_hand
        elif not things and not (doing.named or doing.holding):
            raise Open("which_thing")
        before = doing.calls
        done = _put_one(doing, words, place, source)
        doing.calls = [*before, *done]
        made += done
        doing.calls = before
    return made


def push(doing: Doing, roles: Roles) -> Calls:
    """To a place it is carried: "move it to the sofa"."""
    things, place = roles.all("thing"), roles.words("place")
    if things and (not place or _AWAY.search(place.casefold())) and doing.entity(things[0]).refers:
        raise Open("where_put")
    if not (things and place):
        raise Unable("act")
    return put(doing, roles)


_AWAY: Final = re.compile(r"\bout of\b|\baway\b|\baside\b|\bway\b")
"""Anywhere else."""
_BESIDE: Final = re.compile(
    r"^(?:next to|beside|by|near|close to|in front of|behind|under|underneath|against|at|over by|around|"
    r"to the \w+ of)\b|"
    r"(?:旁边?|边上|附近|前面?|后面?|下面?|底下|跟前)$"
)
"""Words for a place at a piece of furniture that is not on it."""
_AT_A_THING: Final = re.compile(
    r"^(?:(?:to )?where(?:ver)? |next to |beside |by |near |close to |in front of |behind |with )|"
    r" (?:is|are|lies|stands|sits)(?: now)?$|(?:旁边?|边上|附近|那里|那儿)$",
    re.IGNORECASE,
)
"""What says that a place is that of another thing: "where the blue cup is"."""
_WHERE_IT_BELONGS: Final = re.compile(r"\b(?:its|their)\b.*\b(?:place|spot|home|position)|\bbelongs?\b|该[在放]|原位")


def _put_one(doing: Doing, words: str, place: str, source: str) -> Calls:
    if not place:
        return (*fetched(doing, words, source), *call("putdown"))
    target = doing.where(place)
    if target.every:
        raise Unable("role", place)
    if target.surface == FLOOR and target.room is None and target.at is not None and target.at.place is not None:
        return carried(doing, words, target.at.place, source)  # "on the floor by the bed"
    group = doing.entity(words)
    colour = colour_of(doing, group.thing or words.casefold())
    if group.every and not group.refers:
        if not colour or target.surface is None:
            raise Unable("every", words)
        return call("tidy", colour, target.surface)
    if target.place is not None:
        doing.place = target.place
    beside = _BESIDE.search(place.casefold()) is not None or (target.room is not None and target.surface == FLOOR)
    surface = None if target.place is not None and beside else target.surface
    if surface is not None and surface != target.room:
        put = call("place_in_bin") if surface == BIN else call("place_object", surface)
        return (*fetched(doing, words, source or source_of(doing, Roles(Do("put")), words)), *put)
    if target.me or target.place is not None:
        if doing.held(doing.thing(words)):
            return (*call("navigation", target.place or ZERO_SYMBOL), *call("putdown"))
        return carried(doing, words, target.place or ZERO_SYMBOL, source)
    if _WHERE_IT_BELONGS.search(place.casefold()) and _numbered(words):
        return call("apriltag_sort", Quantity(amounts.number(words) or 0, ""))
    if (other := doing.entities.of(_AT_A_THING.sub("", place)).thing) and not is_rubbish(other):
        made = fetched(doing, words, source)
        return (*made, *call("navigate_to_object", other), *call("putdown"))
    if target.refers or target.side or place.casefold() in ("down", "away", "aside"):
        if target.refers or target.side == "ahead":
            return (*fetched(doing, words, source), *call("putdown"))
        raise Open("where_put")
    raise NowhereKnown(doing.entities.near(place))


def carried(doing: Doing, words: str, place: str, source: str) -> Calls:
    thing = doing.thing_from(words, source)
    if doing.held(thing):
        return (*call("navigation", place), *call("putdown"))
    if doing.in_hand:
        raise Unable("full", doing.in_hand)
    at = doing.where(source) if source else doing.entities.of(words).at
    where = (at.surface or at.room) if at is not None else None
    if source and where is None and not doing.entity(source).refers:
        raise NowhereKnown(doing.entities.near(source))
    if at is not None and at.place is not None and is_choice(thing):  # chosen among what is there
        return (*call("navigation", at.place), *call("carry", thing, place))
    return call("carry", thing, place, *((where,) if where else ()))


def bring(doing: Doing, roles: Roles) -> Calls:
    person, things = roles.words("person"), roles.all("thing")
    if person and not things and not doing.entity(person).me and not (doing.named and doing.depends):
        return people.meet(doing, roles)  # "fetch Oliver at the exit"
    things, source, place = things or _it(doing), roles.words("source"), roles.words("place")
    if source and _WHERE_IT_WAS.fullmatch(place.casefold()):  # "back where it was, the coffee table"
        place, source = source, ""
    goal = ZERO_SYMBOL
    if person and not (place and _FOR_SOMEBODY.search(doing.said)):
        who = doing.entity(person)
        if who.every and who.person:
            return _served(doing, things, person, place)
        if not who.me and who.place is None:
            return _brought(doing, things, source, person, place)
        goal = who.place or ZERO_SYMBOL
    elif place:
        where = doing.entity(place)
        if where.place is None and where.surface is not None:
            return put(doing, roles)
        goal = doing.spot(place)
    made: Calls = ()
    for words in things:
        if doing.entity(words).refers and doing.in_hand and not made:
            doing.named = doing.in_hand
        made += carried(doing, words, goal, source)
    return made


_FOR_SOMEBODY: Final = re.compile(r"[帮替]我们?")
"""For whom something is done, who need not get it: "帮我把球送到书房"."""
_WHERE_IT_WAS: Final = re.compile(
    r"(?:back )?(?:to )?(?:where (?:it|they) (?:was|were|came from|belongs?)(?: before)?|"
    r"(?:its|the|their) (?:old |original )?(?:place|spot))|原处|原来的(?:地方|位置)"
)


def _served(doing: Doing, things: tuple[str, ...], person: str, place: str) -> Calls:
    """One of these for each of them: "drinks to everyone in the kitchen"."""
    if len(things) > 1:
        raise Unable("full", things[0])
    kind = doing.entities.several(things[0])[0] or doing.thing(things[0])
    who, there = people.somebody(doing, person, place)
    return call("serve", kind, who, *((there,) if there else ()))


def _brought(doing: Doing, things: tuple[str, ...], source: str, person: str, place: str) -> Calls:
    """One thing, into somebody's hand."""
    if len(things) > 1:
        raise Unable("full", things[0])
    made = fetched(doing, things[0], source or source_of(doing, Roles(Do("bring")), things[0]))
    return (*made, *people.hand(doing, person, place))


def drop(doing: Doing, roles: Roles) -> Calls:
    for words in roles.all("thing"):
        doing.thing(words)
    return call("open_gripper")


def throw_away(doing: Doing, roles: Roles) -> Calls:
    things, source = roles.all("thing"), roles.words("source")
    if source and doing.entity(source).surface == BIN:  # "into the bin"
        source = ""
    if len(things) == 1 and (_is_rubbish(doing, things[0]) or _LYING_ABOUT.fullmatch(things[0].casefold())):
        where = source or source_of(doing, roles, things[0])
        doing.named = "rubbish"
        cleans = cleaned(doing.entity(where).room) if where else call("clear_rubbish")
        return () if cleans == tuple(doing.calls[-1:]) else cleans  # "pick up the litter and throw it out"
    if not things:
        if doing.in_hand:
            return call("place_in_bin")
        things = _it(doing)
    made: Calls = ()
    for words in things:
        if doing.entity(words).refers and doing.in_hand and not made:
            doing.named = doing.in_hand
            made += call("place_in_bin")
        elif doing.entity(words).every and (colour := colour_of(doing, doing.entity(words).thing or "")):
            made += call("tidy", colour, BIN)
        else:
            made += (*fetched(doing, words, source or source_of(doing, roles, words)), *call("place_in_bin"))
    return made


_LYING_ABOUT: Final = re.compile(
    r"(?:everything|anything|whatever|all(?: the)?(?: things| stuff)?)(?: that| which)?(?:'s| is| are)? "
    r"(?:(?:lying|left|strewn|scattered)(?: about| around)?|on the (?:floor|ground))(?: (?:in|on) .*)?|"
    r"(?:地上|散落)的?(?:所有)?(?:东西|玩意儿?)"
)
"""All that is on a floor."""
_RUBBISH: Final = re.compile(
    r"(?:(?:all|all of|the|this|that|your|my|our|any|some) )*(?:rubbish|trash|garbage|litter|waste|debris|junk|refuse)"
    r"(?: (?:in|from|on|off|of|that|which|lying|left) .*)?|"
    r"(?:这些|那些|所有的?|地上的?|满地的?|到处的?|乱七八糟的?|里的?)*(?:垃圾|废物)"
)
"""What lies about and nobody wants."""


_RUBBISH_WORD: Final = re.compile(r"\b(?:rubbish|trash|garbage|litter|debris|junk)\b|垃圾|废物")


def rubbish_in(text: str) -> str:
    """The word for rubbish in a text; empty where there is none."""
    found = _RUBBISH_WORD.search(text.casefold())
    return found[0] if found is not None else ""


def is_rubbish(words: str) -> bool:
    """Whether these words are for what lies about and nobody wants."""
    return _RUBBISH.fullmatch(words.casefold()) is not None


def _is_rubbish(doing: Doing, words: str) -> bool:
    """Whether that is what lies about, and not a thing here that is called so."""
    found = doing.entity(words)
    return (found.refers and is_rubbish(doing.named)) or (is_rubbish(words) and found.thing is None)


def tidy(doing: Doing, roles: Roles) -> Calls:
    thing, place, source = roles.words("thing"), roles.words("place"), roles.words("source")
    if thing and not place and _is_rubbish(doing, thing):
        return throw_away(doing, roles)
    if thing and not place and (height := _taller_than(thing)) is not None:
        colour = colour_of(doing, thing.casefold())
        return call("color_remove_higher", colour, height) if colour else call("apriltag_remove_higher", height)
    if thing and not place and _numbered(thing):
        return sort(doing, roles)
    named = thing if doing.named else ""
    if not named and not (thing and place) and (there := _meant_room(doing, thing or place)) is not None:
        return cleaned(there)
    room = doing.entity(thing or place or source)
    if (room.room or is_everywhere(thing or place) or is_this_room(thing or place)) and not (thing and place):
        return cleaned(room.room)
    colour = colour_of(doing, doing.entity(thing).thing or "") if thing else ""
    if thing and place and colour and _is_several(doing, thing):
        surface = doing.entity(place).surface
        if surface is None:
            raise NowhereKnown(doing.entities.near(place))
        return call("tidy", colour, surface)
    if thing and place:
        return put(doing, roles)
    if not thing and not place and not source:
        return call("clean_room")
    raise Open("where_put")


def _meant_room(doing: Doing, words: str) -> str | None:
    """The room that "it" is: "if nobody is in the hall, tidy it up"."""
    return doing.where(words).room if words and doing.entity(words).refers else None


def _is_several(doing: Doing, words: str) -> bool:
    """Whether all of a kind are meant, or may be: "red things", 蓝色的东西."""
    plain = words.casefold().rstrip()
    return doing.entity(words).every or plain.endswith(("s", "东西", "玩意儿"))


_TALLER: Final = re.compile(r"(?:tall|high|more|above|over|exceed|upwards?|bigger).*|[高超]")


def _taller_than(words: str) -> Quantity | None:
    """The height of "blocks taller than 4 cm"."""
    plain = words.casefold()
    found = _TALLER.search(plain)
    metres = amounts.quantity(plain if is_chinese(plain) else plain[found.start() :], "m") if found else None
    return Quantity(metres, "m") if metres is not None else None


def _numbered(words: str) -> bool:
    """Whether it is one block with a number."""
    return (
        amounts.number(words) is not None and re.search(r"block|cube|tag|marker|方块|积木|标签|号", words) is not None
    )


def clean(doing: Doing, roles: Roles) -> Calls:
    made: Calls = ()
    for words in roles.all("place") or roles.all("thing"):
        found = doing.where(words)
        if found.room is None and not (found.refers or is_everywhere(words) or is_this_room(words)):
            raise Unable("act")
        made += cleaned(found.room)
    return made or call("clean_room")


def cleaned(room: str | None) -> Calls:
    """Clean a room; None: the one that the robot is in."""
    return call("clean_room", room) if room else call("clean_room")


_SORTS_OUT: Final = re.compile(r"\bsort (?:it|this|that|everything) out\b")
"""To tidy up."""


def sort(doing: Doing, roles: Roles) -> Calls:
    words = roles.words("thing")
    if words and doing.entity(words).refers and _SORTS_OUT.search(doing.said.casefold()) and not doing.named:
        room = doing.entities.of(doing.entities.place_in(doing.said)).room
        return cleaned(room)
    if (place := roles.words("place")) and not _TRAY.fullmatch(place.casefold()):
        raise Unable("role", place)
    tag = amounts.number(doing.thing(words) if words and doing.entity(words).refers else words)
    if tag is None:
        raise Open("which_tag")
    return call("apriltag_sort", Quantity(tag, ""))
