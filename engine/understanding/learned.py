"""The learned reader: finds the meaning of a request with a small network, on one core, in some milliseconds.

The network writes symbols and points at words (``training/network.py``); a grammar allows only what is a meaning
(``symbols.py``). How sure it is, is the product of the likelihoods of all that it wrote, each against that of what it
is certain of. A third graph tells whether the words are said to the robot at all (``training/directed.py``).
"""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from heapq import heappop, heappush
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
UNDIRECTED: Final = 0.1
"""What is less likely to be said to the robot than this, is not."""
_NO_ORDER: Final = frozenset({"about", "instead", "not", "retract"})
ENOUGH: Final = 0.9
"""Of all likelihood: once meanings make that up, no further one is looked for."""
LEAST: Final = 0.02
"""How likely a meaning is that is worth looking at."""
SPANS: Final = 3
"""Places that the words of a role are looked for at."""
MAX_RUNS: Final = 80
"""Steps of the decoder for one text: about 15 ms."""


class _Parts(NamedTuple):
    base: Base
    encoder: Any  # onnxruntime.InferenceSession
    decoder: Any
    directed: Any


class _Sentence(NamedTuple):
    """What the encoder gives."""

    units: list[Unit]
    spans: Floats  # (1, units, WIDTH)
    fixed: dict[str, Any]
    """What the decoder gets at every step."""


class LearnedReader:
    """Thread-safe. It is loaded when it is first asked, in about 0.5 s, and takes about 90 MB then."""

    def __init__(self, base: Path, folder: Path) -> None:
        """``base`` is the file of the encoder, ``folder`` has the graphs."""
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
                graphs = (_session(self._folder / f"{name}.onnx") for name in ("encoder", "decoder", "directed"))
                self._loaded = _Parts(Base(self._base), *graphs)
            return self._loaded

    def read(self, text: str) -> Meaning | None:
        """The likeliest meaning; None where :meth:`readings` finds none."""
        return next(iter(self.readings(text)), None)

    def readings(self, text: str) -> tuple[Meaning, ...]:
        """What the text may mean, the likeliest first; the confidence of each is how likely it is. Nothing where there
        is no word in the text, or far too many, and as long as the base is not on this machine."""
        if not self.here or self.trouble is not None:
            return ()
        try:
            parts = self.load()
        except Exception as error:  # noqa: BLE001 - onnxruntime has errors of its own for a damaged graph
            self.trouble = error
            return ()
        sentence = _sentence(text, parts)
        if sentence is None:
            return ()
        directed = float(parts.directed.run(None, {"spans": sentence.spans})[0][0])
        found = _search(text, sentence.units, parts.decoder, sentence.fixed, sentence.spans)
        return tuple(replace(meaning, directed=directed) for meaning in found)

    def vectors(self, text: str) -> Floats | None:
        """Vectors of the units of the text (units, 384), of which a network can be trained; None as for
        :meth:`readings`. Raises as :meth:`load`."""
        sentence = _sentence(text, self.load())
        return None if sentence is None else sentence.spans[0]


def _sentence(text: str, parts: _Parts) -> _Sentence | None:
    found = units(text)
    if not 0 < len(found) <= MAX_UNITS:
        return None
    pieces, owners = parts.base.pieces(found)
    if len(pieces) > MAX_PIECES:
        return None
    pool = np.zeros((1, len(found), len(pieces)), np.float32)
    for index, owner in enumerate(owners):
        if owner >= 0:
            pool[0, owner, index] = 1 / owners.count(owner)
    spans, starts, ends, *rest = parts.encoder.run(None, {"words": parts.base.vectors(pieces)[None], "pool": pool})
    fixed: dict[str, Any] = {"starts_of": starts, "ends_of": ends}
    fixed |= {f"sentence_{kind}{at // 2}": rest[at] for at, kind in enumerate("kv" * LAYERS)}
    return _Sentence(found, spans, fixed)


