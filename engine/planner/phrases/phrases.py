"""The fixed phrases of one language and one house: how actions are told, what is asked back, and small talk."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from config.schema import Place
from engine.plan import ActionCall
from engine.planner.phrases.answers import Answers
from engine.planner.phrases.said import Question
from engine.planner.phrases.small_talk import SmallTalk
from engine.planner.text.language import load
from engine.skills.library import LIBRARY
from engine.skills.places import Places
from engine.skills.registry import Skill
from engine.skills.vocabulary import Vocabulary


@dataclass(frozen=True, slots=True)
class Told:
    """What a plan is told as."""

    steps: tuple[str, ...]  # one sentence for each action
    response: str  # what the robot answers; may be empty

    @property
    def doing(self) -> str:
        """The answer as a part of a sentence: "going to the kitchen"."""
        words = self.response.rstrip(".。")
        return f"{words[:1].lower()}{words[1:]}"


class Phrases:
    """Thread-safe. ``vocabulary`` has the words of the house beyond the places; ``skills`` are those of the library
    where none are given. ``robot`` has the places of the running robot."""

    def __init__(
        self,
        places: Mapping[str, Place],
        language: str = "en",
        *,
        vocabulary: Vocabulary | None = None,
        skills: Iterable[Skill] | None = None,
        robot: Places | None = None,
    ) -> None:
        sections = load(language)
        offered = {skill.name: skill for skill in (LIBRARY if skills is None else skills)}
        words = vocabulary or Vocabulary(Places(places))
        self._answers = Answers(sections, places, words, offered, robot or Places(places))
        self._talk = SmallTalk(sections)

    @property
    def understood(self) -> str:
        """A sentence with examples of what can be said."""
        return self._answers.understood

    @property
    def abilities(self) -> str:
        """A sentence that tells what the robot can do."""
        return self._answers.abilities

    @property
    def places(self) -> tuple[str, ...]:
        """Names of the places on the map."""
        return self._answers.places

    def question(self, missing: Question) -> str:
        """The question for what a command lacks."""
        return self._answers.question(missing)

    def phrase(self, key: str) -> str:
        """What the robot says on stopping: ``stop``, ``stop_rest``, ``end_task``."""
        return self._answers.phrase(key)

    def talk(self, text: str, *, asks: bool = False) -> str:
        """The answer to small talk, or to a question that only small talk answers."""
        return self._talk.answer(text, asks=asks)

    def only_talk(self, text: str) -> str:
        """The answer to ``text`` where its words are those of small talk, and no others; else empty."""
        return self._talk.only(text)

    def told(self, calls: Sequence[ActionCall]) -> Told:
        """How actions are told; those without words for them, by their names."""
        try:
            return Told(self._answers.steps(calls), self._answers.response(calls))
        except (KeyError, IndexError, ValueError):
            return Told(tuple(call.name for call in calls), "")
