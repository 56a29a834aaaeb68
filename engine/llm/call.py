"""One question to one model, and what came of it, for the record.

Whatever becomes of a call is told once: answered, failed, broken off, or answered after all when nobody waited any
more. What is told holds what was said and what was answered, and nothing of how it travelled: no address, no header.
"""

from __future__ import annotations

import asyncio
import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from engine.clock import Clock
from engine.events import Layer, MessageView, ModelAsked
from engine.llm.chat import Ask, Chat, ChatError, Hear, Message, Reply

MAX_TEXT: Final = 20_000
"""Characters that are told of all messages together, of a reply, and of an error."""
_PNG: Final = b"\x89PNG\r\n\x1a\n"
_PNG_SIZE: Final = slice(16, 24)
"""Width and height in a PNG file (https://www.w3.org/TR/png-3/#11IHDR)."""


@dataclass(frozen=True, slots=True)
class Call:
    """A call that is over."""

    platform: str
    model: str
    ask: Ask
    duration_s: float
    came: str  # the answer, or what had come of it
    reply: Reply | None = None
    error: ChatError | None = None
    cancelled: bool = False  # it was broken off before it was answered

    def as_event(self, layer: Layer, round: int) -> ModelAsked:
        """``round``: 1 for a question, 2 when its answer was given back."""
        head, newer = self.ask.messages[: self.ask.shared], self.ask.messages[self.ask.shared :]
        reply = self.reply
        return ModelAsked(
            layer=layer,
            platform=self.platform,
            model=self.model,
            round=round,
            head=_fingerprint(head),
            head_length=sum(len(message.text) for message in head),
            messages=_told(newer),
            reply=_cut(self.came, MAX_TEXT),
            duration_s=self.duration_s,
            error_code=None if self.error is None else self.error.code,
            error="" if self.error is None else _cut(str(self.error), MAX_TEXT),
            prompt_tokens=reply.prompt_tokens if reply is not None else 0,
            cached_tokens=reply.cached_tokens if reply is not None else 0,
            reply_tokens=reply.reply_tokens if reply is not None else 0,
            cut_off=reply is not None and reply.cut_off,
            cancelled=self.cancelled,
        )


Tell = Callable[[Call], object]
"""Is given each call when it is over."""


def untold(call: Call) -> None:
    pass


async def reply_of(chat: Chat, ask: Ask, hear: Hear, tell: Tell, clock: Clock) -> Reply:
    """``chat.reply``, with ``tell`` told of it however it ends."""
    began = clock.now()
    pieces: list[str] = []
    reply: Reply | None = None
    failed: ChatError | None = None

    def overhear(piece: str) -> None:
        pieces.append(piece)
        hear(piece)

    try:
        reply = await chat.reply(ask, overhear)
    except ChatError as error:
        failed = error
        raise
    finally:
        task = asyncio.current_task()
        cancelled = reply is None and task is not None and task.cancelling() > 0
        if cancelled:
            failed = None  # because it was cut off
        came = "".join(pieces) if reply is None else reply.text
        tell(Call(chat.name, chat.model, ask, clock.now() - began, came, reply, failed, cancelled))
    return reply


def _fingerprint(messages: Sequence[Message]) -> str:
    """The same for the same messages: the first digits of a SHA-256; empty where there are none."""
    if not messages:
        return ""
    digest = hashlib.sha256()
    for message in messages:
        digest.update(f"{message.role}\0{message.text}\0".encode("utf-8", "replace"))
    return digest.hexdigest()[:16]


def _told(messages: Sequence[Message]) -> tuple[MessageView, ...]:
    """The messages, the newest whole as far as there is room."""
    told: list[MessageView] = []
    left = MAX_TEXT
    for message in reversed(messages):
        text = _cut(message.text, left)
        left = max(0, left - len(message.text))
        if message.picture is not None:
            text = f"{text}\n{_picture(message.picture)}".lstrip()
        told.append(MessageView(message.role, text))
    return tuple(reversed(told))


def _cut(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[:most]}… [{len(text) - most} characters more]"


def _picture(file: bytes) -> str:
    """What stands for a picture."""
    size = file[_PNG_SIZE]
    if not file.startswith(_PNG) or len(size) < 8:
        return "[picture]"
    return f"[picture {int.from_bytes(size[:4])}×{int.from_bytes(size[4:])}]"
