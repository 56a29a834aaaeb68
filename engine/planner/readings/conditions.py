"""Requests that depend on what is there: "if there is an apple on the table, bring it to the kitchen, otherwise beep".

Nobody knows beforehand what the robot will see, so such a request is taken apart instead of guessed: where to look,
what for, and what to do in either case. The reader is precise rather than greedy: a sentence that it does not
understand to its last word, or that hangs on something that a look does not tell ("if the battery is low"), is none.
English is read here, with its clauses in ``presence.py`` and what is to follow in ``consequences.py``; Chinese in
``conditions_zh.py``.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

from engine.han import is_chinese
from engine.planner.readings import conditions_zh
from engine.planner.readings.consequences import POLITE, VERBS, consequence, is_request
from engine.planner.readings.presence import Presence, is_one, plainly, presence
from engine.planner.request import Conditional

MAX_TEXT: Final = 300
"""Longest request that is looked at, characters."""


def conditional(text: str) -> Conditional | None:
    """Take ``text`` apart; None where it is no condition on what can be seen, or is not understood in full."""
    if len(text) > MAX_TEXT:
        return None
    plain = re.sub(r"[ ,，;；.。]*[()][ ,，;；]*", ", ", unicodedata.normalize("NFKC", text).replace("’", "'"))
    plain = " ".join(plain.split()).strip(" ,，.!?。")
    return conditions_zh.read(plain) if is_chinese(plain) else _english(_YES_NO.sub(r"\g<mark> if \g<said>, ", plain))


_YES_NO: Final = re.compile(r"(?P<mark>[?.;])\W*(?P<said>yes|no)\b[:,;]? ", re.IGNORECASE)
""" "Is it there? Yes: bring it. No: beep"."""


def _english(text: str) -> Conditional | None:
    if _DEPENDS.search(text) is None:
        return None
    for read in (_looked, _asked, _leading, _trailing):
        for sentence in read(text):
            if (found := _taken(sentence)) is not None:
                return found
    return None


@dataclass(frozen=True, slots=True)
class _Sentence:
    """A request with a condition, cut into its parts but not yet understood."""

    before: str
    about: Presence
    then: str
    """With what is to be done otherwise still in it."""


_DEPENDS: Final = re.compile(
    r"\b(?:if|when|whenever|in case|in the event|on condition|unless|whether|in that case|provided|providing|assuming|"
    r"supposing|as long as|so long as|should|(?:is|are) there|any(?:thing|body|one)?)\b|\?",
    re.IGNORECASE,
)
"""Without one of these words there is no condition."""
_IF: Final = (
    r"(?:(?:but )?(?:only )?(?:if|when|whenever|in case|in the event that|(?:on condition|provided|providing|assuming|"
    r"supposing)(?: that)?|as long as|so long as)|should)"
)
_JOINT = r"(?:(?:[,;:.?!]|\b(?:and|then|but|so)\b)[ ,]*)+"
_START = rf"(?:^|(?P<joint> ?{_JOINT}))"
_OPENER: Final = re.compile(rf"{_START}{POLITE}(?:{_IF}|(?P<unless>unless|except if)) ", re.IGNORECASE)
_CLOSER: Final = re.compile(rf",? (?:{_IF}|(?P<unless>unless|except if)) ", re.IGNORECASE)
_BREAK: Final = re.compile(
    rf" ?[,;:.?!]+ ?(?:and |so )?(?:then,? |please )?| (?:and )?then,? |"
    rf" (?!(?:(?<=\bis )|(?<='s )|(?<=\bare )|(?<=n't ))(?:empty|clear|clean|free|open)\b)(?={POLITE}(?:{VERBS})\b)",
    re.IGNORECASE,
)
"""Where a condition may end and what is to be done begin."""
_GOES_TO = r"(?:(?:please )?(?:go|pop|run|nip|drive|head)(?: over| back)?(?: and| to)? )?"
_CHECKS: Final = re.compile(
    rf"{_START}{POLITE}(?:i want to know |i'd like to know |{_GOES_TO}(?:check|look|see|find out|(?:have|take) a "
    r"(?:look|peek)|tell me|verify|confirm|make sure) )(?:(?:to see |and see )?(?:if|whether)|that) ",
    re.IGNORECASE,
)
_CHECKS_BARE: Final = re.compile(
    rf"{_START}{POLITE}{_GOES_TO}(?:check|make sure|see|verify) "
    r"(?=nobody|no one|nothing|there|the \w+(?: \w+)?(?: is|'s)\b)",
    re.IGNORECASE,
)
_SEEKS: Final = re.compile(
    rf"{_START}{POLITE}{_GOES_TO}(?:(?:look|search|hunt|check|have a look|take a look) for|try (?:to|and) find|find|"
    r"(?:see|check) (?:if|whether) (?:you|we) can (?:find|see|spot)) ",
    re.IGNORECASE,
)
_ANSWER: Final = re.compile(rf"(?: ?{_JOINT}| )(?:(?P<said>in that case)|{_IF} (?!and\b))", re.IGNORECASE)
"""Where it is said what is to be done if what was asked or looked for is so."""
_IS_SO: Final = re.compile(
    r"in that case|so|yes|yes it is|that is (?:so|the case|true)|that's (?:so|the case|true)|it does|possible",
    re.IGNORECASE,
)
_ELSE: Final = re.compile(
    r"[,;.]? ?\b(?:and |but )?(?:otherwise|or else|or otherwise|else|if not|if no|"
    r"(?:should it be|if it(?:'s| is)) (?:anywhere|somewhere) else)\b(?: then)?,? ",
    re.IGNORECASE,
)


def _parted(text: str) -> Iterator[tuple[str, str]]:
    """Everywhere ``text`` can be cut in a condition and what is to be done."""
    for match in _BREAK.finditer(text):
        yield text[: match.start()], text[match.end() :]


def _cut(text: str, opener: re.Pattern[str]) -> Iterator[tuple[re.Match[str], str, str]]:
    """What stands before and after each ``opener``."""
    for match in opener.finditer(text):
        yield match, text[: match.start()], text[match.end() :]


def _answers(text: str) -> Iterator[tuple[str, str, str]]:
    """What stands before an "if so", its condition ("so"), and what is to be done then, on whichever side it stands."""
    for match, before, rest in _cut(text, _ANSWER):
        if match["said"]:
            yield before, "so", rest
            continue
        yield from ((before, said, then) for said, then in _parted(rest))
        yield from ((asked.removesuffix(" and"), rest, then) for asked, then in _parted(before))


def _looked(text: str) -> Iterator[_Sentence]:
    """ "Check whether the cup is on the table, and if so …"; "look for it, if it isn't there …"."""
    for opener, as_clause in ((_SEEKS, "there is {}"), (_CHECKS, "{}"), (_CHECKS_BARE, "{}")):
        for _, before, rest in _cut(text, opener):
            for clause, said, then in _answers(rest):
                yield from _told(before, as_clause.format(clause), said, then)


def _told(before: str, clause: str, said: str, then: str) -> Iterator[_Sentence]:
    """With the condition that ``clause`` and what is said of it afterwards make up."""
    about = presence(clause)
    if about is None:
        return
    if _IS_SO.fullmatch(said):
        yield _Sentence(before, about, then)
    elif said.casefold() in ("not", "no"):
        yield _Sentence(before, _opposite(about), then)
    elif (there := is_one(said)) is not None:
        yield _Sentence(before, replace(about, negated=not there), then)
    elif (more := presence(said, about)) is not None and plainly(said).casefold().startswith(_ABOUT_IT):
        yield _Sentence(before, more, then)


_ABOUT_IT: Final = ("it ", "that ", "they ", "the coast ")


def _asked(text: str) -> Iterator[_Sentence]:
    """ "Is there a cup on the table? Then bring it"; "anything red in the hall, then …"."""
    for match, before, rest in _cut(text, _QUESTION):
        for asked, said, then in _answers(rest):
            for clause in _stated(match["asks"], asked):
                yield from _told(before, clause, said, then)
        for asked, then in _parted(rest):
            joint = rest[len(asked) : len(rest) - len(then)]
            if "?" in joint or "then" in joint or _ELSE.search(then) is not None:
                for clause in _stated(match["asks"], asked):
                    yield from _told(before, clause, "so", then)


_QUESTION: Final = re.compile(
    rf"{_START}(?P<asks>(?:is|are) there |is |are |(?:do|can|could) you see |can you find |(?=any|no|some))",
    re.IGNORECASE,
)
_SUBJECT: Final = re.compile(
    r" (?=(?:in|on|at|under|near|by|inside|behind|beside|next|there|here|empty|free|clear|lying|standing|sitting|"
    r"still|red|green|blue|yellow|white|black|orange)\b)",
    re.IGNORECASE,
)
"""Where the subject of a question may end."""


def _stated(asks: str, asked: str) -> Iterator[str]:
    """A question as a statement."""
    if asks.casefold() in ("is ", "are "):
        yield from (f"{thing} is {where}" for _, thing, where in _cut(asked, _SUBJECT))
    else:
        yield f"there is {asked}"


def _leading(text: str) -> Iterator[_Sentence]:
    """ "If there is a cup on the table, …", with or without something before it."""
    for match, before, rest in _cut(text, _OPENER):
        looked = _place_looked_at(before)
        for clause, then in _parted(rest):
            found = presence(clause, looked)
            if (
                found is None
                and looked is not None
                and looked.thing != "thing"
                and (there := is_one(clause)) is not None
            ):
                found = replace(looked, negated=not there)
            if found is not None:
                going = "" if looked is not None and found.where == looked.where else before
                yield _Sentence(going, found if match["unless"] is None else _opposite(found), then)


_LOOKING: Final = (
    r"(?:look|(?:have|take) a (?:look|peek)|peek|glance)(?: around| round)? (?:in|into|at|around|inside|on|through)"
)
_PLACE_TO_LOOK: Final = re.compile(
    rf"{POLITE}{_GOES_TO}(?:check(?: out| on)?|search|inspect|scan|visit|{_LOOKING})(?: (?:in|at|on|inside))? "
    r"(?P<place>.+)",
    re.IGNORECASE,
)


def _place_looked_at(before: str) -> Presence | None:
    """What "it" is after "look at the box on the table" or "check the stool"; None for other requests."""
    match = _PLACE_TO_LOOK.fullmatch(re.sub(rf"{_JOINT}$", "", before.strip()).strip(" ,;.:"))
    if match is None:
        return None
    there = presence(f"there is {match['place']}")
    if there is not None and there.where:
        return there
    empty = presence(f"{match['place']} is empty")
    return replace(empty, negated=False) if empty is not None else None


def _trailing(text: str) -> Iterator[_Sentence]:
    """ "Beep if you see a cup", with or without what is to be done besides, or otherwise."""
    for match, then, rest in _cut(text, _CLOSER):
        if _NO_CONDITION.search(then):
            continue
        before, then = _journey(then)
        moved, spot = _moved(then), _SPOT.search(then)
        for clause, more in _continued(rest):
            if (goal := _DESTINATION.search(then)) is not None:
                clause = re.sub(r"\bin there$", f"in {goal['place']}", clause, flags=re.IGNORECASE)
            if spot is not None:
                clause = re.sub(r"\b(?:on|in|at|under) it$", spot[0], clause, flags=re.IGNORECASE)
            found = presence(clause, moved) or (moved if is_one(clause) else None)
            if found is not None and not any(is_one(said) is not None for said, _ in _parted(clause)):
                yield _Sentence(before, found if match["unless"] is None else _opposite(found), then + more)


_NO_CONDITION: Final = re.compile(r"\b(?:as|even|what|not|or|especially|except|like|know|sure)$|^ask\b", re.IGNORECASE)


def _continued(text: str) -> Iterator[tuple[str, str]]:
    """A condition, and what is said after it of what is to be done: "if you see one and put it in the bin"."""
    if (contrary := _ELSE.search(text)) is not None:
        yield text[: contrary.start()], f", otherwise {text[contrary.end() :]}"
    yield text, ""
    for match in re.finditer(r",? (?:and|then)+ ", text):
        yield text[: match.start()], f" and {text[match.end() :]}"


def _journey(then: str) -> tuple[str, str]:
    """ "Look into the bedroom and beep": the way to the look, and what depends on it."""
    match = re.fullmatch(r"(?P<go>.+?),? (?:and|then|and then) (?P<then>.+)", then, re.IGNORECASE)
    if match is None or _place_looked_at(match["go"]) is None:
        return "", then
    return match["go"], match["then"]


_MOVED: Final = re.compile(
    rf"{POLITE}(?:bring|take|fetch|grab|get|carry|put|pick up|throw|move|collect|deliver|place|give)(?: me| us)? "
    r"(?P<thing>(?:the|a|an|my|any|all|your) .+?)(?: (?:from (?P<where>(?:the|my|your) \w+(?: \w+)?)|"
    r"(?:to|into|onto|in|on|up|away|here|back|for|from|at|over|out)\b.*))?",
    re.IGNORECASE,
)
_DESTINATION: Final = re.compile(r"\b(?:to|into|in) (?P<place>(?:the|my|your) \w+(?: \w+)?)$", re.IGNORECASE)
"""What "in there" is after "take it to the bedroom"."""
_SPOT: Final = re.compile(r"\b(?:on|in|at|under|onto|into) (?:the|my|your) \w+(?: \w+)?$", re.IGNORECASE)
"""What "on it" is after "put the box on the stool"."""


def _moved(then: str) -> Presence | None:
    """What "it" is after "bring the cup to the kitchen"."""
    match = _MOVED.fullmatch(then)
    if match is None:
        return None
    return presence(f"there is {match['thing']}{' at ' + match['where'] if match['where'] else ''}")


def _opposite(found: Presence) -> Presence:
    return replace(found, negated=not found.negated)


# What the parts mean


def _taken(sentence: _Sentence) -> Conditional | None:
    """With what is to be done in either case as requests of their own; None where one of them is none."""
    about = sentence.about
    before = _going(sentence.before)
    if before is None:
        return None
    for then, otherwise in _either(sentence.then, about):
        first = consequence(then, about)
        second = consequence(otherwise, _opposite(about), instead_of=then)
        if then and first is not None and second is not None and (first or second):
            return Conditional(before, about.thing, about.where, about.negated, first, second)
    return None


def _either(words: str, about: Presence) -> Iterator[tuple[str, str]]:
    """What is to be done, and what otherwise."""
    if (contrary := _ELSE.search(words)) is not None:
        yield words[: contrary.start()], words[contrary.end() :]
    for then, said, otherwise in _answers(words):
        there = is_one(said)
        if there is None and (again := presence(said, about)) is not None and again.thing == about.thing:
            there = not again.negated
        if there is not None and there == about.negated:
            yield then, otherwise
    yield words, ""


_ONLY_LOOK: Final = re.compile(
    r"(?:go and )?(?:look|look around|check|have a look|take a look|look there|go|and|)", re.IGNORECASE
)
_TRAILING_LOOK: Final = re.compile(
    r",? (?:and|to) (?:check|look|look around|see|have a look|take a look)(?: around| there)?$", re.IGNORECASE
)


def _going(words: str) -> str | None:
    """What is to be done before looking; to look somewhere is to go there. None for what is no request."""
    words = re.sub(rf"(?:^| ){_JOINT}$", "", f"{words} ".strip()).strip(" ,;.:?")
    words = _TRAILING_LOOK.sub("", re.sub(rf"^{POLITE}", "", words, flags=re.IGNORECASE).strip(" ,;."))
    if _ONLY_LOOK.fullmatch(words):
        return ""
    match = _PLACE_TO_LOOK.fullmatch(words)
    if match is not None and (looked := presence(f"{match['place']} is empty")) is not None:
        return f"go to {looked.where}"
    return words if is_request(words) else None
