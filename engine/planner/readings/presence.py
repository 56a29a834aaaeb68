"""What a clause says is there: "there's still a red apple on the table", "nobody is in the hall", "the stool is free".

A look tells whether a thing can be seen somewhere, and nothing else: not how many there are, not what the weather or
the battery is like, and not what was. A clause that says anything but that, or that is not understood to its last word,
is none. Words that change nothing ("still", "by any chance", "lying about") are passed over.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Final

from engine.perception.naming import KINDS

MAX_CLAUSE: Final = 160
"""Longest clause that is looked at, characters."""


@dataclass(frozen=True, slots=True)
class Presence:
    """Something that is there, or is not."""

    thing: str
    """Without its article; ``thing`` and ``person`` for anything and anybody."""
    where: str = ""
    """Without the preposition; empty for wherever the robot looks."""
    negated: bool = False


def presence(clause: str, about: Presence | None = None) -> Presence | None:
    """What ``clause`` says is there; "it" is what it is ``about``. None for anything else."""
    if len(clause) > MAX_CLAUSE:
        return None
    plain = plainly(clause)
    for negated, pattern in _CLAUSES:
        match = pattern.fullmatch(plain)
        if match is not None and (found := _read(match, negated, about)) is not None:
            return found
    return None


def plainly(clause: str) -> str:
    """In full words, and without those that change nothing."""
    for pattern, words in _PLAINER:
        clause = pattern.sub(words, clause)
    return " ".join(clause.split()).strip(" ,;.?!")


def is_one(clause: str) -> bool | None:
    """Whether a clause about what was just spoken of says that it is there ("it is", "you find one") or that it is not
    ("there isn't", "it's gone"); None for neither."""
    plain = plainly(clause)
    if _IT_IS.fullmatch(plain):
        return True
    return False if _IT_IS_NOT.fullmatch(plain) else None


COLOURS: Final = r"(?:red|orange|yellow|green|blue|purple|white|gr[ea]y|black)"
_PLAINER: Final = tuple(
    (re.compile(pattern, re.IGNORECASE), words)
    for pattern, words in (
        (r"\bcannot\b|\bcan't\b", "can not"),
        (r"n't\b", " not"),
        (r"\b(there|it|that|he|she|one|no ?one|(?:some|any|no|every)(?:body|one|thing))'s\b", r"\1 is"),
        (
            r"(?<=\w)'s(?= (?:not|no longer|in|inside|on|at|under|by|near|next|beside|behind|there|here|lying|standing|"
            rf"sitting|waiting|still|already|empty|free|clear|missing|gone|around|about|{COLOURS})\b)",
            " is",
        ),
        (r"\b(they|we|you)'re\b", r"\1 are"),
        (r"\b(we|you|they)'ve\b", r"\1 have"),
        (r"\bhappens? to be\b", "is"),
        (r"\bhappens? to (?=see|find|notice|spot)", ""),
        (r"\b(?:is|are) no longer\b", "is not"),
        (r"\bany(?: ?more| longer)$", ""),
        (r"\bany more (?=\w)", "any "),
        (r"\b(?:still|already|currently|actually|really|maybe|perhaps|by (?:any )?chance|right now|at the moment|"
         r"at present|for now|yet|just|also|by then)\b", ""),
        (r"(?<!the )(?<!my )(?<!your )\bleft(?: over)?(?= (?:on|in|inside|at|under|by|near|behind|beside|"
         r"next)\b|$)", ""),
        (r"\b(?:lying|standing|sitting|hanging|waiting|walking|lounging|laying|resting|placed|parked|somewhere|anywhere)"
         r"(?: (?:about|around|over))?(?= (?:here|there|on|in|inside|at|under|by|near|behind|beside|next)\b)", ""),
        (r"\b(?:lying|standing|sitting|hanging|waiting|walking|laying) ?(?:about|around)?$", "there"),
    )
)  # fmt: skip

_A = r"(?:the|a|an|any|some|my|our|your|one|another|his|her|their|that|this|either)"
_NO_NAME = (
    r"(?:is|are|was|were|be|been|has|have|had|you|it|we|they|there|here|on|in|at|under|by|near|next|behind|and|or|then|"
    r"to|if|which|who|what|how|not|no|none|see|onto|into|from|of|with|for|about|as|like|please|otherwise|than|"
    r"a|an|the|any|some|do|does|did|will|would|could|should|so|gone|missing|when|until|tomorrow|today|tonight|"
    r"yesterday|later|again|soon|called|named|wearing|never|always|often|hardly|almost|your|my|our|his|her|their|"
    r"this|that)"
)
_WORD = rf"(?:(?!{_NO_NAME}\b)[^\W\d_][\w'-]*|(?<=\w )\d+)"
_NAME = rf"(?:{_WORD}(?: {_WORD}){{0,3}}?)"
_ANY = rf"(?:(?:at least one|even one|a single|one or more|(?:any|one) of (?:the|my|our|those)|{_A}) )"
_THING = rf"(?:{_ANY}?(?P<thing>{_NAME}))"
_PREPOSITION = (
    r"(?:on top of|on|in|inside|at|under|underneath|near|by|next to|beside|in front of|behind|over (?:by|in|at|on)|"
    r"down in|up in|out in|out on|around|within)"
)
_PLACE = rf"(?:(?:{_A} )?{_NAME})"
_HERE = (
    r"(?:(?:(?:over|right|in|around|down|up|on) )?(?:there|here)|anywhere(?: about| around)?|"
    r"from (?:where you are|here|there)|around|about|on it|in it|to be seen|in "
    r"sight|in view|nearby|present|at all|(?:in front|ahead) of (?:you|me)|ahead|(?:on|to) (?:the|your|my) (?:left|"
    r"right))"
)
_WHERE = rf"(?:{_HERE}|{_PREPOSITION} (?P<where>{_PLACE}))"
_SEES = (
    r"(?:(?:you|we) )?(?:(?:can|do|could|should) )*(?:see|find|notice|spot|detect|come across|discover|encounter|"
    r"meet)"
)
_SEES_NOT = r"(?:(?:you|we) )?(?:can|do|could|should) not (?:see|find|notice|spot|detect|discover)"
_THERE = r"there (?:is|are|be)"
_IS = r"(?:is|are|be|lies|stands|sits)"
_EMPTY = r"(?:(?:all |completely |quite )?(?:empty|free|clear|bare|vacant|unoccupied|deserted))"
_CLAUSES: Final = tuple(
    (negated, re.compile(pattern, re.IGNORECASE))
    for negated, pattern in (
        (True, rf"{_THERE} (?:not\b|no longer|no(?= \w)) ?{_THING}(?: {_WHERE})?"),
        (True, rf"{_THERE} (?P<nothing>nothing|none|nobody|no ?one)(?: {_WHERE})?"),
        (True, rf"{_SEES_NOT} {_THING}(?: {_WHERE})?"),
        (True, rf"{_SEES} (?:no |(?P<nothing>nothing|nobody|no ?one)\b){_THING}?(?: {_WHERE})?"),
        (False, rf"(?:{_THERE}|{_SEES}) (?P<it>it|them|one|any)(?: {_WHERE})?"),
        (False, rf"(?:{_THERE}|{_SEES}) {_THING}(?: {_WHERE})?"),
        (False, rf"{_PREPOSITION} (?P<where>{_PLACE}) {_THERE} {_THING}"),
        (True, rf"{_PREPOSITION} (?P<where>{_PLACE}) {_THERE} (?:not|no) {_THING}"),
        (True, rf"(?P<nothing>nobody|no ?one|nothing)(?: else)? {_IS} {_WHERE}"),
        (True, rf"no {_THING} {_IS} {_WHERE}"),
        (True, rf"(?:you|we) (?:are|have run|run) out of {_THING}"),
        (False, rf"(?P<empty>{_PLACE}|it|that) {_IS} (?:occupied|taken|not {_EMPTY})"),
        (True, rf"(?P<empty>{_PLACE}|it|that) {_IS} {_EMPTY}"),
        (True, rf"(?:{_THING}|(?P<it>it|they)) (?:{_IS}|has|have) (?:gone|missing|disappeared)(?: from "
               rf"(?P<where>{_PLACE}))?"),
        (True, rf"(?:{_THING}|(?P<it>it|they)) {_IS} not {_WHERE}"),
        (False, rf"(?:{_THING}|(?P<it>it|they)) {_IS} {_WHERE}"),
        (True, rf"(?:{_THING}(?: {_WHERE})?|(?P<it>it|that)) {_IS} not (?P<colour>{COLOURS})"),
        (False, rf"(?:{_THING}(?: {_WHERE})?|(?P<it>it|that)) {_IS} (?P<colour>{COLOURS})"),
        (False, rf"(?P<where>{_PLACE}) (?:has|holds|contains) {_THING} (?:on|in|inside) it"),
        (True, rf"(?P<where>{_PLACE}) has (?:no|nothing) {_THING} (?:on|in|inside) it"),
    )
)  # fmt: skip

_ONE = r"(?:it|them|one|any|some|him|her|that one|this one|(?:some|any)(?:body|one|thing))"
_IT_IS: Final = re.compile(
    rf"(?:it|they|he|she|that|one|(?:some|any)(?:body|one|thing)) {_IS}(?: {_HERE})?|{_THERE}(?: {_ONE})?(?: "
    rf"(?:there|here))?|(?:you|we) (?:do|can|did|have|succeed)(?: (?:see|find|spot) {_ONE})?|{_SEES} {_ONE}(?: there)?",
    re.IGNORECASE,
)
_IT_IS_NOT: Final = re.compile(
    rf"(?:it|they|he|she|that) {_IS} (?:not(?: {_HERE})?|gone|missing)|{_THERE} (?:not(?: {_ONE})?|none|nothing|nobody|"
    rf"no ?one)(?: (?:there|here))?|(?:you|we) (?:do|can|did|have) not(?: (?:see|find|spot) {_ONE})?(?: there)?|"
    rf"{_SEES} (?:nothing|nobody|no ?one|none)(?: there)?|(?:nobody|nothing|no ?one|none) {_IS}(?: (?:there|here))?|"
    r"it has (?:gone|disappeared)",
    re.IGNORECASE,
)

_NOT_SEEN: Final = (
    "problem problems question questions time need danger issue error way chance doubt emergency noise music voice "
    "reason battery rain snow wind storm thunder weather sun light power it one you robot that this everything i he "
    "she they we enough obstacle room space trouble risk hurry fit sense answer news mistake sound smell point use "
    "more less many few several two three four five six seven eight nine ten all both other others else me us yourself "
    "myself difficult hard difference money mood fault internet network signal connection wifi charge temperature "
    "difficulty idea"
)
_UNSEEN: Final = frozenset(_NOT_SEEN.split())
"""What a look does not tell of, numbers among them."""
_NOWHERE: Final = (
    "mood way hurry trouble danger time charge love pain end doubt need use order fire holiday phone work home "
    "question morning afternoon evening night noon midnight minute minutes hour hours moment luck risk fact future "
    "past air move once dark battery power line process middle meeting loose hand hands gripper hospital coast"
)
_NO_PLACE: Final = frozenset(_NOWHERE.split())
_ROOM: Final = re.compile(
    r"(?:room|bedroom|kitchen|hall|hallway|study|bathroom|office|lobby|garage|house|flat|corridor|nursery|lounge|"
    r"kitchenette|toilet|cellar|attic|reception|entrance)$",
    re.IGNORECASE,
)
_NUMBERS: Final = ("one", "two", "three", "four", "five", "six", "seven", "eight", "nine")
_NUMBERED: Final = re.compile(rf"(?<=block )(?:number )?({'|'.join(_NUMBERS)})$", re.IGNORECASE)
_ANYBODY: Final = re.compile(r"(?:any|some|no) ?(?:body|one)(?: else)?|people|persons?", re.IGNORECASE)
_ANYTHING: Final = re.compile(
    r"(?:(?:any|some|no)thing|things?|stuff|none)(?: else)?(?: (?P<kind>\w+))?", re.IGNORECASE
)


def _read(match: re.Match[str], negated: bool, about: Presence | None) -> Presence | None:
    parts = {name: words or "" for name, words in match.groupdict().items()}
    where = parts.get("where", "")
    if empty := parts.get("empty", ""):
        if empty.casefold() in ("it", "that", "the coast"):
            thing = about.thing if about is not None and about.thing == "person" else "thing"
            return replace(about, thing=thing, negated=negated) if about is not None else None
        return _checked(Presence("person" if _ROOM.search(empty) else "thing", empty, negated))
    thing = parts.get("nothing", "") or parts.get("thing", "")
    if parts.get("it"):
        if about is None and not parts.get("colour"):
            return None
        thing, where = (about.thing, where or about.where) if about is not None else ("thing", where)
    thing = _named(thing)
    if colour := parts.get("colour", ""):
        if thing.split()[-1] not in KINDS:
            return None  # a light, a sign
        thing = f"{colour} {thing}"
    return _checked(Presence(thing, where, negated))


def _named(thing: str) -> str:
    """Without articles, with the number of a block in figures, and "anything red" as a red thing."""
    shorter = re.sub(r"^(?:any|some|no|single) ", "", thing, flags=re.IGNORECASE)
    if _ANYBODY.fullmatch(thing) or _ANYBODY.fullmatch(shorter):
        return "person"
    thing = shorter
    if (match := _ANYTHING.fullmatch(thing)) is not None:
        return f"{match['kind']} thing" if match["kind"] else "thing"
    return _NUMBERED.sub(lambda found: str(_NUMBERS.index(found[1].casefold()) + 1), thing)


_EVERYWHERE: Final = frozenset(["floor", "ground", "carpet"])
"""Where a thing can be anywhere: the look is from where the robot is then, unless a room is named."""


def _checked(found: Presence) -> Presence | None:
    """None for what no look tells of."""
    words, place = found.thing.casefold().split(), found.where.casefold().split()
    if not words or words[0] in _UNSEEN or words[-1] in _UNSEEN:
        return None
    if place and (place[-1] in _NO_PLACE or place[-1] in _UNSEEN - {"room"}):
        return None
    if place and place[-1] in _EVERYWHERE:  # the kitchen floor is in the kitchen
        room = re.sub(r"(?: |^)\w+$", "", found.where).removesuffix("'s")
        return replace(found, where="" if re.fullmatch(_A, room, re.IGNORECASE) else room)
    return found
