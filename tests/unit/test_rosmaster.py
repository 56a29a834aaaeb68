"""The Rosmaster board: its frames, its servos, its odometry, and the body that drives it, in virtual time."""

from __future__ import annotations

import itertools
import math
import random
import struct
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.errors import DeviceError
from engine.framing import Framer
from engine.robot.arm import ARM_UP
from engine.robot.description import described
from engine.robot.geometry import ZERO, Pose, Twist
from engine.robot.host.memory import STATE
from engine.robot.rosmaster import frames
from engine.robot.rosmaster.frames import (
    ArmAt,
    Attitude,
    CarType,
    Encoders,
    FromBoard,
    Order,
    Report,
    ServoAt,
    Speed,
    ToBoard,
    Version,
)
from engine.robot.rosmaster.odometry import Odometry, counts_of
from engine.robot.rosmaster.servos import Servos, degrees, pulse
from engine.robot.sim.dimensions import ARM, FOOTPRINT
from engine.serial_port import PortError
from tests.board import Bench, run, speed_in

FORWARD = Twist(0.2)


def test_the_simulated_robot_is_described_as_it_is_built() -> None:
    sim = described("sim")
    built, told = ARM, sim.arm_model
    assert sim.footprint == FOOTPRINT
    assert (told.shoulder, told.upper, told.fore, told.hand, told.eye) == (
        built.shoulder, built.upper, built.fore, built.hand, built.eye,
    )  # fmt: skip
    assert told.jaw == pytest.approx(built.jaw)
    assert [limit for pair in told.ranges for limit in pair] == pytest.approx(
        [limit for pair in built.ranges for limit in pair], abs=1e-3
    )


# Frames


def test_a_motion_frame_is_what_the_board_expects() -> None:
    expected = bytes.fromhex("FF FC 0A 12 01 FA 00 00 00 0C FE 21")
    assert frames.motion(1, Twist(0.25, 0.0, -0.5)) == expected


@pytest.mark.parametrize(
    ("kind", "data", "told"),
    [
        (frames.SPEED, struct.pack("<3hB", 250, -100, -500, 121), Speed(Twist(0.25, -0.1, -0.5), 12.1)),
        (frames.ATTITUDE, struct.pack("<3h", 100, -200, 15708), Attitude(0.01, -0.02, 1.5708)),
        (frames.ENCODERS, struct.pack("<4i", 1, -2, 3, -4), Encoders((1, -2, 3, -4))),
        (frames.SERVO, struct.pack("<Bh", 3, 2000), ServoAt(3, 2000)),
        (frames.ARM, struct.pack("<6h", 2000, 900, 3100, 2000, 1487, -1), ArmAt((2000, 900, 3100, 2000, 1487, -1))),
        (frames.CAR_TYPE, b"\x02", CarType(2)),
        (frames.VERSION, b"\x03\x05", Version(3, 5)),
    ],
)
def test_what_the_board_reports_is_understood(kind: int, data: bytes, told: Report) -> None:
    assert Framer(FromBoard()).push(b"\x00\xff\xfb" + frames.report_bytes(kind, data) + b"\xff") == [told]
    assert frames.report(kind, data[:-1]) != told


@given(st.binary(max_size=200), st.sampled_from((FromBoard(), ToBoard())))
def test_no_bytes_make_a_format_raise(data: bytes, form: Any) -> None:
    Framer(form).push(data)


def test_a_frame_with_a_wrong_sum_is_none() -> None:
    whole = bytearray(frames.report_bytes(frames.VERSION, b"\x03\x05"))
    whole[-1] ^= 1
    assert Framer(FromBoard()).push(bytes(whole)) == []


@given(
    st.floats(allow_nan=False, allow_infinity=False, width=32),
    st.floats(allow_nan=False, allow_infinity=False, width=32),
    st.floats(allow_nan=False, allow_infinity=False, width=32),
)
def test_a_speed_that_no_frame_can_tell_is_the_greatest_that_one_can(vx: float, vy: float, wz: float) -> None:
    (order,) = Framer(ToBoard()).push(frames.motion(1, Twist(vx, vy, wz)))
    told = speed_in(order)
    assert all(abs(value) <= 32.768 for value in (told.vx, told.vy, told.wz))


# Servos


