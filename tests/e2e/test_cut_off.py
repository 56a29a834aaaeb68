"""Requests that are cut off while the robot drives in real time, by a time limit and by a reader who goes away."""

from __future__ import annotations

import subprocess
from pathlib import Path

from engine.errors import ExitCode
from tests.e2e.sayso import command, environment, events, sayso


def test_a_time_limit_stops_the_robot_and_exits_with_4(tmp_path: Path) -> None:
    real = {"SAYSO_ROBOT__SPEED": "real"}
    done = sayso("ask", "--json", "--timeout", "5", "go forward 5 metres", state=tmp_path, environ=real)
    assert done.returncode == ExitCode.TIMEOUT
    assert [event["body"]["outcome"] for event in events(done, "action.finished")] == ["interrupted"]


def test_a_reader_who_goes_away_stops_the_robot_and_leaves_no_traceback(tmp_path: Path) -> None:
    with subprocess.Popen(
        command("ask", "--json", "go forward 4 metres"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment(tmp_path),
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.readline()
        process.stdout.close()
        complaint = process.stderr.read().decode()
    assert process.returncode == ExitCode.INTERRUPTED
    assert "Traceback" not in complaint
    assert "robot was stopped" in complaint
