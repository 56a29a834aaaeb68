"""One turn: from a request to its answer. It listens, thinks, then acts and speaks, all in one epoch.

A turn only ever runs inside its task, which the session cancels to interrupt it. What had started by then is on record
before the cancellation goes on, and the turn never waits longer than a moment for work that does not want to end. A
turn whose epoch is over does nothing more: the interruption that ended the epoch is on its way to cancel it.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final, Literal, Protocol

from ulid import ULID

from engine import events
from engine.audio.endpoint import Utterance
from engine.bus import Bus, Emit
from engine.cancellation import Remains, bounded
from engine.commands import Added
from engine.epoch import Epoch
from engine.errors import ExitCode, RobotError, SaysoError
from engine.events import Outcome, State, TurnResult
from engine.hearing.afterwards import More
from engine.hearing.hearing import NothingHeard
from engine.llm.chat import ChatError
from engine.parts.part import Loading
from engine.plan import Action, InWords, Plan, as_written
from engine.planner.intent import with_intent
from engine.planner.phrases.stopping import is_emergency, is_release, is_stop
from engine.planner.request import Happened, Language, NoPlan, PlanRequest, Plans
from engine.planner.text.language import language_of
from engine.robot.robot import Robot
from engine.session.around import Around
from engine.session.dispatch import Dispatcher, Report, Run
from engine.session.history import Acted, Answered, NeverStarted, Planned, Said, TaskCycle
from engine.session.ran import Ran
from engine.session.recall import Recall
from engine.session.way_back import WayBack
from engine.skills.outcome import ErrorCode
from engine.tts.voice import Voice
from engine.wording import Wording

TurnOutcome = Literal["done", "failed", "clarify", "refused", "interrupted", "timeout", "unheard"]

MOST_FAILURES: Final = 2
"""As often as this an action may fail in one request: once, and once more when it is tried again."""

ANSWER_S: Final = 10.0
"""Robot time in which somebody who was asked has to answer, s."""

STAND_DOWN_S: Final = 1.0
"""How long a turn waits for the interruption that has overtaken it; it only has to cross a queue."""

_OUTCOMES: dict[ExitCode, TurnOutcome] = {ExitCode.CLARIFY: "clarify", ExitCode.REFUSED: "refused"}


class Listens(Protocol):
    """The ears, as a turn uses them; see ``engine.hearing.hearing.Hearing``."""

    async def listen(self, emit: Emit, *, restarted: bool = False) -> Utterance | NothingHeard: ...

    async def transcribe(
        self, utterance: Utterance, emit: Emit, on_more: More
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
    """Answers what was said."""
    recall: Callable[[Robot], Recall]
    wording: Wording = field(default_factory=Wording)
    ask: Callable[[Added], None] = lambda command: None
    """Tells the session what was added to a request."""
    press: Callable[[bool], None] = lambda pressed: None
    """Presses the emergency stop, or releases it; from any thread."""
    set_volume: Callable[[float], None] = lambda volume: None
    """How loud the robot is from now on, 0…1."""
    voice_for_typed: Voice | None = None
    """Answers what was typed; None: the same one does."""
    place_names: Mapping[str, str] = field(default_factory=dict)
    """By their symbols."""
    rounds: int = 8
    """Plans that one request may lead to."""
    steps: int = 60
    """Actions that one request may lead to."""
    release_key: str = ""
    """Releases the emergency stop where the robot is asked; empty: no key does, but a command."""
    around: Callable[[], Around | None] = lambda: None
    """Those around the robot, who hear it and may answer."""
    told: Callable[[Action], InWords] = as_written
    """How people are told of an action."""


PRESSED: Final = "The emergency stop is pressed: nothing moves until it is released."


def _charge(robot: Robot) -> float | None:
    """About how much the battery holds, 0…1, where that is measured."""
    with contextlib.suppress(RobotError):  # its loss is told by whoever acts
        battery = robot.state().battery
        return battery.charge if battery is not None else None
    return None


def way_back(needs: Needs, cycle: TaskCycle) -> WayBack:
    """From what was done last in a task."""
    if (robot := needs.robot.value) is None:
        return WayBack(why_not="I cannot undo anything while my robot is away.")
    turn, acted = cycle.acted_last()
    return needs.dispatcher(robot).way_back(acted, relocated=bool(turn) and turn == cycle.put_after, told=needs.told)


class Overtaken(Exception):
    """The epoch is over, and nobody came to say why."""


class Turn:
    """The work of one request. ``enter`` tells the session which state the work has reached."""

    def __init__(
        self,
        number: int,
        epoch: Epoch,
        bus: Bus,
        needs: Needs,
        cycle: TaskCycle,
        enter: Callable[[State, str], None],
        planned: Callable[[Plan | NoPlan], None] = lambda found: None,
    ) -> None:
        """``number``: the epoch that the turn belongs to; it can be over already. ``planned`` is told what the request
        has come to, before anything of it begins."""
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
        self.broke_off = False
        """The turn began with stopping the robot. Its failure has to say so."""
        self.ends_cycle = False
        """The dialogue was finished by this turn."""
        self.asked = ""
        """What it was asked to do, once that is known."""
        self._epoch = epoch
        self._needs = needs
        self._cycle = cycle
        self.answers = False
        """What was said was taken for the answer to the question that was asked last."""
        self._enter = enter
        self._planned = planned
        self._mouth = asyncio.Lock()
        self._voice = needs.voice
        self._thinking = False
        self._stage: State | None = None  # that thinking has reached
        self._language: Language | None = None  # that was heard
        self._spoken = False
        self._so_far: tuple[Happened, ...] = ()  # what had happened in the cycle when it was asked
        self._asked_at = 0.0  # robot time, s
        self._failures: Counter[str] = Counter()
        self._waits: asyncio.Future[str] | None = None  # for an answer

    # Requests

    @property
    def asks(self) -> bool:
        """Whether it waits for an answer: what is typed now is that."""
        return self._waits is not None and not self._waits.done()

    def answer(self, text: str) -> None:
        """What it has asked for was typed."""
        if self._waits is not None and not self._waits.done():
            self._waits.set_result(text)

    async def listen(self, *, restarted: bool) -> TurnResult:
        """Hear a request and act on it."""
        hearing = await self._needs.hearing.get()
        await self.stay_current()
        self._enter("LISTENING", "woken")
        utterance = await bounded(hearing.listen(self.emit, restarted=restarted))
        if isinstance(utterance, NothingHeard):
            return TurnResult(ExitCode.FAILED, "unheard", self.worded(utterance.message))
        await self.stay_current()
        self._enter("TRANSCRIBING", "the speaker has finished")
        transcript = await bounded(hearing.transcribe(utterance, self.emit, self._more))
        if isinstance(transcript, events.TranscriptRejected):
            return TurnResult(ExitCode.FAILED, "unheard", self.worded(f"Not understood: {transcript.detail}"))
        self._take_in(transcript)
        if is_emergency(self.asked):  # it stands since the wake
            self._needs.press(True)
            self._enter("PLANNING", "the emergency stop")
            return await self.stopped(PRESSED)
        return await self.do()

    def hear(self, heard: events.TranscriptFinal) -> None:
        """What was said before the turn began: on record at once."""
        self.emit(heard)
        self._take_in(heard)

    def take(self, text: str, source: Literal["text", "overheard"]) -> None:
        """What was typed or overheard: on record at once, before the turn's task has begun."""
        text = text.encode(errors="replace").decode()  # a terminal can send half a character, and no model takes one
        if source == "text":
            self._voice = self._needs.voice_for_typed or self._voice
        self.emit(
            events.TranscriptFinal(
                text=text, source=source, language="", confidence=float(source == "text"), avg_logprob=0.0,
                no_speech_probability=0.0, audio_s=0.0, decode_s=0.0,
            )
        )  # fmt: skip
        self._note(text)

    async def do(self) -> TurnResult:
        """Plan what was taken and do it; think over what became of it, and go on, until nothing is left to be done."""
        found = self._about_release() or await self._think(self.asked, self._so_far)
        await self.stay_current()
        self._planned(found)
        steps = 0
        for rounds in range(1, self._needs.rounds + 1):
            await self.stay_current()
            if isinstance(found, NoPlan):
                found = replace(found, answer=self.worded(found.answer))
            self.emit(with_intent(found, self._needs.place_names))
            self._cycle.entries.append(Planned(self.id, found))
            if isinstance(found, NoPlan):
                return await self._answer(found.answer, found.exit_code, _OUTCOMES.get(found.exit_code, "failed"))
            if not found.actions:
                return await self._answer(found.response, *self._how_it_went())
            steps += len(found.actions)
            if steps > self._needs.steps:
                text = f"That would be {steps} actions by now; one request leads to {self._needs.steps} at most."
                return await self._answer(text, ExitCode.FAILED, "failed")
            result, again = await self._act(found)
            if not again:
                return result
            if rounds < self._needs.rounds:
                reconsidered = await self._reconsider(result)
                if isinstance(reconsidered, TurnResult):
                    return reconsidered
                found = reconsidered
        text = f"After {self._needs.rounds} plans I gave up: {result.message}".rstrip()
        return await self._answer(text, ExitCode.FAILED, "failed")

    async def stopped(self, told: str = "Stopped.") -> TurnResult:
        """Somebody said stop, and it stands: only say so."""
        return await self._answer(told, ExitCode.DONE, "done")

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

    def worded(self, text: str, language: Language | None = None) -> str:
        """A sentence of ours in a language: if none is named, that of the request; before there is one, of the last."""
        own = self._language or language_of(self.asked or self._cycle.last_said)
        return self._needs.wording.worded(text, language or own)

    def _more(self, heard: events.TranscriptFinal, adds: bool) -> None:
        """Somebody goes on who had made a complete request."""
        self._needs.ask(Added(heard, adds, self.id, self.epoch))

    def _take_in(self, heard: events.TranscriptFinal) -> None:
        self._note(heard.text)
        self._spoken = True
        self._language = "zh" if heard.language == "zh" else None  # else the text itself shows it

    def _note(self, text: str) -> None:
        self._so_far = self._cycle.happened()
        self.asked = text
        self._cycle.entries.append(Said(self.id, text))

    def _about_release(self) -> Plan | NoPlan | None:
        """The answer to somebody who asks in words to release the emergency stop: words may be misheard, repeated or
        come from a program, and so they never do. None for all other requests."""
        if not is_release(self.asked):
            return None
        with contextlib.suppress(RobotError):  # whether it is pressed is not known then
            if (robot := self._needs.robot.value) is not None and not robot.state().estop:
                return Plan(self.asked, (), "The emergency stop is not pressed.", "phrases")
        text = "No words release the emergency stop; `sayso robot release` does."
        if key := self._needs.release_key:
            text = f"No words release the emergency stop; the key {key} does."
        return NoPlan(self.asked, "release_in_words", text, ExitCode.REFUSED)

    # Thinking

    async def _think(self, text: str, so_far: tuple[Happened, ...]) -> Plan | NoPlan:
        """Plan ``text``, or what is to follow after feedback."""
        planner = await self._needs.planner.get()
        await self.stay_current()
        request = PlanRequest(
            text,
            so_far,
            cycle=self._cycle.name,
            language=self._language,
            spoken=self._spoken,
            on_record=self._cycle.on_record(),
            spent=frozenset(action for action, failures in self._failures.items() if failures >= MOST_FAILURES),
            enter=self._enter_stage,
            answers=self._answer_taken,
            decide=lambda steps, source: self._thought(events.DecisionMade(steps, source)),
            warn=lambda message: self._thought(events.Log("warning", "planner", message)),
            read=lambda meaning: self._thought(meaning),
            record=lambda call: self.emit(call),  # whenever it comes: what was sent is on record
        )
        if (robot := self._needs.robot.value) is not None:
            recall = self._needs.recall(robot)
            back = way_back(self._needs, self._cycle)
            record = replace(request.on_record, charge=_charge(robot), back=back.calls, no_way_back=back.why_not)
            request = replace(request, on_record=record)
            if text:
                self._asked_at = recall.now()
            picture = await recall.picture() if not text and self._looked() else None
            request = replace(request, picture=picture)
            request = replace(request, holding=recall.holding(), seen=recall.seen(), sees=recall.since(self._asked_at))
            request = replace(request, people=recall.people(), may_be_at=recall.where_since(self._asked_at))
        remains: Remains[Plan | NoPlan] = Remains(lambda found: self._drop(text, found))
        self._thinking, self._stage = True, None
        try:
            found = await bounded(planner.plan(request), remains)
            self._enter_stage("PLANNING")  # if that took no time
            return found
        except asyncio.CancelledError:
            if remains.found is not None:
                self._drop(text, remains.found)
            raise
        finally:
            self._thinking = False

    async def _reconsider(self, result: TurnResult) -> Plan | NoPlan | TurnResult:
        """What is to follow, now that a plan has come to its end; how the turn ends where nobody can say."""
        try:
            found = await self._think("", self._cycle.happened())
        except ChatError as error:
            found = NoPlan(self.asked, error.code, str(error), error.exit_code)
        if not isinstance(found, NoPlan) or not found.nothing_new:
            return found
        if not found.answer:
            return result
        self.emit(events.ErrorRaised(found.code, found.answer))
        if result.exit_code != ExitCode.DONE:
            return result
        return await self._answer(f"I cannot tell whether that was all. {found.answer}", found.exit_code, "failed")

    def _looked(self) -> bool:
        """Whether the newest thing that was done in this turn is a look, of which there is a picture."""
        done = next((entry for entry in reversed(self._cycle.entries) if isinstance(entry, Acted)), None)
        if done is None or done.turn != self.id:
            return False
        return done.ran.action.name == "seewhat" and done.ran.result.ok

    def _answer_taken(self) -> None:
        self.answers = True

    def _thought(self, body: events.Body) -> None:
        if self._thinking and self.cut is None:
            self.emit(body)

    def _enter_stage(self, stage: Literal["DECIDING", "PLANNING"]) -> None:
        if self._thinking and self.cut is None and stage != self._stage:  # one that has been given up still thinks
            self._stage = stage
            self._enter(stage, "a request was understood")

    def _drop(self, text: str, found: object) -> None:
        """A plan that came after its turn was over: for the record, and without any effect."""
        detail = f"It failed: {found}" if isinstance(found, BaseException) else "It was dropped."
        self.emit(events.PlanRejected(text, f"A plan came too late. {detail}", "late"))

    # Acting and speaking

    async def _act(self, plan: Plan) -> tuple[TurnResult, bool]:
        """Do it; how it ended, and whether that is to be thought over."""
        dispatcher = self._needs.dispatcher(await self._needs.robot.get())
        await self.stay_current()
        if self.limit is not None and dispatcher.is_endless(plan):
            self.limit.cancel()
        self._enter("ACTING", f"{len(plan.actions)} actions")
        report = await self._run(dispatcher, plan)
        await self.stay_current()
        if (question := report.question) is not None:
            self.emit(events.ClarificationAsked(question))
            return await self._answer(question, ExitCode.CLARIFY, "clarify"), False
        self._enter("FEEDBACK", "done" if report.ok else "not done")
        if message := self.worded(report.message):
            await self._speak(message)
        if report.ok:
            return TurnResult(ExitCode.DONE, "done", message), not plan.finished
        assert report.failure is not None, "whatever ends a plan early has failed"
        self._failures[str(report.failure.action)] += 1
        lost = report.failure.result.error_code == "robot_lost"
        result = TurnResult(ExitCode.MISSING if lost else ExitCode.FAILED, "failed", message)
        return result, not lost and plan.is_worth_thinking_over(report.failure.result.error_code)

    def _how_it_went(self) -> tuple[ExitCode, TurnOutcome]:
        """How a turn ends that has nothing more to do: it failed where its last action did."""
        ran = next((e.ran for e in reversed(self._cycle.entries) if isinstance(e, Acted) and e.turn == self.id), None)
        return (ExitCode.DONE, "done") if ran is None or ran.result.ok else (ExitCode.FAILED, "failed")

    async def _run(self, dispatcher: Dispatcher, plan: Plan) -> Report:
        """Act and speak the response at the same time; what never started is on record however it ends."""
        run = Run(plan, self.epoch, self.emit, self._speak, self._record, lambda: self.cut_by, self._ask, self.worded)
        run.told = self._needs.told
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
        text = self.worded(text)
        await self._speak(text)
        return TurnResult(exit_code, outcome, text)

    async def _ask(self, question: str, limit_s: float = ANSWER_S) -> str | None:
        """Say a question and wait for its answer: what is typed, what is heard where the request was spoken, or what
        somebody of a simulation says. A stop is no answer."""
        robot, around = await self._needs.robot.get(), self._needs.around()
        self._waits = asyncio.get_running_loop().create_future()
        listening: asyncio.Task[str] | None = None
        answer, source = "", "nobody"
        try:
            if around is not None:
                around.forget()
            await self._speak(question)
            self.emit(events.PersonAsked(question))
            listening = asyncio.create_task(self._listen_for_answer())
            state = robot.state()
            end = state.work_t + limit_s
            while not answer and state.work_t < end:
                if self._waits.done():
                    answer, source = self._waits.result(), "typed"
                elif listening.done():
                    answer, source = listening.result(), "heard"
                    break
                elif around is not None and (said := around.answered()):
                    answer, source = said, "company"
                else:
                    state = await robot.tick()
        finally:
            self._waits = None
            if listening is not None and not listening.done():
                listening.cancel()
                await asyncio.wait([listening])
        if is_stop(answer) or is_emergency(answer):
            answer = ""
        self.emit(events.PersonAnswered(question, answer, source if answer else "nobody"))  # type: ignore[arg-type]
        return answer or None

    async def _listen_for_answer(self) -> str:
        """What is said next, where this request was spoken; ends when somebody has said something."""
        hearing = self._needs.hearing.value
        with contextlib.suppress(SaysoError):  # the microphone is gone: what is typed is an answer, too
            while hearing is not None and self._spoken:
                utterance = await hearing.listen(self.emit)
                if isinstance(utterance, NothingHeard):
                    continue
                heard = await hearing.transcribe(utterance, self.emit, lambda more, adds: None)
                if isinstance(heard, events.TranscriptFinal):
                    return heard.text
        await asyncio.get_running_loop().create_future()  # nobody is heard
        raise AssertionError("nobody ends that")

    async def _speak(self, text: str) -> None:
        """Say one sentence at a time; what was heard of it is on record however it ends. A voice that fails is
        reported and ends nothing: the words are on the screen."""
        heard = ""
        outcome: Outcome = "interrupted"

        def hear(so_far: str) -> None:
            nonlocal heard
            heard = so_far

        async with self._mouth:
            saying = self._voice.say(text, hear)  # whoever stops from here on silences it, however late we learn of it
            if not self._epoch.is_current(self.epoch):
                saying.close()
                return  # the work of a discarded generation has nothing to say
            self.emit(events.SpeechStarted(text, self._voice.audible))
            if (around := self._needs.around()) is not None:
                around.tell(text)
            try:
                await bounded(saying)
                outcome = "ok"
            except SaysoError as error:
                outcome = "failed"
                self.emit(events.ErrorRaised(error.code, error.message, error.hint))
            finally:
                self._cycle.entries.append(Answered(self.id, text, heard))
                self.emit(events.SpeechEnded(text, heard, outcome))
