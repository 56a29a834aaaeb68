"""What another program says: its output, and the sound in it."""

from __future__ import annotations

import io
import subprocess
from collections.abc import Sequence
from typing import Final

import numpy as np
import soundfile
import soxr
from numpy.typing import NDArray

from engine.environment import clean_environment
from engine.errors import ModelError
from engine.wake.embedding import RATE

PATIENCE_S: Final = 60.0


def output(command: Sequence[str]) -> bytes:
    """What it prints. Raises ``ModelError``."""
    try:
        done = subprocess.run(command, capture_output=True, timeout=PATIENCE_S, check=True, env=clean_environment())
    except (OSError, subprocess.SubprocessError) as error:
        raise ModelError(f"{command[0]} cannot be used: {error}.", hint="apt install espeak-ng") from error
    return done.stdout


def decoded(wav: bytes) -> NDArray[np.float32]:
    """A WAV, mono, at 16 kHz, ±1. Programs that write to a pipe cannot say how long it is: its header may be wrong.
    Raises ``ModelError``."""
    try:
        sound, rate = soundfile.read(io.BytesIO(wav), dtype="float32", always_2d=True)
    except soundfile.LibsndfileError as error:
        raise ModelError(f"A synthetic voice gave no sound: {error}.", hint="apt install espeak-ng") from error
    return np.asarray(soxr.resample(sound[:, 0], rate, RATE), np.float32)
