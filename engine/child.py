"""A child process of our own: one of our modules in a Python of its own, to which a socket pair leads.

Nothing has a name that could be left over: the child inherits its end of the link and whatever else it shares with us,
and its last words go to a file without a name. When either side dies in whatever way, the kernel closes its end of
the link and the other side knows. Programs of other people run in an ``engine.process.ProcessTree`` instead.
"""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import engine
from engine.errors import ProcessError
from engine.unnamed import unnamed_file

LEAVE_LIMIT_S = 1.5
"""s in which a child leaves when asked."""
_LAST_WORDS = 2000  # bytes of stderr that an epitaph quotes


class Child:
    """One running child process. Whoever makes it ends it (:meth:`end` or :meth:`kill`), then releases it.

    ``link`` is our end of the socket pair; the child is told its own as ``--link=FD``.
    """

    def __init__(
        self,
        name: str,
        module: str,
        arguments: Sequence[str] = (),
        *,
        shared: Sequence[int] = (),
        environment: Mapping[str, str] | None = None,
    ) -> None:
        """Start ``python -m module``; ``name`` is for people, ``shared`` are descriptors that it inherits under the
        same number, ``environment`` is added to ours. Raises :class:`ProcessError`."""
        self._name = name
        with contextlib.ExitStack() as ours:  # until the process runs
            try:
                self.link, theirs = socket.socketpair()
                ours.enter_context(self.link)
                with theirs:
                    # No pipe for stderr: nobody would read it while all is well, and a full pipe stops the writer.
                    # Nor a file in a folder: a full disk must not keep a child from starting.
                    self._stderr = ours.enter_context(os.fdopen(unnamed_file("sayso-last-words"), "w+b"))
                    self._process = subprocess.Popen(
                        [sys.executable, "-P", "-m", module, f"--link={theirs.fileno()}", *arguments],
                        pass_fds=(theirs.fileno(), *shared),
                        stdin=subprocess.DEVNULL,
                        stdout=subprocess.DEVNULL,
                        stderr=self._stderr,
                        env={**_environment(), **(environment or {})},
                        start_new_session=True,  # Ctrl-C and the terminal's hang-up reach the engine alone
                    )
            except OSError as error:
                raise ProcessError(f"The {name} process cannot be started: {error}.") from error
            ours.pop_all()

    @property
    def pid(self) -> int:
        return self._process.pid

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
            self._stderr.seek(max(0, size - _LAST_WORDS))
            words = self._stderr.read().decode(errors="replace").strip()
        return f"The {self._name} process {cause}{f': {words}' if words else '.'}"

    def end(self) -> None:
        """Ask the process to leave and block until it has; kill it when it does not."""
        with contextlib.suppress(OSError):  # its end may be closed already
            self.link.shutdown(socket.SHUT_RDWR)
        try:
            self._process.wait(LEAVE_LIMIT_S)
        except subprocess.TimeoutExpired:
            self.kill()

    def kill(self) -> None:
        """End the process for good, also one that has been stopped, and block until it is gone. Thread-safe."""
        end_for_good(self._process)

    def discard(self) -> None:
        """End the process for good, and leave nothing of it."""
        self.kill()
        self.release()

    def release(self) -> None:
        """Close what is ours."""
        self.link.close()
        self._stderr.close()


def end_for_good(process: subprocess.Popen[bytes]) -> None:
    """What :meth:`Child.kill` does, for a thread that is not to hold on to what the child shares with us: a pool's
    thread knows its work for a moment longer than whoever waits for it."""
    process.kill()
    process.wait()


def _environment() -> dict[str, str]:
    """Ours, with this very package first on the path (-P keeps the working folder off it), and one thread for BLAS:
    spinning worker threads would steal the time of the control loop."""
    root = str(Path(engine.__file__).resolve().parents[1])
    path = os.pathsep.join(filter(None, (root, os.environ.get("PYTHONPATH", ""))))
    return {**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
