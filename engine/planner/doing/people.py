"""Acts on people: finding, meeting, following, guiding them, and talking with them.

Who is meant is said by a name, a description or a pronoun; where they are, beside it ("the person at the sink").
Whoever is only named, and neither known here nor said to be anywhere, is asked about.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from engine.errors import PlanError
from engine.facts import fact
from engine.han import is_chinese
from engine.plan import ActionCall, Quantity
from engine.planner.doing.doing import Doing, NowhereKnown, Open, Roles, Unable, is_everywhere
from engine.planner.phrases.said import Calls, call
from engine.skills.places import ZERO_SYMBOL
from engine.skills.vocabulary import ME


def as_name(words: str) -> str:
    """A name as it is written."""
    name = words.strip(" .,!?。，！？")
    return name.title() if name.islower() else name


def somebody(doing: Doing, words: str, where: str = "", *, stranger: bool = False) -> tuple[str, str]:
    """Who these words mean, as skills know them, and the room or the piece of furniture where they are said to be, else
    nothing. Raises Open for a pronoun that nobody was named for, and for a stranger without a name ("my aunt") of whom
    nobody said where they are, unless that does no harm (``stranger``)."""
    words = _WHOEVER.sub("everyone", _AT_HOME.sub("", words))
    plain = " ".join(words.casefold().split()).strip(" ,.!?")
    if _PRONOUN.fullmatch(plain):
        if not doing.who:
            raise Open("who")
        return doing.who, spot(doing, where) or doing.there
    if doing.entities.of(words).me:
        return ME, spot(doing, where)
    try:
        who, at = doing.entities.somebody(words)
    except PlanError:
        raise Unable("person", words) from None
    there = spot(doing, where or at)
    if doing.entities.is_stranger(who) and not there and not stranger and not (doing.depends and not doing.found):
        there = doing.entities.place_name(doing.place)  # where it has just been sent
        if (
            not there
            and _NO_NAME.match(plain)
            and who.name.casefold().endswith(_NO_NAME.sub("", plain, count=1).strip())
        ):
            raise Open("where_person")
    doing.who = str(who)
    return doing.who, there


_PRONOUN: Final = re.compile(r"(?:to |for |with |from )?(?:him|her|them|he|she|they)(?:self|selves)?|[他她]们?")


_AT_HOME: Final = re.compile(
    r"(?<=\w) (?:in|at|around|of) (?:(?:the|this|our|my) )?(?:whole |entire )?"
    r"(?:house|home|flat|apartment|building|place)$|"
    r"^(?:整个)?(?:家|屋子|房子)里?的(?=.)",
    re.IGNORECASE,
)
"""Where everybody is who is here."""
_WHOEVER: Final = re.compile(
    r"^who(?:so)?ever(?:(?:'s| is)(?: (?:there|here|around|about|home|inside)\b)?)?", re.IGNORECASE
)
"""All those who are there."""
_NO_NAME: Final = re.compile(
    r"(?:the|an?|my|our|your|his|her|their|that|this)\b|[我你他她]们?的?(?![^\W\d_]*[A-Za-z])|[这那]"
)
"""What whoever has no name is spoken of with."""


def spot(doing: Doing, words: str) -> str:
    """Where somebody is: a room or a piece of furniture by its name. Raises NowhereKnown."""
    if not words:
        return ""
    found = doing.where(words)
    if not (found.room or found.surface or found.place) and is_everywhere(words):
        return ""
    if found.me or (found.refers and not found.place):
        return ""
    if found.room is None and found.surface is None and found.place is None:
        raise NowhereKnown(doing.entities.near(words))
    if found.place is not None:
        doing.place = found.place
    return found.room or found.surface or doing.entities.place_name(found.place or "")


def named(doing: Doing, roles: Roles, *, stranger: bool = False) -> tuple[str, str]:
    """The person of an act, and where; anybody where none is said."""
    words, where = roles.words("person"), roles.words("place") or roles.words("source")
    if not words:
        return "person", spot(doing, where)
    return somebody(doing, words, where, stranger=stranger)


def find_person(doing: Doing, who: str, where: str) -> Calls:
    """Go where they are said to be, and for a stranger through the rooms; a stranger is asked for the name. Nothing
    where nobody has to be looked for."""
    met = any(who in made.positional for made in doing.calls) or (doing.depends and who == doing.found)
    if who == ME or (not where and (met or not doing.entities.is_name(who))):
        return ()
    return _looked_for(doing, who, where)


def _looked_for(doing: Doing, who: str, where: str) -> Calls:
    return call("meet" if doing.entities.is_name(who) else "find_person", who, *((where,) if where else ()))


def find(doing: Doing, roles: Roles) -> Calls:
    """Whoever is only named, and is no one whom the robot knows, is asked for the name where somebody is found."""
    who, where = named(doing, roles, stranger=True)
    return _looked_for(doing, who, where)


def found(doing: Doing, words: str) -> Calls:
    """To somebody, wherever they are."""
    who, where = somebody(doing, words)
    return call("find_person", who, *((where,) if where else ()))


def meet(doing: Doing, roles: Roles) -> Calls:
    who, where = named(doing, roles)
    return call("meet", who, *((where,) if where else ()))


def before(doing: Doing, roles: Roles) -> Calls | None:
    """Up to the one person of an act, or to where people are said to be; None where that is whoever is here."""
    words, place = roles.all("person"), roles.words("place")
    if len(words) != 1 or doing.entities.of(words[0]).me or are_several(doing, words[0]):
        return call("navigation", doing.spot(place)) if place else None
    try:
        who, there = somebody(doing, words[0], place)
    except (Open, Unable):
        return call("navigation", doing.spot(place)) if place else None
    if doing.entities.is_known(words[0]):
        return call("meet", who, *((there,) if there else ()))
    return find_person(doing, who, there) or None


def follow(doing: Doing, words: str, place: str, source: str) -> Calls:
    """Behind one person among several, to a place where one is said."""
    who, at = somebody(doing, words, source)
    first = call("meet", who, at) if at else find_person(doing, who, "")
    to = (doing.spot(place),) if place and not _OUT.search(place.casefold()) else ()
    if who == ME and not to:
        return call("person_follow")
    return (*first, *call("person_follow", "person" if who == ME else who, *to))


def until_they_stand(calls: Sequence[ActionCall]) -> list[ActionCall]:
    """Whoever is followed nowhere in particular is followed until they stand, where something is to be done then."""
    made = list(calls)
    for index, made_call in enumerate(made[:-1]):
        if made_call.name == "person_follow" and len(made_call.positional) < 2 and not made[index + 1].alongside:
            who = made_call.positional[:1] or ("person",)
            made[index] = replace(made_call, positional=(*who, "", Quantity(STANDS_S, "s")))
    return made


STANDS_S: Final = 6.0
_OUT: Final = re.compile(r"\bwherever|\boutside\b|\baround\b|到处|外面")


def guide(doing: Doing, words: str, place: str, source: str) -> Calls:
    """Ahead of somebody, who is met first where they are said to be."""
    who, at = somebody(doing, words, source) if words else (doing.who or ME, "")
    if not place and not _BACK.search(doing.said.casefold()):
        raise Open("where")
    first = call("meet", who, at) if at else find_person(doing, who, "")
    return (*first, *call("guide", who, doing.spot(place) if place else _back(doing)))


def _back(doing: Doing) -> str:
    """Where somebody is led back to: whom the speaker wants here, here; anybody else to the place where they were."""
    return ZERO_SYMBOL if not doing.place or _HERE.search(doing.said.casefold()) else doing.place


_BACK: Final = re.compile(r"\bback\b|回来|回去")
_HERE: Final = re.compile(r"\bbring\b.*\bback\b|\bback (?:here|to me|with you)\b|回来")


def tell(doing: Doing, words: str, where: str, text: str) -> Calls:
    """Gone to and told; several people each by themselves, in all rooms where none is said."""
    everybody = _ALL_OF_THEM.match(text)
    if are_several(doing, words) or everybody is not None or (words.endswith("人") and _ALL_ZH.search(doing.said)):
        text = text[everybody.end() :] if everybody is not None else text
        kind, room = somebody(doing, words, where)
        return call("tell_everyone", text, kind, *((room,) if room else ()))
    who, there = somebody(doing, words, where)
    return (*find_person(doing, who, there), *call("tell", who, message(text)))


def message(text: str) -> str:
    """What is told, as it is said to the person: "that she is late" → "You are late", "to take his coat" → "Please take
    your coat". As it is where more than one person is spoken of."""
    plain = text.strip(" .!")
    spoken_of = {found[0].casefold() for found in _THIRD.finditer(plain)}
    if not plain.isascii() or sum(not spoken_of.isdisjoint(one) for one in _EACH_PERSON) > 1:
        return text
    turned = re.sub(r"^to (?=[a-z])", "please ", plain)
    turned = re.sub(r"^(?:he|she|they)(?:'s|'re| is| are)\b", "you are", turned, flags=re.I)
    turned = re.sub(r"^(?:he|she|they) (?:has|have)\b", "you have", turned, flags=re.I)
    turned = re.sub(r"^(?:he|she|they) (?=(?:can|could|may|must|should|will|would|need)\b)", "you ", turned, flags=re.I)
    turned = re.sub(r"^(?:he|she|they) needs\b", "you need", turned, flags=re.I)
    if turned == plain:
        return text
    turned = re.sub(r"\b(?:his|her|their)\b(?= \w)", "your", turned)
    turned = re.sub(r"\b(?:him|her|them|he|she|they)\b", "you", turned)
    return f"{turned[:1].upper()}{turned[1:]}"


