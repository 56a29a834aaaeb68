"""``sayso bench``: the benchmarks of a checkout (they are not part of the installed package)."""

from __future__ import annotations

import subprocess
import sys
from argparse import Namespace
from pathlib import Path

from engine.errors import ExitCode, UsageError
from tui.output import data

FOLDER = Path(__file__).resolve().parents[2] / "tests" / "bench"


def run(arguments: Namespace) -> int:
    """Run one benchmark, or list them."""
    names = sorted(file.stem for file in FOLDER.glob("*.py") if "__main__" in file.read_text(encoding="utf-8"))
    if not names:
        raise UsageError("There are no benchmarks here.", hint="Run sayso from a checkout of its repository.")
    if arguments.name is None:
        data("\n".join(names))
        return int(ExitCode.DONE)
    if arguments.name not in names:
        raise UsageError(f"There is no benchmark {arguments.name!r}.", hint=f"There are: {', '.join(names)}.")
    options = [*arguments.options, *(["--json"] if arguments.json else [])]
    return subprocess.run(
        [sys.executable, "-m", f"tests.bench.{arguments.name}", *options], cwd=FOLDER.parents[1], check=False
    ).returncode
