"""Whether a microphone is too loud or too quiet, judged from a few seconds of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from engine.audio.gain import HEADROOM_DB, HIGHEST_DB, Gain, suitable_gain
from engine.audio.level import decibels, loudness
from engine.audio.source import FRAME_S, Frame
from engine.audio.vad import VoiceActivity

Verdict = Literal["good", "too loud", "too quiet", "noisy", "nobody spoke", "silent"]

CLIPPED = 32_700
"""From this amplitude a sample counts as clipped: converters stop a little below full scale."""

CLIPPED_SHARE = 0.0005
"""From this share of clipped samples a recording is too loud: fewer are a click."""

NEAR_DB = 8.0
"""Speech this much fainter than it should be is heard as well."""

CLEAR_DB = 10.0
"""Speech should stand out from the noise by this: with less, words get lost."""

SILENT_DB = -90.0
"""A device whose loudest sample is below this hears nothing: even a quiet room is louder."""

LISTEN_DB = 40.0
"""A recording is made this much louder at most before speech is looked for in it."""

SPEECH_S = 0.3
"""Less speech than this is none."""


@dataclass(frozen=True, slots=True)
class Calibration:
    """What was measured, and what follows from it. Levels are dB relative to full scale."""

    verdict: Verdict
    advice: str  # a sentence for people
    gain_db: float | None  # what to set; None: no gain would help
    noise_db: float  # of the quietest tenth of the time
    speech_db: float | None  # of the loud parts of speech; None: nobody spoke
    peak_db: float
    clipped: int  # samples
    speech_s: float
    levels: tuple[float, ...]  # of every 32 ms
    voiced: tuple[bool, ...]  # whether speech was heard in them


def calibrate(frames: Sequence[Frame], vad: VoiceActivity) -> Calibration:
    """Judge a recording, at least one frame long, as the microphone gave it."""
    sound = np.concatenate([frame.samples for frame in frames])
    levels = tuple(loudness([frame]).rms_db for frame in frames)
    peak_db = decibels(float(np.abs(sound.astype(np.int32)).max()) / 32768)
    loud = Gain(min(LISTEN_DB, max(0.0, -HEADROOM_DB - peak_db)))  # or faint speech would pass for none
    voiced = tuple(vad.process(loud.apply(frame)).speech for frame in frames)
    spoken = [level for level, speech in zip(levels, voiced, strict=True) if speech]
    speech_s = len(spoken) * FRAME_S
    speech_db = float(np.percentile(spoken, 85)) if speech_s >= SPEECH_S else None
    noise_db = float(np.percentile(levels, 10))
    clipped = int(np.count_nonzero(np.abs(sound.astype(np.int32)) >= CLIPPED))
    gain_db = round(suitable_gain(speech_db, noise_db, peak_db)) if speech_db is not None else None
    verdict, advice = _judged(peak_db, clipped / len(sound), speech_db, noise_db, gain_db)
    return Calibration(
        verdict,
        advice,
        gain_db if verdict in ("good", "too quiet") else None,
        round(noise_db, 1),
        round(speech_db, 1) if speech_db is not None else None,
        peak_db,
        clipped,
        round(speech_s, 2),
        levels,
        voiced,
    )


def _judged(
    peak_db: float, clipped: float, speech_db: float | None, noise_db: float, gain_db: float | None
) -> tuple[Verdict, str]:
    if peak_db < SILENT_DB:
        return "silent", "Nothing at all is heard: the microphone is muted, or it is another one (audio.device)."
    if clipped > CLIPPED_SHARE:
        return "too loud", "It is clipped: lower the input level of the system's mixer; audio.gain_db cannot mend that."
    if speech_db is None or gain_db is None:
        return "nobody spoke", "No speech was heard: try again, and say something while it records."
    if speech_db - noise_db < CLEAR_DB:
        return "noisy", "Speech hardly stands out from the noise: go closer to the microphone, or quieten the room."
    if gain_db > NEAR_DB:
        most = " or raise the input level of the system's mixer" if gain_db >= HIGHEST_DB else ""
        return "too quiet", f"Set audio.gain_db to {gain_db:g} or to auto{most}."
    return "good", "Nothing needs to be set."
