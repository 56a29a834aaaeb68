"""Somebody beside a robot, who answers what ``sayso robot calibrate`` asks."""

from __future__ import annotations

import signal
import subprocess
from pathlib import Path

from tests.e2e.sayso import command, environment


class Person:
    """Answers what is asked. ``heard`` is all that was said until then, ``found`` what stood on stdout at the end."""

    def __init__(self, state: Path, *arguments: str) -> None:
        self.heard = ""
        self.found = ""
        self._process = subprocess.Popen(
            command("robot", "calibrate", *arguments),
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment(state), text=True,
        )  # fmt: skip

    def asked(self, words: str) -> None:
        """Wait for a question with these words."""
        assert self._process.stderr is not None
        for line in self._process.stderr:
            self.heard += line
            if words in line:
                return
        raise AssertionError(f"nobody asked {words!r}: {self.heard}")

    def answers(self, text: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(f"{text}\n")
        self._process.stdin.flush()

    def ends(self) -> int:
        self.found, said = self._process.communicate()
        self.heard += said
        return self._process.returncode

    def is_interrupted(self) -> int:
        """Ctrl-C, and the exit code."""
        self._process.send_signal(signal.SIGINT)
        return self.ends()
