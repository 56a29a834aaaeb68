"""The session: who may do what when, in a conversation with a robot.

A *session* is a row of *task cycles*, a cycle is a row of *turns* (``engine.session.turn``); each is a task group, and
nothing outlives its scope. One asyncio task, :meth:`Session.run`, owns all state and takes what happens one thing at a
time: a request from outside, or the end of a turn. The states, and what each interruption does, are in
``engine.states``.

Interruptions take two steps. The first, in ``engine.session.inbox``, stops the robot in the thread of whoever asks.
Here is the second: the loop learns of it, ends the turn, and goes on as the kind of interruption says. A request that
is overtaken by a newer one before the loop sees it has no effect but an acknowledgement that says so.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
from collections.abc import Awaitable, Callable, Iterable
from dataclasses import asdict, dataclass
from typing import Any, Literal

from msgspec import structs, to_builtins

from config.schema import Session as SessionSettings
from engine import events
from engine.bus import Bus
from engine.commands import (
    COMMANDS,
    Added,
    Audio,
    Command,
    Drive,
    Drop,
    EndTask,
    EStop,
    Halted,
    Heard,
    Here,
    Interrupt,
    LimitSpeed,
    Move,
    Quit,
    Release,
    Say,
    SetVolume,
    Snapshot,
    Wake,
    Withdraw,
)
from engine.epoch import Epoch
from engine.errors import ExitCode, RobotError, SaysoError
from engine.events import Scope, State, TurnResult
from engine.plan import Plan
from engine.planner.about_itself import goes_on
from engine.planner.phrases.joints import comes_after
from engine.planner.request import NoPlan
from engine.planner.text.language import language_of
from engine.robot.geometry import Pose, Twist, wrap
from engine.robot.robot import EMERGENCY_STOP
from engine.session.by_hand import ByHand
from engine.session.history import Interrupted, TaskCycle, Withdrawn
from engine.session.inbox import Inbox, Request
from engine.session.turn import PRESSED, Needs, Overtaken, Turn, way_back
from engine.session.waiting import Waiting, seen
from engine.skills.outcome import ErrorCode
from engine.states import EFFECTS, EXPRESSING, NEXT, REST

ARM_RETURN_SPEED = 0.5  # rad/s: after an interruption the arm goes home slowly, it may hold something

FREE_S = 10.0
"""Without a request for so long, nobody is about to ask for the next."""


@dataclass(frozen=True, slots=True)
class Question:
    """What the robot wants to know: the turn that asked, and the words of the request that it is about."""

    turn: str
    about: str


@dataclass(frozen=True, slots=True)
class TurnOver:
    """A turn has ended by itself."""

    turn: Turn


class Session:
    """One conversation with one robot. Create it in the engine's loop, then ``await run()``.

    ``hear_audio`` takes sound that comes as commands and says whether it did; ``mark_wake`` is told of a wake in the
    thread it comes from, so that nothing said after it is lost.
    """

    def __init__(
        self,
        settings: SessionSettings,
        bus: Bus,
        epoch: Epoch,
        needs: Needs,
        *,
        hear_audio: Callable[[bytes], bool] = lambda pcm: False,
        mark_wake: Callable[[Wake], None] = lambda wake: None,
    ) -> None:
        self._settings = settings
        self._bus = bus
        self._epoch = epoch
        self._needs = needs
        self._hear_audio = hear_audio
        self._loop = asyncio.get_running_loop()
        self._by_hand = ByHand(needs.robot)
        self._inbox: Inbox[TurnOver] = Inbox(
            epoch, settings.busy, lambda: self._state, mark_wake, needs.press, self._asks
        )
        self._state: State = "IDLE"
        self._asked_at = self._loop.time()
        self._cycle = TaskCycle(1)
        self._turn: Turn | None = None
        self._turns: asyncio.TaskGroup | None = None  # of the present cycle
        self._waiting = Waiting(self._tell_waiting)
        self._offers = events.OffersMade()  # what has been offered
        self._begun: Request | None = None  # what the running turn was asked for in words
        self._postponed: Request | None = None  # what the next cycle begins with
        self._again = False  # the wake that is being handled came while listening…
        self._broke_off = False  # …or while the robot moved or spoke
        self._undone = ""  # the newest turn, if what it was asked for was not done
        self._asking = False  # the newest request ended with a question, and nobody has said anything since
        self._question: Question | None = None  # that is open, or whose answer is being planned
        self._about = ""  # the request that the question was about which the running turn has answered
        self._answer = ""  # the id of a request that came while a question was being put
        self._quit: Request | None = None

    @property
    def state(self) -> State:
        """Where the session is; safe to read from any thread."""
        return self._state

    def is_free(self) -> bool:
        """Whether nothing runs or waits, and nobody has asked for anything for ``FREE_S``, not even by hand."""
        asked = self._loop.time() - self._asked_at
        return self._turn is None and not self._waiting and self._state in REST and asked > FREE_S

    def _asks(self) -> bool:
        """Whether the running turn waits for an answer before it goes on."""
        turn = self._turn
        return turn is not None and turn.asks

    def request(self, command: Command) -> None:
        """Ask for something. Thread-safe; when it returns, an interruption has already stopped the robot. "And then …"
        interrupts nothing, and is no answer that goes before what waits."""
        asked = self._asks() or self._has_asked
        if isinstance(command, Say) and not asked and comes_after(command.text):
            command = structs.replace(command, wait=True)
        if not isinstance(command, Snapshot | Audio):
            self._asked_at = self._loop.time()
        self._inbox.request(command)

    # The loop

    async def run(self) -> None:
        """Go through task cycles until :class:`Quit`. However it ends, the running turn is ended and on record."""
        try:
            while self._quit is None:
                await self._run_cycle(self._cycle)
            self._drop_waiting("shutdown")  # what was asked for after it
            self._ack(self._quit, "The session ends.")
        except BaseExceptionGroup as group:
            raise group.exceptions[0] from None  # the scope of a cycle wraps what went wrong in it
        finally:
            self._epoch.advance()
            await self._by_hand.close()

    async def _run_cycle(self, cycle: TaskCycle) -> None:
        """Take what happens until the cycle ends. Leaving the scope ends the turn that still runs in it."""
        async with asyncio.TaskGroup() as self._turns:
            if (postponed := self._postponed) is not None:
                self._postponed = None
                self._carry_out(postponed)
            while self._cycle is cycle and self._quit is None:
                goes_on = self._turn is None and self._waiting and not self._holds
                if goes_on and self._inbox.is_empty():  # nobody has anything against it
                    self._carry_out(self._waiting.take())
                    continue
                match await self._inbox.get():
                    case TurnOver(turn):
                        if turn is self._turn:  # else it was interrupted in the moment in which it ended
                            self._close(turn)
                            if turn.ends_cycle:
                                self._arm_home()
                    case Request() as request:
                        stopped, request = request.since_its_stop()
                        admitted = await self._admit(request)
                        self._never_begun(stopped, request.scope)
                        if not admitted:
                            continue
                        first, *others = request.one_by_one()
                        self._waiting.add(others)
                        if self._cycle is cycle:
                            self._carry_out(first)
                        else:  # the turn that it interrupted had finished the dialogue
                            self._postponed = first

    async def _admit(self, request: Request) -> bool:
        """Let a request interrupt what it interrupts; whether it is to be carried out now."""
        command, scope = request.command, request.scope
        if self._inbox.is_overtaken(request):
            stopped = scope in ("interrupt", "release")  # which is all it was to do
            self._ack(request, "A newer request replaced this one.", ok=stopped)
            by = self._inbox.overtaken_by(request)
            for one in request.one_by_one():
                if by in (None, "replaced"):
                    self._end(one, "replaced")
                else:
                    self._end(one, "interrupted", by)
            return False
        if isinstance(command, Wake):
            self._bus.publish(events.WakeHeard(command.source, command.phrase, command.angle_deg), epoch=request.epoch)
            self._again, self._broke_off = self._state == "LISTENING", self._state in EXPRESSING
        if isinstance(command, Halted):
            await self._halt(request, command)
        elif scope is not None:
            await self._interrupt(scope, request)
        elif self._turn is not None and isinstance(command, Say) and self._turn.asks and not command.wait:
            answer, *others = request.one_by_one()
            self._turn.answer(command.text)
            self._ack(request)
            self._end(answer, "answer")
            self._waiting.add(others)
            return False
        elif self._turn is not None and isinstance(command, Say) and self._rejects(command):
            self._ack(request, "Busy: the command was not taken (session.busy is reject).", ok=False)
            for one in request.one_by_one():
                self._end(one, "rejected")
            return False
        elif self._has_asked and isinstance(command, Say) and not command.wait:  # it is the answer, and never queues
            if self._turn is None:
                return True
            answer, *others = request.one_by_one()
            self._answer = answer.id
            self._waiting.add([answer], first=True)
            self._waiting.add(others)
            return False
        elif self._has_to_wait(command):
            self._waiting.add(request.one_by_one())
            if isinstance(command, Added):
                self._log("info", f"After this: “{command.heard.text}”.")
            return False
        return True

    @property
    def _has_asked(self) -> bool:
        """Whether the robot asks what a request left open, or has, and nobody has said anything since."""
        turn = self._turn
        return self._state == "CLARIFYING" or (self._asking and (turn is None or not turn.asked))

    @property
    def _holds(self) -> bool:
        """Whether what waits has to wait for an answer; not where the session is to end, as nobody is left to give it.
        An answer that came before the question had been put waits itself."""
        ends = any(isinstance(request.command, Quit) for request in self._waiting)
        return self._asking and not ends and all(request.id != self._answer for request in self._waiting)

    def _has_to_wait(self, command: Command) -> bool:
        """Whether something runs or waits before it, or the robot waits for an answer that it is not."""
        if isinstance(command, Say | Quit | Added) and (self._turn is not None or self._waiting):
            return True
        return isinstance(command, Say) and command.wait and self._asking

    def _rejects(self, command: Say) -> bool:
        return self._settings.busy == "reject" and not command.wait

    def _tell_waiting(self, waiting: tuple[events.WaitingRequest, ...]) -> None:
        told = events.RequestsWaiting(tuple(one.text for one in waiting), waiting)
        self._bus.publish(told, epoch=self._epoch.current)

    def _carry_out(self, request: Request) -> None:
        """Do what a request asks for; nothing is running that it has to wait for."""
        match request.command:
            case Snapshot():
                self._ack(request, snapshot=self._snapshot())
            case Audio(pcm):
                taken = self._hear_audio(pcm)
                self._ack(request, "" if taken else "Sound comes from elsewhere; try --source none.", ok=taken)
            case Interrupt():
                self._ack(request)
            case Withdraw(id):
                self._withdraw(id)
            case Drop(id):
                self._drop(request, id)
            case Move(id, before):
                self._move(request, id, before)
            case EStop():
                self._ack(request, PRESSED)
            case Release():
                self._ack(request, "The emergency stop is released.")
            case Drive(vx, vy, wz) as drive:
                refused = self._by_hand.drive(Twist(vx, vy, wz), request.epoch)
                if refused or request.scope is not None or drive.id is not None:
                    self._ack(request, refused, ok=not refused)
            case Here() as here:
                refused = self._put(here)
                self._ack(request, refused or "The robot believes you.", ok=not refused)
            case LimitSpeed(share):
                refused = self._limit_speed(share)
                self._ack(request, refused or f"I drive at {100 * share:.0f}% of my speed at most.", ok=not refused)
            case SetVolume(volume):
                self._needs.set_volume(volume)
                self._ack(request)
            case Wake():
                again = self._again
                self._start(request, lambda turn: turn.listen(restarted=again)).broke_off = self._broke_off
            case Say(text) if request.scope in ("stop", "estop"):
                self._start(request, _told_stop(request.scope)).take(text, "text")
            case Heard(text) if request.scope in ("stop", "estop"):
                self._start(request, _told_stop(request.scope)).take(text, "overheard")
            case Say() | EndTask() if request.scope == "end_task":
                self._ack(request)
                self._end(request, "done")
                said = request.command.text if isinstance(request.command, Say) else self._cycle.last_said
                self._new_cycle("asked")
                self._arm_home(request.epoch)
                message = self._needs.wording.worded("The task is ended.", language_of(said))
                result = TurnResult(ExitCode.DONE, "done", message)
                self._enter("IDLE", "the task was ended", None, result)
            case Say(text):
                self._start(request, Turn.do).take(text, "text")
            case Added(adds=True, turn=first) if first == self._undone:
                self._leave(request)
            case Added(heard):
                self._start(request, Turn.do).hear(heard)
            case Quit():
                self._quit = request

    async def _halt(self, request: Request, halted: Halted) -> None:
        """The robot has stopped by itself. What moves or speaks is over; what only listens or thinks goes on, in the
        epoch in which the robot can move again."""
        if halted.reason == EMERGENCY_STOP and self._turn is None:
            return  # whoever pressed it knows
        message = halted.reason if halted.lost else f"I stopped by myself: {halted.reason}."
        code: ErrorCode = "robot_lost" if halted.lost else "robot_halted"
        turn = self._turn
        concerned = turn is not None and turn.epoch < request.epoch and self._state in EXPRESSING
        if not halted.lost:  # whoever lost it has said so
            said: events.Body = events.Log("warning", "robot", message)
            if concerned:
                said = events.ErrorRaised(code, message, "Say it again to go on.")
            self._bus.publish(said, epoch=request.epoch)
        if turn is None or turn.epoch >= request.epoch:
            return
        if concerned:
            exit_code = ExitCode.MISSING if halted.lost else ExitCode.FAILED
            await self._interrupt("halted", request, TurnResult(exit_code, "failed", message), code)
            return
        turn.move_on(self._inbox.epoch_for(turn.epoch))

    def _new_cycle(self, reason: str) -> None:
        self._bus.publish(events.TaskEnded(reason), epoch=self._epoch.current)
        self._cycle = TaskCycle(self._cycle.number + 1)
        self._asking, self._question = False, None
        self._offer()

    # Turns

    def _start(self, request: Request, work: Callable[[Turn], Awaitable[TurnResult]]) -> Turn:
        """Begin the next turn; its work begins when the caller lets the loop turn."""
        assert self._turn is None, "one turn at a time"
        assert self._turns is not None, "requests are handled within a cycle"

        def enter(state: State, reason: str) -> None:
            self._enter(state, reason, turn)
            if state == "CLARIFYING" and self._question is None and self._cycle.leaves_open(turn.id):
                self._question = Question(turn.id, self._about or turn.asked)

        def planned(found: Plan | NoPlan) -> None:
            self._question_met(found, answered=turn.answers)

        self._about = ""
        number = self._inbox.epoch_for(request.epoch)
        turn = Turn(number, self._epoch, self._bus, self._needs, self._cycle, enter, planned)
        self._turn = turn
        self._begun = request
        self._ack(request, turn=turn)
        turn.task = self._turns.create_task(self._run_turn(turn, work), name=f"turn {turn.id}")
        turn.task.add_done_callback(lambda task: self._inbox.put(TurnOver(turn)))
        return turn

    async def _run_turn(self, turn: Turn, work: Callable[[Turn], Awaitable[TurnResult]]) -> TurnResult:
        """Run one turn to its end, whatever that is; exactly one result comes of it."""
        turn.limit = limit = self._loop.call_later(self._settings.turn_limit_s, self._expire, turn)
        try:
            result = await work(turn)
            await turn.stay_current()
        except asyncio.CancelledError:
            return turn.cut or TurnResult(ExitCode.INTERRUPTED, "interrupted", EFFECTS["shutdown"].message)
        except Overtaken:
            return TurnResult(ExitCode.INTERRUPTED, "interrupted", EFFECTS["interrupt"].message)
        except SaysoError as error:
            message = f"{error.message} The robot has stopped what it was doing." if turn.broke_off else error.message
            turn.emit(events.ErrorRaised(error.code, message, error.hint))
            return TurnResult(error.exit_code, "failed", turn.worded(f"{message} {error.hint}".rstrip()))
        except Exception as error:  # noqa: BLE001 - a fault in one turn must not take the session with it
            self._epoch.advance()
            message = f"A fault in sayso itself: {error!r}."
            turn.emit(events.ErrorRaised("internal", message, "Please report it with the session's log."))
            return TurnResult(ExitCode.FAILED, "failed", turn.worded(message))
        finally:
            limit.cancel()
        return result

    def _expire(self, turn: Turn) -> None:
        message = f"The time limit of {self._settings.turn_limit_s:g} s for one turn ran out."
        self._epoch.advance()
        self._cancel(turn, TurnResult(ExitCode.TIMEOUT, "timeout", message), "time_limit")

    async def _interrupt(
        self, scope: Scope, request: Request, result: TurnResult | None = None, code: ErrorCode = "cancelled"
    ) -> None:
        """Record an interruption and end the running turn; returns when its last outcome is on record."""
        turn, state = self._turn, self._state
        if turn is not None or scope in ("interrupt", "estop", "release"):
            raised = events.InterruptRaised(scope, request.command.do, state)
            self._bus.publish(raised, turn=turn.id if turn else None, epoch=request.epoch)
        if scope in ("replaced", "wake") and self._has_asked:  # what comes is the answer
            self._waiting.move_on(request.epoch)
        else:
            self._drop_waiting(scope)
        if scope not in ("replaced", "wake"):  # else what comes may be the answer
            self._withdraw_question(scope)
        if turn is None:
            return
        if turn.asked:  # else nobody has said anything yet
            self._cycle.entries.append(Interrupted(turn.id, scope))
        self._cancel(turn, result or TurnResult(ExitCode.INTERRUPTED, "interrupted", EFFECTS[scope].message), code)
        assert turn.task is not None
        await asyncio.wait([turn.task])
        self._close(turn, scope)
        goes_on = isinstance(request.command, Wake) and request.command.source == "speech"  # nobody called
        if state in EFFECTS[scope].arm_home_from and not goes_on:
            self._arm_home()

    @staticmethod
    def _cancel(turn: Turn, result: TurnResult, code: ErrorCode) -> None:
        """Cancel once: a second cancellation would cut the first one's clean-up short."""
        assert turn.task is not None
        if turn.cut is None:
            turn.cut = TurnResult(result.exit_code, result.outcome, turn.worded(result.message))
            turn.cut_by = code
            turn.task.cancel()

    def _close(self, turn: Turn, scope: Scope | None = None) -> None:
        """The running turn has ended, by an interruption of this ``scope`` if any: say how."""
        assert turn.task is not None
        self._turn = None
        if turn.ends_cycle:
            self._new_cycle("finished by the dialogue")
        if turn.task.cancelled():  # before it had begun
            assert turn.cut is not None
            result = turn.cut
        else:
            result = turn.task.result()
        self._undone = turn.id if result.outcome != "done" else ""
        if turn.asked:
            self._asking = result.outcome == "clarify" and self._cycle.leaves_open(turn.id)
        self._enter("WAITING" if self._cycle.entries else "IDLE", result.outcome, turn, result)
        self._offer()
        self._leave_what_follows(self._undone)
        request, self._begun = self._begun, None
        if request is not None and request.text is not None:
            assert result.outcome != "unheard", "only who listens hears nothing"
            replaced = result.outcome == "interrupted" and scope == "replaced"
            self._end(request, "replaced" if replaced else result.outcome, scope, turn)

    # Questions

    def _question_met(self, found: Plan | NoPlan, *, answered: bool) -> None:
        """What was said while a question was open has come to this. A question that is put once more stays open."""
        if isinstance(found, NoPlan) and found.repeats:
            return
        question, self._question = self._question, None
        if question is None:
            return
        if answered:
            self._about = question.about
        if isinstance(found, NoPlan) and found.is_no_order:
            self._tell_question(question, "declined")
            return
        if isinstance(found, NoPlan):  # of an answer that fails, too, nothing came, and the question is not put again
            nothing = found.is_not_understood or (answered and found.exit_code is ExitCode.FAILED)
        else:
            nothing = not found.actions and not answered
        self._tell_question(question, "withdrawn" if nothing else "answered" if answered else "replaced")

    def _withdraw_question(self, scope: Scope) -> None:
        """An interruption concerns an open question, too: nothing that is said later is its answer."""
        question, self._question, self._asking = self._question, None, False
        if question is not None:
            self._cycle.entries.append(Withdrawn(question.turn))
            self._tell_question(question, "withdrawn", scope)

    def _tell_question(
        self,
        question: Question,
        outcome: Literal["answered", "declined", "replaced", "withdrawn"],
        scope: Scope | None = None,
    ) -> None:
        ended = events.QuestionEnded(question.about, outcome, scope)
        self._bus.publish(ended, turn=question.turn, epoch=self._epoch.current)

    # What waits

    def _never_begun(self, requests: Iterable[Request], scope: Scope | None) -> None:
        """A stop came with these, and behind them."""
        for request in requests:
            self._ack(request, "Interrupted before it started.", ok=False)
            self._end(request, "interrupted", scope)

    def _end(
        self, request: Request, outcome: events.RequestOutcome, scope: Scope | None = None, turn: Turn | None = None
    ) -> None:
        """The one end of a request in words; ``turn`` is what it became, if anything."""
        if (text := request.text) is not None:
            ended = events.RequestEnded(request.id, text, outcome, scope, request.sent_as)
            epoch = turn.epoch if turn else self._epoch.current
            self._bus.publish(ended, turn=turn.id if turn else None, epoch=epoch)

    def _drop_waiting(self, scope: Scope) -> None:
        """An interruption concerns what waits, too; what was asked to end the session stays asked."""
        dropped = [request for request in self._waiting if not isinstance(request.command, Quit)]
        if not dropped:
            return
        self._bus.publish(events.RequestsDropped(tuple(one.text for one in seen(dropped))), epoch=self._epoch.current)
        for request in dropped:
            self._ack(request, "Interrupted before it started.", ok=False)
            if isinstance(request.command, Added):
                self._warn_left(request.command)
            self._end(request, "replaced" if scope == "replaced" else "interrupted", scope)
        self._waiting.remove(dropped)

    def _withdraw(self, id: str) -> None:
        """Whoever asked for it has thought better of it."""
        for request in self._waiting:
            if isinstance(request.command, Say) and request.command.id == id:
                self._take_out(request, "Withdrawn before it started.")

    def _drop(self, request: Request, id: str) -> None:
        """Somebody does not want one of those that wait."""
        if (dropped := self._waits(request, id)) is not None:
            self._take_out(dropped, "Dropped before it started.")
            self._ack(request)

    def _take_out(self, request: Request, why: str) -> None:
        self._waiting.remove([request])
        self._ack(request, why, ok=False)
        self._end(request, "dropped")

    def _move(self, request: Request, id: str, before: str | None) -> None:
        """Somebody wants another order."""
        moved = self._waits(request, id)
        following = None if before is None or moved is None else self._waits(request, before)
        if moved is not None and (before is None or following is not None):
            self._waiting.move(moved, following)
            self._ack(request)

    def _waits(self, request: Request, id: str) -> Request | None:
        """The one of this id among those that wait; where there is none, ``request`` is told so."""
        if (found := self._waiting.find(id)) is None:
            self._ack(request, f"No request with the id {id!r} waits: it has begun, or ended, or never was.", ok=False)
        return found

    def _leave_what_follows(self, undone: str) -> None:
        """What waits to follow a turn that was not done is left, wherever it has been moved to."""
        left = [one for one in self._waiting if isinstance(one.command, Added) and one.command.turn == undone]
        self._waiting.remove(left)
        for request in left:
            self._leave(request)

    def _offer(self) -> None:
        """What may be asked about the past is another thing now, perhaps."""
        turn, _ = self._cycle.acted_last()
        record, back = self._cycle.on_record(), way_back(self._needs, self._cycle)
        stopped = record.stopped is not None and goes_on(record)
        offers = events.OffersMade(
            resume=turn if turn and stopped else None,
            undo=turn if turn and back.calls else None,
            again=self._cycle.planned_last() or None,
            acted=turn or None,
            no_undo=back.why_not if turn and not back.calls else "",
        )
        if offers != self._offers:
            self._offers = offers
            self._bus.publish(offers, epoch=self._epoch.current)

    def _leave(self, request: Request) -> None:
        """What it was to follow was not done."""
        assert isinstance(request.command, Added), "nothing else follows a turn"
        self._warn_left(request.command)
        self._end(request, "left")

    def _warn_left(self, added: Added) -> None:
        self._log("warning", f"“{added.heard.text}” is left: what it was to follow was not done.")

    def _log(self, level: Literal["info", "warning"], message: str) -> None:
        self._bus.publish(events.Log(level, "session", message), epoch=self._epoch.current)

    def _arm_home(self, epoch: int | None = None) -> None:
        """Send the arm slowly to its initial pose, unless ``epoch`` is over; whatever interrupts next holds it where it
        is."""
        if (robot := self._needs.robot.value) is not None:
            with contextlib.suppress(RobotError):  # its loss is reported by whoever watches the robot
                if robot.state().estop:
                    return
                robot.move_arm(robot.arm.rest, epoch or self._epoch.current, speed=ARM_RETURN_SPEED)

    def _put(self, here: Here) -> str:
        """Have the robot believe where it is; why not, in words."""
        robot = self._needs.robot.value
        if robot is None:
            return "The robot is not there yet."
        if self._turn is not None:
            return "Not while it does something: stop it first."
        if not (all(map(math.isfinite, (here.x, here.y, here.yaw or 0.0))) and robot.floor_map.holds(here.x, here.y)):
            return "That is not on the map."
        try:
            believed = robot.state().pose
            robot.relocate(believed, Pose(here.x, here.y, wrap(believed.yaw if here.yaw is None else here.yaw)))
        except RobotError as error:
            return error.message
        self._cycle.put_after, _ = self._cycle.acted_last()
        self._offer()
        return ""

    def _limit_speed(self, share: float) -> str:
        """Have the robot drive no faster; why not, in words."""
        if (robot := self._needs.robot.value) is None:
            return "The robot is not there yet."
        robot.limit_speed(share)
        return ""

    # What others see

    def _enter(self, state: State, reason: str, turn: Turn | None, result: TurnResult | None = None) -> None:
        assert state in NEXT[self._state], f"there is no way from {self._state} to {state}"
        previous, self._state = self._state, state
        if (hearing := self._needs.hearing.value) is not None:
            hearing.overhear(state in EXPRESSING)
        change = events.StateChanged(previous, state, reason, result)
        epoch = turn.epoch if turn else self._epoch.current
        self._bus.publish(change, turn=turn.id if turn else None, epoch=epoch)

    def _ack(
        self,
        request: Request,
        message: str = "",
        *,
        ok: bool = True,
        turn: Turn | None = None,
        snapshot: dict[str, Any] | None = None,
    ) -> None:
        if request.command.do not in COMMANDS:  # from a part of the engine, which waits for no answer
            return
        ack = events.Ack(request.command.do, ok, message, request.sent_as, snapshot)
        self._bus.publish(ack, turn=turn.id if turn else None, epoch=request.epoch)

    def _snapshot(self) -> dict[str, Any]:
        robot = self._needs.robot.value
        try:
            state = None if robot is None else asdict(robot.state())
        except RobotError as error:
            state = {"error": str(error)}
        return {
            "state": self._state,
            "epoch": self._epoch.current,
            "cycle": self._cycle.number,
            "history": self._cycle.as_json(),
            "robot": state,
            "offers": to_builtins(self._offers),
            "waiting": [request.text for request in self._waiting.seen],
            "requests": [to_builtins(request) for request in self._waiting.seen],
        }


def _told_stop(scope: Scope) -> Callable[[Turn], Awaitable[TurnResult]]:
    return (lambda turn: turn.stopped(PRESSED)) if scope == "estop" else Turn.stopped
