"""The protocol of a large model: messages in, one reply out, and what can go wrong on the way.

A model is a service of somebody else's. Every failure is one of the errors below, with a sentence that names the
platform and a hint that names the setting; none of them ever holds a key.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

from engine.errors import ExitCode, SaysoError

Role = Literal["system", "user", "assistant"]


@dataclass(frozen=True, slots=True)
class Message:
    """One thing that was said."""

    role: Role
    text: str
    picture: bytes | None = None  # a PNG or JPEG file


@dataclass(frozen=True, slots=True)
class Reply:
    """What a model answered."""

    text: str  # as it came, but without the spaces around it; never empty


class Chat(Protocol):
    """A large model that is ready to be asked."""

    @property
    def name(self) -> str:
        """The platform, as the configuration calls it."""
        ...

    async def reply(self, messages: Sequence[Message]) -> Reply:
        """Ask, and wait for the whole answer. Cancelling closes the connection at once. Raises :class:`ChatError`."""
        ...


class ChatError(SaysoError):
    """A large model gave no answer."""

    code = "model_service"


class KeyWanted(ChatError):
    """The service wants a key, and there is none that could be sent."""

    code = "model_key"
    exit_code = ExitCode.MISSING


class Unreachable(ChatError):
    """Nobody answers at that address, or the connection broke."""

    code = "model_unreachable"
    exit_code = ExitCode.MISSING


class Refused(ChatError):
    """The service answered that it will not; ``status`` is its HTTP status."""

    code = "model_refused"

    def __init__(self, message: str, status: int, *, hint: str = "") -> None:
        super().__init__(message, hint=hint)
        self.status = status


class TooSlow(ChatError):
    """The answer did not come in time."""

    code = "model_too_slow"
    exit_code = ExitCode.TIMEOUT


class Unreadable(ChatError):
    """What came is no answer."""

    code = "model_unreadable"
