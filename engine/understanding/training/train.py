"""Train the learned reader: ``make reader``, or ``python -m engine.understanding.training.train``.

On two processor cores this takes an hour or so. It learns from the sentences in ``assets/understanding`` and,
where they are at hand, from HuRIC and the grammar of RoboCup's GPSR task. The result is committed: it holds what
training changed. The base is fetched like the other models."""

from __future__ import annotations

import argparse
import math
import random
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

import torch
from torch import Tensor
from torch.nn import functional

from config import paths
from engine.models.store import ModelStore
from engine.understanding.base import MAX_PIECES, MODEL, WIDTH, Base
from engine.understanding.learned import CERTAIN, MAX_UNITS
from engine.understanding.notation import Example
from engine.understanding.symbols import BEGIN, DONE, IDS, MAX_STEPS
from engine.understanding.training import directed, gpsr, huric
from engine.understanding.training.examples import ASSETS, HABITS, SENTENCES, Variations, habits, written
from engine.understanding.training.export import export
from engine.understanding.training.network import Network
from engine.understanding.training.resume import resume
from engine.understanding.units import units

BATCH: Final = 48
LAYERS_OF_BASE: Final = 6
"""Layers of the base that are used; all of them are tuned."""
GRAMMAR: Final = 1200
"""Sentences of the public grammar that are learnt from."""
MADE_UP: Final = "from_meanings"
"""The folder of sentences for meanings that were put together by chance: less natural than the others."""
RATE: Final = {"encoder": 1e-4, "decoder": 4e-4}
RESUMED: Final = 0.45
"""Of the rates, where it goes on from what has been learnt."""


class Encoded:
    """An example in numbers."""

    __slots__ = ("first", "ids", "last", "owners", "steps", "units")

    def __init__(self, example: Example, base: Base) -> None:
        """Raises ValueError where a role has no unit, or the example is too long."""
        found = units(example.text)
        self.units = len(found)
        self.ids, self.owners = base.pieces(found)
        self.steps = [IDS[BEGIN], *(IDS[step.symbol] for step in example.steps), IDS[DONE]]
        self.first, self.last = [-1] * len(self.steps), [-1] * len(self.steps)
        if self.units > MAX_UNITS or len(self.steps) > MAX_STEPS or len(self.ids) > MAX_PIECES or not self.units:
            raise ValueError("too long")
        for index, step in enumerate(example.steps, 1):
            if step.start >= 0:
                inside = [i for i, unit in enumerate(found) if unit.start < step.end and step.start < unit.end]
                if not inside:
                    raise ValueError(f"{step} of {example.text!r} has no word")
                self.first[index], self.last[index] = inside[0], inside[-1]


def batch_of(items: Sequence[Encoded], base: Base) -> dict[str, Tensor]:
    """Tensors of several examples, padded."""
    count, pieces = len(items), max(len(item.ids) for item in items)
    most, steps = max(item.units for item in items), max(len(item.steps) for item in items) - 1
    words = torch.zeros(count, pieces, WIDTH)
    padding, unit_padding = torch.full((count, pieces), -math.inf), torch.full((count, most), -math.inf)
    pool = torch.zeros(count, most, pieces)
    symbols, wanted = torch.zeros(count, steps, dtype=torch.long), torch.full((count, steps), -100)
    first, last = torch.zeros(count, steps, dtype=torch.long), torch.zeros(count, steps, dtype=torch.long)
    pointed = torch.zeros(count, steps)
    starts, ends = torch.full((count, steps), -100), torch.full((count, steps), -100)
    for row, item in enumerate(items):
        words[row, : len(item.ids)] = torch.from_numpy(base.vectors(item.ids))
        padding[row, : len(item.ids)] = 0
        unit_padding[row, : item.units] = 0
        for piece, owner in enumerate(item.owners):
            if owner >= 0:
                pool[row, owner, piece] = 1 / item.owners.count(owner)
        length = len(item.steps) - 1
        symbols[row, :length] = torch.tensor(item.steps[:-1])
        wanted[row, :length] = torch.tensor(item.steps[1:])
        for index in range(length):
            if item.first[index] >= 0:  # this step's role is pointed at here, and known to the next
                starts[row, index], ends[row, index] = item.first[index], item.last[index]
                if index + 1 < length:
                    first[row, index + 1], last[row, index + 1] = item.first[index], item.last[index]
                    pointed[row, index + 1] = 1
    return {
        "words": words, "padding": padding, "pool": pool, "unit_padding": unit_padding, "symbols": symbols,
        "wanted": wanted, "first": first, "last": last, "pointed": pointed, "starts": starts, "ends": ends,
    }  # fmt: skip


def loss_of(network: Network, batch: dict[str, Tensor]) -> Tensor:
    """Cross entropy of symbols and of pointers."""
    symbols, starts, ends = network(batch)
    total = functional.cross_entropy(symbols.flatten(0, 1), batch["wanted"].flatten(), label_smoothing=1 - CERTAIN)
    for scores, wanted in ((starts, batch["starts"]), (ends, batch["ends"])):
        if bool((wanted >= 0).any()):
            total = total + 0.5 * functional.cross_entropy(scores.flatten(0, 1), wanted.flatten())
    return total


