"""Builds the planner and the skill registry from settings: enough to plan, nothing that could move."""

from __future__ import annotations

from collections.abc import Iterator

from config.schema import Settings
from engine.errors import PlanError, UsageError
from engine.planner.house import build_vocabulary
from engine.planner.phrases import PhrasePlanner
from engine.planner.planner import Planner
from engine.robot.robot import Capability
from engine.skills.external.host import external_skill
from engine.skills.library import LIBRARY
from engine.skills.library.signals import COLOURS
from engine.skills.places import Places
from engine.skills.registry import Skill, SkillRegistry

CAPABILITIES: dict[str, frozenset[Capability]] = {"sim": frozenset({"base", "arm", "camera", "voice"})}
"""What each kind of robot has; known without starting it."""


def build_registry(settings: Settings, places: Places | None = None) -> SkillRegistry:
    """The skills that the configured robot can do: the library, and the programs of the configuration. Raises
    :class:`UsageError` when one of these takes a name of the library."""
    return SkillRegistry(
        (*LIBRARY, *_external(settings)),
        capabilities=CAPABILITIES[settings.robot.kind],
        vocabulary={**build_vocabulary(settings, places).resolvers(), "colour": _colour},
    )


def _external(settings: Settings) -> Iterator[Skill]:
    taken = {skill.name for skill in LIBRARY}
    for name, declaration in settings.skills.items():
        if name in taken:
            raise UsageError(
                f"skills.{name}: there is a built-in skill of this name.",
                hint="Give yours another one; `sayso config show` says which file it is in.",
            )
        yield external_skill(name, declaration)


def build_planner(settings: Settings, registry: SkillRegistry | None = None) -> Planner:
    """The planner of these settings."""
    skills = registry or build_registry(settings)
    phrases = PhrasePlanner(
        settings.places,
        language=settings.planner.language,
        vocabulary=build_vocabulary(settings),
        skills=frozenset(skill.name for skill in skills),
    )
    return Planner(phrases, skills, max_actions=settings.planner.max_actions)


def _colour(word: str) -> str:
    colour = word.casefold().strip()
    if colour not in COLOURS:
        raise PlanError(f"The light cannot be {word!r}.", hint=f"It can be: {', '.join(COLOURS)}.")
    return colour
