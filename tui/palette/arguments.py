"""The arguments of a skill as somebody types them: each with its unit, its limits and what may stand there.

This only helps to write a request that is right; what becomes of it is decided where all requests are.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from config.nearest import nearest
from tui.palette.calls import Values
from tui.shown.facts import printable
from tui.words import strings

if TYPE_CHECKING:
    from engine.offer import Offer
    from engine.skills.registry import Parameter, Skill


@dataclass(frozen=True, slots=True)
class Blank:
    """One argument to be filled in."""

    name: str
    unit: str
    usual: str
    """What it is when nothing is written; empty where something must be."""
    limits: str
    """What is allowed, for people."""
    choices: tuple[str, ...]
    """What may stand there; empty for numbers and sentences."""
    parameter: Parameter

    @property
    def required(self) -> bool:
        return self.parameter.default is None


class NotRight(ValueError):
    """What was written cannot be this argument; the message says what can."""


def blanks(skill: Skill, offer: Offer, seen: tuple[str, ...] = ()) -> tuple[Blank, ...]:
    """The arguments of a skill; ``seen`` are things that lie about, which may be meant as well."""
    return tuple(_blank(parameter, offer, seen) for parameter in skill.parameters)


def _blank(parameter: Parameter, offer: Offer, seen: tuple[str, ...]) -> Blank:
    usual = parameter.default
    shown = "" if usual is None else f"{usual:g}" if isinstance(usual, float | int) else usual
    if parameter.low is not None and parameter.high is not None:
        limits = strings.FORM_NUMBER.format(low=parameter.low, high=parameter.high)
        return Blank(parameter.name, parameter.unit, shown, limits, (), parameter)
    choices = offer.choices.get(parameter.word or "", ())
    if parameter.word == "object":
        choices = tuple(dict.fromkeys((*seen, *choices)))
    return Blank(parameter.name, "", shown, printable(", ".join(choices)) or strings.FORM_WORDS, choices, parameter)


def nearest_choice(blank: Blank, written: str) -> str:
    """What was probably meant, where what was written is none of what is known; empty where it is, or none is near.
    Other words may be right as well: who knows is the planner."""
    words = written.strip().casefold()
    begun = any(choice.casefold().startswith(words) for choice in blank.choices)
    return "" if begun else nearest(words, blank.choices)


def value_of(blank: Blank, written: str) -> float | str | None:
    """What was written, in the unit of the parameter; None where the usual value will do. Raises :class:`NotRight`."""
    text = written.strip()
    if not text:
        if blank.required:
            raise NotRight(strings.FORM_MISSING.format(name=blank.name))
        return None
    return _number(blank, text) if blank.parameter.type == "number" else text


def _number(blank: Blank, text: str) -> float:
    from engine.errors import PlanError
    from engine.plan import Quantity
    from engine.skills.units import convert

    match = re.fullmatch(r"([+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+))\s*(\S*)", text)
    if match is None:
        raise NotRight(strings.FORM_NO_NUMBER.format(name=blank.name))
    try:
        number = convert(Quantity(float(match[1].replace(",", ".")), match[2]), blank.parameter.unit, blank.name)
    except PlanError as error:
        raise NotRight(str(error)) from error
    low, high = blank.parameter.low, blank.parameter.high
    if low is not None and high is not None and not low <= number <= high:
        raise NotRight(strings.FORM_RANGE.format(name=blank.name, low=low, high=high, unit=blank.unit).rstrip())
    return number


def values(lines: Mapping[Blank, str]) -> Values:
    """All arguments. Raises :class:`NotRight` at the first that cannot be."""
    read = {blank.name: value_of(blank, written) for blank, written in lines.items()}
    return {name: value for name, value in read.items() if value is not None}
