"""The model on this machine: llama.cpp in a process of its own, spoken to like any OpenAI-compatible service.

What it is told first (the rules, the skills, the house) takes seconds to read and stays the same, so it is read once
and kept: in one of the process's *slots* while it runs, and in the user's cache folder for the next start. Each
beginning has a slot of its own as long as there are enough. Cancelling a question pauses the process: silence at once.
"""

from __future__ import annotations

import asyncio
import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pydantic import SecretStr

from config.schema import Platform
from engine.llm.chat import Ask, Hear, Message, Reply, Unreachable, _deaf
from engine.llm.llama import LlamaProcess, NotRunning, Shape
from engine.llm.openai import OpenAIChat
from engine.llm.prompt_cache import PromptCache, rendered, shared

if TYPE_CHECKING:
    import httpx2

Told = Callable[[float], None]
"""Is given how much of a prompt has been read, 0…1."""

MOST_THREADS: Final = 4
"""More make generation no faster: memory is what it waits for."""
WORTH_SAVING: Final = 400
"""Characters of a prompt; fewer are read again in no time."""
_ALIKE: Final = 0.9  # of a beginning: the rest is a tail that varies, and the slot goes on with the new one
_AGAIN: Final = "Ask again: it is started anew. If it keeps happening, try a smaller model."
_COMPLETIONS: Final = "http://localhost/v1/chat/completions"
_ONCE: Final = {"Connection": "close"}  # llama.cpp closes a connection that is kept, perhaps just as it is used again
_LAYOUT: Final = "plain-attention"  # what llama.cpp saves looks otherwise with flash attention
_SPEAKS: Final = {"return_progress": True, "cache_prompt": True}
"""Fields of every question. Without news of its progress, llama.cpp notices a closed connection too late."""


@dataclass(slots=True)
class _Slot:
    """A conversation that the process keeps."""

    number: int
    chat: OpenAIChat
    text: str = ""  # the beginning that it has read
    used: int = 0  # when: counts up


def _untold(fraction: float) -> None:
    pass


