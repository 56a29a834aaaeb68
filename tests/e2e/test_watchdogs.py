"""Whatever is killed, paused, hung or unplugged: the robot stands, says why, and does not go on by itself.

Each test drives in real time, strikes in mid-drive, and reads from the robot process's own memory what became of it.
"""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import psutil
import pytest

from engine.errors import ExitCode
from engine.robot.host.memory import STOP_EPOCH
from tests.e2e.body import CAN_READ, Body, until
from tests.e2e.engine import Engine, engine
from tests.e2e.sayso import command, environment
from tests.e2e.terminal import TO_THE_PANES, Terminal, console
from tests.e2e.test_console import last

pytestmark = pytest.mark.skipif(not CAN_READ, reason="reads another process's memory through /proc")

FAR = "go to the bedroom"
HANGS = """
import threading, engine.engine
start = engine.engine.Engine.start
def hanging(self):
    start(self)
    def hang(event):
        if event.kind == "action.progress" and (event.body.fraction or 0) > 0.1:
            threading.Event().wait()
    self.subscribe(hang)
engine.engine.Engine.start = hanging
"""
"""An engine whose thread hangs when an action has made some progress, in the worst of places: inside the bus."""
BREAKS = """
import engine.session.session
def broken(self):
    raise ZeroDivisionError("broken on purpose")
engine.session.session.Session._snapshot = broken
"""
"""A session with a fault: it breaks over a snapshot."""


def driving_engine(running: Engine) -> Body:
    running.until_loaded()
    body = Body(running.process.pid)
    running.send(do="say", text=FAR)
    body.until_driving()
    return body


def driving_console(terminal: Terminal) -> Body:
    terminal.until(lambda: "✓ robot" in terminal.text and "◌" not in terminal.text)
    body = Body(terminal.pid)
    terminal.type("/")
    terminal.type(FAR + "\r" + TO_THE_PANES)
    terminal.until(lambda: body.driving)
    return body


def gone(*processes: psutil.Process) -> bool:
    return psutil.wait_procs(processes, timeout=10)[1] == []


def kinds(events: list[dict[str, Any]], kind: str) -> list[dict[str, Any]]:
    return [event["body"] for event in events if event["kind"] == kind]


def failed(body: dict[str, Any]) -> bool:
    return bool(body["result"] and body["result"]["outcome"] == "failed")


# The engine


def test_a_paused_engine_leaves_a_robot_that_stands_and_does_not_go_on_by_itself(tmp_path: Path) -> None:
    with engine(tmp_path) as running:
        body = driving_engine(running)
        blow = time.monotonic()
        running.process.send_signal(signal.SIGSTOP)
        body.until_resting(blow)
        until(lambda: body.halted == "heartbeat lost", "the robot halts")
        body.stays(1.5)
        running.process.send_signal(signal.SIGCONT)
        assert running.until("error")["code"] == "robot_halted"
        assert running.until("action.finished")["error_code"] == "robot_halted"
        running.until("state.changed", failed)
        body.stays(1.0)
        until(lambda: not body.halted, "the new epoch has released the robot")
        assert any("did not respond" in log["message"] for log in kinds(running.seen, "log"))
        running.send(do="say", text=FAR)
        body.until_driving()


def test_a_killed_engine_leaves_a_robot_that_stands_and_then_nothing(tmp_path: Path) -> None:
    with engine(tmp_path) as running:
        body = driving_engine(running)
        blow = time.monotonic()
        running.process.kill()
        body.until_resting(blow)
        assert gone(body.process)
        assert body.halted == "engine gone"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT, signal.SIGQUIT])
