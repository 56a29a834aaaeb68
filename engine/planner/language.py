"""The phrase files, each read once: ``assets/phrases/<language>.yaml``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import lru_cache
from importlib.resources import files
from typing import Any

import yaml

from engine.errors import UsageError

_FOLDER = files("assets") / "phrases"
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml is ten times as fast, where it is built in


def load(language: str) -> Mapping[str, Any]:
    """The sections of a language that plans are made in. Raises :class:`UsageError` when that is none of them."""
    for name, sections in all_phrases().items():
        if name == language and "intents" in sections:
            return sections
    raise UsageError(f"There are no phrases for the language {language!r}.", hint="Set planner.language to en.")


@lru_cache
def all_phrases() -> Mapping[str, Mapping[str, Any]]:
    """The sections of every phrase file, as they stand there, by language. Some hold only what stops a robot."""
    return {
        file.name.removesuffix(".yaml"): yaml.load(file.read_text("utf-8"), Loader=_Loader)  # noqa: S506 - a safe one
        for file in sorted(_FOLDER.iterdir(), key=lambda file: file.name)
        if file.name.endswith(".yaml")
    }


def any_of(phrases: Iterable[str]) -> str:
    """Regular expression for any one of the phrases as whole words, the longest first.

    The group is atomic: text is read once from left to right, whatever it is, and never tried in a second way.
    """
    longest_first = sorted(phrases, key=len, reverse=True)
    return rf"(?<!\S)(?>{'|'.join(re.escape(phrase) for phrase in longest_first)})(?!\S)"


def without(pattern: re.Pattern[str], text: str) -> str:
    """``text`` with everything that matches taken out, and single spaces between what is left."""
    return " ".join(pattern.sub(" ", text).split())
