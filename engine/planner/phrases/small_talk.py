"""Small talk: "hello", "how are you", "well done". It is answered with a sentence, and nothing moves.

Every part of a text between two punctuation marks has to be small talk, or politeness beside it: what holds anything
else is left to whoever understands that.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Final

from engine.han import is_chinese
from engine.planner.phrases.clauses import split
from engine.planner.phrases.templates import NOTHING, Templates, render
from engine.planner.text.language import any_of, without
from engine.planner.text.measures import read_measures
from engine.planner.text.words import words_of

MAX_PARTS: Final = 4
"""Who goes on for longer has a story to tell."""
_BY_THE_WAY: Final = frozenset({"Greeting", "Thanks", "Aside"})
"""What is said beside something else that is to be answered."""

_THINKS: Final = (
    "keep (?:a )?secrets?|think|feel|dream|love|hate|believe|remember|know|swim|fly|count|sing|whistle|laugh|cry|smile|"
    "see|hear|smell|taste|breathe|learn|lie|read|write|spell|draw|play|jump|run|climb|eat|drink|sleep|"
    "get (?:tired|bored|angry|lonely|sad|scared)|die|grow|speak|understand"
)
_JUDGED: Final = (
    "lovely|nice|beautiful|cold|hot|warm|raining|snowing|sunny|late|early|day|night|weekend|weather|freezing|boiling|"
    "relief|pity|shame|pleasure|surprise|outside|funny|boring|interesting|great|good|bad|sad|strange|weird|true|amazing|"
    "awful|terrible|fun|joke|quiet|loud|life|world"
)
_LEADS: Final = r"(?:and|but|so|tell me|say|hey|well|by the way)"
_ASIDES: Final = (
    ("Self", re.compile(
        rf"^(?:(?:good morning|robot|{_LEADS}) )*(?:"
        r"(?:do|don't|did|have|haven't|are|aren't|were|was|would|why|how|who|what|when|where|which|whose)\b"
        r".*\b(?:you|your|yourself|yours)\b"
        rf"|(?:can|can't|could|will) you (?:also |really |actually |even |ever )?(?:{_THINKS})\b)",
    )),
    ("Aside", re.compile(
        r"^(?:(?:and|but|so|oh|well|hey|wow|haha|ha|lol|hehe|yay|yippee|thanks|brr+|gosh|ah|aw|ugh|phew|you know|hm+|"
        r"today|tomorrow|yesterday|now) )*(?:"
        r"(?:i|we|he|she|they|you) (?!(?:can|could|should|must|may|might|will|would|have to|got to|are to|ought)\b)"
        r"\w+\b(?! (?:that you|you to))"
        r"|(?:i|we)(?:'m| am|'re| are|'ve| have| was| were| had| feel| felt| think| thought| love| hate| like| went|"
        r" saw| slept| forgot|'ll be| will be| might be| must be| never| always| used to| know| knew| hope| guess|"
        r" believe| did| didn't| don't| do)\b"
        r"|(?:my|our|his|her|their) (?:\w+ ){1,3}(?:is|are|was|were|has|had|likes?|loves?|came|comes|will)\b"
        r"|(?:the|this|that|these|those|what an?) [\w ]+ (?:was|were|tasted|smells|tastes)\b"
        r"|[\w' ]*\b(?:hilarious|delicious|tasty)\b"
        r"|(?:it|it's|that's|that|this|isn't it|wasn't that|what a|how|such a|he|she|they)"
        rf"(?: is| was| looks| sounds| must be|'s)?\b.*\b(?:{_JUDGED})\b)",
    )),
    ("Unknown", re.compile(
        rf"^(?:{_LEADS} )*(?:why|how (?:many|much|far|long|high|old|big|tall|deep|heavy|do|does|is|are)|who|whose|"
        r"what's|what is|what are|what was|what does|when|which|is it true|did|does|do|is|are|was|were|will|what time|"
        r"what day)\b(?!.*\b(?:your|here|there|my|me|i|we|robot|room|house|flat)\b)",
    )),
    ("Self", re.compile(
        r"^你(?!帮|给|去|来|把|拿|先|再|快|往|到|能不能|可以|可不可以|会不会).*[吗呢么？?]?$"
        r"|你(?:自己|喜欢|觉得|多大|几岁|是谁|为什么)"
    )),
    ("Aside", re.compile(
        r"^(?:今天|昨天|明天|我)(?!要|想要|需要|想喝|想吃|渴|饿|想让).*"
        r"(?:心情|累|困|开心|高兴|难过|无聊|天气|下雨|上班|生病|考试|生日|忙|烦|伤心)"
    )),
)  # fmt: skip
_WORK: Final = re.compile(
    r"\b(?:bring|fetch|carry|deliver|put|place|pick|grab|throw|drop|hand|drive|rotate|clean|tidy|wash|cook|open|close|"
    r"lock|unlock|water|feed|repair|fix|call|phone|text|order|buy|vacuum|iron|set|raise|lower|follow|please|need|want|"
    r"would like|could use|thirsty|hungry|there|somewhere|thing|it(?!')|them|if|unless|metres?|degrees|seconds|"
    r"i'd like|turn|go|move|come|take|give|look|find|stop|wait)(?:s|es|ing|ed)?\b"
    r"|拿|放|送|搬|扔|去|来|转|开|关|打扫|收拾|停|等|走|找|抬|举|跟"
)
"""What speaks of work is no mere talk, whatever else it is."""


class SmallTalk:
    """Knows the small talk of one language. Thread-safe."""

    def __init__(self, sections: Mapping[str, Any], templates: Templates) -> None:
        self._templates = templates
        self._answers: Mapping[str, str] = sections["answers"]["talk"]
        self._fillers = re.compile(any_of((*sections["fillers"], *sections["hesitations"])))

    def answer(self, text: str) -> str:
        """The answer to ``text``; empty where that is more than small talk, or nothing but politeness."""
        parts = split(read_measures(words_of(text).tokens), ())
        if not 0 < len(parts) <= MAX_PARTS:
            return ""
        kinds: list[str] = []
        for part in parts:
            said, _ = render(part.words)
            kind = next(filter(None, map(self._kind, (said, without(self._fillers, said)))), "")
            if not kind and without(self._fillers, said):
                return ""
            kinds += [kind] if kind else []
        kinds.sort(key=_BY_THE_WAY.__contains__)
        return self._answers[kinds[0]] if kinds else ""

    def aside(self, text: str, house: re.Pattern[str]) -> str:
        """The answer to a question about the robot itself, or to what somebody tells about themselves; empty where
        ``house`` finds a place or a thing in it, which is more than talk."""
        plain = render([token for token in read_measures(words_of(text).tokens) if token.kind != "mark"])[0]
        plain = "".join(plain.split()) if is_chinese(plain) else plain
        if house.search(plain) or _WORK.search(plain):
            return ""
        ways = (plain, without(self._fillers, plain))
        kind = next((kind for kind, pattern in _ASIDES if any(map(pattern.search, ways))), "")
        return self._answers[kind] if kind else ""

    def _kind(self, said: str) -> str:
        match = self._templates.match(said, NOTHING, "talk_intents") if said else None
        return match.intent if match is not None else ""
