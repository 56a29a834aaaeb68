"""How good a trained wake word is, as people read it: the plot of its trial, and its figures."""

from __future__ import annotations

from typing import Final

from engine.wake.head import Head, Trial
from engine.wake.training.trainer import Trained
from engine.wake.training.trial import Point

WIDTH: Final = 38
"""Cells of a bar: all of it fits into 80 columns."""


def plot(trained: Trained) -> str:
    """A line for each threshold: what it hears, and what it takes for the phrase. The one that was chosen has an
    arrow."""
    rows = [f"threshold  {'heard (░ 5 dB, ▓ 10 dB, █ clean)':<{WIDTH}} clean  like it  false alarms"]
    for point in trained.points:
        mark = "→" if point.threshold == trained.head.threshold else " "
        clean, near = f"{point.recall['clean']:5.0%}", f"{point.near:7.0%}"
        rows.append(f"{mark} {point.threshold:7.3f}  {_bar(point)} {clean}  {near}  {point.alarms:12}")
    return "\n".join(rows)


def figures(trial: Trial) -> str:
    """All of its figures, in one line."""
    heard = ", ".join(f"{share:.0%} {name}" for name, share in trial.recall.items())
    return f"heard {heard} of {trial.said}; {trial.near:.0%} of what is like it; {alarms(trial)}"


def alarms(trial: Trial) -> str:
    """How often it woke by itself while it was tried, and in how much. A figure an hour would pretend to know more."""
    minutes = f"{trial.hours * 60:.0f} min of other talk"
    if not trial.hours:
        return "false alarms were not looked for"
    return f"{trial.alarms or 'no'} false alarm{'s' if trial.alarms != 1 else ''} in {minutes}"


def described(head: Head) -> str:
    """What is told of a head that was just trained, below its plot."""
    assert head.trial is not None, "training ends with a trial"
    told = f"{figures(head.trial)}; known {head.delay_s:+.2f} s after its end; threshold {head.threshold:g}"
    return told.replace("; ", "\n")


def _bar(point: Point) -> str:
    ends = [round(point.recall[name] * WIDTH) for name in ("5 dB", "10 dB", "clean")]
    cells = [next((sign for end, sign in zip(ends, "░▓█", strict=True) if at < end), " ") for at in range(WIDTH)]
    return "".join(cells)
