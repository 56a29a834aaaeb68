"""Marks and people in real pictures: tags, landmarks, tape, QR codes, figures; and driving by landmarks."""

from __future__ import annotations

import asyncio
import math
from dataclasses import replace

import numpy as np
import pytest

from engine.errors import CameraError
from engine.perception.landmarks import Fix, where
from engine.perception.line import find_line, tape_points
from engine.perception.localise import Localiser, replaced
from engine.perception.memory import WorldMemory
from engine.perception.person import find_people
from engine.perception.qr import find_qr
from engine.perception.sighting import Sight, Sighting
from engine.perception.tags import find_tags
from engine.robot.arm import ARM_INITIAL, Joints
from engine.robot.camera import Picture
from engine.robot.geometry import Pose, wrap
from engine.robot.robot import RobotState
from engine.robot.sim.floor import floor_map
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_parts import LandmarkTag, LooseObject, Person, Poster
from engine.skills.travel import go_to
from tests.sim.eye import Eye
from tests.sim.inhand import HandRobot, context_of
from tests.sim.rig import flat, places

LEVEL: Joints = (0.0, -1.1, 1.85, 0.77, 0.0)
"""Folded, the camera a little below the horizon."""
DOWN: Joints = (0.0, -1.1, 1.85, 1.6, 0.0)
"""Folded, looking at the floor before the hull."""


def flat_with(**changes: object) -> Scene:
    return flat().model_copy(update=changes)


def hall_with(*landmarks: LandmarkTag) -> Scene:
    return flat_with(landmarks=landmarks)


# Tags


def a_block(**changes: object) -> Scene:
    block = LooseObject.model_validate({"kind": "tag_block", "at": (0.5, 0.3), "size": 0.045, "tag": 7, **changes})
    return flat_with(objects={"block 7": block}, landmarks=())


def before(eye: Eye, name: str, away: float, aside: float) -> Pose:
    """Where the camera is ``away`` from a thing, seeing its side at an angle."""
    x, y, _ = eye.where(name)
    reach = away + 0.04
    return Pose(x - reach * math.cos(aside), y - reach * math.sin(aside), aside)


