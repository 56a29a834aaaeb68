"""Which of several readings of a sound is meant: where the likeliest is nothing that can be done, the one that can.

Noise makes "pick us red box" of "pick up the red box", and a recogniser that is asked what else it may have been knows
the right one. Only what is nearly as likely is among its readings. Three limits keep commands from being made of what
was none: what is the beginning of a sentence stays one, since any reading that completes it has invented its end; no
number is taken that the likeliest reading has not got, or that sounds like another one in noise; and what people say to
each other as much as to a robot ("let's clean up here") has to be what was heard.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

from engine.asr.agreement import normalised_words
from engine.asr.recogniser import Rejected, Transcript

Completeness = Literal["complete", "incomplete", "unknown"]
"""Whether somebody who said this has said all."""

Judge = Callable[[str], Completeness]


@dataclass(frozen=True, slots=True)
class Afterthought:
    """What somebody went on with after a request that was complete."""

    text: str
    adds: bool
    """It is to be done after that request; else in its place."""
    clear: bool = True
    """It is a command; else only its first words tell that it belongs to the request, and it may be misheard."""


Notice = Callable[[str, str], Afterthought | None]
"""Finds what was added to a request, given its words alone and with what was said after it."""

_COMMA = ",，、 "
"""Written in noise at the end of anything."""

_NUMBER = re.compile(r"\d+(?:\.\d+)?|\w+teen\b")
_TEEN = re.compile(r"1[3-9]|\w+teen")
"""Mostly 30 … 90, misheard."""

_TO_EACH_OTHER = re.compile(r"\W*(?:(?:let[’']?s|let us|shall we|we)\b|让?(?:我们|咱|大家))", re.IGNORECASE)


def is_to_each_other(text: str) -> bool:
    """Whoever says it means more than one: a command only where nothing else was heard."""
    return _TO_EACH_OTHER.match(text) is not None


def makes_no_sense(text: str, judge: Judge) -> bool:
    """It is no command, and not the beginning of one."""
    return judge(text) != "complete" and judge(text.rstrip(_COMMA)) == "unknown"


def sensible(found: Transcript | Rejected, judge: Judge) -> Transcript | Rejected:
    """What was found, read as the likeliest command that it may have been if its text makes no sense."""
    if not isinstance(found, Transcript) or not found.others or not makes_no_sense(found.text, judge):
        return found
    words = normalised_words(found.text)
    for other in found.others:
        if normalised_words(other)[: len(words)] == words:
            continue  # the same, and an end that nobody has said
        numbers = _NUMBER.findall(other)
        certain = numbers == _NUMBER.findall(found.text) and not any(map(_TEEN.fullmatch, numbers))
        if certain and judge(other) == "complete" and not is_to_each_other(other):
            return replace(found, text=other, others=(found.text, *(o for o in found.others if o != other)))
    return found
