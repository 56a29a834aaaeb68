"""What happened before, for tests of planners: as it stands in the history of a session."""

from __future__ import annotations

import json

from engine.errors import ExitCode
from engine.events import Outcome
from engine.plan import Action, Plan, Quantity, parse_call
from engine.planner.request import NoPlan, Ran
from engine.skills.library import LIBRARY

_PARAMETERS = {skill.name: skill.parameters for skill in LIBRARY}


def action(written: str) -> Action:
    """An action of the library as it is written, its words unchecked; what was left out is the skill's own."""
    call = parse_call(written)
    values = [value.value if isinstance(value, Quantity) else value for value in call.positional]
    parameters = _PARAMETERS.get(call.name, ())
    given = dict(zip((parameter.name for parameter in parameters), values, strict=False))
    defaults = {p.name: p.default for p in parameters if p.default is not None}
    return Action(call.name, {**defaults, **given} if parameters else {str(at): v for at, v in enumerate(values)})


def planned(*written: str) -> Plan:
    """A plan of these actions."""
    return Plan("", tuple(map(action, written)), "", "phrases")


def asked(question: str) -> NoPlan:
    """A question of the robot."""
    return NoPlan("", "incomplete", question, ExitCode.CLARIFY)


def answered(text: str) -> Plan:
    """An answer in words."""
    return Plan("", (), text, "openai", written=json.dumps({"response": text}, ensure_ascii=False))


def ran(written: str, outcome: Outcome = "ok", message: str = "") -> Ran:
    """An action that ran."""
    return Ran(action(written), outcome, message)
