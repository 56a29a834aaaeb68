"""Several large models as one: where the first does not answer, the next one is asked.

One that failed rests for a while, longer each time, so that a dead service does not cost its timeout at every question.
Who is asked instead of whom is told. When all fail, the first error is raised, with what the others said.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from engine.clock import Clock, SystemClock
from engine.llm.call import Tell, reply_of, untold
from engine.llm.chat import Ask, Chat, ChatError, Hear, Refused, Reply, _deaf

REST_S: Final = 30.0
"""After the first failure; twice as long after each further one…"""
LONGEST_REST_S: Final = 600.0
"""…but no longer than this."""
_OF_THE_QUESTION: Final = frozenset((400, 413, 415, 422))
"""Statuses that say something of this question and nothing of the next one."""


@dataclass(slots=True)
class _Link:
    """One model, and how it is doing."""

    chat: Chat
    failures: int = 0  # in a row
    until: float = 0.0  # rests until then

    def fail(self, now: float) -> None:
        self.failures += 1
        self.until = now + min(REST_S * 2.0 ** min(self.failures - 1, 10), LONGEST_REST_S)


class Chain:
    """A :class:`Chat` that has others to fall back on.

    What is heard of an answer that breaks off is followed by the whole of another one: only the reply counts.
    """

    def __init__(self, chats: Sequence[Chat], tell: Callable[[str], None], clock: Clock | None = None) -> None:
        """``tell`` gets a sentence when another model is asked than before. The chain closes the chats."""
        assert chats
        self._links = [_Link(chat) for chat in chats]
        self._tell = tell
        self._clock = clock or SystemClock()

    @property
    def name(self) -> str:
        """The platform that is asked first."""
        return self._links[0].chat.name

    @property
    def model(self) -> str:
        return self._links[0].chat.model

    @property
    def held(self) -> bool:
        return self._links[0].chat.held

    @property
    def sees(self) -> bool:
        return self._links[0].chat.sees

    async def reply(self, ask: Ask, hear: Hear = _deaf) -> Reply:
        return await self.answer(lambda chat: ask, hear)

    async def answer(self, make: Callable[[Chat], Ask], hear: Hear = _deaf, *, tell: Tell = untold) -> Reply:
        """As ``reply``, with a question that ``make`` puts as suits the chat that is asked. ``tell`` is told of each
        call, also of one that failed."""
        now = self._clock.now()
        awake = [link for link in self._links if link.until <= now] or self._links  # rather a tired one than none
        failed: list[ChatError] = []
        for index, link in enumerate(awake):
            try:
                reply = await reply_of(link.chat, make(link.chat), hear, tell, self._clock)
            except ChatError as error:
                task = asyncio.current_task()
                if task is not None and task.cancelling():  # it failed because it was cut off
                    raise asyncio.CancelledError from error
                failed.append(error)
                if not (isinstance(error, Refused) and error.status in _OF_THE_QUESTION):
                    link.fail(self._clock.now())
                if index + 1 < len(awake):
                    self._tell(f"{error} The platform {awake[index + 1].chat.name} is asked instead.")
            else:
                if link.failures:
                    link.failures = 0
                    self._tell(f"The platform {link.chat.name} answers again.")
                return reply
        raise _of_all(failed)

    async def close(self) -> None:
        """Close them all, and raise what the first one that cannot be closed raises."""
        troubles = await asyncio.gather(*(link.chat.close() for link in self._links), return_exceptions=True)
        for trouble in troubles:
            if trouble is not None:
                raise trouble


def _of_all(failed: Sequence[ChatError]) -> ChatError:
    """The first error, with what the others said."""
    first, *others = failed
    if others:
        first.message = " ".join((first.message, *(error.message for error in others)))
        first.args = (first.message,)
    return first
