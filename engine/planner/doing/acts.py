"""From what is meant to the actions that do it.

Each act has one function that turns its roles into calls of skills. What the roles name in this house decides which
skill serves: "look at the table" drives there, "look at the kitchen" scans a room."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Final

from engine.planner import amounts
from engine.planner.doing.conditions import untimed
from engine.planner.doing.doing import MOST, Doing, Roles, Unable
from engine.planner.doing.errands import FOLLOW_AND_CLEAR, as_errands
from engine.planner.doing.handling import bring, clean, drop, pick_up, push, put, sort, throw_away, tidy
from engine.planner.doing.looking import check, count, describe, find, look, report
from engine.planner.doing.moving import (
    charge,
    come,
    drive_shape,
    face,
    follow,
    follow_and_clear,
    go,
    go_back,
    guide,
    leave,
    meet,
    move,
    patrol,
    turn,
    turn_around,
    turn_to_no_side,
    unspecified,
    wait,
)
from engine.planner.doing.people import answer, ask, introduce, until_they_stand
from engine.planner.doing.several import one_by_one, spread, with_each
from engine.planner.doing.signals import arm_turn, beep, greet, just, light, often, remember, say, switch, tell, wave
from engine.planner.phrases.said import Calls, call
from engine.understanding.meaning import Do, If, Repeat


def calls_of(nodes: Sequence[Do | If | Repeat], doing: Doing) -> Calls:
    """The calls for what is wanted, behind those that ``doing`` has already. Raises Open, Which, NowhereKnown and
    Unable; conditions are somebody else's business."""
    for node in as_errands(spread(nodes, doing), doing):
        if isinstance(node, Repeat):
            _repeat(node, doing)
        elif isinstance(node, Do):
            _do(node, doing)
        else:
            raise Unable("condition")
    return tuple(until_they_stand(doing.calls))


def _repeat(node: Repeat, doing: Doing) -> None:
    count = amounts.times(node.times)
    if count is None:
        raise Unable("times", node.times)
    if _LISTED.search(node.times.casefold()):
        count = 1  # "three things: …" says how many acts there are
    before = len(doing.calls)
    for _ in range(count):
        calls_of([inner for inner in node.nodes if isinstance(inner, (Do, If, Repeat))], doing)
        if len(doing.calls) - before > MOST:
            break


_LISTED: Final = re.compile(
    r"\b(?:things?|steps|stages|parts|tasks|jobs|errands|orders|favou?rs|trips)\b|件事|个任务|趟"
)
"""What a speaker counts who lists them. Who goes twice with the same thing says "twice"."""


def _do(act: Do, doing: Doing) -> None:
    if act.act == "again" and doing.calls:
        doing.calls += doing.last * (amounts.times(act.words("times")) or 1)
        return
    if act.until is not None and (act := untimed(act)).until is not None:
        raise Unable("until")
    act = one_by_one(with_each(act, doing), doing)
    roles = Roles(act)
    found = _ACTS.get(act.act)
    if found is None:
        raise Unable("act")
    made = found(doing, roles)
    roles.must_be_used()
    doing.went(act)
    doing.last = made
    if made and list(made) == doing.calls[-1:] and made[0].name == "navigation":
        return  # there already: "go to the exit and wait at the exit"
    if made and act.together and doing.calls:
        made = (replace(made[0], alongside=True), *made[1:])
    doing.calls += made


_ACTS: Final[Mapping[str, Callable[[Doing, Roles], Calls]]] = {
    "go": go,
    "come": come,
    "forward": move("move_forward", 1),
    "backward": move("move_forward", -1),
    "sideways_left": move("move_sideways", 1),
    "sideways_right": move("move_sideways", -1),
    "turn_left": turn("move_left"),
    "turn_right": turn("move_right"),
    "move": unspecified,
    "turn": turn_to_no_side,
    "turn_around": turn_around,
    "face": face,
    "leave": leave,
    "go_back": go_back,
    "charge": charge,
    "drive_shape": drive_shape,
    "follow": follow,
    FOLLOW_AND_CLEAR: follow_and_clear,
    "guide": guide,
    "meet": meet,
    "patrol": patrol,
    "stop": just("stop"),
    "wait": wait,
    "drift": just("drift"),
    "dance": just("dance"),
    "pick_up": pick_up,
    "put": put,
    "bring": bring,
    "drop": drop,
    "push": push,
    "throw_away": throw_away,
    "tidy": tidy,
    "clean": clean,
    "sort": sort,
    "look": look,
    "find": find,
    "count": count,
    "check": check,
    "describe": describe,
    "arm_up": just("arm_up"),
    "arm_down": just("arm_down"),
    "arm_turn": arm_turn,
    "open_gripper": just("open_gripper"),
    "close_gripper": just("close_gripper"),
    "nod": often("arm_nod"),
    "shake": often("arm_shake"),
    "wave": wave,
    "applaud": often("arm_applaud"),
    "beep": beep,
    "light": light,
    "light_off": lambda doing, roles: call("light", "off"),
    "switch_on": switch("white"),
    "switch_off": switch("off"),
    "say": say,
    "tell": tell,
    "greet": greet,
    "ask": ask,
    "introduce": introduce,
    "answer": answer,
    "report": report,
    "skills": just("list_skills"),
    "remember": remember,
    "end_task": just("finish_dialogue"),
}
