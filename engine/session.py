"""The session: the state machine of a conversation, and the scopes of what can be cancelled.

A *session* is a row of *task cycles*, a cycle is a row of *turns* (see ``engine.turn``). One asyncio task,
:meth:`Session.run`, owns all state and takes requests one at a time; a turn runs in a task of its own, which is the
scope that an interruption cancels.

Interruptions take two steps. :meth:`Session.request` is called in the thread of whoever asks (the key handler, a
reader of the network) and advances the epoch there and then, which stops the robot before the call returns. The loop
then learns of it, ends the turn, and goes on as the kind of interruption says. A request that is overtaken by a newer
epoch before the loop sees it has no effect but an acknowledgement that says so.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections import deque
from collections.abc import Awaitable, Callable
from dataclasses import asdict, dataclass
from typing import Any

from config.schema import Session as SessionSettings
from engine import events
from engine.bus import Bus
from engine.commands import Audio, Command, EndTask, Interrupt, Quit, Say, Snapshot, Wake
from engine.epoch import Epoch
from engine.errors import ExitCode, RobotError, SaysoError
from engine.events import Scope, State, TurnResult
from engine.history import TaskCycle
from engine.planner.phrases import is_end_task, is_stop
from engine.robot.robot import ARM_INITIAL
from engine.turn import Needs, Turn

ARM_RETURN_SPEED = 0.5  # rad/s: after an interruption the arm goes home slowly, it may hold something


@dataclass(frozen=True, slots=True)
class Request:
    """A command, the epoch it was given in, and the interruption that it raised, if any."""

    command: Command
    epoch: int
    scope: Scope | None


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
        mark_wake: Callable[[], None] = lambda: None,
    ) -> None:
        self._settings = settings
        self._bus = bus
        self._epoch = epoch
        self._needs = needs
        self._hear_audio = hear_audio
        self._mark_wake = mark_wake
        self._loop = asyncio.get_running_loop()
        self._inbox: asyncio.Queue[Request] = asyncio.Queue()
        self._state: State = "IDLE"
        self._cycle = TaskCycle(1)
        self._turn: Turn | None = None
        self._waiting: deque[Request] = deque()  # what waits for the running turn to end

    @property
    def state(self) -> State:
        """Where the session is; safe to read from any thread."""
        return self._state

    def request(self, command: Command) -> None:
        """Ask for something. Thread-safe; when it returns, an interruption has already stopped the robot."""
        if isinstance(command, Wake):
            self._mark_wake()
        scope = self._scope_of(command)
        epoch = self._epoch.current if scope is None else self._epoch.advance()
        with contextlib.suppress(RuntimeError):  # the loop has ended: there is nothing left to ask, and it stands
            self._loop.call_soon_threadsafe(self._inbox.put_nowait, Request(command, epoch, scope))

    def _scope_of(self, command: Command) -> Scope | None:
        """The interruption that a command is: decided before any queue is involved, from the command alone."""
        match command:
            case Quit(drain):
                return None if drain else "shutdown"
            case EndTask():
                return "end_task"
            case Interrupt():
                return "interrupt"
            case Wake():
                return "wake"
            case Say(text) if is_stop(text):
                return "stop"
            case Say(text) if is_end_task(text):
                return "end_task"
            case Say() if self._settings.busy == "interrupt":
                return "replaced"
        return None

    async def run(self) -> None:
        """Take requests until :class:`Quit`. However it ends, the running turn is ended and on record first."""
        try:
            while True:
                request = await self._inbox.get()
                if isinstance(request.command, Quit) and not self._must_wait(request):
                    break
                await self._handle(request)
            await self._end_turn("shutdown", request, "The session ends.")
            self._ack(request, "The session ends.")
        finally:
            self._epoch.advance()
            if self._turn is not None:
                await self._cut(self._turn, "The session ended.")

    def _must_wait(self, request: Request) -> bool:
        """Whether ``request`` comes after the running turn; if so, it is kept until then."""
        match request.command:
            case Quit(drain=True) | Say() if self._turn is not None and request.scope is None:
                self._waiting.append(request)
                return True
        return False

    async def _handle(self, request: Request) -> None:
        if request.scope is not None and not self._epoch.is_current(request.epoch):
            self._ack(request, "A newer request replaced this one.", ok=False)
            return
        match request.command:
            case Snapshot():
                self._ack(request, snapshot=self._snapshot())
            case Audio(pcm):
                taken = self._hear_audio(pcm)
                self._ack(request, "" if taken else "Sound comes from elsewhere; try --source none.", ok=taken)
            case Interrupt():
                await self._end_turn("interrupt", request, "Interrupted.")
                self._ack(request)
            case Wake(source, phrase, angle_deg):
                self._bus.publish(events.WakeHeard(source, phrase, angle_deg), epoch=request.epoch)
                again = self._state == "LISTENING"
                await self._end_turn("wake", request, "Woken.")
                self._start(request, lambda turn: turn.listen(restarted=again))
            case Say(text):
                await self._say(request, text)
            case EndTask():
                await self._end_task(request)

    async def _say(self, request: Request, text: str) -> None:
        if request.scope == "end_task":
            await self._end_task(request)
        elif request.scope == "stop":
            await self._end_turn("stop", request, "Stopped.")
            self._start(request, lambda turn: turn.answer("Stopped.", ExitCode.DONE, "done"))
        elif self._turn is not None and self._settings.busy == "reject":
            self._ack(request, "Busy: the command was not taken (session.busy is reject).", ok=False)
        elif request.scope == "replaced" or not self._must_wait(request):
            await self._end_turn("replaced", request, "A newer command replaced this one.")
            self._start(request, lambda turn: turn.typed(text))

    async def _end_task(self, request: Request) -> None:
        await self._end_turn("end_task", request, "The task was ended.")
        self._ack(request)
        self._new_cycle("asked")
        self._enter("IDLE", "the task was ended", None, TurnResult(ExitCode.DONE, "done", "The task is ended."))

    def _new_cycle(self, reason: str) -> None:
        self._arm_home()
        self._bus.publish(events.TaskEnded(reason), epoch=self._epoch.current)
        self._cycle = TaskCycle(self._cycle.number + 1)

    def _start(self, request: Request, work: Callable[[Turn], Awaitable[TurnResult]]) -> None:
        turn = Turn(request.epoch, self._bus, self._needs, self._cycle, lambda s, why: self._enter(s, why, turn))
        self._turn = turn
        self._ack(request, turn=turn)
        turn.task = self._loop.create_task(self._run_turn(turn, work), name=f"turn {turn.id}")

    async def _run_turn(self, turn: Turn, work: Callable[[Turn], Awaitable[TurnResult]]) -> None:
        """Run one turn to its end, whatever that is; exactly one result comes of it."""
        limit = self._loop.call_later(self._settings.turn_limit_s, self._expire, turn)
        try:
            result = await work(turn)
        except asyncio.CancelledError:
            result = turn.cut or TurnResult(ExitCode.INTERRUPTED, "interrupted", "The session ended.")
        except SaysoError as error:
            turn.emit(events.ErrorRaised(error.code, error.message, error.hint))
            result = TurnResult(error.exit_code, "failed", str(error))
        except Exception as error:  # noqa: BLE001 - a fault in one turn must not take the session with it
            self._epoch.advance()
            message = f"A fault in sayso itself: {error!r}."
            turn.emit(events.ErrorRaised("internal", message, "Please report it with the session's log."))
            result = TurnResult(ExitCode.FAILED, "failed", message)
        finally:
            limit.cancel()
        if turn.ends_cycle:
            self._new_cycle("finished by the dialogue")
        self._turn = None
        if self._waiting:
            following = self._waiting.popleft()
            self._inbox.put_nowait(Request(following.command, self._epoch.current, None))
        self._enter("WAITING" if self._cycle.entries else "IDLE", result.outcome, turn, result)

    def _expire(self, turn: Turn) -> None:
        message = f"The time limit of {self._settings.turn_limit_s:g} s for one turn ran out."
        turn.cut = TurnResult(ExitCode.TIMEOUT, "timeout", message)
        self._epoch.advance()
        assert turn.task is not None
        turn.task.cancel()

    async def _end_turn(self, scope: Scope, request: Request, message: str) -> None:
        """Record an interruption and end the running turn; returns when its last outcome is on record."""
        turn = self._turn
        if turn is None and scope != "interrupt":
            return
        source = request.command.do
        raised = events.InterruptRaised(scope, source, self._state)
        self._bus.publish(raised, turn=turn.id if turn else None, epoch=request.epoch)
        self._drop_waiting()
        if turn is not None:
            await self._cut(turn, message)
            if scope == "wake":
                self._arm_home()

    def _drop_waiting(self) -> None:
        """An interruption concerns what waits, too; what was asked to end the session stays asked."""
        for request in tuple(self._waiting):
            if not isinstance(request.command, Quit):
                self._waiting.remove(request)
                self._ack(request, "Interrupted before it started.", ok=False)

    async def _cut(self, turn: Turn, message: str) -> None:
        assert turn.task is not None
        if turn.cut is None:
            turn.cut = TurnResult(ExitCode.INTERRUPTED, "interrupted", message)
        turn.task.cancel()
        await self._finished(turn)

    @staticmethod
    async def _finished(turn: Turn) -> None:
        assert turn.task is not None
        await asyncio.wait([turn.task])

    def _arm_home(self) -> None:
        """Send the arm slowly to its initial pose; whatever interrupts next holds it where it is."""
        if (robot := self._needs.robot.value) is not None:
            with contextlib.suppress(RobotError):  # its loss is reported by whoever watches the robot
                robot.move_arm(ARM_INITIAL, self._epoch.current, speed=ARM_RETURN_SPEED)

    def _enter(self, state: State, reason: str, turn: Turn | None, result: TurnResult | None = None) -> None:
        previous, self._state = self._state, state
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
        key: str | None = getattr(request.command, "id", None)
        ack = events.Ack(request.command.do, ok, message, key, snapshot)
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
        }
