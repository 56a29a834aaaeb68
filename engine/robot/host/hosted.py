"""A robot that a host owns, as the engine holds it.

Stops, commands and readings are accesses to the memory shared with the host's process and never wait for it. Ticks
come over a socket: in real time the host sends one while somebody waits, at full speed it is asked for one.

The memory outlives the process. When the process is lost (it died, was killed, does not answer), everybody who waits
for it gets an error, and ``start`` puts another one in its place, in the same memory: the robot stands where it was,
and what was commanded before moves nothing. The camera is nothing of the host's: pictures may take their time.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import math
import os
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, Protocol

import numpy as np

from config.schema import Robot as RobotSettings
from engine.errors import CameraError, RobotError
from engine.robot.arm import ArmModel
from engine.robot.camera import Picture
from engine.robot.camera_news import CameraNews, TellOfCamera
from engine.robot.company import Company
from engine.robot.description import Battery
from engine.robot.floor_map import FloorMap
from engine.robot.geometry import Pose, Twist, compose, inverse
from engine.robot.host import memory as m
from engine.robot.host.company import SharedCompany
from engine.robot.host.guard import end_guard
from engine.robot.host.memory import Memory, Record, believed
from engine.robot.host.process import HostProcess
from engine.robot.lidar import LIDAR_ANGLES, RAYS
from engine.robot.robot import SLOWEST, BatteryState, Capability, Footprint, Going, RobotState, Scan

ANSWER_LIMIT = 2.5
"""s of silence after which a robot process that has not ended counts as lost."""
BRAKE_TICKS: Final = 25
"""Ticks in which a robot at full speed comes to rest after a stop; from its highest speed it needs 5."""
_AGAIN = "Start it again."


class Eye(Protocol):
    """What takes pictures for a robot, in one asyncio loop."""

    @property
    def pid(self) -> int | None:
        """Of its process, where it has one."""
        ...

    async def look(self, *, labels: bool = False) -> Picture:
        """A picture of now. Raises ``CameraError``."""
        ...

    async def close(self) -> None:
        """End it and release everything."""
        ...


@dataclass(frozen=True, slots=True)
class Build:
    """How a robot is made: what the engine knows of it before anything is opened."""

    name: str
    """For people: ``simulated robot (flat)``."""
    capabilities: frozenset[Capability]
    footprint: Footprint
    floor_map: FloorMap
    arm: ArmModel
    eye: Callable[[Memory, TellOfCamera], Eye] | None
    """Opens the camera; None where there is none."""
    battery: Battery | None = None
    """Where one is measured."""
    navigates: bool = False
    """Whether it finds its way itself."""
    company: bool = False
    """Whether its body plays people around it."""
    environment: Mapping[str, str] = field(default_factory=dict)
    """Of the host's process."""


