"""What an answer to a question of the robot chooses: the second one, not the red one, yes to what was offered."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from engine.planner.phrases.said import Calls
from engine.planner.request import NoPlan

_YES: Final = re.compile(
    r"\W*(?:(?:oh|ok|okay|um+)\W+)?(?:yes|yeah|yep|yup|sure|ok|okay|please|please do|do (?:that|it|so)|go ahead|"
    r"of course|absolutely|exactly|right|correct|why not|that would be (?:nice|great|lovely))"
    r"(?:\W+(?:please|do|thanks|thank you|do (?:that|it)|go ahead|sure|robot))*\W*|"
    r"(?:好|好的|好啊|是|是的|对|行|可以|嗯|当然)[，,吧啊呀的。！ ]*(?:谢谢)?\W*",
    re.IGNORECASE,
)
_OFFER: Final = re.compile(
    r"(?:shall|should|may|can|could) i (?P<do>[^?]+)|(?:do|would) you (?:want|like) me to (?P<what>[^?]+)|"
    r"要(?:不要)?我(?P<zuo>[^?？吗]+)|"
    r"我(?:来|去|可以|能|现在)*(?P<bang>(?:帮|给)[你您][^?？吗，]+?)，?(?:好吗|好不好|行吗|可以吗|吗)[?？]",
    re.IGNORECASE,
)
_FROM_ME: Final = ((re.compile(r"\byour\b", re.IGNORECASE), "my"), (re.compile(r"\byou\b", re.IGNORECASE), "me"))
_OPTIONS: Final = re.compile(r"(?:.*[:：]|(?:which|哪).*?[,，])?(?P<options>[^:：?？]+)[?？]", re.IGNORECASE)
_BETWEEN: Final = re.compile(r",? or (?:the )?|, (?:the )?|、|还是|，")
_NOT_THIS: Final = re.compile(
    r"(?:\w+,? )?(?:not|anything but|any but|never) (?:the )?(?P<not>\w+)(?: (?:one|\w+))?(?: please)?"
    r"|(?:不要|不是|别拿)(?P<bu>[^，。的]+?)(?:色)?的?(?:那个)?",
    re.IGNORECASE,
)
_ONE_THERE: Final = re.compile(
    r"(?:\b(?:the )?(?:one|it|that)(?:'s| is| that's| that is| which is)? (?:lying |standing |sitting )?)?"
    r"\b(?:on|in|at|by|next to|near|from|over by) (?:the |my |your )?(?P<where>[\w ]+)$",
    re.IGNORECASE,
)
_ORDINAL: Final = re.compile(
    r"\b(?:(?P<first>first|1st|former)|(?P<second>second|2nd)|(?P<third>third|3rd)|(?P<last>last|latter))\b"
    r"|第(?P<number>[一二三四五1-5])|(?P<end>最后)",
    re.IGNORECASE,
)
_PLACES: Final = {"first": 0, "second": 1, "third": 2}


def chosen(question: NoPlan, answer: str, seen: Sequence[str] = ()) -> str:
    """What an answer such as "the blue cup", "the second one", "not the red one" or, of what was ``seen``, "the one on
    the stool" chooses of "Which one: the red box or the blue cup?"; empty where it is no such answer."""
    names = question.options or _options(question.answer)
    said = answer.strip(" .!。")
    if len(names) < 2:
        return ""
    plain = said.casefold().removeprefix("the ")
    if named := next((name for name in names if name.casefold() == plain), ""):
        return named
    if (but := _NOT_THIS.fullmatch(said)) is not None:
        left = [name for name in names if (but["not"] or but["bu"]).casefold() not in name.casefold()]
        return left[0] if len(left) == 1 else ""
    if (ordinal := _ORDINAL.search(said)) is not None:
        number = ordinal["number"]
        place = "一二三四五12345".find(number) % 5 if number else _PLACES.get(ordinal.lastgroup or "", -1)
        return names[place] if place < len(names) else ""
    if (lies := _ONE_THERE.fullmatch(said)) is not None:
        there = [name for name in names if any(name in told and lies["where"].casefold() in told for told in seen)]
        return there[0] if len(there) == 1 else ""
    return ""


def agreed(question: NoPlan, answer: str) -> Calls | str:
    """What a plain yes makes of an offer: the actions that were offered, or the request that a model's question is
    ("Shall I bring you the bottle?"); nothing for any other answer."""
    if _YES.fullmatch(answer) is None:
        return ""
    if question.offer:
        return question.offer
    offer = _OFFER.search(question.answer)
    if offer is None:
        return ""
    words = next(words for words in offer.groups() if words)
    for pattern, word in _FROM_ME:
        words = pattern.sub(word, words)
    return words.replace("你", "我").replace("您", "我").strip()


def _options(question: str) -> tuple[str, ...]:
    """The names between which a model asks."""
    found = _OPTIONS.match(question)
    parts = _BETWEEN.split(found["options"]) if found is not None else ()
    return tuple(name.strip().removeprefix("the ") for name in parts if name.strip())
