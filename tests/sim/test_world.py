"""The simulated robot in its world, held in the hand: base, arm, lidar, envelope and odometry against real physics."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from engine.robot.arm import ARM_DOWN, ARM_INITIAL, ARM_UP
from engine.robot.geometry import Pose, Twist
from engine.robot.host.memory import STATE
from engine.robot.lidar import LIDAR_ANGLES
from engine.robot.mecanum import twist_of, wheel_speeds
from engine.robot.sim.dimensions import FOOTPRINT
from engine.robot.sim.odometry import Odometry
from engine.robot.sim.scene_parts import KeepOut
from engine.robot.sim.world import World
from tests.sim.rig import drive, flat, in_the_flat, settings


def fixed_touched(world: World) -> set[str]:
    """What the robot touches that cannot move."""
    return set(world.touching()) - set(flat().objects)


def test_it_stops_from_walking_speed_within_a_few_millimetres() -> None:
    world = in_the_flat()
    drive(world, Twist(0.3), 1.0)
    assert world.twist.vx == pytest.approx(0.3, abs=0.005)
    before, started = world.true_pose, world.t
    world.stop()
    while not world.at_rest:
        world.step()
    assert world.t - started < 0.08
    assert world.true_pose.distance_to(before) < 0.008


@pytest.mark.parametrize("direction", [Twist(0.5), Twist(-0.5), Twist(0, 0.4), Twist(0, -0.4), Twist(0, 0, 1.5)])
def test_it_goes_in_every_direction_as_told(direction: Twist) -> None:
    world = in_the_flat()
    drive(world, direction, 0.8)
    twist = world.twist
    assert (twist.vx, twist.vy, twist.wz) == pytest.approx((direction.vx, direction.vy, direction.wz), abs=0.01)


def test_ten_metres_forward_at_full_speed_end_before_the_wall() -> None:
    world = in_the_flat()
    touched: set[str] = set()
    drive(world, Twist(0.7), 15.0, lambda: touched.update(fixed_touched(world)))
    assert not touched
    assert world.at_rest
    assert world.blocked is not None
    assert "ahead" in world.blocked
    assert world.ranges[np.abs(LIDAR_ANGLES) < 0.7].min() > FOOTPRINT.length / 2 + 0.05


@pytest.mark.parametrize("seed", range(4))
def test_no_random_driving_ever_touches_walls_or_furniture(seed: int) -> None:
    rng = np.random.default_rng(seed)
    world = in_the_flat(Pose(*[(0.0, 0.0), (-2.2, 0.5), (0.5, -2.0), (3.0, 2.4)][seed], float(rng.uniform(-3, 3))))
    touched: set[str] = set()
    for _ in range(40):
        vx, vy, wz = rng.uniform((-0.9, -0.9, -4), (0.9, 0.9, 4))
        turning = rng.random() < 0.6
        drive(world, Twist(vx, vy, wz if turning else 0), 1.0, lambda: touched.update(fixed_touched(world)))
    assert not touched


def test_a_keep_out_zone_is_not_entered() -> None:
    scene = flat().model_copy(update={"keep_out": (KeepOut(name="stairs", x=(1.0, 1.5), y=(-0.9, 0.9)),)})
    world = World(scene, settings())
    drive(world, Twist(0.7), 4.0)
    assert world.true_pose.x + FOOTPRINT.length / 2 == pytest.approx(1.0 - 0.06, abs=0.01)


def test_the_lidar_sees_the_walls_of_the_hall_and_not_the_robot() -> None:
    world = in_the_flat()
    left = world.ranges[90]
    assert LIDAR_ANGLES[90] == pytest.approx(math.pi / 2)
    assert world.ranges[270] == pytest.approx(0.85, abs=0.01)
    assert left > 0.85, "through the kitchen's door"
    assert world.ranges.min() > FOOTPRINT.width / 2


@pytest.mark.parametrize("pose", [ARM_UP, ARM_DOWN, ARM_INITIAL])
def test_the_arm_reaches_its_named_poses(pose: tuple[float, ...]) -> None:
    world = in_the_flat()
    assert world.move_arm(pose, 1.5)
    drive(world, Twist(), 3.0)
    assert world.arm.joints == pytest.approx(pose, abs=0.02)


def test_reaching_down_brings_the_gripper_to_the_floor_in_front_of_the_hull() -> None:
    world = in_the_flat()
    world.move_arm(ARM_DOWN, 1.5)
    drive(world, Twist(), 3.0)
    x, y, z = world.data.site("grip").xpos
    assert x > FOOTPRINT.length / 2 + 0.08
    assert abs(y) < 0.01
    assert 0.01 < z < 0.05


def test_the_folded_arm_stays_within_the_hull() -> None:
    world = in_the_flat()
    drive(world, Twist(), 0.5)
    x, y, z = world.data.site("grip").xpos
    assert math.hypot(x, y) < FOOTPRINT.length / 2
    assert z > 0.2


def test_it_pushes_a_ball_that_lay_asleep() -> None:
    ball = flat().objects["ball"].at
    world = in_the_flat(Pose(ball[0] + 0.5, ball[1], math.pi))
    drive(world, Twist(), 1.0)
    drive(world, Twist(0.2), 3.0)
    assert world.data.body("ball").xpos[0] < ball[0] - 0.02


def test_the_gripper_lifts_a_box_and_a_stop_does_not_drop_it() -> None:
    """The box is put between the open fingers: grasping from the floor is the skill's business, holding is ours."""
    world = in_the_flat()
    world.move_arm(ARM_DOWN, 1.5)
    world.grip(1.0)
    drive(world, Twist(), 3.0)
    x, y, _ = world.data.site("grip").xpos
    address = world.model.joint("green box").qposadr[0]
    world.data.qpos[address : address + 7] = [x, y, 0.001, 1, 0, 0, 0]
    drive(world, Twist(), 0.5)
    world.grip(0.0)
    drive(world, Twist(), 1.0)
    world.move_arm(ARM_INITIAL, 1.0)
    drive(world, Twist(), 3.0)
    assert world.data.body("green box").xpos[2] > 0.2
    drive(world, Twist(-0.5), 1.0)
    world.stop()
    drive(world, Twist(0, 0, 2.0), 1.0)
    world.stop()
    drive(world, Twist(), 0.5)
    held = world.data.site("grip").xpos - world.data.geom("green box").xpos
    assert np.linalg.norm(held) < 0.03


