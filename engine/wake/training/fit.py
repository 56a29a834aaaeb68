"""Training a perceptron, with numpy alone: Adam (Kingma and Ba 2015), dropout at the input, a falling step."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from engine.wake.head import Layer

WIDTH: Final = 64
BATCH: Final = 512
_DECAY, _DECAY_SQUARE, _TINY = 0.9, 0.999, 1e-8  # Adam's own
_WEIGHT_DECAY: Final = 1e-4

Array = NDArray[np.float32]


def fit(
    stacks: Array,
    wanted: Array,
    weights: Array,
    *,
    epochs: int,
    seed: int,
    on_epoch: Callable[[int, float], None] = lambda epoch, loss: None,
    step: float = 2e-3,
    dropout: float = 0.5,
) -> tuple[Layer, ...]:
    """A network that says ``wanted`` (0 or 1) of each row of ``stacks``; ``weights`` says how much each row counts.
    ``on_epoch`` is told after each pass how large the loss was. What it looks at need not be standardised: the first
    layer does that. Few epochs and much dropout: a network that knows its synthetic voices by heart takes real people
    for the phrase."""
    chance = np.random.default_rng(seed)
    mean, scale = stacks.mean(0), stacks.std(0) + np.float32(1e-3)
    sizes = (stacks.shape[1], WIDTH, WIDTH, 1)
    values = [
        part
        for fan_in, fan_out in itertools.pairwise(sizes)
        for part in (
            chance.normal(0, np.sqrt(2 / fan_in), (fan_in, fan_out)).astype(np.float32),
            np.zeros(fan_out, np.float32),
        )
    ]
    with threadpool_limits(1):  # of matrices this small, two threads that wait for each other make forty times the work
        _descend(values, (mean, scale), stacks, wanted, weights, chance, epochs, step, dropout, on_epoch)
    values[1] = values[1] - (mean / scale) @ values[0]
    values[0] = values[0] / scale[:, None]
    return tuple(zip(values[::2], values[1::2], strict=True))


def _descend(
    values: list[Array],
    standard: tuple[Array, Array],
    stacks: Array,
    wanted: Array,
    weights: Array,
    chance: np.random.Generator,
    epochs: int,
    step: float,
    dropout: float,
    on_epoch: Callable[[int, float], None],
) -> None:
    """Make the values better, in place; ``standard`` is mean and scale of what the first layer gets."""
    mean, scale = standard
    first, second = [np.zeros_like(value) for value in values], [np.zeros_like(value) for value in values]
    total, done = epochs * -(-len(stacks) // BATCH), 0
    for epoch in range(epochs):
        order, losses = chance.permutation(len(stacks)), 0.0
        for begin in range(0, len(order), BATCH):
            rows = order[begin : begin + BATCH]
            inputs = (stacks[rows] - mean) / scale
            inputs *= (chance.random(inputs.shape, np.float32) > dropout) / np.float32(1 - dropout)
            loss, slopes = _slopes(values, inputs, wanted[rows], weights[rows])
            losses += loss * len(rows)
            done += 1
            rate = step * 0.5 * (1 + np.cos(np.pi * done / total))
            for index, slope in enumerate(slopes):
                first[index] += (1 - _DECAY) * (slope - first[index])
                second[index] += (1 - _DECAY_SQUARE) * (slope * slope - second[index])
                mended = first[index] / (1 - _DECAY**done)
                spread = np.sqrt(second[index] / (1 - _DECAY_SQUARE**done)) + _TINY
                values[index] -= np.float32(rate) * (mended / spread + _WEIGHT_DECAY * values[index])
        on_epoch(epoch + 1, losses / len(order))


def _slopes(values: list[Array], inputs: Array, wanted: Array, weights: Array) -> tuple[float, list[Array]]:
    """The mean cross-entropy, and how it changes with each of the values."""
    w0, b0, w1, b1, w2, b2 = values
    one = np.maximum(inputs @ w0 + b0, 0)
    two = np.maximum(one @ w1 + b1, 0)
    logits = (two @ w2 + b2)[:, 0]
    share = weights / weights.sum()
    loss = float(np.sum(share * (np.logaddexp(0, logits) - wanted * logits)))
    out = ((1 / (1 + np.exp(-logits)) - wanted) * share)[:, None].astype(np.float32)
    at_two = (out @ w2.T) * (two > 0)
    at_one = (at_two @ w1.T) * (one > 0)
    return loss, [inputs.T @ at_one, at_one.sum(0), one.T @ at_two, at_two.sum(0), two.T @ out, out.sum(0)]
