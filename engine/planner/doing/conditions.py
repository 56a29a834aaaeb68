"""What a condition looks at, what the robot knows of itself without a look, and when "until" needs no watching."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

from engine.planner.doing.doing import Doing, Unable
from engine.planner.doing.moving import anybody
from engine.planner.entities import Entities
from engine.planner.phrases.said import Calls, call
from engine.planner.text.counts import Count, at_least, how_many
from engine.understanding.meaning import Condition, Do, If, Node

_TOLD: Final = re.compile(
    r"\b(?:i|we|you(?:'re| are)?|further|told|someone|somebody|he|she|they)\b.*"
    r"\b(?:say|says|said|tell|tells|told|call|calls|shout|stop|stops|whistle|notice|otherwise)|"
    r"further (?:notice|orders|instructions)|otherwise|"
    r"\b(?:i|we)(?:'m| am|'ve| have)? (?:get |got )?(?:bored|tired|fed up|done|had enough|finished|ready)|"
    r"我.*(?:说|叫|喊|让)|叫停|喊停|另行通知"
)
"""The user says so, which ends every action anyway."""
_GOES_ON: Final = frozenset({"follow", "patrol", "dance"})
"""Acts that go on until something ends them."""
_ITSELF: Final = re.compile(r"you(?:rself|'re| are)?|your (?:hands?|gripper|claw|arm)|你(?:自己|手里|手上|手)?|机器人")
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
    elif condition.kind not in ("is", "is_not"):
        return None
    if not who:  # "your hand is empty"
        who, thing = (condition.words("place") or thing).casefold(), ""
    elif condition.words("place"):
        return None
    if not _ITSELF.fullmatch(who) or not (_HOLDING.search(state) or _EMPTY.fullmatch(state)):
        return None
    return state, thing or _HELD_THING.sub("", state).strip()


def looked_for_once(nodes: Sequence[Node], entities: Entities) -> tuple[Node, ...]:
    """The nodes without a search that the condition behind it makes anyway: "look for the ball in the hall, and if it's
    there dance"."""
    made: list[Node] = []
    for node in nodes:
        last = made[-1] if made else None
        if isinstance(node, If) and isinstance(last, Do) and last.act in _LOOKS and _about_it(last, node, entities):
            taken = [role for role in last.roles if role.name in ("thing", "person", "place")]
            kept = [role for role in node.condition.roles if not entities.of(role.words).refers]
            names = {role.name for role in kept}
            roles = (*(role for role in taken if role.name not in names), *kept)
            made[-1] = replace(node, condition=replace(node.condition, roles=roles))
        else:
            made.append(node)
    return tuple(made)


_LOOKS: Final = frozenset({"find", "look", "check"})


def _about_it(search: Do, node: If, entities: Entities) -> bool:
    """Whether a condition is about what was searched for, or lies where it was looked."""
    thing, place = node.condition.words("thing"), node.condition.words("place")
    if search.words("thing"):
        same = entities.of(thing).thing == entities.of(search.words("thing")).thing
        return bool(thing) and (entities.of(thing).refers or same)
    return not place or entities.of(place).refers


def with_antecedent(node: If, entities: Entities) -> Condition:
    """The condition with the thing that "it" is in it, where that is only named in what depends on it: "pick up the cup
    only if it is on the desk"."""
    condition = node.condition
    if not entities.of(condition.words("thing") or "?").refers:
        return condition
    acts = (act for act in (*node.then, *node.otherwise) if isinstance(act, Do))
    named = next((words for act in acts for words in act.all("thing") if not entities.of(words).refers), None)
    if named is None:
        return condition
    roles = (replace(role, words=named) if role.name == "thing" else role for role in condition.roles)
    return replace(condition, roles=tuple(roles))


@dataclass(frozen=True, slots=True)
class Sought:
    """What a condition looks for."""

    thing: str
    """As skills know it; ``thing`` is anything, ``person`` anybody."""
    there: bool
    """Whether it holds where that is there."""
    look: Calls
    """The calls after which it is known."""
    count: Count | None = None
    names: tuple[str, ...] = ()
    """Of the things that are counted."""

    def holds(self, sees: Callable[[str], bool]) -> bool:
        """Whether the condition is met; ``sees`` tells whether something was seen."""
        found = sees(self.thing) if self.count is None else self.count.holds(self.names, sees)
        return found == self.there


def sought(doing: Doing, condition: Condition) -> Sought:
    """What a condition looks for, and how it finds out. Raises the exceptions of ``doing.py``."""
    condition = as_seen(condition, doing.entities)
    thing, person, place = condition.words("thing"), condition.words("person"), condition.words("place")
    if condition.words("times"):
        raise Unable("until")
    if condition.kind in ("is", "is_not"):
        raise Unable("state", condition.words("state"))
    if condition.kind == "event":
        raise Unable("event", condition.words("topic"))
    if person and not anybody(person.casefold()):
        raise Unable("person", person)
    many = how_many(thing) if thing else None
    if many is not None:
        thing = many[0]
    found = doing.entities.of(thing) if thing else None
    at = found.at.words if not place and found is not None and found.at is not None and found.at.known else place
    is_there = bool(at) and bool(doing.calls) and doing.entities.of(at).refers
    going = call("navigation", doing.spot(at)) if at and not is_there else ()
    look = (*going, *call("seewhat"))
    there = condition.kind == "seen"
    if len(several := condition.all("thing")) > 1:  # "if both … are there", "if neither … is"
        names = tuple(doing.thing(words) for words in several)
        return Sought(thing, there, look, at_least(len(names) if there else 1), names)
    if many is None:
        looked_for = "person" if person else (doing.thing(thing) if thing else "thing")
        return Sought(looked_for, there, look)
    names = doing.entities.members(found) if found is not None else ()
    if len(names) < 2:
        raise Unable("count", thing)
    return Sought(thing, there, look, many[1], names)


def as_seen(condition: Condition, entities: Entities) -> Condition:
    """A condition on a state that is one of being there: "if the cup is on the desk", "if the desk is empty"."""
    if condition.kind not in ("is", "is_not"):
        return condition
    state, positive = condition.words("state").casefold(), condition.kind == "is"
    others = tuple(role for role in condition.roles if role.name != "state")
    where = entities.of(state)
    if _THERE.fullmatch(state) or _GONE.fullmatch(state):
        return Condition("seen" if positive == (_THERE.fullmatch(state) is not None) else "unseen", others)
    if condition.words("place") == "" and (where.place or where.room or where.surface):
        place = next(role for role in condition.roles if role.name == "state")
        return Condition("seen" if positive else "unseen", (*others, replace(place, name="place")))
    thing = condition.words("thing")
    empty = _EMPTY.fullmatch(state) is not None or state in ("clear", "bare", "vacant", "unoccupied")
    if empty and (spot := entities.of(thing or condition.words("place"))) and (spot.place or spot.room):
        roles = tuple(replace(role, name="place") for role in others if role.name in ("thing", "place"))
        return Condition("unseen" if positive else "seen", roles[:1])
    return condition


_THERE: Final = re.compile(
    r"(?:still |already )?(?:there|here|present|visible|around|available|in (?:sight|view))|"
    r"还?在(?:那儿?|那里|这儿?|这里)?"
)
_GONE: Final = re.compile(r"missing|gone|absent|away|nowhere(?: to be (?:seen|found))?|not there|不在了?|不见了?|没了")
