"""Trains what tells whether words are said to the robot at all: ``directed.onnx``.

A microphone hears talk between people, a television, and words that a recogniser has made of noise. The reader finds a
meaning in all of it. This small network looks at the same vectors of the sentence as the decoder does, and tells what
was said to the robot from what it overhears: talk, and words in no order (the field calls it device-directed speech
detection). It is trained behind the reader, from its exported graphs, in a few minutes:
``python -m engine.understanding.training.directed``."""

from __future__ import annotations

import random
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Final

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from config import paths
from engine.models.store import ModelStore
from engine.understanding.base import MODEL, WIDTH, Floats
from engine.understanding.learned import UNDIRECTED, LearnedReader
from engine.understanding.training.examples import ASSETS, HABITS, SENTENCES, Variations, habits, language_of, written
from engine.understanding.training.export import export_directed

INNER: Final = 32
EPOCHS: Final = 12
BATCH: Final = 256
RATE: Final = 1e-3
SHUFFLED: Final = {"en": 12000, "zh": 4000}
"""Sentences of words in no order, for each language."""
TWISTED: Final = 6000
"""Sentences of talk in which the recogniser is thought to have misheard words."""
MISHEARD: Final = 0.35
"""How many of their words."""
OVERHEARD: Final = "overheard"
"""The folder of sentences that are said to others."""
TALK: Final = 4
"""How many times each of them counts."""
_WORD: Final = re.compile(r"[A-Za-z']+|[\u3400-\u9fff]")


class Directed(nn.Module):
    """From the vectors of units, as the encoder's graph gives them (batch, units, 384), how likely it is that the words
    are said to the robot (batch,)."""

    def __init__(self) -> None:
        super().__init__()
        self.scale, self.offset = (nn.Parameter(torch.zeros(3 * WIDTH), requires_grad=False) for _ in range(2))
        self.inner, self.last = nn.Linear(3 * WIDTH, INNER), nn.Linear(INNER, 1)
        self.before, self.drop = nn.Dropout(0.1), nn.Dropout(0.3)

    def forward(self, spans: Tensor) -> Tensor:
        return torch.sigmoid(self.score(torch.cat((spans.mean(1), spans.amax(1), spans.amin(1)), 1)))

    def score(self, pooled: Tensor) -> Tensor:
        x = self.before(pooled * self.scale + self.offset)
        return self.last(self.drop(functional.relu(self.inner(x))))[:, 0]


class Shuffled:
    """Makes sentences that say nothing, of the words of sentences that do."""

    def __init__(self, texts: Sequence[str], chance: random.Random) -> None:
        self._chance = chance
        self._words = {language: self._of(texts, language) for language in SHUFFLED}
        self._all = {language: sorted(set(words)) for language, words in self._words.items()}
        self._texts = {language: [text for text in texts if language_of(text) == language] for language in SHUFFLED}

    def sentence(self, language: str) -> str:
        """Words in no order, as a recogniser writes them; at times behind the beginning of a real sentence."""
        chance, zh = self._chance, language == "zh"
        words = self._words[language] if chance.random() < 0.4 else self._all[language]
        made = [chance.choice(words) for _ in range(chance.randint(3, 11))]
        if chance.random() < 0.3:
            made = [*_WORD.findall(chance.choice(self._texts[language]))[: chance.randint(1, 3)], *made]
        comma = "，" if zh else ","
        text = ("" if zh else " ").join(word + (comma if chance.random() < 0.15 else "") for word in made).strip(comma)
        if chance.random() < 0.6:
            return f"{text[:1].upper()}{text[1:]}{chance.choice('。。？' if zh else '..?')}"
        return text.lower()

    def misheard(self, text: str) -> str:
        """``text`` with other words in it."""
        of = self._all[language_of(text)]
        return _WORD.sub(lambda word: self._chance.choice(of) if self._chance.random() < MISHEARD else word[0], text)

    def _of(self, texts: Iterable[str], language: str) -> list[str]:
        of_it = (text for text in texts if language_of(text) == language)
        if language == "en":
            return [word for text in of_it for word in re.findall(r"[A-Za-z']+", text)]
        runs = [run for text in of_it for run in re.findall(r"[\u3400-\u9fff]+", text)]
        return [run[at : at + 2] for run in runs for at in range(0, len(run), 2)]


def train(folder: Path, base: Path, held_out: Sequence[str], seed: int = 1) -> None:
    """Train on the sentences, but for the files named ``held_out``, with the graphs in ``folder``, and write the third
    one beside them."""
    chance = random.Random(seed)
    torch.manual_seed(seed)
    reader = LearnedReader(base, folder)
    export_directed(Directed(), folder)  # the reader is whole only with it
    files = [file for file in sorted(SENTENCES.glob("*/*.txt")) if file.parent.name != "from_meanings"]
    learnt, talk, held = (
        written(file for file in files if (file.stem in held_out, file.parent.name == OVERHEARD) == of)
        for of in ((False, False), (False, True), (True, False))
    )
    varied = [example.text for example in Variations(learnt, habits(HABITS), chance).epoch()]
    others = [example.text for example in Variations(talk, habits(HABITS), chance).epoch()]
    shuffled = Shuffled([example.text for example in (*learnt, *talk)], chance)
    nothing = [shuffled.sentence(language) for language, count in SHUFFLED.items() for _ in range(count)]
    nothing += [shuffled.misheard(chance.choice(talk).text) for _ in range(TWISTED)]
    _tell(f"{len(varied)} sentences said to it, {len(others)} to others, and {len(nothing)} that say nothing")
    pooled = _pooled(reader.vectors)
    said, unsaid = pooled(varied), torch.cat((pooled(others).repeat(TALK, 1), pooled(nothing)))
    network = Directed()
    network.scale.data = 1 / (said.std(0) + 1e-3)
    network.offset.data = -said.mean(0) * network.scale
    _fit(network, torch.cat((said, unsaid)), torch.cat((torch.ones(len(said)), torch.zeros(len(unsaid)))))
    network.eval()
    with torch.no_grad():
        likely = torch.sigmoid(network.score(pooled(example.text for example in held)))
    _tell(f"of {len(held)} held out {float((likely < UNDIRECTED).float().mean()):.1%} are taken for overheard")
    export_directed(network, folder)


def _pooled(vectors: Callable[[str], Floats | None]) -> Callable[[Iterable[str]], Tensor]:
    def of(texts: Iterable[str]) -> Tensor:
        found = (vectors(text) for text in texts)
        rows = [np.concatenate((of.mean(0), of.max(0), of.min(0))) for of in found if of is not None]
        return torch.from_numpy(np.stack(rows))

    return of


def _fit(network: Directed, inputs: Tensor, wanted: Tensor) -> None:
    optimiser = torch.optim.AdamW([p for p in network.parameters() if p.requires_grad], RATE, weight_decay=0.05)
    network.train()
    for _ in range(EPOCHS):
        order = torch.randperm(len(inputs))
        for start in range(0, len(order), BATCH):
            rows = order[start : start + BATCH]
            loss = functional.binary_cross_entropy_with_logits(network.score(inputs[rows]), wanted[rows])
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()


def _tell(line: str) -> None:
    sys.stderr.write(f"{line}\n")
    sys.stderr.flush()


if __name__ == "__main__":
    store = ModelStore(paths().models)
    train(ASSETS, store.find(MODEL) / store.file(MODEL).name, held_out=("09", "79"))
