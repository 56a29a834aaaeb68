"""Programs that the engine runs, each as a whole tree of processes of which nothing survives.

A program may start others, move them into sessions of their own, ignore SIGTERM, fork faster than anybody can count,
or be paused. :class:`ProcessTree` starts it below a supervisor (``engine.supervisor``) that no process leaves, and
ends all of it: when the ``async with`` block is left in whatever way, when the program ends by itself, and when the
engine dies. Where a supervisor cannot see everything (macOS) or somebody killed both halves of it, the engine looks
for what is left by a marker in the environment and by session.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Collection, Coroutine, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self, TypeVar

from ulid import ULID

from engine import supervisor
from engine.environment import clean_environment
from engine.errors import ProcessError

GRACE_S = 0.15
"""s between SIGTERM and SIGKILL, unless told otherwise."""
MAX_LINE = 1 << 20
"""Longest line that is read, bytes; a longer one is skipped and counted."""
MARKER = "SAYSO_TREE"
"""Environment variable by which the processes of a tree are known."""

_START_LIMIT_S = 10.0
_ANSWER_LIMIT_S = 0.5  # for a supervisor, beyond the grace; one that somebody paused has been woken up
_SWEEP_LIMIT_S = 2.0
_CHUNK = 1 << 16
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Killed:
    """How a tree ended."""

    seconds: float  # from the word to the last process gone
    survivors: tuple[int, ...]  # processes that could not be ended; another user's, for instance


class ProcessTree:
    """One program and everything that it starts, alive within ``async with``. For use in one asyncio loop.

    ``inherits`` names variables that it sees beside those of :func:`engine.environment.clean_environment`, and ``env``
    is added to them; ``grace`` is the time between SIGTERM and SIGKILL, s. Entering raises :class:`ProcessError` when
    the program cannot be started.
    """

    def __init__(
        self,
        argv: Sequence[str],
        *,
        env: Mapping[str, str] | None = None,
        inherits: Collection[str] = (),
        cwd: str | Path | None = None,
        grace: float = GRACE_S,
    ) -> None:
        self._argv = tuple(argv)
        self._grace = grace
        self._marker = str(ULID())
        self._env = {**clean_environment(inherits), **(env or {}), MARKER: self._marker}
        self._cwd = cwd
        self._guard: subprocess.Popen[bytes] | None = None
        self._control = _Control()
        self._input = _Input()
        self._output = asyncio.StreamReader(limit=_CHUNK)
        self._transports: list[asyncio.BaseTransport] = []
        self._killing: asyncio.Task[Killed] | None = None
        self.overlong = 0
        """Lines that were skipped for their length."""

    @property
    def pid(self) -> int:
        """Of the program."""
        return self._control.pids[0]

    @property
    def supervisors(self) -> tuple[int, int]:
        """Guard and warden."""
        assert self._guard is not None
        return self._guard.pid, self._control.pids[1]

    @property
    def last_words(self) -> str:
        """The end of what the program wrote to stderr; known once it has ended."""
        return self._control.stderr.decode(errors="replace").strip()

    async def __aenter__(self) -> Self:
        try:
            await self._start()
        except BaseException:
            await self._close()
            raise
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self._close()

    async def _start(self) -> None:
        loop = asyncio.get_running_loop()
        ours = self._spawn()
        guard = self._guard
        assert guard is not None
        assert guard.stdin is not None
        assert guard.stdout is not None
        await self._connect(loop.create_connection(lambda: self._control, sock=ours))
        await self._connect(loop.connect_write_pipe(lambda: self._input, guard.stdin))
        reading = asyncio.StreamReaderProtocol(self._output, loop=loop)
        await self._connect(loop.connect_read_pipe(lambda: reading, guard.stdout))
        try:
            async with asyncio.timeout(_START_LIMIT_S):
                await self._control.started.wait()
        except TimeoutError:
            raise ProcessError(f"{self._argv[0]} was not started within {_START_LIMIT_S:.0f} s.") from None
        if not self._control.pids:
            why = os.strerror(self._control.errno) if self._control.errno else "its supervisor was killed"
            raise ProcessError(f"{self._argv[0]} cannot be started: {why}.")

    def _spawn(self) -> socket.socket:
        """Start the supervisor; returns our end of its control socket."""
        ours, theirs = socket.socketpair()
        command = [sys.executable, "-I", "-S", supervisor.__file__, str(theirs.fileno()), str(self._grace), *self._argv]
        try:
            self._guard = subprocess.Popen(
                command,
                pass_fds=(theirs.fileno(),),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,  # the supervisor takes the program's; see Watch.hear
                env=self._env,
                cwd=self._cwd,
                start_new_session=True,  # the terminal's signals reach the engine alone
                bufsize=0,
            )
        except OSError as error:
            ours.close()
            raise ProcessError(f"{self._argv[0]} cannot be started: {error.strerror}: {error.filename}.") from error
        finally:
            theirs.close()
        return ours

    async def _connect(self, connecting: Coroutine[Any, Any, tuple[asyncio.BaseTransport, Any]]) -> None:
        transport, _ = await connecting
        self._transports.append(transport)

    async def write(self, line: str) -> None:
        """Send a line (without its end) to the program; waits while it reads too slowly. A program that has closed
        its stdin, or ended, hears nothing: :meth:`wait` and :meth:`lines` tell of that."""
        await self._input.write(line.encode() + b"\n")

    async def lines(self) -> AsyncIterator[str]:
        """What the program writes, line by line, until it and all who share its stdout have closed it. Bytes that
        are not UTF-8 are replaced, and what follows the last line end is a line too."""
        pending, skipping = bytearray(), False
        while data := await self._output.read(_CHUNK):
            *complete, rest = data.split(b"\n")
            for end in complete:
                pending += end
                if not self._too_long(pending, skipping):
                    yield pending.decode(errors="replace")
                    await asyncio.sleep(0)  # a program that writes without end must not hold up the others here
                pending.clear()
                skipping = False
            pending += rest
            if len(pending) > MAX_LINE:
                pending.clear()
                skipping = True
        if self._too_long(pending, skipping):
            return
        if pending:
            yield pending.decode(errors="replace")

    def _too_long(self, line: bytearray, skipping: bool) -> bool:
        too_long = skipping or len(line) > MAX_LINE
        self.overlong += too_long
        return too_long

    async def wait(self) -> int:
        """Wait for the program to end: its exit code, or the negative number of the signal that ended it."""
        await self._control.exited.wait()
        return self._control.code

    async def kill(self) -> Killed:
        """End the program and everything that it started; returns when all are gone.

        Cancellation waits for that too, which is bounded. May be called again: the answer is the same.
        """
        if self._killing is None:
            self._control.tell()  # at once, whatever becomes of the task: the word is out
            self._wake_supervisors()
            self._killing = asyncio.create_task(self._kill(time.monotonic()))
        return await _to_the_end(self._killing)

    async def _kill(self, began: float) -> Killed:
        guard, control = self._guard, self._control
        if guard is None:
            return Killed(0.0, ())
        for victim in (*control.pids[1:], guard.pid, None):
            try:
                async with asyncio.timeout(self._grace + _ANSWER_LIMIT_S):
                    await control.gone.wait()
                break
            except TimeoutError:  # the warden is stuck, so the guard shall do it; the guard is stuck: so shall we
                if victim is not None:
                    _send(victim, signal.SIGKILL)
        seconds = time.monotonic() - began
        survivors = control.survivors
        if survivors is None or sys.platform != "linux":
            survivors = await asyncio.to_thread(_sweep, self._marker, guard.pid)
            seconds = time.monotonic() - began
        try:
            async with asyncio.timeout(self._grace + _ANSWER_LIMIT_S):
                await control.closed.wait()
        except TimeoutError:
            guard.kill()
        return Killed(seconds, tuple(survivors))

    def _wake_supervisors(self) -> None:
        """A supervisor that somebody paused hears nothing."""
        if self._guard is not None and self._guard.returncode is None and not self._control.gone.is_set():
            for pid in (self._guard.pid, *self._control.pids[1:]):
                _send(pid, signal.SIGCONT)

    async def _close(self) -> None:
        try:
            await self.kill()
        finally:
            for transport in self._transports:
                if transport.is_closing():
                    continue
                transport.abort() if isinstance(transport, asyncio.WriteTransport) else transport.close()
            if self._guard is not None:
                self._reap(self._guard)
        await asyncio.sleep(0)  # the transports close their ends now

    @staticmethod
    def _reap(guard: subprocess.Popen[bytes]) -> None:
        """Bury the guard, which has ended unless this loop itself was torn down before the tree was."""
        for stream in (guard.stdin, guard.stdout):
            if stream is not None:
                stream.close()
        try:
            guard.wait(_SWEEP_LIMIT_S)
        except subprocess.TimeoutExpired:
            guard.kill()
            guard.wait()


class _Control(asyncio.Protocol):
    """The control socket: what the supervisor says of the program, as it is known so far."""

    def __init__(self) -> None:
        self.started, self.exited, self.gone = asyncio.Event(), asyncio.Event(), asyncio.Event()
        self.closed = asyncio.Event()  # both supervisors have ended
        self.pids: tuple[int, ...] = ()  # program and warden
        self.errno = 0
        self.code = -int(signal.SIGKILL)  # unless somebody lives to tell another
        self.stderr = b""
        self.survivors: list[int] | None = None
        self._transport: asyncio.Transport | None = None
        self._buffer = b""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport

    def data_received(self, data: bytes) -> None:
        *lines, self._buffer = (self._buffer + data).split(b"\n")
        for line in lines:
            self._take(line.decode().split(" "))

    def _take(self, words: list[str]) -> None:
        match words:
            case ["started", program, warden]:
                self.pids = int(program), int(warden)
                self.started.set()
            case ["failed", number]:
                self.errno = int(number)
            case ["exited", code, stderr]:
                self.code, self.stderr = int(code), bytes.fromhex(stderr)
                self.exited.set()
            case ["gone", *survivors]:
                self.survivors = [int(pid) for pid in survivors]
                self.exited.set()
                self.gone.set()

    def connection_lost(self, exc: Exception | None) -> None:
        if not self.pids:
            self.survivors = []  # nothing was ever started
        for event in (self.started, self.exited, self.gone, self.closed):
            event.set()

    def tell(self) -> None:
        """End them all."""
        if self._transport is not None and not self._transport.is_closing():
            self._transport.write(b"end\n")


class _Input(asyncio.BaseProtocol):
    """The program's stdin."""

    def __init__(self) -> None:
        self._free = asyncio.Event()
        self._free.set()
        self._transport: asyncio.WriteTransport | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.WriteTransport)
        self._transport = transport

    def pause_writing(self) -> None:
        self._free.clear()

    def resume_writing(self) -> None:
        self._free.set()

    def connection_lost(self, exc: Exception | None) -> None:
        self._transport = None
        self._free.set()

    async def write(self, data: bytes) -> None:
        if self._transport is not None and not self._transport.is_closing():
            self._transport.write(data)
        await self._free.wait()


