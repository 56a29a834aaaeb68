"""Builds the planner and the skill registry from settings: enough to plan, nothing that could move."""

from __future__ import annotations

import atexit
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path

from config import paths
from config.schema import Place, Settings
from engine.errors import PlanError, UsageError
from engine.llm.chat import Chat
from engine.models.store import ModelStore
from engine.plan import Action
from engine.planner.grounding.doubt import Doubt, ungrounded
from engine.planner.phrases.phrases import Phrases, Told
from engine.planner.planner import Planner
from engine.planner.request import Language
from engine.planner.stages.about import Subject
from engine.planner.stages.blanks import filled
from engine.planner.stages.knowledge import Knowledge
from engine.planner.stages.models import Models
from engine.planner.stages.omissions import left_out
from engine.planner.stages.prompts import HouseWords, Prompts
from engine.planner.stages.slips import mended
from engine.planner.stages.two_stage import TwoStage
from engine.planner.validation import as_call
from engine.planner.worlds.house import build_vocabulary
from engine.planner.worlds.world import World
from engine.robot.bodies import description_of
from engine.skills.external.host import external_skill
from engine.skills.library import LIBRARY
from engine.skills.library.signals import COLOURS
from engine.skills.people import People
from engine.skills.places import Places
from engine.skills.registry import Skill, SkillRegistry
from engine.skills.vocabulary import Vocabulary
from engine.understanding.base import MODEL
from engine.understanding.learned import LearnedReader


def build_registry(
    settings: Settings, places: Places | None = None, people: People | None = None, *, world: World | None = None
) -> SkillRegistry:
    """The skills that the configured robot can do: the library, and the programs of the configuration. ``world``
    replaces the words of the scene. Raises :class:`UsageError` when a program takes a name of the library."""
    words = build_vocabulary(settings, places, people) if world is None else world.vocabulary(places)
    robot = description_of(settings.robot)
    return SkillRegistry(
        (*LIBRARY, *_external(settings)),
        capabilities=robot.capabilities,
        depth=robot.camera is None or robot.camera.depth,
        vocabulary={**words.resolvers(), "colour": _colour},
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


def build_planner(
    settings: Settings,
    registry: SkillRegistry | None = None,
    *,
    models: Models | None = None,
    world: World | None = None,
    reader: bool = True,
    places: Places | None = None,
) -> Planner:
    """The planner of these settings, for another world than that of the scene if one is given; without the
    learned one where ``reader`` is False. The phrases of a language are read when it is spoken. ``places`` are those
    of the running robot, which knows where it started."""
    skills = registry or build_registry(settings, world=world)
    mapped = settings.places if world is None else world.places
    vocabulary = build_vocabulary(settings) if world is None else world.vocabulary()

    @cache
    def phrases(language: Language) -> Phrases:
        return Phrases(mapped, language, vocabulary=vocabulary, skills=skills, robot=places)

    @cache
    def made(language: Language, brief: bool, sees: bool) -> Prompts:
        return Prompts(language, skills, _words(mapped, vocabulary), brief=brief, sees=sees)

    def prompts(language: Language, chat: Chat) -> Prompts:
        return made(language, chat.held, chat.sees)

    def doubts(
        actions: Sequence[Action], said: Sequence[str], seen: Sequence[str], known: Sequence[str], language: Language
    ) -> Doubt | None:
        return ungrounded(actions, skills, said, vocabulary, seen=seen, known=known, language=language)

    def tell(actions: Sequence[Action], language: Language) -> Told:
        return phrases(language).told([as_call(skills[action.name], action) for action in actions])

    two_stage = None
    if models is not None:
        two_stage = TwoStage(
            models.execution,
            models.decision,
            prompts,
            skills,
            Subject(skills, vocabulary).covers,
            lambda calls, text: filled(mended(calls, text, vocabulary), text, skills, vocabulary),
            lambda actions, text: left_out(actions, text, vocabulary),
            doubts,
            tell,
            max_actions=settings.planner.max_actions,
        )
    return Planner(
        phrases,
        skills,
        vocabulary,
        language=None if settings.planner.language == "auto" else settings.planner.language,
        models=two_stage,
        knowledge=Knowledge(paths().config / "knowledge.md"),
        tell=tell,
        max_actions=settings.planner.max_actions,
        reader=learned_reader(settings.models.folder or paths().models) if reader and settings.planner.reader else None,
    )


@cache
def learned_reader(folder: Path) -> LearnedReader | None:
    """The learned reader, which reads as soon as its base has been fetched; None where it has not been trained."""
    graphs = Path(str(files("assets") / "understanding"))
    if not (graphs / "encoder.onnx").exists():
        return None
    reader = LearnedReader(ModelStore(folder).file(MODEL), graphs)
    atexit.register(reader.close)  # onnxruntime must not be taken down before what uses it
    return reader


def _words(places: Mapping[str, Place], vocabulary: Vocabulary) -> HouseWords:
    """What a model is told of the house: names, not where loose things are."""
    names = tuple(place.name for place in places.values())
    return HouseWords(names, vocabulary.furniture(), vocabulary.inventory())


def _colour(word: str) -> str:
    colour = word.casefold().strip()
    if colour not in COLOURS:
        raise PlanError(f"The light cannot be {word!r}.", hint=f"It can be: {', '.join(COLOURS)}.")
    return colour
