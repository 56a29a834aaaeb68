"""A platform on the network: how long and how often it is asked, and what its failures are called.

Only what may be over in a moment is tried again, after a pause that grows and is never the same twice, and never once
something of the answer was heard. All attempts share the platform's time. The key is in nothing that could be shown;
where a service repeats it, it is blotted out.
"""

from __future__ import annotations

import asyncio
import math
import random
import re
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, TypeVar
from urllib.parse import urlsplit

from pydantic import Field, SecretStr

from config.schema import Platform
from config.secrets import secrets_of_url
from engine.errors import SaysoError, one_line
from engine.llm.chat import ChatError, KeyWanted, Refused, TooSlow, Unreachable, Unreadable
from engine.llm.streamed import MASK
from engine.strict_json import read_json

if TYPE_CHECKING:
    import httpx2

TRIES: Final = 3
PAUSE_S: Final = 0.3
"""Before the second attempt, s; twice as long before each further one."""
LONGEST_PAUSE_S: Final = 5.0
"""A service that wants to be left alone for longer is not asked again."""
Tokens = Annotated[int, Field(ge=0, lt=1 << 53)]
"""How a service counts them; a greater number is no count, and no reader of events could take it."""
T = TypeVar("T")
_TOLD: Final = 200  # characters of what a service says about its refusal
_LONGEST: Final = 500  # characters of a message as a whole
_SENDABLE: Final = re.compile(r"[!-~]*")  # what a header can carry
_JPEG: Final = b"\xff\xd8"
_PNG: Final = b"\x89PNG"


@dataclass(frozen=True, slots=True)
class Failure:
    """One attempt that gave no answer."""

    error: ChatError
    may_pass: bool = False  # it may be over in a moment
    wait_s: float | None = None  # for so long the service wants to be left alone
    said: str = ""  # by the service, in full
    code: str = ""  # its own word for it


