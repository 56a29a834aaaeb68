"""Tells on one line how requests ended: one after the other, each for some seconds, behind what runs by then; what was
done only where something else has the line. Those that ended alike, one right after the other, are told together. The
full console has a row for each.

While the emergency stop is pressed, the newest are told first, and then all of them in turn, again and again; once it
is released, they are told in their order, and what it refused in other words: those of the robot say that it is
pressed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from msgspec.structs import replace

from tui.words import strings

if TYPE_CHECKING:
    from textual.timer import Timer

    from tui.shown.facts import Ended, Line, Problem
    from tui.shown.model import ConsoleModel
    from tui.stage import Stage

TOLD_S: Final = 6.0
"""How long one end is told…"""
MORE_S: Final = 3.0
"""…and how long where another one is still to be told."""


class Ending:
    """Follows how requests end. In the UI thread."""

    def __init__(self, stage: Stage) -> None:
        self.told: tuple[Ended, ...] = ()
        """What is told now: ends that are alike."""
        self.outdated: tuple[Line | Problem, ...] = ()
        """What the model still has and was true only while the emergency stop was pressed."""
        self._stage = stage
        self._seen = 0  # the number of the newest end
        self._left: list[Ended] = []  # ends that are told now, and then those that are still to be told
        self._first = 0  # how many of them are told together now
        self._pressed = False  # the emergency stop is
        self._refused: list[Ended] = []  # requests that it refused or halted since it was pressed
        self._next: Timer | None = None
        self._timed: tuple[int, bool] = 0, False  # how many the timer is for, and whether more are to be told

    def look(self, model: ConsoleModel, *, pressed: bool, hidden: bool, cut: bool = False) -> None:
        """So things are now. ``pressed``: the emergency stop is; ``hidden``: something more urgent has the line;
        ``cut``: what stands before the ends may leave them no room. As long as one of the last two is so, the time of
        what is to be told does not run. What was done or answered while the emergency stop is pressed is told first."""
        new = [end for end in model.ends if end.number > self._seen]
        self._seen = new[-1].number if new else self._seen
        self._left = [*new, *self._left] if pressed else [*self._left, *new]
        if new and pressed:
            self._time((0, False))
        if pressed or self._pressed:
            self._refused += [end for end in new if end.halted]
        if self._pressed and not pressed:
            self._released(model)
        self._pressed = pressed
        if model.ended is not None:
            self._left = []
        if pressed:
            self._left.sort(key=lambda end: not end.done)
        alike = next((at for at, end in enumerate(self._left) if not end.is_like(self._left[0])), len(self._left))
        now, more = tuple(self._left[:alike]), len(self._left) > alike
        self.told = () if hidden or (not more and not pressed and _is_said_last(now, model)) else now
        self._first = 0 if hidden else len(now)
        waits = hidden or cut or (pressed and not more and not all(end.done for end in now))
        self._time((0, False) if waits else (len(now), more))

    def next(self) -> None:
        """What is told now has been told for long enough."""
        told, self._left = self._left[: self._first], self._left[self._first :]
        if self._pressed:
            self._left += [end for end in told if not end.done]
        self._timed = 0, False
        self._stage.redraw()

    def _released(self, model: ConsoleModel) -> None:
        """Nothing may say any more that the emergency stop is pressed."""
        self._left = [
            replace(end, message="", note=strings.WAS_PRESSED) if end in self._refused else end
            for end in sorted(self._left, key=lambda end: end.number)
        ]
        said = {end.message for end in self._refused}
        last, problem = model.conversation[-1] if model.conversation else None, model.problem
        outdated: list[Line | Problem] = []
        if last is not None and (last.note == "estop" or last.text in said or _tells_of_press(last, model)):
            outdated.append(last)
        if problem is not None and problem.message in said:
            outdated.append(problem)
        self.outdated, self._refused = tuple(outdated), []

    def _time(self, timed: tuple[int, bool]) -> None:
        if timed == self._timed:
            return
        self._timed = timed
        if self._next is not None:
            self._next.stop()
            self._next = None
        count, more = timed
        if count:
            self._next = self._stage.set_timer(MORE_S if more else TOLD_S, self.next)


def _is_said_last(ends: tuple[Ended, ...], model: ConsoleModel) -> bool:
    """Whether that is what the robot said last, which stands there in any case as long as nothing begins."""
    last = model.conversation[-1] if model.conversation else None
    said = last is not None and last.who == "robot" and all(end.done and end.message == last.text for end in ends)
    return said and not model.busy and not model.waiting


def _tells_of_press(last: Line, model: ConsoleModel) -> bool:
    """Whether this answers a request that has pressed the emergency stop: it says that it is pressed."""
    from engine.planner.phrases.stopping import is_emergency  # reads words that no console needs to begin

    return last.who in ("robot", "done") and bool(model.turns.kept) and is_emergency(model.turns.kept[-1].text)
