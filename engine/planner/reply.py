"""What a model answered, read with suspicion: an object of JSON with actions, a response, a question, or a reason.

The form is that of execution layers: ``{"action": ["name(args)", …], "response": "…", "clarification": null | "…"}``;
``impossible`` may say why it cannot be done at all, ``refuse`` why it must not. Whatever a model puts around the object
(a fence, a sentence) is left out; actions may also come as objects with ``name`` and ``args``. Nothing here believes
that an action exists: only the skill registry knows.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from engine.errors import PlanError
from engine.plan import MAX_ACTIONS, ActionCall, Argument, Quantity, parse_call, parse_calls
from engine.skills.registry import NOT_SAID
from engine.strict_json import read_first_json

MAX_REPLY: Final = 20_000
"""Longest answer that is read, characters."""
LONGEST_SENTENCE: Final = 400
"""Characters of a response or a question that are passed on."""
FINISH: Final = "finishtask"
_UNSAID: Final = re.compile(r"(?<=[(,=])\s*['\"]?\?['\"]?\s*(?=[),])")

SCHEMA: Final[Mapping[str, Any]] = {
    "type": "object",
    "properties": {
        "action": {"type": "array", "items": {"type": "string"}},
        "response": {"type": "string"},
        "clarification": {"type": ["string", "null"]},
        "impossible": {"type": ["string", "null"]},
        "refuse": {"type": ["string", "null"]},
    },
    "required": ["action", "response", "clarification", "impossible", "refuse"],
    "additionalProperties": False,
}
"""JSON schema of an answer, for services that can be held to one."""

STEPS_SCHEMA: Final[Mapping[str, Any]] = {
    "type": "object",
    "properties": {"steps": {"type": "array", "items": {"type": "string"}}},
    "required": ["steps"],
    "additionalProperties": False,
}
"""JSON schema of a decision layer's answer."""


class UnreadableReply(PlanError):
    """A model's answer is no plan. The message tells the model what is wrong with it."""

    code = "unreadable_reply"


@dataclass(frozen=True, slots=True)
class Proposal:
    """What a model proposes; nothing of it has been checked against the skills."""

    calls: tuple[ActionCall, ...] = ()
    response: str = ""
    clarification: str = ""
    impossible: str = ""
    refuse: str = ""

    @property
    def finishes(self) -> bool:
        """The model wants no feedback."""
        return any(call.name in (FINISH, "finish_dialogue") for call in self.calls)


def read_reply(text: str) -> Proposal:
    """The proposal in a model's answer. Raises :class:`UnreadableReply`, or ``PlanError`` for a malformed action."""
    found = _object(text)
    actions = found.get("action", found.get("actions", []))
    if isinstance(actions, str):
        calls: tuple[ActionCall, ...] = parse_calls(_UNSAID.sub(NOT_SAID, actions))
    elif isinstance(actions, list) and len(actions) <= MAX_ACTIONS:
        calls = tuple(_call(action) for action in actions)
    elif isinstance(actions, list):
        raise UnreadableReply(f"There are {len(actions)} actions; a plan has {MAX_ACTIONS} at most.")
    else:
        raise UnreadableReply('"action" must be a list of strings.')
    proposal = Proposal(
        calls, *(_sentence(found.get(key)) for key in ("response", "clarification", "impossible", "refuse"))
    )
    if proposal == Proposal():
        raise UnreadableReply("There is no action, no response and no clarification in it.")
    return proposal


def read_steps(text: str) -> tuple[str, ...]:
    """The steps of a decision layer: a JSON object with ``steps``, or else a line each. Raises
    :class:`UnreadableReply`."""
    try:
        steps = _object(text).get("steps")
    except UnreadableReply:
        steps = text[:MAX_REPLY].splitlines()
    if not isinstance(steps, list):
        raise UnreadableReply('There is no list of "steps" in it.')
    plain = (_sentence(step).lstrip("0123456789.)-* \t") for step in steps)
    return tuple(step for step in plain if step)[:MAX_ACTIONS]


def _object(text: str) -> dict[str, Any]:
    """The first JSON object in a text."""
    if len(text) > MAX_REPLY:
        raise UnreadableReply(f"The answer is {len(text)} characters long; {MAX_REPLY} are read at most.")
    start = text.find("{")
    try:
        found = read_first_json(text[start:]) if start >= 0 else None
    except ValueError:
        found = None
    if not isinstance(found, dict):
        raise UnreadableReply("The answer must be one JSON object and nothing else.")
    return found


def _call(action: object) -> ActionCall:
    if isinstance(action, str):
        return parse_call(_UNSAID.sub(NOT_SAID, action))
    if isinstance(action, Mapping) and isinstance(name := action.get("name", action.get("action")), str):
        args = action.get("args", action.get("arguments", action.get("parameters", {})))
        if isinstance(args, Mapping):
            return ActionCall(name, (), {str(key): _argument(value) for key, value in args.items()})
        if isinstance(args, Sequence) and not isinstance(args, str):
            return ActionCall(name, tuple(_argument(value) for value in args))
    raise UnreadableReply(f'This is no action: {str(action)[:80]!r}. Write it as a string: "name(arguments)".')


def _argument(value: object) -> Argument:
    match value:
        case bool():
            raise UnreadableReply("An argument is a number or a text.")
        case int() | float():
            return Quantity(float(value))
        case str():
            return NOT_SAID if value.strip() == "?" else value
    raise UnreadableReply(f"An argument is a number or a text, not {str(value)[:40]!r}.")


def _sentence(value: object) -> str:
    """A text of a model, fit to be shown: one line, without control characters, not too long."""
    if not isinstance(value, str) or value.strip().casefold() in ("", "null", "none"):
        return ""
    line = " ".join("".join(sign if sign.isprintable() else " " for sign in value).split())
    return line if len(line) <= LONGEST_SENTENCE else f"{line[: LONGEST_SENTENCE - 1]}…"
