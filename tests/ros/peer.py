"""A node of rclpy that the tests meet in the graph: ``.ros/bin/python -m tests.ros.peer``. It shares no code with the
doors. It does what a peer may do, good and bad, and besides what it is told in JSON lines.

| it serves | and does |
|---|---|
| /peer/set (SetBool) | answers with what it was asked |
| /peer/mute (Trigger) | never answers |
| /peer/slow (Fibonacci) | a step of the sequence every STEP_S, with feedback; lets itself be cancelled |
| /peer/stubborn | the same, but refuses to be cancelled |
| /peer/picky | takes no goal |
| /peer/failing | aborts after two steps |
| /peer/dying | is gone, as in a crash, after two steps |
"""

from __future__ import annotations

import importlib
import os
import threading
import time
from collections.abc import Mapping
from typing import Any

import rclpy  # type: ignore[import-not-found]
from rclpy.action import (  # type: ignore[import-not-found]
    ActionClient,
    ActionServer,
    CancelResponse,
    GoalResponse,
)
from rclpy.callback_groups import (  # type: ignore[import-not-found]
    MutuallyExclusiveCallbackGroup,
    ReentrantCallbackGroup,
)
from rclpy.executors import MultiThreadedExecutor  # type: ignore[import-not-found]
from rclpy.qos import DurabilityPolicy, QoSProfile  # type: ignore[import-not-found]
from std_srvs.srv import SetBool, Trigger  # type: ignore[import-not-found]
from test_msgs.action import Fibonacci  # type: ignore[import-not-found]

from tests.ros.lines import Line, read, write

STEP_S = 0.02
ENDS = {4: "succeeded", 5: "canceled", 6: "aborted"}


class Peer:
    """The node and what it has begun."""

    def __init__(self) -> None:
        rclpy.init()
        self.node = rclpy.create_node("peer", enable_rosout=False, start_parameter_services=False)
        self._group = ReentrantCallbackGroup()
        self._publishers: dict[str, Any] = {}
        self._clients: dict[str, Any] = {}
        self._goals: dict[str, Any] = {}
        self._cancelled: set[str] = set()
        self._never = threading.Event()
        self.node.create_service(SetBool, "/peer/set", self._set, callback_group=self._group)
        self.node.create_service(Trigger, "/peer/mute", self._mute, callback_group=self._group)
        self._servers = [self._server(name) for name in ("slow", "stubborn", "picky", "failing", "dying")]

    def spin(self) -> None:
        executor = MultiThreadedExecutor(8)
        executor.add_node(self.node)
        executor.spin()

    # What it serves

    def _set(self, request: Any, response: Any) -> Any:
        response.success, response.message = request.data, f"it was {request.data}"
        return response

    def _mute(self, request: Any, response: Any) -> Any:
        self._never.wait()
        return response

    def _server(self, name: str) -> Any:
        taken = GoalResponse.REJECT if name == "picky" else GoalResponse.ACCEPT
        cancels = CancelResponse.REJECT if name == "stubborn" else CancelResponse.ACCEPT
        return ActionServer(
            self.node,
            Fibonacci,
            f"/peer/{name}",
            execute_callback=lambda goal: self._carry_out(name, goal),
            goal_callback=lambda request: taken,
            cancel_callback=lambda goal: cancels,
            callback_group=self._group,
        )

    def _carry_out(self, name: str, goal: Any) -> Any:
        sequence = [0, 1]
        result, feedback = Fibonacci.Result(), Fibonacci.Feedback()
        for step in range(goal.request.order):
            time.sleep(STEP_S)  # carrying out takes its time
            if goal.is_cancel_requested:
                goal.canceled()
                break
            if name in ("failing", "dying") and step == 2:
                if name == "dying":
                    os._exit(1)
                goal.abort()
                break
            sequence.append(sequence[-1] + sequence[-2])
            feedback.sequence = [number % 2**31 for number in sequence]
            goal.publish_feedback(feedback)
        else:
            goal.succeed()
        result.sequence = [number % 2**31 for number in sequence]
        return result

    # What it is told

    def do(self, line: Line) -> None:
        getattr(self, f"do_{line.pop('do')}")(**line)

    def do_publish(self, topic: str, type: str, message: Line, latched: bool, wait_s: float) -> None:
        if topic not in self._publishers:
            durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
            qos = QoSProfile(depth=10, durability=durability)
            self._publishers[topic] = made = self.node.create_publisher(_class(type), topic, qos)
            end = time.monotonic() + wait_s
            while not made.get_subscription_count() and time.monotonic() < end:
                self._never.wait(STEP_S)  # rclpy has an event for it, which is not always told
        self._publishers[topic].publish(_filled(_class(type)(), message))

    def do_listen(self, topic: str, type: str) -> None:
        def heard(message: Any) -> None:
            write({"heard": topic, "message": _plain(message)})

        in_order = MutuallyExclusiveCallbackGroup()
        self.node.create_subscription(_class(type), topic, heard, 10, callback_group=in_order)
        write({"listening": topic})

    def do_call(self, id: str, service: str, type: str, request: Line, limit_s: float) -> None:
        client = self.node.create_client(_class(type), service, callback_group=self._group)

        def call() -> None:
            if not client.wait_for_service(limit_s):
                write({"response": id, "message": None})
                return
            future = client.call_async(_filled(_class(type).Request(), request))
            future.add_done_callback(answered)

        def answered(done: Any) -> None:
            write({"response": id, "message": _plain(done.result())})
            self.node.destroy_client(client)  # a bridge takes a service to be there as long as it has a client

        threading.Thread(target=call, daemon=True).start()

    def do_goal(self, id: str, action: str, type: str, goal: Line) -> None:
        if action not in self._clients:
            self._clients[action] = ActionClient(self.node, _class(type), action, callback_group=self._group)
        client = self._clients[action]

        def taken(done: Any) -> None:
            handle = done.result()
            write({"accepted": id, "yes": handle.accepted})
            if handle.accepted:
                self._goals[id] = handle
                if id in self._cancelled:
                    handle.cancel_goal_async()
                handle.get_result_async().add_done_callback(ended)

        def ended(done: Any) -> None:
            found = done.result()
            write({"ended": id, "how": ENDS.get(found.status, "?"), "result": _plain(found.result)})

        def send() -> None:
            if client.wait_for_server(10.0):
                client.send_goal_async(
                    _filled(_class(type).Goal(), goal),
                    feedback_callback=lambda told: write({"progress": id, "message": _plain(told.feedback)}),
                ).add_done_callback(taken)

        threading.Thread(target=send, daemon=True).start()

    def do_cancel(self, id: str) -> None:
        self._cancelled.add(id)
        if id in self._goals:
            self._goals[id].cancel_goal_async()


def _class(name: str) -> Any:
    package, kind, own = name.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), own)


def _filled(message: Any, fields: Mapping[str, Any]) -> Any:
    for name, value in fields.items():
        if isinstance(value, Mapping):
            _filled(getattr(message, name), value)
        else:
            setattr(message, name, value)
    return message


def _plain(value: Any) -> Any:
    if hasattr(value, "get_fields_and_field_types"):
        return {name: _plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, str | bytes | bool | int | float):
        return value
    return [_plain(one) for one in value]


def main() -> None:
    peer = Peer()
    threading.Thread(target=peer.spin, daemon=True).start()
    write({"ready": True})
    for line in read():
        peer.do(line)
    os._exit(0)  # what is mute has no end


if __name__ == "__main__":
    main()
