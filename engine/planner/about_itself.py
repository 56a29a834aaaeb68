"""Questions to the robot about itself, answered from what is on record, or with "I don't know": no model knows.

What it holds and has done is told as the session has it (:class:`~engine.planner.request.OnRecord`). "Continue" goes on
with what an interruption cut; a relative motion that was cut in the middle is asked about, because nobody has counted
how much of it is left.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from engine.events import Scope
from engine.plan import Action
from engine.planner.request import Language, OnRecord

_BECAUSE: Final[dict[Language, dict[Scope, str]]] = {
    "en": {
        "stop": "Because you said stop.",
        "estop": "Because you pressed the emergency stop.",
        "release": "Because you released the emergency stop.",
        "interrupt": "Because you interrupted me.",
        "wake": "Because you called me.",
        "end_task": "Because you ended the task.",
        "replaced": "Because you gave me another command.",
        "by_hand": "Because you drove me by hand.",
        "halted": "Because I had to stop by myself.",
        "shutdown": "Because the session ended.",
    },
    "zh": {
        "stop": "因为您说了停。",
        "estop": "因为您按下了急停。",
        "release": "因为您解除了急停。",
        "interrupt": "因为您打断了我。",
        "wake": "因为您叫了我。",
        "end_task": "因为您结束了任务。",
        "replaced": "因为您给了我别的命令。",
        "by_hand": "因为您手动驾驶了我。",
        "halted": "因为我自己不得不停下。",
        "shutdown": "因为会话结束了。",
    },
}
_SAID: Final[dict[Language, dict[str, str]]] = {
    "en": {
        "holding": "I hold the {thing}.",
        "nothing_held": "I hold nothing.",
        "not_stopped": "I don't know: nothing on record stopped me.",
        "battery": "I don't know how full my battery is: this robot does not tell me.",
        "charge": "My battery is about {percent:.0f} % full.",
        "nothing_done": "I have done nothing in this task yet.",
        "nothing_left": "There is nothing that I could go on with.",
        "cut": "I was stopped in the middle of {action}, and I don't know how much of it is left. What shall I do?",
    },
    "zh": {
        "holding": "我拿着{thing}。",
        "nothing_held": "我手里没有东西。",
        "not_stopped": "我不知道：记录里没有什么让我停下。",
        "charge": "我的电池大约还有百分之{percent:.0f}的电。",
        "battery": "我不知道还有多少电：这个机器人没有告诉我。",
        "nothing_done": "这个任务里我还什么都没做。",
        "nothing_left": "没有什么可以继续的。",
        "cut": "我在做{action}的时候被打断了，不知道还剩多少。您要我做什么？",
    },
}
RELATIVE: Final = frozenset({"move_forward", "move_sideways", "move_left", "move_right", "set_cmdvel", "drift", "wait"})
"""Actions of which a part is left when they were cut, and nobody knows how much."""


def of(kind: str, record: OnRecord, holding: str, language: Language) -> str:
    """The answer to what is asked: ``holding``, ``stopped``, ``battery``, ``done``; empty for anything else."""
    said = _SAID[language]
    match kind:
        case "holding":
            return said["holding"].format(thing=holding) if holding else said["nothing_held"]
        case "stopped" if record.stopped is not None:
            return _BECAUSE[language][record.stopped]
        case "stopped":
            return record.failure or said["not_stopped"]
        case "battery":
            if record.charge is None:
                return said["battery"]
            return said["charge"].format(percent=round(100 * record.charge, -1))
        case "done":
            return " ".join(record.done) or said["nothing_done"]
    return ""


def goes_on(record: OnRecord) -> bool:
    """Whether what is left on record can go on by itself."""
    return bool(record.left) and not (record.cut and record.left[0].name in RELATIVE)


def cannot_continue(record: OnRecord, language: Language, doing: Callable[[Action], str]) -> str:
    """Why what is left on record cannot go on by itself; empty where it can. ``doing`` tells what goes on while an
    action is done: "driving forward 1 metre"."""
    if goes_on(record):
        return ""
    said = _SAID[language]
    return said["cut"].format(action=doing(record.left[0])) if record.left else said["nothing_left"]
