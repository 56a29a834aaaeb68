"""A fault of the console, written down so that it can be reported (``config.secrets`` says what is left out)."""

from __future__ import annotations

import os
import platform
from datetime import UTC, datetime
from pathlib import Path

from config.private import make_folders
from engine import __version__


def write(folder: Path, text: str, now: datetime | None = None) -> Path:
    """Into a new file of this folder, for its owner alone. Raises ``OSError``."""
    when = now or datetime.now(UTC)
    make_folders(folder)
    path = folder / f"crash-{when:%Y%m%dT%H%M%SZ}-{os.getpid()}.txt"
    head = f"sayso {__version__}, Python {platform.python_version()}, {platform.system()}, {when:%Y-%m-%d %H:%M:%S} UTC"
    number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)
    with os.fdopen(number, "w", encoding="utf-8", errors="backslashreplace") as file:
        file.write(f"{head}\n\n{text}")
    return path
