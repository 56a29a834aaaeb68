"""Hesitation: what may have been a stop pauses the robot until somebody knows.

A spotter of words is quick and takes some other words for a stop; a recogniser is slow and hears better. So the spotter
pauses motion, in its own thread and in the moment in which it is sure, and the recogniser is asked. When it confirms,
its stop ends the pause as it ends everything else; when it does not, motion goes on, and that was a false pause, which
is counted and told. When it never answers, the robot halts by itself (``PAUSE_LIMIT_S``).

Of what the spotter is not sure, the recogniser is asked as well, while motion goes on; it pauses when the recogniser
has found that likely and looks once more. What only speaks is not paused, it is quieter meanwhile.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from engine.bus import Bus
from engine.clock import Clock
from engine.epoch import Epoch
from engine.events import MotionPaused, MotionResumed, State
from engine.robot.robot import PAUSE_LIMIT_S, Robot
from engine.states import EXPRESSING


class Ears(Protocol):
    """Who could confirm a stop; see ``engine.hearing.hearing.Hearing``."""

    @property
    def overhears(self) -> bool: ...

    def suspect(
        self, phrase: str, settled: Callable[[], None], likelier: Callable[[], None], *, sure: bool
    ) -> None: ...


@dataclass(frozen=True, slots=True)
class _Pause:
    token: int
    epoch: int
    began: float  # s of the clock


class Hesitation:
    """Made in the loop; only :meth:`suspect` may be called from other threads.

    ``state`` tells where the session is, and ``ears`` who can be asked, in any thread. ``duck`` makes speech quieter,
    or as loud as usual again, in any thread.
    """

    def __init__(
        self,
        robot: Robot,
        epoch: Epoch,
        bus: Bus,
        clock: Clock,
        *,
        state: Callable[[], State],
        ears: Callable[[], Ears | None],
        duck: Callable[[bool], None],
    ) -> None:
        self.false_pauses = 0
        """In this session."""
        self._robot = robot
        self._epoch = epoch
        self._bus = bus
        self._clock = clock
        self._state = state
        self._ears = ears
        self._duck = duck
        self._loop = asyncio.get_running_loop()
        self._changing = threading.Lock()
        self._pause: _Pause | None = None
        self._end: asyncio.TimerHandle | None = None

    def suspect(self, phrase: str, *, sure: bool) -> None:
        """Somebody may just have said ``phrase``. If that is ``sure`` and the robot acts, it is told to rest when this
        returns. Where nobody could confirm it nothing happens: a robot that halts at every other word is none."""
        state, ears = self._state(), self._ears()
        if state not in EXPRESSING or ears is None or not ears.overhears:
            return
        if sure:
            self._rest(state, phrase)
        with contextlib.suppress(RuntimeError):  # the loop has ended, and stopped the robot
            self._loop.call_soon_threadsafe(self._look_into, ears, phrase, sure)

    def _rest(self, state: State, phrase: str) -> None:
        if state == "ACTING" and self._begin():
            self._bus.publish(MotionPaused("word", phrase), epoch=self._epoch.current)
        self._duck(True)

    def _begin(self) -> bool:
        """Pause, unless it is paused already."""
        with self._changing:
            if self._pause is not None and self._epoch.is_current(self._pause.epoch):
                return False
            epoch = self._epoch.current
            self._pause = _Pause(self._robot.pause(epoch), epoch, self._clock.now())
            return True

    # In the loop

    def _look_into(self, ears: Ears, phrase: str, sure: bool) -> None:
        self._speak_up_later()
        ears.suspect(phrase, self._settle, lambda: self._doubt(phrase), sure=sure)

    def _doubt(self, phrase: str) -> None:
        """It is likelier by now that this was said: the robot rests until that is known."""
        if (state := self._state()) in EXPRESSING:
            self._rest(state, phrase)
            self._speak_up_later()

    def _speak_up_later(self) -> None:
        """If nothing comes before: the recogniser may never answer."""
        if self._end is not None:
            self._end.cancel()
        self._end = self._loop.call_later(PAUSE_LIMIT_S, self._speak_up)

    def _settle(self) -> None:
        """It is known whether that was a stop. If so, it has begun a new epoch by now."""
        self._speak_up()
        with self._changing:
            pause, self._pause = self._pause, None
        if pause is None or not self._epoch.is_current(pause.epoch):
            return
        self._robot.resume(pause.token)
        self.false_pauses += 1
        paused_s = round(self._clock.now() - pause.began, 3)
        self._bus.publish(MotionResumed("not_a_stop", paused_s, self.false_pauses), epoch=pause.epoch)

    def _speak_up(self) -> None:
        end, self._end = self._end, None
        if end is not None:
            end.cancel()
            if self._state() != "LISTENING":  # then it is quiet for another reason
                self._duck(False)
