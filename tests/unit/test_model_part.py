"""The large model as a part of the engine comes by itself, says how far it is, and harms nobody when it does not."""

from __future__ import annotations

import asyncio
import contextlib
import fcntl
import hashlib
import threading
from collections.abc import AsyncIterator, Callable, Iterator, Sequence
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
import yaml

from config import load
from config.schema import Platform
from engine.errors import SaysoError
from engine.handle import PartStatus
from engine.llm.chat import Ask, Message
from engine.llm.llama import NotRunning
from engine.llm.local import LocalChat
from engine.models import Manifest, ModelStore
from engine.parts import fetching
from engine.parts import model as model_part
from engine.parts.fetching import Fetching
from engine.parts.loading import gguf_of, model_store
from engine.parts.model import ModelPart
from engine.parts.part import Part

LIMIT_S = 60.0
"""s for what takes a moment; a test that waits longer has failed."""
WEIGHTS = bytes(range(256)) * 8192  # 2 MB that are no model
RULES = [Message("system", "You command a robot. " + "Never go upstairs. " * 30)]


class SlowServer(ThreadingHTTPServer):
    """Serves the weights: a half at once, the rest when it is let go on."""

    daemon_threads = True

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.go_on = threading.Event()


class _Handler(BaseHTTPRequestHandler):
    server: SlowServer

    def do_GET(self) -> None:
        self.send_response(200)
        self.send_header("Content-Length", str(len(WEIGHTS)))
        self.end_headers()
        middle = len(WEIGHTS) // 2
        with contextlib.suppress(ConnectionError):
            self.wfile.write(WEIGHTS[:middle])
            self.server.go_on.wait(LIMIT_S)
            self.wfile.write(WEIGHTS[middle:])

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture
def server() -> Iterator[SlowServer]:
    with SlowServer() as running:
        thread = threading.Thread(target=running.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        yield running
        running.go_on.set()
        running.shutdown()
        thread.join()


@pytest.fixture(autouse=True)
def _news_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(model_part, "NEWS_S", 0.0)
    monkeypatch.setattr(fetching, "NEWS_S", 0.0)


@pytest.fixture
def make_store(tmp_path: Path) -> Callable[..., ModelStore]:
    def make(source: object, size: int = len(WEIGHTS)) -> ModelStore:
        digest = hashlib.sha256(WEIGHTS).hexdigest()
        file = {"name": "weights.gguf", "size": size, "sha256": digest, "sources": [source]}
        model = {"kind": "llm", "description": "tiny", "licence": "MIT", "memory_mb": 1, "files": [file]}
        path = tmp_path / "models.yaml"
        path.write_text(yaml.safe_dump({"models": {"thinker": model}}))
        (tmp_path / "weights.gguf").write_bytes(WEIGHTS)
        return ModelStore(tmp_path / "models", Manifest.load(path))

    return make


class Kept:
    """A part that is being kept, and what it says."""

    def __init__(self, part: Part[str], chat: LocalChat, reports: list[PartStatus]) -> None:
        self.part = part
        self.chat = chat
        self.reports = reports

    async def says(self, beginning: str) -> str:
        """Wait for the status to say something."""
        async with asyncio.timeout(LIMIT_S):
            while not self.part.status.detail.startswith(beginning):  # noqa: ASYNC110 - nobody is told of progress
                await asyncio.sleep(0.002)
        return self.part.status.detail

    async def settled(self) -> PartStatus:
        """The status once it is ready, or is not going to be."""
        async with asyncio.timeout(LIMIT_S):
            with contextlib.suppress(SaysoError):
                await self.part.get()
        return self.part.status


@contextlib.asynccontextmanager
async def kept(chat: LocalChat, fetching: Fetching | None) -> AsyncIterator[Kept]:
    reports: list[PartStatus] = []
    part: Part[str] = Part("model", reports.append)

    async def instructions() -> Sequence[Sequence[Message]]:
        return [RULES]

    task = asyncio.create_task(ModelPart(part, chat, instructions, fetching).keep())
    try:
        yield Kept(part, chat, reports)
    finally:
        task.cancel()
        async with asyncio.timeout(LIMIT_S):
            await asyncio.wait([task])
        assert task.cancelled()
        assert chat.pid is None


def thinker(store: ModelStore, tmp_path: Path) -> LocalChat:
    platform = Platform(kind="local", model="thinker")
    return LocalChat("local", platform, store.folder / "thinker" / "weights.gguf", tmp_path / "prompts")


QUESTION = Ask((*RULES, Message("user", "Is a rose a flower?")), grammar='root ::= "yes" | "no"', max_tokens=4)


def test_a_missing_model_is_fetched_and_says_how_far_it_is(
    make_store: Callable[..., ModelStore], server: SlowServer, tmp_path: Path
) -> None:
    store = make_store({"url": f"http://127.0.0.1:{server.server_port}/weights"})

    async def scenario() -> None:
        async with kept(thinker(store, tmp_path), Fetching(store, "thinker")) as model:
            assert await model.says("fetching 50%") == "fetching 50%, 1 of 2 MB"
            assert model.part.status.state == "loading"
            with pytest.raises(NotRunning, match="not here yet: fetching 50%"):
                await model.chat.reply(QUESTION)
            server.go_on.set()
            status = await model.settled()  # what came is no model, but it came
            assert status.state == "missing"
            assert "damaged" in status.detail

    asyncio.run(scenario())
    assert store.find("thinker")


def test_an_engine_that_ends_meanwhile_waits_for_no_network_and_the_next_goes_on_from_there(
    make_store: Callable[..., ModelStore], server: SlowServer, tmp_path: Path
) -> None:
    store = make_store({"url": f"http://127.0.0.1:{server.server_port}/weights"})

    async def scenario() -> None:
        async with kept(thinker(store, tmp_path), Fetching(store, "thinker")) as model:
            await model.says("fetching 50%")

    asyncio.run(scenario())
    assert not server.go_on.is_set()
    server.go_on.set()
    for thread in threading.enumerate():
        if thread.name == "fetch":
            thread.join(LIMIT_S)
            assert not thread.is_alive()
    assert store.list()[0].state == "partial"
    assert store.fetched("thinker") >= len(WEIGHTS) // 2


def test_a_model_that_another_sayso_is_fetching_is_waited_for(
    make_store: Callable[..., ModelStore], tmp_path: Path
) -> None:
    store = make_store({"path": "weights.gguf"})
    lock = store.folder / ".partial" / "thinker.lock"
    lock.parent.mkdir(parents=True)

    async def scenario() -> None:
        with lock.open("a") as held:
            fcntl.flock(held, fcntl.LOCK_EX)
            async with kept(thinker(store, tmp_path), Fetching(store, "thinker")) as model:
                await model.says("another sayso is fetching it")
                fcntl.flock(held, fcntl.LOCK_UN)
                assert "damaged" in (await model.settled()).detail

    asyncio.run(scenario())


@pytest.mark.parametrize(
    ("source", "size", "says"),
    [
        ({"path": "absent.gguf"}, len(WEIGHTS), "is not a file"),
        ({"path": "weights.gguf"}, len(WEIGHTS) - 1, "is larger than"),
        ({"url": "http://127.0.0.1:9/weights"}, len(WEIGHTS), "Check the network"),
        ({"path": "weights.gguf"}, 1 << 60, "MB are free"),
    ],
    ids=["no source", "wrong bytes", "no network", "a full disk"],
)
def test_a_model_that_cannot_be_fetched_is_missing_with_a_hint(
    make_store: Callable[..., ModelStore], tmp_path: Path, source: object, size: int, says: str
) -> None:
    store = make_store(source, size)

    async def scenario() -> None:
        async with kept(thinker(store, tmp_path), Fetching(store, "thinker")) as model:
            status = await model.settled()
            assert status.state == "missing"
            assert says in status.detail
            assert model.reports == [status]
            with pytest.raises(NotRunning) as caught:
                await model.chat.reply(QUESTION)
            assert caught.value.hint == "Run: sayso models pull thinker"

    asyncio.run(scenario())


def test_nothing_is_fetched_unless_that_is_wanted(make_store: Callable[..., ModelStore], tmp_path: Path) -> None:
    store = make_store({"path": "weights.gguf"})

    async def scenario() -> None:
        async with kept(thinker(store, tmp_path), None) as model:
            assert "sayso models pull thinker" in (await model.settled()).detail

    asyncio.run(scenario())
    assert not store.folder.exists()


@pytest.mark.model
def test_a_model_that_is_here_is_loaded_told_its_instructions_and_then_ready(tmp_path: Path) -> None:
    settings = load()
    name = settings.platforms["local"].model or ""
    chat = LocalChat("local", settings.platforms["local"], gguf_of(settings, "local"), tmp_path)

    async def scenario() -> None:
        async with kept(chat, Fetching(model_store(settings), name)) as model:
            await model.says("loading")
            await model.says("reading its instructions")
            status = await model.settled()
            assert status == PartStatus("model", "ready", name)
            reply = await chat.reply(QUESTION)
            assert reply.prompt_tokens - reply.cached_tokens < 30

    asyncio.run(scenario())
