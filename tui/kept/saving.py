"""A session that is kept: its events as the event log has them, and a picture of the screen, in a folder of their own.

Only the owner can read them. What cannot be written as a whole is not kept at all.
"""

from __future__ import annotations

import contextlib
import os
import re
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import IO, TYPE_CHECKING, Final

from config.private import private_folder
from engine.errors import StorageError
from engine.event_log import SUFFIX

if TYPE_CHECKING:
    from config.folders import Paths

EVENTS: Final = f"events{SUFFIX}"
PICTURE: Final = "screen.svg"
_BLOCK: Final = 1 << 20
_WEB_FONT: Final = re.compile(r"@font-face\s*\{.*?\}", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Saved:
    """What was kept, and where."""

    folder: Path
    events: bool
    """False: there is no log of this session, and the picture is all."""


def save(folders: Paths, session: str, picture: str, now: datetime | None = None) -> Saved:
    """Keep the session so far in a new folder; takes as long as the disk does. ``picture`` is SVG.

    Raises :class:`StorageError` when it could not be kept.
    """
    kept = folders.state / "saved"
    written: list[Path] = []
    try:
        folder = _new_folder(kept, now or datetime.now(UTC))
        written.append(folder)
        with _created(folder / PICTURE, written) as file:
            file.write(_WEB_FONT.sub("", picture).encode())  # whoever opens it asks nobody for a font
        logs = _parts(folders.logs, session)
        if logs:
            with _created(folder / EVENTS, written) as file:
                for log in logs:
                    _append(log, file)
    except OSError as error:
        for path in reversed(written):
            with contextlib.suppress(OSError):
                path.rmdir() if path == written[0] else path.unlink()
        raise StorageError(
            f"The session could not be saved in {kept}: {error.strerror}.",
            hint="Free some space or set SAYSO_STATE_DIR.",
        ) from error
    return Saved(folder, bool(logs))


def _new_folder(kept: Path, now: datetime) -> Path:
    private_folder(kept)
    stamp, number = now.strftime("%Y%m%dT%H%M%SZ"), 1
    while True:
        folder = kept / (stamp if number == 1 else f"{stamp}.{number}")
        try:
            folder.mkdir(mode=0o700)
        except FileExistsError:
            number += 1
        else:
            return folder


def _created(path: Path, written: list[Path]) -> IO[bytes]:
    file = os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600), "wb")
    written.append(path)
    return file


def _parts(logs: Path, session: str) -> list[Path]:
    """The files of the session's log, the first one first."""
    if not session:
        return []
    files = {path.name: path for path in logs.glob(f"{session}*{SUFFIX}")}
    numbered = (f"{session}.{number}{SUFFIX}" for number in range(2, len(files) + 1))
    return [files[name] for name in (f"{session}{SUFFIX}", *numbered) if name in files]


def _append(log: Path, file: IO[bytes]) -> None:
    """Whole lines alone: the engine may be writing one."""
    rest = b""
    with log.open("rb") as source:
        while block := source.read(_BLOCK):
            lines, newline, rest = (rest + block).rpartition(b"\n")
            file.write(lines + newline)
