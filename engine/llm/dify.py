"""A chat application in Dify (https://docs.dify.ai/api-reference/chats/send-chat-message), streamed.

What the application's model is told to be goes into the application's variable ``instructions``: a paragraph that its
prompt contains as ``{{instructions}}``. Pictures are uploaded first. Dify keeps a conversation itself and is sent only
what was said since; where it does not know the conversation any more, or another model went on with it meanwhile, it is
told what it missed. It cannot be held to a form, and its model's settings are those of the application.
"""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from contextlib import aclosing, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import quote

from pydantic import BaseModel, ValidationError

from config.schema import Platform
from engine.llm.chat import Ask, Hear, Message, Reply, _deaf
from engine.llm.service import Failure, Service, Tokens, media_type
from engine.llm.sse import events
from engine.llm.streamed import Streamed

if TYPE_CHECKING:
    import httpx2

USER: Final = "sayso"
"""To whom conversations and files belong. Dify wants a name; it need not be a person's."""
CONVERSATIONS: Final = 32
"""As many are remembered, the latest ones."""
STOP_S: Final = 2.0
"""Longest that telling Dify to stop may take, s."""
_GONE: Final = frozenset(("not_found", "conversation_completed"))


@dataclass(frozen=True, slots=True)
class _Talk:
    """A conversation that Dify keeps."""

    number: str  # its identity there
    instructions: str  # as Dify was told them last
    answers: int  # that had been given when the last question was put


@dataclass(frozen=True, slots=True)
class _Question:
    """What is sent."""

    number: str  # of the conversation that it belongs to; empty for a new one
    instructions: str
    query: str
    pictures: tuple[bytes, ...]
    answers: int


class DifyChat:
    """One application. Belongs to the loop in which it is asked first."""

    def __init__(self, name: str, platform: Platform) -> None:
        """``platform`` has a ``base_url``; the configuration sees to that where it is used."""
        assert platform.base_url is not None
        remedy = (
            "Look at the application in Dify: its variable `instructions`, its model, and whether it takes pictures."
        )
        self._service = Service(name, platform, "the API of Dify", remedy)
        self._sees = platform.sees
        self._talks: dict[str, _Talk] = {}
        self._stops: set[asyncio.Task[None]] = set()

    @property
    def name(self) -> str:
        return self._service.name

    @property
    def model(self) -> str:
        return ""  # that of the application

    @property
    def held(self) -> bool:
        return False

    @property
    def sees(self) -> bool:
        return self._sees

    async def reply(self, ask: Ask, hear: Hear = _deaf) -> Reply:
        for message in ask.messages:
            if message.picture is not None:
                media_type(message.picture)  # before anything is sent
        return await self._service.ask(lambda: self._asked(ask, hear))

    async def close(self) -> None:
        if self._stops:
            await asyncio.wait(self._stops, timeout=STOP_S)
        await self._service.close()

    async def _asked(self, ask: Ask, hear: Hear) -> Reply | Failure:
        talk = self._talks.get(ask.conversation) if ask.conversation else None
        found = await self._attempt(ask, _question(ask, talk), hear)
        if isinstance(found, Failure) and found.code in _GONE and talk is not None:
            self._talks.pop(ask.conversation, None)
            found = await self._attempt(ask, _question(ask, None), hear)
        return found

    async def _attempt(self, ask: Ask, question: _Question, hear: Hear) -> Reply | Failure:
        client = await self._service.client()
        import httpx2

        answer = _Answer(Streamed(hear, self._service.secret))
        body: dict[str, Any] = {"query": question.query, "inputs": {"instructions": question.instructions}}
        body |= {"user": USER, "response_mode": "streaming", "conversation_id": question.number}
        try:
            for picture in question.pictures:
                file = await self._uploaded(client, picture)
                if isinstance(file, Failure):
                    return file
                named = {"type": "image", "transfer_method": "local_file", "upload_file_id": file}
                body.setdefault("files", []).append(named)
            async with client.stream("POST", f"{self._service.base_url}/chat-messages", json=body) as response:
                if response.status_code != httpx2.codes.OK:
                    return self._service.refused(response.status_code, await response.aread(), response.headers)
                found = await self._listen(response, answer)
        except (httpx2.HTTPError, httpx2.InvalidURL, OSError) as error:
            return self._service.broken(error, answer.streamed.begun)
        finally:
            if answer.task and not answer.ended:  # whoever went away in the middle has closed the connection by now
                self._stop(client, answer.task)
        if isinstance(found, Reply) and ask.conversation and answer.conversation:
            self._remember(ask.conversation, _Talk(answer.conversation, question.instructions, question.answers))
        return found

    def _remember(self, conversation: str, talk: _Talk) -> None:
        self._talks.pop(conversation, None)  # the latest ones stand last
        self._talks[conversation] = talk
        if len(self._talks) > CONVERSATIONS:
            del self._talks[next(iter(self._talks))]

    async def _listen(self, response: httpx2.Response, answer: _Answer) -> Reply | Failure:
        async with aclosing(events(response.aiter_bytes())) as told:
            while True:
                try:
                    data = await anext(told)
                    event = _Event.model_validate_json(data)
                except StopAsyncIteration:
                    break
                except ValueError:  # pydantic's own error is one of them
                    return Failure(self._service.unreadable("it is not what Dify sends"))
                answer.take(event)
                if event.event == "error":
                    return self._service.refused(event.status, data.encode(), {}, answer.streamed.begun)
                if answer.ended:
                    return self._reply(answer)
        if answer.task:
            return self._service.broken(ConnectionError("it ends without an end"), begun=True)
        return Failure(self._service.unreadable("there is nothing in it"))

    def _reply(self, answer: _Answer) -> Reply | Failure:
        text = answer.streamed.whole()
        if not text:
            return Failure(self._service.unreadable("there is nothing in it"))
        usage = answer.usage
        return Reply(text, self.name, "dify", usage.prompt_tokens, reply_tokens=usage.completion_tokens)

    async def _uploaded(self, client: httpx2.AsyncClient, picture: bytes) -> str | Failure:
        """The name under which Dify knows a picture. Raises what the HTTP library raises."""
        kind = media_type(picture)
        file = (f"picture.{kind.partition('/')[2]}", picture, kind)
        url = f"{self._service.base_url}/files/upload"
        response = await client.post(url, data={"user": USER}, files={"file": file})
        if not 200 <= response.status_code < 300:
            return self._service.refused(response.status_code, response.content, response.headers)
        try:
            return _File.model_validate_json(response.content).id
        except ValidationError:
            return Failure(self._service.unreadable("it is not what Dify sends for a file"))

    def _stop(self, client: httpx2.AsyncClient, task: str) -> None:
        """Tell Dify that nobody listens any more, without keeping anybody waiting for it."""
        stop = asyncio.get_running_loop().create_task(self._stopped(client, task))
        self._stops.add(stop)
        stop.add_done_callback(self._stops.discard)

    async def _stopped(self, client: httpx2.AsyncClient, task: str) -> None:

        url = f"{self._service.base_url}/chat-messages/{quote(task, safe='')}/stop"
        with suppress(Exception):  # it ends by itself, only later
            async with asyncio.timeout(STOP_S):
                await client.post(url, json={"user": USER})


