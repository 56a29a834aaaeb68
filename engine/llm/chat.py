"""The protocol of a large model: messages in, one reply out, and what can go wrong on the way.

A model is a service of somebody else's. Every failure is one of the errors below, with a sentence that names the
platform and a hint that names the setting; none of them ever holds a key.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from engine.errors import ExitCode, SaysoError

Role = Literal["system", "user", "assistant"]


@dataclass(frozen=True, slots=True)
class Message:
    """One thing that was said."""

    role: Role
    text: str
    picture: bytes | None = None  # a PNG or JPEG file


@dataclass(frozen=True, slots=True)
class Ask:
    """One question to a model: all that was said, and how the answer shall be.

    A form (``schema`` or ``grammar``) is a wish: a model that cannot be held to it answers as it likes, and whoever
    asked checks every answer.
    """

    messages: tuple[Message, ...]
    schema: Mapping[str, Any] | None = None
    """JSON schema of the answer."""
    grammar: str | None = None
    """GBNF grammar of the answer (https://github.com/ggml-org/llama.cpp/tree/master/grammars), for llama.cpp, which
    takes it instead of the schema."""
    max_tokens: int = 512
    temperature: float = 0.0
    seed: int = 0
    shared: int = 0
    """So many messages at the beginning are those of many other questions, too: worth keeping what was computed."""
    conversation: str = ""
    """Questions of one conversation have the same name here: a service that keeps the history itself goes on in it, and
    is only sent the last message."""


@dataclass(frozen=True, slots=True)
class Reply:
    """What a model answered."""

    text: str  # as it came, but without the spaces around it; never empty
    model: str = ""  # the platform that answered, as the configuration calls it
    kind: Literal["local", "openai", "dify"] = "openai"
    prompt_tokens: int = 0  # 0 where the service does not say
    cached_tokens: int = 0  # of the prompt, those that needed no computing
    reply_tokens: int = 0
    cut_off: bool = False  # max_tokens ended it


Hear = Callable[[str], None]
"""Is given each piece of an answer as it comes."""


def _deaf(piece: str) -> None:
    pass


class Chat(Protocol):
    """A large model that can be asked."""

    @property
    def name(self) -> str:
        """The platform, as the configuration calls it."""
        ...

    @property
    def model(self) -> str:
        """What the platform runs, as the configuration calls it; empty where only the service knows."""
        ...

    @property
    def held(self) -> bool:
        """Whether it can be held to a grammar."""
        ...

    @property
    def sees(self) -> bool:
        """Whether it is shown pictures."""
        ...

    async def reply(self, ask: Ask, hear: Hear = _deaf) -> Reply:
        """Ask, and wait for the whole answer; ``hear`` gets it piece by piece where the service streams. Cancelling
        closes the connection at once, and the model falls silent. Raises :class:`ChatError`."""
        ...

    async def close(self) -> None:
        """Leave nothing of it behind."""
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
