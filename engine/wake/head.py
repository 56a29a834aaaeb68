"""A head: the small network that tells from the last 1.6 s of the speech embedding whether a phrase has just ended.

A head is one file (.npz, nothing in it is ever executed) with its weights, the phrase, the threshold from which it
counts, who trained it, and how it did when others tried it. Several networks vote: each is a perceptron with two
hidden layers.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from engine.errors import ModelError, StorageError
from engine.wake.embedding import SIZE, STACK, Stacks

FORMAT: Final = 1
Layer = tuple[NDArray[np.float32], NDArray[np.float32]]
"""Weights (in, out) and biases (out)."""


@dataclass(frozen=True, slots=True)
class Trial:
    """How a head did with voices that it was not trained on."""

    recall: Mapping[str, float]  # "clean", "10 dB", "5 dB": the share of phrases that it heard
    said: int  # phrases that each of them is a share of
    near: float  # the share of what is like it that it took for it
    alarms: int  # how often it heard the phrase in what was something else
    hours: float  # how long that was

    @property
    def alarms_an_hour(self) -> float:
        return self.alarms / self.hours if self.hours else 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Head:
    """The networks for one phrase."""

    phrase: str
    threshold: float  # 0…1
    networks: Sequence[Sequence[Layer]]
    delay_s: float = 0.0  # from the end of the phrase to when it is known, as a median
    trial: Trial | None = None
    made_of: str = ""  # a sentence about what it was trained with
    trained_by: tuple[str, ...] = ()  # speakers whom it knows: whoever tries it is none of them; empty: nobody knows
    steps: int = 1  # rows, the newest, whose mean counts: what is only like the phrase is so for a moment

    def probabilities(self, stacks: Stacks) -> NDArray[np.float32]:
        """How likely it is that the phrase has just ended, for each row; they follow one another, and the first have
        fewer before them than the mean is made of."""
        votes = np.mean([_run(layers, stacks) for layers in self.networks], axis=0)
        sums = np.cumsum(votes, dtype=np.float64)
        sums[self.steps :] -= sums[: -self.steps].copy()
        means = sums / np.minimum(np.arange(1, len(votes) + 1), self.steps)
        return np.asarray(1 / (1 + np.exp(-means)), np.float32)

    def save(self, file: Path) -> None:
        """Write it; either all of it is there, or what was there before. Raises ``StorageError``."""
        arrays: dict[str, Any] = {
            f"{kind}{network}_{layer}": values.astype(np.float16)
            for network, layers in enumerate(self.networks)
            for layer, pair in enumerate(layers)
            for kind, values in zip("wb", pair, strict=True)
        }
        about = {
            "format": FORMAT,
            "phrase": self.phrase,
            "threshold": self.threshold,
            "delay_s": self.delay_s,
            "trial": None if self.trial is None else asdict(self.trial),
            "made_of": self.made_of,
            "trained_by": self.trained_by,
            "steps": self.steps,
        }
        partial = file.with_name(f".{file.name}.partial")
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            with partial.open("wb") as stream:
                np.savez_compressed(stream, about=np.array(json.dumps(about)), **arrays)
            partial.replace(file)
        except OSError as error:
            raise StorageError(f"{file}: {error.strerror or error}.", hint="Can you write there?") from error
        finally:
            with contextlib.suppress(OSError):
                partial.unlink()

    @classmethod
    def load(cls, file: Path) -> Head:
        """Read one. Raises ``ModelError``."""
        try:
            with np.load(file, allow_pickle=False) as arrays:
                about = json.loads(str(arrays["about"]))
                if about["format"] != FORMAT:
                    raise ValueError(f"format {about['format']}")
                weights = {name: arrays[name].astype(np.float32) for name in arrays.files if name != "about"}
                trial = about["trial"]
                return cls(
                    str(about["phrase"]),
                    float(about["threshold"]),
                    _networks(weights),
                    float(about["delay_s"]),
                    None if trial is None else Trial(**trial),
                    str(about["made_of"]),
                    tuple(about.get("trained_by", ())),
                    max(1, int(about.get("steps", 1))),
                )
        except Exception as error:  # what is damaged fails in many ways, in zip, zlib, numpy's headers or JSON
            hint = "Train it again: sayso wake train PHRASE"
            raise ModelError(f"{file} is no head for a wake word: {error}.", hint=hint) from error


def _run(layers: Sequence[Layer], values: NDArray[np.float32]) -> NDArray[np.float32]:
    for weights, biases in layers[:-1]:
        values = np.maximum(values @ weights + biases, 0)
    weights, biases = layers[-1]
    return np.asarray((values @ weights + biases)[:, 0])


def _networks(arrays: Mapping[str, NDArray[np.float32]]) -> tuple[tuple[Layer, ...], ...]:
    """Put together, and checked: a head of another shape would fail in the midst of listening."""
    found: list[tuple[Layer, ...]] = []
    while f"w{len(found)}_0" in arrays:
        layers: list[Layer] = []
        width = STACK * SIZE
        while (name := f"{len(found)}_{len(layers)}") and f"w{name}" in arrays:
            weights, biases = arrays[f"w{name}"], arrays[f"b{name}"]
            if weights.ndim != 2 or weights.shape[0] != width or biases.shape != weights.shape[1:]:
                raise ValueError(f"layer {name} does not fit the one before")
            layers.append((weights, biases))
            width = weights.shape[1]
        if width != 1:
            raise ValueError("a network has to end in one number")
        found.append(tuple(layers))
    if not found:
        raise ValueError("there are no weights in it")
    return tuple(found)
