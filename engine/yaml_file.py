"""Reading a YAML file that a person wrote: whatever it is, the answer is its content or one kind of error."""

from __future__ import annotations

import stat
from pathlib import Path
from typing import Any, Final

import yaml

MOST_BYTES: Final = 1_000_000


class BadFile(Exception):
    """It cannot be read; the message says why, without naming it."""


def read(path: Path) -> Any:
    """What stands in it. Raises :class:`BadFile`."""
    data = read_bytes(path, MOST_BYTES)
    try:
        return yaml.safe_load(data)
    except (yaml.YAMLError, ValueError, RecursionError) as error:  # a date that is none, a number too long, too deep
        raise BadFile(f"not YAML: {str(error).splitlines()[0] if str(error) else 'nested too deep'}") from error


def read_bytes(path: Path, most: int) -> bytes:
    """The bytes of a plain file that has no more than so many. Raises :class:`BadFile`."""
    try:
        about = path.stat()
        if not stat.S_ISREG(about.st_mode):
            raise BadFile("it is no plain file")
        if about.st_size > most:
            raise BadFile(f"it has {about.st_size} bytes; {most} are read at most")
        return path.read_bytes()
    except FileNotFoundError:
        raise
    except (OSError, ValueError) as error:  # a ValueError: a zero in its name
        raise BadFile(getattr(error, "strerror", None) or str(error)) from error
