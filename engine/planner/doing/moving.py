"""Acts that move the base."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Final

from engine.plan import Quantity
from engine.planner import amounts
from engine.planner.conventions import DRIVE_SPEED, FULL, HALF, QUARTER, TURN_SPEED
from engine.planner.doing import people
from engine.planner.doing.doing import MOST, Doing, NowhereKnown, Open, Roles, Unable, is_everywhere
from engine.planner.phrases.said import Calls, call
from engine.skills.places import ZERO_SYMBOL
from engine.skills.vocabulary import ME


def speed_of(roles: Roles) -> tuple[Quantity, ...]:
    words = roles.words("manner")
    if not words:
        return ()
    said = amounts.quantity(words, "m/s")
    if said is not None:
        return (Quantity(said, "m/s"),)
    manner = amounts.manner(words)
    return () if manner is None else (Quantity(DRIVE_SPEED[manner], "m/s"),)


def move(name: str, sign: int) -> Callable[[Doing, Roles], Calls]:
    def move(doing: Doing, roles: Roles) -> Calls:
        amount, time, speed = roles.words("amount"), roles.words("time"), speed_of(roles)
        if not amount and (seconds := amounts.quantity(time, "s")) is not None:
            value = speed[0].value if speed else DRIVE_SPEED[None]
            x, y = (sign * value, 0.0) if name == "move_forward" else (0.0, sign * value)
            return call(
                "set_cmdvel", Quantity(x, "m/s"), Quantity(y, "m/s"), Quantity(0, "rad/s"), Quantity(seconds, "s")
            )
        if time:
            raise Unable("role", time)
        metres = amounts.distance(amount)
        before = doing.calls[-1] if doing.calls else None
        if (
            _AS_MUCH.search(amount.casefold())
            and before is not None
            and before.name in ("move_forward", "move_sideways")
        ):
            first = before.positional[0]
            metres = abs(first.value) if isinstance(first, Quantity) else metres
        if metres is None and any(letter.isdigit() for letter in amount):
            raise Unable("amount", amount[:20])
        if metres is None:
            raise Open("how_far")
        return call(name, Quantity(sign * metres, "m"), *speed)

    return move


_AS_MUCH: Final = re.compile(r"\bsame\b|\bas (?:much|far)\b|同样|一样")
"""As far as before."""


def turn(name: str) -> Callable[[Doing, Roles], Calls]:
    def turn(doing: Doing, roles: Roles) -> Calls:
        amount, time, words = roles.words("amount"), roles.words("time"), roles.words("manner")
        rate = amounts.quantity(words, "rad/s")
        manner = amounts.manner(words)
        value = rate if rate is not None else TURN_SPEED[manner] if manner else None
        if not amount and (seconds := amounts.quantity(time, "s")) is not None:
            turning = (value or TURN_SPEED[None]) * (1 if name == "move_left" else -1)
            return call(
                "set_cmdvel", Quantity(0, "m/s"), Quantity(0, "m/s"), Quantity(turning, "rad/s"), Quantity(seconds, "s")
            )
        if time:
            raise Unable("role", time)
        degrees = amounts.turn(amount) if amount else QUARTER
        if degrees is None:
            raise Open("which_way")
        return call(name, Quantity(degrees, "deg"), *(() if value is None else (Quantity(value, "rad/s"),)))

    return turn


def unspecified(doing: Doing, roles: Roles) -> Calls:
    """A motion whose direction nobody has said."""
    raise Open("which_way")


def turn_to_no_side(doing: Doing, roles: Roles) -> Calls:
    """A turn after which it is the same, to whichever side it went; any other one is asked about."""
    degrees = amounts.angle(roles.words("amount"))
    before = doing.calls[-1].name if doing.calls else ""
    if degrees is not None and before in ("move_left", "move_right") and _ONCE_MORE.search(doing.said.casefold()):
        return call(before, Quantity(degrees, "deg"))
    if degrees is None or degrees % HALF:
        raise Open("which_way")
    return call("move_left", Quantity(degrees, "deg"))


_ONCE_MORE: Final = re.compile(r"\b(?:again|another|same (?:way|direction|side))\b|再|同一个?方向")
"""To the side to which it has turned before."""


def turn_around(doing: Doing, roles: Roles) -> Calls:
    amount, often = roles.words("amount"), roles.words("times")
    degrees = amounts.angle(amount) if amount else FULL if _SPIN.search(doing.said.casefold()) else HALF
    if degrees is None:
        raise Open("which_way")
    if often:
        count = amounts.times(often)
        if count is None:
            raise Unable("times", often)
        degrees = FULL * count
    elif degrees % HALF:  # to either side it would not be the same
        raise Open("which_way")
    return call("move_left", Quantity(degrees, "deg"))


_SPIN: Final = re.compile(
    r"\b(?:spin|twirl|pirouette|(?:full|complete|whole|entire) (?:turn|circle|rotation|revolution|loop))\b|"
    r"转一?个?圈"
)
"""A turn after which the robot faces where it did before."""


def go(doing: Doing, roles: Roles) -> Calls:
    places = (*roles.all("place"), *roles.all("thing"), *roles.all("person"))
    if not places:
        raise Open("where")
    persons, things = roles.all("person"), roles.all("thing")
    return tuple(
        made
        for several in places
        for words in _by_way_of(several)
        for made in _to(doing, words, words if words in persons else "", is_thing=words in things)
    )


def _by_way_of(words: str) -> tuple[str, ...]:
    """A place, after the one on the way to it: "the stool by way of the hall"."""
    found = _VIA.fullmatch(words)
    return (found["by"], found["to"]) if found is not None else (words,)


_VIA: Final = re.compile(r"(?P<to>.+?) (?:via|by way of) (?P<by>.+)", re.IGNORECASE)


def _to(doing: Doing, words: str, person: str = "", *, is_thing: bool = False) -> Calls:
    found = doing.entity(words)
    if is_thing and found.refers and doing.sought:
        return call("navigate_to_object", doing.thing(words))
    if person and found.place is None and found.thing is None and not found.refers:
        return people.found(doing, words)
    if found.side and not found.place:
        raise Open("how_far")
    if found.place is None and found.thing is not None:
        return call("navigate_to_object", doing.thing(words))
    if found.refers and not doing.place and (doing.named or doing.holding):
        return call("navigate_to_object", doing.thing(words))
    return call("navigation", doing.spot(words))


def come(doing: Doing, roles: Roles) -> Calls:
    for words in roles.all("person"):
        if not doing.entity(words).me:
            return people.found(doing, words)
    return call("navigation", ZERO_SYMBOL)


def meet(doing: Doing, roles: Roles) -> Calls:
    """Somebody, or the speaker, who is met where they say."""
    if any(not doing.entity(words).me for words in roles.all("person")):
        return people.meet(doing, roles)
    place = roles.words("place")
    return call("navigation", doing.spot(place) if place else ZERO_SYMBOL)


def go_back(doing: Doing, roles: Roles) -> Calls:
    words = roles.words("place")
    if not words or doing.entity(words).me or _STARTED.search(words.casefold()):
        return call("navigation", ZERO_SYMBOL)
    if doing.entity(words).refers and any(made.name == "get_current_pose" for made in doing.calls):
        return call("navigation", ZERO_SYMBOL)  # "remember where you are, go to the desk and come back to it"
    return charge(doing, roles) if _CHARGING.search(words.casefold()) else call("navigation", doing.spot(words))


_STARTED: Final = re.compile(r"\bwhere\b|start|before|came from|original|previous|出发|原|刚才|之前|来的")
_CHARGING: Final = re.compile(r"charg|dock|充电")


def charge(doing: Doing, roles: Roles) -> Calls:
    words = roles.words("place")
    for name in (words, "charging dock", "dock", "charging station", "home", "充电桩"):
        if name and (place := doing.entities.of(name).place) is not None:
            return call("navigation", place)
    raise NowhereKnown(words or "charging dock")


def face(doing: Doing, roles: Roles) -> Calls:
    for words in (*roles.all("place"), *roles.all("thing"), *roles.all("person")):
        side = doing.entity(words).side or doing.entities.side_in(words)
        if side is None:
            raise Unable("act")
        return turned(side)
    raise Open("which_way")


def turned(side: str) -> Calls:
    if side == "ahead":
        return ()
    return call(
        "move_right" if side == "right" else "move_left", Quantity(HALF if side == "behind" else QUARTER, "deg")
    )


def leave(doing: Doing, roles: Roles) -> Calls:
    """Out of one place into another, which has to be said."""
    places = roles.all("place")
    if len(places) < 2:
        raise Open("where")
    return call("navigation", doing.spot(places[-1]))


def drive_shape(doing: Doing, roles: Roles) -> Calls:
    shape = roles.words("thing").casefold()
    if "square" not in shape and "方" not in shape:
        raise Unable("act")
    metres = amounts.distance(roles.words("amount") or shape)
    if metres is None:
        raise Open("how_far")
    count = amounts.times(roles.words("times")) if roles.words("times") else 1
    corner = call("move_forward", Quantity(metres, "m"), *speed_of(roles)) + call("move_left", Quantity(QUARTER, "deg"))
    return corner * 4 * min(count or 1, MOST)


def follow(doing: Doing, roles: Roles) -> Calls:
    words = roles.words("person") or roles.words("thing")
    plain = words.casefold()
    if _LINE.search(plain):
        return _along(doing, roles, "follow_line")
    if "qr" in plain or "二维码" in plain:
        return call("qr_follow")
    tag = amounts.number(words)
    if tag is not None:
        return call("apriltag_follow", Quantity(tag, ""))
    found = doing.entity(words) if words else None
    if found is not None and found.refers and not doing.who:
        raise Open("which_thing")
    if found is not None and found.thing and found.thing not in ("person",) and not found.me:
        colour = colour_of(doing, found.thing)
        if colour:
            return call("color_follow", colour)
        raise Open("which_colour")
    if found is not None and not found.known and not roles.words("person") and colour_of(doing, plain):
        return call("color_follow", colour_of(doing, plain))
    return people.follow(doing, words or ME, roles.words("place"), roles.words("source"))


_LINE: Final = re.compile(r"line|tape|stripe|线")


def follow_and_clear(doing: Doing, roles: Roles) -> Calls:
    """Along a line, taking away what lies on it."""
    if _LINE.search(roles.words("thing").casefold()) is None:
        raise Unable("act")
    return _along(doing, roles, "follow_line_clear")


def _along(doing: Doing, roles: Roles, skill: str) -> Calls:
    colour, where = colour_of(doing, roles.words("thing").casefold()), roles.words("source") or roles.words("place")
    going = call("navigation", doing.spot(where)) if where and doing.entity(where).place is not None else ()
    return (*going, *(call(skill, colour) if colour else call(skill)))


def anybody(plain: str) -> bool:
    """Whether any person will do, or the one before the robot."""
    return any(word in plain for word in ("person", "human", "body", "someone", "anyone", "people", "man", "人"))


def colour_of(doing: Doing, plain: str) -> str:
    if plain.isascii():
        things = [f"{word} thing" for word in plain.split()]
    else:
        things = [f"{plain[at : at + size]}东西" for at in range(len(plain)) for size in (2, 1)]
    for words in things:
        thing = doing.entities.of(words).thing or ""
        if thing.endswith(" thing"):
            return thing.removesuffix(" thing")
    return ""


def guide(doing: Doing, roles: Roles) -> Calls:
    words, place, source = roles.words("person"), roles.words("place"), roles.words("source")
    return people.guide(doing, words, place, source)


def patrol(doing: Doing, roles: Roles) -> Calls:
    symbols = [
        symbol
        for words in roles.all("place")
        if not (doing.entity(words).every or is_everywhere(words) or doing.entities.rooms_meant(words))
        for symbol in _several(doing, words)
    ]
    return call("patrol", ",".join(symbols)) if symbols else call("patrol")


def _several(doing: Doing, words: str) -> list[str]:
    """The places of "the kitchen and the hall"."""
    if doing.entity(words).place is None:
        for joint in (" and ", "和", "、", "跟", ","):
            if joint in words:
                return [symbol for part in words.split(joint) for symbol in _several(doing, part)]
    return [doing.spot(words)]


def wait(doing: Doing, roles: Roles) -> Calls:
    place, time = roles.words("place"), roles.words("time")
    if place and doing.entity(place).refers:
        place = ""  # where it is, or has just gone to
        if not time and doing.calls and not roles.words("person"):
            return ()
    others = [words for words in roles.all("person") if not doing.entity(words).me]
    if roles.words("person") and not others and not time and not place and doing.calls:
        return ()  # for the speaker, where it has just gone to
    if others and not time and not place:
        if not doing.calls or doing.calls[-1].name != "navigation":
            raise Unable("person", others[0])
        return ()  # the robot stays where it has just gone
    stays = bool(doing.calls) and doing.calls[-1].name == "navigation"
    if stays and not (time or place or roles.words("person")):
        return ()  # where it has just gone to
    seconds = amounts.quantity(time, "s")
    if seconds is None and place and amounts.number(time) is None:
        return call("navigation", doing.spot(place))
    if seconds is None:
        raise Open("how_long")
    return (*(call("navigation", doing.spot(place)) if place else ()), *call("wait", Quantity(seconds, "s")))
