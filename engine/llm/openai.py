"""Any service that speaks OpenAI's chat completions: OpenAI itself, OpenRouter, DashScope, Ollama, vLLM, llama.cpp.

``POST {base_url}/chat/completions`` (https://platform.openai.com/docs/api-reference/chat), streamed, with the official
client; pictures are data URLs. Services differ in what they take: where one refuses a question for one of its wishes (a
form of the answer, a seed, …), it is asked again without that one, and is spared it from then on.
"""

from __future__ import annotations

import asyncio
import base64
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from config.schema import Platform
from engine.llm.chat import Ask, Hear, Message, Refused, Reply, _deaf
from engine.llm.service import Failure, Service, Tokens, media_type
from engine.llm.streamed import Streamed

if TYPE_CHECKING:
    from openai import AsyncOpenAI

_WISHES: Final = ("response_format", "grammar", "seed", "temperature", "stream_options", "max_tokens")
"""What an answer can do without. Newer models of OpenAI call the last one max_completion_tokens, and take no other."""
_UNKNOWN_WISH: Final = frozenset((400, 422, 501))
_NO_TEXT: Final = "there is half a character in it"
_OURS: Final = frozenset(("grammar",))
"""Fields that are no part of OpenAI's protocol."""


class OpenAIChat:
    """One model of one platform. Belongs to the loop in which it is asked first."""

    def __init__(
        self,
        name: str,
        platform: Platform,
        *,
        kind: Literal["openai", "local"] = "openai",
        uds: Path | None = None,
        takes_grammar: bool = False,
        extra: Mapping[str, Any] | None = None,
    ) -> None:
        """``platform`` has a ``model``, and a ``base_url`` where there is no ``uds``; the configuration sees to that
        where it is used. ``takes_grammar``: it is llama.cpp; ``extra`` are further fields of each question."""
        assert platform.model is not None
        assert platform.base_url is not None or uds is not None
        remedy = f"Check platforms.{name}.model: does it take pictures, and so long a question?"
        self._service = Service(name, platform, "an OpenAI-compatible service", remedy, uds)
        self._model = platform.model
        self._kind = kind
        self._takes_grammar = takes_grammar or platform.grammar
        self._sees = platform.sees
        self._extra = dict(extra or {})
        self._refused: set[str] = set()  # wishes that the service does not take
        self._client: AsyncOpenAI | None = None

    @property
    def name(self) -> str:
        return self._service.name

    @property
    def model(self) -> str:
        return self._model

    @property
    def held(self) -> bool:
        return self._takes_grammar

    @property
    def sees(self) -> bool:
        return self._sees

    async def reply(self, ask: Ask, hear: Hear = _deaf) -> Reply:
        messages = [_as_sent(message) for message in ask.messages]
        return await self._service.ask(lambda: self._asked(ask, messages, hear))

    async def close(self) -> None:
        self._client = None
        await self._service.close()

    async def _asked(self, ask: Ask, messages: list[Any], hear: Hear) -> Reply | Failure:
        """The answer, with as many wishes as the service takes."""
        without = set(self._refused)
        while True:
            body = self._body(ask, messages, without)
            found = await self._attempt(body, hear)
            if isinstance(found, Reply):
                self._refused = without
                return found
            wish = _refused_wish(found, body)
            if wish is None:
                return found
            without.add(wish)

    def _body(self, ask: Ask, messages: list[Any], without: set[str]) -> dict[str, Any]:
        limit = "max_completion_tokens" if "max_tokens" in without else "max_tokens"
        body: dict[str, Any] = {"model": self._model, "messages": messages, limit: ask.max_tokens}
        body |= {"temperature": ask.temperature, "seed": ask.seed, "stream_options": {"include_usage": True}}
        if ask.grammar is not None and self._takes_grammar:
            body["grammar"] = ask.grammar
        elif ask.schema is not None:
            schema = {"name": "answer", "schema": dict(ask.schema), "strict": True}
            body["response_format"] = {"type": "json_schema", "json_schema": schema}
        return {key: value for key, value in body.items() if key not in without}

    async def _attempt(self, body: dict[str, Any], hear: Hear) -> Reply | Failure:
        client = await self._ready()
        import httpx2
        import openai

        extra = {key: value for key, value in body.items() if key in _OURS} | self._extra
        known = {key: value for key, value in body.items() if key not in _OURS}
        streamed = Streamed(hear, self._service.secret)
        try:
            stream: Any = await client.chat.completions.create(**known, stream=True, extra_body=extra or None)
            async with stream:
                if "event-stream" not in stream.response.headers.get("content-type", ""):
                    return self._read(await stream.response.aread(), streamed)
                return await self._listen(stream, streamed)
        except openai.APIStatusError as error:
            response = error.response
            return self._service.refused(error.status_code, response.content, response.headers)
        except (openai.APIConnectionError, httpx2.HTTPError, httpx2.InvalidURL, OSError) as error:
            return self._service.broken(error, streamed.begun)
        except openai.APIError as error:  # some services say so in the midst of an answer
            return self._service.refused(_status(error), _said(error), {}, streamed.begun)

    async def _listen(self, stream: Any, streamed: Streamed) -> Reply | Failure:
        usage, end = _Usage(), None
        while True:
            try:
                chunk = _Completion.model_validate(await anext(stream), from_attributes=True)
            except StopAsyncIteration:
                break
            except (ValueError, RecursionError):  # pydantic's own error is one of them
                return Failure(self._service.unreadable("it is not what a chat completion looks like"))
            if chunk.usage is not None:
                usage = chunk.usage
            for choice in chunk.choices[:1]:
                end = choice.finish_reason or end
                try:
                    streamed.add(choice.delta.text)
                except ValueError:
                    return Failure(self._service.unreadable(_NO_TEXT))
        if end is None:
            if not streamed.begun:
                return Failure(self._service.unreadable("there is nothing in it"))
            return self._service.broken(ConnectionError("it ends without an end"), begun=True)
        return self._reply(streamed, usage, end)

    def _read(self, body: bytes, streamed: Streamed) -> Reply | Failure:
        """An answer in one piece, of a service that does not stream."""
        try:
            answer = _Completion.model_validate_json(body)
        except ValidationError:
            return Failure(self._service.unreadable("it is not what a chat completion looks like"))
        if not answer.choices and answer.error is not None:  # some services say so with status 200
            return self._service.refused(200, body, {})
        for choice in answer.choices[:1]:
            streamed.add(choice.message.text)
        end = answer.choices[0].finish_reason if answer.choices else None
        return self._reply(streamed, answer.usage or _Usage(), end or "stop")

    def _reply(self, streamed: Streamed, usage: _Usage, end: str) -> Reply | Failure:
        try:
            text = streamed.whole()
        except ValueError:
            return Failure(self._service.unreadable(_NO_TEXT))
        if not text:
            why = "it was cut off before it began; give it more tokens" if end == "length" else "there is nothing in it"
            return Failure(self._service.unreadable(why))
        cached = usage.prompt_tokens_details.cached_tokens if usage.prompt_tokens_details else None
        tokens = (usage.prompt_tokens or 0, cached or 0, usage.completion_tokens or 0)
        return Reply(text, self.name, self._kind, *tokens, cut_off=end == "length")

    async def _ready(self) -> AsyncOpenAI:
        if self._client is None:
            http = await self._service.client()
            self._client = await asyncio.to_thread(self._made, http)
        return self._client

    def _made(self, http: Any) -> AsyncOpenAI:
        """Takes a while the first time: for a thread."""
        from openai import AsyncOpenAI

        # The key is put in further below; everything else is given lest it be taken from the environment.
        url = self._service.base_url
        client = AsyncOpenAI(
            api_key="-", admin_api_key="-", base_url=url, timeout=None, max_retries=0, http_client=http
        )
        assert client.chat.completions  # imported now, not when somebody waits for an answer
        return client


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
    message: _Said = _Said()
    delta: _Said = _Said()
    finish_reason: str | None = None


