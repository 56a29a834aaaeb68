"""What an engine and its recogniser process say to each other arrives as it was said."""

from __future__ import annotations

import socket
import threading

import numpy as np

from engine.asr.recogniser import Decoding, Rejected, Transcript
from engine.asr.wire import (
    ANSWERS,
    REQUESTS,
    Accepted,
    Answer,
    Cancel,
    Declined,
    Failed,
    Loaded,
    Request,
    Transcribe,
    Weigh,
    Weighed,
    Wire,
)

LIMIT_S = 30.0
"""s for what takes a moment; a test that waits longer has failed."""


def test_questions_and_answers_arrive_as_they_were_sent() -> None:
    decoding = Decoding("en", -0.14285714285714285, 0.1, 1.5, 0.25, 10.0, doubtful=True, only_reading=True)
    engine_end, worker_end = socket.socketpair()
    with engine_end, worker_end:
        engine: Wire[Answer] = Wire(engine_end, ANSWERS)
        worker: Wire[Request] = Wire(worker_end, REQUESTS)
        for request in (
            Transcribe(
                1, np.linspace(-1, 1, 100_000, dtype=np.float32).tobytes(), ("kitchen",), True, ("to", b"\x01\x02")
            ),
            Weigh(2, b"\x00\x00\x80\x3f", ("Stop", "停")),
            Cancel(2),
        ):
            sending = threading.Thread(target=engine.send, args=(request,))  # sound is longer than what a socket holds
            sending.start()
            assert worker.receive(LIMIT_S) == request
            sending.join(LIMIT_S)
        for answer in (
            Loaded("whisper-base (int8, 1 thread)"),
            Accepted(1, Transcript("Go to the kitchen.", 0.8961372086789002, decoding, ("Go to the chicken.", ""))),
            Declined(1, Rejected("no_speech", "The sound is no speech.", "You", decoding)),
            Declined(1, Rejected("too_short", "The sound is too short.")),
            Weighed(2, -0.42958372831344604),
            Weighed(2, None),
            Failed("It cannot be loaded.", "Fetch it."),
        ):
            worker.send(answer)
            assert engine.receive(LIMIT_S) == answer