def test_an_engine_that_is_told_to_end_stops_the_robot_and_keeps_its_books(
    tmp_path: Path, number: signal.Signals
) -> None:
    with engine(tmp_path) as running:
        body = driving_engine(running)
        blow = time.monotonic()
        running.process.send_signal(number)
        body.until_resting(blow)
        events = running.rest()
        assert [end["outcome"] for end in kinds(events, "action.finished")] == ["interrupted"]
        assert events[-1]["kind"] == "session.ended"
        assert set(kinds(events, "robot.state")[-1]["twist"].values()) == {0}, "it is told how the robot rests"
        assert running.process.wait(10) == (ExitCode.INTERRUPTED if number == signal.SIGINT else ExitCode.DONE)
        assert gone(body.process)


def test_an_engine_that_hangs_is_given_up(tmp_path: Path) -> None:
    with engine(tmp_path, before=f"{HANGS}\nimport tui.commands.engine\ntui.commands.engine.HUNG_S = 4") as running:
        body = driving_engine(running)
        body.until_resting(0.0)
        until(lambda: body.halted == "heartbeat lost", "the robot halts")
        assert running.process.wait(60) == ExitCode.FAILED
        assert running.process.stderr is not None
        words = running.process.stderr.read().decode()
        assert "the engine does not answer" in words
        assert "not answered for" in words
        assert gone(body.process)


def test_an_engine_with_a_fault_stops_the_robot_says_so_and_fails(tmp_path: Path) -> None:
    with engine(tmp_path, before=BREAKS) as running:
        body = driving_engine(running)
        blow = time.monotonic()
        running.send(do="snapshot")
        body.until_resting(blow)
        events = running.rest()
        fault = kinds(events, "error")[-1]
        assert (fault["code"], fault["fatal"]) == ("engine_died", True)
        assert "broken on purpose" in fault["message"]
        assert [end["outcome"] for end in kinds(events, "action.finished")] == ["interrupted"]
        assert kinds(events, "session.ended")[-1]["reason"] == "a fault"
        assert running.process.wait(10) == ExitCode.FAILED
        assert gone(body.process)


@pytest.mark.parametrize(
    ("before", "words"),
    [(HANGS, "not answered"), (BREAKS.replace("_snapshot(", "_close(").replace("_snapshot", "_close"), "fault")],
    ids=["hangs", "breaks"],
)
def test_nobody_waits_for_ever_for_a_result(tmp_path: Path, before: str, words: str) -> None:
    before = before.replace("broken(self)", "broken(self, turn)")
    done = subprocess.run(
        command("ask", "--speed", "max", "go to the kitchen", before=before),
        env=environment(tmp_path),
        capture_output=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == ExitCode.FAILED, done.stderr
    assert words in done.stderr.decode()


# The recogniser process


LIBRARIES = ("ctranslate2", "tokenizers")
"""Those whose Python parts would hold up whoever stops the robot. (onnxruntime is in the engine too: wake words take
some ms of it a second, in a thread that holds nobody up.)"""


def test_an_engine_keeps_the_recogniser_out_of_its_own_process(tmp_path: Path) -> None:
    with engine(tmp_path) as running:
        running.until_loaded()
        (recogniser,) = (child for child in below(running.process.pid) if "engine.asr.worker" in child.cmdline())
        assert libraries(running.process.pid) == set()
        assert "ctranslate2" in libraries(recogniser.pid)
        running.send(do="quit")
        assert running.process.wait(10) == ExitCode.DONE
        assert gone(recogniser)


def below(pid: int) -> list[psutil.Process]:
    return psutil.Process(pid).children(recursive=True)


def libraries(pid: int) -> set[str]:
    """Those of the recogniser that a process has mapped."""
    mapped = Path(f"/proc/{pid}/maps").read_text(encoding="utf-8")
    return {library for library in LIBRARIES if library in mapped}


# The robot process


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP, signal.SIGTERM])
def test_a_lost_robot_comes_back_where_it_was_and_takes_new_commands(tmp_path: Path, number: signal.Signals) -> None:
    with engine(tmp_path) as running:
        body = driving_engine(running)
        lost = body.process
        lost.send_signal(number)
        error = running.until("error", lambda error: error["code"] == "robot_lost")
        assert not error["fatal"]
        was = body.pose
        running.until("log", lambda log: "running again where it was" in log["message"])
        assert gone(lost)
        assert body.pose.distance_to(was) < 0.05
        body.stays(0.5)
        (finished,) = kinds(running.seen, "action.finished")
        assert finished["error_code"] in ("robot_lost", "robot_halted")  # one that is told to end halts before it goes
        running.send(do="say", text=FAR)
        body.until_driving()
        running.send(do="quit")
        assert running.until("session.ended")["reason"] == "asked to"
        assert running.process.wait(10) == ExitCode.DONE


