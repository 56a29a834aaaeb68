"""Driving to be charged: what a robot with a low battery does by itself, where there is a dock.

It goes when nobody has asked for anything for a while, and once: whoever stops it on its way has decided, until the
battery has been charged.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from engine.bus import Emit
from engine.commands import Command, Say
from engine.errors import PlanError, RobotError
from engine.events import Log
from engine.parts.part import Loading
from engine.robot.robot import BatteryState, Robot
from engine.skills.places import Places

THERE_M: Final = 0.3
"""A robot that is as near as this stands at its dock."""
LOOKS: Final = 3
"""How often running the battery must be low: motors that start take some volts for a moment."""
ID: Final = "battery"
"""Of the request, so that nobody takes its end for that of theirs."""
CHARGED: Final = 0.6
"""From this part of a full battery on, it has been charged; one that rests gains less by itself."""


class Charging:
    """Sends the robot to the place called ``dock``; None: it has none, and somebody has to charge it.

    ``is_free`` tells whether nobody wants anything, and nobody has for a while: not even to drive it by hand.
    """

    def __init__(
        self,
        robot: Loading[Robot],
        places: Places,
        dock: str | None,
        is_free: Callable[[], bool],
        ask: Callable[[Command], object],
        emit: Emit,
    ) -> None:
        self._robot = robot
        self._places = places
        self._dock = dock
        self._is_free = is_free
        self._ask = ask
        self._emit = emit
        self._lows = 0
        self._went = False

    def look(self, battery: BatteryState) -> None:
        """What the battery gives now; asked for again and again."""
        if battery.charge > CHARGED:
            self._went = False
        self._lows = self._lows + 1 if battery.low else 0
        if self._lows >= LOOKS and not self._went and self._is_free():
            self._went = self._go(battery.volts)

    def _go(self, volts: float) -> bool:
        """Whether it is on its way."""
        robot = self._robot.value
        if robot is None or self._dock is None:
            return False
        try:
            symbol, state = self._places.symbol(self._dock), robot.state()
        except (PlanError, RobotError):  # a house without a dock; or a robot that is lost, which is told by its keeper
            return False
        goal = self._places.pose(symbol)
        if goal is None or state.estop or math.dist((goal.x, goal.y), (state.pose.x, state.pose.y)) < THERE_M:
            return False
        name = self._places.name(symbol)
        self._emit(Log("warning", "robot", f"The battery is low ({volts:g} V): I am going to {name}."))
        plain = self._dock.replace(" ", "").isalnum()
        self._ask(Say(f"navigation({self._dock if plain else symbol})", id=ID, wait=True))
        return True
