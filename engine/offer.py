"""What the robot can be asked to do, and the words of its house to ask with: what a form or a completion needs to
know. Names only, never where loose things are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import get_args

from engine.perception.sighting import Colour
from engine.skills.library.signals import COLOURS
from engine.skills.registry import Skill, SkillRegistry
from engine.skills.vocabulary import BIN, FLOOR, Vocabulary


@dataclass(frozen=True, slots=True)
class Offer:
    """A snapshot. Whoever asks for something is understood by the planner, or not: nothing here is a permission."""

    skills: tuple[Skill, ...] = ()
    choices: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """What may stand for each kind of word (``engine.skills.registry.Word``), the usual names; none for sentences."""
    words: tuple[str, ...] = ()
    """Every word for a place, a room, a piece of furniture or a thing, in every language that the house has."""


def offered(registry: SkillRegistry, vocabulary: Vocabulary, places: tuple[str, ...]) -> Offer:
    """What this registry can do in this house; ``places`` are the usual names of those on its map."""
    furniture = vocabulary.furniture()
    choices = {
        "place": places,
        "places": places,
        "object": vocabulary.inventory(),
        "surface": tuple(dict.fromkeys((*furniture, BIN, FLOOR))),
        "room": tuple(word for word in vocabulary.rooms() if word in vocabulary.names()),
        "thing_colour": get_args(Colour),
        "colour": tuple(COLOURS),
    }
    words = (*vocabulary.places(), *vocabulary.rooms(), *vocabulary.surfaces(), *vocabulary.names())
    return Offer(tuple(registry), choices, tuple(dict.fromkeys(words)))
