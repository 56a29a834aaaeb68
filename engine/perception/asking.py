"""A large model's answer to a question about a picture: what perception has no words for.

The model gets the picture as a file, enlarged, because models are trained on greater ones; what it answers is made
fit to be shown.
"""

from __future__ import annotations

import asyncio
from typing import Final

import cv2

from engine.llm.chat import Chat, Message
from engine.robot.camera import Picture

LONGEST: Final = 400
"""Characters of an answer that are passed on."""
WIDTH: Final = 480
"""A picture that is narrower is enlarged to this, pixels…"""
MOST: Final = 4
"""…but not more than so many times."""


class Onlooker:
    """Tells what a picture shows, by asking a model that sees."""

    def __init__(self, chat: Chat) -> None:
        self._chat = chat

    async def __call__(self, picture: Picture, question: str) -> str:
        """The answer on one line, at most ``LONGEST`` printable characters. Raises ``ChatError``."""
        file = await asyncio.to_thread(as_png, picture)
        reply = await self._chat.reply([Message("user", question, file)])
        return printable(reply.text)


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