# The console


def test_a_paused_console_leaves_a_robot_that_stands_and_says_for_how_long(tmp_path: Path) -> None:
    with console(state=tmp_path) as terminal:
        body = driving_console(terminal)
        blow = time.monotonic()
        os.kill(terminal.pid, signal.SIGSTOP)
        body.until_resting(blow)
        body.stays(1.5)
        os.kill(terminal.pid, signal.SIGCONT)
        terminal.until(lambda: "stopped by itself" in terminal.text and "Not responding for" in terminal.text)
        body.stays(0.5)
        terminal.type("/")
        terminal.type(FAR + "\r")
        terminal.until(lambda: body.driving)


def test_a_console_whose_engine_hangs_says_so_and_leaves_at_once(tmp_path: Path) -> None:
    with console(state=tmp_path, before=HANGS) as terminal:
        body = driving_console(terminal)
        body.until_resting(0.0)
        terminal.until(lambda: "is not responding" in terminal.text and "quits at once" in terminal.text)
        epoch = body.memory.ints[STOP_EPOCH]
        terminal.type("\x1b[27u")  # escape, in a form that cannot be taken for the beginning of anything
        until(lambda: body.memory.ints[STOP_EPOCH] > epoch, "the key still stops the robot")
        terminal.type("q")
        assert terminal.wait() == ExitCode.FAILED
        assert gone(body.process)


def test_a_lost_robot_is_shown_until_it_is_back(tmp_path: Path) -> None:
    with console(state=tmp_path) as terminal:
        body = driving_console(terminal)
        body.process.kill()
        terminal.until(lambda: "SIGKILL" in terminal.text)
        terminal.until(lambda: "the robot is connected again" in terminal.text and "✓ robot" in terminal.text)
        assert "Something failed" not in terminal.text
        terminal.type("q")
        assert terminal.wait() == ExitCode.DONE


BLOWS: dict[str, tuple[Callable[[Terminal], None], int]] = {
    "killed": (lambda terminal: os.kill(terminal.pid, signal.SIGKILL), -signal.SIGKILL),
    "terminal closed": (lambda terminal: terminal.hang_up(), ExitCode.INTERRUPTED),
    "SIGHUP": (lambda terminal: os.kill(terminal.pid, signal.SIGHUP), ExitCode.INTERRUPTED),
    "SIGTERM": (lambda terminal: os.kill(terminal.pid, signal.SIGTERM), ExitCode.INTERRUPTED),
    "SIGQUIT": (lambda terminal: os.kill(terminal.pid, signal.SIGQUIT), ExitCode.INTERRUPTED),
}


@pytest.mark.parametrize("blow", BLOWS)
def test_a_console_that_goes_away_leaves_a_robot_that_stands_and_then_nothing(tmp_path: Path, blow: str) -> None:
    strike, code = BLOWS[blow]
    with console(state=tmp_path) as terminal:
        body = driving_console(terminal)
        family = psutil.Process(terminal.pid).children(recursive=True)
        when = time.monotonic()
        strike(terminal)
        body.until_resting(when)
        assert terminal.wait() == code
        assert gone(*family)
        if code != -signal.SIGKILL:
            assert last(terminal, "action.finished")["outcome"] == "interrupted"
