"""Errands that are interrupted: the robot stands, what it says it holds is what is between its fingers, and the next
request begins there. Once through a whole engine, and once in the hand, for the ticks in which the fingers take hold
and let go."""

from __future__ import annotations

import asyncio
import math
import queue
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import yaml

from config import load
from engine import events
from engine.commands import Interrupt, Quit, Say
from engine.engine import Engine
from engine.events import Event
from engine.parts.loading import Sound
from engine.perception.memory import WorldMemory
from engine.robot.geometry import Pose
from engine.robot.host.memory import Memory
from engine.robot.sim.scene import Scene
from engine.robot.sim.world import World
from engine.skills.hand import still_held
from engine.skills.library.manipulation import pick_object, place_in_bin
from tests.sim.inhand import SQUEEZED_N, HandRobot, context_of, pressed_by

DEADLINE_S = 30.0
ROOM: dict[str, Any] = {
    "name": "a room to clean",
    "bounds": {"x": [-1.5, 1.5], "y": [-1.4, 1.4]},
    "start": {"x": -0.5, "y": -0.2, "yaw": 0},
    "rooms": {"den": {"x": [-1.5, 1.5], "y": [-1.4, 1.4]}},
    "furniture": {"bin": {"kind": "bin", "at": [-1.2, 1.1], "size": [0.3, 0.3, 0.2]}},
    "objects": {
        "blue box": {"kind": "box", "at": [0.3, -0.5], "size": 0.04, "colour": "blue"},
        "red cup": {"kind": "cup", "at": [0.5, 0.5], "size": 0.08, "colour": "red", "mass": 0.08},
        "green box": {"kind": "box", "at": [-0.2, 0.7], "size": 0.04, "colour": "green"},
    },
}


class Running:
    """An engine, what it tells, and the truth of its physics."""

    def __init__(self, engine: Engine, settings: Any) -> None:
        self._engine, self._settings = engine, settings
        self._scene = Scene.model_validate(ROOM)
        self._queue: queue.SimpleQueue[Event] = queue.SimpleQueue()
        self.seen: list[Event] = []
        engine.subscribe(self._queue.put)

    def until(self, met: Callable[[events.Body], object]) -> events.Body:
        while True:
            self.seen.append(self._queue.get(timeout=DEADLINE_S))
            if met(self.seen[-1].body):
                return self.seen[-1].body

    def say(self, text: str) -> None:
        self._engine.send(Say(text))

    def interrupt(self) -> None:
        self._engine.send(Interrupt())

    def over(self) -> events.TurnResult:
        body = self.until(is_over)
        assert isinstance(body, events.StateChanged)
        assert body.result is not None
        return body.result

    @property
    def pose(self) -> Pose:
        return self.world().true_pose

    @property
    def stands(self) -> bool:
        """Whether the base has been told to."""
        memory: Memory = self._engine._robot.memory  # type: ignore[attr-defined]
        return not np.any(memory.state.get()["command"])

    @property
    def remembered(self) -> str | None:
        held = self._engine.world().held
        return held.name if held is not None else None

    def world(self) -> World:
        memory: Memory = self._engine._robot.memory  # type: ignore[attr-defined]
        return World(self._scene, self._settings.robot, memory.state.get())

    def between_the_fingers(self) -> str | None:
        """By the truth of physics."""
        world = self.world()
        mujoco.mj_forward(world.model, world.data)
        return next((name for name in self._scene.objects if pressed_by(world, name) > SQUEEZED_N), None)

    def where(self, name: str) -> tuple[float, float, float]:
        x, y, z = self.world().data.body(name).xpos.tolist()
        return x, y, z


@contextmanager
def a_room_to_clean(folder: Path) -> Iterator[Running]:
    file = folder / "room.yaml"
    file.write_text(yaml.safe_dump(ROOM, sort_keys=False), "utf-8")
    told = [f"robot.scene={file}", "robot.speed=max", "session.record_log=false", f"asr.model={folder / 'none'}"]
    settings = load(overrides=told, environ={}, user_folder=folder / "none")
    engine = Engine(settings, mode="test", sound=Sound("none"))
    running = Running(engine, settings)
    engine.start()
    try:
        running.until(
            lambda body: isinstance(body, events.Log) and body.source == "robot" and body.message.startswith("ready")
        )
        yield running
    finally:
        engine.send(Quit())
        assert engine.join(DEADLINE_S)


def is_over(body: events.Body) -> bool:
    return isinstance(body, events.StateChanged) and body.result is not None


