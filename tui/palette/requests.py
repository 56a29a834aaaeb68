"""How a skill with its arguments is asked for in plain English, in words that phrases understand without a model.

What stands here is put into the input line, where a person reads it and sends it, and then goes the way of everything
that is typed: nothing passes the planner and its registry. A skill that has no words here (one of a user's own, or one
for pixels of a picture) is written as a model writes it, which only a model understands.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from engine.skills.registry import Parameter, Skill

Values = Mapping[str, float | str]
"""Arguments by parameter name, numbers in the unit of the parameter; those that are left out are not there."""


def request(skill: Skill, values: Values) -> str:
    """What a person types to have this done."""
    given = {name: value for name, value in values.items() if value != ""}
    composed = _COMPOSED.get(skill.name)
    if composed is not None and (text := composed(given)):
        return text
    template = _TEMPLATES.get(skill.name)
    if template is not None:
        usual = {parameter.name: parameter.default for parameter in skill.parameters}
        unusual = {name: value for name, value in given.items() if value != usual[name]}
        return _filled(template, unusual)
    return as_written(skill, given)


def is_plain(skill: Skill, text: str) -> bool:
    """Whether a request for a skill is in words, and not written as only a model understands it."""
    return not text.startswith(f"{skill.name}(")


def as_written(skill: Skill, values: Values) -> str:
    """The action as a model writes it: ``get_dist(x=80, y=60)``."""
    arguments = ", ".join(
        f"{parameter.name}={_argument(parameter, values[parameter.name])}"
        for parameter in skill.parameters
        if parameter.name in values
    )
    return f"{skill.name}({arguments})"


def _argument(parameter: Parameter, value: float | str) -> str:
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return f"{value:g} {parameter.unit}".rstrip()


_TEMPLATES: Final = {
    "stop": "stop",
    "move_left": "turn left {angle} degrees[ at {angular_speed} rad/s]",
    "move_right": "turn right {angle} degrees[ at {angular_speed} rad/s]",
    "get_current_pose": "remember this place",
    "report_pose": "where are you?",
    "arm_up": "raise your arm",
    "arm_down": "lower your arm",
    "arm_nod": "nod",
    "arm_shake": "shake your head",
    "arm_applaud": "applaud",
    "dance": "dance",
    "drift": "drift",
    "servo1_move": "turn servo 1 to {angle} degrees",
    "open_gripper": "open your gripper",
    "close_gripper": "close your gripper",
    "seewhat": "what do you see?",
    "scan_room": "look around[ in the {room}]",
    "locate": "find the {object}",
    "navigate_to_object": "drive up to the {object}",
    "pick_object": "pick up the {object}",
    "putdown": "put it down",
    "place_object": "put it on the {surface}",
    "place_in_bin": "throw it into the bin",
    "carry": "bring the {object}[ from the {source}] to the {place}",
    "clean_room": "clean up[ the {room}]",
    "tidy": "put all {color} things on the {surface}",
    "color_follow": "follow the {color} thing",
    "person_follow": "follow me",
    "qr_follow": "follow the qr code",
    "follow_line": "follow the[ {color}] line",
    "follow_line_clear": "follow the[ {color}] line and clear it",
    "apriltag_sort": "sort block {id}",
    "apriltag_remove_higher": "remove all blocks higher than {height} metres",
    "color_remove_higher": "remove all {color} things higher than {height} metres",
    "wait": "wait {seconds} seconds",
    "beep": "beep[ for {seconds} seconds]",
    "light": "turn the light {color}",
    "say": "say {text}",
    "list_skills": "what can you do?",
    "finish_dialogue": "end the task",
    "apriltag_follow": "follow the tag[ {tag}]",
    "patrol": "patrol[ {places}]",
}
"""By skill. What is in brackets is left out where its argument is the skill's own default."""


def _filled(template: str, values: Values) -> str:
    def optional(match: re.Match[str]) -> str:
        part = match[1]
        return part if all(name in values for name in _SLOT.findall(part)) else ""

    return _SLOT.sub(lambda slot: _plain(values.get(slot[1], "")), re.sub(r"\[(.+?)\]", optional, template)).strip()


_SLOT: Final = re.compile(r"\{(\w+)\}")


def _plain(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:g}"


def _forward(values: Values) -> str:
    return _straight(values, "move forward", "move back")


def _sideways(values: Values) -> str:
    return _straight(values, "move left", "move right")


def _straight(values: Values, ahead: str, back: str) -> str:
    distance = values.get("distance", 0.0)
    assert isinstance(distance, float)
    pace = f" at {_plain(values['speed'])} m/s" if "speed" in values else ""
    return f"{ahead if distance >= 0 else back} {abs(distance):g} m{pace}"


def _velocity(values: Values) -> str:
    """One of the three directions at a time has words."""
    duration = _plain(values.get("duration", 0.0))
    ways = {name: speed for name in _WAYS if isinstance(speed := values.get(name), float) and speed}
    if len(ways) != 1:
        return ""
    [(name, speed)] = ways.items()
    way = _WAYS[name][speed < 0]
    unit = "rad/s" if name == "angular_z" else "m/s"
    return f"{way} at {abs(speed):g} {unit} for {duration} seconds"


_WAYS: Final = {
    "linear_x": ("move forward", "move back"),
    "linear_y": ("move left", "move right"),
    "angular_z": ("turn left", "turn right"),
}


def _journey(values: Values) -> str:
    place = _plain(values.get("place", ""))
    if place == "zero":
        return "come back"
    return f"go to the {place}" if place.isascii() else f"去{place}"


_COMPOSED: Final[dict[str, Callable[[Values], str]]] = {
    "move_forward": _forward,
    "move_sideways": _sideways,
    "set_cmdvel": _velocity,
    "navigation": _journey,
}
"""Skills whose words depend on their arguments; empty: it has none for these."""
