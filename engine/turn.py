"""One turn: from a request to its answer. It listens, thinks, then acts and speaks, all in one epoch.

A turn only ever runs inside its task, which the session cancels to interrupt it. What had started by then is on record
before the cancellation goes on, and the turn never waits longer than a moment for work that does not want to end. A
turn whose epoch is over does nothing more: the interruption that ended the epoch is on its way to cancel it.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal, Protocol

from ulid import ULID

from engine import events
from engine.audio.endpoint import Utterance
from engine.bus import Bus, Emit
from engine.cancellation import Remains, bounded
from engine.dispatch import Dispatcher, Ran, Report, Run
from engine.epoch import Epoch
from engine.errors import ExitCode, SaysoError
from engine.events import Outcome, State, TurnResult
from engine.hearing import NothingHeard
from engine.history import Acted, Answered, NeverStarted, Said, TaskCycle
from engine.parts import Loading
from engine.plan import Plan
from engine.planner.planner import NoPlan, PlanRequest, Plans
from engine.robot.robot import Robot
from engine.skills.outcome import ErrorCode
from engine.tts.voice import Voice

TurnOutcome = Literal["done", "failed", "clarify", "refused", "interrupted", "timeout", "unheard"]

STAND_DOWN_S: Final = 1.0
"""How long a turn waits for the interruption that has overtaken it; it only has to cross a queue."""

_OUTCOMES: dict[ExitCode, TurnOutcome] = {ExitCode.CLARIFY: "clarify", ExitCode.REFUSED: "refused"}


class Listens(Protocol):
    """The ears, as a turn uses them; see ``engine.hearing.Hearing``."""

    @property
    def warnings(self) -> tuple[str, ...]: ...

    async def listen(self, emit: Emit, *, restarted: bool = False) -> Utterance | NothingHeard: ...

    async def transcribe(
        self, utterance: Utterance, emit: Emit
    ) -> events.TranscriptFinal | events.TranscriptRejected: ...

    def overhear(self, on: bool) -> None: ...


@dataclass(frozen=True, slots=True)
class Needs:
    """What turns work with. Parts load in the background; each is awaited where it is needed."""

    robot: Loading[Robot]
    planner: Loading[Plans]
    dispatcher: Callable[[Robot], Dispatcher]
    hearing: Loading[Listens]
    voice: Voice


class Overtaken(Exception):
    """The epoch is over, and nobody came to say why."""


class Turn:
    """The work of one request. ``enter`` tells the session which state the work has reached."""

    def __init__(
        self, number: int, epoch: Epoch, bus: Bus, needs: Needs, cycle: TaskCycle, enter: Callable[[State, str], None]
    ) -> None:
        """``number``: the epoch that the turn belongs to; it can be over already."""
        self.id = str(ULID())
        self.epoch = number
        self.emit = bus.bound(turn=self.id, epoch=number)
        self._bus = bus
        self.task: asyncio.Task[TurnResult] | None = None
        self.limit: asyncio.TimerHandle | None = None
        """Its time limit."""
        self.cut: TurnResult | None = None
        """Why the turn was cancelled; set before the cancellation."""
        self.cut_by: ErrorCode = "cancelled"
        """The same as the error code of the actions that it cuts."""
        self.ends_cycle = False
        """The dialogue was finished by this turn."""
        self.asked = ""
        """What it was asked to do, once that is known."""
        self._epoch = epoch
        self._needs = needs
        self._cycle = cycle
        self._enter = enter
        self._mouth = asyncio.Lock()
        self._thinking = False
        self._so_far = ""  # what had happened in the cycle when it was asked

    # Requests

    async def listen(self, *, restarted: bool) -> TurnResult:
        """Hear a request and act on it."""
        hearing = await self._needs.hearing.get()
        await self.stay_current()
        self._enter("LISTENING", "woken")
        utterance = await bounded(hearing.listen(self.emit, restarted=restarted))
        for warning in hearing.warnings:
            self.emit(events.Log("warning", "microphone", warning))
        if isinstance(utterance, NothingHeard):
            return TurnResult(ExitCode.FAILED, "unheard", utterance.message)
        await self.stay_current()
        self._enter("TRANSCRIBING", "the speaker has finished")
        transcript = await bounded(hearing.transcribe(utterance, self.emit))
        if isinstance(transcript, events.TranscriptRejected):
            return TurnResult(ExitCode.FAILED, "unheard", f"Not understood: {transcript.detail}")
        self._note(transcript.text)
        return await self.do()

    def take(self, text: str, source: Literal["text", "overheard"]) -> None:
        """What was typed or overheard: on record at once, before the turn's task has begun."""
        self.emit(
            events.TranscriptFinal(
                text=text, source=source, language="", confidence=float(source == "text"), avg_logprob=0.0,
                no_speech_probability=0.0, audio_s=0.0, decode_s=0.0,
            )
        )  # fmt: skip
        self._note(text)

    async def do(self) -> TurnResult:
        """Plan what was taken and do it."""
        plan = await self._think(self.asked, self._so_far)
        await self.stay_current()
        self.emit(plan.as_event())
        if isinstance(plan, NoPlan):
            return await self._answer(plan.answer, plan.exit_code, _OUTCOMES.get(plan.exit_code, "failed"))
        if not plan.actions:
            return await self._answer(plan.response, ExitCode.DONE, "done")
        return await self._act(plan)

    async def stopped(self) -> TurnResult:
        """Somebody said stop, and it stands: only say so."""
        return await self._answer("Stopped.", ExitCode.DONE, "done")

    def move_on(self, number: int) -> None:
        """Belong to another epoch from now on. Only for a turn that has not moved or said anything yet."""
        self.epoch = number
        self.emit = self._bus.bound(turn=self.id, epoch=number)

    async def stay_current(self) -> None:
        """Return while the turn's epoch lasts. After that, wait to be cancelled; raises :class:`Overtaken` when that
        does not happen."""
        if not self._epoch.is_current(self.epoch):
            await asyncio.sleep(STAND_DOWN_S)
            raise Overtaken

    def _note(self, text: str) -> None:
        self._so_far = self._cycle.as_text()
        self.asked = text
        self._cycle.entries.append(Said(self.id, text))

    # Thinking

    async def _think(self, text: str, so_far: str) -> Plan | NoPlan:
        planner = await self._needs.planner.get()
        await self.stay_current()
        request = PlanRequest(text, so_far, self._enter_stage)
        remains: Remains[Plan | NoPlan] = Remains(lambda found: self._drop(text, found))
        self._thinking = True
        try:
            return await bounded(planner.plan(request), remains)
        except asyncio.CancelledError:
            if remains.found is not None:
                self._drop(text, remains.found)
            raise
        finally:
            self._thinking = False

    def _enter_stage(self, stage: Literal["DECIDING", "PLANNING"]) -> None:
        if self._thinking and self.cut is None:  # else a planner that has been given up still thinks
            self._enter(stage, "a request was understood")

    def _drop(self, text: str, found: object) -> None:
        """A plan that came after its turn was over: for the record, and without any effect."""
        detail = f"It failed: {found}" if isinstance(found, BaseException) else "It was dropped."
        self.emit(events.PlanRejected(text, f"A plan came too late. {detail}", "late"))

    # Acting and speaking

    async def _act(self, plan: Plan) -> TurnResult:
        dispatcher = self._needs.dispatcher(await self._needs.robot.get())
        await self.stay_current()
        if self.limit is not None and dispatcher.is_endless(plan):
            self.limit.cancel()
        self._enter("ACTING", f"{len(plan.actions)} actions")
        report = await self._run(dispatcher, plan)
        await self.stay_current()
        if (question := report.question) is not None:
            self.emit(events.ClarificationAsked(question))
            return await self._answer(question, ExitCode.CLARIFY, "clarify")
        self._enter("FEEDBACK", "done" if report.ok else "not done")
        if report.message:
            await self._speak(report.message)
        if report.ok:
            return TurnResult(ExitCode.DONE, "done", report.message)
        lost = report.failure is not None and report.failure.result.error_code == "robot_lost"
        return TurnResult(ExitCode.MISSING if lost else ExitCode.FAILED, "failed", report.message)

    async def _run(self, dispatcher: Dispatcher, plan: Plan) -> Report:
        """Act and speak the response at the same time; what never started is on record however it ends."""
        run = Run(plan, self.epoch, self.emit, self._speak, self._record, cut_by=lambda: self.cut_by)
        try:
            async with asyncio.TaskGroup() as scope:
                if plan.response:
                    scope.create_task(self._speak(plan.response))
                acting = scope.create_task(dispatcher.run(run))
        finally:
            if never := run.report().never_started:
                self._cycle.entries.append(NeverStarted(self.id, never))
        return acting.result()

    def _record(self, ran: Ran) -> None:
        """An action has ended."""
        self.ends_cycle |= ran.action.name == "finish_dialogue" and ran.result.ok
        self._cycle.entries.append(Acted(self.id, ran))

    async def _answer(self, text: str, exit_code: ExitCode, outcome: TurnOutcome) -> TurnResult:
        """Say ``text`` and end the turn with it."""
        self._enter("CLARIFYING" if outcome == "clarify" else "SPEAKING", "answering")
        await self._speak(text)
        return TurnResult(exit_code, outcome, text)

    async def _speak(self, text: str) -> None:
        """Say one sentence at a time; what was heard of it is on record however it ends. A voice that fails is
        reported and ends nothing: the words are on the screen."""
        heard = ""
        outcome: Outcome = "interrupted"

        def hear(so_far: str) -> None:
            nonlocal heard
            heard = so_far

        async with self._mouth:
            if not self._epoch.is_current(self.epoch):
                return  # the work of a discarded generation has nothing to say
            self.emit(events.SpeechStarted(text, self._needs.voice.audible))
            try:
                await bounded(self._needs.voice.say(text, hear))
                outcome = "ok"
            except SaysoError as error:
                outcome = "failed"
                self.emit(events.ErrorRaised(error.code, error.message, error.hint))
            finally:
                self._cycle.entries.append(Answered(self.id, text, heard))
                self.emit(events.SpeechEnded(text, heard, outcome))
