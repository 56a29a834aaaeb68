"""Builds the planner and the skill registry from settings: enough to plan, nothing that could move."""

from __future__ import annotations

from config.schema import Settings
from engine.errors import PlanError
from engine.planner.phrases import PhrasePlanner
from engine.planner.planner import Planner
from engine.robot.robot import Capability
from engine.skills.library import LIBRARY
from engine.skills.library.signals import COLOURS
from engine.skills.places import Places
from engine.skills.registry import SkillRegistry

CAPABILITIES: dict[str, frozenset[Capability]] = {"sim": frozenset({"base", "arm", "camera", "voice"})}
"""What each kind of robot has; known without starting it."""


def build_registry(settings: Settings, places: Places | None = None) -> SkillRegistry:
    """The skills that the configured robot can do."""
    known = places or Places(settings.places)
    return SkillRegistry(
        LIBRARY,
        capabilities=CAPABILITIES[settings.robot.kind],
        vocabulary={"place": known.symbol, "colour": _colour},
    )


def build_planner(settings: Settings, registry: SkillRegistry | None = None) -> Planner:
    """The planner of these settings."""
    return Planner(
        PhrasePlanner(settings.places, language=settings.planner.language),
        registry or build_registry(settings),
        max_actions=settings.planner.max_actions,
    )


def _colour(word: str) -> str:
    colour = word.casefold().strip()
    if colour not in COLOURS:
        raise PlanError(f"The light cannot be {word!r}.", hint=f"It can be: {', '.join(COLOURS)}.")
    return colour