@pytest.mark.parametrize(
    ("number", "angle", "position"),
    [(1, 0, 3100), (1, 180, 900), (4, 90, 2000), (5, 0, 380), (5, 270, 3700), (6, 0, 900), (6, 180, 3100)],
)
def test_a_servos_angle_is_a_position(number: int, angle: float, position: int) -> None:
    assert pulse(number, angle) == position
    assert degrees(number, position) == pytest.approx(angle)


@pytest.mark.parametrize("model", ["x3plus", "emulated"])
def test_joints_become_positions_and_come_back(model: str) -> None:
    arm = described(model).arm
    assert arm is not None
    servos = Servos(arm)
    for joints in (ARM_UP, (0.5, -0.7, 0.7, 1.2, 0.3)):
        assert servos.angles(servos.pulses(joints, 0.4)) == pytest.approx(joints, abs=0.002)
        assert servos.opening(servos.pulses(joints, 0.4)) == pytest.approx(0.4, abs=0.002)


HERE = (2000, 2000, 2000, 2000, 1487, 1500)


def arm_of(model: str) -> Servos:
    arm = described(model).arm
    assert arm is not None
    return Servos(arm)


def test_servos_are_known_when_all_have_said_twice_where_they_are() -> None:
    servos = arm_of("x3plus")
    servos.read((2000, -1, 2000, 2000, 1487, 1500))
    servos.read((2000, 2000, 2000, 2000, 1487, 1500))
    assert servos.known is None
    servos.read(HERE)
    assert servos.known == HERE


@pytest.mark.parametrize("odd", [-1, 0, 1000, 3050, 32000, -32768])
def test_a_servo_that_is_misread_is_where_it_was(odd: int) -> None:
    servos = arm_of("x3plus")
    for _ in range(2):
        servos.read(HERE)
    for _ in range(2):
        servos.read((2000, odd, 2000, 2000, 1487, 1500))
    servos.read(HERE)
    assert servos.known == HERE


def test_a_servo_that_was_bent_is_believed_when_it_says_so_again_and_again() -> None:
    servos = arm_of("x3plus")
    for _ in range(2):
        servos.read(HERE)
    for _ in range(3):
        servos.read((2000, 1000, 2000, 2000, 1487, 1500))
    assert servos.known == (2000, 1000, 2000, 2000, 1487, 1500)


# Odometry


def roll(odometry: Odometry, model: str, twist: Twist, seconds: float, *, gyroscope: bool, first: int = 0) -> None:
    description, turned, counts = described(model), 0.0, [float(first)] * 4
    for tick in range(round(seconds / 0.04) + 1):
        if gyroscope:
            odometry.attitude(turned, 0.04 * tick)
        odometry.encoders([(round(count) + 2**31) % 2**32 - 2**31 for count in counts], 0.04 * tick)
        counts = [count + more for count, more in zip(counts, counts_of(description, twist, 0.04), strict=True)]
        turned = math.remainder(turned + twist.wz * 0.04, 2 * math.pi)


@pytest.mark.parametrize("gyroscope", [True, False])
@pytest.mark.parametrize(
    ("model", "twist", "pose"),
    [
        ("x3", Twist(0.25), Pose(0.5, 0, 0)),
        ("x3", Twist(0, -0.25), Pose(0, -0.5, 0)),
        ("x3", Twist(0, 0, 0.5), Pose(0, 0, 1.0)),
        ("x1", Twist(0.25), Pose(0.5, 0, 0)),
        ("x1", Twist(0, 0, 0.5), Pose(0, 0, 1.0)),
        ("x3plus", Twist(0.5, 0, math.pi / 2), Pose(0, 2 / math.pi, math.pi)),
    ],
)
def test_counts_add_up_to_where_it_is(model: str, twist: Twist, pose: Pose, gyroscope: bool) -> None:
    odometry = Odometry(described(model))
    roll(odometry, model, twist, 2.0, gyroscope=gyroscope)
    assert odometry.pose.distance_to(pose) < 0.01
    assert math.remainder(odometry.pose.yaw - pose.yaw, 2 * math.pi) == pytest.approx(0, abs=0.02)


def test_counts_may_wrap() -> None:
    odometry = Odometry(described("x3"))
    roll(odometry, "x3", FORWARD, 2.0, gyroscope=False, first=2**31 - 500)
    assert odometry.pose.x == pytest.approx(0.4, abs=0.01)


