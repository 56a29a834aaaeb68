"""Conditions on what somebody answers to a question that the robot has just asked: "ask Anna whether she is thirsty,
and if she is, bring her the bottle"."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from engine.plan import ActionCall
from engine.understanding.meaning import Condition

_OF_WHOM: Final = re.compile(
    r"(?:if )?(?:so|yes|no|not|he|she|they|him|her|them|that|it|the (?:answer|reply)|someone|anyone)\b|"
    r"(?:对方|回答|答案|他|她|要|是|好|不|没|愿意|同意|答应)"
)
"""How a condition on an answer begins: with whoever was asked, or with the answer itself."""
_NEGATIVE: Final = re.compile(r"\bno(?:t|pe|ne|body|thing)?\b|n't\b|\bnever\b|refus|declin|disagree|[不没别]|拒绝")
_AFFIRMATIVE: Final = re.compile(
    r"\b(?:yes|yeah|yep|yup|aye|sure|ok(?:ay)?|please|gladly|of course|certainly|absolutely|"
    r"i (?:do|am|would|will|can|have)|i'd (?:like|love)|i'm)\b|[是好对要嗯]|可以|当然|愿意|行"
)
_SAYS: Final = re.compile(
    r"\b(?:say|answer|repl|want|choos|prefer|ask(?:s)? for)\w*\s+(?P<what>.+)|(?:说|要|选)(?P<zh>.+)"
)
"""What somebody may answer beside yes and no."""
_EMPTY: Final = frozenset({"it", "to", "one", "some", "that", "so", "the", "a", "an", "for", "any", "them", "help"})


def depends_on_an_answer(condition: Condition, calls: Sequence[ActionCall]) -> bool:
    """Whether a condition is about what somebody says who has just been asked something."""
    if not calls or calls[-1].name != "ask_person" or condition.kind in ("seen", "unseen"):
        return False
    who = condition.words("person") or condition.words("thing") or condition.words("topic")
    return bool(who) and _OF_WHOM.match(_plain(who)) is not None


def is_met(condition: Condition, answer: str) -> bool | None:
    """Whether the answer is the one that it depends on; None where the answer tells neither yes nor no."""
    words, answer = _plain(f"{condition.words('topic')} {condition.words('state')}"), _plain(answer)
    wants_no = (_NEGATIVE.search(words) is not None) != (condition.kind == "is_not")
    if (named := _named(words)) and any(word in answer for word in named):
        return not wants_no
    says_no, says_yes = _NEGATIVE.search(answer) is not None, _AFFIRMATIVE.search(answer) is not None
    if says_no or (says_yes and not named):
        return says_no == wants_no
    return wants_no if named else None  # "coffee, please" is no tea


def _named(words: str) -> list[str]:
    """What an answer has to name: "if she says tea"."""
    found = _SAYS.search(words)
    rest = (found["what"] or found["zh"]) if found is not None else ""
    names = re.findall(r"[a-z]+|[\u3400-\u9fff]+", rest)
    return [name for name in names if name not in _EMPTY and not (_NEGATIVE.search(name) or _AFFIRMATIVE.search(name))]


def _plain(words: str) -> str:
    return " ".join(words.casefold().replace("’", "'").split()).strip(' ,.!?，。！？“”"')
