"""A command that lacked something, and the answer to the question about it: the ways to make one sentence of them.

People answer with a word ("red"), a thing, a place with or without its preposition, a measure, or the half of a
command ("put it on the desk"). Each reading is only a proposal: whoever asks for them knows which one is a command.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Final, get_args

from engine.perception.sighting import Colour
from engine.planner.phrases.said import Calls
from engine.planner.request import Language, NoPlan

LONGEST: Final = 200
"""Longest command, and longest answer, that are put together, characters."""
_COLOURS: Final = "|".join((*get_args(Colour), "gray", "violet"))
_BEFORE: Final = re.compile(
    r"^(?:(?:i (?:mean|meant|think|guess|said|want|would say)|i'd (?:say|like)|please|um+|uh+|well|oh|ok|okay|yes|"
    r"sorry|maybe|perhaps|probably|just|only|rather|make (?:it|that)|let's say|say|how about|it's|it is|that's|"
    r"that would be)[,:]* )+(?=\S)",
    re.IGNORECASE,
)
_AFTER: Final = re.compile(
    r"(?:,? (?:if you please|please|sorry|i mean|i meant|i think|i guess|or so|then|maybe|thanks|thank you|of "
    r"course|obviously|"
    r"naturally|clearly|"
    r"i suppose|i believe|i reckon|i'd say|as far as i'm concerned|for all i care|"
    r"(?:would|will|should|ought to|might|that'll) (?:do|suffice|be (?:enough|plenty|fine|good|great|nice|perfect|"
    r"alright|all right))"
    r"(?: (?:it|nicely|for me|for now))?|"
    r"(?:is|would be) (?:fine|enough|good|great|nice|perfect)))+$",
    re.IGNORECASE,
)
_THING: Final = re.compile(
    r"\b(?:(?:the|that|this|some|a|another) )?(?:thing|stuff|object|item|one)s?\b|\bsome(?:thing|one|body)\b|\bthem\b"
    r"|\bit\b|\bthat\b",
    re.IGNORECASE,
)
_PLACE: Final = re.compile(
    r"\b(?:(?:over|up|down) )?there\b|\bsomewhere(?: else)?\b|\b(?:to the side|away|aside)\b", re.IGNORECASE
)
_AMOUNT: Final = re.compile(r" (?:for )?a (?:little )?(?:bit|little|while|moment)$", re.IGNORECASE)
_WHERE: Final = re.compile(r"\b(?:to|into|onto|on|in|at|by|under|behind|next to)\b", re.IGNORECASE)
_ARTICLE: Final = re.compile(r"^(?:to )?(?:the )?(?=\S)", re.IGNORECASE)
_NAMED: Final = re.compile(r"\b(?:the|my|a|an|your)\b", re.IGNORECASE)
_COLOUR: Final = re.compile(rf"(?:the )?(?:one (?:that|which) is )?({_COLOURS})(?: one| thing)?", re.IGNORECASE)
_NOUN: Final = re.compile(rf"\b(?:the|that|this|a|an|my) (?!(?:{_COLOURS})\b)(?=(\w+))", re.IGNORECASE)
_PUTS: Final = re.compile(r"\b(?:put|place|set|lay|leave)\b", re.IGNORECASE)
_OF_A_THING: Final = re.compile(
    r"\b((?:the|my|a|an|that|this) (?!thing|stuff|one|object|item)[\w ]+?)(?: (?:(?:over |up )?there|away|aside|"
    r"somewhere.*|to the side))?$",
    re.IGNORECASE,
)

_AS_FAR_AS: Final = re.compile(
    r"(?:(?:as far as|up to|until|till|right to|all the way to|to where) )(?=\w)", re.IGNORECASE
)
_OFFER: Final = re.compile(
    r"(?:shall|should|may|can|could) i (?P<do>[^?]+)|(?:do|would) you (?:want|like) me to (?P<what>[^?]+)|"
    r"要(?:不要)?我(?P<zuo>[^?？吗]+)|"
    r"我(?:来|去|可以|能|现在)*(?P<bang>(?:帮|给)[你您][^?？吗，]+?)，?(?:好吗|好不好|行吗|可以吗|吗)[?？]",
    re.IGNORECASE,
)
_YES: Final = re.compile(
    r"\W*(?:(?:oh|ok|okay|um+)\W+)?(?:yes|yeah|yep|yup|sure|ok|okay|please|please do|do (?:that|it|so)|go ahead|"
    r"of course|absolutely|exactly|right|correct|why not|that would be (?:nice|great|lovely))"
    r"(?:\W+(?:please|do|thanks|thank you|do (?:that|it)|go ahead|sure|robot))*\W*|"
    r"(?:好|好的|好啊|是|是的|对|行|可以|嗯|当然)[，,吧啊呀的。！ ]*(?:谢谢)?\W*",
    re.IGNORECASE,
)
_FROM_ME: Final = ((re.compile(r"\byour\b", re.IGNORECASE), "my"), (re.compile(r"\byou\b", re.IGNORECASE), "me"))

_BEFORE_ZH: Final = re.compile(r"^(?:就是|我说的是|我是说|我要|我想要|应该是|是|嗯|呃|哦|那就|[，,])+(?=.)")
_AFTER_ZH: Final = re.compile(r"(?:吧|就好|就行|就可以|好了|谢谢|啊|呀|哦|了|[，,])+$")
_THING_ZH: Final = re.compile(r"那个东西|这个东西|那东西|这东西|个东西|东西|那个|这个|它")
_PLACE_ZH: Final = re.compile(r"那里|那边|那儿|某个地方|别处|一边")
_PUT_ZH: Final = re.compile(r"(?:放|收|收起|收拾)(?:好|来|到那里|到那边|到一边)?$|(?:拿|搬)(?:走|开)$")
_COLOUR_ZH: Final = re.compile(r"(红|橙|黄|绿|蓝|紫|白|灰|黑|粉|棕)(?:色)?(?:的)?(?:那个)?")
_NOUN_ZH: Final = re.compile(r"(?<!的)(?=盒|杯|球|瓶|积木|方块)")
_OF_A_THING_ZH: Final = re.compile(r"[把将](.+?)(?=放|收|拿|搬|送|移|挪|带|扔)")
_OPTIONS: Final = re.compile(r"(?:.*[:：]|(?:which|哪).*?[,，])?(?P<options>[^:：?？]+)[?？]", re.IGNORECASE)
_BETWEEN: Final = re.compile(r",? or (?:the )?|, (?:the )?|、|还是|，")
_NOT_THIS: Final = re.compile(
    r"(?:(?:hm+|uh+|no|nope),? )?(?:not|anything but|any but|never) (?:the )?(?P<not>\w+)(?: (?:one|\w+))?(?: please)?"
    r"|(?:不要|不是|别拿)(?P<bu>[^，。的]+?)(?:色)?的?(?:那个)?",
    re.IGNORECASE,
)
""" "Not the red one"."""
_ONE_THERE: Final = re.compile(
    r"\b(?:the )?(?:one|it|that)(?:'s| is| that's| that is| which is)? (?:lying |standing |sitting )?"
    r"(?:on|in|at|by|next to|near|from|over by) (?:the |my |your )?(?P<where>[\w ]+)$",
    re.IGNORECASE,
)
""" "The one on the stool"."""
_ORDINAL: Final = re.compile(
    r"(?:the )?(?:(?P<first>first|1st|former)|(?P<second>second|2nd)|(?P<third>third|3rd)|(?P<last>last|latter))"
    r"(?: one)?"
    r"|第(?P<number>[一二三四五1-5])[个只]?|(?P<end>最后[一]?[个只]?)",
    re.IGNORECASE,
)


def chosen(question: NoPlan, answer: str, seen: Sequence[str] = ()) -> str:
    """What an answer such as "the second one" or, of what was ``seen``, "the one on the stool" chooses of "Which one:
    the red box or the blue cup?"; empty where it is no such answer."""
    names = question.options or _options(question.answer)
    ordinal = _ORDINAL.fullmatch(_AFTER.sub("", _BEFORE.sub("", answer.strip(" .!。"))))
    if len(names) < 2:
        return ""
    if (but := _NOT_THIS.fullmatch(_BEFORE.sub("", answer.strip(" .!。")))) is not None:
        left = [name for name in names if (but["not"] or but["bu"]).casefold() not in name.casefold()]
        return left[0] if len(left) == 1 and len(left) < len(names) else ""
    if (lies := _ONE_THERE.search(_AFTER.sub("", answer.strip(" .!。")))) is not None:
        there = [name for name in names if any(name in told and lies["where"].casefold() in told for told in seen)]
        return there[0] if len(there) == 1 else ""
    if ordinal is None:
        return ""
    if ordinal["number"]:
        place = "一二三四五".find(ordinal["number"]) if not ordinal["number"].isdigit() else int(ordinal["number"]) - 1
    else:
        place = {"first": 0, "second": 1, "third": 2}.get(ordinal.lastgroup or "", -1)
    return names[place] if place < len(names) else ""


