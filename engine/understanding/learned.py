"""The learned reader: finds the meaning of a request with a small network, on one core, in some milliseconds.

The network writes symbols and points at words (``training/network.py``); a grammar allows only what is a meaning
(``symbols.py``). How sure it is, is the product of the likelihoods of all that it wrote, each against that of what it
is certain of.
"""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from engine.understanding.base import MAX_PIECES, WIDTH, Base, Floats
from engine.understanding.meaning import Meaning, meaning_of
from engine.understanding.notation import Step
from engine.understanding.symbols import BEGIN, DONE, IDS, MAX_STEPS, ROLE_NAMES, SYMBOLS, Grammar
from engine.understanding.units import Unit, units

LAYERS: Final = 2
"""Of the decoder; the network is made with the same."""
HEADS: Final = 6
MAX_UNITS: Final = 90
CERTAIN: Final = 0.95
"""How likely a symbol is of which the network is certain: training lets it be no surer (label smoothing)."""
_NO_ORDER: Final = frozenset({"about", "instead", "not", "retract"})
_NO_ORDER_IDS: Final = tuple(IDS[symbol] for symbol in sorted(_NO_ORDER))


class _Parts(NamedTuple):
    base: Base
    encoder: Any  # onnxruntime.InferenceSession
    decoder: Any


class LearnedReader:
    """Thread-safe. It is loaded when it is first asked, in about 0.5 s, and takes about 90 MB then."""

    def __init__(self, base: Path, folder: Path) -> None:
        """``base`` is the file of the encoder, ``folder`` has both graphs."""
        self._base, self._folder = base, folder
        self._lock = threading.Lock()
        self._loaded: _Parts | None = None
        self.trouble: Exception | None = None
        """Why it cannot be loaded; then it reads nothing."""

    def close(self) -> None:
        """Let go of the graphs; it reads nothing after that."""
        with self._lock:
            self._loaded, self.trouble = None, RuntimeError("The reader is closed.")

    @property
    def here(self) -> bool:
        """Whether its base is on this machine."""
        return self._loaded is not None or self._base.is_file()

    def load(self) -> _Parts:
        """Load it now. Raises OSError, ``BaseError``, and what onnxruntime raises where a graph is damaged."""
        with self._lock:
            if self._loaded is None:
                self._loaded = _Parts(
                    Base(self._base), _session(self._folder / "encoder.onnx"), _session(self._folder / "decoder.onnx")
                )
            return self._loaded

    def read(self, text: str) -> Meaning | None:
        """The likeliest meaning; None where there is no word in the text, or far too many, and as long as the base is
        not on this machine."""
        found = units(text)
        if not 0 < len(found) <= MAX_UNITS or not self.here or self.trouble is not None:
            return None
        try:
            parts = self.load()
        except Exception as error:  # noqa: BLE001 - onnxruntime has errors of its own for a damaged graph
            self.trouble = error
            return None
        pieces, owners = parts.base.pieces(found)
        if len(pieces) > MAX_PIECES:
            return None
        pool = np.zeros((1, len(found), len(pieces)), np.float32)
        for index, owner in enumerate(owners):
            if owner >= 0:
                pool[0, owner, index] = 1 / owners.count(owner)
        inputs = {"words": parts.base.vectors(pieces)[None], "pool": pool}
        spans, starts, ends, *sentence = parts.encoder.run(None, inputs)
        fixed: dict[str, Any] = {"starts_of": starts, "ends_of": ends}
        fixed |= {f"sentence_{kind}{at // 2}": sentence[at] for at, kind in enumerate("kv" * LAYERS)}
        return _written(text, found, parts.decoder, fixed, spans)


def _written(text: str, found: list[Unit], decoder: Any, fixed: dict[str, Any], spans: Floats) -> Meaning | None:
    grammar, steps = Grammar(), list[Step]()
    past = [np.zeros((1, HEADS, 0, WIDTH // HEADS), np.float32)] * 2 * LAYERS
    symbol, span, sure = IDS[BEGIN], np.zeros((1, 1, WIDTH), np.float32), 1.0
    order = 1.0
    for place in range(MAX_STEPS):
        inputs = {"symbol": np.array([[symbol]]), "place": np.array([place]), "span": span, **fixed}
        inputs |= {f"past_{kind}{at // 2}": past[at] for at, kind in enumerate("kv" * LAYERS)}
        symbols, starts, ends, *past = decoder.run(None, inputs)
        span = np.zeros((1, 1, WIDTH), np.float32)
        if SYMBOLS[symbol] in ROLE_NAMES:
            begin, end, likely = _span(starts[0, 0], ends[0, 0])
            sure *= likely
            steps[-1] = Step(SYMBOLS[symbol], found[begin].start, found[end].end)
            span = (spans[:, begin] + spans[:, end])[:, None]
        allowed = [IDS[name] for name in grammar.allowed()]
        scores = symbols[0, 0, allowed]
        likelihoods = _softmax(scores)
        best = int(likelihoods.argmax())
        if SYMBOLS[allowed[best]] not in _NO_ORDER:
            order *= 1 - sum(float(likelihoods[allowed.index(one)]) for one in _NO_ORDER_IDS if one in allowed)
        symbol, sure = allowed[best], sure * min(1.0, float(likelihoods[best]) / CERTAIN)
        if SYMBOLS[symbol] == DONE:
            return meaning_of(text, steps, "learned", sure, 1 - order)
        grammar.feed(SYMBOLS[symbol])
        steps.append(Step(SYMBOLS[symbol]))
    return None


def _span(starts: Floats, ends: Floats) -> tuple[int, int, float]:
    """The likeliest first and last unit, the last one not before the first, and how likely they are."""
    both = np.triu(np.outer(_softmax(starts), _softmax(ends)))
    begin, end = np.unravel_index(int(both.argmax()), both.shape)
    return int(begin), int(end), float(both[begin, end])


def _softmax(scores: Floats) -> Floats:
    exponentials = np.exp(scores - scores.max())
    return np.asarray(exponentials / exponentials.sum(), np.float32)


def _session(file: Path) -> Any:
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    options.inter_op_num_threads = 1
    options.log_severity_level = 3
    session = onnxruntime.InferenceSession(str(file), options, providers=["CPUExecutionProvider"])
    if session.get_modelmeta().custom_metadata_map.get("symbols", "").split() != list(SYMBOLS):
        raise ValueError(f"{file.name} was trained with other symbols; train it anew: make reader")
    return session
