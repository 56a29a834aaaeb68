"""Folders that are this user's alone, whatever the umask: what was said, what was shown, and a socket lie in them."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Collection
from pathlib import Path


class NotPrivate(PermissionError):
    """A folder that others can get at; ``strerror`` says why, and what to do."""

    def __init__(self, folder: Path, why: str) -> None:
        super().__init__(errno.EPERM, why, str(folder))


def private_folder(folder: Path, ours: Collection[str] | None = None) -> None:
    """Make the folder, and those above it that are missing, for this user alone. One that is there already is taken
    from others; if ``ours`` is given, only where it is empty or holds one of these names, as the user may have named a
    folder that is for others, too. Raises :class:`NotPrivate` and ``OSError``."""
    make_folders(folder)
    about = folder.lstat()
    if stat.S_ISLNK(about.st_mode):
        raise NotPrivate(folder, "it is a symbolic link; name the folder itself with SAYSO_STATE_DIR")
    if about.st_uid != os.geteuid():
        raise NotPrivate(folder, "it belongs to another user; name one of yours with SAYSO_STATE_DIR")
    if about.st_mode & 0o077:
        found = [entry.name for entry in folder.iterdir()] if ours is not None else []
        if found and ours is not None and not set(ours) & set(found):
            raise NotPrivate(folder, "others may use it; chmod 700 it, or name another one with SAYSO_STATE_DIR")
        folder.chmod(0o700)


def make_folders(folder: Path) -> None:
    """Make the folder and those above it that are missing, each for this user alone. Raises ``OSError``."""
    if folder.is_dir():
        return
    make_folders(folder.parent)
    try:
        folder.mkdir(0o700)
    except FileExistsError:
        if not folder.is_dir():  # another process made it meanwhile
            raise
    else:
        if stat.S_IMODE(folder.stat().st_mode) != 0o700:  # a umask took something from us
            folder.chmod(0o700)
