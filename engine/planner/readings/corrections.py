"""People who correct themselves: "turn right, no, sorry, left", "go to the kitchen, I mean the bedroom".

What follows the correction replaces the end of what came before it; where that end begins nobody says. So each place is
only a proposal, the shortest end first, and whoever asks for them knows which one makes a command.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final, get_args

from engine.han import is_chinese
from engine.perception.sighting import Colour
from engine.planner.request import Language

LONGEST: Final = 300
"""Longest sentence that is looked at, characters."""
_CORRECTION: Final = re.compile(
    r"[,.;:!?…–—\s]+(?:(?:uh+|um+|er+|oh|ah|no|nope|nah|sorry|wait|hang on|hold on|my mistake|my bad|oops|well|"
    r"actually|rather|scratch that|correction|make (?:it|that)|i (?:mean|meant)|i wanted to say|not that|"
    r"let me correct(?: that)?|i was wrong)\b[,.;:!?…–—\s]*){1,5}",
    re.IGNORECASE,
)
_CERTAIN: Final = re.compile(
    r"\b(?:no|nope|nah|sorry|my mistake|my bad|oops|rather|scratch that|correction|make (?:it|that)|i (?:mean|meant)|"
    r"actually|i wanted to say|not that|let me correct|i was wrong)\b",
    re.IGNORECASE,
)
"""A mere "uh" or "wait" is none."""
_CORRECTION_ZH: Final = re.compile(
    r"[，。！,.!\s]*(?:哦|噢|呃|啊|嗯)?(?:不对|不是|说错了|错了|我是说|我说的是|应该是|改成|哦不|噢不)[，。！,.!\s]*(?:是|我是说|应该是)?"
)
_MAKES: Final = re.compile(r"\bmake (?:it|that)\W*$", re.IGNORECASE)
_FOR: Final = re.compile(r"\b(?:for|as|mean|means|meaning|saying|says|if)$", re.IGNORECASE)
_TO_BE: Final = re.compile(rf"(?:{'|'.join(get_args(Colour))}|on|off|pink|cyan|gray|violet)\b", re.IGNORECASE)
_ONE: Final = re.compile(r"\bone\b(?! (?:half |quarter )?(?:met|cent|degree|second|minute|time|turn))", re.IGNORECASE)
"""As in "the red box, no, the blue one", and not in "one metre"."""
_WHICH_ONE: Final = re.compile(
    r"(?P<said>.+?)(?: please)?,? (?P<one>the \w+ one)(?:,? (?:i mean|that is|please))?[.!]*", re.IGNORECASE
)
"""As in "bring me the box, the blue one"."""
_WORD: Final = re.compile(r"\S+")
_AT_THE_END: Final = re.compile(r"[,\s]+(?:i (?:mean|meant)|sorry|my mistake|actually)\W*$", re.IGNORECASE)
QUOTES: Final = re.compile(r"[\"“”「」『』]")
"""Words that are quoted are to be said as they are."""
_NEVER_MIND: Final = re.compile(
    r"\W*(?:(?:oh|ah|no|nah|nope|ok|okay|well|actually|hmm?|thanks|no thanks)\W+)*"
    r"(?:never ?mind|forget (?:it|about it|that)|don't bother|leave it|no need|no thanks|no thank you|"
    r"(?:it's|its|that's|i'm) (?:fine|ok|okay|all right|alright))"
    r"(?:\W+(?:then|thanks|thank you|now|i (?:don't|dont|do not) (?:need|want) (?:it|that)(?: any ?more)?))*\W*|"
    r"\W*(?:算了吧?|没事了?|不用了|不必了)(?:，?谢谢)?\W*",
    re.IGNORECASE,
)


def bare(text: str) -> str:
    """A sentence with single spaces and without marks at its ends; empty where it is too long to be looked at."""
    plain = " ".join(text.split()).strip(" ,.!?。，！？")
    return plain if len(plain) <= LONGEST else ""


def is_taken_back(text: str) -> bool:
    """Whether somebody wants nothing any more: "never mind"."""
    return _NEVER_MIND.fullmatch(text) is not None


def times_corrected(text: str) -> int:
    """How often something is taken back within a sentence."""
    language: Language = "zh" if is_chinese(text) else "en"
    pattern = _CORRECTION_ZH if language == "zh" else _CORRECTION
    return sum(_takes_back(found, text, language) for found in pattern.finditer(text))


def corrected(text: str, language: Language) -> Iterator[str]:
    """What ``text`` may mean where its speaker took something back; nothing where nobody did. The newest word counts:
    of several corrections, each applies to what the ones before it left."""
    if len(text) > LONGEST or QUOTES.search(text):
        return
    which = _WHICH_ONE.fullmatch(text) if language == "en" else None
    if which is not None and _CERTAIN.search(which["said"]) is None:
        yield from corrected(f"{which['said']}, I mean {which['one']}", language)
    pattern = _CORRECTION_ZH if language == "zh" else _CORRECTION
    found = next((match for match in pattern.finditer(text) if _takes_back(match, text, language)), None)
    if found is None:
        return
    before, after = text[: found.start()].rstrip(" ,.;，。"), _AT_THE_END.sub("", text[found.end() :].strip())
    later = list(corrected(f"{before} {after}", language)) if pattern.search(after) else []
    yield from later
    if language == "en" and _ONE.search(after) and before:
        after = _ONE.sub(before.split()[-1], after, count=1)
    ends = [match.start() for match in _WORD.finditer(before)] if language == "en" else list(range(len(before)))
    joint = " " if language == "en" else ""
    for end in reversed(ends):
        yield f"{before[:end].rstrip()}{joint}{after}".strip()


def _takes_back(match: re.Match[str], text: str, language: Language) -> bool:
    between = match.start() > 0 and match.end() < len(text)
    if language == "en" and _MAKES.search(match[0]) and _TO_BE.match(text[match.end() :]):
        return False  # "…, then make it blue"
    if language == "en" and _FOR.search(text[: match.start()]):
        return False  # "shake for no, then clap"
    return between and (language == "zh" or _CERTAIN.search(match[0]) is not None)
