"""Words that leave a thing or a place to guessing: "pick up the thing", "put it over there"."""

from __future__ import annotations

import re
from typing import Final

from engine.perception.naming import KINDS
from engine.planner.grounding.statement import Statement
from engine.planner.text.language import alternatives

_DOES: Final = (
    r"(?:pick(?: up)?|grab|grasp|take|get|bring|fetch|put(?: down| away)?|place|move|carry|throw(?: away)?|give|hand|"
    r"lift|hold|find|look for|search for|locate|drop|push|go to|drive to|approach|deliver|collect|pass|follow|set down|"
    r"lay down|do|use|show)"
)
_VAGUE_THING: Final = re.compile(
    rf"\b{_DOES}(?: (?:me|us|him|her|over|up|down|away|with))*"
    r"(?: (?:the|that|this|a|an|some|these|those|my|your|other|one|of|little|small|big|another|certain|right|same|"
    r"usual))* "
    r"(?:things?|stuff|something(?! to \w)|objects?|items?|thingy|thingies|ones?|whatsit|gadget)\b"
    r"(?! (?:that|which|on|in|under|at|near|next|behind|from|lying|standing|i|you|with|called)\b)"
    r"|(?:拿|捡|抓|取|带|送|搬|放|找|给|递|扔|丢|跟|去|到|把)[^，。]{0,3}?"
    r"(?:那个|这个|那些|这些|那|这|某个|点|些|个|一个)(?:东西|玩意儿?|物品|物体|家伙)"
    r"|(?:拿|捡|抓|取|带|送|搬|找|递)(?:一下|起|来|点)?"
    r"(?:东西|那个|这个|那些|那玩意)(?=$|[，。]|给|来|去|过来|放|拿|起来|到)"
)
_VAGUE_PLACE: Final = re.compile(
    r"\b(?:over there|"
    r"(?:go|drive|move|come|head|put it|put them|bring it|take it|carry it|put that|place it|leave it|drop it|travel|"
    r"run|walk) (?:\w+ )?(?:there|somewhere|someplace|elsewhere|wherever)|"
    r"(?:to|in|into|at|on) (?:another|some|some other|that|the other|a different) "
    r"(?:place|room|spot|side|location|area)|"
    r"to the (?:place|spot|location|room))$"
    r"|(?:去|到|放|往|开到|走到|送到|拿到|带到|搬到|放在|在)(?:了)?"
    r"(?:那边|那里|那儿|某个地方|别的地方|别处|另一个房间|那个地方|那个房间)"
)
_POINTS: Final = re.compile(
    rf"\b{_DOES}(?: (?:me|us|him|her|them|over|up|down|away|back))* "
    r"(?:this|that|these|those|it|something)(?! (?:i|you|to) )\b"
)
""" "Take this over there"."""
_KNOWN: Final = re.compile(
    rf"\b(?:{alternatives({*KINDS, 'light', 'arm', 'gripper', 'hand'})})s?\b|\bsomething to \w|\b(?:do|show) "
)
"""What may be meant by such a word, where it is named as well."""
_PLACED: Final = re.compile(
    r"\b(?:to|into|in|at|on|of) (?:the|my|your|our) (?!(?:place|spot|location|room|other)\b)\w+"
)


def vague(text: str) -> bool:
    """Whether ``text`` asks for something to be done with a thing or a place that it leaves to guessing."""
    words = Statement(text).text
    if _POINTS.search(words) is not None and _KNOWN.search(words) is None:
        return True
    return _VAGUE_THING.search(words) is not None or (
        _VAGUE_PLACE.search(words) is not None and _PLACED.search(words) is None
    )
