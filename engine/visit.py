"""One visitor of a Wyoming server (``engine.serving``): what they ask for, what they get, and what they may cost.

Sound is sent and words come back, or a text is sent and sound comes back, in the order in which it was asked. Whoever
breaks a limit, or speaks something else, is told why: :class:`Unacceptable`.
"""

from __future__ import annotations

import asyncio
import functools
import time
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np
import soxr
from numpy.typing import NDArray

from engine import __version__, wyoming
from engine.asr.recogniser import Recogniser, Rejected, Transcript
from engine.errors import SaysoError
from engine.tts.sentences import Sentence, sentences
from engine.tts.synthesis import Piece, Synthesiser
from engine.wyoming import RATE

if TYPE_CHECKING:
    from wyoming.asr import Transcribe
    from wyoming.audio import AudioChunk
    from wyoming.event import Event, Eventable
    from wyoming.info import Info

LONGEST_S: Final = 60.0
"""Most sound that is recognised in one go, s."""
LONGEST_TEXT: Final = 5000
"""Most characters that are said in one go."""
REQUESTS: Final = 4
"""Requests of one connection that wait; reading stops until there is room."""
IDLE_S: Final = 300.0
"""A connection on which nothing is asked for so long is closed, s."""
PATIENCE_S: Final = 30.0
"""A visitor who stops in the midst of a sound, or goes on with pieces in which there is none, or does not take an
answer, is given up after this, s; and what they asked for before they left, or closed their side."""
_CHUNK_S: Final = 0.1
_NAMES, _NAME_SIGNS = 100, 60  # words that the recogniser is to expect
_SILENT_RATE: Final = 22_050  # of an answer in which nothing is to be said
Request = Callable[[], Awaitable[None]]
"""Something that a visitor asks for, to be done in its turn."""


@dataclass(frozen=True, slots=True)
class Offer:
    """What is served. At least one of the two is there; both are loaded."""

    recogniser: Recogniser | None
    voice: Synthesiser | None
    hears: Sequence[str]  # languages, ISO 639-1
    says: Sequence[str]


class Unacceptable(Exception):
    """Why a visitor is shown out, as a sentence for them, and a word for programs."""

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code


class Host(Protocol):
    """Who serves the visitors."""

    @property
    def offer(self) -> Offer: ...

    @property
    def tell(self) -> Callable[[str], None]:
        """Is told of each request, in a sentence without what was said."""
        ...

    async def recognise(self, samples: NDArray[np.int16], names: Sequence[str]) -> Transcript | Rejected:
        """Raises ``SaysoError``."""
        ...

    async def say(self, sentence: Sentence) -> list[Piece]:
        """Raises ``SaysoError``."""
        ...


