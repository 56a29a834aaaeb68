"""Sound from a file: WAV, FLAC, Ogg, MP3, AIFF and whatever else libsndfile reads, at any rate, with any number of
channels, paced in real time or as fast as it can be read.

libsndfile reads the file and soxr resamples it, both block by block, so that the length of a file does not matter. A
WAV file that is cut short is read as far as it goes, with a warning; what cannot be read is called by its name.
"""

from __future__ import annotations

import asyncio
import re
from collections import deque
from pathlib import Path
from types import TracebackType
from typing import Any, Literal

import numpy as np
import soxr

from engine.audio.source import RATE, Frame, Framer, Pacer, Samples, to_int16
from engine.errors import AudioFormatError

BLOCK_S = 0.5  # s of sound per read: small enough to keep the loop's pauses short (a block costs about 1 ms)

MAGIC: tuple[tuple[bytes, str], ...] = (
    (b"RIFF", "a WAV file"),
    (b"RIFX", "a WAV file"),
    (b"RF64", "a WAV file"),
    (b"ID3", "an MP3 file"),
    (b"\xff\xf1", "an AAC file"),
    (b"\xff\xf9", "an AAC file"),
    (b"fLaC", "a FLAC file"),
    (b"OggS", "an Ogg file (Vorbis or Opus)"),
    (b"FORM", "an AIFF file"),
    (b".snd", "an AU file"),
    (b"caff", "a Core Audio file"),
    (b"\x1aE\xdf\xa3", "a Matroska or WebM file"),
    (b"PK\x03\x04", "a ZIP file"),
    (b"\x1f\x8b", "a gzip file"),
    (b"%PDF", "a PDF file"),
    (b"version https://git-lfs", "a Git LFS pointer, not the file itself"),
)


class WavSource:
    """The sound of a file.

    ``pace`` "real" delivers frames as they would sound; "fast" as soon as they are asked for. Opening raises
    ``AudioFormatError`` (exit code 2) when the file cannot be read or holds no sound.
    """

    live = False

    def __init__(self, path: Path, pace: Literal["real", "fast"] = "real") -> None:
        self.path = path
        self.name = path.name
        self.warnings: tuple[str, ...] = ()
        self._pacer = Pacer() if pace == "real" else None
        self._file: Any = None
        self._resampler: Any = None
        self._framer = Framer()
        self._ready: deque[Frame] = deque()

    async def __aenter__(self) -> WavSource:
        self._file = await asyncio.to_thread(_open, self.path)  # importing soundfile takes 80 ms
        if self._file.samplerate != RATE:
            self._resampler = soxr.ResampleStream(self._file.samplerate, RATE, 1, dtype="float32")
        if missing := _promised(self._file) - self._file.frames:
            self.warnings = (
                f"{self.path} is cut short: it promises {_seconds(self._file, missing + self._file.frames)} "
                f"of sound and holds {_seconds(self._file, self._file.frames)}.",
            )
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ready.clear()
        if self._file is not None:
            self._file.close()
            self._file = None

    def __aiter__(self) -> WavSource:
        return self

    async def __anext__(self) -> Frame:
        while not self._ready and self._file is not None:
            self._read_block()
        if not self._ready:
            raise StopAsyncIteration
        if self._pacer is not None:
            await self._pacer.wait()
        else:
            await asyncio.sleep(0)  # a fast file must not starve the loop
        if not self._ready:  # closed meanwhile
            raise StopAsyncIteration
        return self._ready.popleft()

    def _read_block(self) -> None:
        """Decode the next block; at the end of the file, what is left, and close it."""
        try:
            block = self._file.read(round(self._file.samplerate * BLOCK_S), dtype="float32", always_2d=True)
        except RuntimeError as error:  # soundfile.LibsndfileError
            raise AudioFormatError(f"{self.path} cannot be read further: {error}") from error
        last = not len(block)
        mono = block.mean(axis=1, dtype=np.float32)
        if self._resampler is not None:
            mono = self._resampler.resample_chunk(mono, last=last)
        self._ready.extend(self._framer.push(to_int16(mono)))
        if last:
            self._ready.extend(self._framer.flush())
            self._file.close()
            self._file = None


def check_sound(path: Path) -> None:
    """Raises ``AudioFormatError`` where there is nothing to hear in a file."""
    _open(path).close()


def read_wav(path: Path) -> Samples:
    """The whole sound of a file, for which there must be memory. Raises ``AudioFormatError``."""
    with _open(path) as file:
        sound = file.read(dtype="float32", always_2d=True).mean(axis=1, dtype=np.float32)
        return to_int16(soxr.resample(sound, file.samplerate, RATE) if file.samplerate != RATE else sound)


def _open(path: Path) -> Any:
    """An open ``soundfile.SoundFile`` with sound in it; raises ``AudioFormatError`` otherwise."""
    import soundfile

    hint = f"Convert it with: ffmpeg -i '{path}' -ac 1 -ar {RATE} speech.wav"
    if not path.is_file():
        what = f"{path} is no regular file." if path.exists() else f"There is no file {path}."
        raise AudioFormatError(what, hint="Give the path of a recording.")
    try:
        with path.open("rb") as file:
            head = file.read(64)
    except OSError as error:
        raise AudioFormatError(f"{path} cannot be read: {error.strerror}.", hint="Check its permissions.") from error
    if not head:
        raise AudioFormatError(f"There is nothing to hear in {path}: the file is empty.", hint="Record it again.")
    try:
        file_ = soundfile.SoundFile(str(path))
    except TypeError as error:  # soundfile wants to be told what is in a file called .raw
        told = f"{path} is raw sound, whose rate nobody knows."
        raise AudioFormatError(told, hint=f"Where it is 16 kHz, 16-bit, mono: sayso hear - < '{path}'") from error
    except RuntimeError as error:  # soundfile.LibsndfileError
        reason = str(error).rpartition(": ")[2].strip()
        told = f"{path} cannot be read as sound: it looks like {_kind(head)} ({reason.rstrip('.')})."
        raise AudioFormatError(told, hint=hint) from error
    if not file_.frames:
        file_.close()
        told = f"There is nothing to hear in {path}: it has a header and no samples."
        raise AudioFormatError(told, hint="Record it again.")
    return file_


def _kind(head: bytes) -> str:
    for magic, kind in MAGIC:
        if head.startswith(magic):
            return kind
    if head[0] == 0xFF and len(head) > 1 and head[1] & 0xE0 == 0xE0:  # MPEG frame sync
        return "an MP3 file"
    if head[4:8] == b"ftyp":
        return "an MP4 or M4A file"
    return "text" if all(32 <= byte < 127 or byte in b"\t\r\n" for byte in head) else "something unknown"


def _promised(file: Any) -> int:
    """How many sample frames the header announces, by libsndfile's log of parsing it.

    0xFFFFFFFF and values near 0x7FFFFFFF stand in headers of recorders that write to a pipe and do not know the
    length yet; they promise nothing.
    """
    found = re.search(r"^data : (\d+) \(should be \d+\)", file.extra_info, re.MULTILINE)
    align = re.search(r"^  Block Align   : (\d+)", file.extra_info, re.MULTILINE)
    if found is None or align is None or int(found[1]) >= 0x7FFF0000:
        return int(file.frames)
    return max(int(found[1]) // max(1, int(align[1])), int(file.frames))


def _seconds(file: Any, frames: int) -> str:
    return f"{frames / file.samplerate:.2f} s"
