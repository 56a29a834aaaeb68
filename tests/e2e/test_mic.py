"""Somebody else's microphone, handed to a running sayso through a pipe."""

from __future__ import annotations

import os
import pty
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from engine.audio.source import RATE
from engine.audio.wav import read_wav
from engine.errors import ExitCode
from tests.e2e.engine import engine
from tests.e2e.sayso import command, environment, sayso
from tests.e2e.terminal import TO_THE_PANES, console
from tests.e2e.test_console import driving, last

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
LIMIT_S = 60
OVER_SSH = {"SSH_CONNECTION": "192.0.2.1 50000 192.0.2.2 22"}


class Feeder:
    """``sayso mic`` at the end of a pipe."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self._process = process

    def words(self) -> str:
        """Its next line for people."""
        assert self._process.stderr is not None
        return self._process.stderr.readline().decode()

    def say(self, recording: str) -> None:
        """A recording, and silence after it."""
        assert self._process.stdin is not None
        silence = np.random.default_rng(0).normal(0, 5, 2 * RATE).astype(np.int16)
        self._process.stdin.write(np.concatenate((read_wav(SPEECH / recording), silence)).astype("<i2").tobytes())
        self._process.stdin.flush()

    def end(self) -> int:
        """The pipe ends; the exit code."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        return self._process.wait(LIMIT_S)


@contextmanager
def feeder(state: Path, environ: Mapping[str, str]) -> Iterator[Feeder]:
    pipes = {"stdin": subprocess.PIPE, "stderr": subprocess.PIPE}
    argv = command("mic")
    with subprocess.Popen(argv, env=environment(state, environ), **pipes) as process:  # type: ignore[call-overload]
        try:
            yield Feeder(process)
        finally:
            process.kill()


@pytest.mark.model
def test_a_microphone_over_ssh_is_heard_in_the_console_until_it_leaves(tmp_path: Path) -> None:
    with console("--set", "audio.device=no such device", state=tmp_path) as terminal:

        def told() -> list[str]:
            return [e["body"]["message"] for e in terminal.events() if e["body"].get("source") == "microphone"]

        terminal.until(lambda: "No microphone" in terminal.text)
        terminal.until(lambda: any(e["body"].get("source") == "recogniser" for e in terminal.events()))
        with feeder(tmp_path, OVER_SSH) as laptop:
            assert str(terminal.pid) in laptop.words()
            terminal.until(lambda: "ssh microphone" in terminal.text)
            terminal.type(" ")
            terminal.until(lambda: last(terminal, "listen.started").get("source") == "ssh microphone")
            laptop.say("go_to_the_kitchen.wav")
            terminal.until(lambda: "kitchen" in last(terminal, "transcript.final").get("text", "").lower())
            terminal.until(lambda: driving(terminal))
            laptop.say("stop.wav")  # without a wake, as at any microphone
            terminal.until(lambda: last(terminal, "interrupt.raised").get("scope") == "stop")
            assert laptop.end() == ExitCode.DONE
        terminal.until(lambda: "No microphone" in terminal.text)
        missing, guest, again = told()
        assert missing == again
        assert guest == "ready: ssh microphone"
        terminal.type(TO_THE_PANES + "q")
        assert terminal.wait() == 0
    assert not (tmp_path / "mic.sock").exists()


@pytest.mark.model
def test_after_a_guest_sound_comes_from_where_it_came_before(tmp_path: Path) -> None:
    with engine(tmp_path) as robot:
        robot.until_loaded()
        with feeder(tmp_path, {}) as guest:
            guest.words()
            robot.until("log", lambda body: body["message"] == "ready: piped microphone")
            robot.send(do="audio", pcm="AAAAAA==")
            assert not robot.until("ack")["ok"]
            with feeder(tmp_path, OVER_SSH) as second:
                assert "hears somebody else already (piped microphone)" in second.words()
                assert second.end() == ExitCode.MISSING
            assert guest.end() == ExitCode.DONE
        robot.until("log", lambda body: body["message"] == "ready: audio commands")
        robot.send(do="audio", pcm="AAAAAA==")
        assert robot.until("ack")["ok"]
        with feeder(tmp_path, {}) as last_one:
            last_one.words()
            robot.send(do="quit")
            robot.rest()
            assert "has ended" in last_one.words()


def test_without_a_sayso_the_guest_is_told_so(tmp_path: Path) -> None:
    done = sayso("mic", state=tmp_path, stdin=b"\0" * 64)
    assert done.returncode == ExitCode.MISSING
    assert b"No sayso that hears runs on this machine" in done.stderr
    assert done.stdout == b""


def test_a_person_is_not_expected_to_type_sound(tmp_path: Path) -> None:
    ours, theirs = pty.openpty()
    done = subprocess.run(
        command("mic"), stdin=theirs, capture_output=True, timeout=LIMIT_S, env=environment(tmp_path), check=False
    )
    os.close(ours)
    os.close(theirs)
    assert done.returncode == ExitCode.USAGE
    assert b"arecord" in done.stderr
