"""``sayso skills``: what the robot can do, as planners see it."""

from __future__ import annotations

from argparse import Namespace

from engine.errors import ExitCode
from engine.parts.loading import at_home
from engine.planner.build import build_registry
from tui.commands.settings import load_settings
from tui.output import data, json_line


def run(arguments: Namespace) -> int:
    """One line a skill, or one JSON object a skill."""
    for skill in build_registry(at_home(load_settings(arguments))):
        if arguments.json:
            json_line(skill.describe())
        else:
            data(f"{skill.signature}\n    {skill.summary}")
    return int(ExitCode.DONE)