@dataclass(frozen=True, slots=True)
class _Begun:
    """The beginning of a meaning. ``symbol`` is its last one, whose words, if it is a role, are not yet found."""

    likely: float
    symbol: int
    span: Floats
    """What was pointed at in the step before: (1, 1, WIDTH)."""
    past: Sequence[Floats]
    steps: tuple[Step, ...]
    grammar: Grammar
    order: float = 1.0
    """How likely it is that no more of the text than this is no order."""


def _search(text: str, found: list[Unit], decoder: Any, fixed: dict[str, Any], spans: Floats) -> Iterator[Meaning]:
    """Meanings, the likeliest first: of all that is begun, the likeliest goes on (a best-first search)."""
    past = [np.zeros((1, HEADS, 0, WIDTH // HEADS), np.float32)] * 2 * LAYERS
    count, runs, known = 0, 0, 0.0
    begun: list[tuple[float, int, _Begun | Meaning]] = [
        (-1.0, count, _Begun(1.0, IDS[BEGIN], _NOWHERE, past, (), Grammar()))
    ]
    while begun and known < ENOUGH and runs < MAX_RUNS:
        _, _, at = heappop(begun)
        if isinstance(at, Meaning):
            known += at.confidence
            yield at
            continue
        runs += 1
        for following in _steps_after(at, text, found, decoder, fixed, spans):
            count += 1
            likely = following.confidence if isinstance(following, Meaning) else following.likely
            heappush(begun, (-likely, count, following))


_NOWHERE: Final = np.zeros((1, 1, WIDTH), np.float32)
"""What is pointed at where nothing is."""


def _steps_after(
    at: _Begun, text: str, found: list[Unit], decoder: Any, fixed: dict[str, Any], spans: Floats
) -> Iterator[_Begun | Meaning]:
    """How the beginning of a meaning may go on, where that is likely enough."""
    inputs = {"symbol": np.array([[at.symbol]]), "place": np.array([len(at.steps)]), "span": at.span, **fixed}
    inputs |= {f"past_{kind}{index // 2}": at.past[index] for index, kind in enumerate("kv" * LAYERS)}
    symbols, starts, ends, *past = decoder.run(None, inputs)
    pointed: list[tuple[float, tuple[Step, ...], Floats]]
    if SYMBOLS[at.symbol] in ROLE_NAMES:
        pointed = [
            (
                likely,
                (*at.steps[:-1], Step(SYMBOLS[at.symbol], found[begin].start, found[end].end)),
                (spans[:, begin] + spans[:, end])[:, None],
            )
            for likely, begin, end in _spans(starts[0, 0], ends[0, 0])
        ]
    else:
        pointed = [(1.0, at.steps, _NOWHERE)]
    allowed = at.grammar.allowed()
    likelihoods = _softmax(symbols[0, 0, [IDS[name] for name in allowed]])
    no_order = sum(float(likely) for name, likely in zip(allowed, likelihoods, strict=True) if name in _NO_ORDER)
    for likely, steps, span in pointed:
        for name, chance in zip(allowed, likelihoods, strict=True):
            sure = at.likely * (likely * min(1.0, float(chance) / CERTAIN))
            if sure < LEAST:
                continue
            order = at.order if name in _NO_ORDER else at.order * (1 - no_order)
            if name == DONE:
                yield meaning_of(text, steps, "learned", sure, 1 - order)
            elif len(steps) < MAX_STEPS - 1:
                grammar = at.grammar.copy()
                grammar.feed(name)
                yield _Begun(sure, IDS[name], span, past, (*steps, Step(name)), grammar, order)


def _spans(starts: Floats, ends: Floats) -> list[tuple[float, int, int]]:
    """The likeliest first and last units, the last one not before the first, and how likely each is."""
    both = np.triu(np.outer(_softmax(starts), _softmax(ends)))
    best = np.argsort(both, axis=None)[: -SPANS - 1 : -1]
    places = (np.unravel_index(int(place), both.shape) for place in best)
    return [(float(both[place]), int(place[0]), int(place[1])) for place in places]


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
