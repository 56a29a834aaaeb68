"""What a condition looks at, what the robot knows of itself without a look, and when "until" needs no watching."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Final

from engine.planner.doing.doing import Doing, Unable
from engine.planner.doing.moving import anybody
from engine.planner.phrases.said import Calls, call
from engine.understanding.meaning import Condition, Do

_TOLD: Final = re.compile(
    r"\b(?:i|we|you(?:'re| are)?|further|told|someone|somebody|he|she|they)\b.*"
    r"\b(?:say|says|said|tell|tells|told|call|calls|shout|stop|stops|whistle|notice|otherwise)|"
    r"further notice|otherwise|我.*(?:说|叫|喊|让)|叫停|喊停|另行通知"
)
"""The user says so, which ends every action anyway."""
_GOES_ON: Final = frozenset({"follow", "patrol", "dance"})
"""Acts that go on until something ends them."""
_ITSELF: Final = re.compile(r"you(?:rself)?|your (?:hands?|gripper|claw|arm)|你(?:自己|手里|手上|手)?|机器人")
_ITSELF_HOLDS: Final = re.compile(
    r"(?:you|you're|you are|you've|you have) (?:already |still )?((?:got |hold|carry|grip).*)|"
    r"你(?:手里|手上)?((?:拿|抓|夹).*)"
)
"""That it holds something, told as an event."""
_EMPTY: Final = re.compile(r"empty|free|nothing|空|没")
_HOLDING: Final = re.compile(r"hold|carry|grip|got|in your (?:hand|grip)|拿|抓|夹|空手|手里|empty[- ]?handed")
_HELD_THING: Final = re.compile(r".*?(?:holding|carrying|hold|carry|got)|in your (?:hands?|gripper|grip)|[拿抓夹]着?")
"""What stands before the name of the thing in such a state."""
_ANYTHING: Final = re.compile(r"(?:any|some|no)thing.*|things?|stuff|(?:什么|任何)?东西|什么|空|.*handed")


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


def of_itself(doing: Doing, condition: Condition) -> bool | None:
    """Whether a condition about what the robot holds is met; None for any other condition."""
    found = _about_its_hand(condition)
    if found is None:
        return None
    state, thing = found
    if _EMPTY.search(state):
        met = not doing.in_hand
    elif not doing.in_hand or not thing or _ANYTHING.fullmatch(thing):
        met = bool(doing.in_hand)
    else:
        met = doing.held(doing.thing(thing))
    return met == (condition.kind != "is_not")


def _about_its_hand(condition: Condition) -> tuple[str, str] | None:
    """The state of its hand that a condition is about, and the thing that is named; None where it is about none."""
    who, thing = condition.words("person").casefold(), condition.words("thing")
    state = condition.words("state").casefold()
    if condition.kind == "event":
        told = _ITSELF_HOLDS.fullmatch(condition.words("topic").casefold())
        who, state = ("you", told[1] or told[2]) if told is not None else ("", "")
    elif condition.kind not in ("is", "is_not") or condition.words("place"):
        return None
    if not who:  # "your hand is empty"
        who, thing = thing.casefold(), ""
    if not _ITSELF.fullmatch(who) or not (_HOLDING.search(state) or _EMPTY.fullmatch(state)):
        return None
    return state, thing or _HELD_THING.sub("", state).strip()


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