_THIRD: Final = re.compile(r"\b(?:he|him|his|she|her|they|them|their)\b", re.IGNORECASE)
_EACH_PERSON: Final = (frozenset({"he", "him", "his"}), frozenset({"she", "her"}), frozenset({"they", "them", "their"}))


_ALL_ZH: Final = re.compile(r"人.{0,3}都[说讲告通]")
"""That each of the people is told it, in Chinese."""
_ALL_OF_THEM: Final = re.compile(r"都(?=[\u3400-\u9fff])")
"""Behind those who are told something: each of them is."""


def ask(doing: Doing, roles: Roles) -> Calls:
    text = roles.words("text") or roles.words("topic")
    words, where = roles.words("person"), roles.words("place")
    if not text:
        raise Open("what")
    who, there = somebody(doing, words, where) if words else ("person", spot(doing, where))
    if who == ME:
        return call("say", question(text))
    found = find_person(doing, who, there)
    if _LEAVES.search(text.casefold()):
        return tell(doing, words, where, "Please leave." if text.isascii() else "请您离开。")
    return (*found, *call("ask_person", who, question(text)))


_LEAVES: Final = re.compile(r"^(?:to )?(?:please )?(?:leave|go(?: away)?|get out)\b|^(?:请)?(?:离开|出去)")