class _Answer:
    """What has come of an answer."""

    def __init__(self, streamed: Streamed) -> None:
        self.streamed = streamed
        self.task = ""
        self.conversation = ""
        self.usage = _Usage()
        self.ended = False

    def take(self, event: _Event) -> None:
        self.task = event.task_id or self.task
        self.conversation = event.conversation_id or self.conversation
        match event.event:
            case "message" | "agent_message":
                self.streamed.add(event.answer)
            case "message_replace":  # a moderator does not like it
                self.streamed.replace(event.answer)
            case "message_end":
                self.usage = event.metadata.usage or self.usage
                self.ended = True
            case "error":
                self.ended = True


class _Usage(BaseModel):
    prompt_tokens: Tokens = 0
    completion_tokens: Tokens = 0


class _Metadata(BaseModel):
    usage: _Usage | None = None


class _Event(BaseModel):
    """What is read of an event."""

    event: str
    task_id: str = ""
    conversation_id: str = ""
    answer: str = ""
    metadata: _Metadata = _Metadata()
    status: int = 200


class _File(BaseModel):
    """What is read of the answer to an upload."""

    id: str


def _question(ask: Ask, talk: _Talk | None) -> _Question:
    """What Dify was not told yet, where it knows the conversation; else all."""
    head, said = ask.messages[: ask.shared], ask.messages[ask.shared :]
    told = [*head, *(message for message in said if message.role == "system")]
    instructions = _written(told)
    said = tuple(message for message in said if message.role != "system")
    ends = [index for index, message in enumerate(said, 1) if message.role == "assistant"]
    news = said
    if talk is not None and ends:
        own = min(talk.answers, len(ends) - 1)  # where its own last answer stands: histories are cut at their beginning
        news = said[ends[own] :]
    query = news[0].text if len(news) == 1 else _written(news)
    if talk is not None and talk.instructions != instructions:  # a conversation keeps the variables that it began with
        query = f"{instructions}\n\n{query}"
    pictures = tuple(message.picture for message in news if message.picture is not None)
    return _Question(talk.number if talk else "", instructions, query, pictures, len(ends))


def _written(messages: Sequence[Message]) -> str:
    """Messages as one text, in which everybody but the system has a name."""
    texts = (m.text if m.role == "system" else f"{m.role}: {m.text}" for m in messages)
    return "\n\n".join(texts)
