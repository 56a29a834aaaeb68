"""A text as it is said: sentence by sentence, word by word, each word beside what it sounds like.

Whoever is interrupted in the midst of an answer has said a number of words, and what they were is told by where they
stand in the text. What is synthesised may be another word ("m" is said "metres"), so each keeps both. Sentences are
kept short: the first one is to sound soon, and none can be cut off while it is being synthesised.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from engine.han import HAN, is_chinese

FIRST: Final = 16
"""Characters after which the first sentence of a text ends at the next chance: it is waited for in silence."""
FIRST_LONGEST: Final = 46
"""A first sentence that is longer without such a chance ends before it says where something is."""
LONG: Final = 60
"""The same for the ones that follow; they are synthesised while others sound."""
LONGEST: Final = 160
"""Characters of a sentence that has no chance to end; a longer word is a sentence of its own, and cut short."""

_WORD: Final = re.compile(rf"(?:[^\w\s]|_)*{HAN}(?:(?!{HAN}|[-−]\d)[^\w\s])*|(?:(?!{HAN})\S)+")
_END: Final = re.compile(r"[.!?…。！？][\"'”’»)\]」』）]*$|[；;]$")
_BREATH: Final = re.compile(r"[,:—–，、：]$")
_JOINING: Final = frozenset(("and", "or", "but", "then", "because", "so", "which", "while", "where"))
_PLACING: Final = frozenset(("on", "in", "at", "next", "near", "beside", "behind", "under", "above", "from", "with"))
_NUMBER: Final = re.compile(r"([-−]?)(\d+(?:\.\d+)?)(°|[a-z/]+)?([^\w\s]*)")
_UNITS: Final = {
    "m": ("metre", "metres", "米"),
    "cm": ("centimetre", "centimetres", "厘米"),
    "mm": ("millimetre", "millimetres", "毫米"),
    "°": ("degree", "degrees", "度"),
    "deg": ("degree", "degrees", "度"),
    "s": ("second", "seconds", "秒"),
    "m/s": ("metre per second", "metres per second", "米每秒"),
    "rad/s": ("radian per second", "radians per second", "弧度每秒"),
    "kg": ("kilogram", "kilograms", "公斤"),
}


@dataclass(frozen=True, slots=True)
class Word:
    """One word."""

    end: int  # characters of the whole text up to its end
    said: str  # as it is spoken; may be nothing


@dataclass(frozen=True, slots=True)
class Sentence:
    """What is synthesised in one go."""

    words: tuple[Word, ...]  # at least one
    chinese: bool

    def joined(self) -> tuple[str, tuple[int, ...]]:
        """What is to be spoken, and where in it each word begins."""
        text, begins = "", []
        for word in self.words:
            if text and word.said and not (is_chinese(text[-2:]) and is_chinese(word.said[:2])):
                text += " "
            begins.append(len(text))
            text += word.said
        return text, tuple(begins)

    @property
    def audible(self) -> bool:
        """Whether there is a letter or a digit in it: any voice that makes no sound of that has failed."""
        return any(sign.isalnum() for word in self.words for sign in word.said)


def sentences(text: str) -> Iterator[Sentence]:
    """All of ``text``; nothing for one without a word."""
    found = list(_WORD.finditer(text))
    first = 0  # word of the sentence
    for last in _last_words(found):
        chinese = is_chinese(text[found[first].start() : found[last].end()])
        words = [Word(found[index].end(), _sendable(_as_said(found, index))) for index in range(first, last + 1)]
        if last + 1 < len(found) and not chinese and words[-1].said[-1:].isalnum():
            # cut in the midst of a sentence of somebody's, it is to sound as if it goes on
            words[-1] = Word(words[-1].end, words[-1].said + ",")
        yield Sentence(tuple(words), chinese)
        first = last + 1


def _last_words(found: Sequence[re.Match[str]]) -> Iterator[int]:
    """Of each sentence, by their numbers."""
    first, limit = 0, FIRST
    for index, match in enumerate(found):
        start = found[first].start()
        following = found[index + 1] if index + 1 < len(found) else None
        if following is None or _ends(match[0], following[0], match.end() - start, following.end() - start, limit):
            if limit == FIRST and match.end() - start > FIRST_LONGEST:
                yield from _sooner(found, index)
            yield index
            first, limit = index + 1, LONG


def _sooner(found: Sequence[re.Match[str]], last: int) -> Iterator[int]:
    """Where else a first sentence could end that ends at a word much later, if anywhere."""
    start = found[0].start()
    places = [
        index
        for index in range(last)
        if FIRST <= found[index].end() - start <= FIRST_LONGEST and found[index + 1][0] in _PLACING
    ]
    yield from places[-1:]


def _ends(word: str, following: str, length: int, next_length: int, limit: int) -> bool:
    if _END.search(word) or next_length > LONGEST:
        return True
    return length >= limit and (_BREATH.search(word) is not None or following in _JOINING)


def _as_said(found: Sequence[re.Match[str]], index: int) -> str:
    """What a word sounds like: numbers with their unit in full, and no signs that a voice would spell."""
    word = found[index][0][:LONGEST]
    chinese = any(is_chinese(near[0]) for near in found[max(0, index - 2) : index + 3])
    if number := _NUMBER.fullmatch(word):
        sign, digits, unit, rest = number.groups(default="")
        if not unit or unit in _UNITS:
            amount = f"{float(digits):.10g}" if "." in digits else digits
            minus = ("负" if chinese else "minus ") if sign else ""
            return f"{minus}{amount}{' ' + _unit(unit, amount, chinese) if unit else ''}{rest}"
    bare = word.rstrip(".,;:!?…。，；：！？)")
    if bare in _UNITS and index and (number := _NUMBER.fullmatch(found[index - 1][0])) and not number[3]:
        return _unit(bare, f"{float(number[2]):.10g}", chinese) + word[len(bare) :]
    return " ".join(re.sub(r"[_*`#<>|·→\\{}\[\]]", " ", word).split())


def _sendable(said: str) -> str:
    """With a question mark for each half of a character, as in a text that was cut or read wrongly: no message to a
    voice could hold it."""
    return said.encode("utf-8", "replace").decode("utf-8")


def _unit(unit: str, amount: str, chinese: bool) -> str:
    one, many, han = _UNITS[unit]
    return han if chinese else one if amount == "1" else many
