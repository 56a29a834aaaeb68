"""Whatever happens to one of engine, host and guard, or to the line, or to both at once: the board is told to stand.

The robot turns on the spot through an emulated board, which would turn on for ever; the board itself says what it was
told, and when. ``tests/bench/board.py`` has the times.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, Literal

import psutil
import pytest

from engine.serial_port import PortError, opened
from tests.board import Emulator, Turning

Process = Literal["engine", "host", "guard"]
PROCESSES: Final[tuple[Process, ...]] = ("engine", "host", "guard")
FULL_DISK: Final = Path(__file__).parents[1] / "full_disk"
LINE_FAULTS: Final = {
    "unplug": ("unplug", "plug", "was unplugged"),
    "silence": ("silence on", "silence off", "is silent"),
    "garbage": ("garbage on", "garbage off", None),
    "brownout": ("brownout on", "brownout off", "the battery is empty"),
}


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Emulator]:
    with Emulator(tmp_path_factory.mktemp("board")) as emulator:
        yield emulator


def turns(state: dict[str, Any]) -> bool:
    return abs(state["speed"]["wz"]) > 0.4


def stands(state: dict[str, Any]) -> bool:
    return not any(state["told"].values()) and abs(state["speed"]["wz"]) < 0.02


def turn(board: Emulator, turning: Turning) -> None:
    """Told to go until it goes: a board that comes back takes a moment to be ready, and says so."""
    for _ in range(10):
        turning.say("go")
        if board.comes_to(turns, 2.0):
            return
    raise AssertionError(f"it does not turn; its last state was {board.state}")


def stays(board: Emulator) -> None:
    """It stands, and goes on standing."""
    first = board.until(stands)
    board.until(lambda state: state["t"] > first["t"] + 0.6)
    assert stands(board.state)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "stopped"])
@pytest.mark.parametrize("process", PROCESSES)
def test_whichever_process_dies_or_hangs_the_board_is_told_to_stand(
    board: Emulator, process: Process, number: signal.Signals
) -> None:
    with Turning(board.path) as turning:
        turn(board, turning)
        struck = getattr(turning, process)
        struck.send_signal(number)
        stays(board) if process != "host" or number == signal.SIGKILL else board.until(stands)
        if process == "engine":
            return
        event = "lost" if process == "host" else "halted"
        why = turning.until(event)["why"]
        expected = {"host": ("The robot process",), "guard": ("the guard process was lost",)}[process]
        assert any(part in why for part in expected)
        if process == "host":
            turning.until("ready")
        turn(board, turning)
        turning.say("stop")
        stays(board)


@pytest.mark.parametrize("fault", LINE_FAULTS)
@pytest.mark.parametrize("process", PROCESSES)
def test_a_line_that_fails_and_a_process_that_dies_leave_a_board_that_stands(
    board: Emulator, process: Process, fault: str
) -> None:
    begin, end, told = LINE_FAULTS[fault]
    with Turning(board.path) as turning:
        turn(board, turning)
        board.tell(begin)
        if told is not None:
            assert told in turning.until("halted")["why"]
        if not (process == "guard" and fault == "unplug"):  # which has gone with the line
            getattr(turning, process).kill()
        board.tell(end)
        if process == "engine":
            board.until(stands) if fault != "unplug" else None
    if fault == "unplug":  # nobody was there to tell it: whoever comes next does, before anything else
        with Turning(board.path):
            stays(board)
    stays(board)


@pytest.mark.parametrize("fault", LINE_FAULTS)
def test_after_a_fault_of_the_line_it_goes_on_when_it_is_told_to(board: Emulator, fault: str) -> None:
    begin, end, told = LINE_FAULTS[fault]
    with Turning(board.path) as turning:
        turn(board, turning)
        board.tell(begin)
        if told is not None:
            assert told in turning.until("halted")["why"]
            board.tell(end)
            stays(board)
        turn(board, turning)
        board.tell(end)


@pytest.mark.parametrize("process", PROCESSES)
def test_a_second_program_on_the_port_is_told_and_harms_nothing(board: Emulator, process: Process) -> None:
    with Turning(board.path) as turning:
        turn(board, turning)
        with pytest.raises(PortError, match="Another program has the serial port") as refused:
            opened(str(board.path), "robot.port", "")
        assert refused.value.reason == "busy"
        assert turns(board.until(lambda state: True))
        getattr(turning, process).kill()
        stays(board)


@pytest.mark.parametrize("process", PROCESSES)
def test_on_a_full_disk_it_drives_and_stands_all_the_same(
    board: Emulator, process: Process, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((str(FULL_DISK), os.environ.get("PYTHONPATH", ""))))
    with Turning(board.path) as turning:
        turn(board, turning)
        getattr(turning, process).kill()
        stays(board)
        if process != "engine":
            turn(board, turning)


def test_a_host_that_hangs_while_its_engine_dies_is_ended_by_its_guard(board: Emulator) -> None:
    with Turning(board.path) as turning:
        turn(board, turning)
        engine, host, guard = turning.engine, turning.host, turning.guard
        host.suspend()
        engine.kill()
        assert psutil.wait_procs((host, guard), timeout=30)[1] == []
        stays(board)


def test_a_guard_that_hangs_does_not_keep_the_port_when_its_host_dies(board: Emulator) -> None:
    with Turning(board.path) as turning:
        turn(board, turning)
        guard = turning.guard
        guard.suspend()
        turning.host.kill()
        turning.until("ready")
        stays(board)
        assert psutil.wait_procs([guard], timeout=10)[1] == []
        turn(board, turning)


def test_a_host_that_hung_for_long_does_not_go_on_by_itself(board: Emulator) -> None:
    with Turning(board.path) as turning:
        turn(board, turning)
        host = turning.host
        host.suspend()
        first = board.until(stands)
        board.until(lambda state: state["t"] > first["t"] + 1.3)
        host.resume()
        assert "did not respond" in turning.until("halted")["why"]
        stays(board)
        turn(board, turning)


def test_without_a_guard_it_stands_until_there_is_one(board: Emulator) -> None:
    with Turning(board.path) as turning:
        turn(board, turning)
        host = turning.host
        usual = host.rlimit(psutil.RLIMIT_NOFILE)
        host.rlimit(psutil.RLIMIT_NOFILE, (3, usual[1]))
        turning.guard.kill()
        assert "the guard process was lost" in turning.until("halted")["why"]
        stays(board)
        turning.say("go")
        assert board.comes_to(turns, 1.0) is None
        host.rlimit(psutil.RLIMIT_NOFILE, usual)
        turn(board, turning)
