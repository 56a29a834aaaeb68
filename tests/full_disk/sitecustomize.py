"""A full disk, for every Python process that has this folder on its path: no file can be made or written."""

import builtins
import errno
import io
import os
from typing import Any

_open, _os_open = builtins.open, os.open
_NEW = os.O_CREAT | (getattr(os, "O_TMPFILE", 0) & ~os.O_DIRECTORY)


def _full() -> OSError:
    return OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _full_open(file: Any, mode: str = "r", *args: Any, **more: Any) -> Any:
    if not isinstance(file, int) and set(mode) & set("wax+"):
        raise _full()
    return _open(file, mode, *args, **more)


def _full_os_open(path: Any, flags: int, *args: Any, **more: Any) -> int:
    if flags & _NEW:
        raise _full()
    return _os_open(path, flags, *args, **more)


builtins.open = io.open = _full_open
os.open = _full_os_open
