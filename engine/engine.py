"""The engine: builds the parts from settings and runs the session in a thread of its own.

:class:`Engine` is what a screen or a command holds (``engine.handle.EngineHandle``). Its loop runs the session, the
robot's heartbeat and the publisher of the robot's state; the robot starts and models load in the background, so that
the engine takes commands from the first moment. Whatever ends the loop, the robot is stopped and closed first.
"""

from __future__ import annotations

import asyncio
import gc
import os
import sys
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from config import paths
from config.schema import Place, Settings
from engine import __version__, events
from engine.bus import Bus, Subscriber
from engine.camera_part import CameraPart
from engine.clock import Clock, SystemClock
from engine.commands import Command, Heard
from engine.demo import Demo
from engine.dispatch import Dispatcher
from engine.ears import Ears
from engine.epoch import Epoch
from engine.errors import RobotError, SaysoError, StorageError
from engine.event_log import EventLog
from engine.events import Body, Event
from engine.handle import PartName, PartStatus
from engine.hearing import Hearing
from engine.holds import Holds
from engine.keeper import Keeper
from engine.loading import Sound, at_home, make_robot, make_vision
from engine.parts import Part
from engine.perception.eyes import Eyes
from engine.perception.memory import World, WorldMemory
from engine.planner.build import build_planner, build_registry
from engine.planner.planner import Planner
from engine.robot.robot import FloorMap, Robot, RobotState, Scan
from engine.scheduling import prefer
from engine.session import Session
from engine.skills.places import Places
from engine.tts.voice import SilentVoice
from engine.turn import Needs

T = TypeVar("T")

PULSE_S = 0.05
"""Between two signs of life of the engine's loop, s."""
SWITCH_S = 0.0005
"""How long a thread that stops the robot may have to wait for one that computes in Python, s (Python: 5 ms)."""
PAUSE_S = 1.0
"""From this long without one, the loop itself says that it was away, once it is back."""


