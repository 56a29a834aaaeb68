"""The bus: one order for all, from any thread, whatever a listener does."""

from __future__ import annotations

import threading
from datetime import UTC, datetime, timedelta

import pytest

from engine.bus import Bus
from engine.events import ErrorRaised, Event, Log


class Handclock:
    """A clock that moves when it is told to."""

    def __init__(self) -> None:
        self.seconds = 100.0

    def now(self) -> float:
        return self.seconds

    def wall(self) -> datetime:
        return datetime(2026, 11, 21, tzinfo=UTC) + timedelta(seconds=self.seconds)


@pytest.fixture
def clock() -> Handclock:
    return Handclock()


@pytest.fixture
def bus(clock: Handclock) -> Bus:
    return Bus(clock, session="S")


def log(message: str) -> Log:
    return Log("info", "test", message)


def test_events_are_numbered_from_one_and_stamped_since_the_start(bus: Bus, clock: Handclock) -> None:
    first = bus.publish(log("a"))
    clock.seconds += 1.5
    second = bus.publish(log("b"), turn="T", epoch=3)
    assert (first.seq, first.t, first.turn, first.epoch, first.session) == (1, 0.0, None, 0, "S")
    assert (second.seq, second.t, second.turn, second.epoch) == (2, 1.5, "T", 3)
    assert second.wall == "2026-11-21T00:01:41.500Z"


def test_a_session_without_a_name_gets_one_of_its_own(clock: Handclock) -> None:
    assert Bus(clock).session != Bus(clock).session


def test_a_listener_has_the_event_when_publish_returns(bus: Bus) -> None:
    seen: list[Event] = []
    bus.subscribe(seen.append)
    event = bus.publish(log("a"))
    assert seen == [event]


def test_a_listener_hears_from_its_subscription_to_its_end(bus: Bus) -> None:
    seen: list[Event] = []
    bus.publish(log("before"))
    unsubscribe = bus.subscribe(seen.append)
    heard = bus.publish(log("during"))
    unsubscribe()
    unsubscribe()  # a second time does no harm
    bus.publish(log("after"))
    assert seen == [heard]


def test_a_failing_listener_is_dropped_and_reported_to_the_others(bus: Bus) -> None:
    first: list[Event] = []
    last: list[Event] = []
    calls = []

    def broken(event: Event) -> None:
        calls.append(event)
        raise RuntimeError("no more")

    bus.subscribe(first.append)
    bus.subscribe(broken)
    bus.subscribe(last.append)
    bus.publish(log("a"))
    bus.publish(log("b"))
    assert len(calls) == 1
    assert [event.kind for event in first] == ["log", "error", "log"]
    assert first == last
    report = first[1].body
    assert isinstance(report, ErrorRaised)
    assert report.code == "subscriber_failed"
    assert "no more" in report.message


def test_when_every_listener_fails_publishing_still_works(bus: Bus) -> None:
    def broken(event: Event) -> None:
        raise RuntimeError(event.kind)

    bus.subscribe(broken)
    bus.subscribe(broken)
    bus.publish(log("a"))
    assert bus.publish(log("b")).seq == 4  # the two reports are 2 and 3


def test_a_listener_may_leave_while_it_is_called(bus: Bus) -> None:
    seen: list[Event] = []

    def once(event: Event) -> None:
        seen.append(event)
        leave()

    leave = bus.subscribe(once)
    other: list[Event] = []
    bus.subscribe(other.append)
    bus.publish(log("a"))
    bus.publish(log("b"))
    assert len(seen) == 1
    assert len(other) == 2


def test_a_listener_that_leaves_and_fails_is_only_reported(bus: Bus) -> None:
    def leaving(event: Event) -> None:
        leave()
        raise RuntimeError("and good-bye")

    leave = bus.subscribe(leaving)
    seen: list[Event] = []
    bus.subscribe(seen.append)
    bus.publish(log("a"))
    assert [event.kind for event in seen] == ["log", "error"]


def test_events_that_a_listener_publishes_reach_everyone_in_the_same_order(bus: Bus) -> None:
    first: list[int] = []
    last: list[int] = []

    def answering(event: Event) -> None:
        if event.body == log("question"):
            bus.publish(log("answer"))

    bus.subscribe(lambda event: first.append(event.seq))
    bus.subscribe(answering)
    bus.subscribe(lambda event: last.append(event.seq))
    bus.publish(log("question"))
    assert first == last == [1, 2]


def test_threads_publish_without_losing_or_reordering_anything(bus: Bus) -> None:
    seen: list[Event] = []
    other: list[Event] = []
    bus.subscribe(seen.append)
    bus.subscribe(other.append)
    start = threading.Barrier(8)

    def publish(name: int) -> None:
        start.wait()
        for count in range(200):
            bus.publish(log(f"{name} {count}"))

    threads = [threading.Thread(target=publish, args=(name,)) for name in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [event.seq for event in seen] == list(range(1, 1601))
    assert seen == other
    for name in range(8):
        own = [e.body.message for e in seen if isinstance(e.body, Log) and e.body.message.startswith(f"{name} ")]
        assert own == [f"{name} {count}" for count in range(200)]


def test_a_bound_publisher_keeps_its_turn_and_epoch(bus: Bus) -> None:
    emit = bus.bound(turn="T", epoch=7)
    event = emit(log("a"))
    assert (event.turn, event.epoch) == ("T", 7)
