"""The voice process: ``python -m engine.tts.worker``, started by :class:`engine.tts.isolated.IsolatedVoice`.

It loads one voice, says so, and synthesises one sentence after the other. A thread of its own listens to the engine all
the time, so that what nobody wants to hear any more is given up at the next chance, and an engine that goes takes this
process with it at once.
"""

from __future__ import annotations

import argparse
import os
import queue
import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from typing import Protocol

from engine.errors import ModelError
from engine.messages import LENGTH_BYTES, packed
from engine.tts.sentences import Sentence
from engine.tts.synthesis import Piece
from engine.tts.wire import (
    REQUESTS,
    Answer,
    Cancel,
    Done,
    Failed,
    Loaded,
    Request,
    Sound,
    Speak,
)


class Backend(Protocol):
    """A library that synthesises. Blocking, for one thread."""

    def load(self) -> None:
        """Load the voice and warm it up. Raises ``ModelError``."""
        ...

    def speak(self, sentence: Sentence, cancelled: Callable[[], bool]) -> Iterator[Piece]:
        """The sound of a sentence, in pieces; ends early once ``cancelled`` is true. Raises ``ModelError``."""
        ...


class Requests:
    """What the engine asks for, from the first moment until it goes, which ends this process."""

    def __init__(self, link: socket.socket) -> None:
        self._read = link.makefile("rb")
        self._waiting: queue.SimpleQueue[Speak] = queue.SimpleQueue()
        self._cancelled = 0  # number of the last sentence that nobody needs any more
        threading.Thread(target=self._listen, name="requests", daemon=True).start()

    def next(self) -> Speak:
        return self._waiting.get()

    def is_cancelled(self, request: Speak) -> bool:
        return self._cancelled >= request.number

    def _listen(self) -> None:
        while (request := self._request()) is not None:
            if isinstance(request, Cancel):
                self._cancelled = request.number
            else:
                self._waiting.put(request)
        os._exit(0)  # the main thread may be synthesising, and nobody waits for what comes of it

    def _request(self) -> Request | None:
        try:
            length = self._read.read(LENGTH_BYTES)
            data = self._read.read(int.from_bytes(length, "little")) if length else b""
        except OSError:
            return None
        return REQUESTS.decode(data) if data else None


def serve(backend: Backend, link: socket.socket) -> ModelError:
    """Load the voice, say so, and synthesise until there is an error; that error."""
    requests = Requests(link)

    def send(answer: Answer) -> None:
        link.sendall(packed(answer))

    try:
        backend.load()
        send(Loaded())
        while True:
            request = requests.next()
            for piece in backend.speak(request.sentence, lambda: requests.is_cancelled(request)):  # noqa: B023
                send(Sound(request.number, piece.samples.tobytes(), piece.rate, piece.said))
            send(Done(request.number))
    except ModelError as error:
        send(Failed(error.message, error.hint))
        return error


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m engine.tts.worker", description="Internal to sayso.")
    parser.add_argument("--link", type=int, required=True, help="an inherited file descriptor")
    parser.add_argument("--backend", choices=("piper", "espeak"), required=True)
    parser.add_argument("--voice", default="", help="of piper, the file of a voice; of espeak, a name")
    parser.add_argument("--speed", type=float, default=1.0)
    args = parser.parse_args(argv)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the engine's business
    link = socket.socket(fileno=args.link)
    backend: Backend
    if args.backend == "piper":
        from engine.tts.piper import Piper

        backend = Piper(args.voice, args.speed)
    else:
        from engine.tts.espeak import Espeak

        backend = Espeak(args.voice, args.speed)
    return int(serve(backend, link).exit_code)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
