"""What comes to a session: the first of the two steps of an interruption, and the queue to the second.

:meth:`Inbox.request` is called in the thread of whoever asks: the key handler, a reader of the network, the recogniser.
It decides what the request interrupts, from the command alone, and advances the epoch there and then, which stops the
robot before the call returns. The session's loop takes the request from the queue later. Of several people who
interrupt at once only the newest counts; a robot that stopped by itself overtakes nobody.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Final, Generic, Literal, TypeVar

from msgspec import structs
from ulid import ULID

from engine.commands import Added, Command, Drive, EndTask, EStop, Halted, Heard, Interrupt, Quit, Release, Say, Wake
from engine.epoch import Epoch
from engine.events import Scope, State
from engine.planner.phrases.stopping import is_stop, scope_of
from engine.states import EXPRESSING, REST

T = TypeVar("T")
Busy = Literal["interrupt", "queue", "reject"]

KEPT: Final = 64
"""So many interruptions are known by what they were."""

KEPT_IDS: Final = 1000
"""So many of the newest ids that senders gave to their requests are known, so that none is given twice."""

STOPS: Final[frozenset[Scope | None]] = frozenset({"stop", "estop"})
"""What a request in words may interrupt whatever stands before it."""

LASTING: Final[frozenset[Scope]] = frozenset({"estop", "end_task", "halted", "shutdown"})
"""Interruptions that do more than end a turn: they take place even when a newer one has come in the meantime."""


@dataclass(frozen=True, slots=True)
class Request:
    """A command, the epoch it was given in, and the interruption that it raised, if any."""

    command: Command
    epoch: int
    scope: Scope | None
    id: str = field(default_factory=lambda: str(ULID()))
    """By which others call it while it waits."""

    @property
    def text(self) -> str | None:
        """What it asks for in words; None where it is not a request in words."""
        match self.command:
            case Say(text):
                return text
            case Added(heard):
                return heard.text
        return None

    @property
    def sent_as(self) -> str | None:
        """The id that its sender gave to the command."""
        return getattr(self.command, "id", None)

    def since_its_stop(self) -> tuple[tuple[Request, ...], Request]:
        """What stands before the last line that says stop, which stops all of that, and the request without it. What
        stands behind that line is asked for anew."""
        stops = [one.scope in STOPS for one in self.one_by_one()]
        if not isinstance(self.command, Say) or self.scope not in STOPS or not any(stops[1:]):
            return (), self
        at = len(stops) - 1 - stops[::-1].index(True)
        lines = (self.command.text, *self.command.then)
        said = Say(lines[at], self.command.id, lines[at + 1 :], requests=self.command.requests[at:])
        return tuple(self.one_by_one())[:at], replace(self, command=said, id=_id_of(said))

    def one_by_one(self) -> Iterator[Request]:
        """The same, with what is to be done after it as requests of their own. Those interrupt nothing: when it is
        their turn, nothing is running."""
        if not isinstance(self.command, Say) or not self.command.then:
            yield self
            return
        yield replace(self, command=Say(self.command.text, self.command.id))
        for at, text in enumerate(self.command.then, 1):
            yield Request(Say(text, self.command.id), self.epoch, scope_of(text), _id_of(self.command, at))


def _id_of(command: Command, at: int = 0) -> str:
    """The id that its sender gave to this one of its requests, or a new one."""
    given = command.requests[at : at + 1] if isinstance(command, Say) else ()
    return next(filter(None, given), None) or str(ULID())


def scope_said(command: Say, busy: Busy) -> Scope | None:
    """What a request in words interrupts, unless it is an answer. ``busy`` is what a new one does while one runs."""
    if (stop := _stop_in(command)) is not None:
        return stop
    return scope_of(command.text) or ("replaced" if busy == "interrupt" and not command.wait else None)


def _stop_in(command: Say) -> Scope | None:
    """The strongest stop among its lines: none of them waits for those before it."""
    found = {scope_of(line) for line in (command.text, *command.then)}
    return "estop" if "estop" in found else "stop" if "stop" in found else None


class Inbox(Generic[T]):
    """Requests from any thread, and news of type ``T`` from the loop itself, in one order. Made in the loop.

    ``busy`` is what a new command does while one runs; ``state`` tells where the session is; ``mark_wake`` is told of a
    wake at once, so that nothing said after it is lost; ``press`` presses the emergency stop, or releases it;
    ``is_asked`` tells whether the robot waits for an answer, which interrupts nothing.
    """

    def __init__(
        self,
        epoch: Epoch,
        busy: Busy,
        state: Callable[[], State],
        mark_wake: Callable[[Wake], None],
        press: Callable[[bool], None],
        is_asked: Callable[[], bool] = lambda: False,
    ) -> None:
        self._epoch = epoch
        self._busy = busy
        self._state = state
        self._mark_wake = mark_wake
        self._press = press
        self._is_asked = is_asked
        self._hand = 0  # the epoch in which somebody drives by hand
        self._loop = asyncio.get_running_loop()
        self._queue: asyncio.Queue[Request | T] = asyncio.Queue()
        self._order = threading.Lock()
        self._newest = epoch.current  # of the newest interruption by somebody, not by the robot itself
        self._raised: deque[tuple[int, Scope | None]] = deque(maxlen=KEPT)  # the newest ones and their epochs
        self._given: deque[str] = deque(maxlen=KEPT_IDS)  # ids of requests that were given by those who asked

    def request(self, command: Command) -> None:
        """Ask for something. Thread-safe; when it returns, an interruption has already stopped the robot."""
        with self._order:
            scope = self._scope_of(command)
            if isinstance(command, Say) and command.requests:
                command = self._with_new_ids(command)
            if scope == "estop":
                self._press(True)
            epoch = self._epoch.current if scope is None else self._epoch.advance()
            if isinstance(command, Release):  # in the order in which people pressed and released; and what was said
                self._press(False)  # meanwhile belongs to an epoch that is over
            if scope not in (None, "halted"):
                self._newest = epoch
                self._raised.append((epoch, scope))
            if isinstance(command, Drive):
                self._hand = epoch
            elif isinstance(command, Say | Added):
                self._hand = 0  # what it asks for is interrupted by the next one that drives
        if isinstance(command, Wake):
            self._mark_wake(command)
        with contextlib.suppress(RuntimeError):  # the loop has ended: there is nothing left to ask, and it stands
            self._loop.call_soon_threadsafe(self._queue.put_nowait, Request(command, epoch, scope, _id_of(command)))

    def _with_new_ids(self, command: Say) -> Say:
        """Without ids that were given before."""
        new: list[str] = []
        for id in command.requests[: 1 + len(command.then)]:
            new.append("" if id in self._given else id)
            self._given.append(id)
        return structs.replace(command, requests=tuple(new))

    def _scope_of(self, command: Command) -> Scope | None:
        match command:
            case Quit(drain):
                return None if drain else "shutdown"
            case EndTask():
                return "end_task"
            case EStop():
                return "estop"
            case Release():
                return "release"
            case Drive():
                return None if self._epoch.is_current(self._hand) and self._state() in REST else "by_hand"
            case Interrupt():
                return "interrupt"
            case Wake():
                return "wake"
            case Halted(lost=lost, epoch=epoch):
                return "halted" if lost or self._epoch.is_current(epoch) else None  # else it is over already
            case Added(adds=adds, epoch=epoch):
                return None if adds or epoch < self._newest else "replaced"
            case Heard(text):
                return scope_of(text) if self._state() in EXPRESSING and is_stop(text) else None
            case Say():
                scope = scope_said(command, self._busy)
                return None if scope == "replaced" and self._is_asked() else scope  # it is the answer
        return None

    # In the loop

    async def get(self) -> Request | T:
        """What came next."""
        return await self._queue.get()

    def is_empty(self) -> bool:
        """Whether nothing has come that was not taken yet."""
        return self._queue.empty()

    def put(self, news: T) -> None:
        """Add something that needs no other thread."""
        self._queue.put_nowait(news)

    def is_overtaken(self, request: Request) -> bool:
        """Whether somebody has interrupted since, so that the request is over before it began."""
        if isinstance(request.command, Added) and request.scope is None:
            return not request.command.adds or request.command.epoch < self._newest
        return request.scope is not None and request.scope not in LASTING and request.epoch < self._newest

    def overtaken_by(self, request: Request) -> Scope | None:
        """What was the first to interrupt since."""
        with self._order:
            return next((scope for epoch, scope in self._raised if epoch > request.epoch), None)

    def epoch_for(self, epoch: int) -> int:
        """The epoch in which work of ``epoch`` that has not moved anything yet may go on: the present one, unless
        somebody has interrupted since. Then it stays what it was, and is over."""
        with self._order:
            return self._epoch.current if epoch >= self._newest else epoch
