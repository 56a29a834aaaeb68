"""The robot process: ``python -m engine.robot.sim.physics``, started by :class:`engine.robot.sim.robot.SimRobot`.

In real time it steps every 2 ms against absolute deadlines; the first thing of every step is the stop stamp, the
second the heartbeat. At full speed it stands still until the engine asks for the next tick over a socket, so that
time passes only while somebody waits for it. Either way it ends when the socket closes or its parent is gone.
"""

from __future__ import annotations

import argparse
import os
import signal
import socket
import sys
import time
from pathlib import Path

from config.schema import Robot as RobotSettings
from engine.errors import SaysoError
from engine.robot.robot import Twist
from engine.robot.sim import memory as m
from engine.robot.sim.build import TIMESTEP
from engine.robot.sim.memory import Mailbox, Memory
from engine.robot.sim.scene import load_scene
from engine.robot.sim.scheduling import as_word, quiet_memory, raise_priority
from engine.robot.sim.world import World

TICK_STEPS = 10
"""Physics steps per tick (20 ms)."""
DEBT = 0.05
"""s that real time may run ahead before the simulation stops trying to catch up."""


class Firmware:
    """Between shared memory and the world: takes stops, heartbeats and commands, publishes readings."""

    def __init__(self, memory: Memory, world: World, settings: RobotSettings) -> None:
        self._memory = memory
        self._world = world
        self._silence = settings.heartbeat_s if settings.speed == "real" else float("inf")
        self._epoch = memory.ints[m.STOP_EPOCH]
        self._halted = ""
        self._stopping = False
        self._seen = {box: box.count for box in (memory.drive, memory.arm, memory.gripper, memory.signal)}
        self._scanned = -1.0

    def step(self, now: float) -> None:
        """One physics step; ``now`` is ``time.monotonic()``."""
        memory = self._memory
        epoch = memory.ints[m.STOP_EPOCH]
        if epoch != self._epoch:
            self._world.stop()
            memory.times[m.ZERO_TIME] = time.monotonic()
            memory.ints[m.STOPPED_EPOCH] = self._epoch = epoch
            self._stopping = True
            self.publish()
        self._watch(now, memory.times[m.HEARTBEAT])
        if not self._halted:
            self._take_commands()
        self._world.step()
        if self._stopping and self._world.at_rest:
            memory.times[m.REST_TIME] = time.monotonic()
            self._stopping = False

    def publish(self) -> None:
        """Show the readings of now."""
        world, box = self._world, self._memory.state
        world.fill(box.scratch)
        box.scratch["epoch"] = self._epoch
        box.scratch["halted"] = self._halted.encode()
        box.put()
        if world.scan_time != self._scanned:
            self._scanned = world.scan_time
            scan = self._memory.scan
            scan.scratch["t"], scan.scratch["ranges"] = world.scan_time, world.ranges
            scan.put()

    def _watch(self, now: float, heartbeat: float) -> None:
        """Halt while the engine is silent. What it had commanded is void: only a new command moves the robot again."""
        silent = heartbeat > 0 and now - heartbeat > self._silence
        if silent and not self._halted:
            self._world.stop()
            self._halted = "heartbeat lost"
            self.publish()
        elif self._halted and not silent:
            for box in (self._memory.drive, self._memory.arm, self._memory.gripper):
                self._seen[box] = box.count
            self._halted = ""
            self.publish()

    def _take_commands(self) -> None:
        memory, world = self._memory, self._world
        if (box := memory.drive).count != self._seen[box]:
            record = box.get()
            if self._is_ours(box, record):
                world.drive(Twist(*record["twist"].tolist()))
        if (box := memory.arm).count != self._seen[box]:
            record = box.get()
            if self._is_ours(box, record):
                world.move_arm(record["joints"].tolist(), float(record["speed"]))
        if (box := memory.gripper).count != self._seen[box]:
            record = box.get()
            if self._is_ours(box, record):
                world.grip(float(record["opening"]))
        if (box := memory.signal).count != self._seen[box]:
            self._seen[box] = box.count
            record = box.get()
            red, green, blue = record["light"].tolist()
            world.signal((red, green, blue), float(record["beep"]))

    def _is_ours(self, box: Mailbox, record: m.Record) -> bool:
        """Whether a command is of the epoch in force. One of a coming epoch is left for when its stop has arrived:
        the stop stamp was read before, so both may have come in between."""
        if record["epoch"] != self._epoch:
            return False
        self._seen[box] = box.count
        return True


def run_in_real_time(memory: Memory, firmware: Firmware, link: socket.socket) -> None:
    """Step every 2 ms until the engine closes the link."""
    ints, times, loop = memory.ints, memory.times, memory.loop
    parent = os.getppid()
    link.setblocking(False)
    step, deadline = 0, time.monotonic()
    while not ints[m.QUIT]:
        deadline += TIMESTEP
        wait = deadline - time.monotonic()
        if wait > 0:
            time.sleep(wait)
        now = time.monotonic()
        late = now - deadline
        if late > DEBT:
            ints[m.OVERRUNS] += 1
            deadline = now
        firmware.step(now)
        times[m.ALIVE] = now
        step += 1
        if step % TICK_STEPS == 0:
            firmware.publish()
            ints[m.TICKS] += 1
            if not _still_linked(link, wake=ints[m.WAITERS] != 0) or os.getppid() != parent:
                return
        loop[step % m.LOOP_SAMPLES] = (late, time.monotonic() - now)
        ints[m.STEPS] = step


def run_on_demand(memory: Memory, firmware: Firmware, link: socket.socket) -> None:
    """Step one tick per request until the engine closes the link."""
    link.setblocking(True)
    while link.recv(1):
        for _ in range(TICK_STEPS):
            firmware.step(time.monotonic())
        firmware.publish()
        memory.ints[m.TICKS] += 1
        link.send(b".")


def _still_linked(link: socket.socket, *, wake: bool) -> bool:
    """Whether the engine holds its end; wakes those who wait for a tick."""
    try:
        if wake:
            link.send(b".")
        return link.recv(1) != b""
    except BlockingIOError:
        return True  # nothing to read, or an engine that reads slowly: both are fine
    except OSError:
        return False


def main(argv: list[str]) -> int:
    """Build the world, say so, and run it."""
    parser = argparse.ArgumentParser(prog="python -m engine.robot.sim.physics", description="Internal to sayso.")
    for name in ("memory", "link"):
        parser.add_argument(f"--{name}", type=int, required=True, help="an inherited file descriptor")
    parser.add_argument("--scene", type=Path, required=True)
    parser.add_argument("--settings", required=True, help="settings of the robot, JSON")
    args = parser.parse_args(argv)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the engine's business: it stops us when it is done
    settings = RobotSettings.model_validate_json(args.settings)
    memory = Memory(args.memory)
    try:
        world = World(load_scene(args.scene), settings)
    except SaysoError as error:
        print(error, file=sys.stderr)  # noqa: T201 - SimRobot puts our stderr into its own error
        return int(error.exit_code)
    firmware = Firmware(memory, world, settings)
    with socket.socket(fileno=args.link) as link:
        if settings.speed == "real" and settings.realtime_priority:
            memory.ints[m.SCHEDULING] = as_word(raise_priority())
        quiet_memory()
        firmware.publish()
        memory.times[m.ALIVE] = time.monotonic()
        memory.ints[m.READY] = 1
        link.send(b".")
        if settings.speed == "real":
            run_in_real_time(memory, firmware, link)
        else:
            run_on_demand(memory, firmware, link)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
