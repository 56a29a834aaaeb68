"""A plan as an intent: what is to be done with which thing, where, and what is unclear about it.

Programs that came from voice-to-action pipelines expect ``{action, target, secondary_location, ambiguity,
clarification_question}`` and ``{goal, steps}``. Both are read off what was planned, so they never say more than that:
the action that the others serve names the intent, and the steps are those that skills go through.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

import msgspec

from engine.errors import ExitCode
from engine.events import Body, ClarificationAsked, IntentView, PlanMade
from engine.plan import Action, Plan
from engine.planner.grounding.vagueness import vague
from engine.planner.request import NoPlan

_GRASP: Final = ("locate", "navigate", "grasp", "lift")
_TRAVEL: Final = ("plan_path", "execute", "confirm_arrival")


class _Verb(NamedTuple):
    """How a skill is told as an intent."""

    action: str
    rank: int = 0  # of several, the last one of the highest rank is what the others serve
    target: str = ""  # the parameter that names it
    secondary: str = ""
    steps: tuple[str, ...] = ()


_VERBS: Final[Mapping[str, _Verb]] = {
    "carry": _Verb("bring", 4, "object", "place", (*_GRASP, "navigate", "place")),
    "place_object": _Verb("place", 4, "", "surface", ("navigate", "place")),
    "place_in_bin": _Verb("place", 4, "", "", ("navigate", "place_in_bin")),
    "putdown": _Verb("place", 4, "", "", ("place",)),
    "tidy": _Verb("tidy", 4, "color", "surface", ("scan_room", "navigate_to_object", "pick_object", "place_object")),
    "clean_room": _Verb(
        "clean_room", 4, "room", "",
        ("scan_room", "identify_dirty_objects", "navigate_to_object", "pick_object", "place_in_bin"),
    ),
    "apriltag_sort": _Verb("sort", 4, "id", "", (*_GRASP, "navigate", "place")),
    "apriltag_remove_higher": _Verb("remove", 4, "", "", ("scan_room", *_GRASP, "place")),
    "color_remove_higher": _Verb("remove", 4, "color", "", ("scan_room", *_GRASP, "place")),
    "pick_object": _Verb("pick_up", 3, "object", "", _GRASP),
    "grasp_obj": _Verb("pick_up", 3, "", "", ("navigate", "grasp", "lift")),
    "locate": _Verb("find", 2, "object", "", ("scan_room", "locate")),
    "navigate_to_object": _Verb("approach", 2, "object", "", ("locate", "navigate")),
    "person_follow": _Verb("follow", 2),
    "qr_follow": _Verb("follow", 2),
    "color_follow": _Verb("follow", 2, "color"),
    "apriltag_follow": _Verb("follow", 2, "tag"),
    "follow_line": _Verb("follow_line", 2, "color"),
    "follow_line_clear": _Verb("follow_line", 3, "color", "", ("follow_line", *_GRASP, "place")),
    "patrol": _Verb("patrol", 2, "places"),
    "navigation": _Verb("navigate", 1, "place", "", _TRAVEL),
    "seewhat": _Verb("look", 1),
    "scan_room": _Verb("look", 1, "room", "", ("scan_room",)),
    "move_forward": _Verb("move"),
    "move_sideways": _Verb("move"),
    "set_cmdvel": _Verb("move"),
    "move_left": _Verb("turn"),
    "move_right": _Verb("turn"),
    "say": _Verb("say", 0, "text"),
    "light": _Verb("light", 0, "color"),
    "finish_dialogue": _Verb("end_task"),
}  # fmt: skip

_SAID: Final[tuple[tuple[str, re.Pattern[str]], ...]] = tuple(
    (action, re.compile(pattern, re.IGNORECASE))
    for action, pattern in (
        ("bring", r"\b(?:bring|fetch|carry|deliver|get|give|hand)\b(?: me)?|拿给|送到|带到|拿来|带来|搬到|送给"),
        ("place", r"\b(?:put|place|set|lay|drop|throw)\b(?: down| away)?|放|扔|丢"),
        ("pick_up", r"\b(?:pick(?: up)?|grab|grasp|take|lift|hold)\b|拿起?|捡起?|抓住?|取"),
        ("clean_room", r"\b(?:clean|tidy)(?: up)?\b|打扫|收拾|清理"),
        ("follow", r"\b(?:follow|track)\b|跟"),
        ("find", r"\b(?:find|locate|look for|search for|search|where is)\b|找|在哪"),
        ("turn", r"\b(?:turn|rotate|spin)\b|转"),
        ("navigate", r"\b(?:go|drive|navigate|head|travel|come|run|walk) (?:over )?(?:to|into|there|"
                     r"over there)\b(?: to)?|去|到"),
        ("move", r"\b(?:move|go|drive|back up|reverse)\b|前进|后退|往前|往后|向前|向后|走"),
    )
)  # fmt: skip
"""What a request without a plan was about, in the order in which it is tried."""
_TARGET: Final = re.compile(
    r"^\W*(?:(?:up|the|a|an|my|your|that|this|some|one of the) )*(?P<target>[a-z0-9'-]+(?: [a-z0-9'-]+){0,2}?)"
    r"(?:[,.;!?]|$| (?:up|down|on|onto|in|into|to|from|away|there|here|and|then|please|for|off|over)\b)"
)
_NOTHING_NAMED: Final = frozenset({"it", "them", "there", "here", "up", "me", "down", "away", "left", "right"})
_UNCLEAR: Final[Mapping[str, str]] = {"navigate": "location", "move": "amount", "turn": "amount"}


def intent_of(found: Plan | NoPlan, places: Mapping[str, str] | None = None) -> IntentView:
    """The intent of a plan, or of a request that has none; ``places`` has the names of the map's symbols."""
    if isinstance(found, Plan):
        return _planned(found, places or {})
    if found.exit_code is ExitCode.CLARIFY:
        return _unclear(found)
    action = "refuse" if found.exit_code is ExitCode.REFUSED else "error"
    return IntentView(action, goal=action)


