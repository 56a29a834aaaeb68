"""Other words for the same request, as ``assets/rewordings`` has them: what is looked for, and what is said instead.

Whoever asks for them says where in a request a rule applies, and which words the house has for its places and things.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from typing import Any, Final

from engine.planner.request import Language
from engine.planner.text.language import alternatives, read
from engine.planner.text.patterns import written_out

_FOLDER: Final = files("assets") / "rewordings"
_NAME: Final = re.compile(r"\{(\w+)\}")
NOTHING: Final = "(?!)"
"""The pattern that finds nothing."""


@dataclass(frozen=True, slots=True)
class Rewording:
    """A pattern, and the words for what it finds."""

    pattern: re.Pattern[str]
    words: str
    """As a template of ``re``."""

    def everywhere(self, text: str) -> str:
        """``text`` with the other words wherever the pattern fits."""
        return self.pattern.sub(self.words, text)

    def at_start(self, text: str) -> str:
        """``text`` with the other words where it begins so; else as it was."""
        found = self.pattern.match(text)
        return text if found is None else found.expand(self.words) + text[found.end() :]

    def whole(self, text: str) -> str:
        """The other words for all of ``text``; empty where the pattern does not fit all of it."""
        found = self.pattern.fullmatch(text)
        return "" if found is None else found.expand(self.words)


class Rewordings:
    """The rules of one language for one house."""

    def __init__(self, language: Language, house: Mapping[str, str]) -> None:
        """``house`` has the parts of patterns that the file leaves open, as regular expressions."""
        self._sections = _file(language)
        self._house = house

    def section(self, name: str) -> Any:
        """What the file has under ``name``."""
        return self._sections[name]

    def pattern(self, name: str) -> re.Pattern[str]:
        """The single pattern of that name."""
        return self.compiled(self._sections["patterns"][name])

    def rules(self, section: str, *, frame: str = "{}", keeps: str = "", say: str = "") -> tuple[Rewording, ...]:
        """The rules of a section, each of their patterns in ``frame``. What they say begins with what ``keeps`` tells
        of the frame; a mere pattern is put as ``say``."""
        found = []
        for rule in self._sections[section]:
            when, words = (rule, say) if isinstance(rule, str) else (rule["when"], rule["say"])
            pattern = self.compiled(frame.replace("{}", f"({when})"))
            found.append(Rewording(pattern, _NAME.sub(r"\\g<\1>", f"{keeps}{words}")))
        return tuple(found)

    def compiled(self, pattern: str) -> re.Pattern[str]:
        """A pattern in the file's way of writing."""
        return re.compile(written_out(pattern, self._sections["parts"], self._house), re.IGNORECASE)


def names(words: Iterable[str]) -> str:
    """The pattern for any one of these words; one that finds nothing where there are none."""
    return alternatives(words) or NOTHING


@lru_cache
def _file(language: Language) -> Mapping[str, Any]:
    sections: Mapping[str, Any] = read(_FOLDER / f"{language}.yaml")
    return sections