class Visit:
    """One connection."""

    def __init__(self, host: Host, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._host = host
        self._reader = reader
        self._writer = writer
        self._requests: asyncio.Queue[Request] = asyncio.Queue(REQUESTS)
        self._unfinished = 0  # requests
        self._wish: Transcribe | None = None
        self._sound: Recording | None = None
        self._since = asyncio.get_running_loop().time()  # when something was asked or sent last
        self._wanted = asyncio.Event()  # the seat, by another visitor

    @property
    def idle_s(self) -> float:
        """For how long nothing was asked; 0 while something is sent or done."""
        busy = self._sound is not None or self._unfinished > 0
        return 0.0 if busy else asyncio.get_running_loop().time() - self._since

    def give_way(self) -> None:
        """Another visitor needs the seat: end the visit."""
        self._wanted.set()

    async def stay(self) -> None:
        """Listen and do what is asked, until the visitor leaves. Raises :class:`Unacceptable`, ``NotWyoming``,
        ``OSError``, ``EOFError`` and ``TimeoutError``."""
        all_ = [asyncio.create_task(work) for work in (self._listen(), self._work(), self._leave())]
        try:
            done, _ = await asyncio.wait(all_, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in all_:
                task.cancel()
            await asyncio.gather(*all_, return_exceptions=True)
        for task in done:
            task.result()

    async def _leave(self) -> None:
        await self._wanted.wait()
        raise Unacceptable("idle", "Nothing was asked here, and somebody else needs the connection.")

    async def _listen(self) -> None:
        now = asyncio.get_running_loop().time
        while True:
            async with asyncio.timeout_at(self._since + (PATIENCE_S if self._sound is not None else IDLE_S)):
                event = await wyoming.read(self._reader)
            if event is None:  # they may have closed only their side, and wait for what they asked for
                async with asyncio.timeout(PATIENCE_S):
                    await self._requests.join()
                return
            before = self._sound
            try:
                request = self._request(event)
            except (KeyError, TypeError, ValueError, AttributeError) as error:
                raise Unacceptable("not-wyoming", f"This {event.type[:40]!r} lacks what belongs to it.") from error
            if request is not None:
                self._unfinished += 1
                await self._requests.put(request)
            if self._sound is not before or not _is_empty(event):
                self._since = now()

    async def _work(self) -> None:
        while True:
            request = await self._requests.get()
            await request()
            self._requests.task_done()
            self._unfinished -= 1

    def _request(self, event: Event) -> Request | None:
        """What an event asks for; nothing where it only prepares that, or is none that we know (servers drop those)."""
        from wyoming.asr import Transcribe
        from wyoming.audio import AudioChunk, AudioStart, AudioStop
        from wyoming.info import Describe
        from wyoming.ping import Ping, Pong
        from wyoming.tts import Synthesize

        kind = event.type
        if Describe.is_type(kind):
            return functools.partial(self._answer, describe(self._host.offer))
        if Ping.is_type(kind):
            return functools.partial(self._answer, Pong(Ping.from_event(event).text))
        if Transcribe.is_type(kind):
            self._wish, self._sound = self._possible(Transcribe.from_event(event)), Recording()
        elif AudioStart.is_type(kind):
            self._sound = Recording()
        elif AudioChunk.is_type(kind):
            self._sound = self._sound or Recording()
            self._sound.add(AudioChunk.from_event(event))
        elif AudioStop.is_type(kind) and self._sound is not None:
            wish, sound, self._wish, self._sound = self._wish, self._sound, None, None
            return functools.partial(self._transcribe, _names(self._possible(wish or Transcribe())), sound.samples())
        elif Synthesize.is_type(kind):
            text = Synthesize.from_event(event).text
            if not isinstance(text, str):
                raise TypeError("it is no text")
            if len(text) > LONGEST_TEXT:
                most = f"{LONGEST_TEXT} are said in one go"
                raise Unacceptable("too-long", f"{len(text)} characters are too many; {most}.")
            return functools.partial(self._synthesise, text)
        return None

    def _possible(self, wish: Transcribe) -> Transcribe:
        """A wish that can be fulfilled. Raises :class:`Unacceptable`."""
        offer = self._host.offer
        if offer.recogniser is None:
            raise Unacceptable("not-offered", "There is no recogniser here.")
        if wish.language and wish.language.replace("_", "-").split("-")[0].casefold() not in offer.hears:
            known = ", ".join(offer.hears)
            raise Unacceptable("language", f"{wish.language[:20]!r} is not understood here (asr.language); {known} is.")
        return wish

    async def _transcribe(self, names: Sequence[str], samples: NDArray[np.int16]) -> None:
        from wyoming.asr import Transcript as Told

        began = time.monotonic()
        try:
            found = await self._host.recognise(samples, names)
        except SaysoError as error:
            raise Unacceptable("recogniser", str(error)) from error
        heard = found.text if isinstance(found, Transcript) else ""
        language = found.decoding.language if found.decoding is not None else None
        seconds = f"{len(samples) / RATE:.1f} s of sound in {time.monotonic() - began:.1f} s"
        self._host.tell(f"Recognised {seconds}." if heard else f"Heard no words: {seconds}.")
        await self._answer(Told(heard, language=language))

    async def _synthesise(self, text: str) -> None:
        from wyoming.audio import AudioChunk, AudioStart, AudioStop

        if self._host.offer.voice is None:
            raise Unacceptable("not-offered", "There is no voice here.")
        rate, said, began = 0, 0, time.monotonic()
        for sentence in sentences(text):
            try:
                pieces = await self._host.say(sentence)
            except SaysoError as error:
                raise Unacceptable("voice", str(error)) from error
            if pieces and not rate:
                rate = pieces[0].rate
                await self._answer(AudioStart(rate=rate, width=2, channels=1))
            for samples in (_at(rate, piece) for piece in pieces):
                said += len(samples)
                step = round(_CHUNK_S * rate)
                for at in range(0, len(samples), step):
                    sound = samples[at : at + step].astype("<i2").tobytes()
                    await self._answer(AudioChunk(rate=rate, width=2, channels=1, audio=sound))
        if not rate:
            await self._answer(AudioStart(rate=_SILENT_RATE, width=2, channels=1))
        await self._answer(AudioStop())
        self._host.tell(f"Said {said / (rate or 1):.1f} s of speech in {time.monotonic() - began:.1f} s.")

    async def _answer(self, event: Eventable) -> None:
        async with asyncio.timeout(PATIENCE_S):
            await wyoming.write(self._writer, event)


class Recording:
    """Sound while it comes, and not more of it than is recognised."""

    def __init__(self) -> None:
        self._intake = wyoming.Intake()
        self._pieces: list[NDArray[np.int16]] = []
        self._seconds = 0.0

    def add(self, chunk: AudioChunk) -> None:
        """Raises :class:`Unacceptable` for a kind that is not understood, and for too much; ``ValueError``."""
        try:
            piece = self._intake.taken(chunk)
        except wyoming.UnknownKind as error:
            raise Unacceptable("audio-format", f"{str(error).capitalize()}.") from error
        self._seconds += chunk.seconds
        if self._seconds > LONGEST_S:
            raise Unacceptable("too-long", f"At most {LONGEST_S:g} s of sound are recognised in one go.")
        if len(piece):
            self._pieces.append(piece)

    def samples(self) -> NDArray[np.int16]:
        """All of it, at 16 kHz; nothing is added from now on."""
        return np.concatenate([np.zeros(0, np.int16), *self._pieces, self._intake.rest()])


def describe(offer: Offer) -> Info:
    """What is offered, as it is told to those who ask."""
    from wyoming.info import AsrModel, AsrProgram, Attribution, Info, TtsProgram, TtsVoice

    def about(name: str, what: str) -> dict[str, Any]:
        maker = Attribution("sayso", "")
        return {"name": name, "description": what, "attribution": maker, "installed": True, "version": __version__}

    asr, tts = [], []
    if offer.recogniser is not None:
        name = offer.recogniser.name  # what follows in brackets changes from start to start
        model = AsrModel(**about(name.partition(" (")[0], name), languages=list(offer.hears))
        asr = [AsrProgram(**about("sayso", "the recogniser of sayso"), models=[model])]
    if offer.voice is not None:
        voice = TtsVoice(**about(offer.voice.name, "the voice of sayso"), languages=list(offer.says))
        tts = [TtsProgram(**about("sayso", "the voice of sayso"), voices=[voice])]
    return Info(asr=asr, tts=tts)


def _is_empty(event: Event) -> bool:
    """It is a piece of sound in which there is none: who sends such pieces has stopped all the same."""
    from wyoming.audio import AudioChunk

    return AudioChunk.is_type(event.type) and not event.payload


def _names(wish: Transcribe) -> list[str]:
    """Words that the recogniser is to expect, the more useful first."""
    names = [*(wish.transcript_names or ()), *(wish.transcript_terms or ())]
    return [str(name)[:_NAME_SIGNS] for name in names[:_NAMES]]


def _at(rate: int, piece: Piece) -> NDArray[np.int16]:
    """A piece of sound at the rate of the ones before it: two voices may differ."""
    if piece.rate == rate:
        return piece.samples
    sound = soxr.resample(piece.samples.astype(np.float32), piece.rate, rate)
    return np.asarray(np.clip(np.rint(sound), -32768, 32767), np.int16)