def test_a_board_that_counts_anew_moves_nothing() -> None:
    odometry = Odometry(described("x3"))
    odometry.encoders((100000, 100000, 100000, 100000), 0.0)
    odometry.encoders((0, 0, 0, 0), 0.04)
    assert odometry.pose == Pose(0, 0, 0)


def test_a_board_without_encoders_is_believed_its_speed() -> None:
    odometry = Odometry(described("x3"))
    for _ in range(50):
        odometry.speed(Twist(0.2), 0.04)
    assert odometry.pose.x == pytest.approx(0.4)


def test_an_odd_direction_turns_nothing() -> None:
    odometry = Odometry(described("x3"))
    for tick in range(20):
        odometry.attitude(2.5 if tick == 10 else 0.0, 0.04 * tick)
        odometry.encoders((0, 0, 0, 0), 0.04 * tick)
    for tick in range(20, 40):
        odometry.attitude(1.5, 0.04 * tick)
        odometry.encoders((0, 0, 0, 0), 0.04 * tick)
    assert odometry.pose.yaw == 0


# The body


def test_it_drives_and_knows_where_it_is() -> None:
    bench = Bench()
    body = bench.body()
    body.drive(FORWARD)
    run(body, 2.0)
    body.drive(ZERO)
    run(body, 0.5)
    true = bench.simulated.true_pose
    assert true.x > 0.3
    assert body.odometry().distance_to(true) < 0.02
    assert body.twist.is_zero
    assert body.volts == pytest.approx(12.4, abs=0.15)


def test_it_moves_the_arm_and_reads_it() -> None:
    body = Bench().body()
    body.place_arm((0.3, -0.5, 0.5, 0.6, 0.2), 1.0)
    run(body, 2.0)
    assert body.joints == pytest.approx((0.3, -0.5, 0.5, 0.6, 0.2), abs=0.05)
    assert body.opening == pytest.approx(1.0, abs=0.1)


def test_servos_that_have_never_said_where_they_are_are_not_moved() -> None:
    bench = Bench()
    bench.board.begin("servos")
    body = bench.body()
    body.place_arm((0.3, -0.5, 0.5, 0.6, 0.2), 1.0)
    run(body, 1.0)
    assert frames.ARM not in {order.function for order in bench.orders()}
    assert body.trouble == "", "it drives all the same"
    bench.board.end("servos")
    told = {body.trouble}
    for _ in range(400):
        body.step()
        told.add(body.trouble)
    assert told == {"", "the arm has only now said where it is"}, "whoever moves it begins where it is"
    assert frames.ARM not in {order.function for order in bench.orders()}
    body.place_arm((*body.joints[:4], 0.5), body.opening)
    run(body, 0.1)
    assert frames.ARM in {order.function for order in bench.orders()}


def test_no_servo_jumps() -> None:
    bench = Bench()
    body = bench.body()
    body.place_arm((1.5, 0.5, -0.5, 1.5, 1.0), 1.0)
    run(body, 1.0)
    sent = [struct.unpack("<7h", order.data)[:6] for order in bench.orders() if order.function == frames.ARM]
    assert len(sent) > 10
    assert all(abs(new - old) <= 80 for one, two in itertools.pairwise(sent) for old, new in zip(one, two, strict=True))


def test_an_arm_that_sank_while_the_cable_was_out_does_not_snap_back() -> None:
    bench = Bench()
    body = bench.body()
    body.place_arm((0.3, -0.5, 0.5, 0.6, 0.2), 0.0)
    run(body, 1.0)
    bench.plugged = False
    run(body, 0.2)
    bench.simulated.place_arm((0.3, 0.5, 0.5, 0.6, 0.2), 0.0)
    run(body, 1.0)
    bench.plugged = True
    bench.orders()
    run(body, 1.5)
    assert body.joints[1] == pytest.approx(0.5, abs=0.05)
    assert frames.ARM not in {order.function for order in bench.orders()}, "nobody has told it to move"


def test_a_stop_is_on_the_wire_at_once() -> None:
    bench = Bench()
    body = bench.body()
    body.drive(FORWARD)
    run(body, 0.5)
    bench.said.clear()
    body.drive(ZERO)
    assert bench.speeds() == [ZERO]


