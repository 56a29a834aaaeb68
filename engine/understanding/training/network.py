"""The learned reader as a network: a pretrained encoder, and a small decoder that points into the sentence.

The encoder gives every unit of the sentence a vector. The decoder writes the meaning symbol by symbol; at each role it
points at the units with which that role begins and ends, so that no word can be invented (Rongali et al. 2020, "Don't
Parse, Generate!"). What it pointed at goes into the next step.
"""

from __future__ import annotations

import math
from typing import Final

import torch
from torch import Tensor, nn
from torch.nn import functional

from engine.understanding.base import WIDTH, Base
from engine.understanding.learned import HEADS, LAYERS
from engine.understanding.symbols import MAX_STEPS, SYMBOLS

INNER: Final = 512
POINTING: Final = 128
EPSILON: Final = 1e-12


class Attention(nn.Module):
    """Multi-head attention; ``mask`` is added to the scores."""

    def __init__(self, heads: int) -> None:
        super().__init__()
        self.heads = heads
        self.q, self.k, self.v, self.out = (nn.Linear(WIDTH, WIDTH) for _ in range(4))

    def keys(self, over: Tensor) -> tuple[Tensor, Tensor]:
        return self._split(self.k(over)), self._split(self.v(over))

    def attend(self, x: Tensor, k: Tensor, v: Tensor, mask: Tensor) -> Tensor:
        mixed = functional.scaled_dot_product_attention(self._split(self.q(x)), k, v, mask)
        return self.out(mixed.transpose(1, 2).flatten(2))

    def forward(self, x: Tensor, over: Tensor, mask: Tensor) -> Tensor:
        return self.attend(x, *self.keys(over), mask)

    def _split(self, x: Tensor) -> Tensor:
        return x.unflatten(2, (self.heads, WIDTH // self.heads)).transpose(1, 2)


class EncoderLayer(nn.Module):
    """One layer of BERT (normalised after each part)."""

    def __init__(self, heads: int, inner: int, dropout: float) -> None:
        super().__init__()
        self.attention = Attention(heads)
        self.after_attention = nn.LayerNorm(WIDTH, eps=EPSILON)
        self.widen, self.narrow = nn.Linear(WIDTH, inner), nn.Linear(inner, WIDTH)
        self.after_inner = nn.LayerNorm(WIDTH, eps=EPSILON)
        self.drop = nn.Dropout(dropout)

    def forward(self, x: Tensor, mask: Tensor) -> Tensor:
        x = self.after_attention(x + self.drop(self.attention(x, x, mask)))
        return self.after_inner(x + self.drop(self.narrow(functional.gelu(self.widen(x)))))


class Encoder(nn.Module):
    """The first ``layers`` layers of the base, over what ``Base.vectors`` gives for pieces."""

    def __init__(self, base: Base, layers: int, dropout: float) -> None:
        super().__init__()
        self.norm = nn.LayerNorm(WIDTH, eps=EPSILON)
        self.norm.weight.data = torch.from_numpy(base.vector("emb.ln.w"))
        self.norm.bias.data = torch.from_numpy(base.vector("emb.ln.b"))
        self.layers = nn.ModuleList()
        for index in range(layers):
            layer = EncoderLayer(base.heads, base.inner, dropout)
            for name, linear in (
                ("q", layer.attention.q), ("k", layer.attention.k), ("v", layer.attention.v),
                ("ao", layer.attention.out), ("fi", layer.widen), ("fo", layer.narrow),
            ):  # fmt: skip
                linear.weight.data = torch.from_numpy(base.matrix(f"l{index}.{name}.w", linear.in_features))
                linear.bias.data = torch.from_numpy(base.vector(f"l{index}.{name}.b"))
            for name, norm in (("aln", layer.after_attention), ("oln", layer.after_inner)):
                norm.weight.data = torch.from_numpy(base.vector(f"l{index}.{name}.w"))
                norm.bias.data = torch.from_numpy(base.vector(f"l{index}.{name}.b"))
            self.layers.append(layer)

    def forward(self, words: Tensor, mask: Tensor) -> Tensor:
        x = self.norm(words)
        for layer in self.layers:
            x = layer(x, mask)
        return x


class DecoderLayer(nn.Module):
    """Self-attention, attention to the sentence, two linear layers; normalised before each."""

    def __init__(self, dropout: float) -> None:
        super().__init__()
        self.before_own, self.before_sentence, self.before_inner = (nn.LayerNorm(WIDTH) for _ in range(3))
        self.own, self.sentence = Attention(HEADS), Attention(HEADS)
        self.widen, self.narrow = nn.Linear(WIDTH, INNER), nn.Linear(INNER, WIDTH)
        self.drop = nn.Dropout(dropout)

    def forward(self, x: Tensor, own: Tensor, sentence: tuple[Tensor, Tensor], mask: Tensor) -> Tensor:
        y = self.before_own(x)
        x = x + self.drop(self.own(y, y, own))
        return self.rest(x, sentence, mask)

    def rest(self, x: Tensor, sentence: tuple[Tensor, Tensor], mask: Tensor) -> Tensor:
        x = x + self.drop(self.sentence.attend(self.before_sentence(x), *sentence, mask))
        return x + self.drop(self.narrow(functional.gelu(self.widen(self.before_inner(x)))))


class Decoder(nn.Module):
    """Writes symbols, and points at units."""

    def __init__(self, dropout: float) -> None:
        super().__init__()
        self.symbols = nn.Embedding(len(SYMBOLS), WIDTH)
        self.places = nn.Embedding(MAX_STEPS, WIDTH)
        nn.init.normal_(self.symbols.weight, std=0.05)
        nn.init.normal_(self.places.weight, std=0.05)
        self.span = nn.Linear(WIDTH, WIDTH, bias=False)
        self.layers = nn.ModuleList(DecoderLayer(dropout) for _ in range(LAYERS))
        self.norm = nn.LayerNorm(WIDTH)
        self.next = nn.Linear(WIDTH, len(SYMBOLS))
        self.starts, self.ends, self.start_of, self.end_of = (nn.Linear(WIDTH, POINTING, bias=False) for _ in range(4))

    def embed(self, symbols: Tensor, places: Tensor, spans: Tensor) -> Tensor:
        return self.symbols(symbols) + self.places(places) + spans

    def heads(self, x: Tensor, starts: Tensor, ends: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        x = self.norm(x)
        scale = 1 / math.sqrt(POINTING)
        return (
            self.next(x),
            self.start_of(x) @ starts.transpose(1, 2) * scale,
            self.end_of(x) @ ends.transpose(1, 2) * scale,
        )


class Network(nn.Module):
    """Encoder and decoder."""

    def __init__(self, base: Base, *, layers: int, dropout: float = 0.1) -> None:
        super().__init__()
        self.encoder = Encoder(base, layers, dropout)
        self.decoder = Decoder(dropout)
        self.drop = nn.Dropout(dropout)

    def units(self, words: Tensor, padding: Tensor, pool: Tensor) -> Tensor:
        """Vectors of units: (batch, units, 384). ``padding``: 0 or −inf for each piece; ``pool``: (batch, units,
        pieces), whose rows average the pieces of a unit."""
        return pool @ self.encoder(words, padding[:, None, None, :])

    def forward(self, batch: dict[str, Tensor]) -> tuple[Tensor, Tensor, Tensor]:
        """Scores of symbols (batch, steps, symbols) and of first and last units (batch, steps, units)."""
        units = self.drop(self.units(batch["words"], batch["padding"], batch["pool"]))
        decoder = self.decoder
        pick = torch.arange(units.shape[0], device=units.device)[:, None]
        ends = decoder.span(units)
        spans = ends[pick, batch["first"]] + ends[pick, batch["last"]]
        steps = batch["symbols"].shape[1]
        places = torch.arange(steps, device=units.device)
        x = self.drop(decoder.embed(batch["symbols"], places, spans * batch["pointed"][:, :, None]))
        own = torch.full((steps, steps), float("-inf"), device=units.device).triu(1)
        mask = batch["unit_padding"][:, None, None, :]
        for layer in decoder.layers:
            x = layer(x, own, layer.sentence.keys(units), mask)
        symbols, starts, ends = decoder.heads(x, decoder.starts(units), decoder.ends(units))
        return symbols, starts + batch["unit_padding"][:, None, :], ends + batch["unit_padding"][:, None, :]
