"""``sayso engine`` in a process of its own: commands in, events out, in real time."""

from __future__ import annotations

import json
import subprocess
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import psutil

from tests.e2e.sayso import command, environment


class Engine:
    """``sayso engine`` in a process of its own."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self.process = process
        self._sending = threading.Lock()
        self.seen: list[dict[str, Any]] = []

    def until_loaded(self, *more: str) -> None:
        """Wait for the robot and the recogniser, and ``more``: while models load, a busy machine can starve the
        heartbeat."""
        waited = {"robot", "recogniser", *more}
        while waited:
            waited.discard(self.until("log")["source"])

    def send(self, **words: Any) -> None:
        """Thread-safe."""
        assert self.process.stdin is not None
        with self._sending:
            self.process.stdin.write(json.dumps(words).encode() + b"\n")
            self.process.stdin.flush()

    def each(self) -> Iterator[dict[str, Any]]:
        """The events that are still to come, to the end."""
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.seen.append(json.loads(line))
            yield self.seen[-1]

    def until(self, kind: str, met: Callable[[dict[str, Any]], object] = lambda body: True) -> dict[str, Any]:
        """Read events until one of this kind meets the condition; its body."""
        for event in self.each():
            if event["kind"] == kind and met(event["body"]):
                body: dict[str, Any] = event["body"]
                return body
        raise AssertionError(f"ended without {kind}: {[event['kind'] for event in self.seen]}")

    def rest(self) -> list[dict[str, Any]]:
        """All events to the end."""
        assert self.process.stdout is not None
        self.seen += [json.loads(line) for line in self.process.stdout]
        return self.seen


@contextmanager
def engine(
    state: Path,
    before: str = "",
    *options: str,
    environ: Mapping[str, str] | None = None,
    source: str = "none",
    below: Callable[[list[str]], list[str]] = list,
) -> Iterator[Engine]:
    """A running engine, of which nothing is left afterwards; ``options`` go before the verb. ``below`` makes its
    command line one that runs it below something else."""
    argv = below(command(*options, "engine", "--json", "--source", source, before=before))
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(argv, env=environment(state, environ), **pipes) as process:  # type: ignore[call-overload]
        children: list[psutil.Process] = []
        try:
            yield Engine(process)
            if process.poll() is None:
                children = psutil.Process(process.pid).children(recursive=True)
        finally:
            process.kill()
    assert psutil.wait_procs(children, timeout=10)[1] == []
