"""The voice as a part of the engine: the loudspeaker is opened, the voice is fetched if it is missing, and loaded.

Nobody waits for it: until it is ready, answers are only shown. With ``voice.backend: auto`` nothing is wrong with a
machine without a voice or a loudspeaker, so there is one line in the log and no part; what somebody asked for by name
is a part, and says what it lacks. A loudspeaker that is not there, or no longer, is looked for in the background, so
that plugging it in is enough. A voice whose process was lost while it loaded is tried again when an answer goes without
it, and is there for those that follow.
"""

from __future__ import annotations

import asyncio
import functools
from collections.abc import Callable
from contextlib import suppress
from math import inf
from typing import Final

from config.schema import Settings
from engine.audio.player import Player
from engine.audio.portaudio import Unusable
from engine.bus import Emit
from engine.errors import SaysoError
from engine.events import Log
from engine.parts.fetching import Fetching, Pull
from engine.parts.loading import make_synthesiser, model_store, voice_to_fetch
from engine.parts.part import Part
from engine.speaking import SpokenVoice
from engine.tts.synthesis import Synthesiser, VoiceLost

AGAIN_S: Final = 5.0
"""Pause before looking for the loudspeaker again when looking itself has failed, s."""
PAUSE_S: Final = 60.0
"""From a voice that was lost while it loaded to the next try, s: each may keep the machine busy for half a minute."""
_LATER: Final = "It is tried again when there is something to say."


class VoicePart:
    """Keeps player and voice; the part's value is the voice's name. ``make_part`` is called when there is one."""

    def __init__(
        self, settings: Settings, player: Player, voice: SpokenVoice, make_part: Callable[[], Part[str]], emit: Emit
    ) -> None:
        self._settings = settings
        self._player = player
        self._voice = voice
        self._make_part = make_part
        self._emit = emit
        self._part: Part[str] | None = None
        self._synthesiser: Synthesiser | None = None
        self._tried = False  # to load the voice
        self._again_at = inf  # from then on (of the loop, s) it may be tried again
        self._found = False  # there is a loudspeaker, or was
        self._news = asyncio.Event()  # the loudspeaker is lost, or the voice is to be tried again

    async def keep(self) -> None:
        """Open the loudspeaker and load the voice; let go of both when this is cancelled."""
        self._player.tell = self._follow
        self._voice.missed = self._try_again
        try:
            found = await self._open()
            while True:
                if found and not self._tried and self._settings.voice.when != "never":
                    self._tried = True
                    await self._load()
                self._voice.settle(self._synthesiser)
                if found:
                    await self._until_news()
                found = await self._find()
        finally:
            self._voice.settle(None)
            if self._synthesiser is not None:
                await self._synthesiser.close()
            await self._player.close()

    # The loudspeaker

    async def _open(self) -> bool:
        try:
            await self._player.open()
        except SaysoError as error:
            wanted = self._settings.voice
            self._do_without(error, asked_for=wanted.backend != "auto" or wanted.device is not None)
            if isinstance(error, Unusable):
                self._voice.settle(None)
                await asyncio.Event().wait()
            return False
        self._found = True
        return True

    async def _find(self) -> bool:
        """Wait for the loudspeaker, and open it; False where it has to be looked for once more."""
        try:
            await self._player.open(patient=True)
        except SaysoError:
            await asyncio.sleep(AGAIN_S)
            return False
        if not self._found and self._part is None:
            self._emit(Log("info", "voice", f"There is a {self._player.name} now."))
        self._found = True
        return True

    async def _until_news(self) -> None:
        self._news.clear()
        if self._player.usable:
            await self._news.wait()

    def _follow(self, trouble: SaysoError | None) -> None:
        """The loudspeaker is lost, or was and is there again."""
        part, made = self._part, self._synthesiser
        if trouble is not None:
            self._news.set()
        if part is not None and made is not None:
            part.fail(trouble) if trouble is not None else part.succeed(made.name, f"{made.name}, {self._player.name}")
        elif trouble is not None:
            self._emit(Log("warning", "voice", str(trouble)))
        else:
            self._emit(Log("info", "voice", f"The {self._player.name} is back."))

    # The voice

    async def _load(self) -> None:
        fetching = await asyncio.to_thread(self._missing)
        if fetching is not None:
            part = self._part_of_it()
            with suppress(SaysoError):  # it is missing, then: what else there is may do, and else that is told
                await Pull(fetching.store, fetching.name, part.progress).done()
        try:
            made = await asyncio.to_thread(make_synthesiser, self._settings, self._warn)
        except SaysoError as error:
            self._do_without(error, asked_for=self._settings.voice.backend != "auto")
            return
        self._synthesiser = made
        part = self._part_of_it()
        await part.load(functools.partial(self._up, made), str)
        if part.value is not None and (lost := self._player.trouble) is not None:
            part.fail(lost)  # meanwhile
        elif part.value is None:
            self._synthesiser = None
            await made.close()

    async def _up(self, synthesiser: Synthesiser) -> str:
        try:
            await synthesiser.load()
        except VoiceLost as error:
            self._again_at = asyncio.get_running_loop().time() + PAUSE_S
            raise VoiceLost(error.message, hint=_LATER) from error
        return synthesiser.name

    def _try_again(self) -> None:
        """Somebody could have used a voice."""
        if asyncio.get_running_loop().time() >= self._again_at:
            self._again_at, self._tried = inf, False
            self._news.set()

    def _missing(self) -> Fetching | None:
        """The model that is to be fetched first, if any."""
        name = voice_to_fetch(self._settings)
        if name is None or not self._settings.models.fetch:
            return None
        store = model_store(self._settings)
        with suppress(SaysoError):
            store.find(name)
            return None
        return Fetching(store, name)

    def _part_of_it(self) -> Part[str]:
        if self._part is None:
            self._part = self._make_part()
        return self._part

    def _do_without(self, error: SaysoError, *, asked_for: bool) -> None:
        """There will be no voice, as things are; say so in one line."""
        if asked_for or self._part is not None:
            self._part_of_it().fail(error)
        else:
            self._emit(Log("info", "voice", f"Answers are shown, not spoken. {error}"))

    def _warn(self, words: str) -> None:
        self._emit(Log("warning", "voice", words))
