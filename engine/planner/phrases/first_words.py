"""Which templates a clause may fit, judged by its first word.

A matcher that tries every template takes longer with each one that is added. Most templates can begin with a few words
only, and those that cannot begin like the clause need not be tried: what is left is the same, in the same order.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from hassil import Intents


class Beginning(NamedTuple):
    """What an expression may begin with."""

    words: frozenset[str] | None  # None: any word (a number, a wildcard)
    skipped: bool = False  # it may also be nothing at all


ANYTHING = Beginning(None, True)


class FirstWords:
    """Templates by what they may begin with."""

    def __init__(self, intents: Intents) -> None:
        self._intents = intents
        self._rules: dict[str, Beginning] = {}
        self._beginnings = {
            id(sentence): self._of(sentence.expression).words
            for intent in intents.intents.values()
            for data in intent.data
            for sentence in data.sentences
        }
        self._chosen = lru_cache(maxsize=1024)(self._choose)

    def beginning(self, clause: str) -> Intents:
        """The templates that ``clause`` may fit."""
        return self._chosen(clause.split(" ", 1)[0])

    def _choose(self, word: str) -> Intents:
        chosen = {}
        for name, intent in self._intents.intents.items():
            data = [part for part in (self._part(data, word) for data in intent.data) if part is not None]
            if data:
                chosen[name] = replace(intent, data=data)
        return replace(self._intents, intents=chosen)

    def _part(self, data: Any, word: str) -> Any:
        """``data`` with those of its sentences that may begin with ``word``; None without any."""
        sentences = [s for s in data.sentences if (words := self._beginnings[id(s)]) is None or word in words]
        if not sentences:
            return None
        part = replace(data)
        vars(part)["sentences"] = sentences  # a cached property, which would parse the templates again
        return part

    def _of(self, expression: Any) -> Beginning:
        from hassil import expression as ex
        from hassil.intents import TextSlotList

        match expression:
            case ex.TextChunk():
                words = expression.text.casefold().split()
                return Beginning(frozenset(words[:1]), not words)
            case ex.RuleReference(rule_name=name):
                if name not in self._rules:
                    self._rules[name] = self._of(self._intents.expansion_rules[name].expression)
                return self._rules[name]
            case ex.ListReference():
                values = self._intents.slot_lists.get(expression.list_name)
                if not isinstance(values, TextSlotList):
                    return Beginning(None)
                return _either(self._of(value.text_in) for value in values.values)
            case ex.Alternative():
                words, skipped = _either(self._of(item) for item in expression.items)
                return Beginning(words, skipped or expression.is_optional)
            case ex.Sequence():
                return self._first_of(expression.items)
        return ANYTHING  # a permutation: not worth the trouble

    def _first_of(self, items: Iterable[Any]) -> Beginning:
        found: frozenset[str] = frozenset()
        for item in items:
            words, skipped = self._of(item)
            if words is None:
                return Beginning(None, skipped)
            found |= words
            if not skipped:
                return Beginning(found)
        return Beginning(found, skipped=True)


def _either(parts: Iterable[Beginning]) -> Beginning:
    found: frozenset[str] = frozenset()
    anyhow = skipped = False
    for words, may_skip in parts:
        found |= words or frozenset()
        anyhow, skipped = anyhow or words is None, skipped or may_skip
    return Beginning(None if anyhow else found, skipped)
