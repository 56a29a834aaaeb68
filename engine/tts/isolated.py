"""A voice in a process of its own, kept warm: what is under the GPL stays outside, and a crash of it harms nobody.

The process is started by :meth:`IsolatedVoice.load`, or by the first sentence. One that is lost is replaced when the
next sentence is asked for, unless the last one did not even get ready, a moment ago; it ends with the engine, however
that ends.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator
from math import inf
from typing import Final, Literal

import msgspec
import numpy as np

from engine.child import Child
from engine.errors import ModelError, ProcessError
from engine.messages import LENGTH_BYTES, packed
from engine.tts.sentences import Sentence
from engine.tts.synthesis import Piece, VoiceLost
from engine.tts.wire import (
    ANSWERS,
    MAX_BYTES,
    Answer,
    Cancel,
    Done,
    Failed,
    Loaded,
    Sound,
    Speak,
)

ANSWER_S: Final = 30.0
"""A process that neither answers nor ends for so long is lost; the slowest machine needs less for anything."""
PAUSE_S: Final = 60.0
"""From a process that did not get ready to the next one that a sentence starts, s: each may take ``ANSWER_S``."""
_WORKER: Final = "engine.tts.worker"
_EPITAPH_S: Final = 1.0  # from the end of the link to the end of the process
_AGAIN: Final = "It is started anew for the next answer."
_LATER: Final = f"It is started anew for the first answer after {PAUSE_S:g} s."


class IsolatedVoice:
    """A backend of ``engine.tts.worker`` in a child process."""

    def __init__(self, name: str, backend: Literal["piper", "espeak"], *, voice: str = "", speed: float = 1.0) -> None:
        """``name`` is for people; ``voice`` and ``speed`` as the backend understands them."""
        self.name = name
        self._arguments = (f"--backend={backend}", f"--voice={voice}", f"--speed={speed}")
        self._one = asyncio.Lock()
        self._child: Child | None = None
        self._reader: asyncio.StreamReader | None = None
        self._writer: asyncio.StreamWriter | None = None
        self._number = 0  # of the last sentence
        self._owed = 0  # of the last sentence whose end has come
        self._due = 0  # bytes of a message whose length was read: whoever read it may have been cancelled since
        self._broken = (-inf, "")  # until when (of the loop, s) no sentence starts another, and why

    @property
    def pid(self) -> int | None:
        """Of the voice process, if there is one."""
        return self._child.pid if self._child is not None else None

    async def load(self) -> None:
        """Start the process and wait until the voice is loaded. Raises ``ModelError``; ``VoiceLost`` without a hint:
        whoever loads it knows when that is tried again."""
        async with self._one:
            await self._ready()

    async def synthesise(self, sentence: Sentence) -> AsyncGenerator[Piece]:
        """See ``Synthesiser``. Raises ``ModelError``."""
        async with self._one:
            await self._ready_again()
            self._number += 1
            number = self._number
            self._send(Speak(number, sentence))
            try:
                while not isinstance(answer := await self._answer_to(number), Done):
                    yield Piece(np.frombuffer(answer.samples, np.int16), answer.rate, answer.said)
            except VoiceLost as error:
                raise VoiceLost(error.message, hint=_AGAIN) from error
            finally:
                if self._owed < number and self._child is not None:
                    self._send(Cancel(number))

    async def close(self) -> None:
        """End the process at once. Whoever waits for a sentence gets a ``ModelError``."""
        await self._end()

    async def _ready(self) -> None:
        """A process that has loaded its voice. Raises ``ModelError``."""
        if self._child is not None and self._child.epitaph() is not None:
            await self._end()  # nobody was waiting for it, so nothing is lost but time
        if self._child is not None:
            return
        starting = asyncio.ensure_future(asyncio.to_thread(Child, "voice", _WORKER, self._arguments))
        try:
            self._child = await asyncio.shield(starting)
        except asyncio.CancelledError:
            self._child = await starting  # or nobody would end it
            await self._end()
            raise
        except ProcessError as error:
            raise VoiceLost(error.message) from error
        self._number = self._owed = self._due = 0
        try:
            self._child.link.setblocking(False)
            self._reader, self._writer = await asyncio.open_connection(sock=self._child.link)
            answer = await self._answer()
            if not isinstance(answer, Loaded):
                raise self._nonsense()
        except BaseException:
            await self._end()
            raise

    async def _ready_again(self) -> None:
        """The same for a sentence, which does not wait for what has just failed."""
        until, why = self._broken
        now = asyncio.get_running_loop().time
        if now() < until:
            raise VoiceLost(why, hint=_LATER)
        try:
            await self._ready()
        except VoiceLost as error:
            self._broken = (now() + PAUSE_S, error.message)
            raise VoiceLost(error.message, hint=_LATER) from error

    async def _answer_to(self, number: int) -> Sound | Done:
        """What comes next for this sentence; what is still on its way of others is passed over."""
        while True:
            answer = await self._answer()
            if isinstance(answer, Loaded | Failed):
                await self._end()
                raise self._nonsense()
            if isinstance(answer, Done):
                self._owed = answer.number
            if answer.number == number:
                return answer

    async def _answer(self) -> Answer:
        """Raises ``ModelError``, also the one that is the answer; then the process is gone."""
        reader, child = self._reader, self._child
        assert reader is not None
        assert child is not None
        try:
            async with asyncio.timeout(ANSWER_S):
                if not self._due:
                    self._due = int.from_bytes(await reader.readexactly(LENGTH_BYTES), "little")
                if self._due > MAX_BYTES:
                    raise self._nonsense()
                data, self._due = await reader.readexactly(self._due), 0
                answer = ANSWERS.decode(data)
        except TimeoutError:
            await self._end()
            raise VoiceLost(f"The voice has not answered for {ANSWER_S:g} s.") from None
        except (asyncio.IncompleteReadError, OSError) as error:
            if self._child is None:
                raise ModelError("The voice has been closed.") from error
            why = await asyncio.to_thread(child.epitaph, wait=_EPITAPH_S)
            await self._end()
            raise VoiceLost(why or "The voice process closed its connection.") from error
        except msgspec.DecodeError as error:
            await self._end()
            raise self._nonsense() from error
        if isinstance(answer, Failed):
            await self._end()
            raise ModelError(answer.message, hint=answer.hint)
        return answer

    def _send(self, request: Speak | Cancel) -> None:
        assert self._writer is not None
        if not self._writer.is_closing():
            self._writer.write(packed(request))

    async def _end(self) -> None:
        """Leave nothing of the process."""
        child, self._child = self._child, None
        if self._writer is not None:
            self._writer.close()
            self._writer = None
        if child is not None:
            await asyncio.to_thread(child.discard)

    @staticmethod
    def _nonsense() -> VoiceLost:
        return VoiceLost("The voice process sent something unreadable.")
