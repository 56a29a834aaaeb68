"""The phrase files, each read once: ``assets/phrases/<language>.yaml``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import lru_cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any, Final, Literal

import yaml

from engine.errors import UsageError
from engine.han import HAN

_FOLDER = files("assets") / "phrases"
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml is ten times as fast, where it is built in
_HOLDS_TOGETHER: Final = re.compile(
    r"\b(?:go|drive|move|turn|rotate|come|take|bring|fetch|carry|get|give|put|place|drop|throw|pick|grab|find|look|search"
    r"|locate|show|tell|say|repeat|ask|clean|tidy|sort|follow|track|remember|patrol|wait|stop|raise|lower|open|close|set"
    r"|make|is|are|do|does|did|can|could|would|will|what|where|which|who|when|how|if|to|and|then|i|you|me)\b",
    re.IGNORECASE,
)
"""Words of an English sentence that are no names."""


def language_of(text: str) -> Literal["en", "zh"]:
    """The language of a request: Chinese where it holds a Chinese character, unless it begins as an English sentence.
    Names, and what is to be said, may be in the other language: "go to the 厨房", "say 你好", 去 kitchen."""
    beginning, *rest = re.split(HAN, text, maxsplit=1)
    return "zh" if rest and _HOLDS_TOGETHER.search(beginning) is None else "en"


def load(language: str) -> Mapping[str, Any]:
    """The sections of a language. Raises :class:`UsageError` where there is none of this name."""
    try:
        return all_phrases()[language]
    except KeyError:
        raise UsageError(
            f"There are no phrases for the language {language!r}.", hint="Set planner.language to en or zh."
        ) from None


@lru_cache
def all_phrases() -> Mapping[str, Mapping[str, Any]]:
    """The sections of every phrase file by language."""
    return {
        file.name.removesuffix(".yaml"): read(file)
        for file in sorted(_FOLDER.iterdir(), key=lambda file: file.name)
        if file.name.endswith(".yaml")
    }


def read(file: Traversable) -> Any:
    """What a data file holds."""
    return yaml.load(file.read_text("utf-8"), Loader=_Loader)  # noqa: S506 - a safe one


def alternatives(phrases: Iterable[str]) -> str:
    """Regular expression for any one of the phrases, the longest first; without bounds and brackets."""
    return "|".join(sorted(map(re.escape, phrases), key=len, reverse=True))


def any_of(phrases: Iterable[str]) -> str:
    """Regular expression for any one of the phrases as whole words, the longest first.

    The group is atomic: text is read once from left to right, whatever it is, and never tried in a second way.
    """
    return rf"(?<!\S)(?>{alternatives(phrases)})(?!\S)"


def without(pattern: re.Pattern[str], text: str) -> str:
    """``text`` with everything that matches taken out, and single spaces between what is left."""
    return " ".join(pattern.sub(" ", text).split())
