"""One language's phrase file, read once: ``assets/phrases/<language>.yaml``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import lru_cache
from importlib.resources import files
from typing import Any

import yaml

from engine.errors import UsageError

_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml is ten times as fast, where it is built in


@lru_cache
def load(language: str) -> Mapping[str, Any]:
    """The phrase file's sections, as they stand there. Raises :class:`UsageError` for a language without one."""
    source = files("assets") / "phrases" / f"{language}.yaml"
    if not source.is_file():
        raise UsageError(f"There are no phrases for the language {language!r}.", hint="Set planner.language to en.")
    sections: Mapping[str, Any] = yaml.load(source.read_text("utf-8"), Loader=_Loader)  # noqa: S506 - a safe loader
    return sections


def any_of(phrases: Iterable[str]) -> str:
    """Regular expression for any one of the phrases as whole words, the longest first.

    The group is atomic: text is read once from left to right, whatever it is, and never tried in a second way.
    """
    longest_first = sorted(phrases, key=len, reverse=True)
    return rf"(?<!\S)(?>{'|'.join(re.escape(phrase) for phrase in longest_first)})(?!\S)"


def without(pattern: re.Pattern[str], text: str) -> str:
    """``text`` with everything that matches taken out, and single spaces between what is left."""
    return " ".join(pattern.sub(" ", text).split())
