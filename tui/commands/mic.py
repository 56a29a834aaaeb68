"""``sayso mic``: raw sound on stdin is heard by the sayso that runs on this machine, as if by its own microphone.

Over SSH it lends a robot the microphone of the machine in front of you:
``arecord -f S16_LE -r 16000 -c 1 -t raw | ssh robot sayso mic``. With ``--wyoming tcp://HOST:10700`` the sound
is that of a Wyoming satellite in the network.
"""

from __future__ import annotations

import asyncio
import os
import sys
import threading
from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager

from config import paths
from config.schema import WYOMING
from engine import wyoming
from engine.audio.feed import feed
from engine.errors import ExitCode, SaysoError, UsageError
from tui.output import say

EXAMPLE = "arecord -f S16_LE -r 16000 -c 1 -t raw | sayso mic"


def run(arguments: Namespace) -> int:
    """Hand sound over until it ends. Exit code 3 when there is nobody to hear it, or nothing to be heard, any more."""
    if arguments.wyoming is not None:
        with _satellite(arguments.wyoming) as sound:
            _feed(sound, f"satellite at {arguments.wyoming.partition('://')[2]}", pauses=True)
        return int(ExitCode.DONE)
    sound = sys.stdin.fileno()
    if os.isatty(sound):
        raise UsageError("sayso mic takes raw sound on stdin (16 kHz, 16-bit, mono).", hint=f"For example: {EXAMPLE}")
    _feed(sound, "ssh microphone" if "SSH_CONNECTION" in os.environ else "piped microphone")
    return int(ExitCode.DONE)


def _feed(sound: int, source: str, *, pauses: bool = False) -> None:
    feed(paths().door, sound, source, lambda pid: say(f"sayso (process {pid}) hears this now."), pauses=pauses)


@contextmanager
def _satellite(address: str) -> Iterator[int]:
    """The end of a pipe through which the sound of a satellite comes, once it streams. Raises what it ended by."""
    from engine.audio.satellite import hear

    if not WYOMING.fullmatch(address):
        raise UsageError(f"{address!r} is no address of a satellite.", hint="For example: tcp://192.168.1.20:10700")
    wyoming.require()
    ours, theirs = os.pipe()
    begun = threading.Event()
    ended: list[SaysoError] = []

    def listen() -> None:
        try:
            asyncio.run(hear(address, lambda pcm: _write(theirs, pcm), begun=begun.set))
        except SaysoError as error:
            ended.append(error)
        finally:
            os.close(theirs)
            begun.set()

    threading.Thread(target=listen, name="satellite", daemon=True).start()
    begun.wait()
    try:
        if ended:
            raise ended[0]
        yield ours
    finally:
        os.close(ours)  # whoever still writes to it ends by that
    if ended:
        raise ended[0]


def _write(pipe: int, pcm: bytes) -> None:
    while pcm:
        pcm = pcm[os.write(pipe, pcm) :]
