"""What processes that use PortAudio do around it."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from engine.audio.portaudio import unlock_jack

LIMIT_S = 20
USER = os.getuid()


@pytest.fixture
def memory() -> Iterator[Path]:
    """Stands for /dev/shm, after a process has died that had JACK's data base open; its own name is short enough for a
    socket."""
    with TemporaryDirectory(prefix="jack") as folder:
        for user in (USER, USER + 1):
            (Path(folder) / f"jack_db-{user}").mkdir()
            (Path(folder) / f"jack_db-{user}" / "__db.001").touch()
        yield Path(folder)


def test_a_data_base_without_a_server_goes(memory: Path) -> None:
    unlock_jack(memory)
    unlock_jack(memory)
    assert [file.name for file in memory.iterdir()] == [f"jack_db-{USER + 1}"]


@pytest.mark.parametrize("server", ["default", "studio"])
def test_that_of_a_server_stays(memory: Path, server: str) -> None:
    with closing(socket.socket(socket.AF_UNIX)) as listening:
        listening.bind(str(memory / f"jack_{server}_{USER}_0"))
        listening.listen()
        unlock_jack(memory)
        assert (memory / f"jack_db-{USER}" / "__db.001").exists()
    unlock_jack(memory)  # the server has been killed; its socket is still there
    assert not (memory / f"jack_db-{USER}").exists()


def test_the_process_ends_with_the_engine_while_a_driver_hangs() -> None:
    ours, theirs = socket.socketpair()
    hanging = (
        "import signal, socket; from engine.audio.portaudio import leave_with\n"
        f"link = socket.socket(fileno={theirs.fileno()}); leave_with(link); link.send(b'.'); signal.pause()"
    )
    with closing(ours), subprocess.Popen([sys.executable, "-c", hanging], pass_fds=[theirs.fileno()]) as process:
        theirs.close()
        try:
            assert ours.recv(1) == b"."
            ours.close()
            assert process.wait(LIMIT_S) == 0
        finally:
            process.kill()