def reports(body: events.Body) -> bool:
    return is_over(body) or isinstance(body, events.RobotStateView)


NEAR = {"kind": "box", "at": [0.0, -0.2], "size": 0.04, "colour": "blue"}
MOMENTS = {
    "started": "clean the room",
    "looking": "clean the room",
    "gripping": "pick up the blue box and put it in the bin",
    "holding": "put all red things in the bin",
    "carrying": "clean the room",
}
"""When it is interrupted, and what it does then; searching the whole room is the longest part of it."""


def wait_for(room: Running, moment: str) -> None:
    """Until the errand is so far; one that ends before is a failure."""
    room.until(lambda body: isinstance(body, events.ActionStarted))
    if moment == "looking":
        room.until(lambda body: isinstance(body, events.ActionProgress))
    if moment in ("gripping", "holding", "carrying"):
        room.until(lambda body: isinstance(body, events.ActionProgress) and "gripping" in body.message)
    if moment in ("holding", "carrying"):
        room.until(lambda body: is_over(body) or room.remembered is not None)
    if moment == "carrying":
        room.until(reports)
    assert not is_over(room.seen[-1].body), f"it was over before it was {moment}"


def test_an_errand_can_be_interrupted_at_any_moment_and_what_is_held_is_known(tmp_path: Path) -> None:
    put_away = 0
    with a_room_to_clean(tmp_path) as room:
        for moment, errand in MOMENTS.items():
            room.say(errand)
            wait_for(room, moment)
            room.interrupt()
            assert room.over().outcome == "interrupted"
            told = [event.body for event in room.seen if isinstance(event.body, events.ActionFinished)][-1]
            before = room.pose
            room.say("wait 1 second")  # or the clock of a simulation at full speed would stand as well
            assert room.over().outcome == "done"
            assert room.stands
            assert before.distance_to(room.pose) < 0.05, (moment, before, room.pose)  # it brakes from 0.5 m/s at most
            true = room.between_the_fingers()
            assert room.remembered == true, (moment, told)
            assert told.outcome == "interrupted"
            assert (f"holding the {true}" in told.message) == (true is not None), told.message
            if moment in ("holding", "carrying"):
                assert true is not None, moment
            if true is None:
                continue
            into = put_away == 0  # else there would soon be nothing left to clean away
            room.say("put it in the bin" if into else "put it down")
            assert room.over().outcome == "done"
            put_away += into
            x, y, z = room.where(true)
            assert room.remembered is None
            assert z < (0.2 if into else 0.05)
            assert (math.hypot(x + 1.2, y - 1.1) < 0.2) == into
    started = Counter(event.body.action for event in room.seen if isinstance(event.body, events.ActionStarted))
    finished = Counter(event.body.action for event in room.seen if isinstance(event.body, events.ActionFinished))
    assert started == finished
    assert set(finished.values()) == {1}


@pytest.mark.parametrize(
    ("told", "closing", "late", "held"),
    [(0.94, True, 6, False), (0.52, True, 0, True), (0.56, False, 0, True), (0.7, False, 6, False)],
    ids=["in the air", "just touched", "loosened", "let go"],
)
def test_fingers_that_are_stopped_half_way_hold_what_they_press_on(
    told: float, closing: bool, late: int, held: bool
) -> None:
    """The fingers are stopped when they have been told ``told``; at 0.59 they touch the box. The robot obeys a stop at
    once, and what it did is cancelled ``late`` ticks after it."""

    async def test() -> None:
        robot, memory = HandRobot(Scene.model_validate({**ROOM, "objects": {"blue box": NEAR}})), WorldMemory()
        context = context_of(robot, memory)
        picking = pick_object.run(context, "blue box")
        if not closing:
            await picking
        errand = asyncio.ensure_future(picking if closing else place_in_bin.run(context))
        stopped: list[float] = []

        def stop() -> None:
            low = robot.arm.grip(robot.state().joints).point[2] < 0.05
            now = robot.world.arm.grip_target
            reached = low and now <= told if closing else now >= told
            if reached and not stopped:
                stopped.append(robot.world.t)
                robot.stop(2)
            if stopped and robot.world.t - stopped[0] >= 0.02 * late - 0.001:
                errand.cancel()

        robot.each_tick = stop
        with pytest.raises(asyncio.CancelledError):
            await errand
        for _ in range(50):
            await robot.tick()
        assert (memory.held is not None) == held == still_held(context)
        assert (pressed_by(robot.world, "blue box") > SQUEEZED_N) == held

    asyncio.run(test())