class Service:
    """One platform."""

    def __init__(self, name: str, platform: Platform, kind: str, remedy: str, uds: Path | None = None) -> None:
        """``kind`` is what it should be, in words, and ``remedy`` what to look at when it does not take a question.
        With ``uds`` it is at that UNIX socket."""
        self.name = name
        self.where = f"platforms.{name}"
        self.base_url = (platform.base_url or "http://localhost/v1").rstrip("/")
        self._kind = kind
        self._remedy = remedy
        self._model = platform.model
        self._uds = uds
        self._address = "its socket" if uds is not None else urlsplit(self.base_url).hostname or ""
        self._timeout_s = platform.timeout_s
        self._key = SecretStr(platform.api_key.get_secret_value().strip()) if platform.api_key else SecretStr("")
        self._client: httpx2.AsyncClient | None = None

    @property
    def secret(self) -> str:
        """What nobody may read, or nothing."""
        return self._key.get_secret_value()

    async def client(self) -> httpx2.AsyncClient:
        """What carries requests; takes a while the first time, but not of the loop."""
        if self._client is None:
            self._client = await asyncio.to_thread(self._made)
        return self._client

    def _made(self) -> httpx2.AsyncClient:
        from engine.llm.transport import make_client

        return make_client(self._key, self._uds)

    async def close(self) -> None:
        if self._client is not None:
            client, self._client = self._client, None
            await client.aclose()

    async def ask(self, attempt: Callable[[], Awaitable[T | Failure]]) -> T:
        """The answer of the first attempt that gives one. Raises :class:`ChatError`."""
        if not _SENDABLE.fullmatch(self.secret):
            message = f"The key of the platform {self.name} has characters that no key has."
            raise KeyWanted(message, hint=f"Look at {self.where}.api_key, and at the variable it names.")
        limit = asyncio.timeout(self._timeout_s)
        found: T | ChatError
        try:
            async with limit:
                found = await self._patiently(attempt, limit)
        except TimeoutError:
            if not limit.expired():
                raise
            found = TooSlow(
                f"The model of the platform {self.name} did not answer within {self._timeout_s:g} s.",
                hint=f"Give it longer with {self.where}.timeout_s, or take a faster model.",
            )
        if isinstance(found, ChatError):
            found.message = one_line(self.blotted(found.message), _LONGEST)
            found.args = (found.message,)
            raise found  # here, where no exception is being handled whose request has the key in it
        return found

    async def _patiently(self, attempt: Callable[[], Awaitable[T | Failure]], limit: asyncio.Timeout) -> T | ChatError:
        for count in range(TRIES):
            found = await self._attempted(attempt)
            if not isinstance(found, Failure):
                return found
            pause = back_off(count, found.wait_s, random.random())
            until = limit.when()
            in_time = until is None or asyncio.get_running_loop().time() + (pause or 0) < until
            if not found.may_pass or pause is None or not in_time or count == TRIES - 1:
                return found.error
            await asyncio.sleep(pause)
        raise AssertionError("the last attempt returns")

    async def _attempted(self, attempt: Callable[[], Awaitable[T | Failure]]) -> T | Failure:
        """What came of one attempt. Whatever a service does to make our reading of it fail is a failure of its own."""
        try:
            return await attempt()
        except SaysoError:
            raise
        except Exception as error:  # noqa: BLE001 - what it says may hold what the service sent: only its kind is told
            fault = type(error).__name__
        return Failure(self.unreadable(f"it is nothing that was expected ({fault})"))

    def broken(self, error: Exception, begun: bool = False) -> Failure:
        """The connection did not come about, or it broke; ``begun``: in the middle of an answer."""
        from engine.llm.transport import Overlong

        cause = error.__cause__ or error
        if isinstance(cause, Overlong):
            return Failure(self.unreadable(str(cause)))
        why = (self._short(str(cause)) or type(cause).__name__).rstrip(".")
        if begun:
            message = f"The platform {self.name} broke off in the middle of its answer: {why}."
        else:
            message = f"The platform {self.name} cannot be reached at {self._address}: {why}."
        hint = f"Check the network, and {self.where}.base_url." if self._uds is None else "Ask again."
        return Failure(Unreachable(message, hint=hint), may_pass=not begun)

    def refused(self, status: int, body: bytes, headers: Mapping[str, str], begun: bool = False) -> Failure:
        """The service said no, with an HTTP status and whatever it says about it."""
        complaint = self.blotted(_complaint(body))
        said = self._short(complaint)
        message = f"The platform {self.name} refused with status {status}{f': {said}' if said else ''}".rstrip(".")
        may_pass = (status == 429 or status >= 500) and status != 501 and not begun
        error: ChatError
        if status in (401, 403) and not self._key:
            hint = f"It wants a key: give it one with {self.where}.api_key: ${{VARIABLE}}, and set that variable."
            error = KeyWanted(f"{message}.", hint=hint)
        else:
            error = Refused(f"{message}.", status, hint=self._hint(status))
        return Failure(error, may_pass, _wanted_pause(headers), complaint, _code(body))

    def _hint(self, status: int) -> str:
        model = f", and that there is a model called {self._model}" if self._model else ""
        hints = {
            401: f"Check the key: the variable that {self.where}.api_key names.",
            403: f"Check the key: the variable that {self.where}.api_key names, and what it may do.",
            404: f"Check {self.where}.base_url{model}.",
            429: "Wait a while, or look at the limits of your account.",
        }
        if 300 <= status < 400:
            return f"It sends one elsewhere, where sayso does not go: set {self.where}.base_url to the right address."
        if status >= 500:
            return "Try again later."
        return hints.get(status, self._remedy)

    def unreadable(self, why: str) -> Unreadable:
        hint = f"Check that {self.where}.base_url is that of {self._kind}." if self._uds is None else "Ask again."
        return Unreadable(f"The answer of the platform {self.name} cannot be read: {why}.", hint=hint)

    def blotted(self, text: str) -> str:
        for secret in (self.secret, *secrets_of_url(self.base_url)):
            text = text.replace(secret, MASK) if secret else text
        return text

    def _short(self, text: str) -> str:
        """What a service said, fit to be shown: one line, without the key, not too long."""
        return one_line(self.blotted(text), _TOLD)


def back_off(failures: int, wanted_s: float | None, chance: float) -> float | None:
    """How long to wait after so many failures before the next attempt, s; None: do not try again. ``wanted_s`` is what
    the service asked for, ``chance`` from 0 to 1 keeps those apart who failed together."""
    if wanted_s is None:
        return float(PAUSE_S * 2**failures * (0.5 + chance))
    return wanted_s if wanted_s <= LONGEST_PAUSE_S else None


def media_type(picture: bytes) -> str:
    """What kind of file a picture is. Raises ``ValueError``."""
    if picture.startswith(_PNG):
        return "image/png"
    if picture.startswith(_JPEG):
        return "image/jpeg"
    raise ValueError("a picture is a PNG or a JPEG file")


def _wanted_pause(headers: Mapping[str, str]) -> float | None:
    """Retry-After (RFC 9110, 10.2.3), s: a number of seconds, or a date."""
    text = headers.get("retry-after", "")
    try:
        seconds = float(text)
    except ValueError:
        try:
            seconds = (parsedate_to_datetime(text) - datetime.now(UTC)).total_seconds()
        except OverflowError:  # a year that no calendar has
            return math.inf
        except (ValueError, TypeError):
            return None
    return max(0.0, seconds) if seconds == seconds else None


def _code(body: bytes) -> str:
    try:
        told = read_json(body)
    except ValueError:
        return ""
    return str(told["code"]) if isinstance(told, dict) and "code" in told else ""


def _complaint(body: bytes) -> str:
    """What a refusal says, in whichever of the usual ways; else the beginning of it as it stands."""
    text = body.decode("utf-8", "replace")
    try:
        told = read_json(text)
    except ValueError:
        return text
    for key in ("error", "message", "detail"):
        while isinstance(told, dict) and key in told:
            told = told[key]
    return told if isinstance(told, str) else text
