"""Driving to be charged: what a robot with a low battery does by itself, where there is a dock.

It waits for what runs to end, interrupts nobody, and asks once: whoever stops it on its way has decided.
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
from engine.robot.robot import Robot
from engine.skills.places import Places

THERE_M: Final = 0.3
"""A robot that is as near as this stands at its dock."""


class Charging:
    """Sends the robot to the place called ``dock``; None: it has none, and somebody has to charge it."""

    def __init__(
        self, robot: Loading[Robot], places: Places, dock: str | None, ask: Callable[[Command], object], emit: Emit
    ) -> None:
        self._robot = robot
        self._places = places
        self._dock = dock
        self._ask = ask
        self._emit = emit

    def go(self, volts: float) -> None:
        """The battery has become low: it gives ``volts``."""
        robot = self._robot.value
        if robot is None or self._dock is None:
            return
        try:
            symbol, state = self._places.symbol(self._dock), robot.state()
        except (PlanError, RobotError):  # a house without a dock; or a robot that is lost, which is told by its keeper
            return
        goal = self._places.pose(symbol)
        if goal is None or state.estop or math.dist((goal.x, goal.y), (state.pose.x, state.pose.y)) < THERE_M:
            return
        name = self._places.name(symbol)
        self._emit(Log("warning", "robot", f"The battery is low ({volts:g} V): I am going to {name}."))
        plain = self._dock.replace(" ", "").isalnum()
        self._ask(Say(f"navigation({self._dock if plain else symbol})", wait=True))
