"""What plans are written with before they are checked: calls, and the questions for what a command lacks."""

from __future__ import annotations

from typing import Literal

from engine.plan import ActionCall, Quantity

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
    "who",
    "where_person",
    "how_high",
]


def call(name: str, *arguments: Quantity | str) -> Calls:
    """One action."""
    return (ActionCall(name, arguments),)
