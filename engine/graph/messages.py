"""Between the messages of a graph and ours: pure functions, which raise ``SaysoError`` for what cannot be read."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import msgspec

from engine.commands import check_request, too_long
from engine.errors import ExitCode, PlanError, SaysoError, UsageError
from engine.events import ActionFinished, ActionView, IntentView, PlanMade, PlanSource, TurnResult
from engine.plan import MAX_TEXT, Action, ActionCall, Argument, Quantity, parse_calls
from engine.planner.phrases.stopping import is_emergency, is_end_task, is_stop
from engine.planner.validation import as_call
from engine.ros.door import Message
from engine.skills.registry import SkillRegistry
from engine.strict_json import is_text, read_json

STRING: Final = "std_msgs/msg/String"
EMPTY: Final = "std_msgs/msg/Empty"
GET_PLAN: Final = "sayso_interfaces/srv/GetPlan"
EXECUTE_PLAN: Final = "sayso_interfaces/action/ExecutePlan"

_CALL: Final = re.compile(r"[A-Za-z_]\w*\(")
"""What a plan begins with that is written as calls."""
_STOPS: Final = frozenset({"stop", "finish_dialogue"})
"""Skills that may be taken for a stop, or for the end of the task: that is what they are."""


@dataclass(frozen=True, slots=True)
class Asked:
    """What a goal asks for, as a request that the session takes: calls as they are written, or a sentence."""

    text: str
    is_calls: bool


def full_name(namespace: str | None, name: str) -> str:
    """The name in the graph: one that begins with / is complete."""
    if name.startswith("/") or not namespace:
        return f"/{name.lstrip('/')}"
    return f"/{namespace.strip('/')}/{name}"


# What peers send


def text_in(message: Message, field: str = "data", most: int = MAX_TEXT) -> str:
    """The text in a field. Raises ``UsageError`` for one that is none, or is longer than ``most`` characters."""
    text = message.get(field)
    if not isinstance(text, str):
        raise UsageError(f"The field {field} is no text.")
    if len(text) > most:
        raise UsageError(f"The field {field} is {len(text)} characters long; {most} are read at most.")
    if not is_text(text):
        raise UsageError(f"The field {field} is no text: it holds half a character.")
    return text


def object_in(message: Message) -> dict[str, Any]:
    """The JSON object in a String. Raises ``UsageError``."""
    text = text_in(message, most=2 * MAX_TEXT)
    try:
        found = read_json(text)
    except ValueError as error:
        raise UsageError(f"Not JSON: {error}.") from error
    if not isinstance(found, dict):
        raise UsageError("Not a JSON object.")
    return found


def read_plan(plan: object, registry: SkillRegistry) -> Asked:
    """What a goal asks for: the JSON of a plan, calls, or a sentence. Every call is checked by the registry here, as it
    will be again before anything moves. Raises ``UsageError`` or ``PlanError`` with the number of the step."""
    if isinstance(plan, str):
        text = text_in({"plan": plan}, "plan").strip()
        if text[:1] in ("{", "["):
            try:
                plan = read_json(text)
            except ValueError as error:
                raise UsageError(f"The plan is no JSON: {error}.") from error
        elif _CALL.match(text):
            plan = [text]
        else:
            check_request(text)
            return Asked(text, is_calls=False)
    calls = _calls(plan)
    written = as_written(calls)
    for number, call in enumerate(calls, 1):
        try:
            registry.resolve(call, written)
        except PlanError as error:
            raise _wrong(number, error) from error
    if (why := too_long(written)) is not None:
        raise UsageError(why)
    is_only_stop = len(calls) == 1 and calls[0].name in _STOPS
    if not is_only_stop and (is_stop(written) or is_emergency(written) or is_end_task(written)):
        raise PlanError("Words in this plan would be taken for a stop.", hint="Write them in another way.")
    return Asked(written, is_calls=True)


def _calls(plan: object) -> tuple[ActionCall, ...]:
    if isinstance(plan, Mapping):
        plan = plan.get("actions", plan.get("steps"))
    if not isinstance(plan, Sequence) or isinstance(plan, str | bytes):
        raise UsageError("A plan is a list of calls, or an object that has one as actions.")
    calls: list[ActionCall] = []
    for number, step in enumerate(plan, 1):
        try:
            found = parse_calls(step) if isinstance(step, str) else (_call(step),)
        except PlanError as error:
            raise _wrong(number, error) from error
        if not found:
            raise PlanError(f"Step {number} is empty.")
        calls += found
    if not calls:
        raise PlanError("The plan has no steps.")
    return tuple(calls)


def _call(step: object) -> ActionCall:
    """A step that is an object: ``{"name": …, "args": {…}, "alongside": false}``, as in our events."""
    if not isinstance(step, Mapping) or not isinstance(name := step.get("name"), str):
        raise PlanError("It is neither a call nor an object with a name.")
    args = step.get("args", {})
    if not isinstance(args, Mapping):
        raise PlanError("Its args are no object.")
    named: dict[str, Argument] = {}
    for key, value in args.items():
        if isinstance(value, str):
            named[str(key)] = value
        elif isinstance(value, int | float) and not isinstance(value, bool):
            named[str(key)] = Quantity(float(value))
        else:
            raise PlanError(f"Its argument {key} is neither a number nor a text.")
    return ActionCall(name, (), named, step.get("alongside") is True)


def _wrong(number: int, error: PlanError) -> PlanError:
    told = PlanError(f"Step {number}: {error.message}", hint=error.hint)
    told.exit_code = ExitCode(error.exit_code)
    return told


def as_written(calls: Iterable[ActionCall]) -> str:
    """Calls as they are read again."""
    text = ""
    for call in calls:
        given = [_argument(one) for one in call.positional]
        given += [f"{name}={_argument(one)}" for name, one in call.named.items()]
        joint = "" if not text else " & " if call.alongside else "; "
        text += f"{joint}{call.name}({', '.join(given)})"
    return text


def _argument(argument: Argument) -> str:
    if isinstance(argument, Quantity):
        return f"{argument.value:.12g} {argument.unit}".rstrip()
    escaped = argument.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n").replace("\t", "\\t")
    return f'"{escaped}"'


# What we send


def string(text: str) -> Message:
    """A String."""
    return {"data": whole(text)}


def as_json(found: object) -> str:
    return whole(json.dumps(found, ensure_ascii=False))


def whole(text: str) -> str:
    """Half a character, which a terminal can send, becomes ?."""
    return text.encode(errors="replace").decode()


def plan_told(
    goal: str,
    steps: Sequence[str],
    actions: Iterable[Action | ActionView],
    response: str,
    source: PlanSource,
    intent: IntentView | None,
    registry: SkillRegistry,
) -> dict[str, Any]:
    """A plan: ``goal`` and ``steps`` are in words, ``actions`` are calls, those that start together in one text."""
    return {
        "goal": goal,
        "steps": list(steps),
        "actions": _grouped(actions, registry),
        "response": response,
        "source": source,
        "intent": None if intent is None else msgspec.to_builtins(intent),
    }


def plan_made(plan: PlanMade, registry: SkillRegistry) -> dict[str, Any]:
    return plan_told(plan.goal, plan.steps, plan.actions, plan.response, plan.source, plan.intent, registry)


def call_told(name: str, args: Mapping[str, Any], registry: SkillRegistry) -> str:
    """An action as a call."""
    return as_written([as_call(registry[name], Action(name, args))])


def _grouped(actions: Iterable[Action | ActionView], registry: SkillRegistry) -> list[str]:
    groups: list[list[ActionCall]] = []
    for action in actions:
        call = as_call(registry[action.name], Action(action.name, action.args, action.alongside))
        if call.alongside and groups:
            groups[-1].append(call)
        else:
            groups.append([replace(call, alongside=False)])
    return [as_written(group) for group in groups]


def action_over(done: ActionFinished, registry: SkillRegistry) -> dict[str, Any]:
    """What became of an action."""
    return {
        "action": done.action,
        "call": call_told(done.name, done.args, registry),
        "name": done.name,
        "args": dict(done.args),
        "outcome": done.outcome,
        "error_code": done.error_code,
        "message": done.message,
        "duration_s": done.duration_s,
        "data": None if done.data is None else dict(done.data),
    }


def turn_over(result: TurnResult, actions: Sequence[Mapping[str, Any]], never: Sequence[str]) -> dict[str, Any]:
    """What became of a request."""
    return {
        "success": result.outcome == "done",
        "outcome": result.outcome,
        "exit_code": result.exit_code,
        "message": result.message,
        "actions": list(actions),
        "never_started": list(never),
    }


def goal_over(outcome: str, message: str, results: Sequence[Mapping[str, Any]] = ()) -> Message:
    """The result of ``execute_plan``."""
    return {
        "success": outcome == "done",
        "outcome": outcome,
        "message": whole(message),
        "results": as_json(list(results)),
    }


def goal_refused(error: SaysoError) -> Message:
    """The same where nothing was begun."""
    outcomes = {ExitCode.CLARIFY: "clarify", ExitCode.REFUSED: "refused"}
    return goal_over(outcomes.get(ExitCode(error.exit_code), "failed"), str(error))


def get_plan_over(plan: dict[str, Any] | None, message: str) -> Message:
    """The response of ``get_plan``."""
    return {
        "success": plan is not None,
        "plan": "" if plan is None else as_json(plan),
        "message": whole(message),
    }
