"""Tells a person when the engine or the robot is away, and when it is back.

The engine beats about twenty times a second; the console feels its pulse twice a second. That the robot stands
meanwhile is not the console's doing: it halts by itself when its engine is silent.
"""

from __future__ import annotations

from typing import Final, Literal

from msgspec.structs import replace

from tui.shown.facts import Line, Problem
from tui.shown.model import ConsoleModel
from tui.words import strings

INTERVAL_S: Final = 0.5
"""How often the pulse is felt."""
SILENT_S: Final = 1.5
"""An engine whose pulse has been away for so long does not answer."""


class Watchdog:
    """Says when an engine falls silent and when it is back. Time is passed in, in seconds."""

    def __init__(self, now: float) -> None:
        self._looked = now
        self._silent = False

    def look(self, now: float, pulse: float) -> Literal["silent", "back"] | None:
        """What has changed since the last look; ``pulse`` is how long ago the engine showed that it lives."""
        away, self._looked = now - self._looked, now
        silent = pulse > SILENT_S
        if away > 2 * INTERVAL_S or silent == self._silent:  # paused ourselves: the engine gets a moment, too
            return None
        self._silent = silent
        return "silent" if silent else "back"


def engine_is_silent(model: ConsoleModel, *, stop: str, leave: str, t: float | None = None) -> ConsoleModel:
    """Say that the engine does not answer; ``stop`` and ``leave`` are the keys that work all the same.
    It is noticed at event time ``t``, or with the newest event."""
    model = model.with_log("error", "console", strings.ENGINE_SILENT, t=t)
    if model.problem is not None and model.problem.fatal:
        return model
    hint = strings.HINT_SILENT.format(stop=stop, leave=leave)
    return replace(model, problem=Problem(strings.ABOUT_SILENT, hint, strings.ENGINE_SILENT, code="engine_silent"))


def engine_is_back(model: ConsoleModel) -> ConsoleModel:
    """The engine says itself for how long it was away."""
    return _without(model, "engine_silent")


def robot_is_back(model: ConsoleModel) -> ConsoleModel:
    """A robot that was lost is ready again."""
    cleared = _without(model, "robot_lost")
    return model if cleared is model else cleared.with_line(Line("mark", strings.ROBOT_BACK))


def _without(model: ConsoleModel, code: str) -> ConsoleModel:
    problem = model.problem
    if problem is None or problem.fatal or problem.code != code:
        return model
    return replace(model, problem=None)
