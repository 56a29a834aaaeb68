"""The emergency stop, as far as the console presses and releases it: also before there is an engine or a robot.

It is pressed in the thread that reads the keyboard. Where there is no engine yet, it is pressed as soon as there is
one, and until the robot tells of it, the status line says so. It stays pressed over a restart, so that before the robot
is there nobody knows whether it is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from engine.commands import EStop, Release
from tui.shown.readiness import no_robot
from tui.words import strings

if TYPE_CHECKING:
    from tui.rooms.drawing import Drawing
    from tui.rooms.keeping import Keeping
    from tui.shown.view import View
    from tui.stage import Stage


class EmergencyStop:
    """In the UI thread, but for :meth:`press`."""

    def __init__(self, stage: Stage, drawing: Drawing, keeping: Keeping) -> None:
        self._stage = stage
        self._drawing = drawing
        self._keeping = keeping
        self._is_owed = False  # it was pressed before the engine was there
        self._was_pressed = False  # it was pressed here, and not released since; the robot may not have told so yet

    def press(self) -> None:
        """Press it, now or as soon as there is something to press. In any thread."""
        self._was_pressed = True
        self._is_owed = True  # before one looks whether the engine is there, which may come in this moment
        if self._stage.handle is not None:
            self._is_owed = False
            self._stage.send(EStop())

    def tell_pressed(self) -> None:
        """It was pressed: say so, where nothing comes of it."""
        if self._drawing.failed:
            self._keeping.remark(strings.NO_ESTOP)
        self._stage.redraw()

    def begin(self) -> None:
        """The engine is there."""
        if self._is_owed:
            self._is_owed = False
            self._stage.send(EStop())
            self._stage.redraw()

    def release(self) -> None:
        """Release it. Where nothing is pressed, that would stop what runs."""
        view, remark = self._drawing.view, self._keeping.remark
        if self._drawing.failed:
            remark(strings.NO_ESTOP)
        elif self.can_be_released:
            if self._stage.handle is None:
                remark(strings.PRESS_TAKEN_BACK)
            elif self._stage.handle.robot_state() is None:
                remark(strings.RELEASED)
            self._is_owed = self._was_pressed = False
            self._stage.send(Release())
        elif self._stage.handle is not None and self._stage.handle.robot_state() is not None:
            remark(strings.NOT_PRESSED, holds=lambda view: not view.pressed)
        elif (why := no_robot(view)) == strings.NO_ROBOT:
            remark(strings.ESTOP_NOT_KNOWN, holds=lambda view: view.robot is None)
        else:
            remark(why, holds=lambda view: view.robot is None)
        self._stage.redraw()

    @property
    def is_pressed(self) -> bool:
        """It is, as the robot tells."""
        robot = self._stage.handle.robot_state() if self._stage.handle is not None else None
        return self._drawing.model.pressed or (robot is not None and robot.estop)

    @property
    def can_be_released(self) -> bool:
        """It is pressed, or was here, and nobody has told of it yet."""
        return not self._drawing.failed and (self.is_pressed or self._was_pressed)

    def standstill(self, view: View) -> str:
        """What the status line says for as long as it is pressed or is going to be, and which key releases it."""
        if view.robot is not None and view.robot.estop:
            drops = view.model.waiting or view.model.asks  # nothing that was said before a release moves the robot
            words = strings.ESTOP_HOLDS_WAITING if drops else strings.ESTOP_HOLDS
        elif view.robot is None and self._was_pressed and not view.failed:
            words = strings.ESTOP_COMES
        else:
            return ""
        return words.format(release=self._stage.reaching("release"))
