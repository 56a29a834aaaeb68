"""What large models are told: the skills, the house, examples, and the conversation so far.

A prompt has a fixed head (rules, skills, examples), which is the same for every house, so that a local model can keep
what it computed for it; then the house; then what was said and done in this task, oldest first; the newest request
last. The texts are in ``assets/prompts/``. Few skills are left out: what a model that sees no picture cannot use.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib.resources import files
from typing import Any, Final

import yaml

from engine.llm.chat import Message
from engine.plan import Plan
from engine.planner.happened import in_words
from engine.planner.request import Happened, Language, NoPlan, Said
from engine.planner.stages.brief import brief, grammar
from engine.planner.text.measures import in_figures
from engine.skills.registry import Skill

_FOLDER: Final = files("assets") / "prompts"
_BY_PICTURE: Final = frozenset({"grasp_obj", "track", "get_dist"})
"""Skills that want pixels of a picture."""
_OF_PEOPLE: Final = frozenset({"stop", "finish_dialogue", "list_skills", "ask_user", "return_to"})
"""Skills that a planner has other ways for."""
_OF_FEEDBACK: Final = frozenset({"finishtask"})
"""A model that is held to the brief form is not asked whether it is done."""
MAX_HAPPENED: Final = 24
"""Of what happened before, the newest that a model is told."""
MAX_SEEN: Final = 12


@dataclass(frozen=True, slots=True)
class HouseWords:
    """What the house is called by: names as a planner may use them."""

    places: tuple[str, ...]
    surfaces: tuple[str, ...]
    things: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Now:
    """The newest message: a request, or (where ``text`` is empty) feedback that is to be thought over."""

    text: str
    steps: tuple[str, ...] = ()
    known: tuple[str, ...] = ()
    holding: str = ""
    seen: tuple[str, ...] = ()
    conditional: bool = False


class Prompts:
    """The prompts of one language. ``brief`` is the form for models that a grammar holds to it: one key an answer;
    ``sees`` is for those that are shown pictures."""

    def __init__(
        self, language: Language, skills: Iterable[Skill], house: HouseWords, *, brief: bool, sees: bool
    ) -> None:
        self.language = language
        hidden = _OF_PEOPLE | (frozenset() if sees else _BY_PICTURE) | (_OF_FEEDBACK if brief else frozenset())
        self._skills = tuple(skill for skill in skills if skill.name not in hidden)
        self._house = house
        self._brief = brief
        self._words: Mapping[str, str] = _read("words.yaml")[language]

    def execution(self, happened: Sequence[Happened], now: Now) -> tuple[Message, ...]:
        """The messages for an execution layer."""
        return (*self.head, *self._conversation(happened, self._newest(now)))

    def decision(self, text: str, known: Sequence[str]) -> tuple[Message, ...]:
        """The messages for a decision layer."""
        abilities = "\n".join(f"- {skill.summary}" for skill in self._skills)
        head = _text(f"decision.{self.language}.md").format(skills=abilities, form=self._words["steps"])
        said = [*self._of_the_house, *self._known(known), self._word("request", text)]
        return (Message("system", head), Message("user", "\n".join(said)))

    def wrong(self, answer: str, why: str) -> tuple[Message, Message]:
        """To be put after the others when an answer was no good."""
        return Message("assistant", self._written(answer)), Message("user", self._word("wrong", why))

    def grammar(self, *, talks: bool) -> str:
        """GBNF of the brief form; only one who ``talks`` may answer with mere words."""
        return grammar(self._skills, talks=talks)

    @cached_property
    def head(self) -> tuple[Message, ...]:
        """What every question to an execution layer begins with; the house comes last, so that another one changes the
        end only."""
        turns = [
            message
            for example in _read(f"examples.{self.language}.yaml")
            if not self._brief or example.get("brief")
            for message in (
                Message("user", self._asked(example["user"])),
                Message("assistant", self._as_answer(example)),
            )
        ]
        understood = Message("assistant", self._as_answer({"response": self._words["at_home"]}))
        return (Message("system", self._rules), *turns, Message("user", "\n".join(self._of_the_house)), understood)

    @property
    def _rules(self) -> str:
        if self._brief:  # every word of it is computed before the first answer
            skills = ", ".join(f"{skill.name}({', '.join(p.name for p in skill.parameters)})" for skill in self._skills)
            return _text(f"brief.{self.language}.md").format(skills=skills, form=self._words["brief"])
        skills = "\n".join(f"{skill.signature}: {skill.summary}" for skill in self._skills)
        return _text(f"execution.{self.language}.md").format(skills=skills, form=self._words["full"])

    def _as_answer(self, found: Mapping[str, str]) -> str:
        """An example's answer, in the form that models are to write."""
        actions = found["action"].split("; ") if "action" in found else []
        answer: dict[str, object] = {"action": actions} if actions else {}
        if not self._brief:
            answer = {"action": actions, "response": "", "clarification": None, "impossible": None, "refuse": None}
        told = {key: value for key, value in found.items() if key not in ("user", "action", "brief")}
        return self._written(json.dumps({**answer, **told}, ensure_ascii=False))

    def _asked(self, request: str) -> str:
        """A request; among what is brief it needs no word before it."""
        return request if self._brief else self._word("request", request)

    def _written(self, answer: str) -> str:
        return brief(answer) if self._brief else answer

    @cached_property
    def _of_the_house(self) -> tuple[str, ...]:
        lists = (("places", self._house.places), ("surfaces", self._house.surfaces), ("things", self._house.things))
        return tuple(self._word(key, ", ".join(names) or self._words["nothing"]) for key, names in lists)

    def _conversation(self, happened: Sequence[Happened], newest: str) -> tuple[Message, ...]:
        """What happened before as turns of a chat; several things that are not the robot's answers are one turn."""
        turns: list[Message] = []
        said: list[str] = []
        for entry in happened[-MAX_HAPPENED:]:
            if isinstance(entry, Plan | NoPlan):
                turns += (Message("user", "\n".join(said)), Message("assistant", self._written(entry.as_written())))
                said = []
            elif isinstance(entry, Said):
                said.append(self._asked(in_figures(entry.text)))
            else:
                said.append(self._word("feedback", in_words(entry)))
        said.append(newest)
        return (*turns, Message("user", "\n".join(filter(None, said))))

    def _newest(self, now: Now) -> str:
        lines = list(self._known(now.known))
        if now.holding:
            lines.append(self._word("holding", now.holding))
        if now.seen:
            lines.append(self._word("seen", " ".join(now.seen[-MAX_SEEN:])))
        if now.text:
            lines.append(self._asked(in_figures(now.text)))
        if now.steps:
            lines.append(self._word("steps_told", "; ".join(now.steps)))
        if now.conditional:
            lines.append(self._words["conditional"])
        return "\n".join(lines)

    def _known(self, facts: Sequence[str]) -> tuple[str, ...]:
        return (self._word("known", " ".join(facts)),) if facts else ()

    def _word(self, key: str, value: str) -> str:
        return self._words[key].replace("{}", value)


@lru_cache
def _text(name: str) -> str:
    return (_FOLDER / name).read_text("utf-8").rstrip()


@lru_cache
def _read(name: str) -> Any:
    return yaml.safe_load(_text(name))
