"""Speaking: from a text to what people have heard of it. Joins a voice that makes sound and a player.

The first sentence sounds while the next one is synthesised. What counts as heard is what has *sounded*, word by word;
whoever interrupts gets silence within a block of sound, and the last word of which they heard the end.
"""

from __future__ import annotations

import asyncio
import re
import time
from collections import deque
from collections.abc import Callable, Coroutine
from contextlib import aclosing, suppress
from dataclasses import dataclass
from math import inf
from typing import Any, Final

from engine.audio.player import Playback, Player
from engine.errors import SaysoError
from engine.events import Event, StateChanged
from engine.tts.sentences import Sentence, sentences
from engine.tts.synthesis import Synthesiser, Timing

AHEAD: Final = 2
"""Sentences that are synthesised before they sound, at most; what is cut off was made in vain."""
STAND_DOWN_S: Final = 1.0
"""How long somebody who was silenced waits to be cancelled, s; that only has to cross a queue."""
ECHO_S: Final = 2.0
"""For how long what has been said may still be recognised by ears that heard it, s."""
_PART: Final = re.compile(r"[^.,;:!?。，；：！？、…]+[.,;:!?。，；：！？、…]*")
_ROUNDING_S: Final = 0.005  # resampling makes a sound a few samples shorter or longer


@dataclass(slots=True)
class _Spoken:
    """A sentence on its way."""

    sentence: Sentence
    timing: Timing
    begins: float  # s, of the playback
    length: float = 0.0  # s, so far
    whole: bool = False  # all of its sound is there

    def is_over(self, position: float) -> bool:
        """Whether all of it has sounded, at this position of the playback."""
        return self.whole and position >= self.begins + self.length - _ROUNDING_S

    def heard(self, position: float) -> int:
        """How many of its words have sounded."""
        if self.is_over(position):
            return len(self.sentence.words)
        return self.timing.said(position - self.begins) if self.length and position > self.begins else 0


class SpokenVoice:
    """Says it aloud. Where there is no sound (the voice still loads, or the loudspeaker is lost), what is shown counts
    as heard. What keeps failing in the same way is only reported once."""

    def __init__(self, player: Player, *, patience_s: float = 0.0) -> None:
        """``patience_s``: how long an answer waits for a voice that still loads."""
        self._player = player
        self._patience_s = patience_s
        self._synthesiser: Synthesiser | None = None
        self._settled = asyncio.Event()  # it is known whether there is one
        self._trouble = ""  # that was reported last, and lasts
        self._lately = deque[str](maxlen=3)  # what sounded
        self._saying = ("", 0.0)  # what sounds, or was the last to; until when it may be overheard
        self.missed: Callable[[], None] = lambda: None
        """Is told, in the loop's thread, that an answer was only shown, for want of a voice."""

    def see(self, event: Event) -> None:
        """Be quieter while somebody is listened to; for the bus, in the loop's thread."""
        if isinstance(event.body, StateChanged):
            self._player.duck(event.body.state == "LISTENING")

    def settle(self, synthesiser: Synthesiser | None) -> None:
        """From now on it speaks with ``synthesiser``, which is loaded; without one it will not speak."""
        self._synthesiser = synthesiser
        self._settled.set()

    @property
    def audible(self) -> bool:
        waits = self._patience_s > 0 and not self._settled.is_set()
        return waits or (self._synthesiser is not None and self._player.usable)

    def not_own(self, words: str) -> str:
        """What of these words cannot be the robot's own, of which a microphone hears what the loudspeaker says: all but
        the parts, between punctuation marks, whose every word begins one that is being said. Any thread."""
        text, until = self._saying
        own = _bare_words(text) if time.monotonic() <= until else set[str]()
        return " ".join(part for part in _PART.findall(words) if not _begin(_bare_words(part), own))

    def repeats(self, words: str) -> bool:
        """Whether these words may be nothing but what the robot said lately. Any thread."""
        own = set[str]().union(*map(_bare_words, tuple(self._lately)))
        return _bare_words(words) <= own

    def say(self, text: str, heard: Callable[[str], None]) -> Coroutine[Any, Any, None]:
        """See ``Voice``. From the moment of this call on, ``Player.stop`` silences it."""
        return self._say(text, heard, self._player.epoch)

    async def _say(self, text: str, heard: Callable[[str], None], epoch: int) -> None:
        synthesiser = await self._loaded()
        if synthesiser is None or not self._player.usable:
            heard(text)
            if synthesiser is None:
                self.missed()
            return
        speech = _Speech(text, heard, self._player.begin(epoch))
        self._saying = (text, inf)
        self._lately.append(text)
        making = asyncio.create_task(speech.make(synthesiser), name="speech")
        try:
            await speech.follow()
            await making
            self._trouble = ""
        except SaysoError as error:
            if str(error) != self._trouble:
                self._trouble = str(error)
                raise
        finally:
            speech.playback.stop()
            self._saying = (text, time.monotonic() + ECHO_S)
            making.cancel()
            await asyncio.gather(making, return_exceptions=True)
        if speech.last != text:
            heard(text)  # what was not to be said aloud is on the screen

    async def _loaded(self) -> Synthesiser | None:
        """The synthesiser, once it is known whether there is one."""
        with suppress(TimeoutError):
            async with asyncio.timeout(self._patience_s):
                await self._settled.wait()
        return self._synthesiser


