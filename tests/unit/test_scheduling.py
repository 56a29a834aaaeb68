"""Who goes before others, and that nobody inherits it."""

from __future__ import annotations

import os
import subprocess
import sys
import threading

import pytest

from engine.scheduling import prefer, workers

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere only whole processes have a niceness")


def niceness() -> int:
    return os.getpriority(os.PRIO_PROCESS, threading.get_native_id())


def niceness_of_a_child() -> int:
    return int(subprocess.run([sys.executable, "-c", "import os; print(os.nice(0))"], capture_output=True).stdout)


def test_workers_are_preferred_if_they_are_prompt_and_what_they_start_is_not() -> None:
    usual = niceness()
    with workers("prompt", 1, prompt=True) as prompt, workers("patient", 1, prompt=False) as patient:
        allowed = prompt.submit(prefer).result()
        assert (prompt.submit(niceness).result() < usual) == allowed
        assert prompt.submit(niceness_of_a_child).result() in (0, usual)
        assert patient.submit(niceness).result() == usual
        assert niceness() == usual, "only the workers"
