"""A busy machine for benchmarks: processes that multiply matrices and walk through Python objects, as a planner and a
screen would, and a recogniser that never stops."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

import numpy as np

from config import load
from engine.audio.wav import read_wav
from engine.parts.loading import make_isolated_recogniser
from engine.scheduling import prefer

_WORK = """
import numpy as np
a = np.random.default_rng(0).random((256, 256), dtype=np.float32)
while True:
    a = a @ a
    a /= np.abs(a).max()
    sum(len(str(i)) for i in range(2000))
"""


@contextlib.contextmanager
def busy_machine(processes: int) -> Iterator[None]:
    """Keep ``processes`` processes busy until the block ends."""
    env = {**os.environ, "OPENBLAS_NUM_THREADS": "2", "OMP_NUM_THREADS": "2"}
    working = [subprocess.Popen([sys.executable, "-c", _WORK], env=env) for _ in range(processes)]
    try:
        yield
    finally:
        for process in working:
            process.kill()
        for process in working:
            process.wait()


@contextlib.contextmanager
def busy_recogniser(*, prompt: bool) -> Iterator[None]:
    """Decode speech all the time, as an engine does, until the block ends: a thread of this process waits for a
    recogniser in another. ``prompt``: with the priority that an engine gives that thread (``engine.scheduling``)."""
    recogniser = make_isolated_recogniser(load())
    recogniser.load()
    speech = read_wav(Path(str(files("assets") / "speech" / "go_to_the_bedroom_then_turn_around.wav")))
    samples = (speech / 32768).astype(np.float32)
    done = threading.Event()

    def recognise() -> None:
        if prompt:
            prefer()
        while not done.is_set():
            recogniser.transcribe(samples)

    thread = threading.Thread(target=recognise, name="busy")
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()
        recogniser.close()
