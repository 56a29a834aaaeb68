"""The templates: which intent a clause has, and what fills its slots.

This is the only file that knows ``hassil``. A clause reaches it as text in which every measure is an index and a
unit ("go forward 0 metres"): hassil's number lists cannot hold arbitrary decimals, and with indices one cached match
serves for every distance.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, Literal, NamedTuple, get_args

from config.schema import Place
from engine.planner.numbers import read_measures
from engine.planner.words import Token, words_of

Kind = Literal["intents", "incomplete_intents", "open_intents"]
"""Sections of the phrase file that are matched separately."""


class Context(NamedTuple):
    """What earlier clauses were about, as the phrase file's ``requires_context`` names it."""

    last: str = ""  # go or turn
    arm: str = ""  # yes, once the arm was spoken of


NOTHING = Context()
"""Before the first clause."""

CACHED_CLAUSES = 512


@dataclass(frozen=True, slots=True)
class Match:
    """A clause that fits a template to its last word."""

    intent: str
    words: Mapping[str, str] = field(default_factory=dict)  # closed slots and fixed ones, by name
    numbers: Mapping[str, int] = field(default_factory=dict)  # slots that hold an index or a whole number
    wildcard: str = ""  # what an open slot took


class Templates:
    """The compiled templates of one language for one map."""

    def __init__(self, sections: Mapping[str, Any], places: Mapping[str, Place]) -> None:
        # imported here: hassil takes 0.1 s to load, and stop words must not wait for it
        from hassil import Intents, TextSlotList

        shared = {key: sections[key] for key in ("language", "lists", "expansion_rules")}
        spoken_names = tuple(_spoken_names(places))
        names = TextSlotList.from_tuples(spoken_names, allow_template=False, name="place")
        self._names = frozenset(name for name, _ in spoken_names)
        self._intents = {kind: Intents.from_dict({**shared, "intents": sections[kind]}) for kind in get_args(Kind)}
        for intents in self._intents.values():
            intents.slot_lists["place"] = names
        self._cached = lru_cache(CACHED_CLAUSES)(self._recognize)
        for clause in sections["warm_up"]:  # hassil compiles what it meets: now, not in the first command
            for kind in self._intents:
                self._recognize(clause, NOTHING, kind)

    def match(self, clause: str, context: Context, kind: Kind = "intents") -> Match | None:
        """The first template of this kind that ``clause`` fits."""
        return self._cached(clause, context, kind)

    def is_place(self, name: str) -> bool:
        """Whether the map has a place of this name, as it is spoken."""
        return name in self._names

    def _recognize(self, clause: str, context: Context, kind: Kind) -> Match | None:
        from hassil import recognize

        result = recognize(clause, self._intents[kind], intent_context=context._asdict())
        if result is None:
            return None
        words, numbers, wildcard = {}, {}, ""
        for entity in result.entities_list:
            if entity.is_wildcard:
                wildcard = entity.text
            elif isinstance(entity.value, str):
                words[entity.name] = entity.value
            else:
                numbers[entity.name] = int(entity.value)
        return Match(result.intent.name, words, numbers, wildcard)


_UNIT_WORDS = {"m": "metres", "deg": "degrees", "s": "seconds"}


def render(words: Sequence[Token]) -> tuple[str, list[float]]:
    """The clause as templates read it, with an index in place of each measure, and the measures."""
    measures: list[float] = []
    parts: list[str] = []
    for token in words:
        if token.kind == "quantity":
            parts.append(f"{len(measures)} {_UNIT_WORDS.get(token.unit, token.unit)}")
            measures.append(token.value)
        else:
            parts.append(token.text)
    return " ".join(parts), measures


def spoken(text: str) -> str:
    """A name as it reaches the templates: lower case, numbers as digits, no punctuation."""
    return " ".join(token.text for token in read_measures(words_of(text).tokens) if token.kind != "mark")


def _spoken_names(places: Mapping[str, Place]) -> Iterator[tuple[str, str]]:
    """Every word for every place, with its symbol; ``zero`` is the remembered pose."""
    yield "zero", "zero"
    yield "0", "zero"
    for symbol, place in places.items():
        for name in (symbol, place.name, *place.aliases):
            said = spoken(name)
            if said:
                yield said, symbol
            if said.startswith("the "):
                yield said.removeprefix("the "), symbol
