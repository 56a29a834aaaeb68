"""What people understand of a sentence that the robot says to them: which of the things in ``docs/people.md`` it wants,
and whom it means.

They know these few phrases in English and Chinese, and whether a sentence is a question.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Final, Literal

from engine.han import SIMPLER, is_chinese

Wish = Literal["name", "follow", "come along", "arrived", "lead", "take", "give", "pass", "answer", "nothing"]
"""What the robot wants of somebody: that they say who they are, follow it, do so again, stand, walk ahead, take what it
holds, give it what they hold, let it pass, answer a question; or nothing."""

COLOURS_ZH: Final[Mapping[str, str]] = {
    "red": "红", "orange": "橙", "yellow": "黄", "green": "绿", "blue": "蓝", "purple": "紫", "white": "白",
    "grey": "灰", "black": "黑",
}  # fmt: skip
"""What people wear, as it is said in Chinese."""
_ORDER = r"(?:^|[,.!?:] ?|\bplease )"
"""Before what somebody is asked to do: "I asked William to follow me" asks nobody."""
_ORDER_ZH = r"(?:^|[,，.。!！?？:：]\s*|请)"
_PHRASES: Final[dict[Wish, re.Pattern[str]]] = {
    "name": re.compile(r"\byour name\b|\bwho are you\b|你叫什么|你的名字|你是谁|怎么称呼"),
    "come along": re.compile(rf"{_ORDER}come along\b|{_ORDER_ZH}跟上"),
    "follow": re.compile(rf"{_ORDER}follow me\b|{_ORDER_ZH}(?:跟我来|跟我走|跟着我|跟随我)"),
    "lead": re.compile(r"\bi(?:'ll| will| shall|'m| am)? follow(?:ing)? you\b|我会?跟(?:着|随|在)?你"),
    "arrived": re.compile(r"\bhere we are\b|(?:^|[,，.。!！]\s*)到了|我们到了"),
    "take": re.compile(rf"\bplease take\b|{_ORDER}take (?:this|the)\b|请(?:拿着|拿好|接着|收下)"),
    "give": re.compile(rf"(?:{_ORDER}|\byou )(?:give|hand) me\b|{_ORDER_ZH}把.*[给递]我|{_ORDER_ZH}[给递](?:给)?我"),
    "pass": re.compile(rf"{_ORDER}(?:let me pass|step aside)\b|\bmay i pass\b|{_ORDER_ZH}(?:让一[下让]|让我过|借过)"),
}
_GOAL = re.compile(r"follow(?:ing)? you to (?:the )?([^?.!,]+)|跟(?:着|随|在)?你(?:去|到)([^？?，。！]+)")
_ARE_YOU = re.compile(r"\bare you (?:called |named )?([^?.!,]+)\?|你(?:是|叫)([^？?，。]+?)吗?\s*[？?]")
_QUESTION = re.compile(r"[?？]\s*$|[吗呢]\s*[。]?\s*$")


@dataclass(frozen=True, slots=True)
class Heard:
    """A sentence, as people understand it."""

    text: str  # as it was said
    wish: Wish
    to: str | None = None  # who is spoken to by name
    are_you: str | None = None  # the name that is asked after: "are you William?"
    goal: str = ""  # where the robot says it follows them to

    @property
    def chinese(self) -> bool:
        return is_chinese(self.text)

    def mentions(self, word: str) -> bool:
        """Whether the sentence has this in it, in whatever case."""
        return word.casefold() in self.text.casefold()


Names = Mapping[str, re.Pattern[str]]
"""Of people, and how each is spoken to."""


def names_of(people: Collection[str]) -> Names:
    """Their names, ready for :func:`understood`. Somebody is spoken to, and not only of, where the name begins a
    sentence or stands apart from the rest of it."""
    greeting = r"(?:(?:hello|hi|hey|excuse me|please|你好)[,，]?\s*)?"
    begins = rf"^\s*{greeting}{{name}}(?![a-z])"
    apart = rf"[,，.。!！?？]\s*{greeting}{{name}}\s*(?:[,，.。!！?？]|$)"
    return {name: re.compile(f"{begins}|{apart}".replace("{name}", re.escape(name.casefold()))) for name in people}


def understood(text: str, names: Names) -> Heard:
    """What a sentence wants, and of whom, where people have these names."""
    plain = text.casefold().translate(SIMPLER)
    to = next((name for name, is_called in names.items() if is_called.search(plain)), None)
    if (asked := _ARE_YOU.search(plain)) is not None:
        name, start = asked[1] or asked[2], max(asked.start(1), asked.start(2))
        # "Are you William?", and not "are you ready?": names are written with capitals, or are those of somebody here.
        if name.strip() in {other.casefold() for other in names} or text[start : start + 1].isupper():
            return Heard(text, "name", to, name.strip())
    wish = next((wish for wish, phrase in _PHRASES.items() if phrase.search(plain)), None)
    if wish is None:
        wish = "answer" if _QUESTION.search(plain) else "nothing"
    goal = _GOAL.search(plain) if wish == "lead" else None
    return Heard(text, wish, to, goal=goal[1] or goal[2] if goal is not None else "")
