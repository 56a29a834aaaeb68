"""The guard process of a robot of ROS 2: ``python -m engine.robot.ros2.guard_main``, started by
:class:`engine.robot.host.guard.Guard`. It has a door of its own, and speaks through it only when the host does not.
"""

from __future__ import annotations

import argparse
import select
import signal
import sys
import time

from engine.errors import SaysoError
from engine.robot.description import RosOf
from engine.robot.geometry import ZERO
from engine.robot.host.guard_main import TICK_S, watch
from engine.robot.ros2 import messages
from engine.ros.actions.parts import ALL, CANCEL, cancel_request, cancel_service
from engine.ros.door import Door
from engine.ros.opening import open_door

CANCEL_S = 0.1
"""Between two requests to cancel."""
LAST_WORDS = 150
"""How often it tells the robot to rest before it leaves, in 1.5 s: a goal that was sent last may be taken late."""


class Resting:
    """Brings the robot to rest, each time that it is called."""

    def __init__(self, door: Door, about: RosOf) -> None:
        self._door, self._about = door, about
        self._cancelled_at = 0.0
        door.advertise(about.velocity, messages.velocity_type(about))

    def __call__(self) -> None:
        about, now = self._about, time.monotonic()
        self._door.publish(about.velocity, messages.velocity_type(about), messages.velocity(ZERO, about, time.time()))
        if now - self._cancelled_at <= CANCEL_S:
            return
        self._cancelled_at = now
        for action in (about.navigation, about.arm.trajectory if about.arm is not None else None):
            if action is not None:
                self._door.call(cancel_service(action), CANCEL, cancel_request(ALL), lambda outcome: None)


def _opened(door: Door, link: int) -> bool:
    """Wait until the door is open, for before that this guards nothing; False where the host has ended meanwhile."""
    while door.trouble:
        if select.select([link], [], [], TICK_S)[0]:
            return False
    return True


def main(argv: list[str]) -> int:
    """Watch the host until it is gone or ends; bring the robot to rest whenever nobody else would."""
    parser = argparse.ArgumentParser(prog="python -m engine.robot.ros2.guard_main", description="Internal to sayso.")
    for name in ("memory", "link"):
        parser.add_argument(f"--{name}", type=int, required=True, help="an inherited file descriptor")
    parser.add_argument("--door", required=True, help="the way to the graph")
    parser.add_argument("--about", required=True, help="names of topics and the action, JSON")
    args = parser.parse_args(argv)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # it leaves when the host does
    try:
        door = open_door(args.door, "sayso_guard")
    except SaysoError as error:
        print(error, file=sys.stderr)  # noqa: T201 - the host puts our stderr into its own error
        return int(error.exit_code)
    if not _opened(door, args.link):
        return 0
    watch(args.memory, args.link, Resting(door, RosOf.model_validate_json(args.about)), last_words=LAST_WORDS)
    door.close()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
