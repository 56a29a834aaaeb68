"""Sentences by which the language records of skills ask for them: "(water|give water to) {plant} [for {time}]".

They are for skills that a user adds: what the built-in ones are asked for by, the learned reader has learnt.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from itertools import pairwise
from typing import Final

from engine.plan import ActionCall, Argument, Quantity
from engine.planner import amounts
from engine.planner.phrases.said import Calls
from engine.skills.registry import Parameter, Skill

_TOKEN: Final = re.compile(r"\{(?P<slot>\w+)\}|(?P<mark>[\[\]()|])|(?P<word>[^\s\[\](){}|]+)")
_MARKS: Final = {"[": "(?:", "]": ")?", "(": "(?:", ")": ")", "|": "|"}
_AROUND: Final = (
    r"(?:(?:please|now|robot|could you|can you|would you|will you|请你?|麻烦你?|帮我)\b[\s,，]*)*",
    r"[\s,，]*(?:(?:please|now|for me|thanks|thank you|吧|谢谢)[\s,，]*)*[.!?。！？\s]*",
)
_NO_NAME: Final = re.compile(r"[你我他她它]|的话|^(?:on|in|at|not|too|also|written|what|nobody)\b", re.IGNORECASE)
"""What no name holds: "我叫你去拿瓶子", "my name is on the box"."""
_ARTICLE: Final = re.compile(r"^(?:the|a|an|my|your|our) (?=\S)", re.IGNORECASE)
_JOINTS: Final = re.compile(
    r"(?:\s*[,，;；]\s*(?:and\s+)?(?:then\s+)?|\s+and\s+then\s+|\s+and\s+|\s+then\s+|然后|接着|再)(?=\S)", re.IGNORECASE
)
_MOST_PIECES: Final = 6


class Asked:
    """What is asked for in the words of skills' records. Thread-safe."""

    def __init__(self, skills: Iterable[Skill]) -> None:
        self._sentences = tuple(
            (re.compile(f"{_AROUND[0]}{_pattern(sentence)}{_AROUND[1]}", re.IGNORECASE), skill)
            for skill in skills
            for sentence in (*skill.words.en.asked, *skill.words.zh.asked)
        )

    def call(self, text: str) -> Calls:
        """The call of the skill that ``text`` asks for; nothing where it asks for none of these."""
        for pattern, skill in self._sentences:
            found = pattern.fullmatch(text.strip())
            given = (
                {key.partition("__")[0]: words for key, words in found.groupdict().items() if words} if found else {}
            )
            values = {p.name: _argument(p, given[p.name]) for p in skill.parameters if p.name in given}
            if found is not None and None not in values.values():
                named = {name: value for name, value in values.items() if value is not None}
                return (ActionCall(skill.name, named=named),)
        return ()

    def pieces(self, text: str) -> Iterator[tuple[str, Calls]]:
        """The parts of a request of which one at least asks for such a skill, each with its call; nothing where none
        does. What lies between two of them stays together."""
        if not self._sentences:
            return
        cuts = [(0, 0), *((joint.start(), joint.end()) for joint in _JOINTS.finditer(text)), (len(text), len(text))]
        parts = [text[before[1] : after[0]] for before, after in pairwise(cuts)]
        calls = [self.call(part) for part in parts]
        if len(parts) > _MOST_PIECES or not any(calls):
            return
        other: list[str] = []
        for part, call in zip(parts, calls, strict=True):
            if call and other:
                yield ", ".join(other), ()
                other.clear()
            if call:
                yield part, call
            else:
                other.append(part)
        if other:
            yield ", ".join(other), ()


def _pattern(sentence: str) -> str:
    """A regular expression; a slot that stands twice gets a number of its own."""
    parts: list[str] = []
    for number, token in enumerate(_TOKEN.finditer(sentence)):
        if token["slot"]:
            parts.append(rf"\s*(?P<{token['slot']}__{number}>.+?)\s*")
        elif token["mark"]:
            parts.append(_MARKS[token["mark"]])
        else:
            word = re.escape(token["word"])
            parts.append(rf"\s*\b{word}\b\s*" if token["word"].isascii() else rf"\s*{word}\s*")
    return "".join(parts)


def _argument(parameter: Parameter, words: str) -> Argument | None:
    """The words of a slot as an argument; None where they are no such thing."""
    if parameter.type != "number":
        words = words.strip(" ,.!?;:，。！？；：")
        if parameter.name == "name" and _NO_NAME.search(words):
            return None
        return words if parameter.word is None else _ARTICLE.sub("", words)
    if not parameter.unit:
        number = amounts.number(words)
        return None if number is None else Quantity(number, "")
    value = amounts.quantity(words, parameter.unit)
    return None if value is None else Quantity(value, parameter.unit)
