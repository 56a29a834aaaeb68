"""The host process: ``python -m engine.robot.host_main``, started by :class:`engine.robot.host.process.HostProcess`."""

from __future__ import annotations

import argparse
import signal
import socket
import sys
import time
from types import FrameType

from config.schema import Robot as RobotSettings
from engine.errors import SaysoError
from engine.robot.bodies import controlled
from engine.robot.host import memory as m
from engine.robot.host.host import Host, run_in_real_time, run_on_demand
from engine.robot.host.memory import Memory
from engine.scheduling import as_word, quiet_memory, raise_priority


def main(argv: list[str]) -> int:
    """Open the body, say so, and run it."""
    parser = argparse.ArgumentParser(prog="python -m engine.robot.host_main", description="Internal to sayso.")
    for name in ("memory", "link"):
        parser.add_argument(f"--{name}", type=int, required=True, help="an inherited file descriptor")
    parser.add_argument("--settings", required=True, help="settings of the robot, JSON")
    args = parser.parse_args(argv)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the engine's business: it stops us when it is done
    settings = RobotSettings.model_validate_json(args.settings)
    memory = Memory(args.memory)
    link = socket.socket(fileno=args.link)

    def terminate(number: int, frame: FrameType | None) -> None:
        memory.ints[m.QUIT] = 1
        link.shutdown(socket.SHUT_RD)  # wakes the loop that waits for a request

    signal.signal(signal.SIGTERM, terminate)
    try:
        controller = controlled(settings, memory.state.get() if memory.state.count else None)
    except SaysoError as error:
        print(error, file=sys.stderr)  # noqa: T201 - the engine puts our stderr into its own error
        return int(error.exit_code)
    host = Host(memory, controller, settings)
    with link:
        if settings.speed == "real" and settings.realtime_priority:
            memory.ints[m.SCHEDULING] = as_word(raise_priority())
        quiet_memory()
        host.publish()
        memory.times[m.ALIVE] = time.monotonic()
        memory.ints[m.READY] = 1
        link.send(b".")
        if settings.speed == "real":
            run_in_real_time(memory, host, link)
        else:
            run_on_demand(memory, host, link)
    controller.body.close()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