def _options(question: str) -> tuple[str, ...]:
    """The names between which a model asks."""
    found = _OPTIONS.match(question)
    parts = _BETWEEN.split(found["options"]) if found is not None else ()
    return tuple(name.strip().removeprefix("the ") for name in parts if name.strip())


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


def completed(pending: str, answer: str, language: Language) -> Iterator[str]:
    """Sentences that ``pending`` may have meant, now that ``answer`` has been given; the likeliest first."""
    pending, answer = pending.strip().rstrip(".!?。！？"), answer.strip().rstrip(".!?。！？")
    if pending and answer and max(len(pending), len(answer)) <= LONGEST:
        yield from dict.fromkeys((_chinese if language == "zh" else _english)(pending, answer))


def _english(pending: str, answer: str) -> Iterator[str]:
    plain = _AFTER.sub("", _BEFORE.sub("", answer)) or answer
    bare = _ARTICLE.sub("", plain)
    yield from _coloured(pending, plain, _COLOUR, _NOUN, "{} ")
    for noun in _NOUN.finditer(pending):  # "the box" in the one, "the red box" in the other
        if bare.casefold().endswith(f" {noun[1].casefold()}"):
            yield f"{pending[: noun.start()]}the {bare}{pending[noun.end(1) :]}"
    if (thing := _OF_A_THING.search(pending)) and re.search(r"\b(?:it|that|them)\b", plain):
        yield re.sub(r"\b(?:it|that|them)\b", thing[1], plain, count=1)  # "put it on the desk"
    for place in _PLACE.finditer(pending):
        before, after = pending[: place.start()], pending[place.end() :]
        spots = [plain] if _WHERE.match(plain) else []
        joints = ("on", "in", "to") if _PUTS.search(before) else ("to", "in", "on")
        spots += [f"{joint} the {bare}" for joint in joints] + [f"to {bare}", bare]
        yield from (f"{before}{spot}{after}" for spot in spots)
        for thing in _THING.finditer(before.rstrip()):  # it tells both
            yield f"{before[: thing.start()]}the {bare}{before[thing.end() :].rstrip()}{after}"
    for thing in _THING.finditer(pending):
        words = (plain, bare) if _NAMED.match(plain) else (f"the {bare}", bare, plain)
        yield from (f"{pending[: thing.start()]}{word}{pending[thing.end() :]}" for word in (*words, answer))
    if goal := _AS_FAR_AS.match(plain):
        yield f"go to {plain[goal.end() :]}"
    shorter = _AMOUNT.sub("", pending)
    for joint in (" ", " to ", " to the ", " by ", " for ", " the "):
        yield from (f"{shorter}{joint}{words}" for words in (answer, plain, bare))


