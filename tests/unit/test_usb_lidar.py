"""A lidar on a serial port, emulated byte by byte: what it sees, from where, and how it comes and goes."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator

import numpy as np
import pytest

from engine.errors import UsageError
from engine.robot.description import Hull, LidarOf
from engine.robot.emulation.lidar import EmulatedLidar
from engine.robot.geometry import Pose, Twist
from engine.robot.host.body import STEP_S
from engine.robot.lidar import LIDAR_ANGLES, RAYS, ranges_of
from engine.robot.sim.simulated import SimulatedBody
from engine.robot.usb_lidar import AGAIN_S, Turn, UsbLidar, driver_of, in_words
from engine.serial_port import PortError
from tests.sim.rig import flat, settings

A1 = LidarOf(model="RPLIDAR-A1")
HULL = Hull(length=0.30, width=0.24)
LIMIT_S = 30.0


class Table:
    """A lidar in the simulated house, whose time passes while somebody reads it: its wire and its clock."""

    def __init__(self, about: LidarOf = A1) -> None:
        self.body = SimulatedBody(flat(), settings(), pictures=False)
        self.lidar = EmulatedLidar(self.body, about)
        self.plugged = True
        self.rubbish = b""
        self.opened = threading.Semaphore(0)
        self.orders = bytearray()

    def clock(self) -> float:
        return self.body.t

    def open(self, path: str, baud: int) -> Table:
        assert baud == 115200
        self.opened.release()
        if not self.plugged:
            raise PortError("absent", f"There is no serial port {path}.")
        return self

    def read(self, size: int) -> bytes:
        if not self.plugged:
            raise OSError("gone")
        for _ in range(5):
            self.body.step()
            self.lidar.step()
        rubbish, self.rubbish = self.rubbish, b""
        return rubbish + self.lidar.send()

    def write(self, data: bytes) -> int:
        self.orders += data
        self.lidar.receive(data)
        return len(data)

    def close(self) -> None:
        pass


def read(table: Table, about: LidarOf = A1) -> UsbLidar:
    return UsbLidar("/dev/ttyTest", about, HULL, clock=table.clock, open_wire=table.open)


def turns(lidar: UsbLidar) -> Iterator[Turn]:
    """One after another, as they come."""
    waiting = threading.Event()
    for _ in range(round(LIMIT_S / 0.005)):
        if (turn := lidar.newest()) is not None:
            yield turn
        waiting.wait(0.005)
    raise AssertionError("no more turns came")


@pytest.mark.parametrize(
    "about",
    [A1, LidarOf(model="RPLIDAR-A1", turned=90), LidarOf(model="RPLIDAR-A1", clockwise=False)],
    ids=["as it is", "turned to the left", "upside down"],
)
def test_it_sees_the_house_as_the_simulation_does(about: LidarOf) -> None:
    table = Table(about)
    truth = table.body.scan()
    lidar = read(table, about)
    try:
        ways = turns(lidar)
        next(ways)  # which may have begun in the middle
        seen = ranges_of(next(ways).points)
    finally:
        lidar.close()
    both = np.isfinite(seen) & np.isfinite(truth) & (truth < 12)
    assert both.sum() > 0.8 * RAYS
    assert np.median(np.abs(seen[both] - truth[both])) < 0.01
    assert bytes(table.orders[-2:]) == b"\xa5\x25", "its motor was told to stand"


def test_rubbish_on_the_line_is_passed_over() -> None:
    table = Table()
    lidar = read(table)
    try:
        ways = turns(lidar)
        next(ways)
        table.rubbish = bytes(range(256)) * 3
        next(ways)
        next(ways)
        seen, truth = ranges_of(next(ways).points), table.body.scan()
    finally:
        lidar.close()
    both = np.isfinite(seen) & np.isfinite(truth)
    assert np.median(np.abs(seen[both] - truth[both])) < 0.01


def test_it_is_unplugged_and_comes_back() -> None:
    table = Table()
    lidar = read(table)
    try:
        next(turns(lidar))
        assert table.opened.acquire(timeout=LIMIT_S)
        table.plugged = False
        assert table.opened.acquire(timeout=10 * AGAIN_S), "it is looked for again"
        assert "no serial port" in lidar.trouble or "unplugged" in lidar.trouble
        table.plugged = True
        lidar.newest()
        next(turns(lidar))
        assert not lidar.trouble
    finally:
        lidar.close()


def test_points_lie_where_they_were_seen_from_a_robot_that_drives_and_turns() -> None:
    body = SimulatedBody(flat(), settings(), pictures=False)
    body.drive(Twist(0.4, 0.0, 1.0))
    points, times, been = [], [], []
    for step in range(150):
        for _ in range(round(0.002 / STEP_S)):
            body.step()
        pose, ray = body.true_pose, step * RAYS // 150
        been.append((body.t, pose.x, pose.y, pose.yaw))
        distance = float(body.scan()[ray])
        if math.isfinite(distance):
            angle = float(LIDAR_ANGLES[ray])
            points.append((distance * math.cos(angle), distance * math.sin(angle)))
            times.append(body.t)
    turn, here = Turn(np.array(points), np.array(times)), body.true_pose
    seen, truth = ranges_of(turn.seen_from(np.array(been), here)), body.scan()
    blurred = ranges_of(turn.points)
    assert _off(seen, truth) < 0.02
    assert _off(blurred, truth) > 2 * _off(seen, truth), "else this would prove nothing"


def _off(seen: np.ndarray, truth: np.ndarray) -> float:
    both = np.isfinite(seen) & np.isfinite(truth)
    return float(np.mean(np.abs(seen[both] - truth[both])))


def test_the_robot_does_not_see_itself() -> None:
    lidar = UsbLidar("/dev/ttyTest", LidarOf(model="RPLIDAR-A1", at=(0.04, 0.0)), HULL, open_wire=Table().open)
    lidar.close()
    turn = lidar._turn([(0.0, 0.05, 0.0), (180.0, 0.1, 0.0), (90.0, 1.0, 0.0)])
    assert turn.points == pytest.approx(np.array([[0.04, -1.0]])), "90° clockwise is to the right"


def test_what_cannot_be_read_is_refused_by_name() -> None:
    with pytest.raises(UsageError, match=r"lds2d does not know it.*RPLIDAR-A1"):
        driver_of(LidarOf(model="RPLIDAR-A9"))
    with pytest.raises(UsageError, match="its motor wants a pin"):
        driver_of(LidarOf(model="XIAOMI-LDS02RR"))


def test_what_it_sees_is_told_so_that_a_person_can_compare() -> None:
    points = np.array([[2.0, 0.0], [0.0, -0.5]])
    assert in_words(points) == "2 points; the nearest 0.50 m away, 90° to the right"
    assert in_words(np.empty((0, 2))) == "sees nothing"


def test_a_pose_between_two_is_interpolated_over_the_turn_of_the_clock() -> None:
    been = np.array([[0.0, 0.0, 0.0, math.pi - 0.1], [1.0, 0.0, 0.0, -math.pi + 0.1]])
    turn = Turn(np.array([[1.0, 0.0]]), np.array([0.5]))
    assert turn.seen_from(been, Pose(0, 0, math.pi)) == pytest.approx(np.array([[1.0, 0.0]]), abs=1e-9)
