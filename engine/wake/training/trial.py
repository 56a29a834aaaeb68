"""Trying a head: how often it hears the phrase, how late, and what else it takes for it.

A recording is tried as the microphone would deliver it, window by window; what is heard twice within a second counts
once, as it does when sayso listens.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.wake.embedding import RATE, SPAN, STEP, Stacks
from engine.wake.head import Trial
from engine.wake.training.sound import Chance, loudness, noise, with_noise
from engine.wake.training.voices import Sound

LATE_S: Final = 0.6
"""A phrase that is heard later than this after its end does not count as heard, s."""
NEAR: Final = 0.15
"""The share of what is like the phrase that may be taken for it: nobody says so all day."""
ENOUGH: Final[dict[str, float]] = {"clean": 0.9, "10 dB": 0.75}
"""The share of phrases that a head should hear, at least."""
SLACK: Final = 0.01
"""The share of phrases that a head may hear less for the sake of false alarms that nobody has seen yet."""
TOO_NEAR: Final = 0.25
"""From this share of what is like the phrase, one takes it for too much."""
TOO_OFTEN: Final = 4.0
"""False alarms an hour of people who talk without a pause: all that is tried is speech, as no home is."""
REFRACTORY: Final = round(1.0 * RATE / STEP)
THRESHOLDS: Final = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.94, 0.97, 0.985, 0.993, 0.997)
CONDITIONS: Final[dict[str, float | None]] = {"clean": None, "10 dB": 10.0, "5 dB": 5.0}
_SPEECH: Final = 0.08  # loudness of a phrase when it is tried

Probabilities = NDArray[np.float32]
Judge = Callable[[NDArray[np.float32]], Probabilities]


@dataclass(frozen=True, slots=True)
class Heard:
    """What a network said to phrases (per condition, one row each) and to everything else (one array a recording)."""

    phrases: dict[str, list[Probabilities]]
    after_s: list[float]  # when the first of each row of those is, after the end of its phrase, s
    near: list[Probabilities]  # of what is like the phrase, one row each
    others: list[Probabilities]  # of other sound, one a recording
    hours: float  # of that


@dataclass(frozen=True, slots=True)
class Rows:
    """What a network gets to see of phrases."""

    of: dict[str, list[NDArray[np.float32]]]  # by condition
    after_s: list[float]  # see Heard


@dataclass(frozen=True, slots=True)
class Point:
    """What a threshold would lead to."""

    threshold: float
    recall: dict[str, float]
    near: float  # the share of what is like the phrase that is taken for it
    alarms: int


def phrase_rows(
    phrases: Sequence[Sound],
    stacks: Callable[[Sound], Stacks],
    chance: Chance,
    babble: Sequence[Sound],
    conditions: Sequence[str] = tuple(CONDITIONS),
) -> Rows:
    """Each phrase in each condition: windows that end from 0.3 s before it ends to ``LATE_S`` after."""
    rows: dict[str, list[NDArray[np.float32]]] = {condition: [] for condition in conditions}
    after_s = []
    for phrase in phrases:
        word = phrase * np.float32(_SPEECH / max(loudness(phrase), 1e-9))
        before = max(0, SPAN + 4 * STEP - len(word)) + int(chance.integers(STEP))
        room = np.concatenate((np.zeros(before), word, np.zeros(round(LATE_S * RATE))))
        room = room.astype(np.float32) + chance.normal(0, 1e-4, len(room)).astype(np.float32)
        for condition in conditions:
            snr = CONDITIONS[condition]
            sound = room
            if snr is not None:
                sound = with_noise(room, snr, _SPEECH, noise(len(room), chance, babble))
            rows[condition].append(stacks(sound))
        after_s.append((SPAN - before - len(word)) / RATE)
    return Rows(rows, after_s)


def judged(judge: Judge, phrases: Rows, near: Rows, others: Sequence[NDArray[np.float32]]) -> Heard:
    """What a network says to all of it."""
    return Heard(
        {condition: [judge(rows) for rows in several] for condition, several in phrases.of.items()},
        phrases.after_s,
        [judge(rows) for rows in near.of["clean"]],
        [judge(rows) for rows in others if len(rows)],
        sum(len(rows) for rows in others) * STEP / RATE / 3600,
    )


def points(heard: Heard, thresholds: Sequence[float] = THRESHOLDS) -> list[Point]:
    """One for each threshold."""
    return [
        Point(
            threshold,
            {
                name: float(np.mean([one.max() >= threshold for one in several]))
                for name, several in heard.phrases.items()
            },
            float(np.mean([one.max() >= threshold for one in heard.near])) if heard.near else 0.0,
            sum(alarms(one, threshold) for one in heard.others),
        )
        for threshold in thresholds
    ]


def alarms(probabilities: Probabilities, threshold: float) -> int:
    """How often a recording would wake."""
    count, next_at = 0, 0
    for at in np.flatnonzero(probabilities >= threshold):
        if at >= next_at:
            count, next_at = count + 1, int(at) + REFRACTORY
    return count


def chosen(found: Sequence[Point], hours: float, alarms_an_hour: float) -> Point:
    """The lowest threshold that keeps to so many false alarms and tells most of what is like the phrase from it, and a
    higher one where that costs next to nothing of what is heard: in so little sound few false alarms show themselves.
    Where it would not hear enough, the highest that does."""
    fit = [point for point in found if point.alarms <= alarms_an_hour * hours and point.near <= NEAR]
    first = fit[0] if fit else found[-1]
    heard = [point for point in found if all(point.recall[name] >= least for name, least in ENOUGH.items())]
    if heard and heard[-1].threshold < first.threshold:
        return heard[-1]
    higher = [point for point in found if point.threshold >= first.threshold]
    return [point for point in higher if all(point.recall[name] >= first.recall[name] - SLACK for name in ENOUGH)][-1]


def doubts(trial: Trial) -> list[str]:
    """What speaks against listening for it, in sentences; none where nothing does."""
    found = []
    for name, least in ENOUGH.items():
        if trial.recall[name] < least:
            where = "in a quiet room" if name == "clean" else f"over noise ({name})"
            found.append(f"It is heard only {trial.recall[name]:.0%} of the time {where}.")
    if trial.near > TOO_NEAR:
        found.append(f"It takes {trial.near:.0%} of what is like the phrase for it.")
    if trial.alarms > 1 and trial.alarms_an_hour > TOO_OFTEN:  # one in so little sound proves nothing
        found.append(f"It would wake by itself about {trial.alarms_an_hour:.0f} times in an hour of talk.")
    return found


def delays(heard: Heard, threshold: float, condition: str = "clean") -> list[float]:
    """How long after its end each phrase that is heard is known, s."""
    found = []
    for one, after_s in zip(heard.phrases[condition], heard.after_s, strict=True):
        at = np.flatnonzero(one >= threshold)
        if len(at):
            found.append(after_s + float(at[0]) * STEP / RATE)
    return found


def as_trial(heard: Heard, threshold: float) -> Trial:
    """The figures of one threshold."""
    (point,) = points(heard, (threshold,))
    return Trial(point.recall, len(heard.phrases["clean"]), point.near, point.alarms, round(heard.hours, 3))
