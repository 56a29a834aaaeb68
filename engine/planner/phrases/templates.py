"""The templates: which intent a clause has, and what fills its slots.

This is the only file that knows ``hassil``. A clause reaches it as text in which every measure is an index and a
unit ("go forward 0 metres"): hassil's number lists cannot hold arbitrary decimals, and with indices one cached match
serves for every distance.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, Final, Literal, NamedTuple, get_args

from config.schema import Place
from engine.errors import PlanError
from engine.han import template_apart
from engine.planner.phrases.first_words import FirstWords
from engine.planner.phrases.said import ONE
from engine.planner.text.measures import read_measures
from engine.planner.text.words import Token, words_of
from engine.skills.registry import Skill
from engine.skills.vocabulary import Vocabulary

Kind = Literal["intents", "incomplete_intents", "open_intents", "talk_intents"]
"""Sections of the phrase file that are matched separately."""


class Context(NamedTuple):
    """What earlier clauses were about, as the phrase file's ``requires_context`` names it."""

    last: str = ""  # go, turn, look, put, errand or line; placed: put in the plan before
    arm: str = ""  # yes, once the arm was spoken of
    light: str = ""  # yes, once the light was


NOTHING = Context()
"""Before the first clause."""

CACHED_CLAUSES = 512
SHORTEST_NAME = 3
"""Of a place that is recognised without words that lead there, characters: "a" is a symbol on the map."""


@dataclass(frozen=True, slots=True)
class Match:
    """A clause that fits a template to its last word."""

    intent: str
    words: Mapping[str, str] = field(default_factory=dict)  # closed slots and fixed ones, by name
    numbers: Mapping[str, int] = field(default_factory=dict)  # slots that hold an index or a whole number
    wildcard: str = ""  # what an open slot took


class Templates:
    """The compiled templates of one language for one house, without those for ``missing`` intents."""

    def __init__(
        self,
        sections: Mapping[str, Any],
        places: Mapping[str, Place],
        vocabulary: Vocabulary,
        skills: Iterable[Skill],
        missing: Collection[str] = (),
    ) -> None:
        """Beside those of the phrase file, there are the sentences by which the records of ``skills`` ask for them."""
        # imported here: hassil takes 0.1 s to load, and stop words must not wait for it
        from hassil import Intents

        language, lists = sections["language"], sections["lists"]
        rules = {"lists": lists, "expansion_rules": sections["expansion_rules"]}
        shared = Intents.from_dict({"language": language, **rules, "intents": {}})
        spoken_names = tuple(_spoken_names(places))
        self._names = frozenset(name for name, _ in spoken_names)
        words = {
            "place": spoken_names,
            "room_place": tuple(_rooms_among(spoken_names, vocabulary)),
            "named_place": tuple(_alone(spoken_names, map(spoken, sections["not_alone"]))),
            "charging": tuple(_charging(sections["charging"], spoken_names)),
            "surface": _pairs(vocabulary.surfaces(), vocabulary.surface),
            "source": _pairs((*vocabulary.surfaces(), *vocabulary.rooms()), vocabulary.surface),
            "room": _pairs(vocabulary.rooms(), vocabulary.room),
            **dict(_thing_lists(sections["things"], _pairs(vocabulary.things(), vocabulary.object))),
        }
        shared.slot_lists |= {name: _slot_list(name, pairs) for name, pairs in words.items()}
        wildcards = {name: values for name, values in lists.items() if "wildcard" in values}
        self._intents = {}
        for kind in get_args(Kind):
            wanted = {name: intent for name, intent in sections[kind].items() if name not in missing}
            if kind == "intents":
                wanted |= {ASKED + skill.name: made for skill in skills if (made := _asked(skill, language))}
            intents = Intents.from_dict({"language": language, "lists": wildcards, "intents": wanted})
            intents.slot_lists, intents.expansion_rules = shared.slot_lists, shared.expansion_rules
            self._intents[kind] = FirstWords(intents)
        self._cached = lru_cache(CACHED_CLAUSES)(self._recognize)
        self._usual: Sequence[str] = sections["warm_up"]

    def warm_up(self) -> None:
        """Have hassil compile what the usual clauses meet, which it does when it first meets it: for whoever stays on
        for many commands and has a twentieth of a second to spare. Without it the first commands take some ms."""
        for clause in self._usual:
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

        result = recognize(clause, self._intents[kind].beginning(clause), intent_context=context._asdict())
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


