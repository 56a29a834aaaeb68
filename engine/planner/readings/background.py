"""What people tell beside what they ask: "that bottle's empty, bin it", "there is a ball in the hall, can you get it".

A statement asks for nothing, but the request behind it may speak of its thing as "it" and of its place as "there".
So the reading of both is the request alone, with their names in it. What is told after the request says why. Whatever
forbids the robot something, or makes conditions, is left alone.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from engine.planner.readings.consequences import VERBS
from engine.planner.readings.corrections import bare
from engine.planner.text.language import alternatives
from engine.skills.vocabulary import Vocabulary

_SUBJECT: Final = (
    r"(?:i|we|you|he|she|it|they|there|somebody|someone|everybody|everyone|(?:the|that|this|those|these|my|our|your|"
    r"his|her|their|both|all|one of)(?: [\w'-]+){1,6}?)"
)
_STATES: Final = re.compile(
    rf"(?:and |but |so |well |oh |hey |look |you know |i think |i believe )*(?:{_SUBJECT}|[\w-]+(?='s ))"
    r"(?:'s|'re|'m|'ve|'d|'ll| is| are| am| was| were| has| have| had| should| must| can| cannot| can't| "
    r"couldn't| could| may| might| will| need| needs| want| wants| belong| belongs| forgot| lost| left| dropped| got| "
    r"went| looks?| seems?| like| likes| fell| rolled| goes| stands?| lies| sits?| did| do| don't| fancy| fancies| "
    r"know| think| feel| said| came| come| hear| heard| see| saw| just| really| still| keep)\b.*",
    re.IGNORECASE,
)
_SETS: Final = re.compile(
    r"\b(?:if|unless|when|whenever|until|till|before|after|once|otherwise|while|except|instead|only|never|say|tell|"
    r"told|ask|"
    r"asked|(?:you|it|that|them) \w*(?:not|n't|never)|you (?:must|should|may|can|could|do|did)(?: not|n't)|"
    r"(?:want|like|need|let|told) (?:you|him|her|them))\b|[\"“”]",
    re.IGNORECASE,
)
"""What makes a statement more than background."""
_MORE: Final = re.compile(rf"(?:[,;.?!]|\band\b|\bthen\b) ?(?:please |also |then |you )*(?:{VERBS})\b", re.IGNORECASE)
"""Another request in what seemed to be a statement."""
_BREAK: Final = re.compile(r"[,;.!?]+(?: (?:so|and|then|well))* | - | so ", re.IGNORECASE)
_POLITE: Final = re.compile(
    r" (?=(?:could|can|would|will) (?:you|ya)\b|please\b|any idea\b|go and\b|go ahead\b)|(?<=\w)(?= see if you can\b)",
    re.IGNORECASE,
)
_VERB: Final = re.compile(
    r" (?=(?:go|take|bring|get|grab|fetch|pick|put|place|set|throw|bin|chuck|give|hand|carry|move|find|drop|stick|"
    r"leave|look)\b)",
    re.IGNORECASE,
)
_REFERS: Final = re.compile(r"\b(?:it|them|this|that|there|that one|this one)\b", re.IGNORECASE)
_IT: Final = re.compile(r"\b(?:that one|this one|it|them|this|that)\b(?!')", re.IGNORECASE)
_THERE: Final = re.compile(r"\b(?:over |in )?there\b(?!')", re.IGNORECASE)
_CLEANS: Final = re.compile(r"\b(?:clean|tidy|clear|search|sort|check|empty)\b", re.IGNORECASE)
_PUTS: Final = re.compile(r"^\W*(?:[\w']+ ){0,4}?(?:put|place|set|leave|drop|lay|stick|pop|stand)\b", re.IGNORECASE)
_PURPOSE: Final = re.compile(
    r",? (?:so that|so|in order that|because|cause|since|as) (?:i|we|he|she|they|it|people|my \w+|nobody|no one)\b"
    r"[^,;.?!]*$|,? before (?:someone|somebody|anyone|anybody|it|he|she) [^,;.?!]*$",
    re.IGNORECASE,
)
_YOU_CAN: Final = re.compile(r"(?:that )?you (?:can|could|may|will|are able to)\b", re.IGNORECASE)
""" "Pick it up so that you can bring it here" asks for both."""
_LEAVES: Final = re.compile(r"\bleave\b", re.IGNORECASE)
""" "The cup, leave it in the hall": it is not there yet."""
_ENDS_OPEN: Final = re.compile(
    r"(?:\b(?:to|the|a|an|my|your|you|i|we|and|or|of|in|(?<!now )on|at|with|can|could|will|would|should|must|may|just|"
    r"please)|'ll|'d)$",
    re.IGNORECASE,
)
_OPENING: Final = re.compile(r"^(?:the|that|this|those|these) ", re.IGNORECASE)


class Background:
    """Knows the things and the places of one house."""

    def __init__(self, vocabulary: Vocabulary, thing: re.Pattern[str]) -> None:
        """``thing`` finds what names a thing."""
        self._thing = thing
        names = {name for name in (*vocabulary.places(), *vocabulary.rooms(), *vocabulary.surfaces()) if len(name) > 1}
        self._place = re.compile(rf"(?<!\w)(?:{alternatives(names)})(?!\w)", re.IGNORECASE)
        self._surfaces = frozenset(vocabulary.surfaces()) - frozenset(vocabulary.rooms())

    def requests(self, text: str) -> Iterator[str]:
        """The request that ``text`` comes to, in every way that it may be cut; nothing where nothing is told first."""
        plain = bare(text)
        for told, asked, certain in _cuts(plain):
            thing = self._thing.search(told)
            topic = thing is not None and thing[0] == told
            if not asked or _SETS.search(told) or _MORE.search(told) or not (topic or _STATES.fullmatch(told)):
                continue
            refers = _REFERS.search(asked) is not None and (thing is not None or self._place.search(told) is not None)
            if refers or (certain and not topic):
                yield self._named(asked, told, thing[0] if thing is not None else "")

    def without_reasons(self, text: str) -> Iterator[str]:
        """The request alone, where a reason follows it; nothing where none does."""
        plain = bare(text)
        if (purpose := _PURPOSE.search(plain)) is not None and not _MORE.search(purpose[0]):
            yield plain[: purpose.start()]
        for found in _BREAK.finditer(plain):
            asked, told = plain[: found.start()], plain[found.end() :]
            if (
                asked
                and _STATES.fullmatch(told)
                and not _YOU_CAN.match(told)
                and not _SETS.search(told)
                and not _MORE.search(told)
            ):
                yield asked

    def _named(self, asked: str, told: str, thing: str) -> str:
        """A request with the names of what it refers to."""
        before = asked
        place = self._place.search(told.replace(thing, "", 1) if thing else told)
        if not thing and place is not None and _CLEANS.search(asked):
            asked = _IT.sub(f"the {place[0]}", asked, count=1)
        if thing:
            asked = _IT.sub(_OPENING.sub("the ", thing), asked, count=1)
        if place is not None:
            name = place[0]
            where = f"to the {name}"
            if _PUTS.search(asked):
                where = f"on the {name}" if name.casefold() in self._surfaces else f"in the {name}"
            asked = _THERE.sub(where, asked, count=1)
        return _LEAVES.sub("put", asked) if asked != before else asked


def _cuts(text: str) -> Iterator[tuple[str, str, bool]]:
    """Every way to cut a text into what is told and what is asked, and whether the place to cut is certain."""
    for pattern, certain in ((_BREAK, True), (_POLITE, True), (_VERB, False)):
        for found in pattern.finditer(text):
            told = text[: found.start()].strip()
            if not _ENDS_OPEN.search(told):
                yield told, text[found.end() :].strip(), certain
