"""An action of ROS 2 that moves the robot, such as a journey or a motion of the arm: what was sent to it must not go on
when nobody wants it to.

| it is | which means of the last goal | until |
|---|---|---|
| idle | there is none, or it has ended | another is sent |
| wanted | it is under way, and is to be; or it waits for what was asked before | it ends, or is given up |
| ending | it was given up, and has not said yet that it has ended | it says so; it is told again till then |
| astray | nobody knows: it was lost, its server is slow, or another host had sent it | it is called back |

To call back is to cancel all goals again and again until for ``QUIET_S`` there has been none. To give up is to cancel
all goals as well, also those of others: a robot that is told to stand, stands. So a new goal waits until the server has
answered the last of these requests, which else might cancel it, too.

Commands come in the host's thread and wait for nothing; how a goal fares comes in the door's. What is heard of a goal
before the last one changes nothing but that its end is known.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from engine.ros.actions.parts import ALL, CANCEL, cancel_request, cancel_service
from engine.ros.door import Door, Goal, Message, Outcome, Take, Then

AGAIN_S: Final = 0.2
"""Between two requests to cancel what may be under way."""
QUIET_S: Final = 1.0
"""For so long nothing must have been there to cancel: a goal may be taken late."""
FOUND_S: Final = 10.0
"""In which a door that was opened anew has found a server that is there: nodes take their time for that."""
STUBBORN_S: Final = 2.0
"""In which a goal has to end once it is told to."""


@dataclass(frozen=True, slots=True)
class _Order:
    goal: Message
    then: Then
    feedback: Take


class MovingAction:
    """One action server, and the last goal that it was sent."""

    def __init__(self, door: Door, action: str, type: str, clock: Callable[[], float], *, astray: bool = False) -> None:
        """``astray``: whoever had the robot before may have left a goal under way."""
        self._door, self._action, self._type, self._clock = door, action, type, clock
        self._sent = 0  # goals
        self._waits: _Order | None = None  # for the answer to what was asked
        self._wanted = False  # the last one
        self._goal: Goal | None = None
        self._open: set[int] = set()  # which of them have not ended
        self._given_up_at = -math.inf
        self._astray = astray
        self._asking = False
        self._asked_at = -math.inf
        self._first_asked_at: float | None = None  # since the door is open
        self._quiet_since: float | None = None  # nothing has been there to cancel

    @property
    def is_wanted(self) -> bool:
        return self._wanted or self._waits is not None

    @property
    def is_ending(self) -> bool:
        return bool(self._open) and not self._wanted

    @property
    def is_astray(self) -> bool:
        return self._astray

    @property
    def is_stubborn(self) -> bool:
        """It goes on although it was told to stop, for all that is known."""
        return self.is_ending and self._clock() - self._given_up_at > STUBBORN_S

    @property
    def may_move(self) -> bool:
        """It may move the robot, as far as anybody knows."""
        return bool(self._open) or self._astray or self._clock() - self._given_up_at < STUBBORN_S

    def send(self, goal: Message, then: Then, feedback: Take = lambda message: None) -> None:
        """Have this goal carried out, instead of whatever is; ``then`` hears how it ends, unless it is given up or
        another is sent."""
        self._waits = _Order(goal, then, feedback)
        self._send_what_waits()

    def give_up(self) -> bool:
        """Whether one was wanted; none is any more. Waits for nobody."""
        waited, self._waits = self._waits is not None, None
        wanted, self._wanted = self._wanted, False
        if wanted and self._goal is not None:
            self._given_up_at = self._clock()
            self._goal.cancel()
            self._ask()
        return wanted or waited

    def look_after(self) -> None:
        """Cancel again what has not ended, and call back what is astray; to be called now and then."""
        self._send_what_waits()
        if not self._astray and not self.is_ending:
            return
        if self._door.trouble:
            self._first_asked_at = None
        elif self._clock() - self._asked_at >= AGAIN_S:
            self._ask()

    def _send_what_waits(self) -> None:
        order = self._waits
        if order is None or self._asking:
            return
        self._sent += 1
        number = self._sent
        self._open.add(number)

        def ended(outcome: Outcome) -> None:
            self._ended(number, outcome, order.then)

        def told(message: Message) -> None:
            if number == self._sent:
                order.feedback(message)

        self._waits, self._wanted = None, True  # before it is sent: it may end at once
        self._goal = self._door.send_goal(self._action, self._type, order.goal, ended, feedback=told)

    def _ask(self) -> None:
        """Have all goals cancelled, unless that is being asked already."""
        if self._asking:
            return
        now = self._clock()
        self._asking, self._asked_at = True, now
        self._first_asked_at = now if self._first_asked_at is None else self._first_asked_at
        self._door.call(cancel_service(self._action), CANCEL, cancel_request(ALL), self._answered)

    # In the door's thread

    def _answered(self, outcome: Outcome) -> None:
        now, since = self._clock(), self._first_asked_at
        is_missing = outcome.code == "no_server" and since is not None and now - since > FOUND_S
        stands = outcome.code == "succeeded" and not outcome.result.get("return_code")
        if not stands or outcome.result.get("goals_canceling"):
            self._quiet_since = None  # a request that was taken, or refused, is no end
        elif self._quiet_since is None:
            self._quiet_since = now
        elif now - self._quiet_since >= QUIET_S:
            self._astray = False
        if is_missing:
            self._astray = False
        if not self._astray:
            self._first_asked_at = self._quiet_since = None
        self._asking = False

    def _ended(self, number: int, outcome: Outcome, then: Then) -> None:
        self._open.discard(number)
        if outcome.code in ("lost", "timed_out", "rejected"):  # a server that was slow may take it yet
            self._astray = True
        if number == self._sent and self._wanted:
            self._wanted = False
            if self._open:  # of those before it; their ends come in any order, so they get their time from now
                self._given_up_at = self._clock()
            then(outcome)
