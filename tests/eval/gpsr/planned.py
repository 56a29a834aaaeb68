"""Only plans a command, in the house that it would be performed in: what of it was not understood, without physics."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping

from engine.errors import ExitCode
from engine.parts.loading import at_home
from engine.planner.build import build_planner
from engine.planner.request import NoPlan, PlanRequest
from tests.eval.gpsr.acts import Names, acts_of, unwanted
from tests.eval.gpsr.goal import Command
from tests.eval.houses import house
from tests.eval.runner import _scene_file, _settings
from tests.eval.tasks import Trial


def misunderstood(command: Command, settings: Mapping[str, str]) -> tuple[str, ...]:
    """What is wrong with the plan; empty where nothing is. A question is right where the command leaves something
    open."""
    name = f"gpsr-{command.seed}-{command.number}"
    scene = house(command.seed * 1000 + command.number, command.needs, language=command.language, name=name)
    trial = Trial(
        kind=command.kind, seed=command.number, say=command.text, scene=scene, settings=dict(settings), limit_s=1,
        watch_s=None, success=({"collisions": 0},),
    )  # fmt: skip
    with _scene_file(trial) as file:
        at = at_home(_settings(trial, file, "max", []))
        found = asyncio.run(build_planner(at).plan(PlanRequest(command.text)))
    if isinstance(found, NoPlan):
        asks = found.exit_code == ExitCode.CLARIFY
        return () if asks and command.goal.answers else (found.answer,)
    acts = acts_of([(action.name, action.args) for action in found.actions])
    wrong = unwanted(command.goal.wants, acts, Names(scene, at.places))
    return (*wrong, f"plan: {'; '.join(map(str, found.actions))}") if wrong else ()
