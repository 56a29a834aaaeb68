"""``sayso scene``: the scenes as data, as a picture in the terminal, and as a file."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import pytest

from engine.errors import ExitCode
from tests.e2e.sayso import sayso
from tui.cli import main


def test_scenes_are_listed_with_what_is_in_them(tmp_path: Path) -> None:
    done = sayso("scene", "list", "--json", state=tmp_path)
    assert done.returncode == ExitCode.DONE, done.stderr
    listed = {scene["name"]: scene for scene in map(json.loads, done.stdout.splitlines())}
    assert {"flat", "workshop", "clutter-SEED"} <= listed.keys()
    assert (listed["flat"]["rooms"], listed["flat"]["things"]) == (5, 11)


def test_a_scene_is_shown_as_data_and_written_as_a_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "workshop.png"
    assert main(["scene", "show", "workshop", "--json", "--png", str(file)]) == ExitCode.DONE
    shown = json.loads(capsys.readouterr().out)
    assert shown["things"]["block 5"]["stands_on"] == "block 4"
    assert next(place["name"] for place in shown["places"].values()) == "workshop"
    picture = cv2.imread(str(file))
    assert picture is not None
    assert picture.shape == (650, 950, 3)


def test_without_colours_a_scene_is_told_in_words(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["scene", "show", "clutter-1"]) == ExitCode.DONE
    told = capsys.readouterr().out
    assert "\x1b" not in told
    assert "▀" not in told
    assert "low table" in told


def test_in_a_terminal_it_is_a_picture_as_wide_as_that(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in {
        "FORCE_COLOR": "1",
        "COLORTERM": "truecolor",
        "TERM": "xterm-256color",
        "COLUMNS": "80",
    }.items():
        monkeypatch.setenv(name, value)
    monkeypatch.delenv("NO_COLOR", raising=False)
    assert main(["scene", "show", "flat"]) == ExitCode.DONE
    lines = capsys.readouterr().out.splitlines()
    rows = [line for line in lines if "▀" in line]
    assert len(rows) > 25
    assert all(75 <= row.count("▀") <= 80 for row in rows)


@pytest.mark.parametrize(
    ("arguments", "code"),
    [(["show", "attic"], ExitCode.USAGE), (["show", "flat", "--png", "/no/such/folder/flat.png"], ExitCode.MISSING)],
)
def test_what_cannot_be_shown_or_written_says_so(
    arguments: list[str], code: ExitCode, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["scene", *arguments]) == code
    assert capsys.readouterr().err.startswith("sayso: ")
