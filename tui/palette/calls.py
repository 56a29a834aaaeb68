"""A skill with its arguments as it is written into the line: ``move_forward(distance=0.8 m)``.

A person reads it there and sends it, and it goes the way of everything that is typed: the planner hands actions that
are written so to the skill registry, as they stand.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from engine.skills.registry import Parameter, Skill

Values = Mapping[str, float | str]
"""Arguments by parameter name, numbers in the unit of the parameter; those that are left out are not there."""


def as_written(skill: Skill, values: Values) -> str:
    """The action with these arguments; empty ones are left out."""
    arguments = ", ".join(
        f"{parameter.name}={_argument(parameter, values[parameter.name])}"
        for parameter in skill.parameters
        if values.get(parameter.name, "") != ""
    )
    return f"{skill.name}({arguments})"


def _argument(parameter: Parameter, value: float | str) -> str:
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return f"{value:g} {parameter.unit}".rstrip()
