"""What a drawn command needs of the house, and what is to be judged of what becomes of it.

Everything is by name: people by the keys of the scene (``person 1``, ``operator``), things by theirs, rooms and places
as the house has them. :mod:`tests.eval.houses` builds what is needed, :mod:`tests.eval.gpsr.judge` judges.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

from engine.robot.company import Gesture, Posture
from tests.eval.gpsr.lexicon import Gender, Language

OPERATOR: Final = "operator"
"""The key of who gives the command."""

Side = Literal["left", "right", "on", "behind", "under"]
"""Where a thing is, seen from another one by somebody before the piece of furniture."""


@dataclass(frozen=True, slots=True)
class Guest:
    """Somebody who must be in the house; the n-th of them is ``person n``."""

    at: str  # a room, or a place of it
    called: str
    gender: Gender
    posture: Posture = "standing"
    gesture: Gesture | None = None
    known: bool = False
    is_child: bool = False
    strays: bool = False  # stops once on the way
    leads_to: str = ""  # a room, or a place, that they walk to in order to be followed
    replies: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Item:
    """A thing that must be in the house, by the key that it gets."""

    name: str  # what it is, in English
    key: str
    at: str  # a placement, or a room: on its floor
    scale: float = 1.0  # of its usual size
    beside: tuple[Side, str] | None = None  # the key of another
    category: str = ""


@dataclass(frozen=True, slots=True)
class Needs:
    """What a house must have for a command; everything else is up to its seed."""

    guests: tuple[Guest, ...] = ()
    items: tuple[Item, ...] = ()
    clear: frozenset[str] = frozenset()
    """Rooms and placements that have nothing, and nobody, but what is said here."""
    blocked: str = ""
    """A placement whose way something stands in that the map does not have."""


What = Literal["pick", "put", "give", "take", "find", "go", "follow", "guide", "tell", "ask", "look", "clean"]


@dataclass(frozen=True, slots=True)
class Want:
    """One thing that a plan must come to. Each field lists what will do; an empty one is not judged."""

    what: tuple[What, ...]
    who: tuple[str, ...] = ()  # words of which the argument has one
    things: tuple[str, ...] = ()  # keys
    places: tuple[str, ...] = ()
    about: tuple[str, ...] = ()  # parts of words, of which the call has one: what is asked of what is looked at


Truth = Literal[
    "on",
    "given",
    "binned",
    "put away",
    "arrived",
    "robot in",
    "found",
    "accompanied",
    "heard",
    "found person",
    "kept",
    "kept",
]


@dataclass(frozen=True, slots=True)
class MustBe:
    """One thing that must be true at the end, or have happened. What the fields mean: :mod:`tests.eval.gpsr.truths`."""

    what: Truth
    who: str = ""
    things: tuple[str, ...] = ()
    place: str = ""
    words: tuple[str, ...] = ()  # of which a sentence that they hear has one
    count: int = 1  # how many of the things


@dataclass(frozen=True, slots=True)
class Fact:
    """One thing that must be told: a word of each group, and none of those that are wrong."""

    groups: tuple[tuple[str, ...], ...] = ()
    wrong: tuple[str, ...] = ()
    number: int | None = None
    of_the_day: Literal["", "time", "today", "tomorrow", "weekday", "day"] = ""
    to: str = ""  # who must hear it; whoever asked, without


@dataclass(frozen=True, slots=True)
class Goal:
    """What is wanted."""

    wants: tuple[Want, ...]
    truths: tuple[MustBe, ...] = ()
    facts: tuple[Fact, ...] = ()
    cannot: str = ""
    """Why no body of this kind can do it; empty where it can."""
    answers: Mapping[str, str] = field(default_factory=dict)
    """What is said where the robot asks for something that has one of these words in its question; "" is any."""


@dataclass(frozen=True, slots=True)
class Command:
    """A drawn command with all that belongs to it."""

    seed: int
    number: int
    category: str
    kind: str  # the production that says what it means
    path: tuple[str, ...]
    language: Language
    text: str
    needs: Needs
    goal: Goal
