"""What is to be done when something is there, or is not, as a request that can be understood by itself.

"It" becomes what the condition was about, "there" where it is; "otherwise green" and "otherwise to the study" take the
rest from what they stand against; what somebody who was met is to be told, is said.
"""

from __future__ import annotations

import re
from typing import Final

from engine.planner.readings.presence import COLOURS, Presence

VERBS: Final = (
    "bring|pick|take|go|drive|put|beep|say|tell|turn|grab|fetch|come|throw|move|wait|dance|nod|raise|lower|light|set|"
    "clean|tidy|follow|find|get|carry|give|look|stop|drop|place|report|return|clap|applaud|shake|head|hand|leave|"
    "deliver|lift|back|switch|announce|let|show|stay|remember|open|close|navigate|spin|make|do|collect|toss|sort|"
    "approach|push|keep|visit|check|search|remove|clear|call|rotate|scan|locate|patrol|describe|lay|transport|try|"
    "wave|greet|bow|off you go|blink|flash|sound|honk|welcome|warn|chuck|dump|stick|pop|bin|empty|wipe|sweep|vacuum|"
    "point|play|cheer|celebrate|stand|step|reverse|hold|release|park|charge|swing|run|begin|start|don't|be|rush|"
    "hurry|ask|remind|inform|wake|congratulate|thank|pass|send|store|stow|stack|dispose|haul|retrieve|hop|walk|"
    "travel|glow|shout|yell|i'd like|i would like|i want|i need|i'll have|i'll take|have a look|take a look"
)
POLITE: Final = (
    r"(?:(?:please|then|also|just|you can|you should|you may|can you|could you|would you|will you|i want you to|i'd "
    r"like you to|i would like you to|go ahead and|simply|so|robot|hey robot|kindly|feel free to|you'd better|be so "
    r"kind and),? )*"
)
_HANGS: Final = re.compile(
    r"\b(?:if|unless|when|whenever|while|until|(?<!the )till|whether|otherwise|else|as soon as|once(?!\W*$)(?! more)|"
    r"in case|provided)\b",
    re.IGNORECASE,
)
_NOTHING: Final = re.compile(
    r"(?:do nothing|don't do anything|(?:just )?(?:leave|let) (?:it|them|him|her|that)(?: alone| be| there| as it is)?|"
    r"stay(?: there| here| put| where you are)?|forget (?:it|about it)|never mind|don't bother|don't)",
    re.IGNORECASE,
)
_ASKS: Final = re.compile(
    r"(?:^|\b(?:and|then|or) )(?:(?:tell|show) (?:me|us)|let (?:me|us) know|say|see|check|look|find out|report|"
    r"inform me)(?: so| about (?:it|that|this))?$",
    re.IGNORECASE,
)
"""To be told what is there is no condition: it is asked for."""
_IT: Final = re.compile(r"\b(?:it|them|this one|that one|one of them|one of those|those)\b(?! is\b)", re.IGNORECASE)
_SOMEBODY: Final = re.compile(r"\b(?:them|him|her)\b", re.IGNORECASE)
_AT_IT: Final = re.compile(
    r"\b(?P<at>on|in|into|onto|inside|under|by|next to|beside|in front of|at) it\b", re.IGNORECASE
)
_GOES_THERE: Final = re.compile(
    r"^(?P<go>(?:go|drive|come|move|head|navigate)(?: over)?) (?:in )?there\b", re.IGNORECASE
)
_PUT_THERE: Final = re.compile(r"^(?P<put>(?:put|place|set|leave|lay|drop) .+?) there\b", re.IGNORECASE)
_TAKE_THERE: Final = re.compile(r"^(?P<take>(?:bring|take|carry|deliver|transport) .+?) there\b", re.IGNORECASE)
_TRY: Final = re.compile(
    r"try (?:in |at |on )?(?P<place>(?:the |my |your )?\w+(?: \w+){0,2})(?: instead| next)?", re.IGNORECASE
)
_TELLS: Final = re.compile(
    r"(?:tell|remind|inform|warn) (?P<who>me|us|everybody|everyone|them|him|her|the \w+|[A-Z]\w+)(?: that)? "
    r"(?!to |about |what |who |how |where |why |which |a |an |the time|the way)(?P<what>.+)"
)
_GREETS: Final = re.compile(
    r"(?:greet|say (?P<hello>hello|hi|good \w+) to) (?:them|him|her|the person|[A-Z]\w+)", re.IGNORECASE
)
_LETS_KNOW: Final = re.compile(
    r"(?:let (?P<who>.+?) know|tell (?P<told>(?:the |my )?\w+))(?: so| about (?:it|that))?", re.IGNORECASE
)
_GAP: Final = re.compile(
    rf"(?P<colour>{COLOURS})|(?P<to>(?:to|into|in|onto|on) (?:the |my |your )?\w+(?: \w+)?)", re.IGNORECASE
)


_TO_THEM: Final = (
    (re.compile(r"\b(?:his|her|their)\b", re.IGNORECASE), "your"),
    (re.compile(r"\b(?:he|she) is\b|\b(?:he|she)'s\b|\bthey(?: are|'re)\b", re.IGNORECASE), "you are"),
)


def is_request(words: str) -> bool:
    """Whether these words ask for something, and for it in any case."""
    return _HANGS.search(words) is None and re.match(rf"(?:{VERBS})\b", words, re.IGNORECASE) is not None


