"""The recogniser process: ``python -m engine.asr.worker``, started by :class:`engine.asr.isolated.IsolatedRecogniser`.

It loads Whisper, says so, and answers one utterance after the other. A thread of its own listens to the engine all the
time, so that a cancellation is known in the middle of a decoding and an engine that goes takes this process with it
at once: native code that decodes leaves the interpreter to others.
"""

from __future__ import annotations

import argparse
import os
import queue
import signal
import socket
import sys
import threading
from pathlib import Path

import numpy as np

from config.schema import Asr
from engine.asr import wire as w
from engine.asr.recogniser import Transcript
from engine.asr.whisper import WhisperRecogniser
from engine.asr.wire import Answer, Cancel, Request, Transcribe, Weigh, Wire
from engine.errors import ModelError
from engine.lead import Lead


class Requests:
    """What the engine asks for, from the first moment until it goes, which ends this process."""

    def __init__(self, wire: Wire[Request]) -> None:
        self._wire = wire
        self._waiting: queue.SimpleQueue[Transcribe | Weigh] = queue.SimpleQueue()
        self._cancelled = 0  # number of the last request that nobody needs any more
        threading.Thread(target=self._listen, name="requests", daemon=True).start()

    def next(self) -> Transcribe | Weigh:
        return self._waiting.get()

    def is_cancelled(self, request: Transcribe | Weigh) -> bool:
        return self._cancelled >= request.number

    def _listen(self) -> None:
        try:
            while (request := self._wire.receive()) is not None:
                if isinstance(request, Cancel):
                    self._cancelled = request.number
                else:
                    self._waiting.put(request)
        except EOFError:
            os._exit(0)  # the main thread may be decoding, and nobody waits for what it finds
        except w.Garbage as garbage:
            print(f"The engine does not speak to a recogniser: {garbage}", file=sys.stderr, flush=True)  # noqa: T201
            os._exit(1)


def answer_to(request: Transcribe | Weigh, recogniser: WhisperRecogniser, requests: Requests) -> Answer:
    samples = np.frombuffer(request.samples, np.float32)

    def cancelled() -> bool:
        return requests.is_cancelled(request)

    try:
        if isinstance(request, Weigh):
            return w.Weighed(request.number, recogniser.likelihood(samples, request.texts, cancelled))
        lead = Lead(request.lead[0], np.frombuffer(request.lead[1], np.int16)) if request.lead is not None else None
        found = recogniser.transcribe(samples, request.vocabulary, cancelled, quick=request.quick, lead=lead)
    except ModelError as error:
        return w.Failed(error.message, error.hint)
    return w.Accepted(request.number, found) if isinstance(found, Transcript) else w.Declined(request.number, found)


def main(argv: list[str]) -> int:
    """Load the model, say so, and answer until there is an error."""
    parser = argparse.ArgumentParser(prog="python -m engine.asr.worker", description="Internal to sayso.")
    parser.add_argument("--link", type=int, required=True, help="an inherited file descriptor")
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--settings", required=True, help="settings of speech recognition, JSON")
    args = parser.parse_args(argv)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the engine's business
    link = socket.socket(fileno=args.link)
    wire = Wire(link, w.REQUESTS)  # read by one thread and written by the other
    requests = Requests(wire)
    recogniser = WhisperRecogniser(args.folder, Asr.model_validate_json(args.settings))
    answer: Answer
    try:
        recogniser.load()
        answer = w.Loaded(recogniser.name)
    except ModelError as error:
        answer = w.Failed(error.message, error.hint)
    wire.send(answer)
    while not isinstance(answer, w.Failed):
        answer = answer_to(requests.next(), recogniser, requests)
        wire.send(answer)
    return int(ModelError.exit_code)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
