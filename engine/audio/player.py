"""What the robot plays: one mixer, from which an output pulls a block of sound at a time.

Everybody who plays has a :class:`Playback`; all of them sound together. :meth:`Player.stop` silences what was begun
before it, from any thread, without waiting for anybody, within the block that is pulled next (20 ms). A playback knows
how far it has *sounded*, not how far it was handed over: that is what people can have heard.

The player knows what it says: :attr:`Player.sounded` has the last seconds as the loudspeaker had them, so that ears can
tell them from what somebody else says. Short sounds (:meth:`Player.play`) are not in there: nobody takes them for
speech, and ears that know as little of an echo as a chime can teach would take the first word after a wake for it.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections import deque
from collections.abc import Callable
from typing import Any, Final, Literal, Protocol

import numpy as np
import soxr
from numpy.typing import NDArray

from engine.audio.sounded import Sounded
from engine.audio.source import Samples, to_int16
from engine.epoch import FIRST
from engine.errors import SaysoError

BLOCK_S: Final = 0.02
"""What an output pulls at a time, s."""
FADE_S: Final = 0.005
"""In which a sound that is cut off fades, s: cut at once it would click."""
REST_S: Final = 10.0
"""The output rests when nothing has sounded for so long, s: it uses a processor and a device that others want, too."""
BUFFER_S: Final = 0.06
"""So much must be there before a sound begins, or goes on after it ran dry, s, unless that is all: what comes from a
network comes in fits and starts, and each gap in it would be heard."""
_FEED_S: Final = 0.5  # how much sound is resampled at a time

Stage = Literal["on", "over", "cut"]
Sound = NDArray[np.float32]
Pull = Callable[[int, float], Samples]
"""Gives the next so many samples, of which the first sounds at that time (of the loop's clock, s). Any thread."""


class Output(Protocol):
    """Where sound goes. All but the pulling belongs to the loop's thread."""

    @property
    def name(self) -> str:
        """For people."""
        ...

    @property
    def rate(self) -> int:
        """Hz; known once it is open."""
        ...

    async def open(self, pull: Pull, lost: Callable[[SaysoError], None], *, patient: bool = False) -> None:
        """Find the device; it rests. ``lost`` may be called in any thread. ``patient``: wait until it is there. Raises
        ``DeviceError``."""
        ...

    async def start(self) -> None:
        """Begin to pull. Raises ``DeviceError``."""
        ...

    async def stop(self) -> None:
        """Rest."""
        ...

    def hush(self) -> None:
        """Drop what was pulled and has not sounded. Any thread; never blocks."""
        ...

    async def close(self) -> None:
        """Let go of the device."""
        ...


class Playback:
    """One thing that is being played: fed by whoever made it, in the loop's thread, and pulled by the player."""

    def __init__(self, player: Player, epoch: int, gain: float, *, ducks: bool) -> None:
        self.epoch = epoch
        self.position = 0.0
        """How much of it has sounded, s."""
        self.ended = False
        """It has sounded to its end, or was silenced, or its output was lost."""
        self.complete = False
        """It has sounded to its end."""
        self.error: SaysoError | None = None
        self._player = player
        self._gain = gain
        self._ducks = ducks
        self._blocks: deque[Sound] = deque()
        self._resampler: Any = None
        self._from = 0  # Hz, what is fed
        self._whole = False
        self._silent = False
        self._taken = 0  # samples, at the player's rate
        self._dry = True  # it waits for more of its sound
        self._news = asyncio.Event()

    @property
    def length(self) -> float:
        """How much of it there is so far, s."""
        return (self._taken + sum(map(len, tuple(self._blocks)))) / self._player.rate

    @property
    def silenced(self) -> bool:
        """Somebody has stopped it; nothing of it sounds any more."""
        return self._silent or self._player.is_over(self.epoch)

    async def feed(self, samples: Samples, rate: int) -> None:
        """Some more of its sound. What comes after it was silenced goes nowhere."""
        for start in range(0, len(samples), max(1, round(rate * _FEED_S))):
            if self.silenced:
                return
            part = samples[start : start + round(rate * _FEED_S)].astype(np.float32) / np.float32(32768)
            self._blocks.append(self._resampled(part, rate))
            await asyncio.sleep(0)  # a long sentence must not hold up the others here

    def flush(self) -> None:
        """What was fed sounds to its end, whatever comes next: resampling holds some of it back until then."""
        if self._resampler is not None:
            self._blocks.append(self._resampler.resample_chunk(np.zeros(0, np.float32), last=True))
            self._resampler = None

    def finish(self) -> None:
        """That was all of it."""
        self.flush()
        self._whole = True

    def stop(self) -> None:
        """Silence it, and nothing else. Thread-safe."""
        self._silent = True

    async def news(self) -> None:
        """Wait until more of it has sounded, or it has ended. Raises the ``SaysoError`` that its output was lost by."""
        if not self.ended:
            self._news.clear()
            await self._news.wait()
        if self.error is not None:
            raise self.error

    async def until_ended(self) -> None:
        """Wait for the end. Raises like :meth:`news`."""
        await self.news()
        while not self.ended:
            await self.news()

    def _resampled(self, sound: Sound, rate: int) -> Sound:
        if rate != self._from:
            self.flush()
            self._from = rate
        if rate == self._player.rate:
            return sound
        if self._resampler is None:
            self._resampler = soxr.ResampleStream(rate, self._player.rate, 1, dtype="float32")
        return np.asarray(self._resampler.resample_chunk(sound), np.float32)

    # What the player does with it

    def take(self, count: int) -> tuple[Sound, Stage]:
        """The next samples, fewer where there are no more yet, and what comes after them. A silenced one fades. In the
        output's thread."""
        silenced = self.silenced
        if silenced:
            count = min(count, round(FADE_S * self._player.rate))
        whole = self._whole  # before the look at the blocks: whoever finishes has fed all of it
        if self._dry and (whole or silenced or self.length - self._taken / self._player.rate >= BUFFER_S):
            self._dry = False
        parts, missing = [], count
        while missing and self._blocks and not self._dry:
            block = self._blocks.popleft()
            if len(block) > missing:
                self._blocks.appendleft(block[missing:])
                block = block[:missing]
            parts.append(block)
            missing -= len(block)
        self._dry = bool(missing)
        sound: Sound = np.concatenate(parts) if parts else np.zeros(0, np.float32)
        if silenced:
            sound = sound * np.linspace(1, 0, len(sound), dtype=np.float32)
            self._blocks.clear()
        else:
            self._taken += len(sound)
        stage: Stage = "cut" if silenced else "over" if whole and not self._blocks else "on"
        return sound * np.float32(self._gain), stage

    def sounded(self, taken: int, stage: Stage) -> None:
        """So many samples have sounded. In the loop's thread."""
        self.position = max(self.position, taken / self._player.rate)
        self.ended |= stage != "on"
        self.complete |= stage == "over"
        self._news.set()

    def lose(self, error: SaysoError) -> None:
        """There is nothing to sound through any more. In the loop's thread."""
        if not self.ended:
            self.error, self.ended = error, True
            self._news.set()

    @property
    def taken(self) -> int:
        return self._taken

    @property
    def ducks(self) -> bool:
        return self._ducks


class Player:
    """The robot's loudspeaker. Belongs to the loop in which it is opened, but for :meth:`stop`, :meth:`duck`,
    :meth:`set_volume` and :attr:`sounded`, which are for any thread."""

    def __init__(self, output: Output, *, volume: float = 1.0, duck_db: float = 12.0) -> None:
        """``volume``: 0…1. ``duck_db``: how much quieter it is while somebody else is to be heard, dB."""
        self._output = output
        self._volume = volume
        self._sounding_volume = volume  # at the end of the last block
        self._ducked = 10 ** (-duck_db / 20)
        self._ducking = False
        self._gain = 1.0  # of what ducks, at the end of the last block
        self._epoch = FIRST  # of the newest stop: what was begun before it is over
        self._active: list[Playback] = []
        self._changing = threading.Lock()  # guards the list above, for moments
        self.sounded = Sounded()
        """What was said when, by the loop's clock; any thread."""
        self.spoken_s = 0.0
        """How much speech has been played so far, s; any thread."""
        self._last_sound = 0.0
        self._wanted = asyncio.Event()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._keeping: asyncio.Task[None] | None = None
        self._error: SaysoError | None = None
        self.tell: Callable[[SaysoError | None], None] = lambda error: None
        """Is told, in the loop's thread, when the output is lost, and with None when it is there again."""

    @property
    def name(self) -> str:
        return self._output.name

    @property
    def rate(self) -> int:
        """Hz, of all that is mixed."""
        return self._output.rate

    @property
    def busy(self) -> bool:
        """Something is being played, or would be if there were more of it yet. Any thread."""
        return bool(self._active)

    @property
    def usable(self) -> bool:
        """It is open, and its output was not lost since."""
        return self._loop is not None and self._error is None

    @property
    def trouble(self) -> SaysoError | None:
        """What its output was lost by, until it is there again."""
        return self._error

    async def open(self, *, patient: bool = False) -> None:
        """Find the output; open it anew where it was lost. ``patient``: wait until it is there. One at a time. Raises
        ``DeviceError``."""
        if self.usable:
            return
        await self.close()
        await self._output.open(self.pull, self._lose, patient=patient)
        self._loop = asyncio.get_running_loop()
        if self._error is not None:
            self._error = None
            self.tell(None)
        self._wanted.clear()
        self._keeping = self._loop.create_task(self._keep(), name="player")

    async def close(self) -> None:
        """Silence everything, and let go of the output."""
        keeping, self._keeping, self._loop = self._keeping, None, None
        if keeping is not None:
            keeping.cancel()
            await asyncio.gather(keeping, return_exceptions=True)
            await self._output.close()
        with self._changing:
            left, self._active = self._active, []
        for playback in left:
            playback.stop()
            playback.sounded(0, "cut")

    # For any thread

    def stop(self, epoch: int) -> None:
        """Silence all that was begun before ``epoch``, in the next block. Never blocks."""
        if epoch > self._epoch:
            self._epoch = epoch
            if self._active:
                self._output.hush()

    def is_over(self, epoch: int) -> bool:
        """Whether what was begun in ``epoch`` has been stopped."""
        return epoch < self._epoch

    def set_volume(self, volume: float) -> None:
        """So loud from the next block on, 0…1; any thread."""
        self._volume = volume

    def duck(self, on: bool) -> None:
        """From now on speech is quieter, or as loud as usual again. Never blocks."""
        self._ducking = on

    # Playing

    @property
    def epoch(self) -> int:
        """What is begun from here on belongs to it, or is silenced by whoever stops until it has begun."""
        return self._epoch

    def begin(self, epoch: int | None = None, *, gain: float = 1.0, ducks: bool = True) -> Playback:
        """Something that will be fed with sound, as of ``epoch``: without one, as of now. Of one without an output
        nothing sounds, and it has ended."""
        playback = Playback(self, self._epoch if epoch is None else epoch, gain, ducks=ducks)
        if not self.usable:
            playback.ended = True
            return playback
        with self._changing:
            self._active.append(playback)
        self._wanted.set()
        return playback

    def play(self, sound: Sound, *, gain: float = 1.0) -> Playback:
        """Play a short sound (shape (n,), ±1, at the player's rate) that does not duck."""
        playback = self.begin(gain=gain, ducks=False)
        playback._blocks.append(sound)
        playback.finish()
        return playback

    def pull(self, count: int, sounds_at: float) -> Samples:
        """See :data:`Pull`."""
        mixed, said = np.zeros((2, count), np.float32)
        target = self._ducked if self._ducking else 1.0
        ramp = np.linspace(self._gain, target, count, dtype=np.float32) if target != self._gain else None
        with self._changing:
            active = tuple(self._active)
        ended = []
        for playback in active:
            sound, stage = playback.take(count)
            if playback.ducks:
                sound = sound * (ramp[: len(sound)] if ramp is not None else np.float32(target))
            mixed[: len(sound)] += sound
            if playback.ducks:
                said[: len(sound)] += sound
                self.spoken_s += len(sound) / self.rate
            if stage != "on":
                ended.append(playback)
            self._tell(playback, playback.taken, sounds_at + len(sound) / self.rate, stage)
        self._gain = target
        before, self._sounding_volume = self._sounding_volume, self._volume
        volume = np.linspace(before, self._sounding_volume, count, dtype=np.float32)  # another one makes no click
        block = to_int16(mixed * volume)
        with self._changing:
            self._active = [playback for playback in self._active if playback not in ended]
            if active:
                self._last_sound = sounds_at
        self.sounded.add(to_int16(said * volume), self.rate, sounds_at)
        return block

    def _tell(self, playback: Playback, taken: int, at: float, stage: Stage) -> None:
        """Tell a playback in the loop how far it has sounded, when it has. In the output's thread."""
        loop = self._loop
        if loop is None:
            return
        with contextlib.suppress(RuntimeError):  # the loop has ended: nobody is interested any more
            loop.call_soon_threadsafe(lambda: loop.call_at(at, lambda: playback.sounded(taken, stage)))

    async def _keep(self) -> None:
        """Let the output run while there is something to play, and a while longer."""
        loop = asyncio.get_running_loop()
        while True:
            await self._wanted.wait()
            try:
                await self._output.start()
            except SaysoError as error:
                self._fail(error)
                return
            self._last_sound = loop.time()
            while self._active or (self._last_sound + REST_S > loop.time()):  # noqa: ASYNC110 - not told of each block
                await asyncio.sleep(max(self._last_sound + REST_S - loop.time(), 1.0))
            self._wanted.clear()
            await self._output.stop()
            if self._active:  # begun meanwhile
                self._wanted.set()

    def _lose(self, error: SaysoError) -> None:
        """The output is lost. In any thread."""
        loop = self._loop
        if loop is not None:
            with contextlib.suppress(RuntimeError):
                loop.call_soon_threadsafe(self._fail, error)

    def _fail(self, error: SaysoError) -> None:
        if not self.usable:
            return
        self._error = error
        with self._changing:
            left, self._active = self._active, []
        for playback in left:
            playback.lose(error)
        self.tell(error)
