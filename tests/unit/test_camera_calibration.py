"""A camera is calibrated by pictures of a board: which of them are taken, the lens, and its place over the floor."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable

import cv2
import numpy as np
import pytest
import resvg_py

from engine.robot.calibration.chessboard import Chessboard, Pixels, View
from engine.robot.calibration.lens import MOST_BENT, MOST_UNSURE, lens_by
from engine.robot.calibration.place import place_by
from engine.robot.calibration.views import WANTED, Verdict, Views
from engine.robot.camera import Lens
from engine.robot.description import CameraOf
from tests.chessboard import BOARD, LENS, corners, held, on_the_floor, picture, ways

GUESS = Lens.of_view(640, 480, math.radians(40))
"""What the description says, which is wrong."""
EYE = CameraOf(depth=False, view=52, on_arm=False, at=(0.1, 0.0, 0.25), down=22)


def looked(views: Views, pixels: Iterable[Pixels], blur: float = 2.0) -> list[Verdict]:
    """What becomes of boards that are each seen twice, the second time."""
    found = []
    for one in pixels:
        views.look(View(one, blur))
        found.append(views.look(View(one, blur)))
    return found


# The board


def test_the_sheet_has_its_true_size() -> None:
    sheet = BOARD.sheet()
    assert 'width="297mm" height="210mm" viewBox="0 0 297 210"' in sheet
    squares = re.findall(r"M([\d.]+) ([\d.]+)h([\d.]+)v([\d.]+)h-25z", sheet)
    assert len(squares) == 35
    assert {(width, height) for _, _, width, height in squares} == {("25", "25")}
    assert "250 mm" in sheet
    assert BOARD.fits
    assert not Chessboard(11, 8, 0.025).fits


def test_what_is_printed_is_what_is_looked_for() -> None:
    page = cv2.imdecode(np.frombuffer(bytes(resvg_py.svg_to_bytes(BOARD.sheet(), dpi=90)), np.uint8), cv2.IMREAD_COLOR)
    assert page is not None
    view = BOARD.find(np.asarray(page, dtype=np.uint8))
    assert view is not None
    across = np.linalg.norm(np.diff(view.corners.reshape(6, 9, 2), axis=1), axis=2)
    assert across.mean() * 297 / page.shape[1] == pytest.approx(25, abs=0.1)


def test_corners_are_found_where_they_are() -> None:
    for placed in ways():
        view = BOARD.find(picture(placed))
        assert view is not None
        true = corners(placed)
        apart = min(np.abs(view.corners - way).max() for way in (true, true[::-1]))
        assert apart < 0.3


def test_a_board_that_is_cut_off_is_not_seen() -> None:
    assert BOARD.find(picture(held(right=0.25))) is None
    assert BOARD.find(picture(None)) is None


def test_a_picture_out_of_focus_is_blurred() -> None:
    sharp = picture(held())
    soft = np.asarray(cv2.GaussianBlur(sharp, (0, 0), 2.5), dtype=np.uint8)
    verdicts = []
    for one in (sharp, soft):
        views, view = Views(BOARD, GUESS), BOARD.find(one)
        views.look(view)
        verdicts.append(views.look(view))
    assert verdicts == ["taken", "blurred"]


# Which pictures are taken


def test_boards_that_are_held_in_many_ways_are_all_taken() -> None:
    views = Views(BOARD, GUESS)
    assert looked(views, map(corners, ways())) == ["taken"] * WANTED
    assert views.complete


def test_a_board_that_moves_is_not_taken_before_it_rests() -> None:
    views = Views(BOARD, GUESS)
    assert views.look(View(corners(held()), 2.0)) == "moving"
    assert views.look(View(corners(held(right=0.01)), 2.0)) == "moving"
    assert views.look(None) == "unseen"
    assert views.look(View(corners(held(right=0.01)), 2.0)) == "moving", "nobody knows how it came there"
    assert views.look(View(corners(held(right=0.0101)), 2.0)) == "taken"


def test_the_same_again_is_not_taken() -> None:
    views = Views(BOARD, GUESS)
    assert looked(views, [corners(held()), corners(held(right=0.02, yaw=4))]) == ["taken", "like before"]
    assert "held in one way only" in views.reason


def test_the_last_places_are_kept_for_boards_that_are_tilted_or_in_the_margins() -> None:
    views = Views(BOARD, GUESS)
    straight = [corners(held(away=away)) for away in (0.5, 0.62, 0.8, 1.0, 1.3, 1.7)]
    assert looked(views, straight) == ["taken"] * (WANTED - 8) + ["like before"] * 2
    told = [views.advice]
    for yaw, pitch in ((30, 0), (-30, 0), (0, 30), (0, -30)):
        assert looked(views, [corners(held(yaw=yaw, pitch=pitch))]) == ["taken"]
        told.append(views.advice)
    assert told[:4] == [f"tilt its {side} edge towards the camera" for side in ("left", "right", "upper", "lower")]
    assert told[4] == "bring it to the left margin of the picture"
    assert views.reason == f"Only 8 of {WANTED} pictures were taken: {told[4]}."
    assert looked(views, [corners(held(yaw=25, pitch=25))]) == ["like before"]
    margins = [held(-0.16), held(0.16), held(down=-0.13), held(down=0.13)]
    assert looked(views, map(corners, margins)) == ["taken"] * 4
    assert views.complete


def test_a_board_that_never_was_there_is_told_with_what_was_looked_for() -> None:
    views = Views(BOARD, GUESS)
    views.look(None)
    assert "never seen. It has 10 × 7 squares" in views.reason
    views.look(View(corners(held()), 2.0))
    assert "never seen sharp and still" in views.reason


# The lens


def seen(noise: float = 0.15, k1: float = 0.0) -> list[Pixels]:
    """The corners of all ways as a lens that bends lines shows them, not quite where they are."""
    chance, found = np.random.default_rng(7), []
    for axes, middle in ways():
        turn = cv2.Rodrigues(axes)[0]
        pixels = cv2.projectPoints(BOARD.points, turn, middle, LENS.matrix, np.array([k1, 0, 0, 0, 0.0]))[0]
        found.append(pixels.reshape(-1, 2) + chance.normal(0, noise, (len(BOARD.points), 2)))
    return found


def test_the_view_is_found() -> None:
    found = lens_by(BOARD, GUESS, seen())
    assert math.degrees(found.view) == pytest.approx(52, abs=0.2)
    assert found.unsure < math.radians(0.2)
    assert found.error == pytest.approx(0.15 * math.sqrt(2), rel=0.2)
    assert not found.poor
    assert found.bend < math.radians(0.2)


def test_a_lens_that_bends_lines_is_told() -> None:
    found = lens_by(BOARD, GUESS, seen(k1=-0.3))
    assert math.degrees(found.bend) == pytest.approx(6, abs=0.5)
    assert found.bend > MOST_BENT


def test_a_board_that_is_not_flat_is_not_the_lens() -> None:
    found = lens_by(BOARD, GUESS, seen(noise=2.0))
    assert found.poor
    assert found.bend < MOST_BENT


def test_boards_that_are_all_held_straight_leave_the_view_unsure() -> None:
    chance = np.random.default_rng(7)
    pixels = [corners(held(0.05 * n, 0, 0.5 + 0.1 * n)) + chance.normal(0, 0.3, (54, 2)) for n in range(5)]
    assert lens_by(BOARD, GUESS, pixels).unsure > MOST_UNSURE


# Its place


@pytest.mark.parametrize(("at", "down"), [((0.1, 0.0, 0.25), 22), ((0.0, 0.0, 0.5), 35), ((0.1, 0.0, 0.12), 8)])
def test_height_and_angle_are_found_by_a_board_on_the_floor(at: tuple[float, float, float], down: float) -> None:
    mount = EYE.model_copy(update={"at": at, "down": down}).mount
    view = BOARD.find(picture(on_the_floor(mount, ahead=0.3 + at[2])))
    assert view is not None
    place = place_by(BOARD, LENS, view.corners)
    assert place.height == pytest.approx(at[2], abs=0.005)
    assert math.degrees(place.down) == pytest.approx(down, abs=0.5)
    assert math.degrees(place.askew) == pytest.approx(0, abs=0.5)


def test_what_the_board_is_glued_to_counts() -> None:
    pixels = corners(on_the_floor(EYE.mount))
    assert place_by(BOARD, LENS, pixels, thickness=0.008).height == pytest.approx(0.258, abs=1e-3)


def test_a_camera_that_is_turned_about_its_line_of_sight_is_told() -> None:
    axes, middle = on_the_floor(EYE.mount)
    turned = cv2.Rodrigues((0.0, 0.0, math.radians(-6)))[0]  # the camera clockwise, the world the other way
    place = place_by(BOARD, LENS, corners((turned @ axes, turned @ middle)))
    assert math.degrees(place.askew) == pytest.approx(6 * math.cos(math.radians(22)), abs=0.5)
