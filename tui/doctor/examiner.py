"""Examines everything beside a running engine.

What the engine has open or has loaded is not opened or loaded a second time: it says how that is doing. No check is
waited for without end.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from queue import Empty, SimpleQueue
from typing import Final

from config.schema import Settings
from engine.handle import PartStatus
from tui.doctor.diagnosis import CHECKS
from tui.doctor.finding import Check, Finding

LIMIT_S: Final = 20.0
"""How long a check may take, s; what takes longer is told and left to itself."""


class Examiner:
    """Examines everything beside a running engine, again and again; for a thread that may wait."""

    def __init__(self, settings: Settings, *, checks: Sequence[Check] | None = None, limit_s: float = LIMIT_S) -> None:
        self._settings = settings
        self._checks = CHECKS if checks is None else checks
        self._limit_s = limit_s
        self._hanging: dict[str, threading.Thread] = {}

    def examine(
        self, parts: Sequence[PartStatus], begins: Callable[[str], object] = lambda name: None
    ) -> Iterator[Finding]:
        """What is found, in the order of the checks; ``parts`` are those of the engine, and ``begins`` is told what a
        check examines before it does."""
        states = {part.name: part for part in parts}
        for check in self._checks:
            begins(check.name)
            part = states.get(check.part) if check.part is not None else None
            if part is not None:
                yield _told(check, part)
            elif check.device:
                yield Finding(
                    check.name, "limited", "not looked at: the engine may have it open", "sayso doctor, without it"
                )
            else:
                yield self._looked(check)

    def _looked(self, check: Check) -> Finding:
        """The check within its time, in a thread that nobody waits for longer than that."""
        found: SimpleQueue[Finding] = SimpleQueue()

        def look() -> None:
            try:
                found.put(check.look(self._settings))
            except Exception as error:  # noqa: BLE001 - one check that has a fault must not take the others with it
                found.put(Finding(check.name, "limited", f"the check has a fault: {error!r}", "Please report it."))

        if (before := self._hanging.get(check.name)) is not None and before.is_alive():
            return Finding(check.name, "limited", "it still does not answer", "start sayso again")
        thread = threading.Thread(target=look, name=f"check {check.name}", daemon=True)
        thread.start()
        try:
            return found.get(timeout=self._limit_s)
        except Empty:
            self._hanging[check.name] = thread
            return Finding(check.name, "limited", f"no answer within {self._limit_s:g} s")


def _told(check: Check, part: PartStatus) -> Finding:
    """What the engine says of its part."""
    match part.state:
        case "ready":
            return Finding(check.name, "ok", part.detail or "ready")
        case "loading":
            return Finding(check.name, "limited", f"loading {part.detail}".rstrip())
        case _:
            return Finding(check.name, "missing", part.detail, needed=part.name in ("robot", "recogniser"))
