"""Whether somebody who pauses has said all: asked while the pause lasts, so that it need not be long.

"Go to the kitchen" is a command as it stands. "Go to the", "then", "go forward two" are the beginning of one, and so is
what lacks something that only its speaker knows, or the unit of its number. After all else one can only wait and see;
also after what is a command but often goes on, as "turn left" does ("… 45 degrees").
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Final

from engine.hearing.readings import Completeness
from engine.plan import Plan
from engine.planner.phrases.stopping import is_end_task, is_stop
from engine.planner.request import NoPlan
from engine.planner.text.measures import read_measures
from engine.planner.text.words import words_of

_ENDS_OPEN: Final = re.compile(
    r"\b(?:a|an|the|my|your|his|her|its|our|their|this|that|these|those|some|any|another|each|every|and|or|then|but|also"
    r"|plus|with|without|to|into|onto|in|on|at|of|off|by|from|for|near|behind|under|over|through|towards?|between|beside"
    r"|beyond|past|via|than|as|if|when|while|until|once|because|so|about|u+h+m*|u+m+|er+m*|h+m+|a+h+|maybe|bring|take|put|fetch|carry"
    r"|get|give|say|tell|let|can|could|would|will)\W*$",
    re.IGNORECASE,
)
"""English words that no command ends in, or none that is worth doing at once."""

_ENDS_OPEN_ZH: Final = re.compile(
    r"(?:然后|再|接着|之后|以后|并且|并|而且|和|跟|与|或者|或|还有|还|先|就|把|将|给|到|往|向|朝|从|在|去|对|用|帮我|帮|请|一个|这个|那个|的|那|这|如果"
    r"|要是|因为|所以|嗯|呃)\W*$"
)
"""Chinese words of which the same is true, where they are not the end of a longer one."""

_LACKS_THING: Final = re.compile(
    r"\b(?:go|turn|move|drive|navigate|pick(?:\s+up)?|find|open|close|raise|lower|clean|patrol|look\s+for)\W*$",
    re.IGNORECASE,
)
"""English words after which most commands name something; where nothing has been said before, those that need none
are known."""

_TRAILS_OFF: Final = re.compile(r"(?:\.\.+|…|[-–—:：])\s*$")
"""How recognisers write a sentence that hangs in the air."""

_COMMA: Final = re.compile(r"[,，、]\s*$")
"""Written where a voice does not fall, and sometimes where the sound was cut a little early."""

_MAY_GO_ON: Final = frozenset({"left", "right", "左", "右", "转", "圈", "弯"})
"""Ends of commands that many continue: by how much."""

_GOES_BACK: Final = re.compile(r"\bgo back\W*$", re.IGNORECASE)
"""To the beginning; or somewhere else, or a metre, once that has been said."""

_THERE_ZH: Final = re.compile(r"[过回]去\W*$")
_ONE: Final = re.compile(r"\bone\W*$", re.IGNORECASE)
""" "The blue one" is no number."""
_OPEN: Final = frozenset({"incomplete", "ambiguous"})
"""Codes of questions for what was not said."""


def completeness(text: str, plain: Callable[[str], Plan | NoPlan | None]) -> Completeness:
    """Whether somebody who said ``text`` has said all; ``plain`` says what comes of it by itself."""
    tokens = [token for token in read_measures(words_of(text).tokens) if token.kind != "mark"]
    if not tokens:
        return "unknown"
    if is_stop(text) or is_end_task(text):
        return "complete"
    found, last = plain(text), tokens[-1]
    acts = isinstance(found, Plan) and bool(found.actions)
    if acts and _THERE_ZH.search(text):
        return "unknown"  # a word of its own, or the beginning of 去厨房
    if any(ending.search(text) for ending in (_ENDS_OPEN, _ENDS_OPEN_ZH, _TRAILS_OFF)):
        return "incomplete"
    if last.kind == "number" and not _ONE.search(text):  # its unit is missing
        return "incomplete"
    if isinstance(found, Plan) and acts:
        open_ended = last.text in _MAY_GO_ON or found.actions[-1].name == "say"
        return "unknown" if open_ended or _GOES_BACK.search(text) or _COMMA.search(text) else "complete"
    if any(ending.search(text) for ending in (_LACKS_THING, _COMMA)):
        return "incomplete"
    return "incomplete" if isinstance(found, NoPlan) and found.code in _OPEN else "unknown"
