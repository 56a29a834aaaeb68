"""A recorded session in the console, without an engine: ``python -m tests.tui.replay FILE [--speed 4]``.

Any session's log will do (``sayso config path`` says where they are). What events do not tell stays away: what the
lidar and the camera saw, and what the robot remembers of things. The map is that of the scene which the recording
names, its parts are as ready as the log says. Keys do nothing to a past that is told as it was.
"""

from __future__ import annotations

import argparse
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import get_args

from config import load
from config.schema import Place
from engine import events as ev
from engine.commands import Command, Quit
from engine.handle import PartName, PartStatus
from engine.robot.geometry import Pose, Twist
from engine.robot.robot import RobotState
from engine.robot.sim.floor import floor_map
from engine.robot.sim.scene_file import load_scene, scene_path
from tests.tui.scripted import ScriptedEngine

RECORDINGS = Path(__file__).parent / "recordings"
SCENE = "flat"
LOADED: tuple[PartName, ...] = ("robot", "microphone", "recogniser", "planner")
"""Parts that load in every session."""


def read(recording: Path) -> list[ev.Event]:
    """All events of a recording."""
    return [ev.from_json(line) for line in recording.read_text(encoding="utf-8").splitlines()]


class Replay(ScriptedEngine):
    """An engine that tells what another one told."""

    def __init__(self, events: Sequence[ev.Event], scene: str = SCENE) -> None:
        house = load_scene(scene_path(scene))
        super().__init__(parts=[PartStatus(name, "loading") for name in LOADED], floor=floor_map(house))
        self._events = iter(events)
        self._places = house.known_places() or load().places

    def places(self) -> Mapping[str, Place]:
        return self._places

    def until(self, kind: type[ev.Body], met: Callable[..., object] = lambda body: True) -> ev.Event:
        """Tell everything up to an event of this kind for which ``met`` holds."""
        for event in self._events:
            self.tell(event)
            if isinstance(event.body, kind) and met(event.body):
                return event
        raise AssertionError("The recording does not tell that.")

    def tell(self, event: ev.Event) -> None:
        """This event, as it was told then."""
        self.t = event.t
        body = event.body
        if isinstance(body, ev.Log) and body.source in get_args(PartName) and body.level == "info":
            self.part(PartStatus(body.source, "ready"))  # type: ignore[arg-type]
        if isinstance(body, ev.RobotStateView):
            self.robot = _robot_in(body, event.epoch)
        for subscriber in tuple(self._subscribers):
            subscriber(event)

    def part(self, status: PartStatus) -> None:
        """A part is like that now."""
        known = {part.name: part for part in self.parts} | {status.name: status}
        self.parts = tuple(known.values())

    def play_on(self, speed: float, ended: threading.Event) -> None:
        """Tell the rest at this speed, 1 as it was, until ``ended``."""
        before = self.t
        for event in self._events:
            if ended.wait(max(0.0, event.t - before) / speed):
                return
            before = event.t
            self.tell(event)


def _robot_in(body: ev.RobotStateView, epoch: int) -> RobotState:
    pose, twist = Pose(body.pose.x, body.pose.y, body.pose.yaw), Twist(body.twist.vx, body.twist.vy, body.twist.wz)
    return RobotState(
        body.robot_t, epoch, pose, twist, twist, body.arm, body.arm, body.gripper, (0, 0, 0), body.blocked, None
    )


def main() -> int:
    from tui.app import run_console

    parser = argparse.ArgumentParser(prog="python -m tests.tui.replay", description="A recorded session, shown again.")
    parser.add_argument("recording", type=Path, help="a session's log")
    parser.add_argument("--speed", type=float, default=1.0, help="how many times as fast as it was")
    parser.add_argument("--scene", default=SCENE, help="whose map is shown")
    arguments = parser.parse_args()
    replay, ended = Replay(read(arguments.recording), arguments.scene), threading.Event()

    def end(command: Command) -> None:
        if isinstance(command, Quit):
            ended.set()

    def start(dress: object) -> Replay:
        replay.on_command = end
        threading.Thread(target=replay.play_on, args=(arguments.speed, ended), daemon=True).start()
        return replay

    return run_console(start)


if __name__ == "__main__":
    sys.exit(main())
