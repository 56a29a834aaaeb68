"""A zenoh router in a process of its own, for tests: ``python -m tests.zenoh_router PORT``, and a peer behind it that
promises everything and does nothing: ``python -m tests.zenoh_router PORT --idle``. Both say so in a line when they are
ready, and end when their input does."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

SERVICE = "/never"
ACTION = "/endless"


class Child:
    """One of the two, started by a test."""

    def __init__(self, port: int, *options: str) -> None:
        command = [sys.executable, "-m", "tests.zenoh_router", str(port), *options]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == b"ready\n"

    def kill(self) -> None:
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()

    @contextmanager
    def stopped(self) -> Iterator[None]:
        """It holds its connections and does nothing."""
        os.kill(self._process.pid, signal.SIGSTOP)
        try:
            yield
        finally:
            os.kill(self._process.pid, signal.SIGCONT)


class Router:
    """A router that can go away and come back."""

    def __init__(self) -> None:
        with socket.socket() as found:
            found.bind(("127.0.0.1", 0))
            self.port: int = found.getsockname()[1]
        self.locator = f"tcp/127.0.0.1:{self.port}"
        self.child: Child | None = None

    def start(self) -> None:
        assert self.child is None
        self.child = Child(self.port)

    def kill(self) -> None:
        child, self.child = self.child, None
        if child is not None:
            child.kill()


def session(port: int, mode: str) -> Any:
    """A session of zenoh's own, as router or client."""
    import zenoh

    config = zenoh.Config()
    endpoints = "listen/endpoints" if mode == "router" else "connect/endpoints"
    settings = {"mode": mode, endpoints: [f"tcp/127.0.0.1:{port}"], "scouting/multicast/enabled": False}
    for key, value in {**settings, "timestamping/enabled": True}.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


def _main() -> None:
    from engine.ros.zenoh.door import ZenohDoor

    port = int(sys.argv[1])
    if "--idle" in sys.argv:
        door = ZenohDoor(f"tcp/127.0.0.1:{port}", 0, name="idle")
        kept: list[object] = []
        door.serve(SERVICE, "std_srvs/srv/Trigger", lambda request, reply: kept.append(reply))
        door.serve_action(ACTION, "test_msgs/action/Fibonacci", _Endless())
    else:
        router = session(port, "router")
    print("ready", flush=True)
    sys.stdin.read()
    (door if "--idle" in sys.argv else router).close()


class _Endless:
    def begin(self, execution: Any) -> bool:
        return True

    def cancel(self, execution: Any) -> None:
        pass


if __name__ == "__main__":
    _main()
