"""Recordings of a phrase by who will say it: in each of them somebody says it once, in a room of their own.

What is not the phrase would be learnt as if it were, and a head that takes a quiet room for its phrase hears nothing
else. So a recording is cut to the voice in it: that is what stands out from the noise of the room where somebody
speaks, as the detector says that also listens to commands.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.audio.source import FRAME_SAMPLES, RATE, Framer, to_int16
from engine.audio.vad import VoiceActivity
from engine.errors import UsageError
from engine.wake.training.voices import Sound

LEAST_S: Final = 0.2
MOST_S: Final = 2.0
"""How long somebody says a phrase, s."""
LOUD: Final = 0.5
"""The peak at which a voice is looked for: the detector does not hear a faint one."""

_HOP, _WINDOW = RATE // 100, 3 * RATE // 100  # samples between two levels, and that each of them is of
_ABOVE_DB: Final = 9.0  # how far a voice stands out from the noise of its room, at the least
_BELOW_DB: Final = 32.0  # what is so much quieter than its loudest moment is none of it
_PAUSE_S: Final = 0.4  # within a phrase
_MARGIN_S: Final = 0.06  # soft sounds with which it begins and ends
_NEAR_S: Final = 0.3  # to a voice: what is further away is the room
_HOW: Final = "the phrase once and nothing else, close to the microphone, where it is quiet."


def phrase_in(recording: Sound, name: str, vad: VoiceActivity) -> Sound:
    """The part of a recording in which the phrase is said. Raises ``UsageError``, with the recording's ``name``, where
    nobody speaks, or for so long that it is no phrase."""
    spoken = _spoken(recording, vad)
    levels = _levels(recording)
    voiced = np.flatnonzero(levels > _threshold(levels, spoken)) if spoken.any() else np.zeros(0, np.int64)
    groups = [group for group in _groups(voiced) if spoken[group].any()]
    if not groups:
        raise UsageError(f"Nobody is heard to speak in {name}.", hint=f"Record it again: {_HOW}")
    said = max(groups, key=lambda group: int(spoken[group].sum()))
    length_s = (said[-1] - said[0]) * _HOP / RATE
    if not LEAST_S <= length_s <= MOST_S:
        hint = f"A phrase takes {LEAST_S:g} to {MOST_S:g} s. Record it again: {_HOW}"
        raise UsageError(f"The voice in {name} is heard for {length_s:.1f} s.", hint=hint)
    margin = round(_MARGIN_S * RATE)
    return recording[max(0, said[0] * _HOP - margin) : said[-1] * _HOP + _WINDOW + margin]


def _spoken(recording: Sound, vad: VoiceActivity) -> NDArray[np.bool_]:
    """For each level, whether somebody speaks then."""
    peak = float(np.abs(recording).max(initial=1e-6))
    framer = Framer()
    vad.reset()
    frames = framer.push(to_int16(recording * np.float32(LOUD / peak)))
    speech = np.array([vad.process(frame).speech for frame in (*frames, *framer.flush())], np.bool_)
    starts = np.arange(_levels_of(len(recording))) * _HOP
    return speech[starts // FRAME_SAMPLES] if len(speech) else np.zeros(len(starts), np.bool_)


def _levels(recording: Sound) -> NDArray[np.float64]:
    """How loud it is, every 10 ms, dB."""
    swing = recording - np.mean(recording, dtype=np.float64) if len(recording) else recording  # some cards add a shift
    energy = np.concatenate(([0.0], np.cumsum(np.square(swing, dtype=np.float64))))
    starts = np.arange(_levels_of(len(recording))) * _HOP
    means = (energy[np.minimum(starts + _WINDOW, len(recording))] - energy[starts]) / _WINDOW
    return np.asarray(10 * np.log10(np.maximum(means, 1e-12)))


def _levels_of(samples: int) -> int:
    return max(0, -(-(samples - _WINDOW) // _HOP) + 1) if samples else 0


def _threshold(levels: NDArray[np.float64], spoken: NDArray[np.bool_]) -> float:
    """From which level on it is a voice, dB. A recording in which there is nothing of the room is all voice."""
    near = round(_NEAR_S * RATE / _HOP)
    about = np.convolve(spoken, np.ones(2 * near + 1))[near : near + len(spoken)]
    room = levels[about < 0.5]
    quietest = float(levels[spoken].max()) - _BELOW_DB
    return max(quietest, float(np.percentile(room, 75)) + _ABOVE_DB) if len(room) else quietest


def _groups(voiced: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Levels without a long pause among them."""
    return np.split(voiced, np.flatnonzero(np.diff(voiced) > _PAUSE_S * RATE / _HOP) + 1) if len(voiced) else []
