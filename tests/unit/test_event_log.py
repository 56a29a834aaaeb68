"""The event log: nothing published is lost, nobody else reads it, and it never ends a session."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from engine.bus import Bus
from engine.clock import SystemClock
from engine.errors import StorageError
from engine.event_log import EventLog
from engine.events import Log, from_json


def bus_with_log(folder: Path, *, max_bytes: int = 1_000_000, keep: int = 5) -> tuple[Bus, EventLog, Path]:
    bus = Bus(SystemClock())
    log = EventLog(folder, bus.session, max_bytes=max_bytes, keep=keep)
    path = log.open()
    bus.subscribe(log.write)
    return bus, log, path


def test_every_event_is_in_the_file_as_soon_as_it_is_published(tmp_path: Path) -> None:
    bus, _, path = bus_with_log(tmp_path)
    for number in range(3):
        bus.publish(Log("info", "test", f"line {number}"))
        assert [from_json(line).seq for line in path.read_bytes().splitlines()] == list(range(1, number + 2))


def test_only_the_owner_can_read_it(tmp_path: Path) -> None:
    _, _, path = bus_with_log(tmp_path / "state")
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700


def test_a_long_session_goes_on_in_another_file(tmp_path: Path) -> None:
    bus, _, path = bus_with_log(tmp_path, max_bytes=1000)
    for number in range(20):
        bus.publish(Log("info", "test", f"line {number}"))
    files = sorted(tmp_path.glob("*.jsonl"))
    assert len(files) > 1
    assert all(file.stat().st_size <= 1000 for file in files)
    lines = [line for file in files for line in file.read_bytes().splitlines()]
    assert sorted(from_json(line).seq for line in lines) == list(range(1, 21))
    assert path in files


def test_old_logs_make_room_for_new_ones(tmp_path: Path) -> None:
    for age in range(8):
        old = tmp_path / f"old{age}.jsonl"
        old.touch()
        os.utime(old, (age, age))
    bus_with_log(tmp_path, keep=3)
    assert {file.name for file in tmp_path.glob("old*")} == {"old6.jsonl", "old7.jsonl"}


def test_a_long_session_makes_room_for_itself(tmp_path: Path) -> None:
    (tmp_path / "old.jsonl").touch()
    bus, _, _ = bus_with_log(tmp_path, max_bytes=1000, keep=2)
    for number in range(60):
        bus.publish(Log("info", "test", f"line {number}"))
    files = list(tmp_path.glob("*.jsonl"))
    assert len(files) == 2
    assert 60 in [from_json(line).seq for file in files for line in file.read_bytes().splitlines()]


def test_an_old_log_that_another_engine_removes_meanwhile_is_no_fault(tmp_path: Path) -> None:
    (tmp_path / "gone.jsonl").symlink_to(tmp_path / "nowhere")  # listed, but not there any more
    bus, _, path = bus_with_log(tmp_path)
    bus.publish(Log("info", "test", "written"))
    assert len(path.read_bytes().splitlines()) == 1


def test_a_log_that_cannot_be_begun_leaves_nothing_open(tmp_path: Path) -> None:
    (tmp_path / "folder.jsonl").mkdir()  # cannot be removed like a file
    log = EventLog(tmp_path, "x", max_bytes=1000, keep=1)
    with pytest.raises(StorageError, match="cannot be written"):
        log.open()
    assert log._fd is None


def test_a_folder_that_cannot_be_made_is_a_clear_error(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(StorageError, match="cannot be written"):
        EventLog(tmp_path / "file" / "logs", "x", max_bytes=1000, keep=3).open()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full, a device that is always full")
def test_a_full_disk_ends_the_log_and_is_reported_once(tmp_path: Path) -> None:
    bus, log, path = bus_with_log(tmp_path)
    log._fd = os.open("/dev/full", os.O_WRONLY)  # the one device that is full on demand
    reported: list[StorageError] = []
    log.on_error = reported.append
    for _ in range(3):
        bus.publish(Log("info", "test", "lost"))
    assert len(reported) == 1
    assert "No space left" in str(reported[0])
    assert path.exists()
