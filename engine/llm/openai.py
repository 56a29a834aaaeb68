"""Any service that speaks OpenAI's chat completions: OpenAI itself, OpenRouter, DashScope, Ollama, vLLM, llama.cpp.

``POST {base_url}/chat/completions`` (https://platform.openai.com/docs/api-reference/chat), pictures as data URLs.
Everything goes to the configured address and nowhere else: no redirect is followed, and no proxy is taken from the
environment. The key is put into a request when it is sent and is in nothing that could be shown; where a service
repeats it, it is blotted out.
"""

from __future__ import annotations

import asyncio
import base64
import functools
import json
import re
import ssl
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urlsplit

from pydantic import BaseModel, Field, SecretStr, ValidationError

from config.schema import Platform
from engine.llm.chat import ChatError, KeyWanted, Message, Refused, Reply, TooSlow, Unreachable, Unreadable

if TYPE_CHECKING:
    import httpx  # slow to import, and most sessions need no service

PAUSE_S: Final = 0.3
"""Before the one other attempt, s."""
MAX_BYTES: Final = 1 << 20
"""Longest answer that is read; what is longer is no answer to a question of ours."""
_MASK: Final = "********"
_TOLD: Final = 200  # characters of what a service says about its refusal
_THOUGHTS: Final = re.compile(r"\A\s*<think>.*?</think>", re.DOTALL)
_SENDABLE: Final = re.compile(r"[!-~]*")  # what a header can carry
_JPEG: Final = b"\xff\xd8"
_PNG: Final = b"\x89PNG"


class OpenAIChat:
    """One model of one platform. Holds nothing open between two questions."""

    def __init__(self, name: str, platform: Platform) -> None:
        """``platform`` has a ``base_url`` and a ``model``; the configuration sees to that where it is used."""
        assert platform.base_url is not None
        assert platform.model is not None
        self._name = name
        self._model = platform.model
        self._url = f"{platform.base_url.rstrip('/')}/chat/completions"
        self._host = urlsplit(platform.base_url).hostname or ""
        self._timeout_s = platform.timeout_s
        self._key = SecretStr(platform.api_key.get_secret_value().strip()) if platform.api_key else SecretStr("")

    @property
    def name(self) -> str:
        return self._name

    async def reply(self, messages: Sequence[Message]) -> Reply:
        if not _SENDABLE.fullmatch(self._key.get_secret_value()):
            message = f"The key of the platform {self._name} has characters that no key has."
            raise KeyWanted(message, hint=f"Look at platforms.{self._name}.api_key, and at the variable it names.")
        request = {"model": self._model, "messages": [_as_sent(message) for message in messages]}
        try:
            async with asyncio.timeout(self._timeout_s):
                found = await self._asked(json.dumps(request).encode())
        except TimeoutError:
            found = TooSlow(
                f"The model of the platform {self._name} did not answer within {self._timeout_s:g} s.",
                hint=f"Give it longer with platforms.{self._name}.timeout_s, or take a faster model.",
            )
        if isinstance(found, ChatError):
            raise found  # here, where no exception is being handled whose request has the key in it
        return found

    async def _asked(self, body: bytes) -> Reply | ChatError:
        """The answer, or what is wrong; what may be better in a moment is tried twice."""
        client = await asyncio.to_thread(self._client)
        async with client:
            found = await self._attempt(client, body)
            if isinstance(found, Unreachable) or (isinstance(found, Refused) and _may_pass(found.status)):
                await asyncio.sleep(PAUSE_S)
                found = await self._attempt(client, body)
        return found

    def _client(self) -> httpx.AsyncClient:
        """Takes a while the first time: for a thread."""
        import httpx

        return httpx.AsyncClient(
            verify=_trusted(), timeout=self._timeout_s, trust_env=False, follow_redirects=False, auth=self._signed
        )

    def _signed(self, request: httpx.Request) -> httpx.Request:
        """The request with the key in it, at the last moment."""
        if self._key:
            request.headers["Authorization"] = f"Bearer {self._key.get_secret_value()}"
        return request

    async def _attempt(self, client: httpx.AsyncClient, body: bytes) -> Reply | ChatError:
        import httpx

        headers = {"Content-Type": "application/json", "Accept-Encoding": "identity"}
        received = bytearray()
        try:
            async with client.stream("POST", self._url, content=body, headers=headers) as response:
                async for chunk in response.aiter_bytes():
                    received += chunk
                    if len(received) > MAX_BYTES:
                        return self._unreadable(f"it is longer than {MAX_BYTES >> 20} MB")
        except (httpx.HTTPError, httpx.InvalidURL, OSError) as error:
            why = self._short(str(error)) or type(error).__name__
            return Unreachable(
                f"The platform {self._name} cannot be reached at {self._host}: {why.rstrip('.')}.",
                hint=f"Check the network, and platforms.{self._name}.base_url.",
            )
        if response.status_code != httpx.codes.OK:
            return self._refused(response.status_code, bytes(received))
        return self._read(bytes(received))

    def _read(self, body: bytes) -> Reply | ChatError:
        try:
            answer = _Completion.model_validate_json(body)
        except ValidationError:
            return self._unreadable("it is not what a chat completion looks like")
        if not answer.choices:
            if answer.error is not None:  # some services say so with status 200
                return self._refused(200, body)
            return self._unreadable("there is nothing in it")
        # Some services leave a model's thoughts in its answer.
        text = _THOUGHTS.sub("", answer.choices[0].message.text).strip()
        return Reply(self._blotted(text)) if text else self._unreadable("there is nothing in it")

    def _refused(self, status: int, body: bytes) -> ChatError:
        said = self._short(_complaint(body))
        message = f"The platform {self._name} refused with status {status}{f': {said}' if said else ''}"
        where = f"platforms.{self._name}"
        if status in (401, 403) and not self._key:
            hint = f"It wants a key: give it one with {where}.api_key: ${{VARIABLE}}, and set that variable."
            return KeyWanted(f"{message.rstrip('.')}.", hint=hint)
        hints = {
            401: f"Check the key: the variable that {where}.api_key names.",
            403: f"Check the key: the variable that {where}.api_key names, and what it may do.",
            404: f"Check {where}.base_url, and that there is a model called {self._model}.",
            429: "Wait a while, or look at the limits of your account.",
        }
        if 300 <= status < 400:
            hint = f"It sends one elsewhere, where sayso does not go: set {where}.base_url to the right address."
        elif status >= 500:
            hint = "Try again later."
        else:
            hint = hints.get(status, f"Check {where}.model: does it take pictures?")
        return Refused(f"{message.rstrip('.')}.", status, hint=hint)

    def _unreadable(self, why: str) -> Unreadable:
        return Unreadable(
            f"The answer of the platform {self._name} cannot be read: {why}.",
            hint=f"Check that platforms.{self._name}.base_url is that of an OpenAI-compatible service.",
        )

    def _short(self, text: str) -> str:
        """What a service said, fit to be shown: one line, without the key, not too long."""
        line = " ".join("".join(sign if sign.isprintable() else " " for sign in self._blotted(text)).split())
        return line if len(line) <= _TOLD else f"{line[: _TOLD - 1]}…"

    def _blotted(self, text: str) -> str:
        return text.replace(self._key.get_secret_value(), _MASK) if self._key else text