def question(text: str) -> str:
    """What is asked, as it is said to the person: "what she would like to drink" → "What would you like to drink?"."""
    plain = text.strip(" .?!。？")
    if not plain.isascii():
        return f"请问，{re.sub('[他她]们?', '您', plain)}？"
    plain = re.sub(r"\b(he|she|they)(?=(?:s|re|ve|ll|d)\b)", r"\1'", plain, flags=re.I)  # "shes" is she's
    plain = re.sub(r"\b(he|she|they)'(s|re|ve)\b", _written_out, plain, flags=re.I)
    plain = re.sub(r"^(?:about|for|to tell (?:me|you|us)|to say)\s+", "", plain, flags=re.I)
    plain = re.sub(r"^(?:if|whether)\s+(?:he|she|they)\s+", "do you ", plain, flags=re.I)
    plain = re.sub(r"^do you (is|are|has|have|would|will|can|wants?|likes?|needs?)\b", _first, plain, flags=re.I)
    plain = re.sub(rf"^({_ASKS}) (it|that|this|the [\w ]+?) (is|are|was|were)$", r"\1 \3 \2", plain, flags=re.I)
    turned = re.sub(
        r"^(what|where|when|why|how(?: \w+)?|which \w+|who)\s+(?:he|she|they|he's|she's)\s*"
        r"(would|will|can|could|should|is|are|was|has|have|\w+s)?\s*\b",
        _inverted,
        plain,
        flags=re.I,
    )
    turned = re.sub(r"\b(?:his|her|their)\b", "your", re.sub(r"\b(?:him|them)\b", "you", turned))
    if not re.match(r"(?:what|where|when|why|how|which|who|do|does|is|are|would|will|can|could|have)\b", turned, re.I):
        turned = f"what {'is' if turned.casefold().startswith('your ') else 'about'} {turned}"
    return f"{turned[:1].upper()}{turned[1:].rstrip()}?"


_ASKS: Final = r"what|where|when|why|who|how(?: \w+)?|which(?: \w+)?"


def _written_out(found: re.Match[str]) -> str:
    return f"{found[1]} {'have' if found[2] == 've' else 'are' if found[2] == 're' else 'is'}"


def _first(found: re.Match[str]) -> str:
    verb = {"is": "are", "has": "have"}.get(found[1].casefold(), found[1].casefold())
    if verb.rstrip("s") in ("want", "like", "need"):
        return f"do you {verb.rstrip('s')}"
    return f"{verb} you"


def _inverted(found: re.Match[str]) -> str:
    verb = (found[2] or "do").casefold()
    if verb in ("is", "was", "has") or not verb.endswith("s"):
        return f"{found[1]} {_TURNED.get(verb, verb)} you "
    return f"{found[1]} do you {re.sub('(?<=[osxh])es$|s$', '', verb)} "  # "where he lives"


_TURNED: Final = {"is": "are", "was": "were", "has": "have"}


