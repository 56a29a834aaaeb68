"""Keeps one program and everything that it starts below itself, and leaves nobody behind.

``engine.process`` starts this file with the bare standard library (``python -I -S``), in a session of its own. It
is two processes, one below the other, and the program below both. Each is a *child subreaper* (Linux): a process that
loses its parent becomes a child of the supervisor, whatever session, process group or environment it made for itself,
so nobody leaves the tree, and ``waitpid`` without a child left (``ECHILD``) proves that all are gone. The lower one,
the *warden*, does the work. The upper one, the *guard*, inherits the tree when somebody kills the warden and then
does the same; the warden, in turn, ends the tree when its guard dies. Where there are no subreapers (macOS) the
program's process group is all that is known here, and the engine looks for the rest.

Over the control socket, in lines of words: to the engine ``started PID WARDEN`` or ``failed ERRNO``, ``exited CODE
STDERR`` (the last bytes, in hexadecimal), ``gone SURVIVOR…``; from the engine any byte means: end them all. So does
the closing of its end, which the kernel does for an engine that dies in whatever way.

Ending: SIGTERM and SIGCONT to everybody, a grace (which ends early when they use it to multiply), then SIGKILL to
everybody again and again until nobody is left. Whole process groups are signalled, because that is atomic: nobody in
the group can fork past it.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import time
from collections.abc import Iterator

TAIL = 2000
"""Bytes of the program's last words that are kept."""
_PATIENCE_S = 1.0  # that the guard gives the warden to end the tree by itself
_KILL_LIMIT_S = 2.0  # after which whoever cannot be killed (another user's, stuck in a device) is reported
_STORM = 100  # ends within the grace, after which it is over: they do not tidy up, they multiply
_PASSES = 5  # rounds of SIGKILL without a pause: whoever sleeps in the middle of a fork storm does not wake up soon
_PAUSE_S = 0.001
_FIFO_PRIORITY = 1  # before everybody whom we end, after whoever stops a robot
_DEFAULTS = tuple(signal.valid_signals() - {signal.SIGKILL, signal.SIGSTOP})
"""Signals that we, or Python, or whoever started the engine (a shell, for what it runs in the background) may ignore;
the program shall not inherit that."""
_PROC = os.path.exists("/proc/self/stat")  # noqa: PTH110 - pathlib is slow to load
_PR_SET_PDEATHSIG, _PR_SET_CHILD_SUBREAPER = 1, 36  # <linux/prctl.h>


class Watch:
    """Everything that wakes a supervisor: signals, the control socket, and the program's stderr."""

    def __init__(self, control: int, child: int, *, listens: bool) -> None:
        """The guard does not listen: it would take the word that is meant for the warden. It notices a closed end."""
        self.told = False  # to end the tree
        self.code: int | None = None  # exit code of the child, negative for signals; None while it lives
        self.ends = 0  # of children and orphans, ever
        self.childless = False
        self._more_ended = False  # perhaps
        self._child = child
        self.tail = b""
        self._control = control
        self._signals, wakeup = os.pipe()
        for end in (self._signals, wakeup):
            os.set_blocking(end, False)
        signal.set_wakeup_fd(wakeup, warn_on_full_buffer=False)
        for number in (signal.SIGCHLD, signal.SIGTERM):
            signal.signal(number, lambda number, frame: None)
        for number in (signal.SIGINT, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)
        self._poll = select.poll()
        self._poll.register(self._signals, select.POLLIN)
        self._poll.register(control, select.POLLIN if listens else 0)
        self._stderr = -1
        self.reap()  # what ended before anybody watched sends no signal any more

    def hear(self, stderr: int) -> None:
        """Keep the last of what is written to the other end of this pipe."""
        os.set_blocking(stderr, False)
        self._stderr = stderr
        self._poll.register(stderr, select.POLLIN)

    def wait(self, seconds: float | None = None) -> None:
        """Until something happens, or for so long; then take note of it."""
        if self._more_ended:
            seconds = 0.0
        for source, _ in self._poll.poll(None if seconds is None else max(0.0, seconds * 1e3)):
            if source == self._signals:
                with contextlib.suppress(BlockingIOError):
                    self.told |= signal.SIGTERM in os.read(self._signals, 4096)
            elif source == self._control:
                self.told = True
                self._poll.unregister(source)  # a closed end would wake us for ever
            else:
                self.read_stderr()
        self.reap(_STORM)

    def reap(self, most: int = sys.maxsize) -> None:
        """Collect the children that have ended: at most so many, where others end all the time."""
        self._more_ended = False
        for _ in range(most):
            try:
                pid, status = os.waitpid(-1, os.WNOHANG)
            except ChildProcessError:
                self.childless = True
                return
            self.childless = False
            if pid == 0:
                return
            self.ends += 1
            if pid == self._child:
                self.code = os.waitstatus_to_exitcode(status)
        self._more_ended = True

    def read_stderr(self) -> None:
        """Take what is there now."""
        for _ in range(64 if self._stderr >= 0 else 0):  # more than a pipe holds; who never ends is heard again later
            try:
                data = os.read(self._stderr, 65536)
            except BlockingIOError:
                return
            if not data:
                self._poll.unregister(self._stderr)
                self._stderr = -1
                return
            self.tail = (self.tail + data)[-TAIL:]

    def report_exit(self) -> None:
        """Tell the engine how the program ended, and its last words."""
        self.read_stderr()
        self.report("exited", -signal.SIGKILL if self.code is None else self.code, self.tail.hex())

    def report(self, *words: object) -> None:
        """Tell the engine, if there still is one. The socket holds far more than all that is ever said."""
        with contextlib.suppress(OSError):
            os.write(self._control, (" ".join(map(str, words)) + "\n").encode())


