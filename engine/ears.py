"""The ears of an engine: which source they have, the recogniser behind it, and what to say where something is missing.

Without a microphone, sound can come as commands (``auto``), or a wake says what is missing and tries again (``mic``).
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import AsyncExitStack

from config.schema import Settings
from engine.audio.pipe import PushSource
from engine.audio.simulated import SimulatedMicrophone
from engine.audio.source import Source
from engine.audio.vad import make_vad
from engine.hearing import Hearing
from engine.loading import Sound, make_demo, make_isolated_recogniser, vocabulary
from engine.overhearing import Alert
from engine.parts import Part
from engine.planner.stopping import is_stop


class Ears:
    """Opens the ears and keeps them open until cancelled; ``microphone`` and ``hearing`` tell how they are.

    ``on_words`` is called with the words of a stop that ``Hearing.overhear`` overheard, in the recogniser's thread.
    """

    def __init__(
        self,
        settings: Settings,
        sound: Sound,
        microphone: Part[str],
        hearing: Part[Hearing],
        *,
        on_words: Callable[[str], None] | None = None,
    ) -> None:
        self._settings = settings
        self._on_words = on_words
        self._sound = sound
        self._microphone = microphone
        self._hearing = hearing
        self._pushed = PushSource() if sound.kind == "none" else None
        self._woken_early = False
        self.simulated: SimulatedMicrophone | None = None
        """The simulated microphone, in a demo."""

    def push(self, pcm: bytes) -> bool:
        """Take sound that came as a command; False where sound comes from elsewhere. Thread-safe."""
        if self._pushed is None:
            return False
        self._pushed.push(pcm)
        return True

    def mark(self) -> None:
        """The wake is now: what is said from here on counts, however late somebody listens. Thread-safe."""
        if (hearing := self._hearing.value) is not None:
            hearing.mark()
        else:
            self._woken_early = True

    async def keep(self) -> None:
        """Load the recogniser, open the source, and close both when cancelled, however far that was."""
        async with AsyncExitStack() as closing:
            await self._hearing.load(lambda: self._load(closing), lambda ears: ears.recogniser_name)
            await asyncio.Event().wait()

    async def _load(self, closing: AsyncExitStack) -> Hearing:
        settings = self._settings
        recogniser = make_isolated_recogniser(settings)
        hearing = Hearing(
            self._open_source,
            make_vad(settings.vad),
            settings.endpoint,
            recogniser,
            vocabulary=vocabulary(settings),
            gain_db=settings.audio.gain_db,
            on_lost=self._microphone.fail,
            alert=Alert(make_vad(settings.vad), is_stop, self._on_words) if self._on_words is not None else None,
        )
        closing.push_async_exit(hearing)
        await hearing.load()
        if self._woken_early:
            hearing.mark()
        await self._microphone.load(lambda: self._open(hearing), str)
        if self._microphone.value is None and self._sound.kind == "auto":  # said by now; sound can come as commands
            self._sound, self._pushed = Sound("none"), PushSource()
            await hearing.__aenter__()
        return hearing

    @staticmethod
    async def _open(hearing: Hearing) -> str:
        await hearing.__aenter__()
        return hearing.source_name

    def _open_source(self) -> Source:
        """The source as asked for; called again when it was lost and somebody listens. Raises ``DeviceError``."""
        match self._sound.kind:
            case "source":
                assert self._sound.source is not None
                return self._sound.source
            case "demo":
                self.simulated = make_demo()
                return self.simulated
            case "none":
                assert self._pushed is not None
                return self._pushed
            case _:
                from engine.audio.microphone import Microphone

                return Microphone(self._settings.audio.device)