class _Speech:
    """One text while it is said."""

    def __init__(self, text: str, heard: Callable[[str], None], playback: Playback) -> None:
        self.playback = playback
        self.last: str | None = None
        """What has been heard of it."""
        self._text = text
        self._heard = heard
        self._spoken: list[_Spoken] = []
        self._done = 0  # sentences that have sounded
        self._words = 0  # of the next one
        self._room = asyncio.Semaphore(AHEAD)

    async def make(self, synthesiser: Synthesiser) -> None:
        """Synthesise one sentence after the other, a little ahead of what sounds. Raises ``SaysoError``."""
        fed = 0.0  # s
        try:
            for sentence in sentences(self._text):
                await self._room.acquire()
                spoken = _Spoken(sentence, Timing(sentence), fed)
                self._spoken.append(spoken)
                async with aclosing(synthesiser.synthesise(sentence)) as pieces:
                    async for piece in pieces:
                        spoken.timing.add(piece)
                        spoken.length += len(piece.samples) / piece.rate
                        await self.playback.feed(piece.samples, piece.rate)
                self.playback.flush()
                spoken.timing.finish()
                spoken.whole = True
                fed += spoken.length
        finally:
            self.playback.finish()  # what there is sounds, whatever became of the rest

    async def follow(self) -> None:
        """Tell what has been heard, until all of it was. Raises ``SaysoError``."""
        ended = False
        while not ended:
            await self.playback.news()
            ended = self.playback.ended
            self._tell()
        if not self.playback.complete:
            await asyncio.sleep(STAND_DOWN_S)
            raise SaysoError("The answer was cut off.")

    def _tell(self) -> None:
        """Every word that has sounded since the last time."""
        while self._done < len(self._spoken):
            spoken = self._spoken[self._done]
            count = spoken.heard(self.playback.position)
            for word in spoken.sentence.words[self._words : count]:
                self.last = self._text[: word.end]
                self._heard(self.last)
            self._words = max(self._words, count)
            if not spoken.is_over(self.playback.position):
                return
            self._done, self._words = self._done + 1, 0
            self._room.release()


def _begin(words: set[str], own: set[str]) -> bool:
    """Whether each of these words is one of the ``own``, or the beginning of one."""
    return all(any(said.startswith(word) for said in own) for word in words)


def _bare_words(text: str) -> set[str]:
    words = (word.said for sentence in sentences(text) for word in sentence.words)
    return {word.strip(".,;:!?。，；！？").casefold() for word in words} - {""}
