"""The things that a text names, by kind, colour and number, and whether a thing of a plan is one of them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from engine.han import SIMPLER
from engine.perception.naming import CHINESE, KINDS
from engine.planner.grounding.colours import COLOURS
from engine.planner.text.words import Token, words_of

_SYNONYMS: Final = {
    **KINDS,
    "carton": "box", "package": "box", "parcel": "box", "crate": "box", "case": "box", "dice": "box", "brick": "block",
    "apriltag": "block", "sphere": "ball", "glass": "cup", "beaker": "cup", "tumbler": "cup", "flask": "bottle",
    "water": "bottle", "man": "person", "woman": "person", "people": "person", "somebody": "person", "me": "person",
    "him": "person", "her": "person", "child": "person", "guest": "person", "one": "thing", "item": "thing",
    "stuff": "thing", "everything": "thing", "anything": "thing", "toy": "thing",
}  # fmt: skip
_PASSED_OVER: Final = "and or coloured colored colour color little small big large tiny 色 的 颜 小 大 个 只 和 那"
_BETWEEN: Final = frozenset(_PASSED_OVER.split())
"""What may stand between a colour and its noun."""
_RELATIVE: Final = (["that", "is"], ["which", "is"], ["that", "are"], ["which", "are"])

_ZH: Final = re.compile("|".join(sorted((*CHINESE, "机器人", "别人"), key=len, reverse=True)))
_ZH_NUMBERED: Final = re.compile(r"([\d一二三四五六七八九])\s*号\s*的?\s*(block|box)")
_ZH_BETWEEN: Final = re.compile(r"(?<=[a-z]) (?:颜?色)?的?(?:小|大|那?个|那?只)? (?=[a-z])")
_NUMERALS: Final = str.maketrans("一二三四五六七八九", "123456789")


@dataclass(frozen=True, slots=True)
class Mention:
    """A thing as it is named: its kind or noun, and its colour; either may be empty."""

    noun: str
    colour: str = ""
    tag: str = ""

    @property
    def has_kind(self) -> bool:
        """Whether it says what the thing is: "the red one" does not, and people are no things."""
        return self.noun not in ("", "thing", "person")


@dataclass(frozen=True, slots=True)
class Thing:
    """A thing as a plan names it."""

    value: str
    noun: str
    colour: str
    tag: str

    @classmethod
    def of(cls, value: str) -> Thing:
        parts = value.casefold().replace("_", " ").split()
        colour = next((COLOURS[part] for part in parts if part in COLOURS), "")
        nouns = [part for part in parts if part not in COLOURS and not part.isdigit()]
        return cls(value, " ".join(nouns) or "thing", colour, parts[-1] if parts and parts[-1].isdigit() else "")

    def fits(self, mention: Mention, *, any_colour: bool = False) -> bool:
        """Whether it may be named so where it was mentioned as ``mention``."""
        if self.tag and mention.tag != self.tag:
            return False
        if self.colour and self.colour != mention.colour and not any_colour:
            return False
        if self.noun == "thing":  # by its colour alone
            return bool(self.colour) and bool(mention.colour)
        nouns = {mention.noun, *(("box",) if mention.noun == "block" else ())}
        return bool(nouns & {self.noun, _SYNONYMS.get(self.noun, self.noun)}) or (
            bool(self.colour) and self.colour == mention.colour and mention.noun in ("", "thing")
        )


def mentions(tokens: Sequence[Token]) -> Iterator[Mention]:
    """Every noun with the colour before it ("red box", "red and blue cups") or after it ("the box that is red")."""
    colours: list[str] = []
    behind = 0  # where a relative clause ends that has been read
    for at, token in enumerate(tokens):
        if at < behind:
            continue
        stem = stem_of(token.text)
        following = [other.text for other in tokens[at + 1 : at + 6]]
        noun = _SYNONYMS.get(token.text) or _SYNONYMS.get(stem)
        if token.kind == "number":
            noun = "thing" if token.value == 1 and colours else None  # "the red one"
        if token.text in COLOURS:
            colours.append(COLOURS[token.text])
        elif noun is not None:
            if following[:2] in _RELATIVE:
                colours += [COLOURS[word] for word in following[2:3] if word in COLOURS]
                behind = at + 4
            numbered = noun == "block" or stem == "box"
            tag = next((word for word in following[:3] if word.isdigit()), "") if numbered else ""
            yield from (Mention(noun, colour, tag) for colour in colours or [""])
            colours = []
        elif token.text not in _BETWEEN:
            yield from (Mention("", colour) for colour in colours)
            colours = []
    yield from (Mention("", colour) for colour in colours)


def things_in_english(text: str) -> tuple[Token, ...]:
    """The things that a Chinese text names, in the words that perception has for them."""
    plain = text.casefold().translate(SIMPLER)
    plain = _ZH.sub(lambda found: f" {CHINESE.get(found[0], 'robot')} ", plain)
    plain = _ZH_NUMBERED.sub(lambda found: f"block {found[1].translate(_NUMERALS)}", plain)
    return words_of(_ZH_BETWEEN.sub(" ", plain)).tokens


def stem_of(word: str) -> str:
    """A word as it is compared: singular, and nobody's."""
    word = word.removesuffix("'s")
    if len(word) > 4 and word.endswith(("xes", "ches", "shes", "sses")):
        return word[:-2]
    if len(word) > 4 and word.endswith("lves"):
        return word[:-3] + "f"
    return word[:-1] if len(word) > 3 and word.endswith("s") and not word.endswith("ss") else word
