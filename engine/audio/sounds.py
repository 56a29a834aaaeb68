"""The robot's own sounds, made when they are needed: a few struck notes each, short and soft.

What sounds while somebody is listened to must not be taken for speech, nor cover the first word: those two are the
shortest and quietest.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Final, Literal

import numpy as np

from engine.audio.player import Sound

SoundName = Literal["wake", "listen", "done", "error"]

_C5, _E5, _F4, _A4, _A5, _G5 = 523.25, 659.26, 349.23, 440.0, 880.0, 783.99

NOTES: Final[Mapping[SoundName, tuple[tuple[float, float, float], ...]]] = {
    "wake": ((0.0, _E5, 0.10), (0.07, _A5, 0.10)),  # "I am here": upwards, like a question
    "listen": ((0.0, _A5, 0.06),),  # the recording runs
    "done": ((0.0, _C5, 0.15), (0.09, _E5, 0.15), (0.18, _G5, 0.15)),
    "error": ((0.0, _A4, 0.18), (0.14, _F4, 0.18)),
}
"""Of each sound its notes: when they begin (s), their pitch (Hz), and how loud they are (of full scale)."""

_RINGS_S: Final = 0.16  # until a note has faded to nothing
_ATTACK_S: Final = 0.006
_DECAY_S: Final = 0.035
_OVERTONES: Final = ((1.0, 1.0), (2.0, 0.25), (3.0, 0.08))  # multiple of the pitch, share


@functools.cache
def sound(name: SoundName, rate: int) -> Sound:
    """One of the sounds, shape (n,), ±1, at ``rate`` Hz."""
    notes = NOTES[name]
    whole = np.zeros(round((notes[-1][0] + _RINGS_S) * rate), np.float32)
    for begins, pitch, loudness in notes:
        note = loudness * _note(pitch, rate)
        first = round(begins * rate)
        whole[first : first + len(note)] += note[: len(whole) - first]
    whole.setflags(write=False)
    return whole


def _note(pitch: float, rate: int) -> Sound:
    time = np.arange(round(_RINGS_S * rate)) / rate
    tone = sum(share * np.sin(2 * np.pi * pitch * multiple * time) for multiple, share in _OVERTONES)
    rise = np.minimum(1.0, time / _ATTACK_S)
    fall = np.exp(-np.maximum(0.0, time - _ATTACK_S) / _DECAY_S) * np.minimum(1.0, (_RINGS_S - time) / _DECAY_S)
    return np.asarray(tone * rise * fall / sum(share for _, share in _OVERTONES), np.float32)
