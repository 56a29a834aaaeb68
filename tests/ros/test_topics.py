"""Topics through each door, both ways."""

from __future__ import annotations

import queue
from typing import Any

import numpy as np
import pytest

from engine.ros.door import Door, octets
from tests.ros.conftest import LIMIT_S, until_heard
from tests.ros.ways import Way

STRING = "std_msgs/msg/String"


def test_what_a_peer_publishes_is_heard(way: Way, door: Door) -> None:
    heard: queue.SimpleQueue[Any] = queue.SimpleQueue()
    door.subscribe("/heard", STRING, heard.put)
    message = until_heard(heard, lambda: way.peer.publish("/heard", STRING, {"data": "hello, 世界"}))
    assert message == {"data": "hello, 世界"}


def test_what_is_published_reaches_a_peer(way: Way, door: Door) -> None:
    twist = {"linear": {"x": 0.25, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": -1.5}}
    heard = way.peer.listen("/told", "geometry_msgs/msg/Twist")
    assert until_heard(heard, lambda: door.publish("/told", "geometry_msgs/msg/Twist", twist)) == twist


def test_fields_that_are_not_given_have_their_defaults(way: Way, door: Door) -> None:
    heard = way.peer.listen("/pose", "geometry_msgs/msg/Pose")
    message = until_heard(heard, lambda: door.publish("/pose", "geometry_msgs/msg/Pose", {"position": {"x": 1.0}}))
    assert message["position"] == {"x": 1.0, "y": 0.0, "z": 0.0}
    assert message["orientation"] == {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}


def test_each_message_counts_where_it_is_said_so(way: Way, door: Door) -> None:
    heard = way.peer.listen("/every", "std_msgs/msg/Int32")
    until_heard(heard, lambda: door.publish("/every", "std_msgs/msg/Int32", {"data": -1}))
    for number in range(8):
        door.publish("/every", "std_msgs/msg/Int32", {"data": number}, every=True)
    numbers = []
    while 7 not in numbers:
        numbers.append(heard.get(timeout=LIMIT_S)["data"])
    assert [number for number in numbers if number >= 0] == list(range(8))


def test_of_many_messages_at_once_the_newest_arrives(way: Way, door: Door) -> None:
    heard = way.peer.listen("/newest", "std_msgs/msg/Int32")
    until_heard(heard, lambda: door.publish("/newest", "std_msgs/msg/Int32", {"data": -1}))
    for number in range(500):
        door.publish("/newest", "std_msgs/msg/Int32", {"data": number})
    numbers = [-1]
    while numbers[-1] != 499:
        numbers.append(heard.get(timeout=LIMIT_S)["data"])
    assert numbers == sorted(numbers)


def test_a_picture_arrives_as_it_was(way: Way, door: Door) -> None:
    heard: queue.SimpleQueue[Any] = queue.SimpleQueue()
    pixels = np.random.default_rng(1).integers(0, 256, 32 * 24 * 3, np.uint8).tobytes()
    picture = {"height": 24, "width": 32, "encoding": "rgb8", "step": 96, "data": pixels}
    door.subscribe("/picture", "sensor_msgs/msg/Image", heard.put)
    message = until_heard(heard, lambda: way.peer.publish("/picture", "sensor_msgs/msg/Image", picture))
    assert octets(message["data"]) == pixels
    assert (message["width"], message["encoding"]) == (32, "rgb8")


def test_a_scan_arrives_as_it_was(way: Way, door: Door) -> None:
    heard: queue.SimpleQueue[Any] = queue.SimpleQueue()
    ranges = [0.5 + index / 128 for index in range(360)]
    door.subscribe("/ranges", "sensor_msgs/msg/LaserScan", heard.put)
    scan = {"range_max": 12.0, "ranges": ranges}
    message = until_heard(heard, lambda: way.peer.publish("/ranges", "sensor_msgs/msg/LaserScan", scan))
    assert list(message["ranges"]) == ranges


def test_what_was_latched_before_is_heard(way: Way, door: Door) -> None:
    if way.name == "zenoh":
        pytest.skip("The peer behind zenoh is a door, and no door latches.")
    way.peer.publish("/latched", STRING, {"data": "the map"}, latched=True)
    heard: queue.SimpleQueue[Any] = queue.SimpleQueue()
    door.subscribe("/latched", STRING, heard.put, latched=True)
    assert heard.get(timeout=LIMIT_S) == {"data": "the map"}


def test_messages_come_no_more_often_than_wanted(way: Way, door: Door) -> None:
    heard: queue.SimpleQueue[Any] = queue.SimpleQueue()
    door.subscribe("/often", STRING, heard.put, every_s=60.0)
    until_heard(heard, lambda: way.peer.publish("/often", STRING, {"data": "first"}))
    after: queue.SimpleQueue[Any] = queue.SimpleQueue()
    door.subscribe("/mark", STRING, after.put)
    way.peer.publish("/often", STRING, {"data": "again"})
    until_heard(after, lambda: way.peer.publish("/mark", STRING, {"data": "mark"}))
    assert heard.empty()
