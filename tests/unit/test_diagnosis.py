"""The doctor examines everything, whatever becomes of one of its checks."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from config import load
from config.schema import Settings
from tui import cli
from tui.doctor import diagnosis
from tui.doctor.diagnosis import examine
from tui.doctor.finding import Check, Finding

SETTINGS = load(environ={})


def forbidden(settings: Settings) -> Finding:
    raise PermissionError(13, "Permission denied", "/forbidden/state")


def fine(settings: Settings) -> Finding:
    return Finding("fine", "ok", "as it should be")


@contextlib.contextmanager
def nobody() -> Iterator[None]:
    """Somebody who may enter no folder of others."""
    if os.geteuid() != 0:
        yield
        return
    os.setresuid(65534, 65534, 0)
    try:
        yield
    finally:
        os.setresuid(0, 0, 0)


def test_a_check_that_fails_is_told_with_the_reason_and_the_others_go_on(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(diagnosis, "CHECKS", (Check("event log", forbidden), Check("fine", fine)))
    failed, ok = examine(SETTINGS)
    assert (failed.name, failed.state) == ("event log", "missing")
    assert "Permission denied" in failed.detail
    assert "/forbidden/state" in failed.detail
    assert ok == fine(SETTINGS)
    assert cli.main(["doctor", "--json"]) == 0
    assert [json.loads(line)["name"] for line in capsys.readouterr().out.splitlines()] == ["event log", "fine"]


def test_a_state_folder_below_one_that_nobody_may_enter_is_not_writable(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    closed = tmp_path / "closed"
    (closed / "state").mkdir(parents=True)
    monkeypatch.setenv("SAYSO_STATE_DIR", str(closed / "state" / "sayso"))
    closed.chmod(0)
    try:
        with nobody():
            found = diagnosis._state_folder(SETTINGS)
    finally:
        closed.chmod(0o700)
    assert (found.name, found.state) == ("event log", "limited")
    assert "is not writable" in found.detail