def test_a_zero_goes_before_what_still_waits() -> None:
    bench = Bench()
    body = bench.body()
    body.drive(FORWARD)
    run(body, 0.3)
    bench.takes = 5
    bench.board.begin("stall")
    run(body, 0.06)  # a part of a frame is in the line, and another waits
    bench.takes = 4096
    bench.said.clear()
    body.drive(ZERO)
    assert bench.speeds() == [ZERO]


def test_a_board_that_resets_does_not_change_where_it_is() -> None:
    bench = Bench()
    body = bench.body()
    body.drive(FORWARD)
    run(body, 2.0)
    bench.board.begin("reset")
    run(body, 1.5)
    assert body.odometry().distance_to(bench.simulated.true_pose) < 0.05


def test_it_is_told_again_and_again() -> None:
    bench = Bench()
    body = bench.body()
    body.drive(FORWARD)
    bench.said.clear()
    run(body, 1.0)
    assert 15 <= bench.speeds().count(FORWARD) <= 25


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from(("x1", "x3", "x3plus", "r2", "emulated")),
    st.lists(st.builds(Twist, *[st.floats(-50, 50)] * 3), min_size=1, max_size=5),
    st.floats(-0.5, 0.5),
)
def test_no_frame_exceeds_what_the_robot_may(model: str, twists: list[Twist], trim: float) -> None:
    bench, most = Bench(), described(model).speeds
    bench.description = described(model).model_copy(update={"trim": trim})
    body = bench.body()
    for twist in twists:
        body.drive(twist)
        body.step()
    for told in bench.speeds():
        assert abs(told.vx) <= most.forward + 1e-9
        assert abs(told.vy) <= most.sideways + 1e-9
        assert abs(told.wz) <= most.turn + 1e-9


def pulling(pull: float, trim: float, model: str = "emulated") -> Bench:
    """A robot that turns by ``pull`` a metre, with a board that is told so much against it, rad/m."""
    bench = Bench(model, pull=pull)
    bench.description = described(model).model_copy(update={"trim": trim})
    return bench


@pytest.mark.parametrize("speed", [0.2, -0.2])
def test_a_robot_that_pulls_drives_straight_with_its_trim_and_knows_where_it_is(speed: float) -> None:
    turned = []
    for trim in (0.0, -0.2):
        bench = pulling(0.2, trim)
        start = bench.simulated.true_pose
        body = bench.body()
        body.drive(Twist(speed))
        run(body, 3.0)
        body.drive(ZERO)
        run(body, 0.5)
        turned.append(bench.simulated.true_pose.yaw - start.yaw)
        assert body.odometry().distance_to(bench.simulated.true_pose) < 0.02
        assert body.odometry().yaw == pytest.approx(bench.simulated.true_pose.yaw, abs=0.005)
    assert turned == pytest.approx([0.6 * speed, 0.0], abs=0.01)


@pytest.mark.parametrize("twist", [ZERO, Twist(0.0, 0.1, 0.0), Twist(0.0, 0.0, 0.5)])
def test_a_robot_that_does_not_drive_ahead_is_not_trimmed(twist: Twist) -> None:
    bench = pulling(0.0, 0.4)
    body = bench.body()
    bench.said.clear()
    body.drive(twist)
    run(body, 0.2)
    assert set(bench.speeds()) == {twist}


def test_a_trim_turns_no_wheel_further_than_it_can_be_steered() -> None:
    bench = pulling(0.0, 0.5, "r2")
    body = bench.body()
    bench.orders()
    body.drive(Twist(0.2, 0.0, 3.0))
    (told,) = bench.speeds()
    assert told.wz == pytest.approx(0.2 * math.tan(math.radians(30)) / 0.23, abs=0.001)
    body.drive(Twist(0.2))
    assert bench.speeds() == [Twist(0.2, 0.0, 0.1)]


def test_it_never_drives_sideways_where_the_wheels_cannot() -> None:
    bench = Bench()
    bench.description = described("x1")
    body = bench.body()
    body.drive(Twist(0.1, 0.1))
    assert bench.speeds()[-1] == Twist(0.1)


