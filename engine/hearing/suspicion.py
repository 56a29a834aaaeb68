"""The suspicion that somebody has just said a stop, and when to look into it.

Of most phrases the recogniser is asked for a text, with the phrase to expect: at once, and a last time when there was a
pause or a little more was said. What is as short as 停 it hardly ever writes with the right one of many characters that
sound alike: of that it is asked how likely it is that this was said, and nothing else; and again a little later, for 听
and 冬 begin many sentences.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, Literal

from engine.audio.source import Samples
from engine.hearing.speech_watch import Stretch

SUSPECTED_S = 1.5
"""How much is recognised on a suspicion, s: the word, and what makes it another one."""

SECOND_FRAMES = 9
"""Frames after a suspicion (0.3 s) until somebody who talks on is listened to a second and last time."""

SAID: Final[Mapping[str, Sequence[str]]] = {"停": ("停", "停下", "停下来", "停下來", "停止", "别动", "別動")}
"""What may have been said where a phrase is suspected that is known by its likelihood."""

ALONE_FRAMES = 6
"""Frames after such a suspicion (0.2 s) until it shows whether that was all that was said."""

AT_ONCE = -2.0
"""Such a stop counts from this likelihood on while it may be the beginning of more…"""

ALONE = -6.0
"""…and from this one on when it was all. Most stops of three voices are likelier, at 10 dB too; in 26 minutes of talk
by two of them nothing was."""

NEARLY = -7.5
"""Where it was less likely, but more than this, it counts when it is so again in a later look. In noise one in sixteen
such stops is found by that; of 21 minutes of that talk, half of it in noise, nothing else was that likely twice."""

AGAIN_FRAMES = 3
"""Frames (0.1 s) after the look that tells most until that one."""

Verdict = Literal["stop", "nearly", "none", "unknown"]
"""What a stretch of sound held; nearly: another look will tell; unknown: nobody listened to it."""


@dataclass(frozen=True, slots=True)
class Look:
    """What the recogniser is asked on a suspicion."""

    samples: Samples  # the newest stretch
    phrases: Sequence[str]
    sure: bool
    later: bool  # long enough after the suspicion for what else was said to be in it
    again: bool  # it was nearly a stop in the look before

    @property
    def likely(self) -> float:
        """The likelihood from which on a short one was said."""
        return NEARLY if self.again else ALONE if self.later else AT_ONCE


@dataclass(slots=True)
class Suspicion:
    """That somebody has just said one of ``phrases``."""

    phrases: list[str]
    sure: bool
    settled: Callable[[], None]
    likelier: Callable[[], None]
    looks: set[asyncio.Future[Verdict]] = field(default_factory=set)  # that are not over
    looked: int = 0  # looks that are
    due: int | None = ALONE_FRAMES  # frames after which to look at what is short; None: nothing more to be seen
    nearly: bool = False  # it was, in the look that tells most
    held: Stretch | None = None  # what else is to be recognised, but must not be in the way of that
    frames: int = 0  # that have come since

    @property
    def short(self) -> bool:
        """One of them is known by its likelihood."""
        return any(phrase in SAID for phrase in self.phrases)

    @property
    def waits(self) -> bool:
        """It is short, and the look that tells most is not over."""
        return self.short and (self.due is not None or bool(self.looks))

    def repeat(self, phrase: str, *, sure: bool) -> None:
        """The same is suspected once more, or another phrase: one answer is enough."""
        self.looked, self.due, self.nearly = 0, ALONE_FRAMES, False
        if not self.short:  # else what is known by its likelihood would be known later each time
            self.frames = 0
        self.sure |= sure
        if phrase not in self.phrases:
            self.phrases.append(phrase)

    def look(self, newest: Samples) -> Look:
        """What to ask of the newest stretch now."""
        if later := self.short and self.is_due(paused=False):
            self.due, self.frames = None, 0
        phrases = tuple(phrase for phrase in self.phrases if phrase in SAID or not self.nearly)
        return Look(newest, phrases, self.sure, later, self.nearly)

    def look_again(self) -> None:
        """It was nearly a stop: another look will tell."""
        self.nearly, self.due = True, AGAIN_FRAMES

    def is_urgent(self, phrase: str, *, sure: bool) -> bool:
        """``phrase``, which was suspected just now, is to be looked for at once."""
        soon = self.due is not None and self.due - self.frames <= AGAIN_FRAMES < self.due
        return phrase not in SAID or (sure and not soon)  # else what tells most would wait for the answer

    def is_due(self, *, paused: bool) -> bool:
        """It is time to look again; ``paused``: who spoke has just stopped."""
        if self.short:
            return self.due is not None and self.frames >= self.due
        return self.frames >= SECOND_FRAMES or paused

    def is_over(self, *, talking: bool) -> bool:
        """No look is missing but those that are not over."""
        return self.due is None if self.short else self.looked >= (2 if talking else 1)