class HostedRobot:
    """A :class:`engine.robot.robot.Robot` that a host owns.

    ``tick`` and ``look`` belong to the asyncio loop that ``start`` ran in; everything else may be called from any
    thread. A command with values that are not finite raises ``ValueError``.
    """

    def __init__(self, settings: RobotSettings, build: Build, on_camera: TellOfCamera | None = None) -> None:
        """With ``on_camera`` the camera opens in the background as soon as the robot has started, and this is told how
        it is doing; otherwise it opens when somebody looks."""
        self._settings = settings
        self._build = build
        self._in_real_time = settings.speed == "real"
        self._writing = threading.Lock()  # one writer at a time for the command mailboxes; stop() never takes it
        self._memory: Memory | None = None
        self._process: HostProcess | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._lost: str | None = "The robot has not been started."
        self._waiters: dict[asyncio.Future[None], int] = {}  # each waits for a tick later than this one
        self._exchange_due = False
        self._braking: asyncio.Task[None] | None = None
        self._on_camera = on_camera
        self._camera: Eye | None = None
        self._looking = 0  # who waits for a picture
        self._pauses = itertools.count(1)
        self._pressed = False  # the emergency stop
        self._speed_limit = 1.0
        self._alive = self._alive_since = self._beaten = 0.0
        self._company = SharedCompany(lambda: self._memory) if build.company else None
        self._read: tuple[tuple[int, int, int, float], RobotState] | None = None  # the newest state that was asked for

    @property
    def name(self) -> str:
        return self._build.name

    @property
    def capabilities(self) -> frozenset[Capability]:
        return self._build.capabilities

    @property
    def footprint(self) -> Footprint:
        return self._build.footprint

    @property
    def floor_map(self) -> FloorMap:
        return self._build.floor_map

    @property
    def arm(self) -> ArmModel:
        return self._build.arm

    @property
    def navigates(self) -> bool:
        return self._build.navigates

    @property
    def company(self) -> Company | None:
        return self._company

    @property
    def memory(self) -> Memory:
        """The shared memory, for cameras, benchmarks and tests. Raises :class:`RobotError` when there is none."""
        return self._running()

    @property
    def pid(self) -> int | None:
        """Of the host's process."""
        return self._process.pid if self._process is not None else None

    @property
    def camera_pid(self) -> int | None:
        """Of the camera process, while it takes pictures."""
        return self._camera.pid if self._camera is not None else None

    async def start(self) -> None:
        """Start the host and wait until it has opened the body; one that was lost is replaced, and the robot goes on
        from where it was. Raises :class:`RobotError`."""
        if self._process is not None and self._lost is None:
            if (why := self._process.epitaph()) is None:
                raise RobotError("The robot is started already.", hint="Close it first.")
            self._lose(why)  # the loop has not heard of it yet
        self._loop = asyncio.get_running_loop()
        await self._bury()
        if self._memory is None:
            self._memory = Memory.create()
            self._memory.ints[m.ESTOP] = self._pressed
            self._memory.times[m.SPEED_LIMIT] = self._speed_limit
        else:
            self._memory.begin_again()
        try:
            self._process = process = HostProcess(self._settings, self._memory, self._build.environment)
            await asyncio.to_thread(process.wait_until_ready)
        except RobotError:
            await self._bury()  # but keep the memory: there may be another try
            raise
        except BaseException:
            await self.close()
            raise
        self._lost = None
        self._alive_since = time.monotonic()
        if self._in_real_time:
            process.link.setblocking(False)
            self._loop.add_reader(process.link, self._on_link)
        else:
            process.link.settimeout(ANSWER_LIMIT)
        if self._on_camera is not None and self._build.eye is not None:
            self._open_camera(self._memory)

    async def close(self) -> None:
        """Stop the robot, end its processes and release everything. Harmless when nothing runs."""
        if self._braking is not None:
            self._braking.cancel()
        process = self._process
        if process is not None and self._lost is None:
            self._lose("The robot has been closed.")
            await self._end(process, process.end)
        await self._bury()
        camera, self._camera = self._camera, None
        if camera is not None:
            await camera.close()
        memory, self._memory = self._memory, None
        self._read = None
        if memory is not None:
            os.close(memory.fd)

    async def _bury(self) -> None:
        """Leave nothing of a process that is lost or never became ready, nor of its guard, which would keep the port if
        it hangs."""
        if (process := self._process) is not None:
            await self._end(process, process.kill)
            if self._memory is not None and (guard := self._memory.ints[m.GUARD]):
                self._memory.ints[m.GUARD] = 0
                await asyncio.to_thread(end_guard, guard)

    async def _end(self, process: HostProcess, end: Callable[[], None]) -> None:
        self._process = None
        ending = asyncio.ensure_future(asyncio.to_thread(end))
        try:
            await asyncio.shield(ending)
        except asyncio.CancelledError:
            await ending  # a moment at most; nothing may be left running
            raise
        finally:
            process.release()

    # Commands. A stop is one store into shared memory, and so is a pause: they take no lock and meet no queue, and
    # whoever loses the processor before it has not stopped yet, and after it has.

    def stop(self, epoch: int) -> None:
        memory = self._memory  # also while there is no process: the next one obeys it
        if memory is not None:
            memory.ints[m.STOP_EPOCH] = epoch
            if not self._in_real_time and (loop := self._loop) is not None:
                with contextlib.suppress(RuntimeError):  # the loop has ended
                    loop.call_soon_threadsafe(self._come_to_rest)

    def press(self, pressed: bool) -> None:
        self._pressed = pressed
        if (memory := self._memory) is not None:
            memory.ints[m.ESTOP] = pressed

    def limit_speed(self, share: float) -> None:
        self._speed_limit = min(1.0, max(SLOWEST, share))
        if (memory := self._memory) is not None:
            memory.times[m.SPEED_LIMIT] = self._speed_limit

    def pause(self, epoch: int) -> int:
        token = m.pause_token(epoch, next(self._pauses))
        if (memory := self._memory) is not None:
            memory.ints[m.PAUSE] = token
        return token

    def resume(self, token: int) -> None:
        if (memory := self._memory) is not None:
            memory.ints[m.RESUME] = token

    def heartbeat(self) -> None:
        memory, loop = self._memory, self._loop
        if memory is None or loop is None or self._lost is not None:
            return
        now = time.monotonic()
        memory.times[m.HEARTBEAT] = now
        if not self._in_real_time:
            return
        alive = memory.times[m.ALIVE]
        # A gap between our own beats (a paused machine) says nothing about the robot process.
        if alive != self._alive or now - self._beaten > 1.0:
            self._alive, self._alive_since = alive, now
        elif now - self._alive_since > ANSWER_LIMIT:
            loop.call_soon_threadsafe(self._lose, f"The robot process has been silent for {ANSWER_LIMIT:.0f} s.")
        self._beaten = now

    def drive(self, twist: Twist, epoch: int) -> None:
        velocities = (twist.vx, twist.vy, twist.wz)
        box = self._running(*velocities).drive
        with self._writing:
            box.scratch["epoch"], box.scratch["twist"] = epoch, velocities
            box.put()

    def go(self, goal: Pose, epoch: int) -> int:
        box = self._running(*_numbers(goal)).goal
        with self._writing:
            ticket = int(box.scratch["ticket"]) + 1
            box.scratch["epoch"], box.scratch["ticket"], box.scratch["pose"] = epoch, ticket, _numbers(goal)
            box.put()
        return ticket

    def move_arm(self, joints: Sequence[float], epoch: int, *, speed: float = 1.0) -> None:
        box = self._running(*joints, speed).arm
        with self._writing:
            box.scratch["epoch"], box.scratch["joints"], box.scratch["speed"] = epoch, tuple(joints), speed
            box.put()

    def set_gripper(self, opening: float, epoch: int) -> None:
        box = self._running(opening).gripper
        with self._writing:
            box.scratch["epoch"], box.scratch["opening"] = epoch, opening
            box.put()

    def set_light(self, rgb: tuple[int, int, int], epoch: int) -> None:
        box = self._running(*rgb).light
        with self._writing:
            box.scratch["epoch"], box.scratch["light"] = epoch, rgb
            box.put()

    def beep(self, seconds: float, epoch: int) -> None:
        box = self._running(seconds).buzzer
        with self._writing:
            box.scratch["epoch"], box.scratch["seconds"] = epoch, seconds
            box.put()

    def relocate(self, believed: Pose, true: Pose) -> None:
        """See :meth:`engine.robot.robot.Robot.relocate`; thread-safe. States and pictures are corrected at once."""
        poses = (*_numbers(believed), *_numbers(true))
        box = self._running(*poses).correction
        with self._writing:
            correction = compose(compose(true, inverse(believed)), Pose(*box.scratch["pose"].tolist()))
            box.scratch["pose"] = _numbers(correction)
            box.put()

    # Readings

    def state(self) -> RobotState:
        memory = self._running()
        newest = (memory.state.count, memory.correction.count, memory.ints[m.ESTOP], self._speed_limit)
        if (read := self._read) is not None and read[0] == newest:
            return read[1]  # in one tick many ask
        record = memory.state.get()
        state = _state(record, believed(record, memory.correction.scratch), self._pressed, self._build.battery)
        state = replace(state, speed_limit=self._speed_limit)
        self._read = (newest, state)
        return state

    def scan(self) -> Scan:
        box = self._running().scan
        if not box.count:  # a robot without a lidar
            return Scan(self.state().t, LIDAR_ANGLES, np.full(RAYS, np.inf))
        record = box.get()
        return Scan(float(record["t"]), LIDAR_ANGLES, record["ranges"].copy())

    async def look(self, *, labels: bool = False) -> Picture:
        """See :meth:`engine.robot.robot.Robot.look`; ``labels`` adds the geoms' ids, for debugging."""
        camera = self._open_camera(self._running())
        self._looking += 1
        try:
            return await camera.look(labels=labels)
        finally:
            self._looking -= 1
            if self._exchange_due and not self._looking:
                asyncio.get_running_loop().call_soon(self._exchange)

    def _open_camera(self, memory: Memory) -> Eye:
        if self._build.eye is None:
            raise CameraError("This robot has no camera.")
        if self._camera is None:
            self._camera = self._build.eye(memory, self._on_camera or _ignore)
        return self._camera

    async def tick(self) -> RobotState:
        while (state := await self._next_tick()).paused:
            pass
        return state

    async def _next_tick(self) -> RobotState:
        memory, loop = self._running(), asyncio.get_running_loop()
        waiter: asyncio.Future[None] = loop.create_future()
        self._waiters[waiter] = memory.ints[m.TICKS]
        if self._in_real_time:
            memory.ints[m.WAITERS] = 1
        elif not self._exchange_due:
            # Not at once: whoever else is ready to run may want to command something for this tick, or wait too.
            self._exchange_due = True
            loop.call_soon(self._exchange)
        try:
            await waiter
        finally:
            self._waiters.pop(waiter, None)
        return self.state()

    def _exchange(self) -> None:
        """At full speed: let one tick pass. The loop stands still for it (about a millisecond), which is what makes
        a session at full speed the same at every run. Time also stands still for whoever takes a picture."""
        if self._looking:
            return  # look() comes back to it
        self._exchange_due = False
        process = self._process
        if process is None or self._lost is not None or not self._waiters:
            return
        try:
            process.link.send(b".")
            answered = process.link.recv(1) != b""
        except TimeoutError:
            self._lose(f"The robot process has not answered for {ANSWER_LIMIT:.0f} s.")
            return
        except OSError:
            answered = False
        self._answer(process, answered)

    def _come_to_rest(self) -> None:
        """At full speed: time stands still where nobody waits for it, and after a stop nobody need do. Let the robot
        brake, and not move for ever."""
        if self._lost is None and self._memory is not None and (self._braking is None or self._braking.done()):
            self._braking = asyncio.ensure_future(self._brake())

    async def _brake(self) -> None:
        with contextlib.suppress(RobotError):
            for _ in range(BRAKE_TICKS):
                if not self.state().moving:
                    return
                await self._next_tick()

    def _on_link(self) -> None:
        """In real time: a tick has passed, or the process has ended."""
        process = self._process
        if process is None or self._lost is not None:
            return
        try:
            answered = process.link.recv(4096) != b""
        except BlockingIOError:
            return
        except OSError:
            answered = False
        self._answer(process, answered)

    def _answer(self, process: HostProcess, answered: bool) -> None:
        """Wake those whose tick has come; when the link is closed, tell them that none will come."""
        if not answered:
            self._lose(process.epitaph(wait=1.0) or "The robot process closed its connection.")
            return
        assert self._memory is not None, "a process has memory"
        ints = self._memory.ints
        now = ints[m.TICKS]
        for waiter, after in list(self._waiters.items()):
            if now > after and not waiter.done():
                del self._waiters[waiter]
                waiter.set_result(None)
        if not self._waiters:
            ints[m.WAITERS] = 0

    def _running(self, *values: float) -> Memory:
        """The memory of a living robot, for a command with these values."""
        process, memory = self._process, self._memory
        why = self._lost
        if why is None and process is not None:
            why = process.epitaph()  # the loop may not have heard of it yet
        if why is not None or memory is None:
            raise RobotError(why or "The robot is gone.", hint=_AGAIN)
        if not all(math.isfinite(value) for value in values):
            raise ValueError(f"{values} is nothing a robot can be told: a value is not finite")
        return memory

    def _lose(self, why: str) -> None:
        """From now on there is no robot; tell everybody who waits for it."""
        if self._lost is not None:
            return
        self._lost = why
        process, loop = self._process, self._loop
        if process is not None and loop is not None and self._in_real_time and not loop.is_closed():
            loop.remove_reader(process.link)
        waiters, self._waiters = self._waiters, {}
        for waiter in waiters:
            if not waiter.done():
                waiter.set_exception(RobotError(why, hint=_AGAIN))


