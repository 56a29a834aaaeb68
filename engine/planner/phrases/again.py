"""What refers to the plan before: again, twice as far, the other way round, more slowly.

Templates read such a clause as a stand-in that says only what is to change; :func:`referred` puts the actions in its
place, those of the clauses before it or else those that were planned last. No model has to be asked.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import zip_longest
from math import copysign
from typing import Final

from engine.plan import MAX_ACTIONS, Action, ActionCall, Plan, Quantity
from engine.planner.phrases.conventions import DRIVE_SPEED, TURN_SPEED, Manner
from engine.planner.phrases.said import Calls, Said, call
from engine.planner.reply import FINISH
from engine.planner.request import Happened, Ran

_AGAIN: Final = "again"
"""The name of a stand-in, which is no skill."""
_MIRRORED: Final = {"move_left": "move_right", "move_right": "move_left"}
_DRIVES: Final = ("move_forward", "move_sideways")
_UNITS: Final[Mapping[str, Sequence[str]]] = {
    **dict.fromkeys(_DRIVES, ("m", "m/s")),
    **dict.fromkeys(_MIRRORED, ("deg", "rad/s")),
    **dict.fromkeys(("wait", "beep"), ("s",)),
    "set_cmdvel": ("m/s", "m/s", "rad/s", "s"),
}
"""Of the arguments, which plans are written without."""
_THING_AT: Final = {"pick_object": 0, "carry": 0, "locate": 0, "navigate_to_object": 0}
_PLACE_AT: Final = {"navigation": 0, "carry": 1, "scan_room": 0, "clean_room": 0, "place_object": 0}
"""Which argument is the thing, and which the place."""
_USUAL: Final = {"move_forward": 0.3, "move_sideways": 0.25, "move_left": 1.0, "move_right": 1.0}
"""The skills' own speeds: nobody has said them."""


def _repeated(said: Said) -> Calls:
    once = call(_AGAIN) if said.manner is None else call(_AGAIN, said.manner)
    return once * int(min(said.numbers.get("whole", 1), MAX_ACTIONS + 1))


def _with_another(said: Said) -> Calls:
    if "place" in said.words:
        return call(_AGAIN, "at", said.words["place"])
    number = f" {said.numbers['tag']:g}" if "tag" in said.numbers else ""
    return call(_AGAIN, "with", f"block{number}" if number else said.words["object"])


REFERENCES: Final[Mapping[str, Callable[[Said], Calls]]] = {
    "Again": _repeated,
    "AgainSo": lambda said: call(_AGAIN, said.words["change"]),
    "AgainWith": _with_another,
    "AgainTimes": lambda said: call(
        _AGAIN,
        "times",
        Quantity(said.numbers.get("factor", said.numbers.get("whole", 1))),
        *([said.words["change"]] if "change" in said.words else []),
    ),
    "AgainBy": lambda said: call(_AGAIN, "by", Quantity(said.numbers["distance"], "m")),
    "AgainTwice": lambda said: call(_AGAIN, "times", Quantity(2)),
    "AgainHalf": lambda said: call(_AGAIN, "times", Quantity(0.5)),
}
"""The stand-in of each intent."""


def planned_last(happened: Sequence[Happened]) -> Calls:
    """What was planned last in a task; of a plan that failed, only what has not been done."""
    done = 0
    for entry in reversed(happened):
        if isinstance(entry, Ran):
            done += entry.outcome == "ok"
        elif isinstance(entry, Plan) and (calls := _calls(entry)):
            return calls[done:] or calls
    return ()


def referred(calls: Calls, before: Calls) -> Calls | None:
    """``calls`` with what stand-ins refer to in their place: the calls in front of the first of them, else those
    ``before``. None where there are none, or where what is to change is nothing of theirs."""
    found: list[ActionCall] = []
    meant: Calls | None = None
    for one in calls:
        if one.name != _AGAIN:
            found.append(one)
            continue
        meant = meant or tuple(found) or before
        changed = _changed(meant, one)
        if not changed:
            return None
        found += changed
    return tuple(found)


def _calls(plan: Plan) -> Calls:
    actions = (action for action in plan.actions if action.name not in (FINISH, "finish_dialogue"))
    return tuple(_with_units(_call(action)) for action in actions)


