"""The dispatcher runs a validated plan and keeps the books.

Actions run one after the other; those that the plan lets start together overlap as far as they occupy different
capabilities. Every action that starts ends exactly once, and its end is on the bus (and so in the event log) before
anything else happens: also when it is cancelled, when its skill has a fault or does not let go, and when the robot is
lost. The plan ends at the first action that is not ok, which cuts those beside it. What never started is in the report
too, so that nobody has to guess.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final, NamedTuple

from ulid import ULID

from engine.bus import Emit
from engine.cancellation import GRACE_S, Remains, bounded
from engine.epoch import Epoch
from engine.errors import CameraError, PlanError, RobotError
from engine.events import (
    ActionFinished,
    ActionProgress,
    ActionQueued,
    ActionStarted,
    CameraFrame,
    ErrorRaised,
    Log,
    PerceptionResult,
)
from engine.llm.chat import ChatError
from engine.perception.eyes import Eyes
from engine.perception.sighting import EVERYTHING, Part, Sight, as_json
from engine.plan import Action, InWords, Plan, as_written
from engine.robot.camera import Picture
from engine.robot.geometry import ZERO, Pose
from engine.robot.robot import Robot
from engine.robot.watch import view
from engine.session.holds import Holds
from engine.session.ran import Moment, Ran
from engine.session.way_back import WayBack, way_back
from engine.skills.context import Ask, AskAbout, Progress, Say, See, SkillContext, Worded
from engine.skills.outcome import ErrorCode, Result, fail
from engine.skills.people import People
from engine.skills.places import Places
from engine.skills.registry import Skill, SkillRegistry

if TYPE_CHECKING:
    from engine.perception.asking import Onlooker

PROGRESS_PERIOD_S = 0.25
"""Shortest time between two progress events of one action, s of robot time; a new path is always sent."""

_MOVING: Final = frozenset({"base", "arm"})
"""What a skill occupies that moves the robot."""

SIGHT_PERIOD_S = 1.0
"""Time between two events about a sight that shows the same things, s of robot time."""


FAR_M: Final = 8.0
"""A place from this far on is not driven to with a low battery."""
_HEARD: Final = frozenset({"say", "finishtask"})
"""Actions of which nothing is left to be told: their words were heard, or they have none for people."""


@dataclass(frozen=True, slots=True)
class Report:
    """What became of a plan: the actions that ran, in the order of their ends, and those that never started."""

    ran: tuple[Ran, ...]
    never_started: tuple[Action, ...]
    failure: Ran | None = None
    """The action that ended the plan early, unless that was an interruption: it failed, or it asked a question."""
    told: Callable[[Action], InWords] = as_written

    @property
    def question(self) -> str | None:
        """What the user has been asked, and the plan with it."""
        if self.failure is None or self.failure.result.error_code != "needs_answer":
            return None
        return self.failure.result.message

    @property
    def ok(self) -> bool:
        return not self.never_started and all(ran.result.ok for ran in self.ran)

    @property
    def message(self) -> str:
        """What happened, for people: the failure first, else what each action reports."""
        if self.failure is None:
            told = (ran.result.message for ran in self.ran if ran.action.name not in _HEARD)
            return " ".join(filter(None, told))
        text = self.failure.result.message
        if self.never_started:
            text += f" I did not start: {', '.join(self.told(action).doing for action in self.never_started)}."
        return text


@dataclass(slots=True)
class Run:
    """One plan on its way: what it may use, and its books, which are true at every moment."""

    plan: Plan
    epoch: int
    emit: Emit
    say: Say
    record: Callable[[Ran], None]
    """Gets every action that ran, at its end, before anybody else can run."""
    cut_by: Callable[[], ErrorCode] = lambda: "cancelled"
    """Why it is being cancelled; asked when that happens."""
    ask: Ask | None = None
    """Asks somebody and gives the answer, where one can be heard."""
    worded: Worded = lambda text, language=None: text
    """Puts a sentence of ours into the language of the request."""
    told: Callable[[Action], InWords] = as_written
    """How people are told of an action."""
    ran: list[Ran] = field(default_factory=list)
    started: set[int] = field(default_factory=set)
    running: set[str] = field(default_factory=set)  # keys of the actions that have started and not ended
    failure: Ran | None = None

    def report(self) -> Report:
        """The books as of now."""
        never = tuple(action for index, action in enumerate(self.plan.actions) if index not in self.started)
        return Report(tuple(self.ran), never, self.failure, self.told)


class Begun(NamedTuple):
    """A started action."""

    action: Action
    key: str
    t: float  # s, robot time
    before: Moment | None


class _Failed(Exception):
    """An action was not ok, or asked the user something: what runs beside it is cut."""


class Dispatcher:
    """Runs plans on one robot, one plan at a time. ``holds`` outlives plans and dispatchers."""

    def __init__(
        self,
        registry: SkillRegistry,
        robot: Robot,
        places: Places,
        epoch: Epoch,
        holds: Holds,
        describe_skills: Callable[[], str],
        eyes: Eyes,
        onlooker: Onlooker | None = None,
        dock: str | None = None,
        people: People | None = None,
    ) -> None:
        """``dock`` is the name of the place where the robot is charged, where there is one."""
        self._registry = registry
        self._robot = robot
        self._places = places
        self._epoch = epoch
        self._holds = holds
        self._describe_skills = describe_skills
        self._eyes = eyes
        self._onlooker = onlooker
        self._dock = dock
        self._people = people or People()
        self._last_time = 0.0

    def is_endless(self, plan: Plan) -> bool:
        """Whether an action of the plan goes on until somebody interrupts it."""
        return any(self._registry[action.name].endless for action in plan.actions)

    async def run(self, run: Run) -> Report:
        """Run the plan. ``run`` is up to date at every moment, also when this is cancelled half-way."""
        actions, keys = run.plan.actions, [str(ULID()) for _ in run.plan.actions]
        for index, (action, key) in enumerate(zip(actions, keys, strict=True), 1):
            told = run.told(action).step
            run.emit(ActionQueued(key, index, len(actions), action.name, action.args, told))
        for group in run.plan.groups():
            if run.failure is not None or not self._epoch.is_current(run.epoch):
                break
            try:
                async with asyncio.TaskGroup() as beside:
                    for index in group:
                        beside.create_task(self._act(run, index, keys[index]))
            except* _Failed:
                pass  # run.failure tells; any other error is a fault of ours and goes on
        return run.report()

    async def _act(self, run: Run, index: int, key: str) -> None:
        """One action, from waiting for what it occupies to its outcome. Raises :class:`_Failed` unless it is ok."""
        action = run.plan.actions[index]
        skill = self._registry[action.name]
        hold = await self._holds.acquire(skill.occupies, run.epoch)
        try:
            if not self._epoch.is_current(run.epoch):
                raise _Failed
            run.started.add(index)
            run.running.add(key)
            told = run.told(action).step
            now = round(self._robot_time(), 3)
            run.emit(ActionStarted(key, index + 1, len(run.plan.actions), action.name, action.args, told, now))
            result = await self._perform(run, action, key)
            if not result.ok or result.error_code == "needs_answer":
                raise _Failed
        finally:
            self._holds.release(hold)

    async def _perform(self, run: Run, action: Action, key: str) -> Result:
        """Run a started action to its end and write that down, whatever it is."""
        begun = Begun(action, key, self._robot_time(), self._moment())
        context = SkillContext(
            robot=self._robot,
            epoch=run.epoch,
            places=self._places,
            say=run.say,
            progress=self._progress(run, key, action.name),
            describe_skills=self._describe_skills,
            see=self._seeing(run, key),
            world=self._eyes.world,
            ask_about=self._asking(run),
            people=self._people,
            ask=run.ask,
            worded=run.worded,
        )
        if (refused := self._refused(self._registry[action.name], action)) is not None:
            self._write(run, begun, refused, began=False)
            return refused
        remains: Remains[Result] = Remains(lambda found: self._drop(run, action, found))
        try:
            result = await bounded(self._registry[action.name].run(context, **action.args), remains)
            result = self._with_fault(result)
            if not self._epoch.is_current(run.epoch):  # it ended by itself, but after the stop
                result = self._interrupted(run, action, result)
        except asyncio.CancelledError:
            if self._epoch.is_current(run.epoch):  # by the failure of one beside it: nobody has stopped the base
                with contextlib.suppress(RobotError):
                    self._robot.drive(ZERO, run.epoch)
            self._write(run, begun, self._cut(run, action, remains))
            raise
        except RobotError as error:
            result = Result("uncertain", "robot_lost", f"{error.message} {_unknown(run, action)}")
        except CameraError as error:
            result = fail("camera_lost", error.message)
        except Exception as error:  # noqa: BLE001 - a fault in one skill ends that action, not the session
            result = fail("crashed", f"{action.name} has a fault: {error!r}.")
            message = f"The skill {action.name} has a fault: {error!r}."
            run.emit(ErrorRaised("skill_crashed", message, "Please report it."))
        self._write(run, begun, result)
        return result

    def _with_fault(self, result: Result) -> Result:
        """What went wrong, and what the controller of the arm says of it."""
        if result.outcome != "failed" or not (fault := self._robot.state().arm_fault):
            return result
        return replace(result, message=f"{result.message} My arm says: {fault}.")

    def _write(self, run: Run, begun: Begun, result: Result, *, began: bool = True) -> None:
        """The one end of an action, in the books and on the bus, before anybody else can run."""
        action = begun.action
        run.running.discard(begun.key)
        self._report_robot(run.emit)
        duration, ended = max(0.0, self._robot_time() - begun.t), self._moment()
        ran = Ran(action, result, duration, begun.before, ended.state.pose if ended is not None else None, began)
        run.ran.append(ran)
        run.record(ran)
        ends = result.outcome in ("failed", "uncertain") or result.error_code == "needs_answer"
        if ends and run.failure is None and self._epoch.is_current(run.epoch):
            run.failure = ran
        run.emit(
            ActionFinished(
                action=begun.key,
                name=action.name,
                args=action.args,
                outcome=result.outcome,
                error_code=result.error_code,
                message=result.message,
                duration_s=round(duration, 3),
                data=dict(result.data) or None,
            )
        )

    def _cut(self, run: Run, action: Action, remains: Remains[Result]) -> Result:
        """The outcome of an action that was cancelled."""
        if run.cut_by() == "robot_lost":
            return Result("uncertain", "robot_lost", f"The robot was lost. {_unknown(run, action)}")
        if remains.let_go:
            return self._interrupted(run, action, remains.found)
        message = f"{_subject(run, action)}: did not stop within {GRACE_S:g} s{self._where()}."
        return Result("uncertain", run.cut_by(), message)

    def _interrupted(self, run: Run, action: Action, said: object) -> Result:
        why = "" if run.failure is None else f" because {run.told(run.failure.action).doing} failed"
        message = f"{_subject(run, action)}: stopped{why}{self._where()}."
        if isinstance(said, Result) and said.message:
            message += f" Its last report: {said.message}"
        return Result("interrupted", run.cut_by(), message)

    @staticmethod
    def _drop(run: Run, action: Action, found: Result | BaseException) -> None:
        """An action ended long after its outcome was written: for the record, and without any effect."""
        run.emit(Log("warning", "dispatch", f"{_subject(run, action)}: ended late, after it was given up: {found!r}."))

    def _progress(self, run: Run, key: str, name: str) -> Progress:
        last = -PROGRESS_PERIOD_S

        def progress(
            fraction: float | None, message: str = "", *, path: tuple[tuple[float, float], ...] | None = None
        ) -> None:
            nonlocal last
            now = self._robot_time()
            if key not in run.running or (path is None and now - last < PROGRESS_PERIOD_S):
                return
            last = now
            run.emit(ActionProgress(key, name, None if fraction is None else round(fraction, 3), message, path))

        return progress

    def _seeing(self, run: Run, key: str) -> See:
        """The eyes, and word of what they see. Followers look ten times a second: what is as before is told rarely."""
        last, names = -SIGHT_PERIOD_S, ""

        async def see(parts: Collection[Part] = EVERYTHING) -> Sight:
            nonlocal last, names
            sight = await self._eyes.see(parts)
            if not EVERYTHING.issubset(parts):
                return sight
            shown = ", ".join(thing.name for thing in sight.objects)
            if key in run.running and (shown != names or sight.t - last >= SIGHT_PERIOD_S):
                last, names = sight.t, shown
                height, width = sight.picture.depth.shape
                run.emit(CameraFrame(width, height))
                run.emit(PerceptionResult(shown, tuple(as_json(thing) for thing in sight.objects)))
            return sight

        return see

    def _asking(self, run: Run) -> AskAbout | None:
        """A model that sees, and word of its calls and failures: what a skill makes of them is its own affair."""
        onlooker = self._onlooker
        if onlooker is None:
            return None

        async def asking(picture: Picture, question: str) -> str:
            try:
                return await onlooker(picture, question, lambda call: run.emit(call.as_event("vision", 1)))
            except ChatError as error:
                run.emit(Log("warning", "vision", str(error)))
                raise

        return asking

    def _refused(self, skill: Skill, action: Action) -> Result | None:
        """Why the robot does not begin this as it stands; None where it does."""
        try:
            state = self._robot.state()
        except RobotError:
            return None  # its loss is the outcome of the action
        if state.estop and skill.occupies & _MOVING:
            return fail("robot_halted", "The emergency stop is pressed: release it first.")
        if state.battery is None or not state.battery.low:
            return None
        volts = state.battery.volts
        if skill.endless or skill.lasting:
            return fail("battery_low", f"My battery is low ({volts:g} V): charge me first.")
        here = state.pose
        places = (str(action.args[p.name]) for p in skill.parameters if p.word == "place")
        away = max((self._away(place, here) for place in places), default=0.0)
        if away > FAR_M:
            far = f"My battery is low ({volts:g} V), and that is {away:.0f} m away: charge me first."
            return fail("battery_low", far)
        return None

    def _away(self, place: str, here: Pose) -> float:
        """How far a place is as the crow flies, m; 0 where it is not known, or the way to it is that to be charged."""
        try:
            symbol = self._places.symbol(place)
        except PlanError:
            return 0.0
        goal = self._places.pose(symbol)
        if goal is None or symbol == self._dock_symbol():
            return 0.0
        return math.dist((here.x, here.y), (goal.x, goal.y))

    def _dock_symbol(self) -> str | None:
        """Of the place where the robot is charged; None where the house has none."""
        with contextlib.suppress(PlanError):
            return None if self._dock is None else self._places.symbol(self._dock)
        return None

    def _report_robot(self, emit: Emit) -> None:
        """Where the action left the robot; the periodic reports may come too late for that."""
        with contextlib.suppress(RobotError):  # its loss is the outcome of the action
            emit(view(self._robot.state()))

    def _moment(self) -> Moment | None:
        """How everything is; None while the robot cannot be asked."""
        try:
            return Moment(self._robot.state(), self._eyes.world.snapshot())
        except RobotError:
            return None

    def way_back(self, acted: Sequence[Ran], *, relocated: bool, told: Callable[[Action], InWords]) -> WayBack:
        """From what was done in one turn; ``relocated``: somebody has put the robot elsewhere on the map since."""
        if (now := self._moment()) is None:
            return WayBack(why_not="I cannot undo anything while my robot is away.")
        robot = self._robot
        return way_back(acted, self._registry, now, robot.floor_map, robot.arm.rest, relocated=relocated, told=told)

    def _robot_time(self) -> float:
        """Robot time, s; of a lost robot, the last that was known."""
        with contextlib.suppress(RobotError):
            self._last_time = self._robot.state().t
        return self._last_time

    def _where(self) -> str:
        try:
            pose = self._robot.state().pose
        except RobotError:
            return ""
        held = self._eyes.world.held
        return f" at x {pose.x:.2f} m, y {pose.y:.2f} m{f', holding the {held.name}' if held else ''}"


def _subject(run: Run, action: Action) -> str:
    """An action as the subject of a sentence."""
    doing = run.told(action).doing
    return f"{doing[:1].upper()}{doing[1:]}"


def _unknown(run: Run, action: Action) -> str:
    return f"{_subject(run, action)}: how far it got is not known."