class _Part(BaseModel):
    text: str = ""


class _Said(BaseModel):
    content: str | list[_Part] | None = None

    @property
    def text(self) -> str:
        if isinstance(self.content, list):
            return "".join(part.text for part in self.content)
        return self.content or ""


class _Choice(BaseModel):
    message: _Said


class _Completion(BaseModel):
    """What is read of a chat completion."""

    choices: list[_Choice] = Field(default_factory=list)
    error: Any = None


@functools.cache
def _trusted() -> ssl.SSLContext:
    """The certificate authorities of the system, and those that come with the HTTP library."""
    import certifi

    context = ssl.create_default_context()
    context.load_verify_locations(certifi.where())
    return context


def _as_sent(message: Message) -> dict[str, Any]:
    if message.picture is None:
        return {"role": message.role, "content": message.text}
    url = f"data:{_media_type(message.picture)};base64,{base64.b64encode(message.picture).decode('ascii')}"
    picture = {"type": "image_url", "image_url": {"url": url}}
    return {"role": message.role, "content": [{"type": "text", "text": message.text}, picture]}


def _media_type(picture: bytes) -> str:
    if picture.startswith(_PNG):
        return "image/png"
    if picture.startswith(_JPEG):
        return "image/jpeg"
    raise ValueError("a picture is a PNG or a JPEG file")


def _may_pass(status: int) -> bool:
    """Whether a refusal may be over in a moment."""
    return status == 429 or status >= 500


def _complaint(body: bytes) -> str:
    """What a refusal says, in whichever of the usual ways; else the beginning of it as it stands."""
    text = body.decode("utf-8", "replace")
    try:
        told = json.loads(text)
    except (ValueError, RecursionError):
        return text
    for key in ("error", "message", "detail"):
        while isinstance(told, dict) and key in told:
            told = told[key]
    return told if isinstance(told, str) else text