@pytest.mark.parametrize(("width", "away"), [(160, 0.3), (160, 0.36), (320, 0.3), (320, 0.65)])
@pytest.mark.parametrize("aside", [0, 25])
def test_a_block_is_read_and_placed_within_a_centimetre(width: int, away: float, aside: int) -> None:
    eye = Eye(a_block(), width=width, height=width * 3 // 4)
    eye.put("block 7", 0.5, 0.3, 0.28)
    tags = find_tags(eye.look(before(eye, "block 7", away, math.radians(aside))))
    assert {tag.id for tag in tags} == {7}
    tag = min(tags, key=lambda tag: tag.normal[0])  # its other side may show as well
    x, y, z = eye.where("block 7")
    assert tag.position == pytest.approx((x - 0.0225, y, z + 0.0225), abs=0.01)
    assert tag.normal == pytest.approx((-1.0, 0.0, 0.0), abs=0.03)
    assert tag.size == pytest.approx(0.036)


def test_a_tag_turned_upside_down_and_leaning_has_its_corners_where_its_face_is() -> None:
    eye = Eye(a_block(), width=320, height=240)
    eye.put("block 7", 0.5, 0.3, 0.28, yaw=0.3)
    picture = eye.look(Pose(0.1, 0.3, 0.0))
    [tag] = find_tags(picture)
    # The corners are those of a square around the position, at right angles to the normal.
    right = np.cross((0.0, 0.0, 1.0), tag.normal)
    square = [np.array(tag.position) + tag.size / 2 * (u * right + np.array([0, 0, v]))
              for u, v in ((-1, 1), (1, 1), (1, -1), (-1, -1))]  # fmt: skip
    assert np.abs(picture.pixels(picture.from_map(np.array(square))) - tag.corners).max() < 1.5


def test_bare_walls_and_furniture_carry_no_tags() -> None:
    eye = Eye(flat_with(landmarks=(), objects={}))
    for pose in places().values():
        assert find_tags(eye.look(pose)) == ()


def test_a_tag_without_depth_is_placed_by_its_size() -> None:
    eye = Eye(a_block(), width=320, height=240)
    eye.put("block 7", 0.5, 0.3, 0.28)
    seen = eye.look(Pose(0.1, 0.3, 0.0))
    [tag] = find_tags(without_depth(seen))
    x, y, _ = eye.where("block 7")
    assert tag.position[:2] == pytest.approx((x - 0.0225, y), abs=0.03)


def without_depth(picture: Picture) -> Picture:
    nothing = np.full_like(picture.depth, np.inf)
    return Picture(picture.t, picture.rgb, nothing, picture.lens, picture.mount, picture.pose)


# Where the robot is


EAST = LandmarkTag(id=120, at=(2.0, 0.845), z=0.4, facing=270, size=0.24)
WEST = LandmarkTag(id=121, at=(1.2, 0.845), z=0.4, facing=270, size=0.24)


def fix_from(eye: Eye, true: Pose, believed: Pose) -> Fix | None:
    marks = floor_map(eye.scene).tags
    picture = eye.look(true, believed=believed)
    return where(find_tags(picture, marks), picture, marks)


def assert_near(pose: Pose, true: Pose, metres: float, degrees: float) -> None:
    assert pose.distance_to(true) < metres, (pose, true)
    assert abs(math.degrees(wrap(pose.yaw - true.yaw))) < degrees, (pose, true)


@pytest.mark.parametrize(
    "true", [Pose(1.0, -0.5, 1.0), Pose(1.6, -0.6, 1.4), Pose(2.4, -0.4, 1.9), Pose(0.8, 0.0, 0.6)]
)
def test_landmarks_tell_the_true_pose_whatever_is_believed(true: Pose) -> None:
    eye = Eye(hall_with(EAST, WEST))
    fix = fix_from(eye, true, Pose(true.x - 0.7, true.y + 0.3, wrap(true.yaw + 0.6)))
    assert fix is not None
    assert_near(fix.pose, true, 0.02, 1.0)
    assert fix.sigma < 0.05


def test_without_a_landmark_there_is_no_fix() -> None:
    assert fix_from(Eye(hall_with(EAST)), Pose(0.0, 0.0, math.pi), Pose(0.0, 0.0, math.pi)) is None


def test_a_block_with_the_number_of_a_landmark_is_none() -> None:
    eye = Eye(a_block().model_copy(update={"landmarks": (LandmarkTag.model_construct(
        id=7, at=(4.9, 0.0), z=0.3, facing=180, size=0.24),)}))  # fmt: skip
    eye.put("block 7", 0.5, 0.3, 0.28)
    true = Pose(0.12, 0.3, 0.0)
    assert [tag.id for tag in find_tags(eye.look(true), floor_map(eye.scene).tags)] == [7]
    assert fix_from(eye, true, true) is None


def test_two_landmarks_that_contradict_each_other_give_no_fix() -> None:
    eye = Eye(hall_with(EAST, WEST))
    true = Pose(1.6, -0.75, math.pi / 2)
    marks = floor_map(eye.scene).tags
    picture = eye.look(true, LEVEL)
    tags = find_tags(picture, marks)
    assert {tag.id for tag in tags} == {120, 121}
    moved = floor_map(hall_with(EAST.model_copy(update={"at": (2.6, 0.845)}), WEST)).tags
    assert where(tags, picture, marks) is not None
    assert where(tags, picture, moved) is None


def fix_at(pose: Pose, sigma: float = 0.01) -> Fix:
    return Fix(pose, np.diag([sigma**2, sigma**2, math.radians(0.5) ** 2]), 1)


def test_a_fix_weighs_more_the_farther_odometry_has_gone() -> None:
    def correction(way: float) -> float:
        localiser = Localiser()
        localiser.update(0.0, Pose(0, 0, 0), fix_at(Pose(0, 0, 0), 0.002))
        return localiser.update(1.0, Pose(way, 0, 0), fix_at(Pose(way, 0.02, 0))).y

    assert 0 < correction(0.1) < correction(1.0) < correction(4.0) < 0.02


def test_a_jump_is_believed_when_a_second_picture_agrees() -> None:
    localiser = Localiser()
    assert localiser.update(0.0, Pose(0, 0, 0), fix_at(Pose(2, 0, 0))) == Pose(0, 0, 0)
    assert_near(localiser.update(0.5, Pose(0.3, 0, 0), fix_at(Pose(2.3, 0, 0))), Pose(2.3, 0, 0), 0.001, 0.1)


def test_two_jumps_to_different_places_are_not_believed() -> None:
    localiser = Localiser()
    localiser.update(0.0, Pose(0, 0, 0), fix_at(Pose(2, 0, 0)))
    assert localiser.update(0.5, Pose(0, 0, 0), fix_at(Pose(0, 3, 0))) == Pose(0, 0, 0)


def test_what_was_seen_moves_along_with_a_correction() -> None:
    picture = Eye(hall_with(EAST)).look(Pose(1.8, -0.6, 1.4))
    ball = Sighting("ball", "red", (0, 0, 9, 9), (1.8, 0.4, 0.03), 0.01, (0.06, 0.06), 1.0, 0.0)
    sight = replaced(Sight(picture, (ball,), find_tags(picture, ())), Pose(0.0, 0.0, 1.4 - math.pi / 2))
    assert sight.objects[0].position == pytest.approx((1.0, 0.0, 0.03), abs=1e-6)
    assert all(np.hypot(*tag.normal[:2]) == pytest.approx(1, abs=0.02) for tag in sight.tags)


def test_looking_out_keeps_the_belief_within_five_centimetres_and_three_degrees() -> None:
    async def tour(looking: bool) -> list[tuple[float, float]]:
        robot = HandRobot(odometry_noise=0.02, seed=1)
        robot.capabilities -= set() if looking else {"camera"}
        context, goals = context_of(robot, WorldMemory()), places()
        off = []

        def compare() -> None:
            believed, true = robot.state().pose, robot.world.true_pose
            off.append((believed.distance_to(true), abs(math.degrees(wrap(believed.yaw - true.yaw)))))

        robot.each_tick = compare
        for symbol in "CDT":
            await go_to(context, goals[symbol], symbol)
        return off

    looking = np.array(asyncio.run(tour(True)))
    blind = np.array(asyncio.run(tour(False)))
    assert (np.max(looking, axis=0) < (0.05, 3.0)).all()
    assert (np.percentile(blind, 95, axis=0) > (0.05, 3.0)).all(), "the noise is too small to test anything"


def test_the_localiser_learns_how_wrong_odometry_is() -> None:
    localiser, believed, true = Localiser(), Pose(0, 0, 0), Pose(0, 0, 0)
    for leg in range(12):
        believed = localiser.update(float(leg), believed, fix_at(true, 0.005))
        # A metre ahead and a quarter turn, of which odometry counts 3 % too little.
        for way, turn in ((1.0, 0.0), (0.0, math.pi / 2)):
            true = driven(true, way, turn)
            believed = driven(believed, 0.97 * way, 0.97 * turn)
    assert believed.distance_to(true) > 0.02
    assert_near(localiser.update(12.0, believed, None), true, 0.01, 0.6)


def driven(pose: Pose, way: float, turn: float) -> Pose:
    return Pose(pose.x + way * math.cos(pose.yaw), pose.y + way * math.sin(pose.yaw), wrap(pose.yaw + turn))


def test_a_drive_goes_on_without_a_camera_and_says_so_once() -> None:
    class Blind(HandRobot):
        async def look(self) -> Picture:
            self.pictures += 1
            raise CameraError("The lens is dirty.")

    async def drive() -> None:
        robot, told = Blind(), []
        context = replace(
            context_of(robot, WorldMemory()), progress=lambda fraction, message="", **_: told.append(message)
        )
        result = await go_to(context, Pose(1.5, 0.0, 0.0), "there")
        assert result.ok, result
        assert robot.pictures == 1
        assert [message for message in told if "dirty" in message] == ["I drive without looking: The lens is dirty."]

    asyncio.run(drive())


def test_with_exact_odometry_looking_changes_hardly_anything() -> None:
    async def drive() -> None:
        robot = HandRobot(odometry_noise=0)
        goal = places()["T"]
        result = await go_to(context_of(robot, WorldMemory()), goal, "the kitchen door")
        assert result.ok, result
        assert robot.pictures > 1
        assert_near(robot.state().pose, robot.world.true_pose, 0.012, 0.7)

    asyncio.run(drive())


def test_a_drive_that_is_cut_while_it_looks_leaves_nothing_behind() -> None:
    class Slow(HandRobot):
        looking = 0

        async def look(self) -> Picture:
            self.looking += 1
            try:
                await asyncio.Event().wait()
                raise AssertionError("nobody sets it")
            finally:
                self.looking -= 1

        def state(self) -> RobotState:  # time goes on, as it does outside a simulation at full speed
            self.world.step()
            return super().state()

    async def drive() -> None:
        robot, far = Slow(), asyncio.Event()
        robot.each_tick = lambda: far.set() if robot.looking and robot.world.true_pose.x > 0.3 else None
        going = asyncio.create_task(go_to(context_of(robot, WorldMemory()), Pose(1.5, 0.0, 0.0), "there"))
        async with asyncio.timeout(60):
            await far.wait()
        going.cancel()
        with pytest.raises(asyncio.CancelledError):
            await going
        assert robot.looking == 0

    asyncio.run(drive())


# Tape


@pytest.mark.parametrize("width", [160, 320])
@pytest.mark.parametrize(("y", "yaw"), [(-0.35, 0.0), (-0.28, 0.15), (-0.45, -0.1)])
def test_the_tape_is_found_with_offset_and_heading(width: int, y: float, yaw: float) -> None:
    line = find_line(Eye(width=width, height=width * 3 // 4).look(Pose(-0.8, y, yaw)), "blue")
    assert line is not None
    assert line.offset == pytest.approx(-0.35 - y, abs=0.015)
    assert line.heading == pytest.approx(-yaw, abs=math.radians(2))
    assert line.confidence > 0.6
    assert not line.ends


def test_the_tape_is_traced_through_its_bends() -> None:
    eye = Eye(width=320, height=240)
    pose = Pose(0.0, -0.35, 0.0)
    line = find_line(eye.look(pose), "blue")
    assert line is not None
    x, y = (line.points + np.array((pose.x, pose.y))).T
    course = np.interp(x, *np.array(flat().lines["blue line"].points).T)
    assert x[-1] > 1.5
    assert np.abs(y - course).max() < 0.03


def test_the_tape_ends_where_it_ends() -> None:
    line = find_line(Eye().look(Pose(3.0, -0.35, 0.0)), "blue")
    assert line is not None
    assert line.ends
    assert line.points[-1] == pytest.approx((0.8, 0.0), abs=0.03)


def test_tape_that_leaves_the_picture_does_not_end_there() -> None:
    line = find_line(Eye().look(Pose(0.0, -0.35, 0.0), DOWN), "blue")
    assert line is not None
    assert not line.ends


@pytest.mark.parametrize("pose", [Pose(-0.9, 0.4, math.pi), Pose(0.2, 1.5, 1.57), Pose(0.6, -1.6, -1.2)])
def test_bare_floor_has_no_tape(pose: Pose) -> None:
    picture = Eye().look(pose)
    assert find_line(picture, "blue") is None
    assert len(tape_points(picture, "blue")) == 0


def test_a_tape_of_another_colour_is_not_the_one_that_is_wanted() -> None:
    picture = Eye().look(Pose(-0.8, -0.35, 0.0))
    assert find_line(picture, "red") is None


def test_points_of_tape_are_on_the_map_as_the_robot_believes_it_stands() -> None:
    picture = Eye().look(Pose(-0.8, -0.35, 0.0), believed=Pose(0.0, 0.0, math.pi / 2))
    tape = tape_points(picture, "blue")
    near = tape[np.hypot(*tape.T) < 1.2]
    assert np.abs(near[:, 0]).max() < 0.03
    assert near[:, 1].min() > 0.4


# QR codes


@pytest.mark.parametrize(
    ("width", "size", "away", "turn"), [(320, 0.45, 1.25, 0), (320, 0.25, 1.0, 35), (160, 0.3, 0.8, -30)]
)
def test_a_qr_code_says_its_text_and_where_it_is(width: int, size: float, away: float, turn: float) -> None:
    [code] = find_qr(poster_from(turn, away, size, width))
    assert code.text == "KITCHEN"
    assert code.position == pytest.approx((1.5, 0.845, 0.4), abs=0.02)
    assert code.normal == pytest.approx((0.0, -1.0, 0.0), abs=0.05)
    assert code.size == pytest.approx(size * 21 / 27, rel=0.03)


def test_a_qr_code_that_does_not_hang_upright_is_read_too() -> None:
    picture = poster_from(10, 1.0, 0.35, 320)
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    tilted = replace(picture, mount=replace(picture.mount, rotation=picture.mount.rotation @ quarter))
    assert [code.text for code in find_qr(tilted)] == ["KITCHEN"]


def poster_from(turn: float, away: float, size: float, width: int) -> Picture:
    """A poster on the north wall, seen from ``away`` m and ``turn`` degrees aside."""
    poster = Poster(text="KITCHEN", at=(1.5, 0.845), z=0.4, facing=270, size=size)
    eye = Eye(flat_with(posters=(poster,), landmarks=()), width=width, height=width * 3 // 4)
    aside = math.radians(turn)
    stand = Pose(1.5 - away * math.sin(aside), 0.845 - away * math.cos(aside), math.pi / 2 - aside)
    return eye.look(stand, LEVEL)


def test_tags_and_furniture_are_no_qr_codes() -> None:
    eye = Eye(width=320, height=240)
    for symbol in "ABCDE":
        assert find_qr(eye.look(places()[symbol])) == ()


# People


@pytest.mark.parametrize("joints", [ARM_INITIAL, LEVEL])
@pytest.mark.parametrize(("away", "facing"), [(1.2, 0), (1.6, 90), (2.2, 200)])
def test_a_person_is_seen_where_they_stand(joints: Joints, away: float, facing: float) -> None:
    eye = Eye(flat_with(people={"anna": Person(path=((-3.0, 0.0),), facing=facing)}))
    [person] = find_people(eye.look(Pose(-3.0 + away, 0.1, math.pi), joints), floor_map(eye.scene))
    assert person.kind == "person"
    assert person.position[:2] == pytest.approx((-3.0, 0.0), abs=0.12)
    assert 0.2 < person.size[0] < 0.7


def test_walls_wardrobes_and_chairs_are_nobody() -> None:
    eye = Eye()
    for pose in places().values():
        for joints in (ARM_INITIAL, LEVEL):
            believed = Pose(pose.x + 0.03, pose.y - 0.03, pose.yaw + 0.03)
            assert find_people(eye.look(pose, joints, believed), floor_map(eye.scene)) == ()


def test_a_chair_that_was_moved_is_nobody() -> None:
    chair = flat().furniture["west chair"].model_copy(update={"moved": (-3.0, 0.2)})
    eye = Eye(flat_with(furniture={**flat().furniture, "west chair": chair}))
    for away in (1.0, 1.5, 2.0):
        assert find_people(eye.look(Pose(-3.0 + away, 0.1, math.pi), LEVEL), floor_map(eye.scene)) == ()