def consequence(words: str, about: Presence, instead_of: str = "") -> str | None:
    """The words as a request of their own, to be done where it is as ``about`` says; None where they are none. Where it
    stands against another one (``instead_of``), it may be short of words."""
    words = re.sub(rf"^{POLITE}", "", words.strip(" ,;.:!?"), flags=re.IGNORECASE).strip(" ,;.:!?")
    words = re.sub(r",? please$", "", words, flags=re.IGNORECASE)
    if not words or _NOTHING.fullmatch(words):
        return ""
    words = _whole(words, instead_of)
    if not is_request(words) or _ASKS.search(words):
        return None
    if (told := _told(words, about)) is not None:
        return told
    if (match := _TRY.fullmatch(words)) is not None:
        return f"look for {_name(about)} in {match['place']}"
    if about.where:
        words = _GOES_THERE.sub(lambda found: f"{found['go']} to {about.where}", words)
        words = _PUT_THERE.sub(lambda found: f"{found['put']} on {about.where}", words)
        words = _TAKE_THERE.sub(lambda found: f"{found['take']} to {about.where}", words)
    return _with_thing(words, about)


_RELATIVES: Final = (
    "mother father mum mom mummy mommy dad daddy brother sister grandma grandpa granny grandmother grandfather wife "
    "husband son daughter uncle aunt man woman boy girl child kid baby visitor guest friend boss cashier doctor nurse "
    "colleague neighbour neighbor lady guy postman"
)
_PEOPLE: Final = frozenset(_RELATIVES.split())


def _is_somebody(about: Presence) -> bool:
    """Whether "him" or "them" is who the condition was about."""
    return about.thing == "person" or about.thing[:1].isupper() or about.thing.split()[-1] in _PEOPLE


def _name(about: Presence) -> str:
    return about.thing if about.thing[:1].isupper() else f"the {about.thing}"


def _with_thing(words: str, about: Presence) -> str:
    """With the thing, or the place where it is not, for what refers to it."""
    if about.negated and about.where:
        if about.thing in ("thing", "person"):
            return _IT.sub(lambda found: about.where, words, count=1)
        words = _AT_IT.sub(lambda found: f"{found['at']} {about.where}", words, count=1)
    if about.thing == "thing" and _CLEANS.fullmatch(words):
        return f"clean up {about.where}" if about.where else "clean up here"
    if _is_somebody(about):
        return words if _APPLAUDS.search(words) else _SOMEBODY.sub(lambda found: _name(about), words, count=1)
    return _IT.sub(lambda found: _name(about), _HIM.sub(r"\g<does> it", words), count=1)


_CLEANS: Final = re.compile(
    r"(?:clean|tidy|clear|sort) (?:up )?(?:it|them|that|those)(?: up| out| all up| then)*", re.IGNORECASE
)
""" "Something is lying in the hall: tidy it up": the hall."""
_HIM: Final = re.compile(
    r"^(?P<does>put|pop|set|lay|take|pick|drop) (?:him|her)(?= (?:in|on|into|onto|up|down|away|back|at|to|off)\b)",
    re.IGNORECASE,
)
"""A teddy."""
_APPLAUDS: Final = re.compile(
    r"\bgive (?:them|him|her) (?:a|an|some|your) (?:\w+ )?(?:clap|applause|hand|nod|wave|bow)\b", re.IGNORECASE
)


def _whole(words: str, instead_of: str) -> str:
    """ "Green" after "turn the light red", "to the study" after "bring it to the kitchen"."""
    match = _GAP.fullmatch(words)
    if match is None or not instead_of:
        return words
    if match["colour"]:
        return re.sub(rf"\b{COLOURS}\b", match["colour"], instead_of, flags=re.IGNORECASE)
    where = re.search(r"\b(?:to|into|in|onto|on) (?:the |my |your )?\w+(?: \w+)?$", instead_of, re.IGNORECASE)
    return instead_of[: where.start()] + match["to"] if where is not None else words


def _told(words: str, about: Presence) -> str | None:
    """What is to be said, to somebody who is there or to be gone to; None for other requests."""
    somebody = _is_somebody(about)
    if somebody and (match := _GREETS.fullmatch(words)) is not None:
        return f"say {match['hello'] or 'hello'}"
    if (match := _LETS_KNOW.fullmatch(words)) is not None:
        who = match["who"] or match["told"]
        if who.casefold() in ("me", "us", "them", "him", "her", "it", "jokes"):
            return None
        seen = f"did not see {_any(about)}" if about.negated else f"saw {_some(about)}"
        return f'go to {who} and say "I {seen}{f" at {about.where}" if about.where else ""}"'
    if (match := _TELLS.fullmatch(words)) is None:
        return None
    what = match["what"]
    for pattern, to_them in _TO_THEM if somebody else ():
        what = pattern.sub(to_them, what)
    return f'say "{what}"'


def _some(about: Presence) -> str:
    if about.thing == "person" or about.thing[:1].isupper():
        return "somebody" if about.thing == "person" else about.thing
    return f"{'an' if about.thing[:1] in 'aeiou' else 'a'} {about.thing}"


def _any(about: Presence) -> str:
    if about.thing == "person" or about.thing[:1].isupper():
        return "anybody" if about.thing == "person" else about.thing
    return f"any {about.thing}"