def batches(items: list[Encoded], base: Base, chance: random.Random) -> Iterator[dict[str, Tensor]]:
    """All items once, those of like length together."""
    items.sort(key=lambda item: len(item.ids) + len(item.steps) + chance.random() * 6)
    groups = [items[start : start + BATCH] for start in range(0, len(items), BATCH)]
    chance.shuffle(groups)
    for group in groups:
        yield batch_of(group, base)


def encoded(examples: Sequence[Example], base: Base) -> list[Encoded]:
    """All that can be encoded."""
    found = []
    for example in examples:
        try:
            found.append(Encoded(example, base))
        except ValueError:
            continue
    return found


def exact(network: Network, items: list[Encoded], base: Base) -> tuple[float, float]:
    """Share of examples whose every symbol, and every symbol and pointer, is right with the right ones before."""
    network.eval()
    right = whole = 0
    with torch.no_grad():
        for start in range(0, len(items), BATCH):
            batch = batch_of(items[start : start + BATCH], base)
            symbols, starts, ends = network(batch)
            good = ((symbols.argmax(2) == batch["wanted"]) | (batch["wanted"] < 0)).all(1)
            at = batch["starts"]
            there = ((starts.argmax(2) == at) | (at < 0)).all(1) & (
                (ends.argmax(2) == batch["ends"]) | (batch["ends"] < 0)
            ).all(1)
            right += int(good.sum())
            whole += int((good & there).sum())
    network.train()
    return right / max(1, len(items)), whole / max(1, len(items))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=ASSETS, help="folder of the graphs; default: that of the reader")
    parser.add_argument("--public", type=Path, metavar="DIR", help="folder with HuRIC and GPSR, learnt from too")
    parser.add_argument("--leave-out", nargs="*", default=["09", "79"], metavar="NAME", help="files to measure with")
    parser.add_argument("--base", type=Path, help="the encoder's file; default: as `sayso models pull` fetched it")
    parser.add_argument("--epochs", type=int, default=10)
    parser.add_argument("--resume", type=Path, metavar="DIR", help="go on from the graphs in this folder, more gently")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    torch.manual_seed(arguments.seed)
    chance = random.Random(arguments.seed)
    store = ModelStore(paths().models)
    file = arguments.base or store.find(MODEL) / store.file(MODEL).name
    base = Base(file)
    files = sorted(SENTENCES.glob("*/*.txt"))
    kept = [file for file in files if file.stem not in arguments.leave_out]
    learnt = written(file for file in kept if file.parent.name != MADE_UP)
    thinned = written(file for file in kept if file.parent.name == MADE_UP)
    held = encoded(written(file for file in files if file.stem in arguments.leave_out), base)
    if arguments.public is not None:
        learnt += 2 * huric.examples(arguments.public / "huric_en_part.jsonl")[0]
        learnt += gpsr.examples(arguments.public / "gpsr", GRAMMAR, chance)[0]
    _tell(f"{len(learnt) + len(thinned)} sentences to learn from, {len(held)} to measure with")
    network = Network(base, layers=LAYERS_OF_BASE)
    if arguments.resume is not None:
        resume(network, arguments.resume)
    pace = 1.0 if arguments.resume is None else RESUMED
    variations = Variations(learnt, habits(HABITS), chance, thinned)
    for _ in _epochs(network, variations, held, base, chance, arguments.epochs, pace):
        export(network, arguments.out)  # each time: whoever stops it keeps what it has learnt
    directed.train(arguments.out, file, arguments.leave_out, arguments.seed)
    return 0


def _epochs(
    network: Network,
    variations: Variations,
    held: list[Encoded],
    base: Base,
    chance: random.Random,
    epochs: int,
    pace: float,
) -> Iterator[None]:
    steps = epochs * (sum(1 for _ in variations.epoch()) // BATCH + 1)
    optimiser = torch.optim.AdamW(
        [
            {"params": network.encoder.parameters(), "lr": pace * RATE["encoder"]},
            {"params": network.decoder.parameters(), "lr": pace * RATE["decoder"]},
        ],
        weight_decay=0.01,
    )
    warm = max(1, steps // 20)
    schedule = torch.optim.lr_scheduler.LambdaLR(
        optimiser, lambda step: min((step + 1) / warm, max(0.02, (steps - step) / steps))
    )
    began = time.monotonic()
    for epoch in range(1, epochs + 1):
        network.train()
        total = count = 0.0
        for batch in batches(encoded(list(variations.epoch()), base), base, chance):
            loss = loss_of(network, batch)
            optimiser.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
            optimiser.step()
            schedule.step()
            total, count = total + loss.item(), count + 1
        symbols, whole = exact(network, held, base)
        _tell(
            f"epoch {epoch} of {epochs}: loss {total / count:.3f}, held out: symbols {symbols:.1%}, all {whole:.1%}, "
            f"{time.monotonic() - began:.0f} s"
        )
        yield


def _tell(line: str) -> None:
    sys.stderr.write(f"{line}\n")
    sys.stderr.flush()


if __name__ == "__main__":
    sys.exit(main())
