"""The simulated robot for :mod:`tests.ros.robot`, in the Python that has the simulation: ``python -m
tests.ros.simulation [SCENE [WITNESS]]``, in JSON lines.

It is told ``{"do": "drive", "twist": [vx, vy, wz]}``, ``{"do": "go", "goal": [x, y, yaw]}`` (map frame) or ``{"do":
"stop"}``; its arm ``{"do": "follow", "number": n, "points": [[seconds, joints], …]}`` or ``{"do": "hold"}``, its
gripper ``{"do": "grip", "number": n, "finger": m}`` or ``{"do": "hold fingers"}``. A velocity holds for LIFETIME_S.

Fifty times a second it tells where odometry has it, how it moves and where its joints are; ten times a second its scan,
what it touches, and the whole state of its world, by which pictures are made (:mod:`tests.ros.photographer`); on a
journey what is left of the way; and how a journey, a trajectory or a grip has ended.
"""

from __future__ import annotations

import math
import os
import queue
import sys
import threading
import time
from typing import Any

from engine.robot.geometry import ZERO, Pose, Twist, compose, inverse
from engine.robot.host.body import STEP_S
from engine.robot.host.memory import Memory
from engine.robot.lidar import LIDAR_ANGLES
from engine.robot.robot import Scan
from engine.robot.sim.dimensions import FOOTPRINT
from engine.robot.sim.floor import floor_map
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_file import load_scene, scene_path
from engine.robot.sim.simulated import SimulatedBody
from tests.pilot import Pilot
from tests.ros.controllers import Controllers
from tests.ros.lines import Line, read, write
from tests.sim.rig import settings

LIFETIME_S = 0.5
TELL_STEPS, SCAN_STEPS = 10, 50
"""Of the simulation: 50 and 10 times a second."""


class Simulation:
    """One robot in a scene. What it really does, ``witness`` shows, the memory of a host."""

    def __init__(self, scene: Scene, witness: Memory | None) -> None:
        self.body = SimulatedBody(scene, settings(), pictures=False)
        self._controllers = Controllers(self.body)
        self._floor = floor_map(scene)
        self._witness = witness
        self._start = self.body.true_pose  # where odometry begins
        self._told, self._told_at = ZERO, -math.inf
        self._pilot: Pilot | None = None

    def live(self, orders: queue.SimpleQueue[Line]) -> None:
        """Let time pass as fast as it does."""
        write({"ready": True, "start": _numbers(self._start)})
        began, steps = time.monotonic(), 0
        while True:
            while steps * STEP_S < time.monotonic() - began:
                while not orders.empty():
                    self._do(orders.get())
                if not self._told.is_zero and self.body.t - self._told_at > LIFETIME_S:
                    self._drive(ZERO)
                self._controllers.step()
                self.body.step()
                steps += 1
                if steps % TELL_STEPS == 0:
                    self._tell(steps % SCAN_STEPS == 0)
            time.sleep(STEP_S)

    def _do(self, line: Line) -> None:
        match line:
            case {"do": "drive", "twist": [vx, vy, wz]}:
                self._drive(Twist(vx, vy, wz))
            case {"do": "go", "goal": [x, y, yaw]}:
                self._pilot = Pilot(self._floor, FOOTPRINT, Pose(x, y, yaw))
            case {"do": "stop"}:
                self._pilot = None
                self._drive(ZERO)
            case {"do": "follow", "number": number, "points": points}:
                self._controllers.follow(number, points)
            case {"do": "hold"}:
                self._controllers.hold()
            case {"do": "grip", "number": number, "finger": finger}:
                self._controllers.grip(number, finger)
            case {"do": "hold fingers"}:
                self._controllers.hold_fingers()

    def _drive(self, twist: Twist) -> None:
        self._told, self._told_at = twist, self.body.t
        self.body.drive(twist)

    def _tell(self, with_scan: bool) -> None:
        scan = self.body.scan() if with_scan or self._pilot is not None else None
        told: dict[str, Any] = {
            "odometry": _numbers(compose(inverse(self._start), self.body.true_pose)),
            "pose": _numbers(self.body.true_pose),
            "twist": [self.body.twist.vx, self.body.twist.vy, self.body.twist.wz],
            "joints": list(self.body.joints),
            "finger": self._controllers.finger,
            **self._controllers.news(),
        }
        if with_scan and scan is not None:
            told["qpos"] = self.body.data.qpos
            told["touching"] = self.body.touching()
            told["scan"] = [value if math.isfinite(value) else None for value in scan.tolist()]
        if self._pilot is not None and scan is not None:
            wanted = self._pilot.guide(self.body.true_pose, Scan(self.body.t, LIDAR_ANGLES, scan))
            if isinstance(wanted, int):
                told["arrived"] = wanted
                self._pilot, wanted = None, ZERO
            else:
                told["left"] = self._pilot.left
            self._drive(wanted)
        write(told)
        if with_scan and self._witness is not None:
            self.body.fill(self._witness.state.scratch)
            self._witness.state.scratch["t"] = self.body.t
            self._witness.state.put()


def _numbers(pose: Pose) -> list[float]:
    return [pose.x, pose.y, pose.yaw]


def main(scene: str = "flat", witness: str = "") -> None:
    memory = Memory(os.open(witness, os.O_RDWR)) if witness else None
    simulation = Simulation(load_scene(scene_path(scene)), memory)
    orders: queue.SimpleQueue[Line] = queue.SimpleQueue()
    threading.Thread(target=simulation.live, args=(orders,), daemon=True).start()
    for line in read():
        orders.put(line)


if __name__ == "__main__":
    main(*sys.argv[1:])
