"""Runs a trial: a whole engine without a screen, a request as somebody would type it, and a witness of the truth.

The witness reads the robot's shared memory, which no skill can, some eight times in a second of robot time. At the end
the world is let come to rest in a copy of it, because a thing that is still falling lies nowhere yet.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import msgspec
import numpy as np
import yaml

from config import load
from config.schema import Settings
from engine import events
from engine.commands import Interrupt, Quit, Say
from engine.engine import Engine
from engine.events import Event
from engine.parts.loading import Sound
from engine.robot.geometry import Pose
from engine.robot.host.memory import Memory
from engine.robot.sim.world import World
from tests.eval.checker import Done, Evidence, Sample, faults
from tests.eval.tasks import Trial
from tests.rosbridge import free_port

SAMPLE_S = 0.12
"""Robot time between two samples."""
SETTLE_S = 1.0
"""How long things may go on falling, robot time."""
PATIENCE_S = 60.0
"""Wall time in which an engine must start or end, or a robot that is not told to wait must move its clock."""
_LOOK_S = 0.003


@dataclass(frozen=True, slots=True)
class Verdict:
    """What became of a trial."""

    kind: str
    seed: int
    ok: bool
    reason: str  # empty when ok
    robot_s: float
    wall_s: float


Through = Literal["host", "board", "ros", "nav2", "rclpy"]
"""What a robot is driven through: its host alone, the frames of an emulated motor board, or a bridge of ROS 2: by
velocities (ros), or where it finds its way itself (nav2), the same with a node of rclpy behind a published rosbridge
(rclpy; SAYSO_ROSBRIDGE names its folder)."""
ROS_MODEL = Path(__file__).with_name("ros_robot.yaml")
"""The simulated robot as one of ROS 2, without its arm."""
ROS_ARM_MODEL = Path(__file__).with_name("ros_robot_arm.yaml")
"""The same with arm, gripper and camera."""


def run(trial: Trial, *, speed: str = "max", through: Through = "host") -> Verdict:
    """Perform a trial and judge it."""
    began = time.monotonic()
    with _scene_file(trial) as file, ExitStack() as more:
        options = ["robot.kind=rosmaster", "robot.port=emulated"] if through == "board" else []
        witnessed: Memory | None = None
        if through in ("ros", "nav2", "rclpy"):
            witnessed = Memory.create()
            more.callback(os.close, witnessed.fd)
            is_node, navigates = through == "rclpy", through == "nav2"
            behind = _node(file, witnessed) if is_node else _peer(file, witnessed, navigates=navigates)
            model = ROS_ARM_MODEL if is_node else ROS_MODEL
            options = ["robot.kind=ros2", f"robot.model={model}", f"robot.door={more.enter_context(behind)}"]
        evidence = _perform(trial, _settings(trial, file, speed, options), witnessed)
    found = faults(trial.success, evidence)
    robot_s = evidence.end.t - evidence.start.t
    if found:
        found = (*found, f"{evidence.result}, said: {evidence.words}" if evidence.words else evidence.result)
    return Verdict(trial.kind, trial.seed, not found, "; ".join(found), robot_s, time.monotonic() - began)


@contextmanager
def _peer(scene: Path, memory: Memory, *, navigates: bool) -> Iterator[str]:
    """A robot behind a bridge, which shows in ``memory`` how it really is; the way to it."""
    port = free_port()
    command = [sys.executable, "-m", "tests.ros_peer", str(port), f"--scene={scene}", f"--witness={memory.fd}"]
    command += [] if navigates else ["--no-navigation"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, pass_fds=(memory.fd,)) as process:
        try:
            while not memory.state.count and process.poll() is None:
                time.sleep(_LOOK_S)
            yield f"ws://127.0.0.1:{port}"
        finally:
            process.kill()


@contextmanager
def _node(scene: Path, memory: Memory) -> Iterator[str]:
    """The same of rclpy."""
    from tests.ros.true_robot import TrueRobot
    from tests.ros.ways import ByRosbridge

    way = ByRosbridge()
    robot = TrueRobot(way.surroundings, str(scene), f"/proc/{os.getpid()}/fd/{memory.fd}")
    try:
        while not memory.state.count:
            time.sleep(_LOOK_S)
        yield way.address
    finally:
        robot.program.close()
        way.close()


def _settings(trial: Trial, scene: Path, speed: str, options: list[str]) -> Settings:
    extra = [f"{key}={value}" for key, value in trial.settings.items()]
    fixed = [
        f"robot.scene={scene}",
        f"robot.speed={speed}",
        f"robot.seed={trial.seed}",
        "robot.realtime_priority=false",
        "session.record_log=false",
        "session.turn_limit_s=3600",
        f"asr.model={scene.parent / 'none'}",  # nobody speaks, and loading a recogniser would take longer than a task
    ]
    return load(overrides=[*fixed, *options, *extra], environ={}, user_folder=scene.parent / "none")


@contextmanager
def _scene_file(trial: Trial) -> Iterator[Path]:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{trial.scene.name}.yaml"
        plain = msgspec.to_builtins(trial.scene.model_dump(mode="json"))
        file.write_text(yaml.safe_dump(plain, sort_keys=False), "utf-8")
        yield file


class _Listener:
    """Hears the engine's events."""

    def __init__(self) -> None:
        self.actions: list[Done] = []
        self.result: events.TurnResult | None = None
        self.ready = threading.Event()
        self.over = threading.Event()
        self._lost = ""

    def hear(self, event: Event) -> None:
        match event.body:
            case events.Log(source="robot", message=message) if message.startswith("ready"):
                self.ready.set()
            case events.ActionFinished(name=name, outcome=outcome, error_code=code, data=data):
                self.actions.append(Done(name, outcome, code, data or {}))
            case events.StateChanged(result=events.TurnResult() as result):
                self.result = result
                self.over.set()
            case events.SessionEnded():
                self.over.set()


