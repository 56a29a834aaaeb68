"""What a model left blank although it was said: the one place, thing or measure of the request that the plan lacks.

Small models write that something was not said (``?``) more often than is true. A blank is filled where exactly one word
of the request can be meant; everything else is asked about.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from engine.plan import ActionCall, Quantity
from engine.planner.grounding.grounds import resolved
from engine.planner.grounding.mentions import Thing
from engine.planner.grounding.statement import Statement, said_names
from engine.planner.phrases.said import Calls
from engine.skills.registry import NOT_SAID, Parameter, SkillRegistry
from engine.skills.vocabulary import FLOOR, Vocabulary

_PLACES = frozenset({"place", "surface", "room"})
_CLOSE = 0.02  # relative


def filled(calls: Calls, text: str, skills: SkillRegistry, vocabulary: Vocabulary) -> Calls:
    """``calls`` with what ``text`` says in place of what was left blank."""
    blanks = [(index, parameter) for index, call in enumerate(calls) for parameter in _blank(call, skills)]
    if not blanks:
        return calls
    said = Statement(text)
    for index, parameter in blanks:
        alike = [other for _, other in blanks if (other.type, other.unit, other.word) == _kind(parameter)]
        if parameter.type == "number":
            found: list[Quantity | str] = [*_unused_measures(calls, said, parameter.unit)]
        elif parameter.word in _PLACES:
            found = [*_unused_places(calls, said, vocabulary, parameter.word)]
        elif parameter.word == "object":
            found = [*_unused_things(calls, said, vocabulary)]
        else:
            continue
        if len(found) == len(alike):
            calls = (*calls[:index], _with(calls[index], parameter, found[0], skills), *calls[index + 1 :])
            blanks = blanks[1:]
    return calls


def _kind(parameter: Parameter) -> tuple[str, str, str | None]:
    return parameter.type, parameter.unit, parameter.word


def _given(call: ActionCall, skills: SkillRegistry) -> dict[str, Quantity | str]:
    names = (parameter.name for parameter in skills[call.name].parameters)
    return {**dict(zip(names, call.positional, strict=False)), **call.named}


def _blank(call: ActionCall, skills: SkillRegistry) -> Iterator[Parameter]:
    """The required parameters that a call has no argument for."""
    try:
        skill = skills[call.name]
    except KeyError:
        return
    given = _given(call, skills)
    yield from (p for p in skill.parameters if given.get(p.name) == NOT_SAID and p.default is None)


def _with(call: ActionCall, parameter: Parameter, value: Quantity | str, skills: SkillRegistry) -> ActionCall:
    return replace(call, positional=(), named={**_given(call, skills), parameter.name: value})


def _arguments(calls: Calls) -> list[Quantity | str]:
    return [argument for call in calls for argument in (*call.positional, *call.named.values())]


def _unused_measures(calls: Calls, said: Statement, unit: str) -> Iterator[Quantity]:
    used = [abs(argument.value) for argument in _arguments(calls) if isinstance(argument, Quantity)]
    for value, of in said.quantities:
        if of != unit:
            continue
        taken = next((other for other in used if math.isclose(other, value, rel_tol=_CLOSE)), None)
        if taken is None:
            yield Quantity(value, unit)
        else:
            used.remove(taken)


def _unused_places(calls: Calls, said: Statement, vocabulary: Vocabulary, kind: str) -> Iterator[str]:
    resolvers = vocabulary.resolvers()
    used = {
        meant
        for argument in _arguments(calls)
        if isinstance(argument, str)
        for of in _PLACES
        if (meant := resolved(resolvers[of], argument)) is not None
    }
    for name in said_names(said, (*vocabulary.rooms(), *vocabulary.places(), *vocabulary.surfaces())):
        stands_for = {resolved(resolvers[of], name) for of in _PLACES}
        if resolved(resolvers[kind], name) not in (None, FLOOR) and not stands_for & used:
            yield name


def _unused_things(calls: Calls, said: Statement, vocabulary: Vocabulary) -> Iterator[str]:
    words = [argument for argument in _arguments(calls) if isinstance(argument, str) and argument != NOT_SAID]
    used = [Thing.of(meant) for word in words if (meant := resolved(vocabulary.object, word)) is not None]
    named = [f"{mention.colour} {mention.noun} {mention.tag}" for mention in said.mentions if mention.has_kind]
    for name in dict.fromkeys((*(" ".join(name.split()) for name in named), *said_names(said, vocabulary.things()))):
        meant = resolved(vocabulary.object, name)
        if meant is not None and all(Thing.of(meant) != other for other in used):
            yield name
