"""What a condition looks for: a thing, somebody, or whether a place is empty; and what counts as found."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Final, get_args

from engine.errors import PlanError
from engine.perception.sighting import Colour
from engine.perception.someone import Someone, UnknownPerson, is_named_after_kin, someone
from engine.planner.doing.conditions import NAMED_BEFORE, TIDY
from engine.planner.doing.doing import WHERE_IT_IS, Doing, Unable
from engine.planner.doing.handling import is_rubbish
from engine.planner.doing.moving import anybody
from engine.planner.doing.people import spot
from engine.planner.doing.sense import plain
from engine.planner.entities import Entities
from engine.planner.phrases.said import Calls, call
from engine.planner.text.counts import Count, at_least, how_many, is_amount
from engine.skills.vocabulary import FLOOR, ME
from engine.understanding.meaning import Condition

PERSON: Final = "person"
"""Anybody, as skills know them."""
ANYTHING: Final = "thing"
"""Any thing, as skills know it."""
_INDEFINITE: Final = re.compile(
    r"(?:(?:any|some)? ?(?:thing|stuff)s?|(?:any |a |the |some )?(?:mess|clutter)|what|"
    r"(?:任何|什么|有)?(?:东西|物品)|什么)(?:'s)?\b"
    r"(?: (?:at all|else|still|left|already))*(?: (?:that |which )?(?:is |are |'s )?"
    r"(?:lying|standing|sitting|left|lies|stands|is|are|there|around|about|on|in)\b.*)?"
)
"""Any thing at all."""
_SPEAKER: Final = re.compile(r"(?:i|we)(?:'m|'re| am| are)?|me|us|我们?|咱们?")
_EACH: Final = re.compile(r"(?:all|both|every|each)\b|所有|全部|每")
"""Of a kind, each one has to be there."""
_FLOOR: Final = re.compile(r"(?:on )?(?:the |this )?(?:floor|ground|carpet)|在?(?:地上|地面上?|地板上?)")
"""The floor of wherever that is."""
_EMPTY: Final = re.compile(
    r"empty|(?:free|clear)(?: of (?:clutter|things|stuff|junk|obstacles))?|nothing|bare|vacant|unoccupied|空[着的]?|没"
)
"""What a place is where nothing and nobody is."""


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
    """Of the things that are counted, or that were seen."""
    empty: bool = False
    """Whether it is asked if a place is empty: of things and of people."""
    at: str = ""
    """The name of the room or piece of furniture where it is to be; empty: wherever it is seen."""
    who: str = ""
    """Whoever is to be there, as skills know them; empty: anybody, or a thing."""

    asks: bool = False
    """Whether it is known by asking people there for their name."""

    @property
    def counts_people(self) -> bool:
        """Whether it depends on how many people there are."""
        return self.count is not None and self.thing == PERSON

    def is_open(self, sees: Callable[[str], bool]) -> bool:
        """Whether somebody was seen, and nobody can tell whether it is who is meant. That nobody is there, or somebody
        whom the robot knows or whose clothes and pose show, settles it."""
        return self.count is None and bool(self.who) and not sees(self.who) and sees(PERSON)

    def holds(self, sees: Callable[[str], bool], people: int = 0) -> bool:
        """Whether the condition is met; ``sees`` tells whether something was seen, ``people`` how many were counted."""
        if self.count is None:
            found = sees(self.who or self.thing)
        elif self.counts_people:
            found = self.count.fits(people)
        else:
            found = self.count.holds(self.names, sees)
        found = found or (self.empty and sees(PERSON))
        return found == self.there


def sought(doing: Doing, condition: Condition) -> Sought:
    """What a condition looks for, and how it finds out. Raises the exceptions of ``doing.py``."""
    condition = as_seen(condition, doing.entities)
    thing, person, place = condition.words("thing"), condition.words("person"), condition.words("place")
    if condition.words("times"):
        raise Unable("until")
    looks = _looks(condition) if person and not thing else None
    if condition.kind in ("is", "is_not") and looks is None:
        raise Unable("state", condition.words("state"))
    if condition.kind == "event":
        raise Unable("event", condition.words("topic"))
    people = how_many(person) if person else None
    who, where = _who(doing, people[0] if people is not None else person, looks) if person else ("", "")
    place = place or where
    there = condition.kind in ("seen", "is")
    if people is not None:
        at = spot(doing, place)
        counted = call("count_people", who or PERSON, *((at,) if at else ()))
        return Sought(PERSON, there, counted, people[1], who=who)
    many = how_many(thing) if thing else None
    if many is not None:
        thing = many[0]
    found = doing.entities.of(thing) if thing else None
    at = found.at.words if not place and found is not None and found.at is not None and found.at.known else place
    if at and (_FLOOR.fullmatch(at.casefold()) or WHERE_IT_IS.fullmatch(at.casefold())):
        at = ""
    is_there = bool(at) and bool(doing.calls) and doing.entities.of(at).refers
    if who and looks is None and at and not is_there and _is_stranger(doing, who):
        return Sought(PERSON, there, call("meet", who, spot(doing, at)), who=who, asks=True)
    going = call("navigation", doing.spot(at)) if at and not is_there else ()
    look = (*going, *call("seewhat"))
    name = _name_of(doing, at) if at else ""
    if len(several := condition.all("thing")) > 1:  # "if both … are there", "if neither … is"
        names = tuple(doing.thing(words) for words in several)
        return Sought(thing, there, look, at_least(len(names) if there else 1), names, at=name)
    if many is None:
        members = doing.entities.members(found) if found is not None and _EACH.match(thing.casefold()) else ()
        if len(members) > 1:
            return Sought(doing.thing(thing), there, look, at_least(len(members)), members, at=name)
        any_thing = not thing or is_anything(thing) or is_rubbish(thing)
        looked_for = PERSON if person else ANYTHING if any_thing else doing.thing(thing)
        return Sought(looked_for, there, look, who=who, empty=not thing and not person, at=name)
    names = doing.entities.members(found) if found is not None else ()
    if len(names) < 2:
        raise Unable("count", thing)
    return Sought(thing, there, look, many[1], names, at=name)


def _is_stranger(doing: Doing, who: str) -> bool:
    """Whether it is a name that the robot cannot tell anybody by."""
    return who != ME and doing.entities.is_name(who) and not doing.entities.is_known(who)


def _name_of(doing: Doing, words: str) -> str:
    """What the room or piece of furniture is called that these words name; empty for other places."""
    found = doing.where(words)
    if _BESIDE.match(words.casefold()) and found.surface not in (None, FLOOR):
        return doing.entities.room_of(found.surface or "")
    return found.room or "" if found.surface in (None, FLOOR) else found.surface


_BESIDE: Final = re.compile(r"(?:by|near|next to|beside|around|close to) ")
"""Not on a piece of furniture, and somewhere in its room."""


def _looks(condition: Condition) -> Someone | None:
    """How somebody is said to look, where a condition is about that and it can be seen: "is sitting", "wears red"."""
    try:
        looks = someone(condition.words("state"))
    except UnknownPerson:
        return None
    shows = looks.posture or looks.gesture or looks.shirt or looks.trousers
    return looks if shows and not looks.name and looks.gender is None else None


def _who(doing: Doing, words: str, looks: Someone | None = None) -> tuple[str, str]:
    """Who these words mean who also ``looks`` so, as skills know them (nothing: anybody), and the words for where they
    are said to be. Raises Unable for what may be nobody at all, and for the robot itself."""
    lower = plain(words).removesuffix("'s")
    if _SPEAKER.fullmatch(lower):
        return ME, ""
    if doing.who and NAMED_BEFORE.fullmatch(lower):
        return (str(_both(someone(doing.who), looks)) if looks is not None else doing.who), ""
    try:
        who, where = doing.entities.somebody(words.replace("’", "'").removesuffix("'s"))
    except PlanError:
        who, where = Someone(), ""
        if not anybody(lower):
            raise Unable("person", words) from None
    if who.is_anybody:
        return str(looks) if looks is not None else "", where
    determined = lower.startswith(("the ", "a ", "my ", "your "))
    is_named = is_named_after_kin(words) or (not determined and (words[:1].isupper() or doing.entities.is_name(lower)))
    if _PRONOUN.fullmatch(lower) or not (is_named or doing.entities.of(words).person or doing.entities.is_known(words)):
        raise Unable("person", words)
    return str(_both(who, looks) if looks is not None else who), where


def _both(who: Someone, looks: Someone) -> Someone:
    """Somebody of two descriptions; what one of them leaves open, the other says."""
    said = {part.name: getattr(looks, part.name) for part in fields(looks)}
    return replace(who, **{name: value for name, value in said.items() if value})


_PRONOUN: Final = re.compile(r"he|she|they|him|her|them|it|you(?:'re| are)?|[他她它你您]们?")


def is_anything(words: str) -> bool:
    """Whether any thing is meant: "something lying there"."""
    return _INDEFINITE.fullmatch(" ".join(plain(words).split())) is not None


def as_seen(condition: Condition, entities: Entities) -> Condition:
    """A condition on a state that is one of being there: "if the cup is on the desk", "if the desk is empty"."""
    if condition.kind not in ("is", "is_not"):
        return condition
    state, positive = condition.words("state").casefold(), condition.kind == "is"
    if not positive and is_amount(f"不{state}"):  # "不止一个": more than one
        state, positive = f"不{state}", True
    others = tuple(role for role in condition.roles if role.name != "state")
    where = entities.of(state)
    if _THERE.fullmatch(state) or _GONE.fullmatch(state):
        return Condition("seen" if positive == (_THERE.fullmatch(state) is not None) else "unseen", others)
    if condition.words("place") == "" and (where.place or where.room or where.surface):
        place = next(role for role in condition.roles if role.name == "state")
        return Condition("seen" if positive else "unseen", (*others, replace(place, name="place")))
    thing = condition.words("thing")
    if where.at is not None and where.at.known and _STAYS.fullmatch(state.removesuffix(where.at.words).strip()):
        place = next(role for role in condition.roles if role.name == "state")
        there = tuple(role for role in others if role.name != "place")
        return Condition("seen" if positive else "unseen", (*there, replace(place, name="place", words=where.at.words)))
    if state in get_args(Colour) and thing and (seen := entities.of(f"{state} {entities.near(thing)}").thing):
        roles = tuple(replace(role, words=seen) if role.name == "thing" else role for role in others)
        at = entities.of(thing).at
        if at is not None and at.known and not condition.words("place"):
            roles = (
                *roles,
                replace(next(role for role in others if role.name == "thing"), name="place", words=at.words),
            )
        return Condition("seen" if positive else "unseen", roles)
    tidy = TIDY.fullmatch(state) is not None
    if tidy or (positive and _MESSY.search(state) is not None):  # something lies there, or nothing does
        spots = [role for role in others if entities.of(role.words).room or entities.of(role.words).refers]
        return Condition(
            "seen" if positive != tidy else "unseen", tuple(replace(role, name="place") for role in spots[:1])
        )
    if how_many(state) is not None and condition.words("place"):  # "on the table it is more than one box"
        return Condition(
            "seen" if positive else "unseen",
            tuple(replace(role, name="thing") if role.name == "state" else role for role in condition.roles),
        )
    if is_amount(state) and thing:  # "the blocks on the bench are more than two"
        counted = f"{state} {thing}" if state.isascii() else f"{state}{thing}"
        roles = tuple(replace(role, words=counted) if role.name == "thing" else role for role in others)
        return Condition("seen" if positive else "unseen", roles)
    empty = _EMPTY.fullmatch(state) is not None
    if empty and (spot := entities.of(thing or condition.words("place"))) and (spot.place or spot.room):
        roles = tuple(replace(role, name="place") for role in others if role.name in ("thing", "place"))
        return Condition("unseen" if positive else "seen", roles[:1])
    return condition


_MESSY: Final = re.compile(r"\bmess|untidy|dirty|filthy|clutter|chaotic|not (?:clean|tidy)|乱|脏|不干净|不整[洁齐]")
_STAYS: Final = re.compile(
    r"(?:still |already |now )*(?:lying|standing|sitting|left|kept|waiting|lies|stands|sits|placed|sleeping)"
    r"(?: (?:on|in|at|by|near|inside|under)(?: top of)?)?(?: the| my| your)?"
)
"""What a state says that is no more than being somewhere."""
_THERE: Final = re.compile(
    r"(?:still |already )?(?:there|here|present|visible|around|available|in (?:sight|view))"
    r"(?: already| still| yet| now)?|"
    r"[还已经]*在(?:那儿?|那里|这儿?|这里)?了?"
)
_GONE: Final = re.compile(r"missing|gone|absent|away|nowhere(?: to be (?:seen|found))?|not there|不在了?|不见了?|没了")