ASKED: Final = "asked:"
"""What the intent of a skill begins with that is asked for as its record says."""
BARE: Final = "bare_"
"""What the slot of a number without a unit begins with."""
_LISTS: Final[Mapping[str, str]] = {
    "m": "{distance:%s} metres", "deg": "{angle:%s} degrees", "s": "{duration:%s} seconds", "m/s": "{speed:%s} m/s",
    "rad/s": "{rate:%s} rad/s", "": "{whole:bare_%s}", "sentence": "{text:%s}",
}  # fmt: skip
"""How the slot of an argument is written, by its unit or its kind; others have the name of their kind."""


def _asked(skill: Skill, language: str) -> dict[str, Any]:
    """The intent of a skill, from the sentences of its record; empty where it has none."""
    sentences = (skill.words.zh if language == "zh" else skill.words.en).asked
    slots = {}
    for parameter in skill.parameters:
        kind = (
            parameter.unit if parameter.type == "number" else (parameter.word or "sentence").replace("places", "place")
        )
        slots[parameter.name] = _LISTS.get(kind, f"[<the>] {{{kind}:%s}}") % parameter.name
    made = [
        re.sub(r"\{(\w+)\}", lambda slot: slots[slot[1]], template_apart(sentence)).casefold() for sentence in sentences
    ]
    return {"data": [{"sentences": made}]} if made else {}


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


Pairs = tuple[tuple[str, str], ...]
"""Words as spoken, with what they stand for."""


def _slot_list(name: str, pairs: Iterable[tuple[str, str]]) -> Any:
    from hassil import TextSlotList

    return TextSlotList.from_tuples(pairs, allow_template=False, name=name)


def _pairs(words: Iterable[str], resolve: Callable[[str], str]) -> Pairs:
    """Words as spoken, with what they stand for; those that stand for several things stay, and are told about later."""
    return tuple((said, _resolved(word, resolve)) for word in words if (said := spoken(word)))


def _resolved(word: str, resolve: Callable[[str], str]) -> str:
    try:
        return resolve(word)
    except PlanError:
        return word


def _thing_lists(words: Mapping[str, Any], called: Pairs) -> Iterator[tuple[str, Pairs]]:
    """The lists of things: every noun with and without every colour, and the names that things have here."""
    colours = tuple((said, colour) for colour, spellings in words["colours"].items() for said in spellings)
    yield "thing_colour", colours
    yield "person", tuple((said, "person") for said in words["person"])
    for name, nouns, vague, more in (
        ("object", words["one"], words["vague"], called), ("objects", words["many"], words["vague_many"], ()),
    ):  # fmt: skip
        plain = tuple((said, noun) for noun, spellings in nouns.items() for said in spellings)
        coloured = (*plain, *((spoken(said), ONE if said == "one" else "thing") for said in vague))
        both = ((f"{hue} {said}", f"{colour} {noun}") for hue, colour in colours for said, noun in coloured)
        yield name, (*plain, *both, *more)


def _alone(names: Iterable[tuple[str, str]], never: Iterable[str]) -> Iterator[tuple[str, str]]:
    """The names of places that mean them whatever stands around them: no symbols, and none of those words."""
    words = frozenset(never)
    return ((name, symbol) for name, symbol in names if len(name) >= SHORTEST_NAME and name not in words)


def _charging(words: Mapping[str, Any], names: Iterable[tuple[str, str]]) -> Iterator[tuple[str, str]]:
    """The words for charging, with the place where that is done; nothing where the map has none."""
    symbol = next((symbol for name, symbol in names if name in map(spoken, words["places"])), None)
    return ((spoken(said), symbol) for said in words["words"] if symbol is not None)


def _rooms_among(names: Iterable[tuple[str, str]], vocabulary: Vocabulary) -> Iterator[tuple[str, str]]:
    """The names of places that are rooms."""
    rooms = frozenset(spoken(word) for word in vocabulary.rooms())
    return ((name, symbol) for name, symbol in names if name in rooms)


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