def _chinese(pending: str, answer: str) -> Iterator[str]:
    plain = _AFTER_ZH.sub("", _BEFORE_ZH.sub("", answer)) or answer
    yield from _coloured(pending, plain, _COLOUR_ZH, _NOUN_ZH, "{}色的")
    thing = _OF_A_THING_ZH.search(pending)
    if thing and re.match(r"[放扔送拿搬收]", plain):
        yield f"把{thing[1]}{plain}"
    if put := _PUT_ZH.search(pending):
        yield from (f"{pending[: put.start()]}{way}{plain}" for way in ("放到", "放在", "放进", "拿到"))
    for vague in (*_THING_ZH.finditer(pending), *_PLACE_ZH.finditer(pending)):
        for words in (plain, answer):
            yield f"{pending[: vague.start()]}{words}{pending[vague.end() :]}"
    for joint in ("", "到", "去"):
        yield from (f"{pending}{joint}{words}" for words in (answer, plain))
    yield f"把{plain}{pending}"


def _coloured(pending: str, answer: str, colour: re.Pattern[str], noun: re.Pattern[str], form: str) -> Iterator[str]:
    """The things of ``pending`` with a colour, where the answer is nothing else."""
    if found := colour.fullmatch(answer):
        for thing in noun.finditer(pending):
            yield f"{pending[: thing.end()]}{form.format(found[1])}{pending[thing.end() :]}"
