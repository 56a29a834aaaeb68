"""The robot process from outside: starting it, noticing its end, and what it died of.

It shares an unnamed piece of memory and one socket pair with us, both inherited, so nothing has a name that could
be left over. When either side dies in whatever way, the kernel closes its end of the socket and the other side knows.
The memory belongs to whoever starts the process, and may have served one before.
"""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import tempfile
from pathlib import Path

import engine
from config.schema import Robot as RobotSettings
from engine.errors import RobotError
from engine.robot.sim import memory as m
from engine.robot.sim.memory import Memory

START_LIMIT = 60.0
"""s until the robot process must have built its world."""
_LEAVE_LIMIT = 1.5  # s in which it leaves when asked: it comes to rest first


class RobotProcess:
    """One running robot process. Whoever makes it closes it."""

    def __init__(self, scene: Path, settings: RobotSettings, memory: Memory) -> None:
        """Start the process. Raises :class:`RobotError`."""
        self._memory = memory
        self.link, theirs = socket.socketpair()
        # No pipe for stderr: nobody would read it while all is well, and a full pipe stops the writer.
        self._stderr = tempfile.TemporaryFile()  # noqa: SIM115 - closed in release()
        command = [sys.executable, "-P", "-m", "engine.robot.sim.physics"]
        command += [f"--memory={memory.fd}", f"--link={theirs.fileno()}"]
        command += [f"--scene={scene}", f"--settings={settings.model_dump_json()}"]
        try:
            self._process = subprocess.Popen(
                command,
                pass_fds=(memory.fd, theirs.fileno()),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=self._stderr,
                env=_environment(),
                start_new_session=True,  # Ctrl-C and the terminal's hang-up reach the engine alone
            )
        except OSError as error:
            self.release()
            raise RobotError(f"The robot process cannot be started: {error}.") from error
        finally:
            theirs.close()

    @property
    def pid(self) -> int:
        return self._process.pid

    def wait_until_ready(self) -> None:
        """Block until the world is built. Raises :class:`RobotError`."""
        self.link.settimeout(START_LIMIT)
        with contextlib.suppress(OSError):  # time-out or a broken connection: not ready either
            if self.link.recv(1):
                return
        raise RobotError(
            self.epitaph(wait=0.5) or f"The robot process was not ready within {START_LIMIT:.0f} s.",
            hint="Check robot.scene in your configuration.",
        )

    def epitaph(self, *, wait: float = 0.0) -> str | None:
        """What the process died of, with its last words; None while it lives (``wait`` s more at most)."""
        try:
            code = self._process.wait(wait) if wait else self._process.poll()
        except subprocess.TimeoutExpired:
            return None
        if code is None:
            return None
        cause = f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
        words = ""
        with contextlib.suppress(OSError, ValueError):  # closed meanwhile by another thread: no last words then
            size = self._stderr.seek(0, os.SEEK_END)
            self._stderr.seek(max(0, size - 2000))
            words = self._stderr.read().decode(errors="replace").strip()
        return f"The robot process {cause}{f': {words}' if words else '.'}"

    def end(self) -> None:
        """Ask the process to leave and block until it has; kill it when it does not."""
        self._memory.ints[m.QUIT] = 1
        with contextlib.suppress(OSError):  # its end may be closed already
            self.link.shutdown(socket.SHUT_RDWR)
        try:
            self._process.wait(_LEAVE_LIMIT)
        except subprocess.TimeoutExpired:
            self.kill()

    def kill(self) -> None:
        """End the process for good, also one that has been stopped, and block until it is gone."""
        self._process.kill()
        self._process.wait()

    def release(self) -> None:
        """Close what is ours."""
        self.link.close()
        self._stderr.close()


def _environment() -> dict[str, str]:
    """Ours, with this very package first on the path (-P keeps the working folder off it), and one thread for BLAS:
    spinning worker threads would steal the time of the control loop."""
    root = str(Path(engine.__file__).resolve().parents[1])
    path = os.pathsep.join(filter(None, (root, os.environ.get("PYTHONPATH", ""))))
    return {**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
