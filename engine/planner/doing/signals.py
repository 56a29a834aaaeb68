"""Acts of the arm, the light and the voice."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Final

from engine.facts import topic_of
from engine.han import is_chinese
from engine.plan import ActionCall, Quantity
from engine.planner import amounts
from engine.planner.doing import people
from engine.planner.doing.doing import MOST, Doing, Open, Roles, Unable
from engine.planner.phrases.said import Calls, call


def just(*names: str) -> Callable[[Doing, Roles], Calls]:
    return lambda doing, roles: tuple(ActionCall(name) for name in names)


def often(name: str) -> Callable[[Doing, Roles], Calls]:
    def often(doing: Doing, roles: Roles) -> Calls:
        roles.words("person")
        return call(name) * _how_often(roles.words("times"))

    return often


def _how_often(words: str) -> int:
    """Once where nothing is said; never more often than any plan may do it."""
    count = amounts.times(words) if words else 1
    if count is None:
        raise Unable("times", words)
    return min(count, MOST)


def arm_turn(doing: Doing, roles: Roles) -> Calls:
    amount, place = roles.words("amount"), roles.words("place")
    side = doing.entity(place).side or _only_side(place) if place else None
    if side in _POINTING:
        return call("servo1_move", Quantity(_POINTING[side], "deg"))
    degrees = amounts.angle(amount)
    if degrees is None:
        raise Open("which_way")
    return call("servo1_move", Quantity(degrees, "deg"))


_POINTING: Final[Mapping[str | None, float]] = {"right": 0.0, "ahead": 90.0, "left": 180.0}
"""deg, of servo 1"""


def _only_side(words: str) -> str | None:
    """The one side that is named in "as far to the left as it goes"; None where there are several."""
    sides = [side for side, pattern in _SIDES if pattern.search(words.casefold())]
    return sides[0] if len(sides) == 1 else None


_SIDES: Final = (
    ("left", re.compile(r"\bleft|左")), ("right", re.compile(r"\bright|右")),
    ("ahead", re.compile(r"\bahead|\bfront|\bstraight|前")),
)  # fmt: skip


def light(doing: Doing, roles: Roles) -> Calls:
    colour = roles.words("colour").casefold()
    if not colour:
        return call("light", "white")
    if _OTHER.search(colour):
        raise Open("which_colour")
    words = re.findall("[a-z]+", colour)  # "coloured" is not red
    plain = next((name for word in words for name in _COLOURS if word.startswith(name)), None) or next(
        (name for said, name in _CHINESE_COLOURS.items() if said in colour), colour
    )
    return call("light", _SAME_COLOUR.get(plain, plain))


_OTHER: Final = re.compile(r"\b(?:other|another|different|else)\b|[别另其]")
"""A colour that is not named."""


def switch(colour: str) -> Callable[[Doing, Roles], Calls]:
    """The robot's own light, switched on or off; it has no other device."""

    def switch(doing: Doing, roles: Roles) -> Calls:
        things = roles.all("thing")
        lit = bool(doing.calls) and any(made.name == "light" for made in doing.calls)
        own = [_LIGHT.search(words.casefold()) or (lit and doing.entity(words).refers) for words in things]
        if not things or not all(own):
            raise Unable("act")
        named = next((shade for words in things for shade in _COLOURS if shade in words.casefold().split()), colour)
        return call("light", named if colour != "off" else colour)

    return switch


_LIGHT: Final = re.compile(r"\b(?:lights?|lamps?|leds?|torch|headlights?)$|灯$")

_COLOURS: Final = (
    "white",
    "red",
    "green",
    "blue",
    "yellow",
    "orange",
    "purple",
    "violet",
    "magenta",
    "pink",
    "cyan",
    "turquoise",
)
_SAME_COLOUR: Final = {"violet": "purple", "magenta": "purple", "turquoise": "cyan"}
_CHINESE_COLOURS: Final = {
    "白": "white", "红": "red", "绿": "green", "蓝": "blue", "黄": "yellow", "橙": "orange", "橘": "orange",
    "紫": "purple", "粉": "pink", "青": "cyan",
}  # fmt: skip


def say(doing: Doing, roles: Roles) -> Calls:
    text, often = roles.words("text"), roles.words("times")
    if not text:
        raise Open("what")
    count = amounts.times(often) if often else 1
    return call("say", text) * min(count or 1, MOST)


