"""Who goes before others, and that nobody inherits it."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

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


def niceness_of_the_session() -> int:
    return int(Path("/proc/self/autogroup").read_text().rpartition(" ")[2])


def in_a_session_of_its_own(program: str) -> list[int]:
    """What it prints of its session's niceness; ours stays as it is."""
    program = f"""
from pathlib import Path
from engine.scheduling import preferred_session
from tests.unit.test_scheduling import niceness_of_the_session
{program}"""
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, start_new_session=True, check=True)
    return [int(word) for word in ran.stdout.split()]


@pytest.mark.skipif(not Path("/proc/self/autogroup").exists(), reason="this kernel does not know sessions")
def test_a_session_is_preferred_as_long_as_somebody_wants_that() -> None:
    told = in_a_session_of_its_own(
        "with preferred_session():\n"
        "    print(niceness_of_the_session())\n"
        "    with preferred_session(): pass\n"
        "    print(niceness_of_the_session())\n"
        "print(niceness_of_the_session())"
    )
    assert told[0] == told[1], "it is given back by who took it"
    assert told[2] == 0 >= told[0]


@pytest.mark.skipif(not Path("/proc/self/autogroup").exists(), reason="this kernel does not know sessions")
def test_a_session_that_somebody_made_nice_keeps_that() -> None:
    told = in_a_session_of_its_own(
        "Path('/proc/self/autogroup').write_text('5')\n"
        "with preferred_session(): print(niceness_of_the_session())\n"
        "print(niceness_of_the_session())"
    )
    assert told == [5, 5]
