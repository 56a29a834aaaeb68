"""The door by rclpy: sayso as a node of its own, where it runs inside an installation of ROS 2 (Jazzy or later).

Types are imported by name from their packages, so all that are installed can be used. What rclpy does, it does in one
thread (:mod:`engine.ros.rclpy.loop`).
"""

from __future__ import annotations

import functools
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from engine.ros.door import CALL_S, Code, Goal, Graph, Message, Outcome, Reply, Take, Then, Work
from engine.ros.rclpy.goals import ActionServer, SentGoal
from engine.ros.rclpy.loop import Loop
from engine.ros.rclpy.messages import BadTypeError, find_type, made_by, to_message
from engine.ros.rclpy.services import Call, serve
from engine.ros.rclpy.topics import How, Publisher, subscribe

LEAVE_S: Final = 0.3
"""In which what was published last goes out before the door is shut."""
_CLOSE_S: Final = 5.0


class RclpyDoor:
    """A :class:`engine.ros.door.Door` by rclpy."""

    def __init__(self, name: str = "sayso", *, domain: int | None = None, arguments: Sequence[str] = ()) -> None:
        """Join the graph in the background, as the node ``name``; ``domain`` is ``ROS_DOMAIN_ID`` where it is None, and
        ``arguments`` are what follows ``--ros-args``. Raises RobotError where there is no rclpy."""
        self._loop = Loop(name, domain, arguments)
        self._lock = threading.Lock()
        self._waiting: dict[str, tuple[str, list[tuple[Message, bool]]]] = {}  # to be published, by topic
        self._open: set[_Open] = set()  # calls and goals that have not ended
        self._looking: list[Callable[[Graph], object]] = []  # who wants to know the graph
        self._publishers: dict[str, Publisher] = {}
        self._subscriptions: dict[str, Any] = {}
        self._clients: dict[tuple[str, str], Any] = {}
        self._action_clients: dict[tuple[str, str], Any] = {}
        self._services: dict[str, Any] = {}
        self._actions: dict[str, ActionServer | None] = {}
        self._loop.start(self._leave)

    @property
    def trouble(self) -> str:
        return self._loop.trouble

    def mismatches(self) -> Mapping[str, str]:
        return dict(self._loop.wrong)

    def advertise(self, topic: str, type: str) -> None:
        with self._lock:
            self._waiting.setdefault(topic, (type, []))
        self._loop.soon(lambda: self._send(topic))

    def publish(self, topic: str, type: str, message: Message, *, every: bool = False) -> None:
        with self._lock:
            _, waiting = self._waiting.setdefault(topic, (type, []))
            if not every:
                waiting[:] = [one for one in waiting if one[1]]
            waiting.append((message, every))
        if not self._loop.soon(lambda: self._send(topic)):
            self._waiting.clear()

    def subscribe(
        self,
        topic: str,
        type: str,
        take: Take,
        *,
        every_s: float = 0.0,
        latched: bool = False,
        every: bool = False,
    ) -> None:
        how = How(every_s, latched, every)
        self._loop.soon(lambda: self._subscribe(topic, type, take, how))

    def call(self, service: str, type: str, request: Message, then: Then, *, limit_s: float = CALL_S) -> None:
        one = _Open(self, then)
        if not self._loop.soon(lambda: self._call(service, type, request, one, limit_s)):
            one.end(Outcome("lost", why=self.trouble))

    def send_goal(
        self,
        action: str,
        type: str,
        goal: Message,
        then: Then,
        *,
        feedback: Take = lambda message: None,
        limit_s: float | None = None,
    ) -> Goal:
        one = _Open(self, then)
        sent = SentGoal(self._loop, action, goal, one.end, feedback, limit_s)
        if not self._loop.soon(lambda: self._send_goal(sent, type)):
            one.end(Outcome("lost", why=self.trouble))
        return sent

    def serve(self, service: str, type: str, answer: Callable[[Message, Reply], object]) -> None:
        self._loop.soon(lambda: self._serve(service, type, answer))

    def serve_action(self, action: str, type: str, work: Work) -> None:
        self._loop.soon(lambda: self._serve_action(action, type, work))

    def graph(self, then: Callable[[Graph], object]) -> None:
        with self._lock:
            self._looking.append(then)
        if not self._loop.soon(lambda: self._loop.later(self._loop.young_s, self._look)):
            self._tell(Graph(why=self.trouble))

    def close(self) -> None:
        self._loop.close(_CLOSE_S)

    # In the loop

    def _type(self, used_by: str, type: str, kind: str) -> Any | None:
        """The class of a type; None where there is none, which is in ``wrong`` then."""
        try:
            found = find_type(type, kind)
        except BadTypeError as error:
            self._loop.wrong[used_by] = str(error)
            return None
        self._loop.wrong.pop(used_by, None)
        return found

    def _make(self, name: str, create: Callable[[], Any]) -> Any | None:
        """What this makes, None where it cannot be made, which is in ``wrong`` then."""
        try:
            return made_by(create)
        except BadTypeError as error:
            self._loop.wrong[name] = f"{name} cannot be used: {error}"
            return None

    def _send(self, topic: str) -> None:
        if topic not in self._publishers:
            with self._lock:
                type, _ = self._waiting.get(topic, ("", ()))
            found = self._type(topic, type, "msg") if type else None
            made = found and self._make(topic, lambda: Publisher(self._loop, topic, found, lambda: self._send(topic)))
            if made is None:
                with self._lock:
                    self._waiting.pop(topic, None)
                return
            self._publishers[topic] = made
        publisher = self._publishers[topic]
        if not publisher.ready:
            return
        with self._lock:
            _, waiting = self._waiting.pop(topic, ("", []))
        for message, _ in waiting:
            try:
                publisher.publish(message)
            except BadTypeError as error:
                self._loop.wrong[topic] = str(error)

    def _subscribe(self, topic: str, type: str, take: Take, how: How) -> None:
        if (old := self._subscriptions.pop(topic, None)) is not None:
            self._loop.node.destroy_subscription(old)
        if (found := self._type(topic, type, "msg")) is not None:
            lossy = replace(how, every=False)

            def unfit() -> None:
                """A publisher that loses messages is heard by one that does not mind alone."""
                if how.every and not how.latched:
                    self._loop.soon(lambda: self._subscribe(topic, type, take, lossy))

            made = self._make(topic, lambda: subscribe(self._loop, topic, found, take, how, unfit))
            self._subscriptions[topic] = made

    def _call(self, service: str, type: str, request: Message, one: _Open, limit_s: float) -> None:
        try:
            found = find_type(type, "srv")
            call = Call(self._loop, service, to_message(found.Request, request), limit_s, one.end)
        except BadTypeError as error:
            one.end(Outcome("bad_type", why=str(error)))
            return
        node = self._loop.node
        client = self._clients.get((service, type))
        if client is None:
            try:
                client = self._clients[service, type] = made_by(lambda: node.create_client(found, service))
            except BadTypeError as error:
                one.end(Outcome("bad_type", why=str(error)))
                return
        call.start(client, lambda: self._absent(service, type, _services(node)))

    def _send_goal(self, goal: SentGoal, type: str) -> None:
        from rclpy.action import ActionClient  # type: ignore[import-not-found]

        client = self._action_clients.get((goal.action, type))
        if client is None:
            try:
                found = find_type(type, "action")
                client = made_by(lambda: ActionClient(self._loop.node, found, goal.action))
            except BadTypeError as error:
                goal.over("bad_type", why=str(error))
                return
            self._action_clients[goal.action, type] = client

        def wrong_type() -> str:
            absent = self._absent(goal.action, type, _actions(self._loop.node))
            return absent.why if absent.code == "bad_type" else ""

        goal.start(client, wrong_type)

    def _absent(self, name: str, type: str, known: list[tuple[str, list[str]]]) -> Outcome:
        """Why nobody serves this name with this type."""
        full = self._loop.node.resolve_service_name(name)
        others = [there for called, types in known if called == full for there in types if there != type]
        code: Code = "bad_type" if others else "no_server"
        return Outcome(code, why=f"{name} is a {others[0]}, no {type}" if others else f"nobody serves {name}")

    def _serve(self, service: str, type: str, answer: Callable[[Message, Reply], object]) -> None:
        if (old := self._services.pop(service, None)) is not None:
            self._loop.node.destroy_service(old)
        if (found := self._type(service, type, "srv")) is not None:
            wrong = functools.partial(self._loop.wrong.__setitem__, service)
            made = self._make(service, lambda: serve(self._loop, service, found, answer, wrong))
            self._services[service] = made

    def _serve_action(self, action: str, type: str, work: Work) -> None:
        if (old := self._actions.pop(action, None)) is not None:
            old.destroy()
        if (found := self._type(action, type, "action")) is not None:
            made = self._make(action, lambda: ActionServer(self._loop, action, found, work))
            self._actions[action] = made

    def _look(self) -> None:
        node = self._loop.node
        self._tell(
            Graph(
                _shown(node.get_topic_names_and_types()),
                _shown(_services(node)),
                _shown(_actions(node)),
            )
        )

    def _tell(self, graph: Graph) -> None:
        with self._lock:
            looking, self._looking = self._looking, []
        for then in looking:
            self._loop.call(then, graph)

    def _leave(self) -> None:
        until = time.monotonic() + LEAVE_S
        for topic in list(self._waiting):
            if topic in self._publishers:
                self._publishers[topic].ready = True
                self._send(topic)
        for publisher in self._publishers.values():
            publisher.wait(until - time.monotonic())
        for server in filter(None, self._actions.values()):
            server.destroy()
        self._tell(Graph(why=self.trouble))
        for one in list(self._open):
            one.end(Outcome("lost", why=self.trouble))


class _Open:
    """A call or a goal that has not ended."""

    def __init__(self, door: RclpyDoor, then: Then) -> None:
        self._door, self._then = door, then
        door._open.add(self)

    def end(self, outcome: Outcome) -> None:
        if self in self._door._open:
            self._door._open.discard(self)
            self._door._loop.call(self._then, outcome)


def _services(node: Any) -> list[tuple[str, list[str]]]:
    """Those that are served; rclpy tells those that are only called, too."""
    return [known for known in node.get_service_names_and_types() if node.count_services(known[0])]


def _actions(node: Any) -> list[tuple[str, list[str]]]:
    from rclpy.action import get_action_names_and_types

    known = get_action_names_and_types(node)
    return [one for one in known if node.count_services(f"{one[0]}/_action/send_goal")]


def _shown(known: list[tuple[str, list[str]]]) -> dict[str, str]:
    """Without what ROS hides: names of which a part begins with an underscore."""
    return {name: types[0] for name, types in known if types and "/_" not in name}
