"""The safety envelope: whatever is commanded, what comes out is within the limits and halts before obstacles."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from config.schema import Limits
from engine.robot.clearance import Points, gaps
from engine.robot.geometry import ZERO, Pose, Twist
from engine.robot.host.envelope import (
    TURN_MARGIN,
    Envelope,
    clamp,
    clamp_joints,
    fence,
    into_base_frame,
    into_map_frame,
    ramp,
)
from engine.robot.robot import Footprint

LIMITS = Limits(
    linear_speed=0.7,
    angular_speed=3.2,
    linear_acceleration=1.5,
    angular_acceleration=8,
    command_lifetime_s=0.25,
    obstacle_margin=0.06,
)
HULL = Footprint(0.30, 0.24)
DT = 0.01
NOTHING: Points = np.empty((0, 2))

speeds = st.floats(-3, 3, allow_nan=False)
twists = st.builds(Twist, speeds, speeds, st.floats(-8, 8))
coordinates = st.floats(-1.5, 1.5)
obstacles = st.lists(st.tuples(coordinates, coordinates), min_size=1, max_size=12).map(lambda p: np.array(p, float))


def wall(x: float) -> Points:
    """A wall across the way, ``x`` m ahead of where the robot starts."""
    return np.column_stack((np.full(200, x), np.linspace(-2, 2, 200)))


def moved(pose: Pose, twist: Twist) -> Pose:
    """Exactly along the arc for one control period."""
    yaw = pose.yaw + twist.wz * DT
    middle = pose.yaw + twist.wz * DT / 2
    c, s = math.cos(middle), math.sin(middle)
    return Pose(pose.x + (c * twist.vx - s * twist.vy) * DT, pose.y + (s * twist.vx + c * twist.vy) * DT, yaw)


def travel(commands: list[Twist], things: Points, periods: int) -> tuple[float, float, Pose]:
    """Drive each command for ``periods``; the smallest gap before and during, and where it ended."""
    envelope, pose, t = Envelope(LIMITS, HULL), Pose(0, 0, 0), 0.0
    first = smallest = float(gaps(things, HULL).min())
    for command in commands:
        for _ in range(periods):
            envelope.command(command, t)
            pose = moved(pose, envelope.shape(t, DT, into_base_frame(things, pose)).twist)
            t += DT
            smallest = min(smallest, float(gaps(into_base_frame(things, pose), HULL).min()))
    return first, smallest, pose


@given(twists)
def test_no_speed_is_above_the_limits_and_the_direction_of_travel_is_kept(twist: Twist) -> None:
    result = clamp(twist, LIMITS)
    assert abs(result.vx) <= 0.7 + 1e-9
    assert abs(result.vy) <= 0.7 + 1e-9
    assert abs(result.wz) <= 3.2
    assert twist.vx * result.vy == pytest.approx(twist.vy * result.vx, abs=1e-9)


@given(twists, twists)
def test_a_ramp_never_accelerates_harder_than_allowed_and_arrives(now: Twist, wanted: Twist) -> None:
    for _ in range(2000):
        following = ramp(now, wanted, DT, LIMITS)
        assert math.hypot(following.vx - now.vx, following.vy - now.vy) <= 1.5 * DT + 1e-9
        assert abs(following.wz - now.wz) <= 8 * DT + 1e-9
        now = following
        if now == wanted:
            return
    raise AssertionError(f"never arrived: {now}")


@settings(deadline=None)
@given(st.lists(twists, min_size=1, max_size=6), obstacles)
def test_no_sequence_of_commands_drives_the_hull_into_an_obstacle(commands: list[Twist], things: Points) -> None:
    assume(gaps(things, HULL).min() > 0.005)
    first, smallest, _ = travel(commands, things, periods=40)
    assert smallest >= min(first, TURN_MARGIN) - 0.002


@settings(deadline=None)
@given(st.lists(st.builds(Twist, speeds, speeds), min_size=1, max_size=6), obstacles)
def test_driving_without_turning_keeps_the_whole_margin(commands: list[Twist], things: Points) -> None:
    assume(gaps(things, HULL).min() > 0.005)
    first, smallest, _ = travel(commands, things, periods=40)
    assert smallest >= min(first, LIMITS.obstacle_margin) - 0.002


@settings(deadline=None)
@given(st.lists(twists, min_size=1, max_size=5), obstacles)
def test_it_only_takes_speed_away(commands: list[Twist], things: Points) -> None:
    assume(gaps(things, HULL).min() > 0.0)
    envelope, pose, last = Envelope(LIMITS, HULL), Pose(0, 0, 0), ZERO
    for i, command in enumerate(commands):
        envelope.command(command, 0.0)
        twist = envelope.shape(0.0, DT, into_base_frame(things, pose)).twist
        speed, before = math.hypot(twist.vx, twist.vy), math.hypot(last.vx, last.vy)
        assert speed <= before + 1.5 * DT + 1e-9, i
        assert abs(twist.wz) <= abs(last.wz) + 8 * DT + 1e-9
        pose, last = moved(pose, twist), twist


@given(st.lists(twists, min_size=1, max_size=4), obstacles)
def test_what_is_out_of_reach_changes_nothing(commands: list[Twist], things: Points) -> None:
    things = 2 * things  # up to 3 m away
    everything, near = Envelope(LIMITS, HULL), Envelope(LIMITS, HULL)
    within = things[np.hypot(things[:, 0], things[:, 1]) < near.reach]
    t = 0.0
    for command in commands:
        for _ in range(30):
            everything.command(command, t)
            near.command(command, t)
            assert everything.shape(t, DT, things) == near.shape(t, DT, within)
            t += DT


@given(twists, obstacles)
def test_an_idle_envelope_stands_whatever_is_around(command: Twist, things: Points) -> None:
    envelope, t = Envelope(LIMITS, HULL), 0.0
    assert envelope.idle
    envelope.command(command, t)
    assert envelope.idle == command.is_zero
    for _ in range(200):  # it dies, and the base comes to rest
        envelope.shape(t, DT, things)
        t += DT
    assert envelope.idle
    assert envelope.shape(t, DT, things) == envelope.shape(t, DT, None)


def test_a_wall_ahead_is_approached_to_the_margin_and_named() -> None:
    envelope, pose, t = Envelope(LIMITS, HULL), Pose(0, 0, 0), 0.0
    for _ in range(400):
        envelope.command(Twist(0.7), t)
        shaped = envelope.shape(t, DT, into_base_frame(wall(1.0), pose))
        pose, t = moved(pose, shaped.twist), t + DT
    assert 1.0 - pose.x - HULL.length / 2 == pytest.approx(LIMITS.obstacle_margin, abs=0.003)
    assert shaped.blocked is not None
    assert shaped.blocked.startswith("obstacle 0.06 m ahead")


def test_it_can_drive_away_from_and_along_a_wall_that_it_stands_at() -> None:
    beside = wall(HULL.length / 2 + 0.03)
    for free in (Twist(-0.3), Twist(0, 0.3), Twist(0, -0.3)):
        _, _, pose = travel([free], beside, periods=100)
        assert math.hypot(pose.x, pose.y) > 0.2, free


def test_it_can_turn_away_from_a_wall_that_it_has_driven_up_to() -> None:
    at_the_wall = wall(HULL.length / 2 + LIMITS.obstacle_margin)
    _, smallest, pose = travel([Twist(wz=1.5)], at_the_wall, periods=150)
    assert abs(pose.yaw) > 1.5
    assert smallest >= TURN_MARGIN - 0.002


def test_a_glancing_approach_goes_on_along_the_wall_and_a_steep_one_halts() -> None:
    glancing, steep = Twist(0.1, 0.5), Twist(0.4, 0.4)
    _, _, along = travel([glancing], wall(0.4), periods=300)
    assert along.y > 1.0
    _, _, halted = travel([steep], wall(0.4), periods=300)
    assert halted.y < 0.4


def test_a_command_dies_after_its_lifetime_with_a_ramp() -> None:
    envelope = Envelope(LIMITS, HULL)
    for i in range(30):
        envelope.command(Twist(0.3), i * DT)
        twist = envelope.shape(i * DT, DT, NOTHING).twist
    assert twist.vx == pytest.approx(0.3)
    fading = [envelope.shape(0.29 + i * DT, DT, NOTHING).twist.vx for i in range(60)]
    assert fading[20] == pytest.approx(0.3), "still alive after 0.2 s"
    assert fading[30] < 0.3
    assert fading[-1] == 0.0


def test_a_halt_needs_no_ramp_and_forgets_the_command() -> None:
    envelope = Envelope(LIMITS, HULL)
    for i in range(50):
        envelope.command(Twist(0.7), i * DT)
        envelope.shape(i * DT, DT, NOTHING)
    envelope.halt()
    assert envelope.shape(0.5, DT, NOTHING).twist == ZERO


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_command_that_is_not_finite_means_standing_still(bad: float) -> None:
    envelope = Envelope(LIMITS, HULL)
    for twist in (Twist(bad), Twist(0, bad), Twist(0, 0, bad)):
        assert not envelope.command(twist, 0.0)
        assert envelope.shape(0.0, DT, NOTHING).twist == ZERO


def test_a_robot_that_sees_nothing_does_not_drive() -> None:
    envelope = Envelope(LIMITS, HULL)
    envelope.command(Twist(0.3), 0.0)
    shaped = envelope.shape(0.0, DT, None)
    assert shaped.twist == ZERO
    assert shaped.blocked == "no lidar scan"


def test_an_edge_of_the_workspace_is_like_a_wall() -> None:
    _, smallest, pose = travel([Twist(0.7, 0.2)], fence([(-1, -1, 1, 1)]), periods=600)
    assert smallest >= LIMITS.obstacle_margin - 0.002
    assert pose.x < 1.0


@given(obstacles, coordinates, coordinates, st.floats(-4, 4))
def test_frames_are_each_others_inverse(things: Points, x: float, y: float, yaw: float) -> None:
    pose = Pose(x, y, yaw)
    assert into_map_frame(into_base_frame(things, pose), pose) == pytest.approx(things, abs=1e-9)


def test_joints_are_kept_within_their_ranges() -> None:
    ranges = ((-1.0, 1.0), (0.0, 2.0))
    assert clamp_joints((5, -5), ranges) == (1.0, 0.0)
    assert clamp_joints((math.nan, 0), ranges) is None
    assert clamp_joints((0.0,), ranges) is None


def driven(envelope: Envelope, twist: Twist) -> Twist:
    """What the motors are told once nothing changes any more, with nothing around."""
    envelope.command(twist, 0.0)
    for _ in range(400):
        told = envelope.shape(0.0, DT, NOTHING).twist
    return told


@settings(deadline=None)
@given(twists, st.floats(0.1, 1.0))
def test_a_speed_limit_only_ever_takes_away_and_keeps_the_direction(wanted: Twist, share: float) -> None:
    envelope = Envelope(LIMITS, HULL)
    envelope.limit_speed(share)
    told, most = driven(envelope, wanted), clamp(wanted, LIMITS)
    assert max(abs(told.vx), abs(told.vy)) <= share * LIMITS.linear_speed + 1e-9
    assert abs(told.wz) <= min(share * LIMITS.angular_speed, abs(most.wz)) + 1e-9
    assert math.hypot(told.vx, told.vy) <= math.hypot(most.vx, most.vy) + 1e-9
    assert told.vx * most.vy == pytest.approx(told.vy * most.vx, abs=1e-6)


def test_a_speed_limit_slows_down_what_drives_already_and_no_value_lets_anything_be_faster_than_the_limits() -> None:
    envelope = Envelope(LIMITS, HULL)
    speeds = []
    for share in (1.0, 0.25, -3.0, 7.0, math.nan):
        envelope.limit_speed(share)
        speeds.append(driven(envelope, Twist(3.0)).vx / LIMITS.linear_speed)
    assert speeds == pytest.approx([1.0, 0.25, 0.1, 1.0, 1.0])
