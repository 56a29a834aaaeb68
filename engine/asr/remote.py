"""A recogniser that is elsewhere: sound goes there, and words come back.

Whoever recognises here waits in a thread (see ``Recogniser``), while the conversation with the other side is a
coroutine in a loop of that thread; who no longer needs the answer, and who closes, ends the conversation at once. The
gates are the same as for a recogniser on this machine, as far as the other side says how sure it was.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from config.languages import code_of
from config.schema import Asr
from engine.asr.gates import judge
from engine.asr.recogniser import Decoding, Rejected, Transcript
from engine.asr.whole import Stretch
from engine.commands import MAX_TEXT
from engine.errors import ModelError, SaysoError, one_line
from engine.han import is_chinese
from engine.lead import Lead

RATE = 16_000
LOOK_S = 0.02
"""Between two looks whether the answer is still needed, s."""
SHORTEST_S = 0.2
"""Shorter sound holds no word."""


@dataclass(frozen=True, slots=True)
class Heard:
    """What came back. What the other side does not tell is None."""

    text: str
    language: str | None = None  # as the other side calls it
    avg_logprob: float | None = None
    no_speech_probability: float | None = None


class Elsewhere(Protocol):
    """The other side. Everything is called in one loop."""

    @property
    def name(self) -> str: ...

    async def ask(self, samples: NDArray[np.int16], vocabulary: Sequence[str], language: str | None) -> Heard:
        """``samples``: 16 kHz. ``language``: the one that is spoken, None where that is to be found out. Raises
        ``SaysoError``."""
        ...

    async def close(self) -> None: ...


class RemoteRecogniser:
    """See ``Recogniser``."""

    takes_lead = False

    def __init__(self, elsewhere: Elsewhere, settings: Asr) -> None:
        self.name = elsewhere.name
        self._elsewhere = elsewhere
        self._settings = settings
        self._lock = threading.Lock()
        self._asking: Callable[[], object] | None = None  # ends the conversation, in any thread
        self._closed = False

    def load(self) -> None:
        """Nothing is sent before there is something to recognise."""

    def transcribe(
        self,
        samples: NDArray[np.float32],
        vocabulary: Sequence[str] = (),
        cancelled: Callable[[], bool] = lambda: False,
        *,
        quick: bool = False,
        lead: Lead | None = None,
    ) -> Transcript | Rejected:
        """Recognise one utterance; see ``Recogniser``. Raises ``SaysoError``."""
        del quick, lead  # there is only one way to ask, and nobody to be told what is known already
        audio_s = len(samples) / RATE
        if audio_s < SHORTEST_S:
            return Rejected("too_short", f"{audio_s:.2f} s of sound is too short for a word.")
        began = time.perf_counter()
        heard = asyncio.run(self._conversation(samples, vocabulary, cancelled))
        if heard is None:
            return Rejected("empty", "It was cancelled before there was an answer.")
        decoding = Decoding(
            language=self._among(heard.language) or ("zh" if is_chinese(heard.text) else self._settings.languages[0]),
            avg_logprob=heard.avg_logprob if heard.avg_logprob is not None else 0.0,
            no_speech_probability=heard.no_speech_probability or 0.0,
            audio_s=audio_s,
            decode_s=time.perf_counter() - began,
            window_s=audio_s,
        )
        return judge(one_line(heard.text, MAX_TEXT + 1), decoding, self._settings, vocabulary)

    def stretches(self, samples: NDArray[np.float32], vocabulary: Sequence[str] = ()) -> Iterator[Stretch]:
        """All of it in one question; see ``WholeRecogniser``."""
        yield Stretch(0.0, len(samples) / RATE, self.transcribe(samples, vocabulary))

    def likelihood(
        self, samples: NDArray[np.float32], texts: Sequence[str], cancelled: Callable[[], bool] = lambda: False
    ) -> float | None:
        """None: there is no such question in these protocols."""
        del samples, texts, cancelled
        return None

    def close(self) -> None:
        """End the conversation at once. Thread-safe."""
        with self._lock:
            self._closed = True
            if self._asking is not None:
                self._asking()

    async def _conversation(
        self, samples: NDArray[np.float32], vocabulary: Sequence[str], cancelled: Callable[[], bool]
    ) -> Heard | None:
        """None where nobody needs the answer any more."""
        sound = np.clip(np.rint(samples * 32768), -32768, 32767).astype(np.int16)
        asking = asyncio.create_task(self._ask(sound, vocabulary))
        loop = asyncio.get_running_loop()
        with self._lock:
            if self._closed:
                asking.cancel()
            self._asking = lambda: loop.call_soon_threadsafe(asking.cancel)
        try:
            while not (await asyncio.wait([asking], timeout=LOOK_S))[0]:
                if cancelled():
                    asking.cancel()
            if not asking.cancelled():
                return asking.result()
            if self._closed:
                raise ModelError("The recogniser has been closed.")
            return None
        finally:
            with self._lock:
                self._asking = None
            await self._elsewhere.close()

    async def _ask(self, sound: NDArray[np.int16], vocabulary: Sequence[str]) -> Heard:
        """One answer, in a language that is spoken here. Whatever the other side brings about is a ``SaysoError``."""
        wanted = None if self._settings.language == "auto" else self._settings.language
        try:
            heard = await self._elsewhere.ask(sound, vocabulary, wanted)
            if wanted is None and heard.language and self._among(heard.language) is None:
                return await self._elsewhere.ask(sound, vocabulary, self._settings.languages[0])
            return heard
        except SaysoError:
            raise
        except Exception as error:  # noqa: BLE001 - what it says may hold what the other side sent
            fault = type(error).__name__
        raise ModelError(
            f"The answer of {self.name} is nothing that was expected ({fault}).",
            hint="Check the settings of asr.",
        )

    def _among(self, language: str | None) -> str | None:
        """The code of a language, if it is one that is spoken here."""
        spoken = self._settings.languages if self._settings.language == "auto" else (self._settings.language,)
        if language is None or language in spoken:
            return language
        return next((known for known in spoken if code_of(known) == code_of(language)), None)
