"""The model on this machine answers, remembers what it has read, falls silent, and is neither lost nor left over."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import psutil
import pytest

from config import load
from config.schema import Platform
from engine.errors import ExitCode
from engine.llm.chat import Ask, Message
from engine.llm.llama import NotRunning
from engine.llm.local import LocalChat
from engine.parts.loading import gguf_of
from tests.children import children

LIMIT_S = 100.0
"""s for what takes a moment; a test that waits longer has failed."""
NAME = "local"
PLATFORM = Platform(kind="local", model="qwen2.5-coder-1.5b", timeout_s=LIMIT_S)
RULES = "You command a robot. " + " ".join(f"Never go to room {number}." for number in range(3, 22))
POEMS = "You are a poet. " + " ".join(f"Line {number} ends with a flower." for number in range(3, 20))
YES = 'root ::= "yes" | "no"'
linux = pytest.mark.skipif(sys.platform != "linux", reason="a paused process ends with its engine only on Linux")


def ask(system: str, text: str = "Is a rose a flower?", **how: object) -> Ask:
    wanted = {"grammar": YES, "max_tokens": 4, **how}
    return Ask((Message("system", system), Message("user", text)), **wanted)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def runner() -> Iterator[asyncio.Runner]:
    """The one loop, and thread, of the model of this module."""
    with asyncio.Runner() as made:
        yield made


@pytest.fixture(scope="module")
def folder() -> Iterator[Path]:
    with tempfile.TemporaryDirectory() as made:
        yield Path(made)


@pytest.fixture(scope="module")
def chat(runner: asyncio.Runner, folder: Path) -> Iterator[LocalChat]:
    made = LocalChat(NAME, PLATFORM, gguf_of(load(), NAME), folder)
    yield made
    runner.run(made.close())
    assert workers() == []


def workers() -> list[psutil.Process]:
    return children("engine.llm.llama_worker")


def until(what: Callable[[], object]) -> None:
    """Wait for something that the system does."""
    deadline = time.monotonic() + LIMIT_S
    while not what():
        assert time.monotonic() < deadline, "it never happened"
        time.sleep(0.005)


async def cancelled_at(begun: asyncio.Event, task: asyncio.Task[object]) -> None:
    async with asyncio.timeout(LIMIT_S):
        await begun.wait()
    task.cancel()
    await asyncio.wait([task])
    assert task.cancelled()


# Answers


@pytest.mark.model
def test_it_answers_in_the_form_that_was_asked_for_piece_by_piece(chat: LocalChat, runner: asyncio.Runner) -> None:
    pieces: list[str] = []
    reply = runner.run(chat.reply(ask(RULES), pieces.append))
    assert reply.text in ("yes", "no")
    assert "".join(pieces) == reply.text
    assert (reply.model, reply.kind) == (NAME, "local")
    assert reply.prompt_tokens > 80
    assert reply.reply_tokens > 0


@pytest.mark.model
def test_two_beginnings_do_not_throw_each_other_out(chat: LocalChat, runner: asyncio.Runner) -> None:
    for _ in range(2):
        for system in (RULES, POEMS):
            reply = runner.run(chat.reply(ask(system)))
    assert reply.prompt_tokens - reply.cached_tokens < 30
    again = runner.run(chat.reply(ask(RULES)))
    assert again.prompt_tokens - again.cached_tokens < 30


# Silence


@linux
@pytest.mark.model
@pytest.mark.parametrize("stage", ["reading", "answering"])
def test_a_cancelled_question_silences_it_and_the_next_one_is_answered(
    chat: LocalChat, runner: asyncio.Runner, stage: str
) -> None:
    async def cut() -> None:
        begun = asyncio.Event()
        if stage == "reading":
            work = chat.prepare([Message("system", f"{POEMS} {RULES}")], lambda done: begun.set() if done else None)
        else:
            long = ask(RULES, "Count to a thousand.", grammar=None, max_tokens=500)
            work = chat.reply(long, lambda piece: begun.set())  # type: ignore[assignment]
        await cancelled_at(begun, asyncio.ensure_future(work))

    runner.run(cut())
    assert chat.pid is not None
    process = psutil.Process(chat.pid)
    until(lambda: process.status() == psutil.STATUS_STOPPED)
    assert runner.run(chat.reply(ask(RULES))).text in ("yes", "no")
    assert process.is_running()


# The next start


def start_again(chat: LocalChat) -> None:
    """End the process; the next question starts it anew."""
    assert chat.pid is not None
    os.kill(chat.pid, signal.SIGKILL)
    os.waitid(os.P_PID, chat.pid, os.WEXITED | os.WNOWAIT)


@pytest.mark.model
def test_what_was_read_is_known_at_the_next_start_and_in_another_house(chat: LocalChat, runner: asyncio.Runner) -> None:
    runner.run(chat.prepare([Message("system", RULES)]))
    start_again(chat)
    other = runner.run(chat.reply(ask(f"{RULES} Rooms: attic, cellar.")))
    assert other.prompt_tokens - other.cached_tokens < 45
    same = runner.run(chat.reply(ask(RULES)))
    assert same.prompt_tokens - same.cached_tokens < 30


@pytest.mark.model
def test_a_damaged_save_is_read_anew(chat: LocalChat, runner: asyncio.Runner, folder: Path) -> None:
    runner.run(chat.prepare([Message("system", RULES)]))
    for state in folder.glob("*.state"):
        state.write_bytes(b"no state")
    start_again(chat)
    told: list[float] = []
    runner.run(chat.prepare([Message("system", RULES)], told.append))
    assert max(told) > 0.9  # it was read, not restored
    reply = runner.run(chat.reply(ask(RULES)))
    assert reply.text in ("yes", "no")
    assert reply.prompt_tokens - reply.cached_tokens < 30


# Loss


@pytest.mark.model
def test_a_process_that_dies_while_it_answers_is_an_error_and_is_replaced_at_the_next_question(
    chat: LocalChat, runner: asyncio.Runner
) -> None:
    told: list[NotRunning | None] = []
    chat.tell = told.append

    def kill(piece: str) -> None:
        assert chat.pid is not None
        os.kill(chat.pid, signal.SIGKILL)

    with pytest.raises(NotRunning, match="killed") as caught:
        runner.run(chat.reply(ask(RULES, "Count to a thousand.", grammar=None, max_tokens=500), kill))
    assert caught.value.exit_code is ExitCode.MISSING
    assert workers() == []
    assert runner.run(chat.reply(ask(RULES))).text in ("yes", "no")
    assert [trouble is None for trouble in told] == [False, True]


@linux
@pytest.mark.model
def test_a_paused_model_ends_with_an_engine_that_is_killed(folder: Path) -> None:
    program = f"""
