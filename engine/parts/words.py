"""The wake words as a part of the engine: they are loaded in the background, and what a live source hears is handed to
the thread in which they are listened for. "Stop" is listened for there as well, in the languages that are spoken.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from config import paths
from config.schema import Settings
from engine.bus import Emit
from engine.commands import Wake
from engine.errors import ModelError, SaysoError
from engine.events import ErrorRaised, Log
from engine.parts.loading import model_store
from engine.parts.part import Part
from engine.wake.choice import MODEL, make_spotters, stop_words, usual_words
from engine.wake.words import Ask, Spotted, Spotter, WordListener

FRESH_STARTS: Final = 3
"""How often listening begins anew after a fault, before it is given up."""


class WordsPart:
    """Listens while :meth:`keep` runs; :meth:`push` and :meth:`reset` are for who hears. ``wake``, ``suspect`` (for
    what may have been a stop) and ``ask`` (for what may have been a wake word) are called in the thread that listens.
    Without ``wakes`` nothing wakes."""

    def __init__(
        self,
        settings: Settings,
        wake: Callable[[Wake], None],
        suspect: Callable[[Spotted], None],
        ask: Ask,
        emit: Emit,
        *,
        wakes: bool = True,
    ) -> None:
        self._settings = settings
        self._wake = wake
        self._suspect = suspect
        self._ask = ask
        self._emit = emit
        self._wakes = wakes
        self._listener: WordListener | None = None
        self._late = False  # and that has been told
        self._told: set[str] = set()  # phrases of which is known that nobody can listen for them

    async def keep(self, make_part: Callable[[], Part[str]]) -> None:
        """Listen until this is cancelled. Where nothing is to be listened for, there is no part."""
        phrases = await asyncio.to_thread(phrases_of, self._settings) if self._wakes else ()
        if not phrases and await asyncio.to_thread(_embedding, self._settings) is None:
            return
        part = make_part()
        try:
            for _ in range(FRESH_STARTS):
                fault = await self._listen(phrases, part)
                self._emit(Log("warning", "wake words", f"Listening for the wake word begins anew after {fault!r}."))
            fault = await self._listen(phrases, part)
        except SaysoError as error:
            part.fail(error)
            return
        given_up = SaysoError(f"Listening for the wake word failed: {fault!r}.", hint="Please report it.")
        part.fail(given_up)
        self._emit(ErrorRaised("internal", given_up.message, given_up.hint))

    async def _listen(self, phrases: Sequence[str], part: Part[str]) -> Exception:
        """Listen until this is cancelled, or to the fault that ends it. Raises ``ModelError``."""
        loop, faults = asyncio.get_running_loop(), asyncio.Queue[Exception]()

        def fail(error: Exception) -> None:
            loop.call_soon_threadsafe(faults.put_nowait, error)

        doubts = self._settings.asr.backend == "whisper"  # which alone can be asked
        unknown: Mapping[str, SaysoError] = {}
        try:
            spotters = await asyncio.to_thread(load_spotters, self._settings, phrases, stops=True, doubts=doubts)
        except SaysoError:
            phrases, unknown = await asyncio.to_thread(told_apart, self._settings, phrases)
            spotters = await asyncio.to_thread(load_spotters, self._settings, phrases, stops=True, doubts=doubts)
            if not spotters:
                raise
        prompt = self._settings.robot.realtime_priority
        stops = stops_of(self._settings, phrases)
        listener = WordListener(
            spotters, self._wake, fail, prompt=prompt, suspect=self._suspect, ask=self._ask, stops=stops
        )
        listener.start()
        self._listener = listener
        named = (
            ", ".join(f"“{phrase}”" for phrase in listener.phrases)
            or f"only {' and '.join(f'“{stop}”' for stop in stops)}"
        )
        self._tell_of(unknown)
        if unknown and not phrases:
            part.fail(next(iter(unknown.values())))
        else:
            part.succeed(named, ", ".join((named, *(f"not “{phrase}”" for phrase in unknown))))
        try:
            return await faults.get()
        finally:
            self._listener = None
            await asyncio.to_thread(listener.close)
            if listener.dropped:
                text = f"{listener.dropped} pieces of sound came faster than wake words could be listened for."
                self._emit(Log("warning", "wake words", text))

    def _tell_of(self, unknown: Mapping[str, SaysoError]) -> None:
        """Say once why these phrases are not listened for."""
        for phrase, error in unknown.items():
            if phrase not in self._told:
                self._told.add(phrase)
                self._emit(Log("warning", "wake words", str(error)))

    def push(self, samples: NDArray[np.int16]) -> None:
        if (listener := self._listener) is not None:
            listener.push(samples)
            if listener.dropped and not self._late:
                self._late = True
                text = "This machine is too slow or too busy to listen for wake words: some are missed."
                self._emit(Log("warning", "wake words", text))

    def reset(self) -> None:
        if (listener := self._listener) is not None:
            listener.reset()


def phrases_of(settings: Settings) -> Sequence[str]:
    """What is to be listened for."""
    wanted = settings.wake.words
    return usual_words(_embedding(settings)) if wanted == "auto" else wanted


def stops_of(settings: Settings, phrases: Sequence[str]) -> Sequence[str]:
    """What is listened for as a stop, where ``phrases`` wake."""
    asr = settings.asr
    spoken = asr.languages if asr.language == "auto" else (asr.language,)
    return [stop for stop in stop_words(spoken) if stop not in phrases]


def spots_stops(settings: Settings) -> bool:
    """What is needed to listen for a stop all the time is here."""
    return _embedding(settings) is not None


def told_apart(settings: Settings, phrases: Sequence[str]) -> tuple[list[str], dict[str, SaysoError]]:
    """The phrases that can be listened for, and why the others cannot."""
    unknown: dict[str, SaysoError] = {}
    for phrase in phrases:
        try:
            load_spotters(settings, [phrase])
        except SaysoError as error:
            unknown[phrase] = error
    return [phrase for phrase in phrases if phrase not in unknown], unknown


def load_spotters(
    settings: Settings, phrases: Sequence[str], *, stops: bool = False, doubts: bool = False
) -> Sequence[Spotter]:
    """Spotters for phrases, and with ``stops`` for what stops, ready to listen; with ``doubts`` they tell of what may
    have been a phrase, too. Raises ``ModelError``."""
    heard = stops_of(settings, phrases) if stops else ()
    own, embedding = paths().words, _embedding(settings)
    return make_spotters(phrases, own, embedding, settings.wake.threshold, stops=heard, doubts=doubts)


def _embedding(settings: Settings) -> Path | None:
    """The folder of the model behind all heads, where it is there."""
    try:
        return model_store(settings).find(MODEL)
    except ModelError:
        return None
