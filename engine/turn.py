"""One turn: from a request to its answer. Listening, thinking, acting and speaking, in that order, in one epoch.

A turn only ever runs inside its task, which the session cancels to interrupt it; what had started by then is on
record before the cancellation goes on.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from ulid import ULID

from engine import events
from engine.bus import Bus
from engine.dispatch import Dispatcher, Ran, Report
from engine.errors import ExitCode
from engine.events import Outcome, State, TurnResult
from engine.hearing import Hearing, NothingHeard
from engine.history import Answered, Done, Said, TaskCycle
from engine.parts import Part
from engine.plan import Plan
from engine.planner.planner import NoPlan, Planner
from engine.robot.robot import Robot
from engine.tts.voice import Voice

TurnOutcome = Literal["done", "failed", "clarify", "refused", "interrupted", "timeout", "unheard"]

_OUTCOMES: dict[ExitCode, TurnOutcome] = {ExitCode.CLARIFY: "clarify", ExitCode.REFUSED: "refused"}


@dataclass(frozen=True, slots=True)
class Needs:
    """What turns work with. Parts load in the background; each is awaited where it is needed."""

    robot: Part[Robot]
    planner: Part[Planner]
    dispatcher: Callable[[Robot], Dispatcher]
    hearing: Part[Hearing]
    voice: Voice


class Turn:
    """The work of one request. ``enter`` tells the session which state the work has reached."""

    def __init__(
        self, epoch: int, bus: Bus, needs: Needs, cycle: TaskCycle, enter: Callable[[State, str], None]
    ) -> None:
        self.id = str(ULID())
        self.epoch = epoch
        self.emit = bus.bound(turn=self.id, epoch=epoch)
        self.task: asyncio.Task[None] | None = None
        self.cut: TurnResult | None = None
        """Why the turn was cancelled; set before the cancellation."""
        self.ends_cycle = False
        """The dialogue was finished by this turn."""
        self._needs = needs
        self._cycle = cycle
        self._enter = enter

    async def listen(self, *, restarted: bool) -> TurnResult:
        """Hear a request and act on it."""
        hearing = await self._needs.hearing.get()
        self._enter("LISTENING", "woken")
        utterance = await hearing.listen(self.emit, restarted=restarted)
        for warning in hearing.warnings:
            self.emit(events.Log("warning", "microphone", warning))
        if isinstance(utterance, NothingHeard):
            return TurnResult(ExitCode.FAILED, "unheard", utterance.message)
        self._enter("TRANSCRIBING", "the speaker has finished")
        transcript = await hearing.transcribe(utterance, self.emit)
        if isinstance(transcript, events.TranscriptRejected):
            return TurnResult(ExitCode.FAILED, "unheard", f"Not understood: {transcript.detail}")
        return await self._act_on(transcript.text)

    async def typed(self, text: str) -> TurnResult:
        """Act on a typed request, as if it had been spoken and understood."""
        self.emit(
            events.TranscriptFinal(
                text=text, source="text", language="", confidence=1.0, avg_logprob=0.0,
                no_speech_probability=0.0, audio_s=0.0, decode_s=0.0,
            )
        )  # fmt: skip
        return await self._act_on(text)

    async def answer(self, text: str, exit_code: ExitCode, outcome: TurnOutcome) -> TurnResult:
        """Say ``text`` and end the turn with it."""
        self._enter("CLARIFYING" if outcome == "clarify" else "SPEAKING", "answering")
        await self._say(text)
        return TurnResult(exit_code, outcome, text)

    async def _act_on(self, text: str) -> TurnResult:
        self._cycle.entries.append(Said(self.id, text))
        self._enter("PLANNING", "a request was understood")
        planner = await self._needs.planner.get()
        plan = await planner.plan(text)
        if isinstance(plan, NoPlan):
            return await self._decline(plan)
        self.emit(plan.as_event())
        if not plan.actions:
            return await self.answer(plan.response, ExitCode.DONE, "done")
        return await self._act(plan)

    async def _decline(self, no: NoPlan) -> TurnResult:
        self.emit(no.as_event())
        return await self.answer(no.answer, no.exit_code, _OUTCOMES.get(no.exit_code, "failed"))

    async def _act(self, plan: Plan) -> TurnResult:
        dispatcher = self._needs.dispatcher(await self._needs.robot.get())
        self._enter("ACTING", f"{len(plan.actions)} actions")
        report = await self._run(dispatcher, plan)
        self._enter("FEEDBACK", "done" if report.ok else "not done")
        self.ends_cycle = any(ran.action.name == "finish_dialogue" and ran.result.ok for ran in report.ran)
        if report.message:
            await self._say(report.message)
        if report.ok:
            return TurnResult(ExitCode.DONE, "done", report.message)
        lost = report.failure is not None and report.failure.result.error_code == "robot_lost"
        return TurnResult(ExitCode.MISSING if lost else ExitCode.FAILED, "failed", report.message)

    async def _run(self, dispatcher: Dispatcher, plan: Plan) -> Report:
        """Act and speak the response at the same time; the history is written however it ends."""
        ran: list[Ran] = []
        try:
            async with asyncio.TaskGroup() as scope:
                if plan.response:
                    scope.create_task(self._say(plan.response))
                acting = scope.create_task(dispatcher.run(plan, self.epoch, self.emit, self._say, ran))
        finally:
            self._cycle.entries.append(Done(self.id, tuple(ran), plan.actions[len(ran) :]))
        return acting.result()

    async def _say(self, text: str) -> None:
        """Say a sentence; what was heard of it is on record however it ends."""
        self.emit(events.SpeechStarted(text, self._needs.voice.audible))
        heard = ""
        outcome: Outcome = "interrupted"
        try:
            heard = await self._needs.voice.say(text)
            outcome = "ok"
        finally:
            self.emit(events.SpeechEnded(text, heard, outcome))
            if heard:
                self._cycle.entries.append(Answered(self.id, heard))
