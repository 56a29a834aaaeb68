"""A large model's answer to a question about a picture: what perception has no words for.

The model gets the picture as a file, enlarged, because models are trained on greater ones; what it answers is made
fit to be shown.
"""

from __future__ import annotations

import asyncio
from typing import Final

import cv2

from engine.clock import Clock, SystemClock
from engine.llm.call import Tell, reply_of, untold
from engine.llm.chat import Ask, Chat, Message, _deaf
from engine.robot.camera import Picture

LONGEST: Final = 400
"""Characters of an answer that are passed on."""
TOKENS: Final = 1024
"""Longest answer; some models think aloud before it."""
WIDTH: Final = 480
"""A picture that is narrower is enlarged to this, pixels…"""
MOST: Final = 4
"""…but not more than so many times."""


class Onlooker:
    """Tells what a picture shows, by asking a model that sees."""

    def __init__(self, chat: Chat, clock: Clock | None = None) -> None:
        self._chat = chat
        self._clock = clock or SystemClock()

    async def __call__(self, picture: Picture, question: str, tell: Tell = untold) -> str:
        """The answer on one line, at most ``LONGEST`` printable characters; ``tell`` is told of the call, however it
        ends. Raises ``ChatError``."""
        file = await asyncio.to_thread(as_png, picture)
        ask = Ask((Message("user", question, file),), max_tokens=TOKENS)
        reply = await reply_of(self._chat, ask, _deaf, tell, self._clock)
        return printable(reply.text)

    async def close(self) -> None:
        """Leave no connection behind."""
        await self._chat.close()


def as_png(picture: Picture) -> bytes:
    """A PNG file, enlarged to ``WIDTH`` where that takes no more than ``MOST`` times."""
    height, width = picture.rgb.shape[:2]
    times = min(MOST, -(-WIDTH // width))
    bgr = cv2.cvtColor(picture.rgb, cv2.COLOR_RGB2BGR)
    if times > 1:
        bgr = cv2.resize(bgr, (times * width, times * height), interpolation=cv2.INTER_CUBIC)
    done, file = cv2.imencode(".png", bgr)
    assert done, "there is memory for a picture"
    return file.tobytes()


def printable(text: str) -> str:
    """``text`` on one line, without anything that a terminal could take for a command, and not too long."""
    line = " ".join("".join(sign if sign.isprintable() else " " for sign in text).split())
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 1]}…"
