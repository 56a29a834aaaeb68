"""When a condition needs no look or no watching, and which other nodes it takes something from."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from engine.planner.doing.doing import Doing
from engine.planner.entities import Entities
from engine.understanding.acts import RoleName
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
_ITSELF: Final = re.compile(
    r"you(?:rself|'re| are|'ve| have)?|your (?:hands?|gripper|claw|arm)|你(?:自己|手里|手上|手)?|机器人"
)
_ITSELF_HOLDS: Final = re.compile(
    r"(?:you|you're|you are|you've|you have) (?:already |still )?((?:got |hold|carry|grip).*)|"
    r"(?:你|你?手[里上])((?:拿|抓|夹).*)"
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


def of_success(condition: Condition, worked: bool) -> bool | None:
    """Whether a condition on how the last action went is met; None for any other condition."""
    who = condition.words("person").casefold() or condition.words("thing").casefold()
    said = (condition.words("topic") or condition.words("state")).casefold().replace("’", "'")
    if condition.kind in ("seen", "unseen") or condition.words("place") or (who and not _DEED.fullmatch(who)):
        return None
    if _WENT.fullmatch(said) is None or not (who or _SAYS_WHOSE.match(said)):
        return None
    succeeds = (_WENT_NOT.search(said) is None) == (condition.kind != "is_not")
    return worked == succeeds


_DEED: Final = re.compile(r"you(?:'ve| have)?|that|this|it|你|这|那")
_SAYS_WHOSE: Final = re.compile(r"(?:you|that|this|it)\b|[你这那没成失找]")
_WENT: Final = re.compile(
    r"(?:(?:you|that|this|it)(?:'ve)? )?"
    r"(?:(?:can|could|do|did|does|has|have|is|was|are|actually)(?: not|n't)? |cannot )*"
    r"(?:work|succe|fail|went (?:well|wrong)|go(?:es)? (?:well|wrong)|manage|ma[dk]e it|f(?:ou|i)nd|reach|able to)"
    r"[a-z]*(?: (?:it|that|them|one|there|him|her))?|你?(?:没有?)?(?:成功|失败|做到|找到|拿到)了?"
)
"""Told of how that went which the robot has just done."""
_WENT_NOT: Final = re.compile(r"n't|\bnot\b|cannot|fail|wrong|没|失败")


def _about_its_hand(condition: Condition) -> tuple[str, str] | None:
    """The state of its hand that a condition is about, and the thing that is named; None where it is about none."""
    who, thing = condition.words("person").casefold(), condition.words("thing")
    state = condition.words("state").casefold()
    if condition.kind == "event" or not (who or thing or condition.words("place")):
        told = _ITSELF_HOLDS.fullmatch(condition.words("topic").casefold() or state)
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
    there dance"; and with what needs a thing that may be missing as what depends on it: "bring me the red box, or if
    you can't find that, the blue one"."""
    made: list[Node] = []
    for node in nodes:
        last = made[-1] if made else None
        if isinstance(node, If) and isinstance(last, Do) and last.act in _LOOKS and _about_it(last, node, entities):
            taken = [role for role in last.roles if role.name in ("thing", "person", "place")]
            kept = [role for role in node.condition.roles if not entities.of(role.words).refers]
            names = {role.name for role in kept}
            roles = (*(role for role in taken if role.name not in names), *kept)
            made[-1] = replace(node, condition=replace(node.condition, roles=roles))
        elif isinstance(node, If) and isinstance(last, Do) and last.act in _NEEDS and _is_missing(last, node, entities):
            sought = [role for role in last.roles if role.name == "thing"]
            at = [replace(role, name="place") for role in last.roles if role.name == "source"]
            made[-1] = If(Condition("seen", (*sought, *at)), (last, *node.otherwise), node.then)
        else:
            made.append(node)
    return tuple(made)


_LOOKS: Final = frozenset({"find", "look", "check"})
_NEEDS: Final = frozenset({"bring", "pick_up", "put", "throw_away"})


def _is_missing(act: Do, node: If, entities: Entities) -> bool:
    """Whether a condition is that the one thing of an act is not to be found."""
    thing = node.condition.words("thing")
    needed = act.all("thing")
    elsewhere = any(not entities.of(words).refers for words in node.condition.all("place"))
    if node.condition.kind != "unseen" or not thing or len(needed) != 1 or elsewhere:
        return False
    return entities.of(thing).refers or entities.of(thing).thing == entities.of(needed[0]).thing


def _about_it(search: Do, node: If, entities: Entities) -> bool:
    """Whether a condition is about what was searched for, or lies where it was looked."""
    thing, place = node.condition.words("thing"), node.condition.words("place")
    person = search.words("person")
    if person and (not search.words("place") or entities.is_name(person)):
        return False  # a look from one place does not find them
    if search.words("thing"):
        same = entities.of(thing).thing == entities.of(search.words("thing")).thing
        return bool(thing) and (entities.of(thing).refers or same)
    return not place or entities.of(place).refers


def with_antecedent(node: If, entities: Entities, *, thing: bool = True, place: bool = True) -> Condition:
    """The condition with the thing that "it" is in it, where that is only named in what depends on it: "pick up the cup
    only if it is on the desk"; so with the place: "go down the hall unless somebody is in there". ``thing``, ``place``:
    whether none was named before."""
    acts = [act for act in (*node.then, *node.otherwise) if isinstance(act, Do)]
    things = (words for act in acts for words in act.all("thing") if not entities.of(words).refers)
    places = (
        words for act in acts for words in act.all("place") if entities.of(words).place and not entities.of(words).me
    )
    meant: dict[RoleName, str | None] = {
        "thing": next(things, None) if thing else None,
        "place": next(places, None) if place else None,
    }
    roles = (
        replace(role, words=words) if (words := meant.get(role.name)) and entities.of(role.words).refers else role
        for role in node.condition.roles
    )
    condition = replace(node.condition, roles=tuple(roles))
    state = next((role for role in condition.roles if role.name == "state"), None)
    if state is None or condition.words("place") or not meant["place"] or not _THERE.search(state.words.casefold()):
        return condition
    return replace(condition, roles=(*condition.roles, replace(state, name="place", words=meant["place"])))


_THERE: Final = re.compile(r"\bthere\b|在那")
"""A state of being where something is to go: "to the bed if it isn't there already"."""