class LocalChat:
    """One GGUF model. It is loaded when it is needed first, or by :meth:`load`; a lost one is replaced at the next
    question. Belongs to the loop, and to the thread, in which it is used first."""

    def __init__(self, name: str, platform: Platform, gguf: Path, cache: Path, *, slots: int = 2) -> None:
        """``gguf`` is the model's file, ``cache`` the folder of saved prompts; both need not exist yet. ``slots`` is
        how many beginnings are kept at a time."""
        self._name = name
        self._platform = platform
        self._shape = Shape(gguf, cache, platform.threads or _threads(), slots)
        self._cache: PromptCache | None = None  # known with the process; None: nothing can be kept
        self._process: LlamaProcess | None = None
        self._loading: asyncio.Task[None] | None = None
        self._slots: list[_Slot] = []
        self._beginnings: list[tuple[Message, ...]] = []  # that were prepared
        self._http: httpx2.AsyncClient | None = None  # for what is not a question
        self._turn = asyncio.Lock()  # one at a time: two would each take twice as long
        self._count = 0
        self._closed = False
        self.on_the_way = ""
        """What is being done about a file that is missing: "fetching 43 %"."""
        self.tell: Callable[[NotRunning | None], None] = lambda trouble: None
        """Is told when the model cannot be had or is lost, and with None when it has been loaded."""

    @property
    def name(self) -> str:
        return self._name

    @property
    def held(self) -> bool:
        return True

    @property
    def sees(self) -> bool:
        return self._platform.sees

    @property
    def model(self) -> str:
        """What it runs, in one word."""
        return self._platform.model or self._shape.gguf.stem

    @property
    def memory_mb(self) -> float:
        """What it needs while it runs, roughly. Raises ``OSError`` where its file is missing."""
        return self._shape.memory_mb

    @property
    def pid(self) -> int | None:
        """Of the model's process, if there is one."""
        return self._process.pid if self._process else None

    async def load(self) -> None:
        """Start the process and wait until the model is loaded. Raises :class:`NotRunning`."""
        async with self._turn:
            await self._ready()

    async def prepare(self, messages: Sequence[Message], tell: Told = _untold) -> None:
        """Read what questions will begin with, or restore it from the last time. Raises ``ChatError``."""
        beginning = tuple(messages)
        if beginning not in self._beginnings:
            self._beginnings.append(beginning)
        async with self._turn:
            process = await self._ready()
            with self._at_work(process):
                await self._read(process, beginning, tell)

    async def reply(self, ask: Ask, hear: Hear = _deaf) -> Reply:
        async with self._turn:
            process = await self._ready()
            with self._at_work(process):
                slot = await self._read(process, self._beginning(ask), _untold)
                try:
                    return await slot.chat.reply(ask, hear)
                except Unreachable as error:
                    raise await self._loss(process, error) from error

    async def close(self) -> None:
        """End the process at once; who waits for an answer gets an error."""
        self._closed = True
        if self._loading is not None:
            self._loading.cancel()
            await asyncio.wait([self._loading])
        if self._process is not None:
            self._process.kill()
        async with self._turn:  # whoever asks notices
            await self._bury()

    # The process

    async def _ready(self) -> LlamaProcess:
        """The process, with its model loaded. Raises :class:`NotRunning`."""
        if self._closed:
            raise NotRunning("The model has been closed.")
        if self._process is not None and self._process.epitaph() is not None:
            await self._bury()  # nobody was waiting for it, so nothing is lost but time
        if self._process is None:
            if self._loading is None or self._loading.done():
                self._loading = asyncio.create_task(self._told(), name="local model")
                self._loading.add_done_callback(lambda task: task.cancelled() or task.exception())
            await asyncio.shield(self._loading)  # whoever gives up waiting does not end it: the next one needs it, too
        if self._process is None:
            raise NotRunning("The model has been closed.")
        return self._process

    async def _told(self) -> None:
        """Load, and say how it went."""
        try:
            await self._load()
        except NotRunning as trouble:
            self.tell(trouble)
            raise
        self.tell(None)

    async def _load(self) -> None:
        shape, name = self._shape, self._platform.model
        remedy = f"Run: sayso models pull {name}"
        if shape.gguf.parent.name != name:
            remedy = f"Check platforms.{self._name}.model: it is the path of a GGUF file."
        if not shape.gguf.is_file():
            if self.on_the_way:
                message = f"The model is not here yet: {self.on_the_way}."
                raise NotRunning(message, hint="Plain commands work meanwhile.")
            raise NotRunning(f"The model {shape.gguf.name} is not there ({shape.gguf}).", hint=remedy)
        await asyncio.to_thread(self._open_cache)
        self._process = process = await LlamaProcess.start(shape, remedy)
        self._slots = [
            _Slot(
                number,
                OpenAIChat(
                    self._name,
                    self._platform,
                    kind="local",
                    uds=process.socket,
                    takes_grammar=True,
                    extra={**_SPEAKS, "id_slot": number},
                ),
            )
            for number in range(shape.slots)
        ]
        self._http = await asyncio.to_thread(_client, process.socket)

    def _open_cache(self) -> None:
        gguf, shape = self._shape.gguf.stat(), self._shape
        made_by = (gguf.st_size, gguf.st_mtime_ns, _library(), shape.context, _LAYOUT)
        cache = PromptCache(shape.states, made_by)
        try:
            cache.open()
        except OSError:
            self._cache = None
        else:
            self._cache = cache

    @contextmanager
    def _at_work(self, process: LlamaProcess) -> Iterator[None]:
        """Let the process work; a caller that leaves before the answer silences it."""
        process.resume()
        try:
            yield
        except BaseException:  # cancelled, or too slow
            process.pause()
            raise

    async def _loss(self, process: LlamaProcess, error: Unreachable) -> Unreachable | NotRunning:
        """What is wrong when nobody answers at the socket."""
        if self._closed:
            return NotRunning("The model has been closed.")
        died = await asyncio.to_thread(process.epitaph, wait=True)
        if died is None:
            return error
        if self._process is process:
            await self._bury()
        lost = NotRunning(died, hint=_AGAIN)
        self.tell(lost)
        return lost

    async def _bury(self) -> None:
        """Leave nothing of the process."""
        process, slots, http = self._process, self._slots, self._http
        self._process, self._slots, self._http = None, [], None
        if process is not None:
            process.kill()
        for slot in slots:
            await slot.chat.close()
        if http is not None:
            await http.aclose()

    # What it has read

    def _beginning(self, ask: Ask) -> tuple[Message, ...]:
        """What of a question others begin with, too: what was prepared, else the rules."""
        messages = ask.messages
        if ask.shared:
            return messages[: ask.shared]
        known = [made for made in self._beginnings if messages[: len(made)] == made]
        if known:
            return max(known, key=len)
        return messages[:1] if messages[0].role == "system" else ()

    async def _read(self, process: LlamaProcess, beginning: tuple[Message, ...], tell: Told) -> _Slot:
        """A slot that has read this beginning. Raises ``ChatError``."""
        text = rendered(beginning)
        slot = self._slot_for(text)
        self._count += 1
        slot.used = self._count
        if slot.text == text or not beginning:
            return slot
        known = shared(slot.text, text)
        if len(text) - known < WORTH_SAVING:  # read with the question
            slot.text = text
            return slot
        if self._cache is not None:
            saved = await asyncio.to_thread(self._cache.nearest, text)
            if saved is not None and (found := shared(saved.text, text)) > known + WORTH_SAVING:
                slot.text = ""  # whatever happens now
                if await self._slot_act(process, slot, "restore", saved.name):
                    slot.text, known = saved.text, found
                else:
                    self._cache.drop(saved.name)
                    known = 0
        unknown = len(text) - known
        if unknown < WORTH_SAVING or await self._compute(process, slot, beginning, tell):
            slot.text = text
        if slot.text and unknown >= WORTH_SAVING and self._cache is not None:
            await self._save(process, slot, self._cache)
        return slot

    def _slot_for(self, text: str) -> _Slot:
        """The slot that has this beginning, or nearly; else one that nobody needs."""
        alike = max(self._slots, key=lambda slot: shared(slot.text, text))
        if shared(alike.text, text) >= _ALIKE * len(text):
            return alike
        return min(self._slots, key=lambda slot: (bool(slot.text), slot.used))

    async def _compute(self, process: LlamaProcess, slot: _Slot, beginning: Sequence[Message], tell: Told) -> bool:
        """Have a beginning read, however long that takes; whether that could be done: it may be too long, and the
        question, which is longer, says so. Raises ``ChatError``."""
        import httpx2

        assert self._http is not None
        body = {
            "messages": [{"role": message.role, "content": message.text} for message in beginning],
            "max_tokens": 0,
            "stream": True,
            "id_slot": slot.number,
            **_SPEAKS,
        }
        slot.text = ""
        try:
            async with self._http.stream("POST", _COMPLETIONS, json=body, headers=_ONCE) as response:
                async for line in response.aiter_lines():
                    if response.is_success and (fraction := _progress(line)) is not None:
                        tell(fraction)
        except (httpx2.HTTPError, OSError) as error:
            lost = Unreachable(f"The model {self._name} broke off: {error}.", hint=_AGAIN)
            raise await self._loss(process, lost) from error
        return response.is_success

    async def _save(self, process: LlamaProcess, slot: _Slot, cache: PromptCache) -> None:
        """Keep what a slot has read for the next start, where there is room for it."""
        draft = cache.draft()
        try:
            if await self._slot_act(process, slot, "save", draft):
                await asyncio.to_thread(cache.keep, draft, slot.text)
        except OSError:  # no room: it will be read again
            pass
        finally:
            cache.drop(draft)

    async def _slot_act(self, process: LlamaProcess, slot: _Slot, action: str, file: str) -> bool:
        """Save or restore a slot; whether that went well. Raises ``ChatError`` when the process is lost."""
        import httpx2

        assert self._http is not None
        url = f"http://localhost/slots/{slot.number}?action={action}"
        try:
            response = await self._http.post(url, json={"filename": file}, headers=_ONCE)
        except (httpx2.HTTPError, OSError) as error:
            lost = Unreachable(f"The model {self._name} broke off: {error}.", hint=_AGAIN)
            raise await self._loss(process, lost) from error
        return response.is_success


def _threads() -> int:
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(cores, MOST_THREADS)


def _library() -> str:
    try:
        return version("xllamacpp")
    except PackageNotFoundError:
        return ""


def _client(socket: Path) -> httpx2.AsyncClient:
    """Takes a while the first time: for a thread."""
    from engine.llm.transport import make_client

    return make_client(SecretStr(""), socket)


def _progress(line: str) -> float | None:
    """How much of the prompt has been read, if this line of the stream tells it."""
    if not line.startswith("data: {"):
        return None
    try:
        told: Any = json.loads(line.removeprefix("data: ")).get("prompt_progress")
        return float(told["processed"]) / max(1.0, float(told["total"])) if told else None
    except (ValueError, KeyError, TypeError, AttributeError):
        return None