def with_intent(found: Plan | NoPlan, places: Mapping[str, str] | None = None) -> Body:
    """The event of ``found``, with the intent where the event has one."""
    event = found.as_event()
    if isinstance(event, (PlanMade, ClarificationAsked)):
        return msgspec.structs.replace(event, intent=intent_of(found, places))
    return event


def _planned(plan: Plan, places: Mapping[str, str]) -> IntentView:
    if not plan.actions:
        return IntentView("respond", goal="respond")
    steps = tuple(step for action in plan.actions for step in _steps(action))
    last = max(range(len(plan.actions)), key=lambda index: (_verb(plan.actions[index]).rank, index))
    served = plan.actions[last]
    verb = _verb(served)
    target = _argument(served, verb.target, places) or _held(plan.actions[:last], verb, places)
    secondary = "bin" if served.name == "place_in_bin" else _argument(served, verb.secondary, places)
    if served.name == "putdown":
        secondary = next(
            (_argument(a, "place", places) for a in reversed(plan.actions[:last]) if a.name == "navigation"), None
        )
    return IntentView(verb.action, target, secondary, goal=_goal(verb.action, target, secondary), steps=steps)


def _verb(action: Action) -> _Verb:
    return _VERBS.get(action.name) or _Verb(action.name)


def _steps(action: Action) -> tuple[str, ...]:
    return _verb(action).steps or (action.name,)


def _held(before: Sequence[Action], verb: _Verb, places: Mapping[str, str]) -> str | None:
    """What is put somewhere is what was picked up last."""
    if verb.action != "place":
        return None
    return next((_argument(a, "object", places) for a in reversed(before) if a.name == "pick_object"), None)


def _argument(action: Action, parameter: str, places: Mapping[str, str]) -> str | None:
    value = action.args.get(parameter) if parameter else None
    if value is None or value == "" or (parameter == "tag" and value == -1):
        return None
    words = f"{value:g}" if isinstance(value, float) else str(value)
    if parameter in ("place", "places"):
        return ", ".join(places.get(symbol, symbol) for symbol in words.split(","))
    return words


def _goal(action: str, target: str | None, secondary: str | None) -> str:
    """``pick_up_red_box``, ``navigate_to_kitchen``, ``place_cup_on_table``: one word for all of it."""
    parts = [action]
    if target:
        parts += ["to", target] if action == "navigate" else [target]
    if secondary:
        parts += ["in" if secondary == "bin" else "to" if action == "bring" else "on", secondary]
    return re.sub(r"\W+", "_", " ".join(parts).casefold()).strip("_")


def _unclear(found: NoPlan) -> IntentView:
    action, target = "clarify", None
    for name, pattern in _SAID:
        if (match := pattern.search(found.text)) is not None:
            action = name
            following = _TARGET.match(found.text[match.end() :].casefold())
            target = following["target"] if following is not None else None
            break
    if target in _NOTHING_NAMED or action in ("move", "turn"):
        target = None
    ambiguity = _UNCLEAR.get(action, "target" if action != "clarify" else "request")
    if action in ("bring", "place") and target is not None and not vague(found.text):
        ambiguity = "location"
    return IntentView(
        action, target, None, ambiguity, clarification_question=found.answer, goal="ask_for_clarification"
    )
