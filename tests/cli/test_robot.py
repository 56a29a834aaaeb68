"""``sayso robot`` and what ``sayso doctor`` says of a motor board, with an emulated one."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

from config import paths
from engine.errors import ExitCode
from tests.board import Emulator
from tests.e2e.sayso import sayso
from tui.cli import main


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Emulator]:
    with Emulator(tmp_path_factory.mktemp("board")) as emulator:
        yield emulator


def on(board: Emulator) -> tuple[str, ...]:
    return ("--set", "robot.kind=rosmaster", "--set", f"robot.port={board.path}")


def test_robots_are_listed_with_what_they_have(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robot", "list", "--json"]) == ExitCode.DONE
    listed = {robot["name"]: robot for robot in map(json.loads, capsys.readouterr().out.splitlines())}
    assert {"sim", "x1", "x3", "x3plus", "r2"} <= listed.keys()
    assert listed["x3plus"]["has"] == ["arm", "base", "voice"]
    assert (listed["r2"]["drive"], listed["x3"]["has"]) == ("ackermann", ["base", "voice"])


def test_a_broken_file_hides_no_other_robot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("SAYSO_CONFIG_DIR", str(tmp_path))
    mine = paths().robots / "mine.yaml"
    mine.parent.mkdir()
    mine.write_text("name: mine\ndrive: hovercraft\n", "utf-8")
    assert main(["robot", "list"]) == ExitCode.DONE
    told = capsys.readouterr()
    assert "x3plus" in told.out
    assert "mine.yaml" in told.err


def test_a_robot_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robot", "show", "x3plus"]) == ExitCode.DONE
    told = capsys.readouterr().out
    assert "car type 2" in told
    assert "stops by itself when the line falls silent: not known" in told
    assert main(["robot", "show", "x3plsu"]) == ExitCode.USAGE
    assert "Did you mean x3plus?" in capsys.readouterr().err


def test_a_board_is_checked_and_nothing_moves(board: Emulator, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robot", "check", "--json", *on(board)]) == ExitCode.DONE
    found = json.loads(capsys.readouterr().out)["board"]
    assert (found["version"], found["car_type"], found["attitude"]) == ("3.5", 2, True)
    assert found["volts"] > 12
    assert len(found["servos"]) == 6
    assert board.until(lambda state: True)["told"] == {"vx": 0.0, "vy": 0.0, "wz": 0.0}


def test_a_port_that_is_not_there_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--set", "robot.kind=rosmaster", "--set", "robot.port=/dev/ttyNowhere"]
    assert main(["robot", "check", *options]) == ExitCode.MISSING
    assert "There is no serial port /dev/ttyNowhere." in capsys.readouterr().err


def test_a_board_needs_a_port(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["skills", "--set", "robot.kind=rosmaster"]) == ExitCode.USAGE
    assert "robot.port" in capsys.readouterr().err


def test_skills_are_offered_by_what_the_robot_has(board: Emulator, capsys: pytest.CaptureFixture[str]) -> None:
    def offered(*options: str) -> set[str]:
        assert main(["skills", "--json", *options]) == ExitCode.DONE
        return {json.loads(line)["name"] for line in capsys.readouterr().out.splitlines()}

    plus, plain = offered(*on(board)), offered(*on(board), "--set", "robot.model=x3")
    assert {"navigation", "arm_up"} <= plus
    assert "navigation" in plain
    assert "arm_up" not in plain
    assert "pick_object" not in plus


def test_a_model_that_does_not_go_with_the_kind_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["skills", "--set", "robot.model=x3"]) == ExitCode.USAGE
    assert "has a Rosmaster board, and robot.kind is sim" in capsys.readouterr().err


@pytest.mark.parametrize("stops_after", [None, "0.5"])
def test_the_doctor_finds_out_whether_a_board_stops_by_itself(tmp_path: Path, stops_after: str | None) -> None:
    arguments = () if stops_after is None else ("--stops-after", stops_after)
    with Emulator(tmp_path, *arguments) as board:
        done = sayso("doctor", "--wheels-up", *on(board), state=tmp_path, stdin=b"yes\n")
        assert done.returncode == ExitCode.DONE, done.stderr
        assert not any(board.until(lambda state: True)["told"].values()), "it is told to stand in any case"
    written = yaml.safe_load((tmp_path / "config" / "robots" / "x3plus.yaml").read_text("utf-8"))
    assert written["board"]["stops_by_itself"] == (stops_after is not None)
    shown = sayso("robot", "show", "x3plus", state=tmp_path)
    assert f"falls silent: {'yes' if stops_after else 'no'}".encode() in shown.stdout


def test_nothing_turns_before_somebody_has_said_yes(board: Emulator, tmp_path: Path) -> None:
    done = sayso("doctor", "--wheels-up", *on(board), state=tmp_path, stdin=b"\n")
    assert done.returncode == ExitCode.FAILED
    assert b"nothing was moved" in done.stderr


def test_the_emergency_stop_is_pressed_for_all_and_stays_until_it_is_released(tmp_path: Path) -> None:
    assert sayso("robot", "estop", state=tmp_path).returncode == ExitCode.DONE
    done = sayso("ask", "go forward 1 metre", state=tmp_path)
    assert done.returncode == ExitCode.FAILED
    assert b"The emergency stop is pressed: release it first." in done.stdout + done.stderr
    assert sayso("robot", "release", state=tmp_path).returncode == ExitCode.DONE
    assert sayso("ask", "go forward 1 metre", state=tmp_path).returncode == ExitCode.DONE


def test_driving_by_hand_needs_a_keyboard(tmp_path: Path) -> None:
    done = sayso("robot", "drive", state=tmp_path)
    assert done.returncode == ExitCode.USAGE
    assert b"needs a keyboard" in done.stderr


def test_a_place_that_was_named_is_known_at_once_and_in_later_sessions(tmp_path: Path) -> None:
    said = b"go forward 1 metre\nremember this place as the snack bar\ngo to the kitchen\ngo to the snack bar\n"
    done = sayso("ask", "-", state=tmp_path, stdin=said)
    assert b"I will remember this as the snack bar." in done.stdout
    assert b"I am at the snack bar." in done.stdout
    assert b"navigation" in sayso("plan", "go to the snack bar", state=tmp_path).stdout
    moved = sayso("ask", "-", state=tmp_path, stdin="把这里叫做厨房\nremember this spot as the study\n".encode())
    assert moved.returncode == ExitCode.DONE, moved.stderr
    kept = yaml.safe_load((tmp_path / "config" / "places" / "flat.yaml").read_text("utf-8"))
    assert {"snack bar", "study"} < kept.keys()
    (tmp_path / "config" / "places" / "flat.yaml").write_text("snack bar: [")
    broken = sayso("plan", "go to the snack bar", state=tmp_path)
    assert broken.returncode == ExitCode.MISSING
    assert b"Mend the file, or delete it." in broken.stderr
