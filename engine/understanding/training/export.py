"""Writes a trained network as the two graphs that run: ``encoder.onnx`` and ``decoder.onnx``, in eight bits; and the
small one that tells what is said to the robot: ``directed.onnx``."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import onnx
import torch
from onnxruntime.quantization import QuantType, quantize_dynamic
from torch import Tensor, nn

from engine.understanding.base import WIDTH
from engine.understanding.learned import HEADS, LAYERS
from engine.understanding.symbols import SYMBOLS
from engine.understanding.training.network import POINTING, Network

GRAPHS: Final = ("encoder.onnx", "decoder.onnx")
DIRECTED: Final = "directed.onnx"


class Reading(nn.Module):
    """The sentence: vectors of its units in the forms that the decoder needs."""

    def __init__(self, network: Network) -> None:
        super().__init__()
        self.network = network

    def forward(self, words: Tensor, pool: Tensor) -> tuple[Tensor, ...]:
        network, decoder = self.network, self.network.decoder
        units = pool @ network.encoder(words, torch.zeros(1, 1, 1, 1))
        keys = tuple(part for layer in decoder.layers for part in layer.sentence.keys(units))
        return (decoder.span(units), decoder.starts(units), decoder.ends(units), *keys)


class Writing(nn.Module):
    """One step of the decoder."""

    def __init__(self, network: Network) -> None:
        super().__init__()
        self.decoder = network.decoder

    def forward(
        self, symbol: Tensor, place: Tensor, span: Tensor, starts: Tensor, ends: Tensor, *rest: Tensor
    ) -> tuple[Tensor, ...]:
        sentence, past = rest[: 2 * LAYERS], rest[2 * LAYERS :]
        x = self.decoder.embed(symbol, place, span)
        now: list[Tensor] = []
        nothing = torch.zeros(1, 1, 1, 1)
        for index, layer in enumerate(self.decoder.layers):
            y = layer.before_own(x)
            k, v = layer.own.keys(y)
            k, v = torch.cat((past[2 * index], k), 2), torch.cat((past[2 * index + 1], v), 2)
            now += [k, v]
            x = x + layer.own.attend(y, k, v, nothing)
            x = layer.rest(x, (sentence[2 * index], sentence[2 * index + 1]), nothing)
        return (*self.decoder.heads(x, starts, ends), *now)


def names(of: str) -> list[str]:
    """The names of keys and values of each layer."""
    return [f"{of}_{kind}{index}" for index in range(LAYERS) for kind in "kv"]


def export(network: Network, folder: Path) -> None:
    """Write both graphs."""
    folder.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as temporary:
        plain = Path(temporary)
        export_plain(network, plain)
        for name in GRAPHS:
            quantize_dynamic(
                plain / name, folder / name, per_channel=True, reduce_range=True, weight_type=QuantType.QInt8
            )
            sign(folder / name)


def export_plain(network: Network, folder: Path) -> None:
    """Write both graphs as they are trained, in 32 bits."""
    network.eval()
    width = WIDTH // HEADS
    with torch.no_grad():
        span, pointing = torch.zeros(1, 1, WIDTH), torch.zeros(1, 5, POINTING)
        keys = [torch.zeros(1, HEADS, 5, width)] * 2 * LAYERS
        past = [torch.zeros(1, HEADS, 3, width)] * 2 * LAYERS
        torch.onnx.export(
            Reading(network), (torch.zeros(1, 7, WIDTH), torch.zeros(1, 5, 7)), str(folder / GRAPHS[0]),
            input_names=["words", "pool"], output_names=["spans", "starts", "ends", *names("sentence")],
            dynamic_axes={"words": {1: "pieces"}, "pool": {1: "units", 2: "pieces"}}, dynamo=False, opset_version=17,
        )  # fmt: skip
        torch.onnx.export(
            Writing(network),
            (torch.zeros(1, 1).long(), torch.zeros(1).long(), span, pointing, pointing, *keys, *past),
            str(folder / GRAPHS[1]),
            input_names=["symbol", "place", "span", "starts_of", "ends_of", *names("sentence"), *names("past")],
            output_names=["symbols", "starts", "ends", *names("now")],
            dynamic_axes={"starts_of": {1: "units"}, "ends_of": {1: "units"},
                          **{name: {2: "units"} for name in names("sentence")},
                          **{name: {2: "before"} for name in names("past")}},
            dynamo=False, opset_version=17,
        )  # fmt: skip


def export_directed(network: nn.Module, folder: Path) -> None:
    """Write the graph that tells whether something is said to the robot."""
    torch.onnx.export(
        network, (torch.zeros(1, 5, WIDTH),), str(folder / DIRECTED),
        input_names=["spans"], output_names=["directed"], dynamic_axes={"spans": {1: "units"}},
        dynamo=False, opset_version=17,
    )  # fmt: skip
    sign(folder / DIRECTED)


def sign(file: Path) -> None:
    """Write the symbols into a graph that it was trained with: it means nothing with others."""
    graph = onnx.load(file)
    onnx.helper.set_model_props(graph, {"symbols": " ".join(SYMBOLS)})
    onnx.save(graph, file)
