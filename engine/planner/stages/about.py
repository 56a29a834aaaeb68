"""Whether a sentence is about what the robot could do: a small model likes to chat about commands instead of planning
them, so that talk is only an answer to what is none of the robot's business."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from functools import lru_cache
from importlib.resources import files

import yaml

from engine.han import is_chinese
from engine.perception.naming import KINDS
from engine.skills.registry import Skill
from engine.skills.vocabulary import Vocabulary


class Subject:
    """The words of one robot in one house."""

    def __init__(self, skills: Iterable[Skill], vocabulary: Vocabulary) -> None:
        listed = _listed()
        told = " ".join(f"{skill.name.replace('_', ' ')} {skill.summary}" for skill in skills)
        words = set(re.findall(r"[a-z]+", told.lower()))
        names = (*vocabulary.names(), *vocabulary.surfaces(), *vocabulary.rooms(), *vocabulary.inventory())
        self._words: Collection[str] = (
            (words - set(listed["everyday"])) | set(listed["verbs"]) | set(KINDS) - {"thing", "object"}
        )
        self._verbs_zh = re.compile("|".join(listed["verbs_zh"]))
        self._names = tuple({name.casefold() for name in names if name})

    def covers(self, text: str) -> bool:
        """Whether ``text`` names something that the robot does, or something in its house."""
        plain = text.casefold()
        if is_chinese(plain) and self._verbs_zh.search(plain):
            return True
        if any(_stem(word) in self._words or word in self._words for word in re.findall(r"[a-z]+", plain)):
            return True
        return any(
            name in plain if is_chinese(name) else re.search(rf"\b{re.escape(name)}\b", plain) for name in self._names
        )


@lru_cache
def _listed() -> Mapping[str, list[str]]:
    text = (files("assets") / "prompts" / "subject.yaml").read_text("utf-8")
    found: Mapping[str, list[str]] = yaml.safe_load(text)
    return found


def _stem(word: str) -> str:
    for ending in ("ing", "es", "ed", "s"):
        if word.endswith(ending) and len(word) - len(ending) > 2:
            return word.removesuffix(ending)
    return word
