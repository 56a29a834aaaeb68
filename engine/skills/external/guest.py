"""The program's side of an external skill: a robot over stdin and stdout, so that an ordinary skill function can run.

::

    async def circle(context: SkillContext, seconds: float) -> Result: ...

    if __name__ == "__main__":
        main(circle)

Time passes only in :meth:`GuestRobot.tick`, which waits for the engine's answer; several tasks of a program share one
tick. What the function prints goes to stderr, so that it cannot be taken for a message. When the engine closes its
end the program ends quietly.
"""

from __future__ import annotations

import asyncio
import json
import os
import sys
from collections.abc import Callable, Collection, Coroutine, Sequence
from typing import TYPE_CHECKING, Any, BinaryIO

from engine.errors import RobotError
from engine.perception.memory import WorldMemory
from engine.perception.sighting import EVERYTHING, Part, Sight
from engine.robot.arm import ArmModel
from engine.robot.camera import Picture
from engine.robot.company import Company
from engine.robot.floor_map import FloorMap
from engine.robot.geometry import ZERO, Pose, Twist
from engine.robot.robot import Capability, Footprint, RobotState, Scan
from engine.skills.context import SkillContext
from engine.skills.external.facts import (
    arm_of,
    footprint_of,
    map_of,
    picture_of,
    places_of,
    pose_facts,
    scan_of,
    state_of,
)
from engine.skills.outcome import Result

if TYPE_CHECKING:
    from engine.perception.eyes import Eyes

Function = Callable[..., Coroutine[Any, Any, Result]]


def main(function: Function) -> None:
    """Read the start, run ``function(context, **args)``, tell its result."""
    wire = Wire(os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb"))
    sys.stdout = sys.stderr
    start = wire.hear("start")
    result = asyncio.run(function(_context(wire, start), **start["args"]))
    wire.say(
        result={
            "outcome": result.outcome,
            "error_code": result.error_code,
            "message": result.message,
            "data": dict(result.data),
        }
    )


class Wire:
    """JSON lines to and from the engine."""

    def __init__(self, incoming: BinaryIO, outgoing: BinaryIO) -> None:
        self._incoming, self._outgoing = incoming, outgoing

    def say(self, **message: Any) -> None:
        """Ends the program when nobody listens any more."""
        try:
            self._outgoing.write(json.dumps(message, separators=(",", ":")).encode() + b"\n")
            self._outgoing.flush()
        except BrokenPipeError:
            os._exit(0)  # nothing can be told, and what is buffered can go nowhere

    def hear(self, kind: str) -> Any:
        """Block until the engine says something of this kind; ends the program when it says no more."""
        while line := self._incoming.readline():
            message = json.loads(line)
            if kind in message:
                return message[kind]
        os._exit(0)


def _context(wire: Wire, start: dict[str, Any]) -> SkillContext:
    def progress(
        fraction: float | None, message: str = "", *, path: tuple[tuple[float, float], ...] | None = None
    ) -> None:
        wire.say(progress={"fraction": fraction, "message": message, "path": path})

    async def say(text: str) -> None:
        wire.say(say=text)

    robot, world = GuestRobot(wire, start), WorldMemory()
    eyes: Eyes | None = None

    async def see(parts: Collection[Part] = EVERYTHING) -> Sight:
        from engine.perception.eyes import Eyes  # slow to import, and not every program sees

        nonlocal eyes
        eyes = eyes or Eyes(robot, world)
        return await eyes.see(parts)

    return SkillContext(
        robot=robot,
        epoch=start["epoch"],
        places=places_of(start["places"]),
        say=say,
        progress=progress,
        describe_skills=lambda: "",
        see=see,
        world=world,
    )


class GuestRobot:
    """A :class:`engine.robot.robot.Robot` that the engine drives for us, in the epoch that it started us in."""

    def __init__(self, wire: Wire, start: dict[str, Any]) -> None:
        self._wire = wire
        self._facts = start["robot"]
        self._epoch: int = start["epoch"]
        self._floor_map = map_of(start["map"])
        self._arm = arm_of(self._facts["arm"])
        self._state = state_of(start["state"], self._epoch)
        self._waiters: list[asyncio.Future[RobotState]] = []

    @property
    def name(self) -> str:
        return str(self._facts["name"])

    @property
    def capabilities(self) -> frozenset[Capability]:
        return frozenset(self._facts["capabilities"])

    @property
    def footprint(self) -> Footprint:
        return footprint_of(self._facts["footprint"])

    @property
    def arm(self) -> ArmModel:
        return self._arm

    @property
    def floor_map(self) -> FloorMap:
        return self._floor_map

    @property
    def navigates(self) -> bool:
        """A program drives by itself."""
        return False

    @property
    def company(self) -> Company | None:
        """Who is around hears what the engine says."""
        return None

    async def start(self) -> None:
        """The engine has done that."""

    async def close(self) -> None:
        """The engine does that."""

    def stop(self, epoch: int) -> None:
        """Epochs are the engine's; here it only stands still."""
        self.drive(ZERO, epoch)

    def press(self, pressed: bool) -> None:
        """The emergency stop is people's."""

    def limit_speed(self, share: float) -> None:
        """The speed limit is people's."""

    def pause(self, epoch: int) -> int:
        """Pauses are the engine's: no tick comes meanwhile."""
        del epoch
        return 0

    def resume(self, token: int) -> None:
        """The same."""

    def heartbeat(self) -> None:
        """The engine's own is what counts."""

    def go(self, goal: Pose, epoch: int) -> int:
        """Nobody asks a robot that does not navigate."""
        raise RobotError("A program's robot finds no way by itself.")

    def state(self) -> RobotState:
        return self._state

    def scan(self) -> Scan:
        self._wire.say(scan=True)
        return scan_of(self._wire.hear("scan"))

    async def look(self) -> Picture:
        self._wire.say(look=True)
        return picture_of(self._wire.hear("picture"))

    def relocate(self, believed: Pose, true: Pose) -> None:
        self._wire.say(relocate={"believed": pose_facts(believed), "true": pose_facts(true)})

    def drive(self, twist: Twist, epoch: int) -> None:
        if epoch == self._epoch:
            self._wire.say(drive=[twist.vx, twist.vy, twist.wz])

    def move_arm(self, joints: Sequence[float], epoch: int, *, speed: float = 1.0) -> None:
        if epoch == self._epoch:
            self._wire.say(arm=list(joints), speed=speed)

    def set_gripper(self, opening: float, epoch: int) -> None:
        if epoch == self._epoch:
            self._wire.say(gripper=opening)

    def set_light(self, rgb: tuple[int, int, int], epoch: int) -> None:
        if epoch == self._epoch:
            self._wire.say(light=list(rgb))

    def beep(self, seconds: float, epoch: int) -> None:
        if epoch == self._epoch:
            self._wire.say(beep=seconds)

    async def tick(self) -> RobotState:
        loop = asyncio.get_running_loop()
        waiter: asyncio.Future[RobotState] = loop.create_future()
        self._waiters.append(waiter)
        if len(self._waiters) == 1:
            # Not at once: whoever else is ready to run may want to command something for this tick, or wait too.
            loop.call_soon(self._exchange)
        return await waiter

    def _exchange(self) -> None:
        self._wire.say(tick=True)
        self._state = state_of(self._wire.hear("state"), self._epoch)
        waiters, self._waiters = self._waiters, []
        for waiter in waiters:
            if not waiter.done():
                waiter.set_result(self._state)
