"""One statement that may be a ground, something said, seen or known: its words, its quantities, the things it names."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Final

from engine.han import HAN, SIMPLER, is_chinese
from engine.planner.grounding.mentions import mentions, stem_of, things_in_english
from engine.planner.text.measures import read_measures
from engine.planner.text.words import Token, words_of

_CLAUSE: Final = re.compile(
    r"[,;.!?，。；！？、]|\b(?:and|then|after|before|also|next|finally|back|between)\b|然后|再|接着|并|和|之后"
)
_CLOSE_UP: Final = re.compile(rf"(?<={HAN}) | (?={HAN})")
_BEFORE_SYMBOL: Final = (
    "to place point room position spot location symbol marker waypoint station named called and then at in go from "
    "between , 、"
)
_AFTER_SYMBOL: Final = "and then please now first with for again to quickly slowly"
_POINTERS: Final = frozenset(_BEFORE_SYMBOL.split())
_JOINTS: Final = frozenset(_AFTER_SYMBOL.split())
_AFTER_A_LENGTH: Final = (
    "forward forwards back backward backwards ahead left right and then to please more further straight again in this "
    "that or"
)
_OF_A_LENGTH: Final = frozenset(_AFTER_A_LENGTH.split())
"""What may follow a number that says how far: "20 copies" are no metres."""
_ANY: Final = ("a", "an", "some", "any", "one", "one of the", "1", "一个")


class Statement:
    """An utterance, a sentence about what was seen, or a fact.

    ``clauses``: how many there may be. ``numbers``: the bare ones; ``lone``: those among them that count nothing.
    ``quantities``: those with a unit, as (value, unit).
    """

    def __init__(self, text: str) -> None:
        tokens = words_of(text).tokens
        measured = read_measures(tokens)
        self.text = _CLOSE_UP.sub("", " ".join(token.text for token in tokens))
        self.clauses = 1 + len(_CLAUSE.findall(text.casefold().translate(SIMPLER)))
        self.numbers = [token.value for token in measured if token.kind == "number"]
        following = [token.text for token in measured[1:]] + [""]
        self.lone = [
            token.value
            for token, after in zip(measured, following, strict=False)
            if token.kind == "number" and (not after.isalpha() or is_chinese(after) or after in _OF_A_LENGTH)
        ]
        self.quantities = [(token.value, token.unit) for token in measured if token.kind == "quantity"]
        self.mentions = tuple(mentions(things_in_english(text) if is_chinese(text) else measured))
        self._raw = text
        self._words = [token.text for token in measured]
        self._stems = (_stems(tokens), _stems(measured))

    def says(self, words: str) -> bool:
        """Whether these words were said, in any inflection. Chinese ones may stand anywhere."""
        if is_chinese(words):
            return words in self.text
        wanted = _stems(words_of(words).tokens)
        return wanted.strip() != "" and any(wanted in stems for stems in self._stems)

    def asks_for_any(self, words: str) -> bool:
        """Whether one of several is asked for, no matter which: "a fruit"."""
        return any(self.says(f"{article} {words}") for article in _ANY)

    def says_symbol(self, symbol: str) -> bool:
        """Whether the letter of a place stands for it, and is no article."""
        if is_chinese(self._raw):
            return re.search(rf"(?<![A-Za-z]){re.escape(symbol)}(?![A-Za-z])", self._raw, re.IGNORECASE) is not None
        for at, word in enumerate(self._words):
            before = self._words[at - 1] if at else "to"
            after = self._words[at + 1] if at + 1 < len(self._words) else ""
            if word == symbol.casefold() and before in _POINTERS and (not after.isalpha() or after in _JOINTS):
                return True
        return False


def said_names(said: Statement, names: Iterable[str]) -> tuple[str, ...]:
    """Which of ``names`` were said, but not those that are only part of a longer one that was."""
    found = [name for name in dict.fromkeys(names) if len(name) > 1 and said.says(name)]
    return tuple(name for name in found if not any(name != other and name in other for other in found))


def _stems(tokens: Sequence[Token]) -> str:
    """With a space before and after each, so that one text of them is found in another only as whole words."""
    return f" {' '.join(stem_of(token.text) for token in tokens)} "
