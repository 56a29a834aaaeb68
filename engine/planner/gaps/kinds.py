"""Which things of the house a request may mean: "the cup" where there are two, unless it says where it stands and only
one of them was seen there; "the red box, or was it the blue one"; "the chair" where there are four.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from engine.errors import PlanError
from engine.planner.grounding.colours import COLOURS
from engine.planner.grounding.statement import Statement, said_names
from engine.planner.readings.corrections import bare
from engine.skills.vocabulary import Ambiguous, Vocabulary

_ANY: Final = re.compile(
    r"\b(?:any|either|both|all|each|every|some|whichever|whatever|random|two|three|four|no matter|don't mind|doesn't "
    r"matter)\b"
)
_WANTED: Final = re.compile(
    r"\b(?:(?:bring|fetch|get|take|carry|put|place|pick|grab|hand|give|pass|drop|deliver|throw|move|lift|collect|file|"
    r"store|clear|want|need)(?:s|ting|ing)?|like|goes|go|drive|head|belongs|have|please|taking|giving|moving|placing|"
    r"storing|must|should)\b"
)
"""Words that a thing is wanted with, and not only spoken of."""
_THE_KIND: Final = re.compile(
    r"\b(?:the|my|that|this|your|there(?:'s| is) an?) "
    r"(?P<other>other |second |bigger |big |small |smaller |little |old |new )?(?P<kind>\w+)\b(?!')"
)
_OFTEN_NO_PLACES: Final = frozenset({"me", "us", "user", "start"})
_OR: Final = re.compile(
    r"^(?P<before>.*?)(?P<one>\b(?:the|a|my) [\w ]+?),? or (?:was it |is it |maybe |perhaps |rather |better |else )*"
    r"(?P<two>(?:the|a|my) [\w ]+)$"
)
""" "Bring me the red box, or was it the blue box?"."""
_LIES: Final = re.compile(
    r"(?:,? (?:the one )?(?:that|which)(?:'s| is| are| stands| lies)?)?(?: lying| standing| sitting)? "
    r"(?P<at>on|in|from|at|off|out of|by|next to|near|beside|under|behind)\b(?P<where>.*?)(?= (?:over |back "
    r")?(?:to|into|onto|and|then|for)\b|,|$)"
)
_PUTS: Final = re.compile(r"\b(?:put|place|stick|set|lay|file|store|pop|leave|drop|throw|stow|dump|chuck)(?: down)? $")
""" "Put | the cup on the table": that is where it goes."""
_ITS_OWN: Final = re.compile(r" (?:that|which|with|i|you|we|called|named|number|\d|one|two|three)\b")


@dataclass(frozen=True, slots=True)
class Known:
    """What a request may go on about."""

    said: bool = False  # something was said or done before
    holding: str = ""
    seen: tuple[str, ...] = ()  # sentences

    @property
    def is_nothing(self) -> bool:
        return not self.said and not self.holding and len(self.seen) != 1

    def placed(self, where: str, things: Sequence[str]) -> str:
        """``where`` with the places of the things that it names: next to the bottle is on the stool."""
        named = [name for name in things if name in where]
        told = (_spoken(sentence) for sentence in self.seen if any(name in sentence for name in named))
        return " ".join((where, *told))

    def shows(self, name: str, where: str) -> bool:
        """Whether a thing was seen at a place that ``where`` names, or nobody knows where."""
        told = [_spoken(sentence) for sentence in self.seen if name in sentence]
        places = [re.split(r" (?:on|in|at) (?:the )?", sentence, maxsplit=1)[1:] for sentence in told]
        return any(not place or place[0].strip(" .") in where for place in places)


NOTHING: Final = Known()


class Kinds:
    """Knows the things and the furniture of one house. Thread-safe."""

    def __init__(self, vocabulary: Vocabulary) -> None:
        self._vocabulary = vocabulary
        self._several = tuple(word for word in vocabulary.surfaces() if self._question(word))

    def either(self, plain: str) -> tuple[str, ...]:
        """The two things of which one is wanted."""
        if _ANY.search(plain) or not (found := _OR.match(plain)) or not is_wanted(plain):
            return ()
        names = [self._vocabulary.fitting(found[part]) for part in ("one", "two")]
        known = self._vocabulary.inventory()
        if any(len(several) != 1 or _spoken(several[0]) not in known for several in names) or names[0] == names[1]:
            return ()
        return (*names[0], *names[1])

    def one_of_several(self, plain: str, before: Known) -> tuple[str, ...]:
        """The things that "the cup" may be, where a thing is wanted and nothing tells which one."""
        words = re.findall(r"\w+", plain)
        if _ANY.search(plain) or not is_wanted(plain) or any(word in COLOURS for word in words):
            return ()
        known = self._vocabulary.inventory()
        for found in _THE_KIND.finditer(plain):
            names = self._vocabulary.fitting(found["kind"])
            after = plain[found.end() :]
            unknown = {_spoken(name) for name in names} - set(known)
            if unknown or self._is_name(f"{found['kind']}{after}"):
                continue
            if before.holding in names and not found["other"]:
                continue
            names = tuple(name for name in names if name != before.holding)
            said = any(re.search(rf"\b{re.escape(_spoken(name))}\b", plain) for name in names)
            if (there := self._there(names, plain, found, before)) or not (said or _ITS_OWN.match(after)):
                names = there or names
                if len(names) > 1:
                    return names
        return ()

    def meant(self, names: tuple[str, ...], text: str, before: Known) -> tuple[str, ...]:
        """Those of several things that are where the speaker says they are; all of them where that tells nothing."""
        plain = bare(text).casefold()
        for found in _THE_KIND.finditer(plain):
            if set(names) <= set(self._vocabulary.fitting(found["kind"])):
                return self._there(names, plain, found, before) or names
        return names

    def _there(self, names: tuple[str, ...], plain: str, found: re.Match[str], before: Known) -> tuple[str, ...]:
        """Those of ``names`` that were seen where the thing that was ``found`` in a request is said to be; nothing
        where that is not said."""
        lies = _LIES.match(plain, found.end())
        if lies is None or _PUTS.search(plain[: found.start()]) is not None:
            return ()
        where = before.placed(lies["where"], self._vocabulary.inventory())
        if not self.names_place(Statement(where)):
            return ()
        return tuple(name for name in names if before.shows(name, where))

    def one_of_furniture(self, said: Statement) -> str:
        """The question which piece is meant, where a word means several; empty where none does."""
        names = said_names(said, (*self._vocabulary.surfaces(), *self._vocabulary.places()))
        word = next((word for word in names if word in self._several), "")
        return self._question(word) if word else ""

    def _question(self, word: str) -> str:
        try:
            self._vocabulary.surface(word)
        except Ambiguous as several:
            return several.message
        except PlanError:
            pass
        return ""

    def _is_name(self, words: str) -> bool:
        """Whether they begin with a longer name of this house: the toy chest is no toy."""
        names = (*self._vocabulary.places(), *self._vocabulary.names())
        return any(" " in name and words.startswith(name) for name in names)

    def names_thing(self, said: Statement) -> bool:
        """Whether a thing is named, by its kind, its colour, or a name that it has in this house."""
        if any(mention.has_kind or mention.colour for mention in said.mentions):
            return True
        return any(said.says(word) for word in (*self._vocabulary.things(), *self._vocabulary.thing_words()))

    def names_place(self, said: Statement) -> bool:
        """Whether a place, a room or a piece of furniture is named."""
        vocabulary = self._vocabulary
        names = said_names(said, (*vocabulary.rooms(), *vocabulary.places(), *vocabulary.surfaces()))
        return any(name not in _OFTEN_NO_PLACES for name in names)


def is_wanted(plain: str) -> bool:
    """Whether somebody wants something done."""
    return _WANTED.search(plain) is not None


def _spoken(name: str) -> str:
    return name.casefold().replace("_", " ")
