"""``sayso robot calibrate``: wheels, steering and servos on an emulated board, and a camera by a film of it."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
import yaml

from engine.errors import ExitCode
from engine.robot.description import CameraOf
from tests.board import Emulator
from tests.chessboard import Picture, film, held, on_the_floor, picture, still, ways
from tests.cli.person import Person
from tests.e2e.sayso import sayso

EYE = CameraOf(depth=False, view=52, on_arm=False, at=(0.12, 0.0, 0.25), down=22)
"""What is before the films; what the description says of it is wrong."""


def on(board: Emulator) -> tuple[str, ...]:
    return ("--set", "robot.kind=rosmaster", "--set", f"robot.port={board.path}")


def described(folder: Path, *changes: tuple[str, str], model: str = "x3plus") -> Path:
    """The description ``mine``, which is this model's with these changes in its text."""
    text = (Path(str(files("assets"))) / "robots" / f"{model}.yaml").read_text("utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    file = folder / "config" / "robots" / "mine.yaml"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)
    return file


def read(file: Path) -> dict[str, Any]:
    found: dict[str, Any] = yaml.safe_load(file.read_text("utf-8"))
    return found


def test_wheels_are_calibrated_with_a_tape(tmp_path: Path) -> None:
    mine = described(tmp_path, ("radius: 0.04,", "radius: 0.044,"))  # the board's wheels have 0.04
    with Emulator(tmp_path) as board:
        person = Person(tmp_path, "wheels", *on(board), "--set", "robot.model=mine")
        person.asked("Enter begins")
        person.answers("")
        was = board.until(lambda state: True)["x"]
        for _ in range(4):
            person.asked("how far has it come")
            now = board.until(lambda state: not any(state["told"].values()))["x"]
            person.answers("nonsense")
            person.asked("measure again")
            person.answers(f"{100 * abs(now - was):.1f} cm")
            was = now
        assert person.ends() == ExitCode.DONE
    written = read(mine)
    assert written["wheels"]["radius"] == pytest.approx(0.04, abs=0.0005)
    assert "4 drives of 1 m; -" in written["calibrated"]["wheels"]


def test_servos_are_calibrated_by_eye(tmp_path: Path) -> None:
    with Emulator(tmp_path) as board:
        person = Person(tmp_path, "servos", *on(board))
        person.asked("Enter begins")
        for answer in ("", "", "", "-4.5", "", ""):
            person.answers(answer)
        assert person.ends() == ExitCode.DONE
    written = read(tmp_path / "config" / "robots" / "x3plus.yaml")
    assert written["arm"]["joints"]["elbow"]["servo"]["zero"] == 85.5, "its servo turns the other way"
    assert "1 of 5 were off" in written["calibrated"]["servos"]


def test_nothing_is_written_when_nobody_answers(tmp_path: Path) -> None:
    with Emulator(tmp_path) as board:
        done = sayso("robot", "calibrate", "wheels", *on(board), state=tmp_path, stdin=b"\n")
    assert done.returncode == ExitCode.USAGE
    assert not (tmp_path / "config" / "robots").exists()


# Steering


def test_a_robot_that_pulls_is_calibrated_and_then_drives_straight(tmp_path: Path) -> None:
    mine = described(tmp_path)
    with Emulator(tmp_path, "--pull", "0.1") as board:
        options = ("steering", *on(board), "--set", "robot.model=mine", "--runs", "2")
        person = Person(tmp_path, *options)
        person.asked("Enter begins")
        assert "1 m free ahead and 0.5 m on either side" in person.heard
        assert not any(board.until(lambda state: True)["told"].values()), "it has not been told to begin"
        person.answers("")
        assert person.ends() == ExitCode.DONE, person.heard
        written = read(mine)
        assert written["trim"] == pytest.approx(-0.1, abs=0.01)
        assert "2 times 0.6 m ahead and back; +0.1" in written["calibrated"]["steering"]

        yaw = board.until(lambda state: True)["yaw"]
        again = Person(tmp_path, *options, "--yes")
        board.until(lambda state: state["told"]["vx"] > 0.1)
        ahead = board.until(lambda state: not state["told"]["vx"])
        assert ahead["yaw"] == pytest.approx(yaw, abs=0.006), "it turned by 0.06 rad before"
        assert again.is_interrupted() == ExitCode.INTERRUPTED
        board.until(lambda state: not any(state["told"].values()))
    assert read(mine) == written, "what was not measured to the end is not written"


def test_nothing_is_driven_while_the_emergency_stop_is_pressed(tmp_path: Path) -> None:
    with Emulator(tmp_path) as board:
        assert sayso("robot", "estop", state=tmp_path).returncode == ExitCode.DONE
        done = sayso("robot", "calibrate", "steering", "--yes", *on(board), state=tmp_path)
        assert done.returncode == ExitCode.MISSING
        assert b"The emergency stop is pressed." in done.stderr
        assert not any(board.until(lambda state: True)["told"].values())
    assert not (tmp_path / "config" / "robots").exists()


# Camera


def before(folder: Path, pictures: Iterator[Picture], *options: str) -> tuple[str, ...]:
    """The command, with a camera that shows this."""
    device = film(folder / "film.avi", pictures)
    board = ("--set", "robot.kind=rosmaster", "--set", "robot.port=/dev/ttyNowhere", "--set", "robot.model=mine")
    return ("camera", *board, "--set", f"robot.camera.device={device}", *options)


def shown(stale: int = 4) -> Iterator[Picture]:
    """A person who fetches the board, holds it in all ways, and lays it on the floor; then come some ``stale`` pictures
    of before."""
    yield from [picture(None)] * 8
    yield from still(ways())
    yield from [picture(held(yaw=50))] * stale
    yield from [picture(on_the_floor(EYE.mount, ahead=0.6))] * 4


CAMERA = "camera: {depth: false, view: 45, on_arm: false, at: [0.12, 0.0, 0.3], down: 10}\n"


def test_a_camera_is_calibrated_by_a_board_in_the_hand_and_on_the_floor(tmp_path: Path) -> None:
    mine = described(tmp_path, ("drive: mecanum\n", f"drive: mecanum\n{CAMERA}"))
    person = Person(tmp_path, *before(tmp_path, shown()))
    person.asked("Enter begins")
    person.answers("")
    person.asked("1 of 12; tilt its right edge towards the camera")
    person.asked("12 of 12")
    person.asked("Enter goes on")
    person.answers("")
    assert person.ends() == ExitCode.DONE, person.heard
    camera = read(mine)["camera"]
    assert camera["view"] == pytest.approx(EYE.view, abs=0.5)
    assert camera["down"] == pytest.approx(EYE.down, abs=0.5)
    assert camera["at"] == [0.12, 0.0, pytest.approx(EYE.at[2], abs=0.005)]
    note = read(mine)["calibrated"]["camera"]
    assert "reprojection error 0." in note
    assert note.endswith("px of 640 × 480; height and angle by a board on the floor")
    assert f"camera.down {camera['down']:g}° (it was 10)" in person.found


def test_a_board_that_does_not_lie_on_the_floor_is_told(tmp_path: Path) -> None:
    mine = described(tmp_path, ("drive: mecanum\n", f"drive: mecanum\n{CAMERA}"))
    done = sayso("robot", "calibrate", *before(tmp_path, shown(stale=8), "--yes"), state=tmp_path)
    assert done.returncode == ExitCode.MISSING
    assert b"it does not lie on the floor. Only the view was written." in done.stderr
    assert read(mine)["camera"]["view"] == pytest.approx(EYE.view, abs=0.5)
    assert read(mine)["camera"]["down"] == 10


def test_of_a_camera_on_the_arm_the_lens_alone_is_calibrated(tmp_path: Path) -> None:
    mine = described(tmp_path, ("drive: mecanum\n", "drive: mecanum\ncamera: {depth: false, view: 45}\n"))
    done = sayso("robot", "calibrate", *before(tmp_path, shown(), "--yes"), state=tmp_path)
    assert done.returncode == ExitCode.DONE, done.stderr
    assert b"where it is there (arm.eye) is not calibrated" in done.stderr
    assert read(mine)["camera"] == {"depth": False, "view": pytest.approx(EYE.view, abs=0.5)}


def test_a_board_that_is_never_seen_or_held_in_one_way_is_told(tmp_path: Path) -> None:
    mine = described(tmp_path, ("drive: mecanum\n", f"drive: mecanum\n{CAMERA}"))
    text = mine.read_text()
    for pictures, told in (
        ([picture(None)] * 80, "4 s are over. The board was never seen. It has 10 × 7 squares"),
        ([picture(held())] * 80, "4 s are over. The board was held in one way only."),
    ):
        done = sayso("robot", "calibrate", *before(tmp_path, iter(pictures), "--yes", "--timeout=4"), state=tmp_path)
        assert done.returncode == ExitCode.TIMEOUT
        assert told in done.stderr.decode()
    assert "sayso: tilt its left edge towards the camera" in done.stderr.decode(), "it was told meanwhile"
    assert mine.read_text() == text


def test_a_camera_that_goes_is_told_with_what_is_still_missing(tmp_path: Path) -> None:
    described(tmp_path, ("drive: mecanum\n", f"drive: mecanum\n{CAMERA}"))
    done = sayso("robot", "calibrate", *before(tmp_path, iter([picture(held())] * 20), "--yes"), state=tmp_path)
    assert done.returncode == ExitCode.MISSING
    assert "delivers no more pictures. The board was held in one way only." in done.stderr.decode()


def test_without_a_camera_there_is_nothing_to_calibrate(tmp_path: Path) -> None:
    command = before(tmp_path, iter([picture(None)]), "--yes")
    described(tmp_path)
    done = sayso("robot", "calibrate", *command, state=tmp_path)
    assert done.returncode == ExitCode.USAGE
    assert b"is described without a camera" in done.stderr
    described(tmp_path, ("drive: mecanum\n", f"drive: mecanum\n{CAMERA}"))
    done = sayso("robot", "calibrate", *command, "--set", "robot.camera.device=null", state=tmp_path)
    assert done.returncode == ExitCode.USAGE
    assert b"No camera is configured." in done.stderr
    for device, told in (("kinect", "There is no camera called 'kinect'."), ("/dev/video99", "cannot be opened")):
        done = sayso("robot", "calibrate", *command, "--set", f"robot.camera.device={device}", state=tmp_path)
        assert done.returncode == ExitCode.MISSING
        assert told in done.stderr.decode()


def test_pictures_that_are_squeezed_are_told(tmp_path: Path) -> None:
    described(tmp_path, ("drive: mecanum\n", f"drive: mecanum\n{CAMERA}"))
    size = ("--set", "robot.camera.width=320", "--set", "robot.camera.height=180")
    done = sayso("robot", "calibrate", *before(tmp_path, iter([picture(None)] * 3)), *size, state=tmp_path)
    assert done.returncode == ExitCode.USAGE
    assert "640 × 480" in done.stderr.decode()
    assert "robot.camera.height: 240 keeps its shape" in done.stderr.decode()


def test_the_board_to_print_is_written(tmp_path: Path) -> None:
    sheet = tmp_path / "board.svg"
    done = sayso("robot", "calibrate", "camera", "--sheet", str(sheet), state=tmp_path)
    assert done.returncode == ExitCode.DONE
    assert "Print it at 100 %" in done.stderr.decode()
    assert 'width="297mm"' in sheet.read_text("utf-8")
    done = sayso("robot", "calibrate", "camera", "--sheet", str(sheet), "--square=30", state=tmp_path)
    assert done.returncode == ExitCode.USAGE
    assert "10 × 7 squares of 30 mm do not fit on A4." in done.stderr.decode()
