"""Files of the user's, written as a whole."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from config.private import make_folders


def write_whole(path: Path, data: bytes, *, mode: int = 0o600) -> None:
    """Write a file anew, and its folder where that is missing. The old one stands until the new one is whole, and if it
    cannot be written. Raises ``OSError``."""
    make_folders(path.parent)
    new = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with os.fdopen(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb") as file:
            os.fchmod(file.fileno(), mode)
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        new.replace(path)
    except OSError:
        with contextlib.suppress(OSError):
            new.unlink()
        raise
