"""Runs the real command line in a process of its own, with folders of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"
LIMIT_S = 120

BOOT = "from tui.cli import entry; entry()"


def command(*arguments: str, before: str = "") -> list[str]:
    """The command line that starts sayso with these arguments; ``before`` is what a test changes in it, as code."""
    return [sys.executable, "-c", f"{before}\n{BOOT}", *arguments]


def environment(state: Path, more: Mapping[str, str] | None = None) -> dict[str, str]:
    """The environment of a user whose logs go to ``state``, and who has configured nothing but that no large model is
    loaded."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith("SAYSO_")}
    folders = {"SAYSO_STATE_DIR": str(state), "SAYSO_CONFIG_DIR": str(state / "config")}
    return kept | folders | {"SAYSO_PLANNER__PROFILE": "phrases"} | dict(more or {})


def sayso(
    *arguments: str, state: Path, stdin: bytes | None = b"", environ: Mapping[str, str] | None = None
) -> subprocess.CompletedProcess[bytes]:
    """Run to the end, simulated time as fast as it goes."""
    more = {"SAYSO_ROBOT__SPEED": "max"} | dict(environ or {})
    return subprocess.run(
        command(*arguments),
        input=stdin,
        capture_output=True,
        timeout=LIMIT_S,
        env=environment(state, more),
        check=False,
    )


def events(done: subprocess.CompletedProcess[bytes], kind: str | None = None) -> list[dict[str, Any]]:
    """The JSON lines of stdout: every one of them must be one."""
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    return [line for line in lines if kind is None or line["kind"] == kind]
