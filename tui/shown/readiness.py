"""Whether a request would be begun at once: which of the parts that it needs are still loading.

A request that comes early is not refused. The engine takes it down at once and waits for the planner, and with its plan
for the robot (``engine.parts.part``); the console says so, and does not look ready before it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from tui.words import strings

if TYPE_CHECKING:
    from engine.handle import PartName, PartStatus
    from tui.shown.model import ConsoleModel
    from tui.shown.view import View

NEEDED: Final[tuple[PartName, ...]] = ("robot", "planner")
"""What every request waits for; only a spoken one waits for the recogniser as well."""
HEARS: Final[tuple[PartName, ...]] = ("microphone", "recogniser")
"""Without one of these nobody is heard, and there is nothing to be woken for."""


def loading(parts: Sequence[PartStatus]) -> tuple[PartName, ...]:
    """The parts that a request waits for."""
    return tuple(part.name for part in parts if part.name in NEEDED and part.state == "loading")


def lost(parts: Sequence[PartStatus]) -> bool:
    """Whether one of them cannot be had: every request fails."""
    return any(part.name in NEEDED and part.state in ("failed", "missing") for part in parts)


def deaf(parts: Sequence[PartStatus]) -> PartName | None:
    """What is missing to hear somebody; None: nothing, or it is still loading."""
    return next((part.name for part in parts if part.name in HEARS and part.state in ("failed", "missing")), None)


def no_robot(view: View) -> str:
    """Why no robot is shown, for people: it is gone, or still starts."""
    return strings.ROBOT_GONE if _is_gone(view) else strings.NO_ROBOT


def no_map(view: View) -> str:
    """Why no map is shown, for people: there is no robot that has one, or it is still read."""
    return strings.ROBOT_GONE if _is_gone(view) else strings.NO_MAP


def _is_gone(view: View) -> bool:
    return view.failed or any(part.name == "robot" and part.state in ("failed", "missing") for part in view.parts)


def waited_for(model: ConsoleModel, parts: Sequence[PartStatus]) -> tuple[PartName, ...]:
    """What has to be loaded before the present request goes on, or the next one begins; empty while one is at work."""
    waits = loading(parts)
    stage = model.plan.stage if model.plan is not None else None
    if model.state in ("IDLE", "WAITING"):
        return waits
    if model.state in ("DECIDING", "PLANNING") and stage == "made":  # it is planned, and there is nobody to do it yet
        return tuple(name for name in waits if name == "robot")
    return ()


def named(parts: Sequence[PartName]) -> str:
    """Their names, for people."""
    return strings.AND.join(strings.PART_WORDS[name] for name in parts)
