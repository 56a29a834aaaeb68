"""The ears of an engine: which source they have, the recogniser behind it, and what to say where something is missing.

The microphone is looked for in the background whenever it is not there, so that plugging it in is enough. Without one,
sound can come as commands (``auto``). Somebody who hands their own microphone over (``sayso mic``) is heard in its
place, until they leave.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

from config.schema import Settings
from engine.asr.recogniser import RecogniserLost
from engine.audio.denoise import usable
from engine.audio.echo import EchoCanceller
from engine.audio.feed import Door
from engine.audio.gain import Gain
from engine.audio.microphone import Lost, Microphone
from engine.audio.pipe import GuestSource, PushSource
from engine.audio.satellite import Satellite
from engine.audio.satellite_microphone import SatelliteMicrophone
from engine.audio.simulated import SimulatedMicrophone
from engine.audio.sounded import Sounded
from engine.audio.source import Source
from engine.audio.vad import make_vad
from engine.commands import Wake
from engine.errors import DeviceError, ModelError, SaysoError, StorageError
from engine.hearing.hearing import Hearing, Listener
from engine.hearing.intake import HearingFault
from engine.hearing.overhearing import Alert
from engine.hearing.readings import Judge, Notice
from engine.parts.loading import Sound, make_demo, make_isolated_recogniser, vocabulary
from engine.parts.part import Part
from engine.planner.phrases.stopping import is_stop

AGAIN_S = 5.0
"""Pause before looking for the microphone again when looking itself has failed, s; before opening a source again that a
fault of ours has ended; and before trying again to get the door that another sayso has."""

FRESH_STARTS = 2
"""How often a recogniser that is lost while it loads is started again."""


class Ears:
    """Opens the ears and keeps them open until cancelled; ``microphone`` and ``hearing`` tell how they are.

    ``on_words`` is called with the words of a stop that ``Hearing.overhear`` overheard, in the recogniser's thread, and
    ``judge`` there with what was said so far: is it all? ``notice``: see ``Hearing``, as for ``on_going_on``.
    ``listener`` is handed everything that a live source hears. ``played`` is what the robot's loudspeaker plays, and is
    not to be heard. ``satellite``: whose microphone is the usual one (None: this
    machine's is). ``door`` is the socket at which guests are let in (None: nowhere); ``warn`` is told when that cannot
    be. ``on_fault`` is told of a fault of ours by which a source has ended.
    """

    def __init__(
        self,
        settings: Settings,
        sound: Sound,
        microphone: Part[str],
        hearing: Part[Hearing],
        *,
        on_words: Callable[[str], None] | None = None,
        judge: Judge = lambda text: "unknown",
        notice: Notice = lambda first, whole: None,
        listener: Listener | None = None,
        played: Sounded | None = None,
        on_going_on: Callable[[float], None] | None = None,
        satellite: Satellite | None = None,
        door: Path | None = None,
        warn: Callable[[str], None] = lambda words: None,
        on_fault: Callable[[SaysoError], None] = lambda fault: None,
    ) -> None:
        self._settings = settings
        self._on_words = on_words
        self._judge = judge
        self._notice = notice
        self._listener = listener
        self._on_going_on = on_going_on
        self._played = played if settings.audio.echo == "auto" else None
        self._satellite = satellite
        self._sound = sound
        self._microphone = microphone
        self._hearing = hearing
        self._door = door if sound.kind in ("mic", "auto", "none") else None
        self._warn = warn
        self._on_fault = on_fault
        self._pushed = PushSource() if sound.kind == "none" else None
        self._woken_early = False
        self._news = asyncio.Event()  # something came or went, so that another source may be right
        self._guest: GuestSource | None = None  # who is to be heard
        self._heard: GuestSource | None = None  # who is
        self._looking = sound.kind in ("mic", "auto")  # for a microphone that is not there
        self._faulty = False  # the usual source has ended by a fault of ours
        self.simulated: SimulatedMicrophone | None = None
        """The simulated microphone, in a demo."""

    def push(self, pcm: bytes) -> bool:
        """Take sound that came as a command; False where sound comes from elsewhere. In the loop's thread."""
        if self._pushed is None or self._heard is not None:
            return False
        if self._looking:  # whoever sends sound wants to be heard, whatever is plugged in later
            self._looking = False
            self._news.set()
        self._pushed.push(pcm)
        return True

    def mark(self, wake: Wake) -> None:
        """The wake is now: what is said from here on counts, or since its phrase ended, however late somebody listens.
        Thread-safe."""
        if (hearing := self._hearing.value) is not None:
            hearing.mark(wake.ago_s, wake.phrase)
        else:
            self._woken_early = True

    async def keep(self) -> None:
        """Load the recogniser, open the source, and close both when cancelled, however far that was."""
        async with AsyncExitStack() as closing:
            await self._hearing.load(lambda: self._load(closing), lambda ears: ears.recogniser_name)
            if (hearing := self._hearing.value) is not None:
                async with asyncio.TaskGroup() as both:
                    both.create_task(self._keep_door())
                    both.create_task(self._attend(hearing))
            else:
                self._microphone.fail(DeviceError("Without a recogniser nothing is heard at the microphone."))
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
            suppression=usable(settings.audio.noise_suppression, self._warn),
            gain_db=settings.audio.gain_db,
            on_end=self._ended,
            warn=self._warn,
            judge=self._judge,
            notice=self._notice,
            partials=settings.asr.backend == "whisper",  # what is elsewhere is asked once
            alert=self._alert(),
            listener=self._listener,
            echo=EchoCanceller(self._played) if self._played is not None else None,
            on_going_on=self._on_going_on,
            beside=make_vad(settings.vad) if settings.asr.backend != "openai" else None,  # a service
            prompt=settings.robot.realtime_priority,
        )
        closing.push_async_exit(hearing)
        await self._have_recogniser(hearing)
        if self._woken_early:
            hearing.mark()
        await self._microphone.load(lambda: self._open(hearing), str)
        if self._microphone.value is None:
            await self._do_without(hearing)
        return hearing

    async def _have_recogniser(self, hearing: Hearing) -> None:
        """Raises ``ModelError``."""
        for _ in range(FRESH_STARTS):
            try:
                return await hearing.load()
            except RecogniserLost as error:  # the machine may be short of memory while all else loads as well
                self._warn(f"{error.message} It is started again.")
                await asyncio.sleep(AGAIN_S)
        try:
            return await hearing.load()
        except RecogniserLost as error:
            hint = "Start sayso again; if it keeps happening, try a smaller asr.model."
            raise ModelError(error.message, hint=hint) from error

    def _alert(self) -> Alert | None:
        """Whatever is said while the robot moves is no business of a service, but for what must be a stop."""
        if self._on_words is None:
            return None
        unasked = self._settings.asr.backend != "openai"
        return Alert(make_vad(self._settings.vad), is_stop, self._on_words, unasked)

    async def _open(self, hearing: Hearing) -> str:
        try:
            await hearing.__aenter__()
        except Lost as error:
            self._looking = self._looking and not error.for_good
            raise
        return hearing.source_name

    def _open_source(self) -> Source:
        """The source as asked for. Raises ``DeviceError``."""
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
                return self._usual()

    def _usual(self, *, patient: bool = False) -> Source:
        """The configured microphone; ``patient``: it is waited for."""
        if self._satellite is not None:
            return SatelliteMicrophone(self._satellite, patient=patient)
        return Microphone(self._settings.audio.device, patient=patient)

    async def _do_without(self, hearing: Hearing) -> None:
        """There is no microphone, and whoever looks has been told: sound can come as commands where that will do."""
        if self._sound.kind == "auto":
            self._pushed = PushSource()
            await hearing.hear(self._pushed)

    # Changes of the source

    async def _keep_door(self) -> None:
        """Let guests in, as soon as no other sayso of this user does; until then they are told which one hears them."""
        while self._door is not None:
            try:
                async with Door(self._door, self._arrived):
                    await asyncio.Event().wait()
            except DeviceError:
                await asyncio.sleep(AGAIN_S)
            except StorageError as error:
                self._warn(str(error))
                return

    def _arrived(self, guest: GuestSource) -> None:
        self._guest = guest
        self._news.set()

    def _ended(self, error: SaysoError | None) -> None:
        """The live source has ended, or is lost."""
        if isinstance(error, HearingFault):
            self._on_fault(error)
        if self._heard is not None:
            self._guest = None if self._guest is self._heard else self._guest
        elif error is not None:
            self._faulty = isinstance(error, HearingFault) and self._sound.kind != "source"  # which is used up
            self._microphone.fail(error)
        self._news.set()

    async def _attend(self, hearing: Hearing) -> None:
        """Hear a guest while there is one, else the usual source, which is looked for while it is not there."""
        while True:
            self._news.clear()
            if self._guest is not self._heard:
                await self._until_news(self._change(hearing, self._guest))
            elif self._faulty and self._heard is None:
                await self._until_news(self._open_again(hearing))
            elif self._looking and self._heard is None and self._microphone.value is None:
                await self._until_news(self._find(hearing))
            else:
                await self._news.wait()

    async def _until_news(self, work: Coroutine[Any, Any, None]) -> None:
        """Work until that is done or overtaken."""
        working, news = asyncio.create_task(work), asyncio.create_task(self._news.wait())
        try:
            await asyncio.wait((working, news), return_when=asyncio.FIRST_COMPLETED)
        finally:
            working.cancel()
            news.cancel()
            await asyncio.gather(working, news, return_exceptions=True)
        if not working.cancelled():
            working.result()  # a fault of ours

    async def _change(self, hearing: Hearing, guest: GuestSource | None) -> None:
        """Hear the guest, or after the last one whatever is usual here."""
        self._faulty = False
        if guest is not None:
            await hearing.hear(guest, Gain("auto" if self._settings.audio.gain_db == "auto" else 0.0))
            self._heard = guest
            self._microphone.succeed(guest.name, guest.name)
            return
        sent = self._pushed is not None and not self._looking  # sound comes as commands, and nothing else will
        usual = self._pushed = PushSource() if sent else None  # the one before was closed when the guest came
        try:
            await hearing.hear(usual or self._open_source())
        except SaysoError as error:
            self._heard = None
            self._microphone.fail(error)
            hearing.lose(error)
            await self._do_without(hearing)
        else:
            self._heard = None
            self._microphone.succeed(hearing.source_name, hearing.source_name)

    async def _open_again(self, hearing: Hearing) -> None:
        """The fault may be back at once, hence the pause."""
        await asyncio.sleep(AGAIN_S)
        await self._change(hearing, None)

    async def _find(self, hearing: Hearing) -> None:
        """Wait for the microphone, and hear it."""
        try:
            await hearing.hear(self._usual(patient=True))
        except SaysoError as error:
            self._looking = not (isinstance(error, Lost) and error.for_good)
            await asyncio.sleep(AGAIN_S)
            return
        self._pushed = None
        self._microphone.succeed(hearing.source_name, hearing.source_name)