class Engine:
    """A running engine. ``start`` it once; it ends by a ``Quit`` command, and ``join`` waits for that.

    ``mode`` is for the record (``console``, ``ask``…). ``sound`` says where sound comes from.
    """

    def __init__(self, settings: Settings, *, mode: str, sound: Sound, clock: Clock | None = None) -> None:
        self._settings = settings = at_home(settings)
        self._mode = mode
        self._sound = sound
        self._bus = Bus(clock or SystemClock())
        self._robot: Robot = make_robot(settings.robot, lambda news: self._camera.follow(news))
        self._epoch = Epoch(self._robot.stop)
        self._parts: dict[PartName, Part[Any]] = {}
        self._memory = WorldMemory()
        self._session: Session | None = None
        self._ready = threading.Event()
        self._ended = threading.Event()
        self._failure: BaseException | None = None
        self._beaten = time.monotonic()
        self._thread = threading.Thread(target=self._run, name="engine", daemon=True)

    # What holders call, from any thread

    def start(self) -> None:
        """Start the engine thread; returns when it takes commands. Raises what kept it from starting."""
        sys.setswitchinterval(SWITCH_S)
        self._thread.start()
        self._ready.wait()
        if self._failure is not None:
            raise self._failure

    def join(self, timeout: float | None = 10.0) -> bool:
        """Wait for the engine to end; False if it has not by then."""
        return self._ended.wait(timeout)  # not Thread.join, which a signal handler that raises leaves broken

    def send(self, command: Command) -> None:
        """Give a command; see ``Session.request``."""
        assert self._session is not None, "start() comes first"
        self._session.request(command)

    def subscribe(self, subscriber: Subscriber) -> Callable[[], None]:
        """Get every event from now on, in the publishing thread."""
        return self._bus.subscribe(subscriber)

    def reject(self, do: str, message: str) -> None:
        """Acknowledge a command that could not even be read."""
        self._bus.publish(events.Ack(do, False, message), epoch=self._epoch.current)

    def status(self) -> tuple[PartStatus, ...]:
        return tuple(part.status for part in self._parts.values())

    @property
    def failure(self) -> BaseException | None:
        """The fault that the engine ended by, if it was one."""
        return self._failure

    def pulse(self) -> float:
        return 0.0 if self._ended.is_set() else time.monotonic() - self._beaten

    def robot_state(self) -> RobotState | None:
        return self._when_robot_is_up(self._robot.state)

    def scan(self) -> Scan | None:
        return self._when_robot_is_up(self._robot.scan)

    def floor_map(self) -> FloorMap | None:
        return self._robot.floor_map

    def places(self) -> Mapping[str, Place]:
        return self._settings.places

    def world(self) -> World:
        return self._memory.snapshot()

    def _when_robot_is_up(self, read: Callable[[], T]) -> T | None:
        if "robot" not in self._parts or self._parts["robot"].value is None:
            return None
        try:
            return read()
        except RobotError:
            return None

    # The engine thread

    def _run(self) -> None:
        if self._settings.robot.realtime_priority:
            prefer()
        try:
            asyncio.run(self._main())
        except BaseException as error:  # noqa: BLE001 - handed to whoever waits in start(), or published
            self._robot.stop(self._epoch.advance())
            self._failure = error
            message = f"The engine ended by a fault: {error!r}."
            self._bus.publish(events.ErrorRaised("engine_died", message, "Please report it.", fatal=True))
        finally:
            self._ready.set()
            self._ended.set()

    async def _main(self) -> None:
        log = self._open_log()
        self._emit(events.SessionStarted(__version__, self._mode, self._robot.name, os.getpid()))
        places = Places(self._settings.places)
        registry = build_registry(self._settings, places)
        robot: Part[Robot] = self._part("robot")
        planner: Part[Planner] = self._part("planner")
        hearing: Part[Hearing] = self._part("recogniser")
        microphone: Part[str] = self._part("microphone")
        self._camera = CameraPart(self._part("camera"), self._emit)

        holds, eyes = Holds(), Eyes(self._robot, self._memory)
        vision = make_vision(self._settings)

        def understood() -> str:
            return planner.value.understood if planner.value else ""

        needs = Needs(
            robot=robot,
            planner=planner,
            dispatcher=lambda up: Dispatcher(registry, up, places, self._epoch, holds, understood, eyes, vision),
            hearing=hearing,
            voice=SilentVoice(),
        )
        ears = Ears(self._settings, self._sound, microphone, hearing, on_words=lambda words: self.send(Heard(words)))
        self._session = Session(
            self._settings.session, self._bus, self._epoch, needs, hear_audio=ears.push, mark_wake=ears.mark
        )
        background = [
            asyncio.create_task(work)
            for work in (
                self._beat(),
                self._keep_robot(robot, places),
                planner.load(lambda: asyncio.to_thread(build_planner, self._settings, registry)),
                ears.keep(),
                *([self._play_demo(ears, hearing)] if self._sound.kind == "demo" else []),
            )
        ]
        self._ready.set()
        reason = "a fault"
        try:
            await self._session.run()
            reason = "asked to"
        finally:
            for task in background:
                task.cancel()
            await asyncio.gather(*background, return_exceptions=True)
            gc.unfreeze()  # what was loaded goes with the engine
            self._emit(events.SessionEnded(reason))
            if log is not None:
                log.close()

    async def _beat(self) -> None:
        """Show that the loop lives; when it did not (paused, or held up), say for how long."""
        self._beaten = time.monotonic()
        while True:
            away, self._beaten = time.monotonic() - self._beaten, time.monotonic()
            if away > PAUSE_S:
                message = f"The engine was away for {away:.1f} s. A robot that was moving has stopped by itself."
                self._emit(events.Log("warning", "engine", message))
                self._emit(events.Timing("paused", round(away, 3)))
            await asyncio.sleep(PULSE_S)

    async def _keep_robot(self, part: Part[Robot], places: Places) -> None:
        """Keep the robot until this is cancelled, and close it."""
        assert self._session is not None, "made before"
        keeper = Keeper(self._robot, part, self._epoch, self._emit, self._session.request)
        await keeper.keep(lambda robot: places.remember(robot.state().pose))

    async def _play_demo(self, ears: Ears, hearing: Part[Hearing]) -> None:
        """Let the demo speak once the robot can hear."""
        await hearing.get()
        assert ears.simulated is not None
        demo = Demo(ears.simulated, self.send)
        unsubscribe = self._bus.subscribe(demo.see)
        try:
            await asyncio.Event().wait()
        finally:
            unsubscribe()
            demo.close()

    def _part(self, name: PartName) -> Part[Any]:
        part: Part[Any] = Part(name, self._report)
        self._parts[name] = part
        return part

    def _report(self, status: PartStatus) -> None:
        """Say how a part is doing; how the robot is lost is its keeper's to say."""
        if status.state == "ready":
            self._emit(events.Log("info", status.name, f"ready: {status.detail}" if status.detail else "ready"))
        elif status.name != "robot":
            self._emit(events.Log("warning", status.name, status.detail))
        if not any(part.status.state == "loading" for part in self._parts.values()):
            # All that was loaded stays. Looking through it for garbage again and again would hold up everybody, also
            # those who stop the robot, for a tenth of a second each time.
            gc.freeze()

    def _emit(self, body: Body, /) -> Event:
        """Publish what belongs to no turn."""
        return self._bus.publish(body, epoch=self._epoch.current)

    def _open_log(self) -> EventLog | None:
        settings = self._settings.session
        if not settings.record_log:
            return None
        log = EventLog(paths().logs, self._bus.session, max_bytes=int(settings.log_mb * 1e6), keep=settings.log_files)
        try:
            log.open()
        except StorageError as error:
            self._tell(error)
            return None
        log.on_error = self._tell
        self._bus.subscribe(log.write)
        return log

    def _tell(self, error: SaysoError) -> None:
        self._emit(events.ErrorRaised(error.code, error.message, error.hint))
