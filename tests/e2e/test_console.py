"""The console as a person uses it: a real terminal, a real engine, real physics in real time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import psutil
import pytest

from tests.e2e.terminal import TO_THE_PANES, Terminal, console


def last(terminal: Terminal, kind: str) -> dict[str, Any]:
    """Body of the newest event of this kind, or {}."""
    return next((event["body"] for event in reversed(terminal.events()) if event["kind"] == kind), {})


def driving(terminal: Terminal) -> bool:
    return last(terminal, "robot.state").get("twist", {}).get("vx", 0.0) > 0.2


@pytest.mark.parametrize("size", [(120, 40), (80, 24)], ids=["120x40", "80x24"])
def test_a_typed_command_drives_and_esc_stops_it_half_way(tmp_path: Path, size: tuple[int, int]) -> None:
    with console(state=tmp_path, columns=size[0], rows=size[1]) as terminal:
        terminal.until(lambda: "READY" in terminal.text)
        terminal.type("/")
        terminal.type("go to the kitchen\r")
        terminal.until(lambda: driving(terminal) and "ACTING" in terminal.text)
        terminal.type("\x1b")
        terminal.until(lambda: last(terminal, "action.finished").get("outcome") == "interrupted")
        terminal.until(lambda: last(terminal, "robot.state").get("moving") is False and "READY" in terminal.text)
        assert 0.01 < last(terminal, "robot.state")["pose"]["y"] < 1.9
        children = psutil.Process(terminal.pid).children(recursive=True)
        terminal.type(TO_THE_PANES + "q")
        assert terminal.wait() == 0
    assert psutil.wait_procs(children, timeout=10)[1] == []


def test_quitting_in_mid_drive_asks_first_and_leaves_nothing_behind(tmp_path: Path) -> None:
    with console(state=tmp_path) as terminal:
        terminal.until(lambda: "READY" in terminal.text)
        terminal.type("/")
        terminal.type("go to the bedroom\r")
        terminal.until(lambda: driving(terminal))
        children = psutil.Process(terminal.pid).children(recursive=True)
        terminal.type(TO_THE_PANES)
        terminal.until(lambda: "Press /" in terminal.text)
        terminal.type("q")
        terminal.until(lambda: "again" in terminal.text)
        terminal.type("q")
        assert terminal.wait() == 0
        assert last(terminal, "action.finished")["outcome"] == "interrupted"
        assert terminal.events()[-1]["kind"] == "session.ended"
    assert psutil.wait_procs(children, timeout=10)[1] == []


def test_a_terminal_that_is_too_small_says_so_and_still_stops(tmp_path: Path) -> None:
    with console(state=tmp_path, columns=40, rows=10) as terminal:
        terminal.until(lambda: "60" in terminal.text and "40" in terminal.text)
        terminal.until(lambda: any(event["body"].get("source") == "robot" for event in terminal.events()))
        terminal.type("\x1b[27u")  # escape, in a form that no key right behind it can belong to
        terminal.until(lambda: last(terminal, "interrupt.raised").get("scope") == "interrupt")
        terminal.type("q")
        assert terminal.wait() == 0


@pytest.mark.model
def test_the_demo_is_heard_and_driven(tmp_path: Path) -> None:
    with console("--demo", state=tmp_path) as terminal:
        terminal.until(lambda: "kitchen" in last(terminal, "transcript.final").get("text", "").lower())
        terminal.until(lambda: driving(terminal) or last(terminal, "action.finished"))
        terminal.type("\x1b")
        terminal.until(lambda: last(terminal, "robot.state").get("moving") is False)


def test_waking_without_a_microphone_says_what_is_missing_at_once(tmp_path: Path) -> None:
    with console("--set", "audio.device=no such device", state=tmp_path) as terminal:
        terminal.until(lambda: any(e["body"].get("source") == "microphone" for e in terminal.events()))
        terminal.until(lambda: any("recogniser" in str(e["body"].get("source")) for e in terminal.events()))
        terminal.type(" ")
        terminal.until(lambda: "Nobody can be heard without a microphone" in terminal.text)
        assert last(terminal, "error") == {}, "nothing was stopped, and nothing failed"
        terminal.type(TO_THE_PANES + "q")
        assert terminal.wait() == 0


def test_the_map_sends_the_robot_while_the_camera_shows_where_it_goes(tmp_path: Path) -> None:
    with console(state=tmp_path) as terminal:
        terminal.until(lambda: "READY" in terminal.text)
        terminal.type(TO_THE_PANES + "c")
        terminal.until(lambda: "▀" in terminal.text)
        terminal.type("m\t\r")
        terminal.until(lambda: "Go to the kitchen?" in terminal.text)  # it stands at the charging dock
        assert last(terminal, "transcript.final") == {}, "it has only been asked"
        terminal.type("\r")
        terminal.until(lambda: driving(terminal))
        assert last(terminal, "transcript.final")["text"] == "go to the kitchen"
        terminal.type("\x1b")
        terminal.until(lambda: last(terminal, "action.finished").get("outcome") == "interrupted")
        terminal.until(lambda: "READY" in terminal.text)  # else it asks whether to quit
        terminal.type("q")
        assert terminal.wait() == 0