import asyncio, pathlib
from tests.unit.test_local import NAME, PLATFORM, RULES, ask, gguf_of, load
from engine.llm.local import LocalChat

async def main():
    chat = LocalChat(NAME, PLATFORM, gguf_of(load(), NAME), pathlib.Path({str(folder)!r}))
    begun = asyncio.Event()
    question = ask(RULES, "Count to a thousand.", grammar=None, max_tokens=500)
    task = asyncio.ensure_future(chat.reply(question, lambda piece: begun.set()))
    await begun.wait()
    task.cancel()
    await asyncio.wait([task])
    print(chat.pid, flush=True)
    await asyncio.Event().wait()

asyncio.run(main())
"""
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True) as engine:
        assert engine.stdout is not None
        model = psutil.Process(int(engine.stdout.readline()))
        socket = next(Path(word.partition("=")[2]) for word in model.cmdline() if word.startswith("--socket="))
        assert socket.exists()
        until(lambda: model.status() == psutil.STATUS_STOPPED)
        engine.kill()
    until(lambda: not model.is_running() or model.status() == psutil.STATUS_ZOMBIE)
    assert not socket.parent.exists()


# What cannot be loaded


def refused(gguf: Path, cache: Path, platform: Platform = PLATFORM, on_the_way: str = "") -> NotRunning:
    async def attempt() -> None:
        made = LocalChat(NAME, platform, gguf, cache)
        made.on_the_way = on_the_way
        try:
            await made.reply(ask(RULES))
        finally:
            await made.close()

    before = set(Path(tempfile.gettempdir()).glob("sayso-*"))
    with pytest.raises(NotRunning) as caught:
        asyncio.run(attempt())
    assert caught.value.exit_code is ExitCode.MISSING
    assert set(Path(tempfile.gettempdir()).glob("sayso-*")) <= before
    return caught.value


def model_file(folder: Path) -> Path:
    file = folder / "qwen2.5-coder-1.5b" / "model.gguf"
    file.parent.mkdir()
    return file


def test_a_model_that_is_not_here_names_the_command_that_fetches_it(tmp_path: Path) -> None:
    error = refused(model_file(tmp_path), tmp_path / "prompts")
    assert "is not there" in error.message
    assert error.hint == "Run: sayso models pull qwen2.5-coder-1.5b"


def test_a_model_that_is_on_its_way_says_how_far_it_is(tmp_path: Path) -> None:
    error = refused(model_file(tmp_path), tmp_path / "prompts", on_the_way="fetching 43 %")
    assert error.message == "The model is not here yet: fetching 43 %."


def test_a_file_that_is_no_model_is_told_so(tmp_path: Path) -> None:
    file = model_file(tmp_path)
    file.write_bytes(b"GGUF and then nothing of the kind")
    error = refused(file, tmp_path / "prompts")
    assert "damaged" in error.message
    assert error.hint == "Run: sayso models pull qwen2.5-coder-1.5b"
    own = PLATFORM.model_copy(update={"model": str(file)})
    assert refused(file, tmp_path / "prompts", own).hint.startswith(f"Check platforms.{NAME}.model")


def test_too_little_memory_is_said_before_anything_is_loaded(tmp_path: Path) -> None:
    file = model_file(tmp_path)
    file.touch()
    os.truncate(file, 1 << 42)  # a hole: it takes no room
    error = refused(file, tmp_path / "prompts")
    assert "too little memory" in error.message
    assert "needs about 4838570 MB" in error.message


def test_a_machine_without_the_library_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "xllamacpp.py").write_text("raise ImportError('libgomp.so.1: cannot open shared object file')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    file = model_file(tmp_path)
    file.write_bytes(b"GGUF")
    error = refused(file, tmp_path / "prompts")
    assert "libgomp.so.1" in error.message
    assert "apt install libgomp1" in error.hint
