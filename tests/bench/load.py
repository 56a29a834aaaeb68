"""A busy machine for benchmarks: processes that multiply matrices and walk through Python objects, as a recogniser,
a planner and a screen would."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from collections.abc import Iterator

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
