"""A lidar on a serial port, emulated byte by byte: what it sees, from where, and how it comes and goes."""

from __future__ import annotations

import math
import random
import threading
from collections.abc import Iterator

import numpy as np
import pytest
from lds2d.core import ScanPoint

from engine.errors import DeviceError, UsageError
from engine.robot.description import Hull, LidarOf
from engine.robot.emulation.lidar import EmulatedLidar
from engine.robot.geometry import Pose, Twist
from engine.robot.host.body import STEP_S
from engine.robot.lidar import LIDAR_ANGLES, RAYS, Turn, ranges_of
from engine.robot.sim.simulated import SimulatedBody
from engine.robot.surroundings import Surroundings
from engine.robot.usb_lidar import AGAIN_S, UsbLidar, driver_of, in_words
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


class Spoken:
    """A lidar of lds2d that says these points, and then nothing more."""

    def __init__(self, said: list[tuple[float, float]], rate: float = 2000.0) -> None:
        self.said, self.rate, self.t, self.started = said, rate, 0.0, 0

    def clock(self) -> float:
        return self.t

    def start(self) -> None:
        self.started += 1

    def stop(self) -> None:
        pass

    def points(self) -> Iterator[ScanPoint]:
        for angle, distance in self.said:
            self.t += 1 / self.rate
            yield ScanPoint(angle, round(distance), 10)
        raise DeviceError("that was all")


class Made:
    """The class of one."""

    DEFAULT_BAUD = 115200

    def __init__(self, spoken: Spoken) -> None:
        self._spoken = spoken

    def __call__(self, wire: object) -> Spoken:
        return self._spoken


class Kept:
    """A queue of one that forgets none."""

    def __init__(self, found: list[Turn]) -> None:
        self.append = found.append


def collected(said: list[tuple[float, float]], rate: float = 2000.0) -> tuple[list[Turn], UsbLidar]:
    """The turns that are made of it."""
    spoken = Spoken(said, rate)
    lidar = UsbLidar("/dev/ttyTest", A1, HULL, clock=spoken.clock, open_wire=lambda path, baud: Table())
    lidar.close()
    found: list[Turn] = []
    lidar._turns = Kept(found)  # type: ignore[assignment]
    lidar._driver = Made(spoken)
    with pytest.raises(DeviceError):
        lidar._read_on()
    assert spoken.started == 1, "it stands until it is told to turn"
    return found, lidar


CIRCLE = [(float(angle), 2000.0) for angle in range(360)]


def test_angles_that_hop_to_and_fro_around_zero_make_no_turns_of_a_few_points() -> None:
    bent = [((angle - (8 if angle % 12 else 0)) % 360, distance) for angle, distance in CIRCLE] * 6
    found, _ = collected(bent)
    assert len(found) == 5
    assert all(len(turn.points) > 340 for turn in found)


def test_a_point_that_was_misread_ends_no_turn() -> None:
    chance = random.Random(0)
    said = [(chance.uniform(0, 511) if chance.random() < 0.02 else angle, distance) for angle, distance in CIRCLE * 10]
    found, _ = collected(said)
    assert len(found) >= 5
    assert all(len(turn.points) > 320 for turn in found)


def test_a_turn_in_which_something_is_missing_is_none() -> None:
    gap = [point for point in CIRCLE if not 90 < point[0] < 180]
    assert collected(gap * 5)[0] == []
    assert collected(CIRCLE * 3, rate=300.0)[0] == [], "it takes too long to be one"


def test_a_lidar_that_is_covered_says_so() -> None:
    found, lidar = collected([(angle, 0.0) for angle, _ in CIRCLE] * 3)
    assert found == []
    assert "Is it covered?" in lidar.trouble


def test_whatever_goes_wrong_in_reading_is_told_and_it_is_tried_again() -> None:
    table = Table()
    again = threading.Event()

    def broken(path: str, baud: int) -> Table:
        if again.is_set():
            return table
        again.set()
        raise TypeError("no such thing")

    lidar = UsbLidar("/dev/ttyTest", A1, HULL, clock=table.clock, open_wire=broken)
    try:
        next(turns(lidar))
        assert not lidar.trouble
    finally:
        lidar.close()


def test_what_has_come_too_near_to_be_measured_stays_until_the_robot_has_moved_away() -> None:
    around = Surroundings((0.0, 0.0), 0.15)
    away = [(2.0, 2.0), (-2.0, -2.0)]

    def scan(t: float, x: float, points: list[tuple[float, float]]) -> np.ndarray:
        here = Pose(x, 0.0, 0.0)
        around.was(t, here)
        found = around.scan(Turn(np.array(points), np.full(len(points), t)), t, here)
        assert found is not None
        return found

    assert scan(0.0, 0.0, [(0.2, 0.0), *away])[0] == pytest.approx(0.2)
    assert scan(0.1, 0.1, away)[0] == pytest.approx(0.1), "it is nearer than can be measured, and there"
    assert scan(0.2, 0.1, [(1.0, 0.0), *away])[0] == pytest.approx(1.0), "what is measured counts"
    assert scan(0.3, 0.0, [(0.2, 0.0), *away])[0] == pytest.approx(0.2)
    assert np.isinf(scan(0.4, -0.2, away)[0]), "from here it would be seen"


def test_a_turn_that_is_over_is_no_scan() -> None:
    around = Surroundings((0.0, 0.0), 0.15)
    turn = Turn(np.array([[1.0, 0.0]]), np.array([1.0]))
    assert around.scan(turn, 1.0, Pose(0, 0, 0)) is None, "nobody knows from where it was seen"
    around.was(0.9, Pose(0, 0, 0))
    assert around.scan(turn, 1.1, Pose(0, 0, 0)) is not None
    assert around.scan(turn, 1.5, Pose(0, 0, 0)) is None, "it is too old"
