"""Whether a meaning accounts for all words of a request that may stop a plan, or change how much is done.

A reader may miss a word; these it must not: words that take back, forbid, report or ask, conditions, numbers, the side
to which something goes, a choice that is left open, the end of a sentence that nobody has finished. Where one of them
stands in no node, nothing is planned of that meaning.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Final, get_args

from engine.han import is_chinese
from engine.perception.sighting import Colour
from engine.planner.amounts import number
from engine.planner.conventions import FULL
from engine.planner.doing.sense import negates_a_condition
from engine.planner.not_an_order import Mark, MarkKind, marks
from engine.planner.text.conditions import CONDITION, IF_POLITE
from engine.planner.text.measures import read_measures
from engine.planner.text.words import words_of
from engine.understanding.acts import ACTS
from engine.understanding.lexicon import common_characters, lexicon, words_in
from engine.understanding.meaning import About, Do, If, Instead, Meaning, Node, Not, Repeat, Retract, Role, walk

_NODES: Final[dict[MarkKind, tuple[type[Node], ...]]] = {
    "taken_back": (Retract, Instead, Not),
    "forbidden": (Not, Retract, About),
    "told": (About,),
    "asked": (About,),
}
"""The nodes that account for a word because of which something is no order."""
TRUSTED: Final = 0.7
"""How sure a reader is that is believed about the order of acts, and about words that may only tell of an order…"""
CERTAINLY: Final = 0.95
"""…where it holds all of the request to be an order, as surely as that."""
_TELLING: Final = frozenset({"told", "asked"})
"""Marks that also stand beside orders: "the postman said he'd left a parcel, see if it's in the hall". What takes back
or forbids always has to stand in the meaning."""
_QUESTIONS: Final = frozenset(
    {"answer", "ask", "check", "count", "describe", "find", "look", "read", "report", "skills", "tell"}
)
"""Acts by which somebody asks for something."""
_ORDERED: Final = re.compile(
    r"\b(?:do|does|did|must|should|shall|need|can|could)\b|"
    r"don't|never|won't|别|不要|不准|不许|勿"
)
"""A negation that forbids; any other one may belong to a condition."""
_OF_WORDS: Final = frozenset({"manner", "text", "topic", "state"})
"""Roles whose words order nothing."""
_SIDES: Final = (
    (frozenset({"turn_left", "sideways_left"}), re.compile(r"\bleft|\blefty|counter|anti-?\s?clock|\bport|左|逆")),
    (
        frozenset({"turn_right", "sideways_right"}),
        re.compile(r"\bright|(?<!counter)(?<!anti)(?<!-)clockwise|starboard|右|顺"),
    ),
)
"""To which side it goes has to be said."""
_NO_SIDE: Final = re.compile(
    r"\b(?:all|that's|it's|you're|am|be) right\b|\bright (?:away|now|here|there|after|before)\b|\bis left\b|"
    r"\bleft (?:over|me|us)\b"
)
"""What "right" and "left" are besides sides."""
_SIDE: Final = re.compile(r"left|right|左|右")
_CUT_OFF: Final = re.compile(
    r"\b(?:the|an?|my|your|(?<!got )(?<!gone )(?<!up )to|from|into|onto|of|with|u[hm]+|er+m?)[\s.…,-]*$|"
    r"(?:[放拿搬送带移走开挪端]到|把|从|给|往|向)[\s。…，]*$"
)
"""The end of a sentence that somebody has not finished."""
_WHERE_FROM: Final = re.compile(r"\bwhere(?:ver)?\b[^.,;!?]*\bfrom[\s.,!]*$")
"""A sentence that ends with "from": "back to where you came from"."""
_EITHER: Final = re.compile(r"\bor (?:was|is|maybe|perhaps|the)\b|还是")
"""A choice that is left open…"""
_RATHER: Final = re.compile(r"还是(?=.*吧[。！!.\s]*$)")
"""…but "算了，还是…吧" decides for the other."""
_NO_NUMBER: Final = re.compile(r"\d{16}")
"""More digits than a number has."""
_ARM: Final = re.compile(r"\bservo (?:number )?(?:1|one)\b|舵机[1一]|[1一]号舵机")
"""What turns the arm about its vertical axis: the number is a name."""
_OF_A_STEP: Final = re.compile(
    r"\bstep (?:number )?(?:\d|one|two|three|four|five|six)\b|第[一二三四五六\d](?:步|件事?|做)|"
    r"\b\d(?:st|nd|rd|th)\b"
)
"""Which step of several this is."""
_TO: Final = re.compile(r"\b2 (?=(?:me|u|you|the|my|us)\b)")
""" "To", as people type it."""
_TOLD_OF: Final = re.compile(
    r"\b(?:i|we|he|she|they)(?:'ve|'s| have| has) (?:already |just )?\w+(?:ed|en|t|d)\b[^,.;!?]*"
)
"""What people have done."""
_LISTED_ACTS: Final = re.compile(
    r"\b(?:these|those|the following|do) (?:two|three|four|\d)\b|"
    r"\b(?:two|three|four|\d) (?:(?:things|jobs|tasks|errands)\b|steps\b(?=\W*[:–—-]))|"
    r"[两二三四\d]件事"
)
"""How many acts are listed, or things."""
_NO_AMOUNTS: Final = frozenset({"one", "a", "an", "once", "一", "一次", "一遍", "一下", "一趟", "一回", "一声", "一眼"})


def accounted(meaning: Meaning, names: Collection[str] = ()) -> bool:
    """Whether everything that may stop a plan, or changes how much is done, stands in the meaning; ``names`` are those
    of things and places of this house."""
    nodes = list(walk(meaning.nodes))
    text = meaning.text.casefold()
    depends = any(isinstance(node, If) or (isinstance(node, Do) and node.until is not None) for node in nodes)
    acts = _acts(nodes)
    asks = bool(acts) and acts <= _QUESTIONS
    if not depends and not asks and (CONDITION.search(IF_POLITE.sub("", meaning.text)) or _is_open(text, nodes)):
        return False
    if is_cut_off(text) or not _sides_stand(text, nodes) or not _lists_stand(meaning, nodes, names):
        return False
    if not _corrections_stand(meaning, nodes) or _goes_via(text, nodes):
        return False
    if not (_trusted(meaning) or _order_stands(text, nodes)) or not _colour_stands(text, nodes):
        return False
    return _marks_stand(meaning, nodes, depends=depends) and _numbers_stand(meaning, nodes)


def _is_open(text: str, nodes: Sequence[Node]) -> bool:
    """Whether a choice is left open."""
    takes_back = any(isinstance(node, Retract) for node in nodes)
    return _EITHER.search(_RATHER.sub("", text) if takes_back else text) is not None


def is_said(meaning: Meaning, known: Collection[str]) -> bool:
    """Whether the acts are said in words that the reader has learned, or that are ``known`` here: one beside the words
    of roles, which may be any; most of them where there are no roles, and half in talk, where people call one another
    by name. Of words that it has never seen a reader is as sure as of others: "glorp" is no order to switch a light
    on."""
    if meaning.reader == "certain":
        return True
    nodes = list(walk(meaning.nodes))
    spans = [(role.start, role.end) for node in nodes for role in _roles(node)]
    words = [word for word in words_in(meaning.text, spans) if word not in _SAY_NOTHING]
    if not words:
        return _are_named(meaning, nodes, known)
    learned = sum(_is_learned(word, known, within=bool(spans)) for word in words)
    return learned > 0 if spans else 2 * learned >= len(words) + (_acts(nodes) != {"talk"})


def _are_named(meaning: Meaning, nodes: Sequence[Node], known: Collection[str]) -> bool:
    """Whether roles whose words are all that is said may have these words: of names any, of others ("slowly", "ten
    metres") not only such as nobody has learned. A reader takes "flurb" for a manner, and so for how to do once more
    what was asked for before."""
    names = [role.name for node in nodes for role in _roles(node)]
    words = [word for word in words_in(meaning.text) if word not in _SAY_NOTHING]
    if not names or not words or not _OF_ANY_WORDS.isdisjoint(names):
        return bool(names)
    return any(_is_learned(word, known, within=True) for word in words)


def _is_learned(word: str, known: Collection[str], *, within: bool) -> bool:
    """``within``: names stand beside it, so that a Chinese verb may be next to any other character."""
    if word in lexicon() or word in known or (within and set(word) <= common_characters()):
        return True
    parts = [part for part in re.split(r"['-]", word) if len(part) > 1]  # "sofa's", "night-time"
    return len(parts) > 0 and parts != [word] and all(part in lexicon() or part in known for part in parts)


def without_an_unsaid_act(meaning: Meaning) -> Meaning:
    """The meaning as a fragment, where no word is left that could say the act: of "dishwasher" alone, nobody knows what
    is to be done with it."""
    act = meaning.nodes[0] if len(meaning.nodes) == 1 else None
    if not isinstance(act, Do) or act.until is not None or len(act.roles) != 1 or act.roles[0].name not in _NAMES:
        return meaning
    others = list(words_in(meaning.text, [(role.start, role.end) for role in act.roles]))
    if any(word not in _SAY_NOTHING for word in others):
        return meaning
    if "please" in others and act.act in ("fragment", "bring") and act.roles[0].name == "thing":
        return replace(meaning, nodes=(Do("bring", act.roles),))  # "the bottle, please"
    return replace(meaning, nodes=(Do("fragment", act.roles),))


_NAMES: Final = frozenset({"place", "source", "thing", "person"})
"""Roles whose words are names."""
_OF_ANY_WORDS: Final = _NAMES | {"except", "text", "topic"}
"""Roles whose words may be any."""
_SAY_NOTHING: Final = frozenset({"the", "a", "an", "my", "your", "our", "please", "请.", "吧."})
"""Words beside a name that say nothing of what is to be done."""


def is_cut_off(text: str) -> bool:
    """Whether a sentence stops where nobody ends one: "put the cup on the"."""
    plain = text.casefold()
    return _CUT_OFF.search(plain) is not None and _WHERE_FROM.search(plain) is None


def without_an_empty_branch(meaning: Meaning) -> Meaning:
    """The meaning without a retraction that is only what a condition leaves undone: "…; if not, never mind"."""
    *before, last = meaning.nodes or (Retract(),)
    if not isinstance(last, Retract) or not before or not isinstance(before[-1], If):
        return meaning
    back = [mark for mark in marks(meaning.text) if mark.kind == "taken_back"]
    plain = _plain(meaning.text)
    if not back or not _OTHERWISE.search(plain[: max(plain.rfind(back[-1].words), 0)]):
        return meaning
    return replace(meaning, nodes=tuple(before))


def _plain(text: str) -> str:
    return " ".join(text.casefold().replace("’", "'").split())


def sides_stand(meaning: Meaning) -> bool:
    """Whether it goes to no side that was not said."""
    return _sides_stand(meaning.text.casefold(), list(walk(meaning.nodes)))


def _trusted(meaning: Meaning) -> bool:
    return meaning.confidence >= TRUSTED and meaning.doubt <= 1 - CERTAINLY


def _marks_stand(meaning: Meaning, nodes: Sequence[Node], *, depends: bool) -> bool:
    """Words because of which something is no order."""
    if nodes and all(isinstance(node, Instead) for node in nodes):
        return True  # "no, not that one, the other": it corrects what was said before
    acts = _acts(nodes)
    quoted = [role.words.casefold() for node in nodes for role in _roles(node) if role.name in _OF_WORDS]
    plain = _plain(meaning.text)
    for mark in marks(meaning.text):
        before, _, behind = plain.rpartition(mark.words)
        if depends and (_OTHERWISE.search(before) or (_ENDS.match(behind) and _opens_a_branch(before, nodes))):
            continue  # "… otherwise don't bother"
        if depends and mark.kind == "asked" and re.match(r"\W*should (?:you|i|we|he|she|it|they)\b", mark.words):
            continue  # "should you see the ball, …"
        if (
            depends
            and mark.kind == "forbidden"
            and (_STAYS_THERE.search(plain, len(before)) or _SEES_NONE.search(before))
        ):
            continue  # "go there and don't move until I say", "you see it? bring it. you don't? come here"
        if mark.words == "not" and (_is_elsewhere(before, behind, meaning) or _is_left_out(before, behind, nodes)):
            continue  # "put it on the bed, not on the floor", "every box, but not the green one"
        if any(isinstance(node, _NODES[mark.kind]) for node in nodes):
            if not _placed(mark, meaning):
                return False
        elif mark.kind in _TELLING and _trusted(meaning):
            continue
        elif not any(mark.words in words for words in quoted) and not negates_a_condition(mark.words, meaning):
            asks = mark.kind == "asked" and acts & _QUESTIONS
            negated = mark.kind == "forbidden" and depends and not _ORDERED.search(mark.words)
            if not (asks or negated or _tells_why(mark, meaning, plain, acts) or _keeps_straight(mark, plain, acts)):
                return False
    return True


def _is_elsewhere(before: str, behind: str, meaning: Meaning) -> bool:
    """Whether only another place than the wanted one is excluded, behind a comma and at the end of a sentence."""
    found = _NOT_THERE.fullmatch(behind)
    if found is None or not before.rstrip().endswith((",", "please", "pls")) or not _trusted(meaning):
        return False
    wanted = {word for node in walk(meaning.wanted()) for role in _roles(node) for word in _plain(role.words).split()}
    return wanted.isdisjoint(set(found["there"].split()) - {"the", "my", "your", "a"})


def _is_left_out(before: str, behind: str, nodes: Sequence[Node]) -> bool:
    """Whether it leaves something out of a group."""
    left_out = (_plain(role.words) for node in nodes for role in _roles(node) if role.name == "except")
    return before.rstrip().endswith("but") and any(behind.strip().startswith(words) for words in left_out)


_NOT_THERE: Final = re.compile(
    r" (?:on|in|at|to|into|onto|by) (?P<there>(?:the |my |your )?\w+(?: \w+)?)(?: please)?[\s.!]*"
)


def _tells_why(mark: Mark, meaning: Meaning, plain: str, acts: set[str]) -> bool:
    """Whether it is a reason for what is said behind it: "I don't need the box any more, throw it away"."""
    found = _NO_USE.search(plain)
    if mark.kind != "forbidden" or found is None or not found.start() <= plain.find(mark.words) < found.end():
        return False
    behind = _CLAUSE_END.split(plain[found.end() :], maxsplit=1)[1:]
    return _trusted(meaning) and acts <= _WITH_THINGS and any(len(clause.strip(" .。!！")) > 1 for clause in behind)


def _keeps_straight(mark: Mark, plain: str, acts: set[str]) -> bool:
    """Whether only what is not done anyway is forbidden: "slide left, don't turn", "count to ten without moving"."""
    begins = max(plain.find(mark.words), 0)
    if acts.isdisjoint(_DRIVES) and _NO_MOVE.search(plain, begins):
        return True
    return acts <= _STRAIGHT and _NO_TURN.search(plain, begins) is not None


_STAYS_THERE: Final = re.compile(
    r"(?:don't|do not|never) (?:move|budge|leave|go (?:away|anywhere))(?: (?:from )?(?:there|it|away|again))*"
    r" (?:until|till|unless|before)\b"
)
_SEES_NONE: Final = re.compile(
    r"[.?!;,] *(?:and |but )?(?:if )?you $|\b(?:if|when|in case) (?:you|i|we|he|she|they|it|there) (?:still |really )?$"
)
_STRAIGHT: Final = frozenset({"forward", "backward", "sideways_left", "sideways_right"})
_DRIVES: Final = frozenset(ACTS) - frozenset({
    "wait", "say", "beep", "light", "light_off", "stop", "nod", "shake", "arm_up", "arm_down", "report", "skills",
})  # fmt: skip
"""Acts that take the robot elsewhere, or may."""
_NO_MOVE: Final = re.compile(
    r"(?:don't|dont|do not|never|without|不要|不许|别|不) ?(?:mov|driv|budg|go(?:ing)? anywhere|动)[a-z]*"
    r"(?: (?:at all|please|an inch|away))*(?=\W*(?:$|[,.;:!?，。；]|until\b|till\b|while\b|then\b))"
)
_NO_TURN: Final = re.compile(
    r"(?:don't|dont|do not|never|without|不要|不许|别|不) ?(?:turn|rotat|spin|转[身弯向]?)[a-z]*"
    r"(?: (?:round|around|at all|please))*(?=\W*(?:$|[,.;:!?，。；]))"
)
_NO_USE: Final = re.compile(
    r"\b(?:i|we|nobody|no one|he|she|they) (?:really |just )?(?:don't|do not|dont|doesn't|does not|never|won't) "
    r"(?:really )?(?:need|want|use|like|drink|eat|wear|play with)\b|"
    r"不要了|不用了|不想要|用不[着上]|不喝了?|不吃了?|没人要"
)
"""That a thing is of no use to people."""
_CLAUSE_END: Final = re.compile(r"[,.;:!?，。；！？]|\b(?:so|and|then)\b|就|那")
_WITH_THINGS: Final = frozenset({"throw_away", "put", "bring", "tidy", "pick_up", "clean"})


def _opens_a_branch(before: str, nodes: Sequence[Node]) -> bool:
    """Whether what follows these words is all that a condition has done: "if it's in the kitchen, leave it"."""
    clause = _CLAUSE.search(before)
    conditions = [node.condition for node in nodes if isinstance(node, If)]
    ends = (role.words.casefold() for condition in conditions for role in condition.roles)
    return clause is not None and any(clause["said"].endswith(_plain(words)) for words in ends)


def _sides_stand(text: str, nodes: Sequence[Node]) -> bool:
    """Whether each side to which something goes was said, and no turn to the other side has been missed."""
    acts, plain = _acts(nodes), _NO_SIDE.sub("", text)
    said = {sides for sides, words in _SIDES if words.search(plain)}
    wanted = {sides for sides, _ in _SIDES if sides & acts}
    corrected = any(isinstance(node, Instead | Retract | Not) for node in nodes)
    described = any(_SIDE.search(role.words) for node in nodes for role in _roles(node))
    missed = len(wanted) == 1 < len(said) and not corrected and not described
    return wanted <= said and not missed


def _corrections_stand(meaning: Meaning, nodes: Sequence[Node]) -> bool:
    """Whether no second correction, and no other direction in a correction, has been missed: "one metre forward, sorry,
    back one metre"."""
    made = sum(isinstance(node, Instead | Retract | Not) for node in nodes)
    if 0 < made < times_corrected(meaning.text):
        return False
    later = [role.start for node in nodes if isinstance(node, Instead) for role in node.roles]
    if not later:
        return True
    first = min((role.end for node in nodes if isinstance(node, Do) for role in node.roles), default=0)
    between = meaning.text.casefold()[min(first, min(later)) : max(later)]
    wanted = {act for acts, _ in _WAYS if acts & _acts(nodes) for act in acts}
    return not wanted or not any(words.search(between) for acts, words in _WAYS if not acts & wanted)


_WAYS: Final = (
    (frozenset({"forward"}), re.compile(r"\bforwards?\b|\bahead\b|前进|[往向]前")),
    (frozenset({"backward"}), re.compile(r"\bback(?:wards?)?\b|\brevers|后退|倒退|[往向]后")),
    *_SIDES,
)
"""The directions of motions, and the words for them."""


def _order_stands(text: str, nodes: Sequence[Node]) -> bool:
    """Whether what is told first is not done first, where words say so: "go to the kitchen, but first beep"."""
    acts = [node for node in nodes if isinstance(node, Do)]
    last, found = _FIRST.match(text), _BEFOREHAND.search(text)
    if last is None and found is not None and found.start() == 0:
        return True  # "once you have been there, …": told in the order in which it is done
    found = last or found
    if found is None or len(acts) < 2 or not acts[0].roles:
        return True
    begins = min(role.start for role in acts[0].roles)
    told_first = all(role.start >= begins for act in acts for role in act.roles)
    return not told_first or (found.start() > 0 and begins > found.start())


def _goes_via(text: str, nodes: Sequence[Node]) -> bool:
    """Whether several places of one act are told in another order than they are gone to, or one on the way is left
    out: "to the stool by way of the hall"."""
    several = any(len(node.all("place")) > 1 for node in nodes if isinstance(node, Do))
    if several and (_FIRST.match(text) or _BEFOREHAND.search(text)) is not None:
        return True
    ends = max((role.end for node in nodes for role in _roles(node)), default=0)
    return _acts(nodes) == {"go"} and _VIA.search(text, ends) is not None


_VIA: Final = re.compile(r"\b(?:via|by way of)\b")


def _colour_stands(text: str, nodes: Sequence[Node]) -> bool:
    """Whether a light gets the colour that is spoken of: "another colour" is none."""
    lights = [node for node in nodes if isinstance(node, Do) and node.act == "light"]
    return not lights or all(node.words("colour") for node in lights) or _COLOUR.search(text) is None


_COLOUR: Final = re.compile(r"\bcolou?r|颜色")
_OTHERWISE: Final = re.compile(
    r"(?:\b(?:else|otherwise|if not|(?:if|when) (?:it|that|he|she|they|there)"
    r"(?:'s not|'re not| is not| are not| isn't| aren't)(?: any| one)?)|"
    r"没有?(?:的话)?|不然|否则|要不然?)"
    r"[\W_]*(?:(?:then|just|do|you can|就|那|那就|也)\b[\W_]*)*(?:就|那就)?$"
)
"""What stands before the branch of a condition in which nothing is to be done."""
_CLAUSE: Final = re.compile(
    r"(?:^|[.,;:!?…–—]|\b(?:and|but|or))\W*(?:if|when|should|in case|要是|如果)\b"
    r"(?P<said>(?:(?!\b(?:if|when|should)\b)[^.;!?])*?)"
    r"(?:[\W_]|\b(?:then|already|just|please|you can|you may|right|there|simply)\b|就|那|了)*$"
)
"""The clause of a condition that nothing is said before which depends on it."""
_ENDS: Final = re.compile(
    r"(?: (?:it|them|that|him|her|there|be|alone|then|bother|touch|do|anything|a thing))*"
    r" *(?:$|[.,;:!?，。；]| (?:and|but|or|else)\b)"
)
"""Behind what is left undone, nothing more is said of it."""
_FIRST: Final = re.compile(r"(?:before|prior to|on (?:your|the) way (?:to|over)|until)\b")
"""What is told in a clause that begins so is done last."""
_BEFOREHAND: Final = re.compile(
    r"\bbut (?:first|before)\b|\bafter (?:you|having|\w+ing\b)|\bvia\b|\bby way of\b|\bonce you(?:'ve| have)\b|"
    r"(?<=.)(?:之前|以前|前先)(?!的)|(?<=.)经过"
)
"""What stands behind these is done before what stands in front of them."""


def _lists_stand(meaning: Meaning, nodes: Sequence[Node], names: Collection[str]) -> bool:
    """Whether nothing is missing at the end of a list: "the red box, the blue box and the green box"."""
    roles = [role for node in nodes for role in _roles(node)]
    acts, text = _acts(nodes), meaning.text.casefold()
    for role in roles:
        joint = _JOINT.match(text, role.end) if role.name in _LISTED else None
        if joint is None or any(other.start < joint.end() + 1 and joint.end() < other.end for other in roles):
            continue
        rest = text[joint.end() :]
        if "throw_away" in acts and _BIN.match(rest):
            continue  # "the green box, bin as well"
        if any(rest.startswith(name) and not rest[len(name) :][:1].isalpha() for name in names if len(name) > 1):
            return False
    return True


_BIN: Final = re.compile(r"(?:bin|trash|rubbish|garbage|waste)\b|垃圾")
_LISTED: Final = frozenset({"thing", "place", "source", "person", "except"})
_JOINT: Final = re.compile(r"\s*(?:, and |, |,| and |、|和|跟|还有)\s*(?:(?:the|a|an|my|your|our|that|this) )?")


def _numbers_stand(meaning: Meaning, nodes: Sequence[Node]) -> bool:
    """Whether each number is in a role; how often something is repeated is read from words of its own."""
    if _NO_NUMBER.search(meaning.text):
        return False
    if any(isinstance(node, Repeat) for node in nodes):
        return True
    spans = [(role.start, role.end) for node in nodes for role in _roles(node)]
    turns = any(isinstance(node, Do) and node.act == "turn_around" for node in nodes)
    acts = sum(isinstance(node, Do) for node in nodes)
    things = sum(role.name == "thing" for node in nodes for role in _roles(node))
    text = meaning.text.casefold()
    for names in (_ARM, _OF_A_STEP, _TO, _TOLD_OF):
        text = names.sub(lambda found: " " * len(found[0]), text)
    text = _LISTED_ACTS.sub(lambda found: " " * len(found[0]) if number(found[0]) in (acts, things) else found[0], text)
    counts = (token for token in read_measures(words_of(text).tokens) if token.kind in ("number", "quantity"))
    return all(
        meaning.text[token.start : token.end].casefold() in _NO_AMOUNTS
        or (turns and (token.unit, token.value) == ("deg", FULL))  # which the act reads itself
        or any(start <= token.start < end for start, end in spans)
        for token in counts
    )


def _placed(mark: Mark, meaning: Meaning) -> bool:
    """Whether what a word forbids is not just what the meaning wants: in "to the study, not to the kitchen" it is the
    kitchen. What is wanted after a retraction stands behind it."""
    at = meaning.text.casefold().find(mark.words)
    wanted = [role.start for node in walk(meaning.wanted()) for role in _roles(node)]
    behind = [start for start in wanted if start > at]
    if mark.kind == "taken_back":
        return not wanted or any(start >= at + len(mark.words) for start in wanted)
    others = [role.start for node in walk(meaning.nodes) for role in _roles(node) if role.start not in wanted]
    forbidden = [start for start in others if start > at]
    return not behind or (bool(forbidden) and min(forbidden) < min(behind))


def _acts(nodes: Sequence[Node]) -> set[str]:
    return {node.act for node in nodes if isinstance(node, Do)}


def _roles(node: Node) -> Sequence[Role]:
    match node:
        case Do():
            return (*node.roles, *(node.until.roles if node.until is not None else ()))
        case Instead():
            return node.roles
        case If():
            return node.condition.roles
    return ()


def times_corrected(text: str) -> int:
    """How often something is taken back within a sentence."""
    chinese = is_chinese(text)
    pattern = _CORRECTION_ZH if chinese else _CORRECTION
    return sum(_takes_back(found, text, chinese) for found in pattern.finditer(text))


def _takes_back(match: re.Match[str], text: str, chinese: bool) -> bool:
    between = match.start() > 0 and match.end() < len(text)
    if not chinese and _MAKES.search(match[0]) and _TO_BE.match(text[match.end() :]):
        return False  # "…, then make it blue"
    if not chinese and _FOR.search(text[: match.start()]):
        return False  # "shake for no, then clap"
    return between and (chinese or _CERTAIN.search(match[0]) is not None)


_CORRECTION: Final = re.compile(
    r"[,.;:!?…–—\s]+(?:(?:uh+|um+|er+|oh|ah|no|nope|nah|sorry|wait|hang on|hold on|my mistake|my bad|oops|well|"
    r"actually|rather|scratch that|correction|make (?:it|that)|i (?:mean|meant)|i wanted to say|not that|"
    r"let me correct(?: that)?|i was wrong)\b[,.;:!?…–—\s]*){1,5}",
    re.IGNORECASE,
)
_CERTAIN: Final = re.compile(
    r"\b(?:no|nope|nah|sorry|my mistake|my bad|oops|rather|scratch that|correction|make (?:it|that)|i (?:mean|meant)|"
    r"actually|i wanted to say|not that|let me correct|i was wrong)\b",
    re.IGNORECASE,
)
_CORRECTION_ZH: Final = re.compile(
    r"[，。！,.!\s]*(?:哦|噢|呃|啊|嗯)?(?:(?:不对|不是|说错了|错了|我是说|我说的是|应该是|改成|哦不|噢不)[，。！,.!\s]*){1,3}"
    r"(?:是|我是说|应该是)?"
)
_MAKES: Final = re.compile(r"\bmake (?:it|that)\W*$", re.IGNORECASE)
_FOR: Final = re.compile(r"\b(?:for|as|mean|means|meaning|saying|says|if)$", re.IGNORECASE)
_TO_BE: Final = re.compile(rf"(?:{'|'.join(get_args(Colour))}|on|off|pink|cyan|gray|violet)\b", re.IGNORECASE)