def _call(action: Action) -> ActionCall:
    said = (Quantity(value) if isinstance(value, int | float) else value for value in action.args.values())
    return ActionCall(action.name, tuple(said), alongside=action.alongside)


def _with_units(call: ActionCall) -> ActionCall:
    units = _UNITS.get(call.name, ())
    arguments = [
        replace(argument, unit=unit) if isinstance(argument, Quantity) and not argument.unit else argument
        for argument, unit in zip_longest(call.positional, units[: len(call.positional)], fillvalue="")
    ]
    if len(arguments) == 2 and arguments[1] == Quantity(_USUAL.get(call.name, 0.0), units[1] if units else ""):
        arguments.pop()
    return replace(call, positional=tuple(arguments))


def _changed(calls: Calls, again: ActionCall) -> Calls | None:
    match again.positional:
        case ("times", Quantity() as factor, str(way)):
            turned = _changed(calls, ActionCall(_AGAIN, (way,)))
            return None if turned is None else _changed(turned, ActionCall(_AGAIN, ("times", factor)))
        case ("times", Quantity(factor)):
            change: Callable[[ActionCall], ActionCall] = lambda call: _scaled(call, factor)  # noqa: E731
        case ("by", Quantity(distance)) if any(call.name in _DRIVES for call in calls):
            return tuple(
                _with(call, 0, lambda old: copysign(distance, old)) if call.name in _DRIVES else call for call in calls
            )
        case ("by", _):
            return None
        case ("other way",):
            change = _mirrored
        case ("with" | "at" as slot, str(word)):
            change = lambda call: _filled(call, slot, word)  # noqa: E731
        case ("slow" | "fast" as manner,):
            change = lambda call: _at_pace(call, manner)  # noqa: E731
        case (str(way),):
            changed = tuple(call if _way(call) == way else _mirrored(call) for call in calls)
            return changed if any(_way(call) == way for call in changed) else None
        case _:
            return calls
    changed = tuple(map(change, calls))
    return changed if changed != calls else None


def _mirrored(call: ActionCall) -> ActionCall:
    if call.name in _MIRRORED:
        return replace(call, name=_MIRRORED[call.name])
    return _with(call, 0, lambda value: -value) if call.name in _DRIVES else call


def _way(call: ActionCall) -> str:
    """Where a motion goes, in a word."""
    first = call.positional[0] if call.positional else None
    negative = isinstance(first, Quantity) and first.value < 0
    match call.name:
        case "move_left" | "move_right":
            return call.name.removeprefix("move_")
        case "move_forward":
            return "back" if negative else "forward"
        case "move_sideways":
            return "right" if negative else "left"
    return ""


def _filled(call: ActionCall, slot: str, word: str) -> ActionCall:
    """With another thing or place; a "blue one" is what the thing before was."""
    index = (_THING_AT if slot == "with" else _PLACE_AT).get(call.name)
    if index is None or index >= len(call.positional):
        return call
    arguments = list(call.positional)
    noun = str(arguments[index]).split()[-1]
    if slot == "with" and word.endswith((" thing", " one")):
        word = f"{word.rpartition(' ')[0]} {noun}"
    arguments[index] = word
    return replace(call, positional=tuple(arguments))


def _scaled(call: ActionCall, factor: float) -> ActionCall:
    return _with(call, 3 if call.name == "set_cmdvel" else 0, lambda value: value * factor)


def _at_pace(call: ActionCall, manner: Manner) -> ActionCall:
    if call.name not in _USUAL:
        return call
    speed = (DRIVE_SPEED if call.name in _DRIVES else TURN_SPEED)[manner]
    return replace(call, positional=(*call.positional[:1], Quantity(speed, _UNITS[call.name][1])))


def _with(call: ActionCall, index: int, change: Callable[[float], float]) -> ActionCall:
    """With another measure as one of its arguments, where it has one there."""
    if call.name not in _UNITS or index >= len(call.positional):
        return call
    arguments = list(call.positional)
    if isinstance(number := arguments[index], Quantity):
        arguments[index] = replace(number, value=change(number.value))
    return replace(call, positional=tuple(arguments))
