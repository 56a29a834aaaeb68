"""What a local model has read before, kept on the disk: a prompt that begins the same is not computed again.

llama.cpp writes what it knows after a prompt (a *state*) into a file here; beside it lies a note with the prompt's
words, so that a prompt that shares only its beginning with an old one still begins from there. Prompts hold places and
names of a home: folder and files are for this user alone. Only whole files are given back to llama.cpp, which trusts
them; the newest few are kept.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import time
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import msgspec

from engine.llm.chat import Message

KEEP: Final = 4
"""Prompts that are kept: two layers, in two houses or languages."""
MAX_BYTES: Final = 400_000_000
"""All states together; a token takes 28 kB with Qwen2.5 1.5B."""
_CHUNK: Final = 1 << 20
_ABANDONED_S: Final = 600.0  # no save takes so long


class _Note(msgspec.Struct, frozen=True):
    """What a state is the state of, and how to know that it is whole."""

    text: str
    size: int
    crc32: int


@dataclass(frozen=True, slots=True)
class Saved:
    """A prompt that has been read before; ``name`` is that of its state, in the folder."""

    name: str
    text: str


class PromptCache:
    """The saved prompts of one model. Safe to use from several processes at once."""

    def __init__(self, folder: Path, maker: Sequence[object]) -> None:
        """``maker`` is everything that a state depends on but the prompt: the model, llama.cpp, their settings."""
        self.folder = folder
        self._maker = hashlib.sha256(repr(tuple(maker)).encode()).hexdigest()[:12]

    def open(self) -> None:
        """Make the folder, and clear what somebody left who was killed while saving. Raises ``OSError``."""
        self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        self.folder.chmod(0o700)
        for pattern in ("*.part", "*.note"):
            for file in self.folder.glob(pattern):
                with contextlib.suppress(OSError):  # gone meanwhile
                    if file.stat().st_mtime < time.time() - _ABANDONED_S:
                        file.unlink()

    def nearest(self, text: str) -> Saved | None:
        """The saved prompt that begins like this one for longest, if it is whole. Reads all of it: for a thread."""
        found = sorted(self._notes(), key=lambda entry: shared(entry[1].text, text), reverse=True)
        for state, note in found:
            if shared(note.text, text) == 0:
                break
            if _is_whole(state, note):
                with contextlib.suppress(OSError):
                    os.utime(state)  # used just now
                return Saved(state.name, note.text)
            self.drop(state.name)
        return None

    def draft(self) -> str:
        """Name for a state that llama.cpp is about to write; :meth:`keep` or :meth:`drop` it."""
        return f"{self._maker}-{os.getpid()}.part"

    def keep(self, draft: str, text: str) -> None:
        """Give a state that was written its name, and let the oldest go. For a thread. Raises ``OSError``."""
        written = self.folder / draft
        written.chmod(0o600)
        note = _Note(text, *_sum(written))
        state = self.folder / f"{self._maker}-{hashlib.sha256(text.encode()).hexdigest()[:16]}.state"
        partial = written.with_suffix(".note")
        partial.touch(mode=0o600)
        partial.write_bytes(msgspec.json.encode(note))
        written.replace(state)
        partial.replace(_note_of(state))
        self._tidy()

    def drop(self, name: str) -> None:
        """Forget one: it is no good."""
        state = self.folder / name
        with contextlib.suppress(OSError):
            state.unlink(missing_ok=True)
            _note_of(state).unlink(missing_ok=True)

    def _notes(self) -> Iterator[tuple[Path, _Note]]:
        for state in self.folder.glob(f"{self._maker}-*.state"):
            try:
                yield state, msgspec.json.decode(_note_of(state).read_bytes(), type=_Note)
            except (OSError, msgspec.DecodeError, UnicodeError):
                self.drop(state.name)

    def _tidy(self) -> None:
        """Keep the newest, of whichever model they are."""
        total = 0
        for count, (_, size, state) in enumerate(sorted(_ages(self.folder), reverse=True)):
            total += size
            if count >= KEEP or total > MAX_BYTES:
                self.drop(state.name)


def rendered(messages: Sequence[Message]) -> str:
    """Messages as one text; two that begin alike have texts that do."""
    return "".join(f"\x1e{message.role}\x1f{message.text}" for message in messages)


def shared(one: str, other: str) -> int:
    """How many characters two texts have in common at their beginning."""
    return len(os.path.commonprefix((one, other)))  # noqa: RUF071 - by characters, as it should


def _ages(folder: Path) -> Iterator[tuple[float, int, Path]]:
    for state in folder.glob("*.state"):
        with contextlib.suppress(OSError):  # gone meanwhile
            found = state.stat()
            yield found.st_mtime, found.st_size, state


def _note_of(state: Path) -> Path:
    return state.with_suffix(".json")


def _is_whole(state: Path, note: _Note) -> bool:
    try:
        return state.stat().st_size == note.size and _sum(state) == (note.size, note.crc32)
    except OSError:
        return False


def _sum(file: Path) -> tuple[int, int]:
    """Size and checksum: a file that a full disk cut short must not reach native code."""
    size = crc32 = 0
    with file.open("rb") as stream:
        while chunk := stream.read(_CHUNK):
            size, crc32 = size + len(chunk), zlib.crc32(chunk, crc32)
    return size, crc32