def main(arguments: list[str]) -> int:
    control, grace, program = int(arguments[0]), float(arguments[1]), arguments[2:]
    os.set_inheritable(control, False)
    _prctl(_PR_SET_CHILD_SUBREAPER, 1)
    guard = os.getpid()
    warden = os.fork()
    if warden:
        return _guard(control, warden, grace)
    _prctl(_PR_SET_CHILD_SUBREAPER, 1)
    return _keep(control, guard, program, grace)


def _guard(control: int, warden: int, grace: float) -> int:
    """Wait for the warden; do its work when it cannot."""
    watch = Watch(control, warden, listens=False)
    _close_standard_streams()
    while watch.code is None and not watch.told:
        watch.wait()
    if watch.code is None:
        for number in (signal.SIGTERM, signal.SIGCONT):
            _kill(warden, number)
        deadline = time.monotonic() + grace + _PATIENCE_S
        while watch.code is None and time.monotonic() < deadline:
            watch.wait(deadline - time.monotonic())
    if watch.code != 0:
        watch.report("gone", *end(watch, warden, grace))
    return 0


def _keep(control: int, guard: int, program: list[str], grace: float) -> int:
    """Start the program, and end everybody when it ends or when told to."""
    last_words, stderr = os.pipe()
    try:
        pid = os.posix_spawnp(
            program[0],
            program,
            os.environ,
            file_actions=[(os.POSIX_SPAWN_DUP2, stderr, 2)],
            setpgroup=0,
            setsigdef=_DEFAULTS,
        )
    except OSError as error:
        os.write(control, f"failed {error.errno}\n".encode())
        return 0
    os.close(stderr)
    watch = Watch(control, pid, listens=True)
    watch.hear(last_words)
    _close_standard_streams()  # else nobody would see that the program has closed them
    _prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    watch.told |= os.getppid() != guard  # it died before we could say that we want to know
    watch.report("started", pid, os.getpid())
    while watch.code is None and not watch.told:
        watch.wait()
    by_itself = watch.code is not None
    if by_itself:
        watch.report_exit()
    survivors = end(watch, pid, grace)
    if not by_itself:
        watch.report_exit()
    watch.report("gone", *survivors)
    return 0


def end(watch: Watch, child: int, grace: float) -> list[int]:
    """End everybody below us; returns who could not be ended."""
    with contextlib.suppress(OSError, AttributeError):  # not allowed, another system; we sleep most of the time
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_FIFO_PRIORITY))
    watch.reap(_STORM)
    for number in (signal.SIGTERM, signal.SIGCONT):  # the paused ones must wake up to hear of their end
        _signal_all(number, child)
    deadline, ends = time.monotonic() + grace, watch.ends
    while not watch.childless and watch.ends - ends < _STORM and time.monotonic() < deadline:
        watch.wait(deadline - time.monotonic())
    deadline = time.monotonic() + _KILL_LIMIT_S
    while not watch.childless and time.monotonic() < deadline:
        for _ in range(_PASSES):
            _signal_all(signal.SIGKILL, child)
            watch.reap()
        watch.wait(_PAUSE_S)
    return [] if watch.childless else list(_below(os.getpid()))


def _signal_all(number: int, child: int) -> None:
    """Everybody below us, once each. All members of their process groups are below us too: a group lies within one
    session, and theirs are the one that we lead or their own."""
    ours, signalled = os.getpgid(0), {0, 1}
    for pid in _below(os.getpid()) if _PROC else [child]:
        try:
            group = os.getpgid(pid)
        except ProcessLookupError:  # it has ended; where nobody can be looked up, its group may live on
            group = 0 if _PROC else pid
        if group == ours:
            _kill(pid, number)
        elif group not in signalled:
            signalled.add(group)
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(group, number)


def _kill(pid: int, number: int) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.kill(pid, number)


def _below(pid: int) -> Iterator[int]:
    """All descendants that can be seen now, the nearest first."""
    children = _children_by_stat() if not os.path.exists(f"/proc/{pid}/task/{pid}/children") else None  # noqa: PTH110
    parents, seen = [pid], {pid}
    for parent in parents:
        for child in _children(parent) if children is None else children.get(parent, []):
            if child not in seen:
                seen.add(child)
                parents.append(child)
                yield child


def _children(pid: int) -> list[int]:
    """As the kernel lists them for each thread: fast enough to catch a process that lives for a millisecond."""
    found: list[int] = []
    with contextlib.suppress(OSError):  # it has ended
        for thread in os.listdir(f"/proc/{pid}/task"):  # noqa: PTH208
            with open(f"/proc/{pid}/task/{thread}/children", "rb") as file:  # noqa: PTH123
                found += map(int, file.read().split())
    return found


def _children_by_stat() -> dict[int, list[int]]:
    """The children of every process, for kernels without lists of them; nobody where there is no /proc."""
    found: dict[int, list[int]] = {}
    for name in filter(str.isdigit, os.listdir("/proc") if _PROC else []):  # noqa: PTH208
        with contextlib.suppress(OSError), open(f"/proc/{name}/stat", "rb") as file:  # noqa: PTH123
            parent = int(file.read().rpartition(b")")[2].split()[1])
            found.setdefault(parent, []).append(int(name))
    return found


def _prctl(option: int, value: int) -> None:
    """On Linux; elsewhere nothing of the kind exists."""
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(option, ctypes.c_ulong(value))


def _close_standard_streams() -> None:
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nowhere, stream)


if __name__ == "__main__":
    os._exit(main(sys.argv[1:]))  # nothing is left to flush, and taking an interpreter down takes as long as the kill
