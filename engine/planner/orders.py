"""What is left to be done of a request that takes something back, forbids it, or only speaks about it.

``not_an_order.py`` finds the words because of which something is no order. Here it is decided what they leave: an order
behind a retraction, the order beside what is only denied, or nothing, and then the reason.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice
from typing import Final

from engine.errors import ExitCode
from engine.planner.not_an_order import last_clauses, marks, what_counts, without_contrast
from engine.planner.phrases.phrases import Matched, PhrasePlanner
from engine.planner.phrases.stopping import is_end_task, is_stop
from engine.planner.readings.corrections import corrected
from engine.planner.readings.first_look import CONDITION
from engine.planner.readings.narrative import only_tells
from engine.planner.request import Conditional, Language, NoPlan
from engine.planner.sentences import SAID

MAX_CORRECTIONS: Final = 40
"""Readings of one correction that are tried."""


class Orders:
    """Finds the order in such a request."""

    def __init__(
        self, phrases: Callable[[Language], PhrasePlanner], conditional: Callable[[str], Conditional | None]
    ) -> None:
        self._phrases = phrases
        self._conditional = conditional

    def left(self, text: str, language: Language) -> str | None:
        """The request that is left where a word takes back what was said before it; empty where that is nothing, and
        None where nothing was taken back, or only what is to be done otherwise ("… else don't bother")."""
        left = None if is_stop(text) or is_end_task(text) else what_counts(text)
        condition = self._conditional(text) if left == "" else None
        if left is None or (condition is not None and not marks(condition.then) and not marks(condition.before)):
            return None
        if left and not self._is_command(left, language):  # "turn left 90 degrees, scratch that, 45"
            whole = islice(corrected(text, language), MAX_CORRECTIONS)
            return next((meant for meant in whole if not marks(meant) and self._is_command(meant, language)), left)
        return left

    def beside_what_is_denied(self, text: str, language: Language) -> str:
        """The plain command beside what is only contrasted with it, or denied before it; empty where there is none."""
        parts = (*without_contrast(text), *last_clauses(text))
        return next((part for part in parts if self._is_command(part, language)), "")

    def why_none(self, text: str, language: Language, *, answers: bool) -> NoPlan | None:
        """What the robot says of a request that is no order; None where it may be one. ``answers``: it may be the
        answer to a question, or the user has written down what it means."""
        found = marks(text)
        tells = not found and not answers and CONDITION.search(text) is None and only_tells(text)
        if not found and not tells:
            return None
        first = next((mark for mark in found if mark.kind != "asked"), None)
        if first is None and not tells:
            return NoPlan(text, "asked", SAID[language]["asked"], ExitCode.CLARIFY)
        forbids = first is not None and first.kind != "told"
        words = first.words if first is not None else text
        told = SAID[language]["forbidden" if forbids else "told"].format(words=words)
        return NoPlan(text, "no_order", told, ExitCode.CLARIFY)

    def _is_command(self, text: str, language: Language) -> bool:
        return isinstance(self._phrases(language).plan(text), Matched)