class _Details(BaseModel):
    cached_tokens: Tokens | None = None


class _Usage(BaseModel):
    prompt_tokens: Tokens | None = None
    completion_tokens: Tokens | None = None
    prompt_tokens_details: _Details | None = None


class _Completion(BaseModel):
    """What is read of a chat completion, or of a piece of one."""

    model_config = ConfigDict(from_attributes=True)
    choices: list[_Choice] = Field(default_factory=list)
    usage: _Usage | None = None
    error: Any = None


def _as_sent(message: Message) -> dict[str, Any]:
    if message.picture is None:
        return {"role": message.role, "content": message.text}
    url = f"data:{media_type(message.picture)};base64,{base64.b64encode(message.picture).decode('ascii')}"
    picture = {"type": "image_url", "image_url": {"url": url}}
    return {"role": message.role, "content": [{"type": "text", "text": message.text}, picture]}


def _refused_wish(failure: Failure, body: Mapping[str, Any]) -> str | None:
    """The wish that a question was refused for: one that the refusal names, else the form of the answer."""
    error = failure.error
    if not isinstance(error, Refused) or error.status not in _UNKNOWN_WISH:
        return None
    named = (wish for wish in _WISHES if wish in body and wish in failure.said)
    return next(named, "response_format" if "response_format" in body else None)


def _status(error: Any) -> int:
    """The status that a service gives an error in the midst of an answer, where it gives one."""
    code = str(error.body.get("code")) if isinstance(error.body, dict) else ""
    return int(code) if len(code) == 3 and code.isdecimal() and 400 <= int(code) < 600 else 200


def _said(error: Any) -> bytes:
    return str(error.message).encode("utf-8", "replace")
