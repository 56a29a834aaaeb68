"""Where to look first, for a condition that could not be taken apart: the place that is named with it.

What is to be done then is decided after the look, with what was seen; so this only has to choose a place, where a look
would tell anything at all ("if you are tired, go home" depends on nothing that can be seen). It is the one that the
request says to go to or to look at ("check the study, and if …"), else the one within the condition ("if a cup is on
the desk, …"), else one in front of it where something is, and not where something is to be taken.
"""

from __future__ import annotations

import re
from typing import Final

from engine.han import is_chinese
from engine.plan import ActionCall
from engine.planner.grounding.grounds import resolved
from engine.planner.grounding.statement import Statement
from engine.planner.phrases.said import Calls
from engine.planner.readings.consequences import VERBS
from engine.skills.vocabulary import Vocabulary

IF_POLITE: Final = re.compile(
    r"\bif (?:you (?:don't mind|do not mind|can|could|would|like|please|want to|have (?:time|a (?:moment|minute)))|"
    r"(?:that|it)(?:'s| is) (?:ok|okay|all right|alright|possible|no trouble|not too much trouble))\b"
    r"|(?:如果|要是)?(?:您|你)?(?:不麻烦|方便|可以|有空|愿意)的话",
    re.IGNORECASE,
)
"""A condition by its form alone."""
CONDITION: Final = re.compile(
    r"\b(?:if|whether|unless|in case|should there|as long as|provided|whenever|otherwise)\b"
    r"|\bis there\b.*\bthen\b|如果|要是|假如|是否|有没有|否则|的话",
    re.IGNORECASE,
)
"""What shows that a request depends on something."""
_GOES: Final = re.compile(r"\b(?:go|drive|head|pop|run|visit|swing by|drop by)\b|去|到", re.IGNORECASE)
_JOINS: Final = re.compile(r"(?:[,;.，。；]|\b(?:and|then))\s*$", re.IGNORECASE)
_WITHIN: Final = re.compile(
    r"\b(?:in|on|at|under|near|by|inside|behind|next to|off) (?:the |my |your |our |a )?(?:\w+(?: \w+){0,2})|^the "
    r"\w+(?: \w+)?",
    re.IGNORECASE,
)
"""Where something is, and not where somebody goes."""


_LOOKS: Final = re.compile(
    r"\b(?:check|look|see|search|inspect|scan|find out|count)\b|看|瞧|检查|找|数一", re.IGNORECASE
)
_SIGHT: Final = re.compile(
    r"\bthere(?:'s|'re| is| are| be| isn't| aren't)\b|\b(?:see|find|spot|notice|detect|discover)\b|(?:'s|n't|\b(?:is|"
    r"are|be|lies|stands|sits|not)) (?:.* )?(?:on|in|at|under|near|by|inside|behind|beside|next to|off|there|here|"
    r"empty|free|clear|bare|missing|gone|red|orange|yellow|green|blue|purple|white|gr[ea]y|black)\b|\b(?:some|any|"
    r"no)(?:body|one|thing| one)\b|\bout of\b|\bmore than\b|\bat least\b|\bfewer than\b|\ba?round\b|有|在|看到|看见|"
    r"发现|没人|空|[红橙黄绿蓝紫白灰黑]色",
    re.IGNORECASE,
)
"""What shows that a look tells whether it is so."""
_NO_SIGHT: Final = re.compile(
    r"\b(?:battery|charge[ds]?|rain(?:s|ing)?|snow(?:s|ing)?|weather|storm|sunny|cold|warm|hot|tired|bored|happy|sad|"
    r"angry|hungry|thirsty|late|early|time|o'clock|noon|midnight|morning|evening|tonight|tomorrow|yesterday|was|were|"
    r"had|would|feel\w*|want|wish|like|mind|mood|problem|trouble|doubt|possible|ready|done|finished|hear|hears|noise|"
    r"music|say|says|ask|asks|call|calls|hit|lost|stuck|i'm|i am|you're|you are)\b|电量|没电|电低|下雨|下雪|天气|"
    r"天黑|累|时间|点钟|昨天|明天|刚才|之前|问题|声音|有空|心情|需要|叫你|你在|我在|办法|机会",
    re.IGNORECASE,
)
"""What shows that it does not: the weather, feelings, the time, what was, and what might be."""
_HYPOTHETICAL: Final = re.compile(r"\b(?:what|as|wonder(?:ing)?|even|know|sure|ask(?: \w+)?)$|好像$", re.IGNORECASE)
_ENDS: Final = re.compile(rf"[,;.?!，。；？！]|\bthen\b| (?=(?:{VERBS})\b)|就|那么|则|的话", re.IGNORECASE)


def first_look(text: str, vocabulary: Vocabulary) -> Calls:
    """Go there and look; nothing where no place is named, or where a look would tell nothing."""
    found = CONDITION.search(text)
    if found is None or _HYPOTHETICAL.search(text[: found.start()].rstrip()):
        return ()
    before, after = text[: found.start()], text[found.end() :]
    condition = found[0] if " " in found[0] else _ENDS.split(after.lstrip(" ,，"), maxsplit=1)[0]
    looks = _LOOKS.search(before) is not None
    if _NO_SIGHT.search(condition) or not (looks or _SIGHT.search(condition) or found[0] in ("是否", "有没有")):
        return ()
    chinese = is_chinese(text)
    within = condition if chinese else " ".join(_WITHIN.findall(condition))
    around = before if chinese else " ".join(_WITHIN.findall(before))
    comes_first = looks or (_GOES.search(before) is not None and _JOINS.search(before) is not None)
    parts = (before, within) if comes_first else (within, around)
    place = next((name for part in parts if (name := _first_named(part, vocabulary))), "")
    if not place:
        return ()
    if resolved(vocabulary.room, place) is not None:
        return (ActionCall("scan_room", (place,)),)
    return (ActionCall("navigation", (place,)), ActionCall("seewhat"))


def _first_named(text: str, vocabulary: Vocabulary) -> str:
    """The place that a text names first, by the longest of its names."""
    plain, said = text.casefold(), Statement(text)
    names = [name for name in (*vocabulary.rooms(), *vocabulary.places()) if len(name) > 1 and said.says(name)]
    found = [(plain.find(name), -len(name), name) for name in names if name in plain]
    return min(found)[2] if found else ""
