"""The first thing in a plan that comes from nowhere, and the short question to ask instead of doing it.

Models fill gaps with what is likely, and a robot that drives to a likely place surprises people. So each argument of
each action is looked for in the words of this task. Vague words ("the thing", "over there") ground nothing, and "it" is
what was named last.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from engine.events import Value
from engine.plan import Action
from engine.planner.grounding.amounts import is_grounded_number
from engine.planner.grounding.colours import of_light
from engine.planner.grounding.grounds import Grounds
from engine.planner.grounding.places import about_surface, is_grounded_place, is_grounded_room
from engine.planner.grounding.questions import HOW_OFTEN, Question, about
from engine.planner.grounding.repetition import too_often
from engine.planner.grounding.statement import Statement
from engine.planner.grounding.things import about_thing
from engine.planner.request import Language
from engine.skills.registry import Parameter, SkillRegistry
from engine.skills.vocabulary import Vocabulary


@dataclass(frozen=True, slots=True)
class Doubt:
    """An argument without a ground, and what to ask about it."""

    action_index: int  # 0-based
    parameter: str  # its name; empty where the action as a whole has no ground
    question: str


def ungrounded(
    actions: Sequence[Action],
    skills: SkillRegistry,
    said: Sequence[str],
    vocabulary: Vocabulary,
    *,
    seen: Sequence[str] = (),
    known: Sequence[str] = (),
    language: Language = "en",
) -> Doubt | None:
    """The first argument of ``actions`` without a ground; None where all have one.

    ``said``: what the user said in this task, newest last. ``seen``: sentences or names of what was seen or reported.
    ``known``: facts of the user that were consulted. Raises ``KeyError`` for actions that ``skills`` does not have.
    """
    grounds = Grounds(
        tuple(Statement(text) for text in said if text),
        tuple(map(Statement, seen)),
        tuple(map(Statement, known)),
        vocabulary,
    )
    for index, action in enumerate(actions):
        for parameter in skills[action.name].parameters:
            value = action.args[parameter.name]
            question = None if value == parameter.default else _question(grounds, action, parameter, value)
            if question is not None:
                return Doubt(index, parameter.name, question.text(language))
    repeated = too_often(grounds, actions)
    return None if repeated is None else Doubt(repeated, "", HOW_OFTEN.text(language))


def _question(grounds: Grounds, action: Action, parameter: Parameter, value: Value) -> Question | None:
    """What to ask about this argument; None where it has a ground."""
    if isinstance(value, (int, float)) and parameter.type == "number":
        return None if is_grounded_number(grounds, action, parameter, float(value)) else about(parameter)
    word = str(value)
    match parameter.word:
        case "object":
            return about_thing(grounds, word)
        case "surface":
            return about_surface(grounds, word)
        case "place":
            grounded = is_grounded_place(grounds, word)
        case "places":
            grounded = all(is_grounded_place(grounds, symbol) for symbol in word.split(","))
        case "room":
            grounded = is_grounded_room(grounds, word)
        case "colour":
            grounded = grounds.says(of_light(word))
        case "thing_colour":
            grounded = any(mention.colour == word for text in grounds.everything() for mention in text.mentions)
        case _:
            grounded = True
    return None if grounded else about(parameter)