@pytest.mark.parametrize(
    ("fault", "told"),
    [("silence", "is silent"), ("stall", "takes no bytes"), ("brownout", None), ("reset", "is silent")],
)
def test_what_goes_wrong_is_trouble_and_ends(fault: Any, told: str | None) -> None:
    bench = Bench()
    body = bench.body()
    body.drive(FORWARD)
    run(body, 0.3)
    if fault == "stall":
        bench.takes = 10
    bench.board.begin(fault)
    troubles = ""
    for _ in range(360):
        body.step()
        troubles += body.trouble
    if told is not None:
        assert told in troubles
    body.drive(FORWARD)  # whoever drives on: it tells the board to stand
    bench.orders()
    run(body, 0.3)
    if told is not None and fault != "stall":
        assert set(bench.speeds()) == {ZERO}
    bench.takes = 4096
    bench.board.end(fault)
    run(body, 1.5)
    assert body.trouble == ""
    body.drive(FORWARD)
    run(body, 0.5)
    assert body.twist.vx == pytest.approx(0.2, abs=0.02)


def test_a_cable_that_is_pulled_is_trouble_until_it_is_back() -> None:
    bench = Bench()
    body = bench.body()
    body.drive(FORWARD)
    run(body, 0.3)
    bench.plugged = False
    run(body, 0.1)
    assert body.trouble == "/dev/ttyTest was unplugged"
    bench.said.clear()
    bench.plugged = True
    run(body, 1.5)
    assert body.trouble == ""
    assert set(bench.speeds()) == {ZERO}, "the first that the board hears is to stand"
    body.drive(FORWARD)
    run(body, 1.0)
    body.drive(ZERO)
    run(body, 0.5)
    assert body.odometry().distance_to(bench.simulated.true_pose) < 0.02, "it drove on meanwhile, and knows how far"


def test_a_board_that_never_answers_is_no_robot() -> None:
    bench = Bench()
    bench.board.begin("silence")
    with pytest.raises(DeviceError, match="No Rosmaster board can be driven on /dev/ttyTest"):
        bench.body()


def test_a_port_that_is_not_there_is_told() -> None:
    bench = Bench()
    bench.plugged = False
    with pytest.raises(PortError, match="There is no serial port"):
        bench.body()


def test_it_goes_on_from_where_it_was() -> None:
    last = np.zeros((), STATE)
    last["t"], last["pose"] = 7.0, (1.0, 2.0, 0.5)
    body = Bench().body(last=last)
    assert body.odometry() == Pose(1.0, 2.0, 0.5)
    assert body.t >= 7.0


def test_a_robot_that_steers_like_a_car_does_not_turn_where_it_stands() -> None:
    bench = Bench()
    bench.description = described("r2")
    body = bench.body()
    bench.orders()
    body.drive(Twist(wz=1.0))
    body.step()
    assert set(bench.speeds()) <= {ZERO}
    body.drive(Twist(0.2, 0.0, 3.0))
    (told,) = bench.speeds()
    assert told.vx == 0.2
    assert told.wz == pytest.approx(0.2 * math.tan(math.radians(30)) / 0.23, abs=0.001)


# A million bytes


def test_a_million_bytes_invent_no_motion() -> None:
    bench = Bench()
    body = bench.body()
    chance = random.Random(27)
    bench.said.clear()
    for _ in range(1000):
        bench.noise = chance.randbytes(1000)
        body.step()
    assert set(bench.speeds()) <= {ZERO}


def test_a_hundred_thousand_frames_invent_no_motion() -> None:
    bench = Bench()
    body = bench.body()
    chance = random.Random(27)
    bench.said.clear()
    for _ in range(1000):
        bench.noise = b"".join(
            frames.report_bytes(chance.randrange(256), chance.randbytes(chance.randrange(24))) for _ in range(100)
        )
        body.step()
    assert set(bench.speeds()) <= {ZERO}
    assert all(map(math.isfinite, (*body.joints, body.opening, body.volts, body.odometry().x)))


def test_a_board_is_not_moved_by_noise() -> None:
    bench = Bench()
    chance = random.Random(27)
    for _ in range(1000):
        bench.board.receive(chance.randbytes(1000))
    assert bench.board.state.told.is_zero


def test_the_board_knows_no_limits() -> None:
    """What the body is there for: the board itself would."""
    bench = Bench()
    bench.board.receive(frames.motion(1, Twist(3.0)))
    assert bench.board.state.told == Twist(3.0)
    bench.board.receive(bytes([*frames.TO_BOARD, 3, frames.MOTION, 0]))
    assert isinstance(Framer(ToBoard()).push(frames.beep(5))[0], Order)
