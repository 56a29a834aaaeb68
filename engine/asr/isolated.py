"""A recogniser in a process of its own, so that nothing in the engine's process ever waits for it.

Whisper's Python parts hold the interpreter lock for tens of milliseconds, and loading a model does for hundreds: long
enough to make a stop late and a robot believe that its engine has gone. Here the one who asks waits for a socket, which
leaves the lock to others, and a crash of native code or a lack of memory ends a child instead of the engine.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from config.schema import Asr
from engine.asr.recogniser import RecogniserLost, Rejected, Transcript
from engine.asr.whisper import WhisperRecogniser
from engine.asr.wire import (
    ANSWERS,
    Accepted,
    Answer,
    Cancel,
    Declined,
    Failed,
    Garbage,
    Loaded,
    Transcribe,
    Weigh,
    Weighed,
    Wire,
)
from engine.child import Child
from engine.errors import ModelError, ProcessError
from engine.lead import Lead

ANSWER_LIMIT_S = 120.0
"""s after which a process that neither answers nor ends counts as lost; the slowest machine needs less for anything."""
_WORKER = "engine.asr.worker"
_LOOK_S = 0.02  # between two looks whether the answer is still needed
_EPITAPH_S = 1.0  # from the end of the link to the end of the process
_AGAIN = "Say it again: it is started anew. If it keeps happening, try a smaller asr.model."


class IsolatedRecogniser:
    """A :class:`engine.asr.whisper.WhisperRecogniser` in a child process, which ends with whoever made it.

    A process that is lost is replaced when something is asked for the next time.
    """

    takes_lead = True

    def __init__(self, folder: Path, settings: Asr) -> None:
        self.name = WhisperRecogniser(folder, settings).name  # cheap as long as it loads nothing
        self._arguments = (f"--folder={folder}", f"--settings={settings.model_dump_json()}")
        self._changing = threading.Lock()  # guards the three below, of which close() in another thread makes use
        self._child: Child | None = None
        self._working = False
        self._closed = False
        self._wire: Wire[Answer] | None = None  # once the child is ready
        self._number = 0  # of the last request

    @property
    def pid(self) -> int | None:
        """Of the recogniser process, if there is one."""
        child = self._child
        return child.pid if child is not None else None

    def load(self) -> None:
        """Start the process and wait until its model is loaded. Raises ``ModelError``."""
        with self._work():
            self._ready()

    def transcribe(
        self,
        samples: NDArray[np.float32],
        vocabulary: Sequence[str] = (),
        cancelled: Callable[[], bool] = lambda: False,
        *,
        quick: bool = False,
        lead: Lead | None = None,
    ) -> Transcript | Rejected:
        """Recognise one utterance; see ``Recogniser``."""
        before = (lead.text, lead.samples.tobytes()) if lead is not None else None

        def request(number: int) -> Transcribe:
            return Transcribe(number, _raw(samples), tuple(vocabulary), quick, before)

        with self._work():
            answer = self._asked(request, cancelled)
            match answer:
                case Accepted(number, transcript) if number == self._number:
                    return transcript
                case Declined(number, rejected) if number == self._number:
                    return rejected
            raise self._nonsense(repr(answer))

    def likelihood(
        self, samples: NDArray[np.float32], texts: Sequence[str], cancelled: Callable[[], bool] = lambda: False
    ) -> float | None:
        """How likely it is that one of the texts was said and nothing else; see ``Recogniser``."""
        with self._work():
            answer = self._asked(lambda number: Weigh(number, _raw(samples), tuple(texts)), cancelled)
            match answer:
                case Weighed(number, likelihood) if number == self._number:
                    return likelihood
            raise self._nonsense(repr(answer))

    def close(self) -> None:
        """End the process at once. Thread-safe; who waits for an answer gets a ``ModelError`` instead."""
        with self._changing:
            self._closed = True
            if self._child is not None:
                self._child.kill()
            if not self._working:
                self._bury()

    # In the thread that asks

    @contextmanager
    def _work(self) -> Iterator[None]:
        """Own the child; one that could not do its work, or was closed meanwhile, is not left behind."""
        with self._changing:
            self._refuse_if_closed()
            self._working = True
        try:
            yield
        except BaseException:  # whatever it was: the next request must not meet the answer to this one
            with self._changing:
                self._bury()
            raise
        finally:
            with self._changing:
                self._working = False
                if self._closed:
                    self._bury()

    def _ready(self) -> Wire[Answer]:
        """The link to a process that has loaded its model. Raises ``ModelError``."""
        with self._changing:
            self._refuse_if_closed()
            if self._child is not None and self._child.epitaph() is not None:
                self._bury()  # nobody was waiting for it, so nothing is lost but time
            if self._wire is not None:
                return self._wire
            try:
                self._child = child = Child("recogniser", _WORKER, self._arguments)
            except ProcessError as error:
                raise RecogniserLost(error.message, hint=_AGAIN) from error
        wire = Wire(child.link, ANSWERS)
        answer = self._answer(wire)
        if not isinstance(answer, Loaded):
            raise self._nonsense(repr(answer))
        self._wire, self.name = wire, answer.name or self.name
        return wire

    def _asked(self, request: Callable[[int], Transcribe | Weigh], cancelled: Callable[[], bool]) -> Answer:
        """What the process answers to the request with a new number. Raises ``ModelError``."""
        wire = self._ready()
        self._number += 1
        try:
            wire.send(request(self._number), ANSWER_LIMIT_S)
        except TimeoutError:
            raise self._silence() from None
        except OSError as error:
            raise self._loss() from error
        return self._answer(wire, cancelled)

    def _answer(self, wire: Wire[Answer], cancelled: Callable[[], bool] = lambda: False) -> Answer:
        """Wait for the next answer; a process that nobody needs to answer is told so, once. Raises ``ModelError``,
        also the one that is the answer."""
        deadline = time.monotonic() + ANSWER_LIMIT_S
        told = False
        try:
            while (answer := wire.receive(_LOOK_S)) is None:
                if time.monotonic() > deadline:
                    raise self._silence()
                if not told and cancelled():
                    told = True
                    wire.send(Cancel(self._number), ANSWER_LIMIT_S)
        except Garbage as garbage:
            raise self._nonsense(str(garbage)) from garbage
        except (EOFError, OSError) as error:
            raise self._loss() from error
        if isinstance(answer, Failed):
            raise ModelError(answer.message, hint=answer.hint)
        return answer

    def _refuse_if_closed(self) -> None:
        if self._closed:
            raise _closed()

    def _bury(self) -> None:
        """Leave nothing of the process."""
        child, self._child, self._wire = self._child, None, None
        if child is not None:
            child.discard()

    def _loss(self) -> ModelError:
        """Why there is nobody at the other end."""
        if self._closed:
            return _closed()
        assert self._child is not None, "only this thread takes it away"
        why = self._child.epitaph(wait=_EPITAPH_S) or "The recogniser process closed its connection."
        return RecogniserLost(why, hint=_AGAIN)

    @staticmethod
    def _silence() -> ModelError:
        return RecogniserLost(f"The recogniser process has not answered for {ANSWER_LIMIT_S:g} s.", hint=_AGAIN)

    @staticmethod
    def _nonsense(what: str) -> ModelError:
        return RecogniserLost(f"The recogniser process sent something unreadable: {what}.", hint=_AGAIN)


def _raw(samples: NDArray[np.float32]) -> bytes:
    return samples.astype(np.float32, copy=False).tobytes()


def _closed() -> ModelError:
    return ModelError("The recogniser has been closed.")