def introduce(doing: Doing, roles: Roles) -> Calls:
    """Whoever is introduced is met where they are said to be, and named to the others. With nobody, or one person and
    "yourself", the robot tells of itself."""
    people, where = roles.all("person"), roles.all("place")
    to, there = (people[-1], where[-1] if where else "") if people else ("", "")
    if len(people) < 2:
        if not _YOURSELF.search(doing.said.casefold()):
            raise Open("who")
        itself = "你自己" if is_chinese(doing.said) else "something about yourself"
        return tell(doing, to, there, itself) if to else call("say", fact(itself))
    at = where[0] if len(where) > 1 else ""
    if doing.entities.of(people[0]).me:
        return tell(
            doing, to, there, "有人想认识您。" if is_chinese(doing.said) else "Somebody here would like to meet you."
        )
    one, met = somebody(doing, people[0], at)
    first = call("meet", one, met) if met else ()
    return (*first, *tell(doing, to, there, _introduced(one, at, is_chinese(doing.said))))


def _introduced(one: str, at: str, chinese: bool) -> str:
    if chinese:
        return f"给您介绍{one}{f'，就在{at}' if at else ''}。"
    return f"I would like to introduce {one}{f', who is at {at}' if at else ''}."


_YOURSELF: Final = re.compile(r"\byourself\b|自己|自我")


def are_several(doing: Doing, words: str) -> bool:
    """Whether each of several people is meant: "everyone", "the guests"."""
    found = doing.entities.of(_WHOEVER.sub("everyone", words)) if words else None
    return found is not None and found.every and bool(found.person)


def hand(doing: Doing, words: str, where: str = "") -> Calls:
    """What is held, into somebody's hand."""
    who, there = somebody(doing, words, where)
    return (*find_person(doing, who, there), *call("hand_over", who))


def take(doing: Doing, thing: str, words: str, where: str = "") -> Calls:
    who, there = somebody(doing, words, where)
    known = thing and doing.entities.of(thing).thing is not None  # what they put into the hand will do
    return (*find_person(doing, who, there), *call("take_from", who, *((thing,) if known else ())))


def count(doing: Doing, roles: Roles) -> Calls:
    said, place = roles.all("person"), roles.words("place")
    words = said[-1] if said else ""
    if (state := _ARE.search(doing.said)) is not None:
        words = f"{words} {state[1]}"
    elif (state := _ARE_ZH.search(doing.said)) is not None:
        words = words.rpartition("是")[2] if state[1] in words else f"{state[1]}的{words}"
    try:
        who, at = doing.entities.somebody(words)
    except PlanError:
        raise Unable("person", words) from None
    room = spot(doing, place or at)
    return call("count_people", str(who), *((room,) if room else ()))


_ARE: Final = re.compile(
    r"\bare (?:they )?((?:sitting|standing|lying|waving|pointing|raising|wearing|dressed|men|women|male|female|"
    r"boys|girls)[^,.?!]*)[.?!]?$",
    re.I,
)
"""What is asked of them behind the place: "how many people in the kitchen are sitting"."""
_ARE_ZH: Final = re.compile(
    r"人.*?((?:坐|站|躺|挥|举|指|穿)[^，。？！?的]*|[男女][孩人士性生]?)(?:的)?[呢啊吗]?[。？！?!]?$"
)
"""The same in Chinese, where it stands at the end, too."""


def describe(doing: Doing, roles: Roles) -> Calls:
    who, where = named(doing, roles)
    topic = next((name for name, pattern in _TOPICS if pattern.search(roles.words("topic").casefold())), "")
    return (*find_person(doing, who, where), *call("describe_person", who, *((topic,) if topic else ())))


_TOPICS: Final = (
    ("name", re.compile(r"\bname|called|who\b|名字|叫什么|是谁")),
    ("gender", re.compile(r"gender|\bsex\b|\bman or|male|性别|男|女")),
    ("pose", re.compile(r"\bpose|posture|sitting|standing|lying|姿势|坐|站|躺")),
    ("gesture", re.compile(r"gesture|waving|pointing|rais|手势|挥手")),
    ("clothes", re.compile(r"wear|cloth|dress|shirt|colou?r|穿|衣服")),
)
"""What of somebody is asked about, in the order in which it is tried."""


def answer(doing: Doing, roles: Roles) -> Calls:
    """A fact said to somebody, or the question that they have answered."""
    topic, words, where = roles.words("topic"), roles.words("person"), roles.words("place")
    who, there = somebody(doing, words, where) if words else (doing.who or "person", spot(doing, where))
    if who == ME:
        if not (answered := fact(topic)):
            raise Unable("act")
        return call("say", answered)
    found = find_person(doing, who, there)
    if _QUESTION.search(topic.casefold()):
        return (*found, *call("answer_question", who))
    return (*found, *call("tell", who, topic))


_QUESTION: Final = re.compile(r"\bquestions?\b|问题|提问")
