"""The dispatcher runs a validated plan, one action after the other, and keeps the books.

Every action that starts ends exactly once, and its end is on the bus (and so in the event log) before anything else
happens: also when it is cancelled, when its skill has a fault, or when the robot is lost. It stops at the first action
that is not ok. What never started is in the report too, so that nobody has to guess.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from dataclasses import dataclass

from ulid import ULID

from engine.bus import Emit
from engine.epoch import Epoch
from engine.errors import RobotError
from engine.events import ActionFinished, ActionProgress, ActionQueued, ActionStarted, ErrorRaised
from engine.plan import Action, Plan
from engine.robot.robot import Robot
from engine.robot.watch import view
from engine.skills.context import Progress, Say, SkillContext
from engine.skills.outcome import Result, fail
from engine.skills.places import Places
from engine.skills.registry import SkillRegistry

PROGRESS_PERIOD_S = 0.25
"""Shortest time between two progress events of one action, s of robot time; a new path is always sent."""


@dataclass(frozen=True, slots=True)
class Ran:
    """An action and how it ended."""

    action: Action
    result: Result
    duration_s: float  # robot time


@dataclass(frozen=True, slots=True)
class Report:
    """What became of a plan: the actions that ran, in order, and those that never started."""

    ran: tuple[Ran, ...]
    never_started: tuple[Action, ...]

    @property
    def ok(self) -> bool:
        return not self.never_started and all(ran.result.ok for ran in self.ran)

    @property
    def failure(self) -> Ran | None:
        """The action that ended the plan early."""
        return next((ran for ran in self.ran if not ran.result.ok), None)

    @property
    def message(self) -> str:
        """What happened, for people: the failure first, else what each action reports."""
        if (failure := self.failure) is None:
            return " ".join(ran.result.message for ran in self.ran if ran.result.message)
        text = failure.result.message
        if self.never_started:
            text += f" I did not start: {', '.join(str(action) for action in self.never_started)}."
        return text


class Dispatcher:
    """Runs plans on one robot. One plan at a time."""

    def __init__(
        self,
        registry: SkillRegistry,
        robot: Robot,
        places: Places,
        epoch: Epoch,
        describe_skills: Callable[[], str],
    ) -> None:
        self._registry = registry
        self._robot = robot
        self._places = places
        self._epoch = epoch
        self._describe_skills = describe_skills

    async def run(self, plan: Plan, epoch: int, emit: Emit, say: Say, ran: list[Ran]) -> Report:
        """Run ``plan`` in ``epoch``. ``ran`` collects what ran, also when this is cancelled half-way."""
        ids = [str(ULID()) for _ in plan.actions]
        total = len(plan.actions)
        for index, (action, key) in enumerate(zip(plan.actions, ids, strict=True), 1):
            emit(ActionQueued(key, index, total, action.name, action.args))
        for index, (action, key) in enumerate(zip(plan.actions, ids, strict=True), 1):
            if not self._epoch.is_current(epoch):
                break
            emit(ActionStarted(key, index, total, action.name, action.args))
            result = await self._run_action(action, key, epoch, emit, say, ran)
            if not result.ok:
                break
        return Report(tuple(ran), plan.actions[len(ran) :])

    async def _run_action(self, action: Action, key: str, epoch: int, emit: Emit, say: Say, ran: list[Ran]) -> Result:
        began = self._robot_time()
        context = SkillContext(
            robot=self._robot,
            epoch=epoch,
            places=self._places,
            say=say,
            progress=self._progress(key, action.name, emit),
            describe_skills=self._describe_skills,
        )
        cancelled: asyncio.CancelledError | None = None
        try:
            result = await self._registry[action.name].run(context, **action.args)
        except asyncio.CancelledError as error:
            cancelled = error
            result = Result("interrupted", "cancelled", f"{action} was interrupted{self._where()}.")
        except RobotError as error:
            result = Result("uncertain", "robot_lost", f"{error} How far {action} got is not known.")
        except Exception as error:  # noqa: BLE001 - a fault in one skill ends that action, not the session
            result = fail("crashed", f"{action.name} has a fault: {error!r}.")
            emit(ErrorRaised("skill_crashed", f"The skill {action.name} has a fault: {error!r}.", "Please report it."))
        self._report_robot(emit)
        duration = max(0.0, self._robot_time() - began)
        ran.append(Ran(action, result, duration))
        emit(
            ActionFinished(
                action=key,
                name=action.name,
                args=action.args,
                outcome=result.outcome,
                error_code=result.error_code,
                message=result.message,
                duration_s=round(duration, 3),
                data=dict(result.data) or None,
            )
        )
        if cancelled is not None:
            raise cancelled
        return result

    def _progress(self, key: str, name: str, emit: Emit) -> Progress:
        last = -PROGRESS_PERIOD_S

        def progress(
            fraction: float | None, message: str = "", *, path: tuple[tuple[float, float], ...] | None = None
        ) -> None:
            nonlocal last
            now = self._robot_time()
            if path is None and now - last < PROGRESS_PERIOD_S:
                return
            last = now
            emit(ActionProgress(key, name, None if fraction is None else round(fraction, 3), message, path))

        return progress

    def _report_robot(self, emit: Emit) -> None:
        """Where the action left the robot; the periodic reports may come too late for that."""
        with contextlib.suppress(RobotError):  # its loss is the outcome of the action
            emit(view(self._robot.state()))

    def _robot_time(self) -> float:
        try:
            return self._robot.state().t
        except RobotError:
            return 0.0

    def _where(self) -> str:
        try:
            pose = self._robot.state().pose
        except RobotError:
            return ""
        return f" at x {pose.x:.2f} m, y {pose.y:.2f} m"
