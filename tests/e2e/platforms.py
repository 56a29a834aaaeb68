"""Large-model platforms on loopback, served by a thread of the test while sayso, in a process of its own, asks them.

A test says what a platform answers from now on, and reads what it was asked. Each has a key of its own and answers
nobody who comes with another one. Both protocols are those of ``tests.model_service`` and ``tests.dify_service``.
"""

from __future__ import annotations

import asyncio
import json
import queue
import threading
from collections.abc import Coroutine, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import yaml

from tests.dify_service import Dify
from tests.model_service import DEADLINE_S, STREAM, Service, Unfinished, event, streamed

Protocol = Literal["openai", "dify"]
START_LIMIT_S = 60


class Platform:
    """One model behind one address; made in the loop of its thread."""

    def __init__(self, protocol: Protocol, name: str, timeout_s: float) -> None:
        self.name = name
        self.key = f"sk-{name}-nobody-may-read-this"
        self._protocol = protocol
        self._timeout_s = timeout_s
        self._service: Service | Dify = Service([]) if protocol == "openai" else Dify([], secret=self.key)
        self._questions: queue.SimpleQueue[None] = queue.SimpleQueue()
        self._service.on_request = lambda: self._questions.put(None)
        self._loop = asyncio.get_running_loop()

    async def serve(self) -> None:
        self._server = await asyncio.start_server(self._service.serve, "127.0.0.1", 0)
        self._service.port = self._server.sockets[0].getsockname()[1]

    # In the thread of the test

    def answers(self, *answers: object) -> None:
        """Answer the next questions with these, the last one again and again, and forget what was asked before. What
        is no response is put into a good one: a text as it stands, everything else as JSON."""
        self._in_loop(self._begin([self._as_answer(answer) for answer in answers]))

    @property
    def asked(self) -> list[str]:
        """The newest message of each question."""
        if isinstance(self._service, Dify):
            assert self._service.wrong == [], "Dify documents nothing of the kind"
            return [message.query for message in self._service.asked]
        assert {request.headers["authorization"] for request in self._service.asked} <= {f"Bearer {self.key}"}
        return [request.body["messages"][-1]["content"] for request in self._service.asked]

    @property
    def everything(self) -> list[str]:
        """All that each question says, older messages included."""
        if isinstance(self._service, Dify):
            return [message.model_dump_json() for message in self._service.asked]
        return [json.dumps(request.body, ensure_ascii=False) for request in self._service.asked]

    @property
    def conversations(self) -> list[str]:
        """The conversation that each question belongs to, as Dify names it; empty for a new one."""
        assert isinstance(self._service, Dify)
        return [message.conversation_id for message in self._service.asked]

    def until_asked(self) -> None:
        """Wait for a question that has not been waited for; who asks it may have to be started first."""
        self._questions.get(timeout=START_LIMIT_S)

    def until_left(self) -> None:
        """Wait until somebody hangs up instead of waiting for the answer."""
        self._in_loop(self._service.left.wait())

    def until_told_to_stop(self) -> None:
        """Wait until somebody says that the answer is not wanted any more."""
        assert isinstance(self._service, Dify)
        self._in_loop(self._service.told_to_stop.wait())

    def breaks_off(self, text: str) -> bytes:
        """A response that ends in the middle of ``text``."""
        return streamed(text, end=None) if self._protocol == "openai" else self._half(text)

    def drips(self, text: str) -> Unfinished:
        """A response that stays alive and never gets further than ``text``."""
        begun = streamed(text, end=None) if self._protocol == "openai" else self._half(text)
        return Unfinished(begun, drip=b": still here\n\n" if self._protocol == "openai" else b"event: ping\n\n")

    def _half(self, text: str) -> bytes:
        facts = {"task_id": "task-of-nobody", "message_id": "m", "conversation_id": "", "created_at": 1705407629}
        if isinstance(self._service, Dify):
            self._service.tasks["task-of-nobody"] = "sayso"
        return STREAM + event({"event": "message", "answer": text, **facts})

    def settings(self) -> dict[str, object]:
        """Its entry in a configuration; the key is in the environment."""
        facts = {"kind": self._protocol, "base_url": f"http://127.0.0.1:{self._service.port}/v1"}
        model = {"model": "a-model"} if self._protocol == "openai" else {}
        return {**facts, **model, "api_key": f"${{{self._variable}}}", "timeout_s": self._timeout_s}

    def environ(self) -> dict[str, str]:
        return {self._variable: self.key}

    @property
    def _variable(self) -> str:
        return f"KEY_OF_{self.name.upper()}"

    def _as_answer(self, answer: object) -> Any:
        if isinstance(answer, (bytes, Unfinished)):
            return answer
        text = answer if isinstance(answer, str) else json.dumps(answer)
        halves = (text[: len(text) // 2], text[len(text) // 2 :])
        return streamed(*halves) if self._protocol == "openai" else halves

    async def _begin(self, answers: list[Any]) -> None:
        self._service.answers = answers
        self._service.asked = []
        self._service.left.clear()
        while not self._questions.empty():
            self._questions.get()

    def _in_loop(self, work: Coroutine[Any, Any, object]) -> None:
        asyncio.run_coroutine_threadsafe(work, self._loop).result(DEADLINE_S)


@contextmanager
def platforms(protocol: Protocol, **timeouts_s: float) -> Iterator[list[Platform]]:
    """One platform of each name, for as long as this is entered."""
    made: queue.SimpleQueue[list[Platform]] = queue.SimpleQueue()
    end: queue.SimpleQueue[tuple[asyncio.AbstractEventLoop, asyncio.Event]] = queue.SimpleQueue()

    async def serve() -> None:
        over = asyncio.Event()
        end.put((asyncio.get_running_loop(), over))
        served = [Platform(protocol, name, timeout_s) for name, timeout_s in timeouts_s.items()]
        for platform in served:
            await platform.serve()
        made.put(served)
        await over.wait()

    thread = threading.Thread(target=lambda: asyncio.run(serve()), name="platforms")
    thread.start()
    loop, over = end.get(timeout=DEADLINE_S)
    try:
        yield made.get(timeout=DEADLINE_S)
    finally:
        loop.call_soon_threadsafe(over.set)
        thread.join()


def configuration(
    folder: Path, *, decision: Sequence[Platform] = (), execution: Sequence[Platform]
) -> tuple[str, str, dict[str, str]]:
    """The options and the environment with which sayso thinks with these platforms."""
    named = {platform.name: platform for platform in (*decision, *execution)}
    profile = {"decision": [p.name for p in decision], "execution": [p.name for p in execution]}
    told = {
        "profiles": {"loopback": profile},
        "platforms": {name: platform.settings() for name, platform in named.items()},
    }
    file = folder / "loopback.yaml"
    file.write_text(yaml.safe_dump(told), encoding="utf-8")
    environ = {
        "SAYSO_PLANNER__PROFILE": "loopback",
        "SAYSO_PLANNER__READER": "false",  # the platforms are to be asked
        "SAYSO_ROBOT__SPEED": "max",
        "SAYSO_CACHE_DIR": str(folder / "cache"),
    }
    for platform in named.values():
        environ |= platform.environ()
    return "--config", str(file), environ
