"""A Dify application on loopback that takes nothing but what Dify's documentation allows.

The schemas are those of https://docs.dify.ai/api-reference: what is missing, superfluous or of the wrong type is a
protocol error, which the test is told of; a file belongs to the user who uploaded it, and a conversation to the one who
began it. Events come in the documented form, with pings between them.
"""

from __future__ import annotations

import asyncio
import uuid
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from email import message_from_bytes
from email.policy import HTTP
from typing import Any, Literal
from urllib.parse import unquote

from pydantic import BaseModel, ConfigDict, Field, SecretStr, ValidationError

from config.schema import Platform
from tests.model_service import DEADLINE_S, SECRET, STREAM, Answer, Unfinished, event, reply


class _Body(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class Attached(_Body):
    type: Literal["image", "document", "audio", "video", "custom"]
    transfer_method: Literal["remote_url", "local_file"]
    url: str | None = None
    upload_file_id: str | None = None


class ChatMessage(_Body):
    """The body of ``POST /chat-messages``."""

    inputs: dict[str, Any]
    query: str = Field(min_length=1)
    user: str = Field(min_length=1)
    response_mode: Literal["streaming", "blocking"] = "blocking"
    conversation_id: str = ""
    files: list[Attached] = []
    auto_generate_name: bool = True
    workflow_id: str | None = None
    trace_id: str | None = None


class Stop(_Body):
    """The body of ``POST /chat-messages/{task_id}/stop``."""

    user: str = Field(min_length=1)


@dataclass(frozen=True, slots=True)
class File:
    user: str
    name: str
    type: str
    data: bytes


@dataclass
class Dify:
    """What was asked, and what will be answered: one answer after the other, the last one again and again.

    An answer is the text of a reply in pieces, or any HTTP response."""

    answers: list[Answer | tuple[str, ...]]
    mode: Literal["chat", "agent-chat"] = "chat"
    secret: str = SECRET  # the application's key
    asked: list[ChatMessage] = field(default_factory=list)
    files: dict[str, File] = field(default_factory=dict)
    conversations: dict[str, str] = field(default_factory=dict)  # whose they are
    tasks: dict[str, str] = field(default_factory=dict)
    stopped: list[str] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)  # requests that Dify does not document
    on_request: Callable[[], None] = lambda: None
    left: asyncio.Event = field(default_factory=asyncio.Event)  # somebody hung up instead of waiting for the end
    told_to_stop: asyncio.Event = field(default_factory=asyncio.Event)
    port: int = 0

    def platform(self, **changes: Any) -> Platform:
        """How to reach it."""
        facts = {"kind": "dify", "base_url": f"http://127.0.0.1:{self.port}/v1", "api_key": SecretStr(self.secret)}
        return Platform(**{**facts, **changes})

    def begin(self, user: str, answer: str) -> bytes:
        """The beginning of a reply in a new conversation, for an answer that goes wrong then."""
        return self._says(self._task(user), self._conversation("", user), answer)

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            head = (await reader.readuntil(b"\r\n\r\n")).decode().split("\r\n")
            headers = {name.lower(): value for name, _, value in (line.partition(": ") for line in head[1:] if line)}
            body = await reader.readexactly(int(headers["content-length"]))
            method, path, _ = head[0].split(" ")
            try:
                answer = self._answer(method, path, headers, body)
            except ValidationError as error:
                answer = self._wrong(f"{path}: {error}")
            self.on_request()
            if isinstance(answer, Unfinished):
                await answer.last(reader, writer)
                self.left.set()
            else:
                writer.write(answer)
        except ConnectionError:
            self.left.set()
        writer.close()

    def _answer(self, method: str, path: str, headers: dict[str, str], body: bytes) -> Answer:
        if headers.get("authorization") != f"Bearer {self.secret}":
            return self._no(401, "unauthorized", "Access token is invalid")
        if method != "POST":
            return self._wrong(f"{method} {path}")
        match unquote(path).removeprefix("/v1/").split("/"):
            case ["files", "upload"]:
                return self._upload(headers["content-type"], body)
            case ["chat-messages", task, "stop"]:
                if self.tasks.get(task) == Stop.model_validate_json(body).user:  # else nothing happens, documented so
                    self.stopped.append(task)
                    self.told_to_stop.set()
                return reply(200, {"result": "success"})
            case ["chat-messages"]:
                return self._chat(headers["content-type"], body)
        return self._wrong(f"POST {path}")

    def _chat(self, content_type: str, body: bytes) -> Answer:
        if content_type != "application/json":
            return self._wrong(f"a message as {content_type}")
        message = ChatMessage.model_validate_json(body)
        for file in message.files:
            known = self.files.get(file.upload_file_id or "")
            if file.transfer_method != "local_file" or known is None or known.user != message.user:
                return self._wrong(f"no file {file.upload_file_id} of this user")
        if message.response_mode != "streaming":
            return self._wrong("this application streams")
        self.asked.append(message)
        told = self.answers[min(len(self.asked), len(self.answers)) - 1]
        if not isinstance(told, tuple):
            return told
        if message.conversation_id:
            uuid.UUID(message.conversation_id)
            if self.conversations.get(message.conversation_id) != message.user:
                return self._no(404, "not_found", "Conversation Not Exists.")
        task, conversation = self._task(message.user), self._conversation(message.conversation_id, message.user)
        return self._says(task, conversation, *told) + self._ends(task, conversation)

    def _task(self, user: str) -> str:
        task = f"task-{len(self.tasks)}"
        self.tasks[task] = user
        return task

    def _conversation(self, number: str, user: str) -> str:
        number = number or str(uuid.uuid4())
        self.conversations[number] = user
        return number

    def _says(self, task: str, conversation: str, *pieces: str) -> bytes:
        kind = "message" if self.mode == "chat" else "agent_message"
        thought = self._event("agent_thought", task, conversation, thought="Hm.", position=1)
        said = [self._event(kind, task, conversation, answer=piece) for piece in pieces]
        return STREAM + b"event: ping\n\n".join([b"", *([] if self.mode == "chat" else [thought]), *said])

    def _ends(self, task: str, conversation: str) -> bytes:
        usage = {"prompt_tokens": 90, "completion_tokens": 7, "total_tokens": 97, "total_price": "0.1", "latency": 1.5}
        metadata = {"usage": usage, "retriever_resources": []}
        end = self._event("message_end", task, conversation, metadata=metadata)
        return end + self._event("tts_message_end", task, conversation, audio="")

    def _event(self, kind: str, task: str, conversation: str, **more: Any) -> bytes:
        facts = {"event": kind, "task_id": task, "message_id": str(uuid.uuid4()), "conversation_id": conversation}
        return event({**facts, "created_at": 1705407629, **more})

    def _upload(self, content_type: str, body: bytes) -> bytes:
        """``multipart/form-data`` with one file and the user's name."""
        form = message_from_bytes(b"Content-Type: " + content_type.encode() + b"\r\n\r\n" + body, policy=HTTP)
        if form.get_content_type() != "multipart/form-data":
            return self._wrong(f"an upload as {content_type}")
        parts = {part.get_param("name", header="content-disposition"): part for part in form.iter_parts()}
        if parts.keys() != {"file", "user"}:
            return self._wrong(f"an upload with {', '.join(map(str, parts))}")
        data = parts["file"].get_payload(decode=True)
        name, kind = str(parts["file"].get_filename()), parts["file"].get_content_type()
        if kind not in {"image/png", "image/jpeg"} or not name.endswith(kind.partition("/")[2]):
            return self._no(415, "unsupported_file_type", "File type not allowed.")
        number = str(uuid.uuid4())
        assert isinstance(data, bytes)
        self.files[number] = File(parts["user"].get_content().strip(), name, kind, data)
        return reply(201, {"id": number, "name": name, "size": len(data), "extension": "png", "mime_type": kind})

    def _wrong(self, what: str) -> bytes:
        self.wrong.append(what)
        return self._no(400, "invalid_param", what)

    def _no(self, status: int, code: str, message: str) -> bytes:
        return reply(status, {"status": status, "code": code, "message": message})


@asynccontextmanager
async def dify(*answers: Answer | tuple[str, ...], **facts: Any) -> AsyncIterator[Dify]:
    """An application that gives these answers, for as long as this is entered. It fails the test in the end when it was
    asked for anything that Dify does not document."""
    service = Dify(list(answers), **facts)
    server = await asyncio.start_server(service.serve, "127.0.0.1", 0)
    service.port = server.sockets[0].getsockname()[1]
    async with server:
        async with asyncio.timeout(DEADLINE_S):
            yield service
    assert service.wrong == []
