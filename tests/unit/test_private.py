"""Folders that are this user's alone."""

from __future__ import annotations

import os
import stat
import subprocess
from pathlib import Path

import pytest

from config.private import NotPrivate, private_folder
from config.writing import write_whole
from engine.errors import ExitCode
from tests.e2e.sayso import command, environment


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.parametrize("umask", [0, 0o022, 0o277, 0o777])
def test_a_new_folder_and_those_above_it_are_private_under_any_umask(tmp_path: Path, umask: int) -> None:
    before = os.umask(umask)
    try:
        private_folder(tmp_path / "a" / "state" / "logs")
        write_whole(tmp_path / "b" / "state" / "file", b"")
    finally:
        os.umask(before)
    folders = [path for path in tmp_path.rglob("*") if path.is_dir()]
    assert len(folders) == 5
    assert {mode(folder) for folder in folders} == {0o700}


def test_a_folder_of_ours_that_others_may_use_is_taken_from_them(tmp_path: Path) -> None:
    folder = tmp_path / "state"
    folder.mkdir(0o755)
    private_folder(folder, {"logs"})
    assert mode(folder) == 0o700
    folder.chmod(0o777)
    (folder / "logs").mkdir()
    private_folder(folder, {"logs"})
    assert mode(folder) == 0o700


def test_a_folder_that_is_for_others_too_is_left_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "theirs").touch()
    tmp_path.chmod(0o755)
    with pytest.raises(NotPrivate, match="chmod 700"):
        private_folder(tmp_path, {"logs"})
    assert mode(tmp_path) == 0o755


def test_a_link_and_a_folder_of_another_user_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "folder")
    with pytest.raises(NotPrivate, match="symbolic link"):
        private_folder(tmp_path / "link")
    monkeypatch.setattr(os, "geteuid", lambda: 65_534)
    with pytest.raises(NotPrivate, match="another user"):
        private_folder(tmp_path / "folder")


@pytest.mark.parametrize("arguments", [("ask", "beep"), ("engine",), ("--web",)])
def test_no_command_keeps_anything_behind_a_link(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "folder")
    environ = {**environment(tmp_path), "SAYSO_STATE_DIR": str(tmp_path / "link")}
    done = subprocess.run(command(*arguments), env=environ, capture_output=True, check=False, stdin=subprocess.DEVNULL)
    assert done.returncode == ExitCode.MISSING
    assert b"symbolic link; name the folder itself with SAYSO_STATE_DIR" in done.stderr
    assert [*(tmp_path / "folder").iterdir()] == []
