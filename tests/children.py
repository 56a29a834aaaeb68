"""Child processes by the module of ours that they run: a test that finds none knows that nothing was left behind."""

from __future__ import annotations

import psutil


def children(module: str, of: int | None = None) -> list[psutil.Process]:
    """The processes below this one, or below process ``of``, that run ``module`` and have not ended."""
    return [child for child in psutil.Process(of).children(recursive=True) if _runs(child, module)]


def _runs(process: psutil.Process, module: str) -> bool:
    try:
        return module in process.cmdline()
    except psutil.NoSuchProcess:  # it has just ended, whichever it was
        return False
