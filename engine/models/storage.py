"""What the file system refuses, as an error that says what to do about it."""

from __future__ import annotations

import contextlib
import errno
from collections.abc import Iterator
from pathlib import Path

from engine.errors import StorageError

FREE_SPACE = "Free some space and run it again: what was fetched is kept."


@contextlib.contextmanager
def storing(path: Path) -> Iterator[None]:
    """Turn an OSError about the cache at or under ``path`` into a StorageError."""
    try:
        yield
    except OSError as error:
        full = error.errno in {errno.ENOSPC, errno.EDQUOT}
        other = "Choose a folder you can write with SAYSO_CACHE_DIR or the setting models.folder."
        raise StorageError(
            f"{error.filename or path}: {error.strerror or error}.", hint=FREE_SPACE if full else other
        ) from error