def _numbers(pose: Pose) -> tuple[float, float, float]:
    return pose.x, pose.y, pose.yaw


def _ignore(news: CameraNews) -> None:
    """Nobody wants to know."""


def _battery(volts: float, battery: Battery | None) -> BatteryState | None:
    if battery is None or not volts:
        return None
    return BatteryState(round(volts, 1), battery.charge(volts), volts < battery.low)


def _going(record: Record) -> Going | None:
    if not record["going"]:
        return None
    how: Any = record["going_how"].item().decode()
    why = record["going_why"].item().decode(errors="replace")
    return Going(int(record["going"]), how, float(record["going_left"]), int(record["going_code"]), why)


def _state(record: Record, pose: Pose, estop: bool, battery: Battery | None) -> RobotState:
    halted = record["halted"].item().decode() or None
    return RobotState(
        t=float(record["t"]),
        epoch=int(record["epoch"]),
        pose=pose,
        twist=Twist(*record["twist"].tolist()),
        command=Twist(*record["command"].tolist()),
        joints=tuple(record["joints"].tolist()),
        joint_targets=tuple(record["joint_targets"].tolist()),
        gripper=float(record["gripper"]),
        grip=float(record["grip"]),
        light=tuple(record["light"].tolist()),
        blocked=record["blocked"].item().decode() or None,
        halted=halted,
        halted_in=int(record["halted_in"]) if halted else None,
        paused=bool(record["paused"]),
        paused_s=float(record["paused_s"]),
        estop=estop,
        battery=_battery(float(record["volts"]), battery),
        going=_going(record),
        arm_fault=record["arm_fault"].item().decode(errors="replace"),
    )
