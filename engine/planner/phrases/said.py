"""A clause that was understood, and what becomes of it: actions, or a question about what it lacks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

from engine.plan import ActionCall, Quantity
from engine.planner.phrases.conventions import Manner

Calls = tuple[ActionCall, ...]
Question = Literal[
    "how_far",
    "which_way",
    "which_colour",
    "which_unit",
    "where",
    "how_long",
    "what",
    "which_thing",
    "which_tag",
    "what_do",
    "where_put",
    "how_high",
]


class Things(NamedTuple):
    """What a sentence has been about so far."""

    named: str = ""  # the thing that was named last
    held: str = ""  # the one that was picked up and not put down
    done: tuple[tuple[str, tuple[Quantity | str, ...]], ...] = ()  # what was done last with the former
    fetched: tuple[tuple[str, str], ...] | None = None  # its source, where all that was said is to fetch it


ONE: Final = "one"
"""What a thing is that is called so: what was named before, of another colour."""
NOTHING_NAMED: Final = Things()


@dataclass(frozen=True, slots=True)
class Said:
    """A clause that was understood: its intent, and what was said in its slots, in SI units and degrees."""

    intent: str
    words: Mapping[str, str]
    numbers: Mapping[str, float]
    manner: Manner | None = None
    things: Things = NOTHING_NAMED  # what "it" may be


class Incomplete(Exception):
    """The clause is a command that lacks something; ``question`` says what."""

    def __init__(self, question: Question) -> None:
        super().__init__(question)
        self.question: Question = question


def call(name: str, *arguments: Quantity | str) -> Calls:
    """One action."""
    return (ActionCall(name, arguments),)


def just(name: str) -> Callable[[Said], Calls]:
    """One action without arguments."""
    return lambda said: call(name)