def tell(doing: Doing, roles: Roles) -> Calls:
    """Said aloud where the robot is; where this house knows the way to the person, it goes there and says it."""
    person, place, text = roles.words("person"), roles.words("place"), roles.words("text")
    who = doing.entity(person) if person else None
    is_me = who is not None and who.me
    if not text and is_me and any(made.name == "ask_person" for made in doing.calls):
        roles.words("topic")  # "what she says"
        return call("report_answer")
    if not text and who is not None and not is_me and topic_of(roles.act.words("topic")):
        return people.answer(doing, roles)  # the time, the day, something about the robot itself
    if not text and doing.calls and (who is None or is_me) and _HOW_IT_WENT.search(roles.words("topic").casefold()):
        return ()  # what came of it is told in any case
    if not text and _SOMETHING.fullmatch(roles.words("topic").casefold()):
        raise Open("what")
    if not text:
        raise Unable("act")
    if is_me and doing.calls and _IS_DONE.fullmatch(text.casefold()):
        return ()
    if who is not None and who.place is None and not who.me:
        return people.tell(doing, person, place, text)
    going: Calls = call("navigation", doing.spot(place)) if place else ()
    if who is not None and who.place is not None and not who.me:
        going += call("navigation", doing.spot(person))
    return (*going, *call("say", text))


_SOMETHING: Final = re.compile(r"(?:some|any)thing.*|sth|什么|点?事情?|一声|")
_IS_DONE: Final = re.compile(r"(?:(?:you(?:'re| are)?|ur|it's|it is|you've) )?(?:all )?(?:done|finished|ready)")
_HOW_IT_WENT: Final = re.compile(
    r"^$|\bdone\b|\bdid\b|finish|work(?:s|ed)\b|\bw(?:ent|as it)\b|\bthere\b|到了|完|好了|怎么样"
)
"""What somebody wants to be told who asks for word when it is done."""


def greet(doing: Doing, roles: Roles) -> Calls:
    """Somebody who is meant is gone to, and each of several in a room; else it is said before whoever is there."""
    place, words = roles.words("place"), roles.all("person")
    if len(words) == 1 and people.are_several(doing, words[0]) and people.somebody(doing, words[0], place)[1]:
        return people.tell(doing, words[0], place, doing.greeting)
    going = people.before(doing, roles) or ()
    greets = any(made.name == "meet" for made in going)
    return going if greets else (*going, *call("say", _greeting(doing)))


def _greeting(doing: Doing) -> str:
    if (
        wish := re.search(r"\bgood (?:morning|afternoon|evening|night)\b|[早晚]上好|早安|晚安", doing.said, re.I)
    ) is not None:
        return f"{wish[0].capitalize()}{'。' if is_chinese(wish[0]) else '.'}"
    if re.search(r"\bwelcom", doing.said, re.IGNORECASE):
        return "Welcome."
    return "欢迎。" if "欢迎" in doing.said else doing.greeting


def wave(doing: Doing, roles: Roles) -> Calls:
    """Before whoever is meant."""
    times = _how_often(roles.words("times"))
    return (*(people.before(doing, roles) or ()), *call("arm_shake") * times)


def beep(doing: Doing, roles: Roles) -> Calls:
    time, times = roles.words("time"), roles.words("times")
    seconds = amounts.quantity(time or times, "s")
    if seconds is None and time:
        raise Unable("role", time)
    if seconds is None:
        return call("beep") * _how_often(times)
    return call("beep", Quantity(seconds, "s")) * _how_often(times if time else "")


def remember(doing: Doing, roles: Roles) -> Calls:
    """The place where the robot is, by its name where one is said; or the name of a person who is introduced."""
    places, text = roles.all("place"), roles.words("text")
    if (named := _CALLED.match(text.strip())) is not None:
        return call("learn_name", people.as_name(named["name"] or named["zh"]))
    if text and _A_NAME.search(doing.said.casefold()):
        return call("learn_name", people.as_name(text))
    if text:
        return call("remember_place", text)
    for words in places:
        doing.entity(words)
    return call("get_current_pose")


_A_NAME: Final = re.compile(r"\b(?:his|her|their) name\b|[他她]的名字")
_CALLED: Final = re.compile(
    r"(?:(?:his|her|their|my \w+'s) name(?: is|'s)|(?:he|she|they)(?: is|'s| are|'re) called) (?P<name>.+)|"
    r"[他她](?:的名字)?(?:叫|是)(?P<zh>.+)",
    re.IGNORECASE,
)
"""What somebody's name is told with."""