def _perform(trial: Trial, settings: Settings, witnessed: Memory | None) -> Evidence:
    """``witnessed`` shows how the robot really is; None: its host's memory does."""
    listener = _Listener()
    engine = Engine(settings, mode="bench", sound=Sound("none"))
    engine.subscribe(listener.hear)
    engine.start()
    try:
        if not listener.ready.wait(PATIENCE_S):
            raise RuntimeError("the robot did not start")
        memory: Memory = witnessed or engine._robot.memory  # type: ignore[attr-defined]
        witness = _Witness(memory)
        engine.send(Say(trial.say))
        reason = _watch(trial, engine, listener, witness)
        record = memory.state.get()
        world = World(trial.scene, settings.robot, record, pictures=False)
        for _ in range(round(SETTLE_S / world.model.opt.timestep)):
            world.step()
        samples = [*witness.samples, _sample_of(world)]
        result = listener.result
        return Evidence(
            scene=trial.scene,
            places=engine.places(),
            samples=samples,
            actions=listener.actions,
            result=reason or (result.outcome if result else "no result"),
            words=result.message if result else "",
        )
    finally:
        engine.send(Quit())
        engine.join(PATIENCE_S)


def _watch(trial: Trial, engine: Engine, listener: _Listener, witness: _Witness) -> str:
    """Look on until the turn is over; says why it had to be ended, if it had."""
    reason, limit = "", trial.watch_s or trial.limit_s
    stuck = time.monotonic() + PATIENCE_S
    while not listener.over.wait(_LOOK_S):
        if witness.look():
            stuck = time.monotonic() + PATIENCE_S
        if not reason and (witness.elapsed > limit or time.monotonic() > stuck):
            reason = "watched" if trial.watch_s else "time limit"
            if time.monotonic() > stuck:
                reason = "the robot's clock stood still"
            engine.send(Interrupt())
            stuck = time.monotonic() + PATIENCE_S
        elif reason and time.monotonic() > stuck:
            return "the engine did not end the turn"
    witness.look(always=True)
    return reason


class _Witness:
    def __init__(self, memory: Memory) -> None:
        self._memory = memory
        self.samples: list[Sample] = []
        self.look(always=True)

    @property
    def elapsed(self) -> float:
        return self.samples[-1].t - self.samples[0].t

    def look(self, *, always: bool = False) -> bool:
        """Take a sample, if it is time; whether it was."""
        record: Any = self._memory.state.get()
        if not always and record["t"] - self.samples[-1].t < SAMPLE_S:
            return False
        pose = Pose(*record["true_pose"].tolist())
        self.samples.append(Sample(float(record["t"]), pose, tuple(record["joints"].tolist()), record["qpos"].copy()))
        return True


def _sample_of(world: World) -> Sample:
    qpos = np.asarray(world.data.qpos, dtype=np.float64).copy()
    return Sample(world.t, world.true_pose, tuple(world.arm.joints), qpos)
