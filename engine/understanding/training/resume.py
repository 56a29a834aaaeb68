"""Puts the weights of exported graphs back into a network, so that training goes on from them.

They are those of eight bits. Symbols that the graphs did not know begin as they are in the new network."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import onnx
import torch
from onnx import ModelProto, numpy_helper

from engine.understanding.base import Floats
from engine.understanding.symbols import IDS
from engine.understanding.training.export import GRAPHS, export_plain
from engine.understanding.training.network import Network

_OF_SYMBOLS = ("decoder.symbols.weight", "decoder.next.weight", "decoder.next.bias")
"""What has a row for each symbol."""


def resume(network: Network, folder: Path) -> None:
    """Take the weights of the graphs in ``folder``. Raises OSError, and ValueError where they are another network's."""
    graphs = [onnx.load(folder / name) for name in GRAPHS]
    weights = dict[str, Floats]()
    with TemporaryDirectory() as temporary:
        export_plain(network, Path(temporary))
        for name, graph in zip(GRAPHS, graphs, strict=True):
            weights |= _named(graph) | _multiplied(graph, onnx.load(Path(temporary) / name), network)
    known = {found.key: found.value for found in graphs[0].metadata_props}["symbols"].split()
    state = network.state_dict()
    missing = [name for name in state if name not in weights]
    if missing:
        raise ValueError(f"{folder} has no {missing[0]}")
    for name, parameter in state.items():
        new = torch.from_numpy(weights[name])
        if name in _OF_SYMBOLS:
            for row, symbol in enumerate(known):
                if symbol in IDS:
                    parameter[IDS[symbol]] = new[row]
        else:
            parameter.copy_(new)


def _named(graph: ModelProto) -> dict[str, Floats]:
    """Tensors that keep their name, and embeddings."""
    tensors = {tensor.name: numpy_helper.to_array(tensor) for tensor in graph.graph.initializer}
    named = {name.removeprefix("network."): values for name, values in tensors.items()}
    for name in [name for name in named if name.endswith(".weight_quantized")]:
        plain = name.removesuffix("_quantized")
        named[plain] = _whole(named[name], named[f"{plain}_scale"], named[f"{plain}_zero_point"])
    return {name: np.array(values, np.float32) for name, values in named.items()}


def _multiplied(graph: ModelProto, plain: ModelProto, network: Network) -> dict[str, Floats]:
    """Matrices, which have lost their names: in the order in which they are multiplied they are those of ``plain``."""
    known = {
        parameter.detach().numpy().T.tobytes(): name
        for name, parameter in network.named_parameters()
        if parameter.ndim == 2
    }
    at = {tensor.name: numpy_helper.to_array(tensor) for tensor in plain.graph.initializer}
    order = [node.input[1] for node in plain.graph.node if node.op_type == "MatMul" and node.input[1] in at]
    tensors = {tensor.name: numpy_helper.to_array(tensor) for tensor in graph.graph.initializer}
    found = [node.input[1] for node in graph.graph.node if node.op_type == "MatMulInteger"]
    if len(found) != len(order):
        raise ValueError(f"{len(found)} matrices, not {len(order)}")
    weights = dict[str, Floats]()
    for name, quantised in zip(order, found, strict=True):
        of = quantised.removesuffix("_quantized")
        whole = _whole(tensors[quantised], tensors[f"{of}_scale"], tensors[f"{of}_zero_point"])
        weights[known[at[name].tobytes()]] = np.ascontiguousarray(whole.T)
    return weights


def _whole(quantised: Floats, scale: Floats, zero: Floats) -> Floats:
    return np.asarray((quantised.astype(np.float32) - zero.astype(np.float32)) * scale, np.float32)