def test_odometry_without_noise_is_the_truth_and_with_noise_repeatable() -> None:
    def believed(**changes: Any) -> tuple[Pose, Pose]:
        world, record = in_the_flat(**changes), np.zeros((), STATE)
        drive(world, Twist(0.4, 0.05, 0.3), 3.0)
        world.fill(record)
        return Pose(*record["true_pose"].tolist()), Pose(*record["pose"].tolist())

    true, exact = believed()
    assert exact.distance_to(true) < 1e-9
    _, first = believed(odometry_noise=0.05, seed=3)
    _, again = believed(odometry_noise=0.05, seed=3)
    _, other = believed(odometry_noise=0.05, seed=4)
    assert first == again
    assert first != other
    assert 0.001 < first.distance_to(true) < 0.5


def test_odometry_errors_grow_with_the_way_at_the_stated_rate() -> None:
    errors = []
    for seed in range(200):
        odometry = Odometry(Pose(0, 0, 0), noise=0.02, seed=seed)
        for i in range(1, 101):
            added = odometry.update(Pose(i / 100, 0, 0))
        errors.append(added.x - 1.0)
    assert np.mean(errors) == pytest.approx(0, abs=0.006)
    assert 0.015 < np.std(errors) < 0.03


def test_wheel_speeds_and_twist_are_each_others_inverse() -> None:
    for twist in (Twist(0.3), Twist(0, 0.2), Twist(0, 0, 1.0), Twist(0.2, -0.1, 0.5)):
        back = twist_of(wheel_speeds(twist))
        assert (back.vx, back.vy, back.wz) == pytest.approx((twist.vx, twist.vy, twist.wz))
    assert wheel_speeds(Twist(0.42)) == pytest.approx((10, 10, 10, 10))
    front_left, front_right, rear_left, rear_right = wheel_speeds(Twist(0, 0.42))
    assert front_left < 0 < front_right
    assert rear_right < 0 < rear_left