async def _to_the_end(task: asyncio.Task[T]) -> T:
    """The result of ``task``, which is waited for also while cancelled."""
    cancelled: asyncio.CancelledError | None = None
    while not task.done():
        try:
            await asyncio.shield(task)
        except asyncio.CancelledError as error:
            cancelled = error
    if cancelled is not None:
        raise cancelled
    return task.result()


def _sweep(marker: str, session: int) -> list[int]:
    """Kill whoever carries the marker, is of the session, or descends from such; returns who could not be killed."""
    import psutil

    def found() -> list[psutil.Process]:
        members = [process for process in psutil.process_iter() if _belongs(process, marker, session)]
        families = [process for member in members for process in (member, *_descendants(member))]
        return [process for process in dict.fromkeys(families) if _is_alive(process)]

    deadline = time.monotonic() + _SWEEP_LIMIT_S
    while (left := found()) and time.monotonic() < deadline:
        for process in left:
            with contextlib.suppress(psutil.Error):
                process.kill()
        psutil.wait_procs(left, timeout=0.05)
    return [process.pid for process in left]


def _belongs(process: Any, marker: str, session: int) -> bool:
    import psutil

    try:
        if os.getsid(process.pid) == session:
            return True
        return bool(process.environ().get(MARKER) == marker)
    except (psutil.Error, OSError):  # it has ended, or is another user's
        return False


def _descendants(process: Any) -> list[Any]:
    import psutil

    with contextlib.suppress(psutil.Error):
        return list(process.children(recursive=True))
    return []


def _is_alive(process: Any) -> bool:
    import psutil

    try:
        return bool(process.status() != psutil.STATUS_ZOMBIE)
    except psutil.Error:
        return False


def _send(pid: int, number: int) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.kill(pid, number)
