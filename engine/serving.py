"""What this machine can do, for other programs: its recogniser and its voice as a Wyoming server.

Home Assistant, a satellite or whoever else speaks Wyoming asks what there is (``describe``), sends sound and gets words
(``transcribe``), or sends a text and gets sound (``synthesize``). No robot is involved. The protocol has neither keys
nor passwords, so it is served on loopback unless somebody says otherwise; what visitors may cost is limited, and one
who breaks a limit, or speaks something else, is told why and shown out (``engine.visit``).
"""

from __future__ import annotations

import asyncio
import ipaddress
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import aclosing, suppress
from types import TracebackType
from typing import Final
from urllib.parse import urlsplit

import numpy as np
from numpy.typing import NDArray

from engine import wyoming
from engine.asr.recogniser import Rejected, Transcript
from engine.asr.transcription import Transcription
from engine.errors import DeviceError, SaysoError, UsageError
from engine.tts.sentences import Sentence
from engine.tts.synthesis import Piece
from engine.visit import Offer, Unacceptable, Visit

VISITORS: Final = 16
"""Connections at a time."""
IDLE_S: Final = 5.0
"""A visitor that has asked nothing for so long gives its seat to a newcomer when all are taken, s."""
GOODBYE_S: Final = 5.0
"""How long somebody who is shown out may take to leave, s."""


class Server:
    """Serves an offer while it is entered. ``tell`` is told of each request, in a sentence without what was said."""

    def __init__(self, offer: Offer, address: str, tell: Callable[[str], None] = lambda words: None) -> None:
        """``address``: tcp://HOST:PORT; a port of 0 is any that is free. Raises ``UsageError``."""
        self.offer = offer
        self.tell = tell
        self._host, self._port = parsed(address)
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="recogniser")
        self._speaking = asyncio.Lock()
        self._server: asyncio.Server | None = None
        self._visits: set[asyncio.Task[None]] = set()
        self._seated: list[Visit] = []

    async def __aenter__(self) -> Server:
        """Raises ``DeviceError`` where nothing can be served at that address."""
        try:
            self._server = await asyncio.start_server(self._knock, self._host, self._port, limit=wyoming.LINE_BYTES)
        except OSError as error:
            why = (
                os.strerror(error.errno) if error.errno and error.errno > 0 else str(error)
            )  # names have codes below 0
            hint = "Choose another address with --uri."
            raise DeviceError(f"Nothing can be served at {self.address}: {why}.", hint=hint) from error
        self._port = self._server.sockets[0].getsockname()[1]
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._server is not None:
            self._server.close()
        for visit in self._visits:
            visit.cancel()
        await asyncio.gather(*self._visits, return_exceptions=True)
        self._thread.shutdown(wait=False, cancel_futures=True)

    @property
    def address(self) -> str:
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"tcp://{host}:{self._port}"

    def _knock(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        visit = asyncio.get_running_loop().create_task(self._receive(reader, writer), name="wyoming")
        self._visits.add(visit)
        visit.add_done_callback(self._visits.discard)

    async def _receive(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """One visitor, from the first word to the last."""
        from wyoming.error import Error

        try:
            try:
                visit = Visit(self, reader, writer)
                self._make_room()
                self._seated.append(visit)
                try:
                    await visit.stay()
                finally:
                    if visit in self._seated:
                        self._seated.remove(visit)
            except (Unacceptable, wyoming.NotWyoming) as error:
                code = error.code if isinstance(error, Unacceptable) else "not-wyoming"
                self.tell(f"A visitor was shown out: {error}")
                async with asyncio.timeout(GOODBYE_S):
                    await wyoming.write(writer, Error(str(error), code))
                    writer.write_eof()
                    while await reader.read(wyoming.LINE_BYTES):
                        pass  # with something unread the connection would be reset, and the error lost on its way
        except TimeoutError:  # no longer there in spirit
            writer.transport.abort()  # closing would wait until they have taken what is still to be sent
        except (OSError, EOFError):
            pass  # gone
        finally:
            writer.close()

    def _make_room(self) -> None:
        """Have the visitor leave who has asked nothing for longest, where every seat is taken. Raises
        ``Unacceptable``."""
        if len(self._seated) < VISITORS:
            return
        idlest = max(self._seated, key=lambda visit: visit.idle_s)
        if idlest.idle_s < IDLE_S:
            raise Unacceptable("busy", f"{VISITORS} others are served already.")
        self._seated.remove(idlest)
        idlest.give_way()

    async def recognise(self, samples: NDArray[np.int16], names: Sequence[str]) -> Transcript | Rejected:
        """Raises ``SaysoError``. Visitors are served one after the other; one who leaves is not waited for."""
        recogniser = self.offer.recogniser
        assert recogniser is not None, "nobody is told that there is one"
        sound = samples * np.float32(1 / 32768)
        work = Transcription(lambda cancelled: recogniser.transcribe(sound, names, cancelled))
        try:
            found = await asyncio.shield(asyncio.get_running_loop().run_in_executor(self._thread, work.run))
        except asyncio.CancelledError:
            work.cancel()
            raise
        if isinstance(found, SaysoError):
            raise found
        return found

    async def say(self, sentence: Sentence) -> list[Piece]:
        """Raises ``SaysoError``. All of a sentence, so that a visitor who takes it slowly keeps nobody waiting."""
        voice = self.offer.voice
        assert voice is not None, "nobody is told that there is one"
        async with self._speaking, aclosing(voice.synthesise(sentence)) as pieces:
            return [piece async for piece in pieces]


def parsed(address: str) -> tuple[str, int]:
    """Host and port of tcp://HOST:PORT. Raises ``UsageError``."""
    try:
        parts = urlsplit(address)
        if parts.scheme == "tcp" and parts.hostname and parts.port is not None and not parts.path:
            return parts.hostname, parts.port
    except ValueError:  # a port that is none
        pass
    raise UsageError(f"{address!r} is no address to serve at.", hint="For example: tcp://127.0.0.1:10300")


def is_private(address: str) -> bool:
    """Only programs on this machine can reach it. Raises ``UsageError``."""
    host, _ = parsed(address)
    with suppress(ValueError):
        return ipaddress.ip_address(host).is_loopback
    return host == "localhost"
