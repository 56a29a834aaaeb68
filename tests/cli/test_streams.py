"""However the three streams of a process are, nothing is deaf, silent by mistake, or ended by a traceback."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from engine.errors import ExitCode
from tests.e2e.sayso import LIMIT_S, command, environment, events, sayso

ENGINE = ("engine", "--source", "none")
FAST = {"SAYSO_ROBOT__SPEED": "max"}


@pytest.fixture
def stalled() -> Iterator[int]:
    """The writing end of a pipe that is full, and that nobody reads."""
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    for size in (65536, 1):
        with contextlib.suppress(BlockingIOError):
            while True:
                os.write(writing, b"x" * size)
    os.set_blocking(writing, True)
    yield writing
    os.close(reading)
    os.close(writing)


@contextmanager
def running(*arguments: str, state: Path, **streams: int) -> Iterator[Any]:
    """A process with pipes, or other streams, of which nothing is left afterwards."""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command(*arguments), env=environment(state), **(pipes | streams)) as process:  # type: ignore[call-overload]
        try:
            yield process
        finally:
            process.kill()


def test_a_request_is_done_while_nobody_takes_what_people_are_told(tmp_path: Path, stalled: int) -> None:
    done = subprocess.run(
        command("ask", "turn left 30 degrees"),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=stalled,
        env=environment(tmp_path, FAST),
        timeout=LIMIT_S,
        check=False,
    )
    assert (done.returncode, done.stdout.decode()) == (ExitCode.DONE, "Turned 30° left.\n")


def test_commands_are_read_from_a_pipe_that_does_not_wait_by_itself(tmp_path: Path) -> None:
    reading, writing = os.pipe()
    os.set_blocking(reading, False)
    with running(*ENGINE, state=tmp_path, stdin=reading) as process:
        os.close(reading)
        process.stdout.readline()  # it is starting, and finds nothing to read
        for name in (b"a", b"b"):
            os.write(writing, b'{"do":"snapshot","id":"%s"}\n' % name)
            assert any(b'"kind":"ack"' in line and b'"id":"%s"' % name in line for line in process.stdout)
        os.write(writing, b'{"do":"quit"}\n')
        process.communicate(timeout=LIMIT_S)
    os.close(writing)
    assert process.returncode == ExitCode.DONE


def test_commands_that_cannot_be_read_end_the_engine_with_a_word(tmp_path: Path) -> None:
    unreadable = os.open(tmp_path / "commands", os.O_WRONLY | os.O_CREAT)
    done = subprocess.run(
        command(*ENGINE), stdin=unreadable, capture_output=True, env=environment(tmp_path), timeout=LIMIT_S, check=False
    )
    os.close(unreadable)
    assert b"commands cannot be read from stdin: Bad file descriptor" in done.stderr
    assert b"Traceback" not in done.stderr
    assert events(done)[-1]["kind"] == "session.ended"


def test_a_reader_who_was_never_there_ends_the_engine(tmp_path: Path) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    with running(*ENGINE, state=tmp_path, stdout=writing) as process:
        os.close(writing)
        assert process.wait(LIMIT_S) == ExitCode.INTERRUPTED  # while commands might still come
        words = process.stderr.read()
    assert b"nobody reads the output" in words
    assert b"Traceback" not in words


@pytest.mark.parametrize(
    ("arguments", "code"), [(ENGINE, ExitCode.DONE), (("ask", "--json", "wait 60 seconds"), ExitCode.INTERRUPTED)]
)
def test_to_be_ended_during_the_start_and_more_than_once_is_an_end_as_usual(
    tmp_path: Path, arguments: tuple[str, ...], code: ExitCode
) -> None:
    with running(*arguments, state=tmp_path) as process:
        process.stdout.readline()  # the session starts, the engine takes no commands yet
        lines = []
        process.send_signal(signal.SIGTERM)
        for line in process.stdout:
            lines.append(json.loads(line)["kind"])
            process.send_signal(signal.SIGTERM)
        _, words = process.communicate(timeout=LIMIT_S)
    assert lines[-1] == "session.ended"
    assert process.returncode == code
    assert b"Traceback" not in words


ENDED_WHILE_LOADING = """
import os, signal, tui.cli
load = tui.cli.importlib.import_module
tui.cli.importlib.import_module = lambda name: os.kill(os.getpid(), signal.{}) or load(name)
"""


@pytest.mark.parametrize("number", ["SIGTERM", "SIGHUP", "SIGQUIT"])
@pytest.mark.parametrize(
    ("arguments", "code"),
    [(ENGINE, ExitCode.DONE), (("wyoming",), ExitCode.DONE), (("ask", "beep"), ExitCode.INTERRUPTED)],
)
def test_to_be_ended_before_anything_is_loaded_is_an_end_as_well(
    tmp_path: Path, arguments: tuple[str, ...], code: ExitCode, number: str
) -> None:
    started = command(*arguments, before=ENDED_WHILE_LOADING.format(number))
    done = subprocess.run(started, env=environment(tmp_path), capture_output=True, timeout=LIMIT_S, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (code, b"", b"")


def test_an_interrupt_ends_a_plan_that_waits_for_a_request(tmp_path: Path) -> None:
    with running("plan", "-", state=tmp_path) as process:
        process.stdin.write(b"beep\n")
        process.stdin.flush()
        process.stdout.readline()  # the first is planned: the next one is waited for
        process.send_signal(signal.SIGINT)
        assert process.wait(LIMIT_S) == ExitCode.INTERRUPTED


@pytest.mark.parametrize("arguments", [ENGINE, ("ask", "--json", "wait 60 seconds")], ids=["engine", "ask"])
def test_a_full_disk_ends_the_engine_with_a_word(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    full = os.open("/dev/full", os.O_WRONLY)
    with running(*arguments, state=tmp_path, stdout=full) as process:
        os.close(full)
        assert process.wait(LIMIT_S) == ExitCode.MISSING
        words = process.stderr.read().decode()
    assert "the output cannot be written: No space left on device; the robot was stopped." in words
    assert "Traceback" not in words


@pytest.mark.parametrize("arguments", [("plan", "--json", "beep"), ("skills",)], ids=["plan", "skills"])
def test_a_full_disk_and_a_reader_who_has_gone_are_told_by_the_exit_code(
    tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    reading, gone = os.pipe()
    os.close(reading)
    full = os.open("/dev/full", os.O_WRONLY)
    for stdout, code, words in (
        (full, ExitCode.MISSING, "sayso: The output cannot be written: No space left on device.\n"),
        (gone, ExitCode.INTERRUPTED, ""),
    ):
        done = subprocess.run(
            command(*arguments),
            stdin=subprocess.DEVNULL,
            stdout=stdout,
            stderr=subprocess.PIPE,
            env=environment(tmp_path),
            timeout=LIMIT_S,
            check=False,
        )
        os.close(stdout)
        assert (done.returncode, done.stderr.decode()) == (code, words)


@pytest.mark.parametrize(
    ("closed", "text", "code"), [(0, "-", ExitCode.DONE), (1, "fly away", ExitCode.FAILED), (2, "fly away", 1)]
)
def test_a_stream_that_is_closed_is_as_if_nobody_were_there(tmp_path: Path, closed: int, text: str, code: int) -> None:
    script = f'exec "$@" {closed}>&-'
    done = subprocess.run(
        ["sh", "-c", script, "sh", *command("plan", text)],
        capture_output=True,
        stdin=subprocess.DEVNULL,
        env=environment(tmp_path),
        timeout=LIMIT_S,
        check=False,
    )
    assert (done.returncode, done.stdout) == (code, b"")
    assert (b"cannot fly" in done.stderr) is (closed == 1)
    assert b"Traceback" not in done.stderr


def test_a_home_that_is_no_folder_holds_no_settings(tmp_path: Path) -> None:
    (tmp_path / "home").touch()
    done = sayso("plan", "beep", state=tmp_path, environ={"SAYSO_CONFIG_DIR": str(tmp_path / "home" / ".config")})
    assert (done.returncode, done.stderr) == (ExitCode.DONE, b"")


def test_a_sound_file_that_is_not_there_is_told_once(tmp_path: Path) -> None:
    done = sayso("hear", str(tmp_path / "missing.wav"), state=tmp_path)
    assert done.returncode == ExitCode.USAGE
    assert done.stderr.count(b"missing.wav") == 1
