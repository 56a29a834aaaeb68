"""A robot behind a rosbridge as a process (:mod:`tests.ros_peer`), as tests and benches have it."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

LIMIT_S = 60.0


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port: int = one.getsockname()[1]
        return port


class Peer:
    """:mod:`tests.ros_peer` as a process."""

    def __init__(self, port: int, *options: str) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.ros_peer", str(port), *options],
            stdout=subprocess.PIPE,
            cwd=Path(__file__).parents[1],
            text=True,
        )

    def __enter__(self) -> Peer:
        self.until(lambda state: True)
        return self

    def __exit__(self, *error: object) -> None:
        self.kill()

    def kill(self) -> None:
        self._process.kill()
        self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()

    def until(self, condition: Any) -> dict[str, Any]:
        """The first state from now on that fulfils this."""
        assert self._process.stdout is not None
        since = time.monotonic()
        over = threading.Timer(LIMIT_S, self._process.kill)
        over.start()
        try:
            for line in self._process.stdout:
                state: dict[str, Any] = json.loads(line)
                if state["at"] >= since and condition(state):
                    return state
        finally:
            over.cancel()
        raise AssertionError("the robot never came to that")
