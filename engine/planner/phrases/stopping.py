"""Stop, and the end of a task, recognised from bare text: no model, no wake word, no minimum length.

These two checks run on whatever is heard while the robot moves or speaks, so they need neither templates nor places,
load in milliseconds, and know the words of every language at once: who shouts stop has no time for settings. Stopping
errs on the side of stopping: "go left, no, stop!" and "stop and turn around" both stop, and the rest has to be said
again. "Go to the kitchen and stop" does not: a motion ends at rest anyway.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, Literal

from engine.planner.text.language import all_phrases, any_of, without
from engine.planner.text.words import Token, words_of

MAX_TEXT = 1000
"""Longest sentence that is looked at, characters: a minute of fast speech."""

_HAN = r"[\u3400-\u9fff\uf900-\ufaff]"
"""A Chinese character. Nothing separates Chinese words, so here each character counts as a word."""
_HAN_PAUSE = re.compile(rf"(?<={_HAN})\s+(?={_HAN})|[~～]+")
"""Recognisers write a space between Chinese characters where they would write a comma in English."""


def is_stop(text: str, *, ended: bool = True) -> bool:
    """Whether ``text`` tells the robot to stop, in any language. Not ``ended``: somebody talks on, and what is a stop
    only by itself is none yet, for "wait" may have been the beginning of "waiting for you"."""
    return len(text) <= MAX_TEXT and _words().stops(text, ended=ended)


def is_emergency(text: str) -> bool:
    """Whether ``text`` asks for the emergency stop, in any language."""
    return len(text) <= MAX_TEXT and _words().is_emergency(text)


def is_release(text: str) -> bool:
    """Whether ``text`` as a whole asks to release the emergency stop, in any language."""
    return len(text) <= MAX_TEXT and _words().releases(text)


def is_end_task(text: str) -> bool:
    """Whether ``text`` as a whole ends the conversation ("that's all", "end the current task"), in any language."""
    return len(text) <= MAX_TEXT and _words().ends_task(text)


def scope_of(text: str) -> Literal["estop", "stop", "end_task"] | None:
    """What a request in these words interrupts by itself, without being read."""
    if is_emergency(text):
        return "estop"
    return "stop" if is_stop(text) else "end_task" if is_end_task(text) else None


def is_only_stop(text: str) -> bool:
    """Whether ``text`` says stop and nothing else."""
    return len(text) <= MAX_TEXT and _words().only_stops(text)


@lru_cache
def _words() -> _StopWords:
    return _StopWords(tuple(all_phrases().values()))


class _StopWords:
    """The stop and end-task words of several languages."""

    def __init__(self, languages: Sequence[Mapping[str, Any]]) -> None:
        def stop(part: str) -> list[str]:
            return [_apart(phrase) for sections in languages for phrase in sections["stop"][part]]

        def section(name: str) -> list[str]:
            return [_apart(phrase) for sections in languages for phrase in sections[name]]

        anywhere, alone = any_of(stop("anywhere")), any_of(stop("anywhere") + stop("alone"))
        around = any_of(stop("interjections"))
        self._fillers = re.compile(any_of(stop("fillers")))
        self._anywhere = re.compile(rf"(?:{around} )*+{anywhere}(?: (?:{anywhere}|{around}))*+")
        self._alone = re.compile(rf"(?:{alone}|{around})(?: (?:{alone}|{around}))*+")
        self._any = re.compile(alone)
        self._leading = re.compile(rf"(?:{around} )*+{anywhere} {any_of(stop('joints'))}")
        self._emergency = re.compile(any_of(section("emergency")))
        self._release = re.compile(any_of(section("release")))
        self._end_task = re.compile(any_of(section("end_task")))

    def stops(self, text: str, *, ended: bool) -> bool:
        return any(self._stop_in(parts, ended=ended) for parts in self._readings(text))

    def only_stops(self, text: str) -> bool:
        return any(self._nothing_but_stop(parts) for parts in self._readings(text))

    def is_emergency(self, text: str) -> bool:
        return any(self._emergency.fullmatch(part) for parts in self._readings(text) for part in parts)

    def releases(self, text: str) -> bool:
        return any(self._release.fullmatch(" ".join(parts)) for parts in self._readings(text))

    def ends_task(self, text: str) -> bool:
        return any(self._end_task.fullmatch(" ".join(parts)) for parts in self._readings(text))

    def _stop_in(self, parts: Sequence[str], *, ended: bool) -> bool:
        if any(self._anywhere.fullmatch(part) for part in parts) or (ended and self._nothing_but_stop(parts)):
            return True
        return bool(parts) and self._leading.match(parts[0]) is not None

    def _nothing_but_stop(self, parts: Sequence[str]) -> bool:
        text = " ".join(parts)
        return self._alone.fullmatch(text) is not None and self._any.search(text) is not None

    def _readings(self, text: str) -> tuple[list[str], list[str]]:
        """The words between punctuation marks, as said, and without what is only politeness."""
        parts = self._parts(text)
        return parts, [bare for part in parts if (bare := without(self._fillers, part))]

    def _parts(self, text: str) -> list[str]:
        """The words between punctuation marks."""
        parts: list[list[Token]] = [[]]
        for token in words_of(_HAN_PAUSE.sub("，", text)).tokens:
            if token.kind == "mark":
                parts.append([])
            else:
                parts[-1].append(token)
        return [_apart(" ".join(token.text for token in part)) for part in parts if part]


def _apart(text: str) -> str:
    """``text`` with every Chinese character as a word of its own."""
    return " ".join(re.sub(rf"({_HAN})", r" \1 ", text).split())
