"""The language record of each built-in skill: what it is called, how it is told and asked for, in English and Chinese.

A record is a file of ``assets/skills`` with the name of the skill; :class:`~config.schema.SkillRecord` says what may
stand in it. An external skill has its record in its declaration."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import Any, Final

import yaml

from config.schema import SkillRecord

FOLDER: Final = files("assets") / "skills"
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml is ten times as fast, where it is built in


def records() -> dict[str, SkillRecord]:
    """All records of built-in skills, by the names of these."""
    return {
        name: record_of(name) for file in FOLDER.iterdir() if (name := file.name.removesuffix(".yaml")) != file.name
    }


@cache
def record_of(name: str) -> SkillRecord:
    """The record of the built-in skill ``name``; an empty one where it has none."""
    file = FOLDER / f"{name}.yaml"
    if not file.is_file():
        return SkillRecord()
    return SkillRecord.model_validate(yaml.load(file.read_text("utf-8"), _Loader))  # noqa: S506 - a safe loader
