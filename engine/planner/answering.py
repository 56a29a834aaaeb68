"""Answers to a question of the robot: what the open command comes to with the answer in it.

``pending.py`` proposes sentences of both; here it is found which one is a command. What is a request by itself stays
one, unless it is the half of a command, or a mere place.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from typing import Final

from engine.errors import ExitCode
from engine.plan import Plan
from engine.planner.happened import last_question, open_command
from engine.planner.pending import chosen, completed
from engine.planner.phrases.phrases import Matched, NoMatch, PhrasePlanner, UnknownPlace
from engine.planner.refusal import refusal
from engine.planner.request import Language, NoPlan, PlanRequest
from engine.planner.text.language import language_of
from engine.planner.validation import Validation

A_NAME: Final = 3
"""Words of a mere place, with its article or a please."""
_HALVES: Final = frozenset({"place_object", "place_in_bin", "putdown", "say"})
"""What a command may begin with that was only the second half of one."""
_SPOT: Final = re.compile(r"\W*(?:in|into|on|onto|at|to|by|near|under|the|my|your|our)\b|\W*[在放到]", re.IGNORECASE)
"""How a place is named that is no journey's end yet."""


class Answering:
    """Puts answers into the commands that lack them."""

    def __init__(
        self, phrases: Callable[[Language], PhrasePlanner], validation: Validation, language: Language | None
    ) -> None:
        """``language`` is the one of all requests; None: that of each."""
        self._phrases = phrases
        self._validation = validation
        self._language = language

    def plan(self, request: PlanRequest, text: str, match: Matched | UnknownPlace | NoMatch) -> Plan | NoPlan | None:
        """The plan for a command that lacked something, with ``text`` in it, or the next question; None where none is
        open, or it is no answer. ``match`` is what ``text`` would mean by itself."""
        pending = open_command(request.happened)
        if not pending or not _may_answer(match, text):
            return None
        language = self._language or language_of(pending[0])
        command = pending[0]
        for answer in pending[1:]:
            command, _ = self._joined(command, answer, language) or (answer, None)
        question = last_question(request.happened)
        answer = (chosen(question, request.text, request.seen) if question is not None else "") or request.text
        joined = self._joined(command, answer, language)
        if joined is None:
            return None
        whole, meant = joined
        if isinstance(meant, Matched):
            found = self._validation.plan(whole, meant)
            return self._validation.one_of(found, replace(request, text=whole), language)
        # With a question of its own it is another command that lacks something.
        answers = isinstance(match, NoMatch) and not match.question
        if answers or (isinstance(match, Matched) and match.calls[0].name == "navigation"):
            return NoPlan(whole, "incomplete", meant.question, ExitCode.CLARIFY)
        return None

    def _joined(self, command: str, answer: str, language: Language) -> tuple[str, Matched | NoMatch] | None:
        """What a command means with an answer in it: a plan, else a command that still lacks something."""
        lacking: tuple[str, NoMatch] | None = None
        for text in completed(command, answer, language):
            match = self._phrases(language).plan(text)
            if isinstance(match, Matched) and match.kind == "plan" and refusal(text) is None:
                return text, match
            if isinstance(match, NoMatch) and match.question and lacking is None:
                lacking = text, match
        return lacking


def _may_answer(match: Matched | UnknownPlace | NoMatch, text: str) -> bool:
    """Whether words that mean this by themselves may yet be the answer to a question: "put it on the desk", "into the
    bin"."""
    if not isinstance(match, Matched):
        return True
    names = [call.name for call in match.calls]
    spot = names == ["navigation"] and (_SPOT.match(text) is not None or len(text.split()) <= A_NAME)
    return match.kind == "plan" and (names[0] in _HALVES or spot)
