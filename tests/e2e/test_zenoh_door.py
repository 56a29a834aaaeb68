"""The door to a ROS 2 graph by zenoh: two doors, or a door and a bare zenoh session, through a real router."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from engine.errors import DeviceError, UsageError
from engine.ros.door import ACCEPT_S, Execution, Graph, Message, Outcome
from engine.ros.zenoh.door import ZenohDoor
from engine.ros.zenoh.wire import Attachment, Entity
from tests.zenoh_router import ACTION, SERVICE, Child, Router, session

TRIGGER = "std_srvs/srv/Trigger"
ADD = "example_interfaces/srv/AddTwoInts"
FIBONACCI = "test_msgs/action/Fibonacci"
STRING = "std_msgs/msg/String"
LIMIT_S = 20.0
"""For what takes a moment, on a machine that is busy."""


def until(true: Callable[[], object]) -> None:
    """Look again and again, for nothing tells of it."""
    pause, late = threading.Event(), time.monotonic() + LIMIT_S
    while not true():
        assert time.monotonic() < late
        pause.wait(0.01)


class Heard(list[Any]):
    """What came, in order."""

    def __init__(self) -> None:
        self._came = threading.Condition()

    def __call__(self, what: Any) -> None:
        with self._came:
            self.append(what)
            self._came.notify_all()

    def first(self, count: int = 1) -> Any:
        """The last of the first ``count``."""
        with self._came:
            assert self._came.wait_for(lambda: len(self) >= count, LIMIT_S)
        return self[count - 1]


@dataclass
class Counter:
    """Carries out a goal of Fibonacci: feedback for each number, and the end at once, or when it is told."""

    ends: bool = True
    executions: Heard = field(default_factory=Heard)
    cancelled: Heard = field(default_factory=Heard)

    def begin(self, execution: Execution) -> bool:
        if execution.goal["order"] < 0:
            return False
        self.executions(execution)
        for n in range(execution.goal["order"]):
            execution.feedback({"sequence": list(range(n))})
        if self.ends:
            execution.end("succeeded", {"sequence": list(range(execution.goal["order"]))})
        return True

    def cancel(self, execution: Execution) -> None:
        self.cancelled(execution)
        execution.end("canceled", {"sequence": [9]})


@pytest.fixture(scope="module")
def router() -> Iterator[Router]:
    found = Router()
    found.start()
    yield found
    found.kill()


@pytest.fixture
def own_router() -> Iterator[Router]:
    """One that this test alone starts and kills."""
    found = Router()
    yield found
    found.kill()


Open = Callable[..., ZenohDoor]


@pytest.fixture
def opened() -> Iterator[Open]:
    doors: list[ZenohDoor] = []

    def opened(router: Router, name: str = "sayso", **settings: Any) -> ZenohDoor:
        doors.append(ZenohDoor(router.locator, settings.pop("domain", 0), name=name, **settings))
        if router.child is not None:
            until(lambda: not doors[-1].trouble)
        return doors[-1]

    yield opened
    for door in doors:
        door.close()


def called(door: ZenohDoor, service: str, type: str, request: Message, limit_s: float = LIMIT_S) -> Outcome:
    outcome = Heard()
    door.call(service, type, request, outcome, limit_s=limit_s)
    found: Outcome = outcome.first()
    return found


def published(door: ZenohDoor, topic: str, text: str, heard: Heard) -> None:
    """Publish until it is heard: nothing tells a publisher when its first listener has come."""
    pause, late = threading.Event(), time.monotonic() + LIMIT_S
    while {"data": text} not in heard:
        assert time.monotonic() < late
        door.publish(topic, STRING, {"data": text})
        pause.wait(0.02)


def graph(door: ZenohDoor) -> Graph:
    found = Heard()
    door.graph(found)
    told: Graph = found.first()
    return told


def test_a_message_comes_through_in_the_thread_of_the_door(router: Router, opened: Open) -> None:
    ours, robot = opened(router), opened(router, "robot")
    heard, threads = Heard(), set()
    ours.subscribe("/a/chatter", STRING, lambda message: (threads.add(threading.current_thread().name), heard(message)))
    published(robot, "/a/chatter", "hello", heard)
    count = len(heard)
    for n in range(100):
        robot.publish("/a/chatter", STRING, {"data": str(n)}, every=True)
    heard.first(count + 100)
    assert heard[-100:] == [{"data": str(n)} for n in range(100)]
    assert threads == {"zenoh-door"}


def test_a_subscription_takes_no_more_than_it_wants_but_the_newest(router: Router, opened: Open) -> None:
    ours, robot = opened(router), opened(router, "robot")
    heard = Heard()
    ours.subscribe("/b", STRING, heard, every_s=0.3)
    published(robot, "/b", "first", heard)
    for n in range(50):
        robot.publish("/b", STRING, {"data": str(n)})
    until(lambda: heard[-1] == {"data": "49"})
    assert len(heard) < 10


def test_one_subscription_a_topic(router: Router, opened: Open) -> None:
    ours, robot = opened(router), opened(router, "robot")
    before, after = Heard(), Heard()
    ours.subscribe("/c", STRING, before)
    published(robot, "/c", "one", before)
    ours.subscribe("/c", STRING, after)
    published(robot, "/c", "two", after)
    assert {"data": "two"} not in before


def test_a_latched_message_reaches_who_comes_later_and_who_came_before(router: Router, opened: Open) -> None:
    ours, robot, late = opened(router), opened(router, "robot"), opened(router, "late")
    early, heard = Heard(), Heard()
    ours.subscribe("/map", STRING, early, latched=True)
    robot.publish("/map", STRING, {"data": "old"}, latched=True)
    robot.publish("/map", STRING, {"data": "new"}, latched=True)
    until(lambda: {"data": "new"} in early)
    late.subscribe("/map", STRING, heard, latched=True)
    assert heard.first() == {"data": "new"}
    plain = Heard()
    late.subscribe("/unlatched", STRING, plain, latched=True)
    published(robot, "/unlatched", "hello", plain)


def test_a_service_is_called_and_answered_later(router: Router, opened: Open) -> None:
    ours, robot = opened(router), opened(router, "robot")

    def answer(request: Message, reply: Any) -> None:
        threading.Timer(0.05, lambda: [reply({"sum": request["a"] + request["b"]}), reply({"sum": 0})]).start()

    robot.serve("/add", ADD, answer)
    assert called(ours, "/add", ADD, {"a": 2, "b": 3}) == Outcome("succeeded", {"sum": 5})
    assert called(robot, "/add", ADD, {"a": 2, "b": 4}).result == {"sum": 6}


def test_a_call_that_cannot_end_well_says_how(router: Router, opened: Open) -> None:
    ours, robot = opened(router), opened(router, "robot")
    robot.serve("/silent", TRIGGER, lambda request, reply: kept.append(reply))
    robot.serve("/odd", TRIGGER, lambda request, reply: reply({"success": "maybe", "message": 3}))
    kept: list[Any] = []
    begun = time.monotonic()
    assert called(ours, "/nobody", TRIGGER, {}).code == "no_server"
    assert time.monotonic() - begun < ACCEPT_S
    assert called(ours, "/silent", TRIGGER, {}, 0.3).code == "timed_out"
    assert called(ours, "/odd", TRIGGER, {}).code == "bad_type"
    assert "/odd" in robot.mismatches()
    assert called(ours, "/odd", "foo_msgs/srv/Foo", {}).code == "bad_type"
    assert called(ours, "/odd", TRIGGER, {"what": 1}).code == "bad_type"
    assert called(ours, "/odd", ADD, {}).why == f"robot serves it as {TRIGGER}, and here it is {ADD}"
    assert called(ours, "/not a name", TRIGGER, {}).code == "bad_type"


def test_a_goal_is_carried_out_with_feedback(router: Router, opened: Open) -> None:
    ours, robot = opened(router), opened(router, "robot")
    outcome, feedback = Heard(), Heard()
    robot.serve_action("/fib", FIBONACCI, Counter())
    ours.send_goal("/fib", FIBONACCI, {"order": 4}, outcome, feedback=feedback)
    assert outcome.first() == Outcome("succeeded", {"sequence": [0, 1, 2, 3]})
    feedback.first(4)
    assert feedback == [{"sequence": list(range(n))} for n in range(4)]


def test_a_goal_is_rejected(router: Router, opened: Open) -> None:
    ours, robot = opened(router), opened(router, "robot")
    outcome = Heard()
    robot.serve_action("/picky", FIBONACCI, Counter())
    ours.send_goal("/picky", FIBONACCI, {"order": -1}, outcome)
    assert outcome.first().code == "rejected"


def test_a_goal_is_cancelled_while_it_is_carried_out(router: Router, opened: Open) -> None:
    ours, robot = opened(router), opened(router, "robot")
    outcome, work = Heard(), Counter(ends=False)
    robot.serve_action("/slow", FIBONACCI, work)
    goal = ours.send_goal("/slow", FIBONACCI, {"order": 1}, outcome)
    work.executions.first()
    goal.cancel()
    goal.cancel()
    found = outcome.first()
    assert (found.code, found.result) == ("canceled", {"sequence": [9]})
    assert len(work.cancelled) == 1
    goal.cancel()


def test_a_goal_that_is_cancelled_before_it_is_taken_is_not_carried_out(router: Router, opened: Open) -> None:
    ours, robot = opened(router), opened(router, "robot")
    outcome, work = Heard(), Counter(ends=False)
    robot.serve_action("/slower", FIBONACCI, work)
    ours.send_goal("/slower", FIBONACCI, {"order": 1}, outcome).cancel()
    assert outcome.first().code == "canceled"
    assert len(work.executions) == len(work.cancelled), "it may have been on its way"


def test_a_goal_that_lasts_too_long_is_cancelled(router: Router, opened: Open) -> None:
    ours, robot = opened(router), opened(router, "robot")
    outcome, work = Heard(), Counter(ends=False)
    robot.serve_action("/endless_a", FIBONACCI, work)
    ours.send_goal("/endless_a", FIBONACCI, {"order": 0}, outcome, limit_s=1.5)
    assert outcome.first().code == "timed_out"
    work.cancelled.first()
    assert len(outcome) == 1


def test_goals_of_one_action_have_each_their_own_end(router: Router, opened: Open) -> None:
    ours, robot = opened(router), opened(router, "robot")
    work = Counter(ends=False)
    robot.serve_action("/many", FIBONACCI, work)
    outcomes = [Heard() for _ in range(3)]
    goals = [ours.send_goal("/many", FIBONACCI, {"order": n}, outcome) for n, outcome in enumerate(outcomes)]
    work.executions.first(3)
    goals[1].cancel()
    assert outcomes[1].first().code == "canceled"
    by_order = {execution.goal["order"]: execution for execution in work.executions}
    by_order[2].end("aborted", {"sequence": [2]})
    by_order[2].end("succeeded", {})
    assert outcomes[2].first().code == "aborted"
    by_order[0].end("succeeded", {"sequence": [7]})
    assert outcomes[0].first() == Outcome("succeeded", {"sequence": [7]})


def test_anybody_may_cancel_all_goals_and_sees_how_they_are(router: Router, opened: Open) -> None:
    ours, robot, other = opened(router), opened(router, "robot"), opened(router, "other")
    outcome, work, states = Heard(), Counter(ends=False), Heard()
    robot.serve_action("/open", FIBONACCI, work)
    ours.send_goal("/open", FIBONACCI, {"order": 0}, outcome)
    work.executions.first()
    other.subscribe("/open/_action/status", "action_msgs/msg/GoalStatusArray", states, latched=True)
    until(lambda: states and states[-1]["status_list"][0]["status"] == 2)
    service, type = "/open/_action/cancel_goal", "action_msgs/srv/CancelGoal"
    unknown = called(other, service, type, {"goal_info": {"goal_id": {"uuid": bytes([7] * 16)}}})
    assert unknown.result == {"return_code": 2, "goals_canceling": []}
    everything = called(other, service, type, {})
    assert (everything.result["return_code"], len(everything.result["goals_canceling"])) == (0, 1)
    assert outcome.first().code == "canceled"
    until(lambda: states[-1]["status_list"][0]["status"] == 5)


def test_a_goal_without_a_server_ends_soon(router: Router, opened: Open) -> None:
    outcome, begun = Heard(), time.monotonic()
    opened(router).send_goal("/nobody_does", FIBONACCI, {"order": 1}, outcome)
    assert outcome.first().code == "no_server"
    assert time.monotonic() - begun < ACCEPT_S


def test_a_server_that_dies_ends_calls_and_goals(router: Router, opened: Open) -> None:
    ours = opened(router)
    idle = Child(router.port, "--idle")
    answer, outcome = Heard(), Heard()
    until(lambda: ACTION in graph(ours).actions)
    ours.call(SERVICE, TRIGGER, {}, answer, limit_s=LIMIT_S)
    ours.send_goal(ACTION, FIBONACCI, {"order": 1}, outcome)
    until(lambda: ours._clients.waiting(f"{ACTION}/_action/get_result") and ours._clients.waiting(SERVICE))
    idle.kill()
    assert answer.first().code == "lost"
    assert outcome.first().code == "lost"
    until(lambda: called(ours, SERVICE, TRIGGER, {}).code == "no_server")


def test_a_robot_sees_what_we_have_and_we_see_what_it_has(router: Router, opened: Open) -> None:
    ours, robot, elsewhere = opened(router), opened(router, "robot"), opened(router, "elsewhere", domain=7)
    robot.publish("/d", STRING, {"data": ""})
    robot.subscribe("/e", "geometry_msgs/msg/Twist", lambda message: None)
    robot.serve("/f", TRIGGER, lambda request, reply: None)
    robot.serve_action("/g", FIBONACCI, Counter())
    until(lambda: {"/g"} <= graph(ours).actions.keys())
    found = graph(ours)
    assert found.why == ""
    assert {"/d": STRING, "/e": "geometry_msgs/msg/Twist"}.items() <= found.topics.items()
    assert found.services["/f"] == TRIGGER
    assert found.actions["/g"] == FIBONACCI
    assert not any("_action" in name for name in (*found.topics, *found.services))
    assert graph(elsewhere) == Graph()
    parts = {entity.endpoint.name: entity.kind for entity in tokens_of(router) if entity.endpoint is not None}
    assert {"/g/_action/feedback": "MP", "/g/_action/status": "MP"}.items() <= parts.items()  # rcl looks for them
    robot.close()
    until(lambda: "/g" not in graph(ours).actions)


def test_a_peer_that_means_another_type_is_told_of(router: Router, opened: Open, tmp_path: Path) -> None:
    path = tmp_path / "std_msgs" / "msg" / "String.msg"
    path.parent.mkdir(parents=True)
    path.write_text("string data\nstring language\n")
    ours, robot = opened(router), opened(router, "robot", definitions=[tmp_path])
    ours.subscribe("/h", STRING, lambda message: None)
    ours.subscribe("/i", "foo_msgs/msg/Foo", lambda message: None)
    robot.publish("/h", STRING, {"language": "en"})
    until(lambda: "/h" in ours.mismatches())
    assert "robot publishes it as std_msgs/msg/String, but with other fields" in ours.mismatches()["/h"]
    assert "No definition of foo_msgs/msg/Foo" in ours.mismatches()["/i"]


def test_what_makes_no_sense_is_dropped(router: Router, opened: Open) -> None:
    ours = opened(router)
    peer = session(router.port, "client")
    heard, asked = Heard(), Heard()
    ours.subscribe("/j", STRING, heard)
    ours.serve("/k", TRIGGER, lambda request, reply: [asked(request), reply({"success": True})])
    until(lambda: len(ours._node._announced) == 2)
    topic, service = (entity.endpoint.key(0) for entity in ours._node._announced.values() if entity.endpoint)
    attachment = Attachment(1, 1, bytes(16)).pack()
    good = b"\0\1\0\0\0"
    for data, about in [(b"", attachment), (b"\xff" * 9, attachment), (good, None), (good, b"x"), (good, attachment)]:
        peer.put(topic, data, attachment=about)
        reply = next(iter(peer.get(service, payload=data, attachment=about, timeout=LIMIT_S)))
        assert (reply.ok is not None) == (data == good and about == attachment)
    assert asked == [{}]
    peer.put(topic, b"\0\1\0\0\3\0\0\0hi\0", attachment=attachment)
    assert heard.first() == {"data": "hi"}
    peer.close()


def test_a_router_that_is_not_there_is_trouble_and_no_error(own_router: Router, opened: Open) -> None:
    ours, robot = opened(own_router), opened(own_router, "robot")
    heard, outcome = Heard(), Heard()
    ours.subscribe("/l", STRING, heard)
    robot.serve("/m", TRIGGER, lambda request, reply: reply({"success": True}))
    until(lambda: "cannot be reached" in ours.trouble)
    ours.publish("/l", STRING, {"data": "nobody hears"})
    assert called(ours, "/m", TRIGGER, {}).code == "lost"
    ours.send_goal("/n", FIBONACCI, {}, outcome)
    assert outcome.first().code == "lost"
    assert "cannot be reached" in graph(ours).why
    own_router.start()
    until(lambda: not ours.trouble and not robot.trouble)
    published(robot, "/l", "hello", heard)
    assert called(ours, "/m", TRIGGER, {}).code == "succeeded"
    assert {"data": "nobody hears"} not in heard


def test_everything_holds_when_the_router_comes_back(own_router: Router, opened: Open) -> None:
    own_router.start()
    ours, robot = opened(own_router), opened(own_router, "robot")
    heard, answer, outcome, work = Heard(), Heard(), Heard(), Counter(ends=False)
    kept: list[Any] = []
    ours.subscribe("/o", STRING, heard)
    robot.serve("/p", TRIGGER, lambda request, reply: kept.append(reply))
    robot.serve("/q", TRIGGER, lambda request, reply: reply({"success": True}))
    robot.serve_action("/r", FIBONACCI, work)
    published(robot, "/o", "before", heard)
    assert called(ours, "/q", TRIGGER, {}).code == "succeeded"
    ours.call("/p", TRIGGER, {}, answer, limit_s=LIMIT_S)
    ours.send_goal("/r", FIBONACCI, {"order": 0}, outcome)
    work.executions.first()
    until(lambda: kept)
    own_router.kill()
    assert answer.first().code == "lost"
    assert outcome.first().code == "lost"
    work.cancelled.first()
    until(lambda: "is gone" in ours.trouble and "is gone" in robot.trouble)
    own_router.start()
    begun = time.monotonic()
    until(lambda: not ours.trouble and not robot.trouble)
    assert time.monotonic() - begun < 3.0
    published(robot, "/o", "after", heard)
    until(lambda: called(ours, "/q", TRIGGER, {}).code == "succeeded")
    work.ends = True
    again = Heard()
    ours.send_goal("/r", FIBONACCI, {"order": 2}, again)
    assert again.first().code == "succeeded"
    assert {"/q", "/p"} <= graph(ours).services.keys()


def test_a_router_that_answers_no_more_is_noticed(own_router: Router, opened: Open) -> None:
    own_router.start()
    ours, robot = opened(own_router), opened(own_router, "robot")
    kept: list[Any] = []
    answer, heard = Heard(), Heard()
    robot.serve("/s", TRIGGER, lambda request, reply: kept.append(reply))
    ours.subscribe("/t", STRING, heard)
    until(lambda: "/s" in graph(ours).services)
    ours.call("/s", TRIGGER, {}, answer, limit_s=LIMIT_S)
    until(lambda: kept)
    assert own_router.child is not None
    with own_router.child.stopped():
        until(lambda: "does not answer" in ours.trouble)
        assert answer.first().code == "lost"
        begun = time.monotonic()
        for _ in range(100):
            ours.publish("/u", "sensor_msgs/msg/Image", {"data": bytes(100_000)})
        assert time.monotonic() - begun < 1.0
    until(lambda: not ours.trouble and not robot.trouble)
    published(robot, "/t", "hello", heard)
    assert "/s" in graph(ours).services
    ours.call("/s", TRIGGER, {}, answer)
    until(lambda: len(kept) == 2)
    kept[1]({"success": True})
    assert answer.first(2).code == "succeeded"


def test_what_was_published_has_gone_out_when_the_door_is_closed(router: Router, opened: Open) -> None:
    ours, robot = opened(router), opened(router, "robot")
    heard, outcome = Heard(), Heard()
    ours.subscribe("/v", STRING, heard)
    published(robot, "/v", "first", heard)
    for n in range(50):
        robot.publish("/v", STRING, {"data": str(n)}, every=True)
    robot.close()
    until(lambda: heard[-1] == {"data": "49"})
    assert robot.trouble == "it has been closed"
    robot.publish("/v", STRING, {"data": "late"})
    robot.subscribe("/v", STRING, heard)
    robot.call("/v", TRIGGER, {}, outcome)
    robot.send_goal("/v", FIBONACCI, {}, outcome).cancel()
    robot.graph(outcome)
    outcome.first(3)
    assert [found.code for found in outcome[:2]] == ["lost", "lost"]
    assert outcome[2].why
    robot.close()


def test_a_door_may_be_closed_from_within_and_ends_what_it_began(router: Router, opened: Open) -> None:
    ours, robot = opened(router), opened(router, "robot")
    answer, outcome, work, kept = Heard(), Heard(), Counter(ends=False), []
    robot.serve("/w", TRIGGER, lambda request, reply: kept.append(reply))
    robot.serve_action("/x", FIBONACCI, work)
    until(lambda: "/x" in graph(ours).actions)
    ours.call("/w", TRIGGER, {}, answer)
    ours.send_goal("/x", FIBONACCI, {"order": 0}, outcome)
    work.executions.first()
    ours.graph(lambda found: ours.close())
    assert answer.first().code == "lost"
    assert outcome.first().code == "lost"
    until(lambda: all(entity.session != str(ours._node.session.zid()) for entity in tokens_of(router)))


def test_a_door_with_no_address_is_an_error_of_its_user() -> None:
    with pytest.raises(UsageError, match="no address"):
        ZenohDoor("nonsense", 0)


@pytest.mark.parametrize("package", ["zenoh", "rosbags.typesys"])
def test_a_package_that_is_not_installed_is_named(monkeypatch: pytest.MonkeyPatch, package: str) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(DeviceError, match=r"sayso\[ros\]"):
        ZenohDoor("tcp/127.0.0.1:1", 0)
    assert not [thread for thread in threading.enumerate() if thread.name == "zenoh-door"]


def tokens_of(router: Router) -> list[Entity]:
    with session(router.port, "client") as peer:
        found = [Entity.parse(str(reply.ok.key_expr)) for reply in peer.liveliness().get("@ros2_lv/0/**") if reply.ok]
    return [entity for entity in found if entity is not None]
