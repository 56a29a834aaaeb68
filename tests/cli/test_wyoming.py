"""``sayso wyoming``: recogniser and voice for other programs, as a service runs it."""

from __future__ import annotations

import asyncio
import json
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from wyoming.client import AsyncClient
from wyoming.info import Describe, Info

from engine.errors import ExitCode
from tests.e2e.sayso import command, environment, sayso

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
LIMIT_S = 60


@contextmanager
def serving(state: Path, *arguments: str) -> Iterator[tuple[subprocess.Popen[bytes], str]]:
    """The process, and where it serves."""
    argv = command("wyoming", "--uri", "tcp://127.0.0.1:0", "--json", *arguments)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(argv, env=environment(state), **pipes) as process:  # type: ignore[call-overload]
        try:
            line = process.stdout.readline()
            assert line, process.stderr.read().decode()
            yield process, json.loads(line)["uri"]
        finally:
            process.kill()


@pytest.mark.model
def test_another_sayso_recognises_with_it(tmp_path: Path) -> None:
    async def offered(uri: str) -> Info:
        async with asyncio.timeout(LIMIT_S), AsyncClient.from_uri(uri) as client:
            await client.write_event(Describe().event())
            event = await client.read_event()
            assert event is not None
            return Info.from_event(event)

    with serving(tmp_path, "--only", "asr") as (process, uri):
        info = asyncio.run(offered(uri))
        assert [program.models[0].name for program in info.asr] == ["whisper-base"]
        assert info.tts == []
        remote = ("--set", "asr.backend=wyoming", "--set", f"asr.server={uri}")
        done = sayso("transcribe", str(SPEECH / "go_to_the_kitchen.wav"), *remote, state=tmp_path / "other")
        assert done.returncode == ExitCode.DONE, done.stderr.decode()
        assert "kitchen" in done.stdout.decode()
        process.terminate()
        assert process.wait(LIMIT_S) == ExitCode.DONE
        told = process.stderr.read().decode()
        assert "warning" not in told
        assert "kitchen" not in told, "what was said is nobody's business"


ELSEWHERE = ("--only", "tts", "--set", "voice.backend=wyoming", "--set", "voice.server=tcp://127.0.0.1:9")
"""A voice that needs no time to load, and will never be asked."""


@pytest.mark.parametrize(
    ("number", "code"),
    [(signal.SIGTERM, ExitCode.DONE), (signal.SIGHUP, ExitCode.DONE), (signal.SIGINT, ExitCode.INTERRUPTED)],
)
def test_it_ends_when_told_to(tmp_path: Path, number: signal.Signals, code: ExitCode) -> None:
    with serving(tmp_path, *ELSEWHERE) as (process, _):
        process.send_signal(number)
        assert process.wait(LIMIT_S) == code
        assert "Traceback" not in process.stderr.read().decode()


def test_whoever_serves_beyond_this_machine_is_warned(tmp_path: Path) -> None:
    done = sayso("wyoming", "--uri", "tcp://192.0.2.1:10300", *ELSEWHERE, state=tmp_path)  # RFC 5737: it is nobody's
    assert done.returncode == ExitCode.MISSING
    assert "no password" in done.stderr.decode()
    assert "Nothing can be served at tcp://192.0.2.1:10300" in done.stderr.decode()


def test_a_server_that_would_ask_itself_is_refused(tmp_path: Path) -> None:
    itself = ("--set", "asr.backend=wyoming", "--set", "asr.server=tcp://127.0.0.1:10300")
    done = sayso("wyoming", *itself, state=tmp_path)
    assert done.returncode == ExitCode.USAGE
    assert "ask itself" in done.stderr.decode()
