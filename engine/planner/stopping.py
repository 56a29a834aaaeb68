"""Stop, and the end of a task, recognised from bare text: no model, no wake word, no minimum length.

These two checks run on whatever is heard while the robot moves or speaks, so they need neither templates nor places
and load in milliseconds. Stopping errs on the side of stopping: "go left, no, stop!" and "stop and turn around" both
stop, and the rest has to be said again. "Go to the kitchen and stop" does not: a motion ends at rest anyway.
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Any

from engine.planner.language import any_of, load, without
from engine.planner.words import Token, words_of

MAX_TEXT = 1000
"""Longest sentence that is looked at, characters: a minute of fast speech."""


def is_stop(text: str, language: str = "en") -> bool:
    """Whether ``text`` tells the robot to stop."""
    return len(text) <= MAX_TEXT and _words(language).stops(text)


def is_end_task(text: str, language: str = "en") -> bool:
    """Whether ``text`` as a whole ends the conversation ("that's all", "end the current task")."""
    return len(text) <= MAX_TEXT and _words(language).ends_task(text)


def is_only_stop(text: str, language: str = "en") -> bool:
    """Whether ``text`` says stop and nothing else."""
    return len(text) <= MAX_TEXT and _words(language).only_stops(" ".join(p.strip() for p in _parts(text)))


@lru_cache
def _words(language: str) -> _StopWords:
    return _StopWords(load(language))


def _parts(text: str) -> list[str]:
    """The words between punctuation marks."""
    parts: list[list[Token]] = [[]]
    for token in words_of(text).tokens:
        if token.kind == "mark":
            parts.append([])
        else:
            parts[-1].append(token)
    return [" ".join(token.text for token in part) for part in parts if part]


class _StopWords:
    """The stop and end-task words of one language."""

    def __init__(self, sections: Any) -> None:
        stop = sections["stop"]
        anywhere, alone = any_of(stop["anywhere"]), any_of(stop["anywhere"] + stop["alone"])
        around = any_of(stop["interjections"])
        self._fillers = re.compile(any_of(sections["fillers"]))
        self._anywhere = re.compile(rf"(?:{around} )*+{anywhere}(?: (?:{anywhere}|{around}))*+")
        self._alone = re.compile(rf"(?:{alone}|{around})(?: (?:{alone}|{around}))*+")
        self._any = re.compile(alone)
        self._leading = re.compile(rf"(?:{around} )*+{anywhere} (?:and|then|but)(?!\S)")
        self._end_task = re.compile(any_of(sections["end_task"]))

    def stops(self, text: str) -> bool:
        parts = [self._bare(part) for part in _parts(text)]
        if any(self._anywhere.fullmatch(part) for part in parts):
            return True
        return self.only_stops(" ".join(parts)) or (bool(parts) and self._leading.match(parts[0]) is not None)

    def only_stops(self, text: str) -> bool:
        text = self._bare(text)
        return self._alone.fullmatch(text) is not None and self._any.search(text) is not None

    def ends_task(self, text: str) -> bool:
        parts = _parts(text)
        return any(self._end_task.fullmatch(t) for t in (" ".join(parts), self._bare(" ".join(parts))))

    def _bare(self, text: str) -> str:
        return without(self._fillers, text)
