"""Files that are in no folder: shared with a child, and gone with the last who has them, however the processes end."""

from __future__ import annotations

import os
import tempfile


def unnamed_file(purpose: str, size: int = 0) -> int:
    """The descriptor of a file of zeros: in memory, or on disk where the system knows no others. The caller closes
    it."""
    if hasattr(os, "memfd_create"):
        fd = os.memfd_create(purpose, os.MFD_CLOEXEC)
    else:
        with tempfile.TemporaryFile() as file:
            fd = os.dup(file.fileno())
    try:
        os.ftruncate(fd, size)
    except BaseException:
        os.close(fd)
        raise
    return fd
