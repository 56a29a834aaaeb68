"""Driving by hand: a line that says how, in the place of the line to type in, and has the keyboard while it is there.

A terminal tells only that a key was pressed, and tells it again and again while it is held down. Each time the robot is
told to drive for a fifth of a second; a key that was let go sends no more, and the robot stands.
"""

from __future__ import annotations

from typing import Any

from textual import events
from textual.message import Message
from textual.widgets import Static

from tui.keys.bindings import HAND_BINDINGS
from tui.keys.speeds import SPEEDS, TURN
from tui.words import strings
from tui.words.hints import Acting, hint_line


class ByHand(Static):
    """The line. It is shown while it has the focus."""

    BINDINGS = HAND_BINDINGS
    can_focus = True

    class Driven(Message):
        """Drive so for a moment: m/s forward and to the left, rad/s counter-clockwise."""

        def __init__(self, vx: float, vy: float, wz: float) -> None:
            super().__init__()
            self.vx, self.vy, self.wz = vx, vy, wz

    class Ended(Message):
        """It is driven by hand no more."""

    def __init__(self, acting: Acting, **more: Any) -> None:
        """``acting`` says which keys act now."""
        super().__init__(id="by-hand", markup=False, **more)
        self._acting = acting
        self._shown = ""
        self._step = 1
        self._standstill = ""
        self.display = False

    def allow_focus(self) -> bool:
        """Nobody drives by a line that is not shown: a terminal that gets the keyboard back would give it to it."""
        return self.display

    def begin(self) -> None:
        """Take the keyboard."""
        self.display = True
        self.screen.set_focus(self)
        self.hint()

    def tell(self, standstill: str) -> None:
        """``standstill`` says why nothing can move the robot, where that is so; the line says it then."""
        if standstill != self._standstill:
            self._standstill = standstill
            self.hint()

    def on_blur(self, event: events.Blur) -> None:
        self.display = False
        self.post_message(self.Ended())

    def action_hand(self, vx: int, vy: int, wz: int) -> None:
        """Drive with the chosen speed in this direction."""
        if self._standstill:
            return
        speed = SPEEDS[self._step]
        self.post_message(self.Driven(vx * speed, vy * speed, wz * speed * TURN))

    def action_hand_speed(self, steps: int) -> None:
        """Choose another speed."""
        self._step = max(0, min(len(SPEEDS) - 1, self._step + steps))
        self.hint()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "hand":
            return not self._standstill or None
        if action == "hand_speed" and isinstance(steps := parameters[0], int):
            return 0 <= self._step + steps < len(SPEEDS) or None
        return super().check_action(action, parameters)

    def on_resize(self) -> None:
        self.hint()

    def hint(self) -> None:
        """Say how fast it drives, and by which keys; or why it cannot."""
        if not self.display:
            return
        hints = strings.BY_HAND_STANDS if self._standstill else strings.BY_HAND
        speed, room = SPEEDS[self._step], max(1, self.size.width - 2)
        words = f" {hint_line(hints, self._acting, room, last=2, speed=speed, why=self._standstill)}"
        if words != self._shown:
            self._shown = words
            self.update(words)
