"""The process of the local model removes what was left behind where it was killed together with its engine."""

from __future__ import annotations

import asyncio
import os
import socket
import tempfile
from pathlib import Path

import pytest

from engine.llm.llama import LOAD_LIMIT_S, SOCKET, LlamaProcess, NotRunning, Shape


def left(temporary: Path, name: str, *, age_s: float, listens: bool = False) -> socket.socket:
    """A folder with a socket, as a model makes one."""
    folder = temporary / name
    folder.mkdir()
    made = socket.socket(socket.AF_UNIX)
    made.bind(str(folder / SOCKET))
    if listens:
        made.listen()
    else:
        made.close()
    then = folder.stat().st_mtime - age_s
    os.utime(folder, (then, then))
    return made


def test_what_killed_engines_left_goes_and_what_somebody_may_use_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    left(tmp_path, "sayso-left", age_s=2 * LOAD_LIMIT_S)
    left(tmp_path, "sayso-young", age_s=0)
    left(tmp_path, "other-left", age_s=2 * LOAD_LIMIT_S)
    (tmp_path / "sayso-empty").mkdir()
    os.utime(tmp_path / "sayso-empty", (0, 0))
    damaged = tmp_path / "damaged.gguf"
    damaged.write_bytes(b"no model")
    with left(tmp_path, "sayso-alive", age_s=2 * LOAD_LIMIT_S, listens=True), pytest.raises(NotRunning):
        asyncio.run(LlamaProcess.start(Shape(damaged, tmp_path, threads=1), "Fetch it again."))
    stay = ["damaged.gguf", "other-left", "sayso-alive", "sayso-empty", "sayso-young"]
    assert sorted(path.name for path in tmp_path.iterdir()) == stay
