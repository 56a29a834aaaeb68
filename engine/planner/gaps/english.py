"""The gaps of an English request that its shape alone shows.

A verb that handles something without naming it ("fetch one for my sister"), a journey to nowhere ("meet me there"), a
wish without an aim ("the usual, please"), two opposite ways at once ("turn left right"), a turn without a side, or a
sentence that stops in the middle.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Final, Literal

from engine.planner.grounding.colours import COLOURS
from engine.planner.grounding.statement import Statement
from engine.planner.phrases.said import Question

Gap = Question | Literal["unfinished"]
"""What to ask about."""

_CUT: Final = re.compile(r"[,;.:!?]+ (?:and then |and |then |but |so )?|,? and then |,? then | and | but ")
_LEADING: Final = re.compile(
    r"(?:(?:go|come|run|nip|pop|hop) (?:over |off |ahead )?and |(?:you |now |also |next |first |please |just |"
    r"maybe |so "
    r"|then )+)+"
)
_HANDLES: Final = (
    r"(?:bring|fetch|get|take|carry|put|place|set|lay|pick|pick up|grab|grasp|hold|hand|give|pass|drop|drop off|"
    r"deliver|"
    r"throw|toss|chuck|move|shift|find|look for|search for|locate|follow|leave|stick|pop|plonk|stuff|lift|collect|"
    r"return|send|transport|retrieve|stow|dump|show|have|want|need|i'll have|i'd like|i want|i need|i'd love)"
)
_FOR_WHOM: Final = (
    r"(?: (?:me|us|him|her|them|over|up|down|away|back|off|out|along|(?:my|your|his|her|the|our) (?:mum|mom|mother|dad|"
    r"father|sister|brother|wife|husband|son|daughter|friend|boss|guests?|kids?|children|neighbou?r)))*"
)
_HEADS: Final = (
    r"(?:things?|ones?|1s?|stuff|items?|objects?|bits?|thing(?:y|ies|amajig|amabob)|whatsits?|gadgets?|bits and bobs|"
    r"other|others|usual|same|lot|rest|latter|former)"
)
_ADJECTIVES: Final = (
    r"(?:(?:other|same|usual|right|wrong|correct|big|bigger|biggest|small|smaller|smallest|little|large|larger|tall|"
    r"taller|old|new|first|second|last|next|nice|nicer|good|better|best|left|different|heavy|light|empty|full|"
    r"certain) )*"
)
_ALONE: Final = (
    r"(?=$| (?:to|into|onto|in|on|at|over|back|for|from|off|up|down|away|out|here|there|please|along|around|next|right|"
    r"then|too|as|with|when|before|after|where|that|which|who|is|was)\b)"
)
"""No noun follows: "that" and not "that newspaper"."""
_POINTER: Final = rf"(?:it|them|(?:this|that|these|those|one|1|another|some){_ALONE})"
_SOME: Final = (
    rf"(?:{_POINTER}|something|some things?|anything|whatever|"
    r"(?:one|1|some|any|a few|two|2|both|all|either|another) of (?:it|this|that|these|those|them)|"
    rf"(?:the|that|this|these|those|my|your|his|her|their|an?|some|any|another|one) {_ADJECTIVES}{_HEADS}|"
    r"you know(?: what| which)?)"
)
_UNNAMED: Final = re.compile(
    rf"{_HANDLES}{_FOR_WHOM} (?:(?P<it>{_POINTER})|{_SOME})(?= |$)"
    r"(?! (?:i|you|we) |(?: \w+)? to (?:eat|drink|read|do)\b| (?:slow|easy|steady|right there|still)\b)"
)
""" "Take something to the study"."""
_OF_THEM: Final = re.compile(
    r"(?:just |only )?(?:one|1|some|any|two|2|three|both|all|either|each|the rest) of (?:them|those|these)\b"
)
_NOUN: Final = re.compile(r"\b(?:an?|the|my|your|our|his|her|their|some|this|that) \w+")
_NOTHING: Final = re.compile(
    r"(?:bring|fetch|carry(?! on)|deliver|hand|pick up|grab|put|place|take(?! off| over)|give(?! up)|throw)"
    r"(?: (?:me|us|him|her|them|over|back|up|down|away))*"
    r"(?: (?:to|into|onto|on|in|from|at) (?:the |my |your |our |me\b|us\b|him\b|her\b).*)?"
    r"|(?:look|search|hunt) for|find(?: me| us)?|(?:hand|bring|give|pass) (?:me|us)"
)
""" "Bring to the kitchen"."""
_NO_THINGS: Final = re.compile(
    r"\b(?:lights?|lamps?|leds?|arms?|hands?|gripper|claw|head|attention|care|part|place|turns?|step|seat|look|"
    r"break|rest|"
    r"time|easy|voice|speed|photo|picture|way|word|noise|sound|hint|tour|walk|spin)\b"
)
"""What is handled without being a thing: "put your arm up", "take a seat"."""
_ELSEWHERE: Final = (
    r"(?: (?:to|in|into|at|on|over to))? (?:(?:the |an|that |some |some)(?:other|different|same|usual|right|next)? ?"
    r"(?:room|place|side|spot|end|location|where)|elsewhere|(?:where|wherever) (?:i|we|he|she|they|it)\b.*)"
)
_MOVES: Final = re.compile(
    r"(?:put|place|pop|plonk|deliver|move|shift|transfer|relocate|transport|lay|stow|drop)"
    r" (?:off )?(?:the|my|your|our|that|this|it|them|those|these) (?!.*\b(?:down|away)\b)(?P<rest>.*)"
)
_LEAVES: Final = re.compile(
    rf"(?:put|place|leave|bring|take|carry|return|drop|get|move|deliver|stick|pop) (?:the|my|your|our|that|this|"
    rf"it|them) "
    rf"[\w ]*?{_ELSEWHERE}(?P<rest>.*)"
)
"""What needs a place as well as a thing."""
_PLACED: Final = re.compile(
    r"\b(?:to|in|into|on|onto|at|by|under|near|beside|behind|inside|with|against|over|around|along|me|us|here|"
    r"home|outside|"
    r"aside|forwards?|back|backwards?|ahead|left|right|closer|open|shut)\b|\d"
)
_GOES: Final = (
    r"(?:go|drive|head|come|walk|run|move|roll|travel|navigate|proceed|get|pop|nip|hop|be|stand|wait|park|"
    r"(?:meet|join|see|wait for) (?:me|us|him|her|them)|(?:take|get|put) yourself)"
)
_NOWHERE: Final = re.compile(
    rf"{_GOES}(?: (?:over|up|down|out|in|inside|back|straight|right|quickly|across|along|around|round|to|into|"
    rf"at|near|by))*"
    r" (?:there|somewhere|someplace|elsewhere|next door|yonder|(?:the |that |this |some |an)(?:other|different|"
    r"same|usual|next|"
    r"right|certain|new|nice|better)?(?: other)? ?(?:room|place|spot|location|area|corner|side|end)|"
    r"where (?:i|we|he|she|they) (?:showed|told|said|meant|mean|pointed|want|wanted|like|liked|asked)\b.*)(?= |$)"
)
""" "Go in there"."""
_TURNS: Final = re.compile(
    r"(?:turn|rotate|spin|swing|pivot|swivel|twist)(?: yourself)?(?: by| through| about)? (?:\d+|half|a quarter|ninety|"
    r"forty|thirty|twenty|sixty|ten|fifteen)\b(?!.*\b(?:left|right|clockwise|around|round|about|back|180|360|"
    r"full|circle|"
    r"times|one eighty)\b)"
)
_OPPOSITES: Final = re.compile(
    r"\b(?:left,? right(?! (?:now|away|here|there|next|behind|in|at|up|after|before|over|across|by|on|off|then|"
    r"beside|into|"
    r"to|side))|right,? left(?! (?:of|over))|forwards? back(?:wards?)?(?! (?:to|and|in|at))|back(?:wards?)? "
    r"forwards?|up "
    r"down|down up)\b"
)
_TALLER: Final = re.compile(
    r"\b(?:remove|take|clear|get rid of|put|throw|sort|move)\b.*\b(?:taller|higher|too (?:tall|high|big))\b"
)
_COLOUR_OF_LIGHT: Final = re.compile(r"(?=.*\b(?:light|lamp|led)\b).*\b(?:colou?r|shade)\b")
_NUMBER: Final = re.compile(r"\d|\b(?:half|one|two|three|four|five|six|seven|eight|nine|ten|twelve|fifteen|twenty)\b")
_AIMLESS: Final = re.compile(
    r"(?:i'll have |i'd like |i want |do |give me |just )?(?:the |my )?(?:usual|same(?: thing)?(?: again)?|regular)"
    r"(?: (?:thing|stuff|one|order|drill|procedure|routine))?(?: (?:as|like) (?:.+))?"
    r"|(?:do )?(?:it |that |this )?(?:as|like) (?:always|usual|ever|before|last time|yesterday|the last time|"
    r"you (?:always )?do|"
    r"you did)"
    r"|(?:do (?:it|that|this) )?(?:once )?(?:again|more|encore|repeat)(?: (?:that|it|this|please|once))?|one more time"
    r"|another (?:one|go|time|round)|you know (?:what|which|how)(?: (?:to do|i (?:mean|want|like)|comes next))?"
    r"|(?:that|the|this) thing (?:that )?(?:you|we|i) .+|(?:do|try|make) (?:what|whatever|as) (?:i|we|he|she) .+"
    r"|(?:deal|help|sort|fix|handle|manage|do|take care|see|work|figure|finish|cope|solve|arrange|mend|tackle|"
    r"attend|try|make"
    r"|get on|get started|start|begin|crack on|check)(?: (?:me|us|him|her))?(?: (?:with|to|of|out|about|on|up))*"
    r" (?:it|this|that|these|those|them|(?:that|this|the|your|a) (?:thing|matter|problem|mess|job|task|"
    r"situation)s?(?: .+)?)"
    r"(?: (?:out|up|off|over there|there|for me|now|already|then))*"
)
_ENDS_OPEN: Final = re.compile(
    r"\b(?:a|an|the|my|your|our|their|every|and|or|but|into|onto|from|to|of|than|because|if|when|while|until|between|"
    r"towards|with)$"
)
_ASKS: Final = re.compile(r"\b(?:who|whom|what|which|where|why|how)\b")


def clauses_of(plain: str) -> Iterator[str]:
    """The parts of a request, roughly."""
    yield from _CUT.split(plain)


def with_verb_first(clause: str) -> str:
    """A clause without what only leads up to its verb."""
    return _LEADING.sub("", clause, count=1)


def contradiction(plain: str) -> Gap | None:
    """What to ask where a request wants two opposite things at once."""
    return "which_way" if _OPPOSITES.search(plain) else None


def goes_nowhere(clauses: Sequence[str]) -> bool:
    """Whether a journey leads to a place that is only pointed at."""
    return any(_NOWHERE.match(clause) for clause in clauses)


def gap_of_measure(plain: str, clauses: Sequence[str], said: Statement) -> Gap | None:
    """A height, a colour of the light or the side of a turn that was not said."""
    if _TALLER.search(plain) and not said.quantities and not _NUMBER.search(plain):
        return "how_high"
    if _COLOUR_OF_LIGHT.match(plain) and not any(word in COLOURS for word in re.findall(r"\w+", plain)):
        return "which_colour"
    return "which_way" if any(_TURNS.match(clause) for clause in clauses) else None


def gap_of_words(plain: str, clauses: Sequence[str], *, thing: bool, place: bool) -> Gap | None:
    """What a request lacks that goes on about nothing. ``thing``, ``place``: whether it names one of this house."""
    if not (thing or place) and any(_AIMLESS.fullmatch(words) for words in (*clauses[:1], plain)):
        return "what_do"
    if not thing and not _NO_THINGS.search(plain) and any(map(_names_nothing, clauses, _before_each(clauses))):
        return "which_thing"
    if thing and not place and any(map(_is_put_nowhere, clauses)):
        return "where_put"
    return "unfinished" if _ENDS_OPEN.search(plain) and not _ASKS.search(plain) else None


def _before_each(clauses: Sequence[str]) -> Iterator[str]:
    return (", ".join(clauses[:at]) for at in range(len(clauses)))


def _names_nothing(clause: str, before: str) -> bool:
    """Whether something is to be handled that has no name, also not in what was said ``before``."""
    if (found := _UNNAMED.match(clause)) is not None:
        return found["it"] is None or _NOUN.search(before) is None
    return _NOTHING.fullmatch(clause) is not None or (_OF_THEM.match(clause) is not None and not _NOUN.search(before))


def _is_put_nowhere(clause: str) -> bool:
    if (found := _LEAVES.fullmatch(clause)) or (found := _MOVES.fullmatch(clause)):
        return _PLACED.search(found["rest"]) is None
    return False
