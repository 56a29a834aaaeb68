"""Who the tests meet in a graph, as the tests see them. For a graph of rclpy it is :mod:`tests.ros.peer`. For one of
zenoh it is a second door in a program of its own: there is no wheel of rmw_zenoh, so no foreign node is met there.
"""

from __future__ import annotations

import functools
import itertools
import queue
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from engine.ros.door import Execution, Message, Reply
from tests.ros.lines import Line, Program
from tests.ros.remote import RemoteDoor

START_S = 20.0
CALL_S = 10.0
STEP_S = 0.02
FIBONACCI = "test_msgs/action/Fibonacci"
SERVERS = ("slow", "stubborn", "picky", "failing", "dying")
Heard = queue.SimpleQueue[Any]


@dataclass
class PeerGoal:
    """A goal that a peer has sent to us."""

    cancel: Callable[[], object]
    accepted: Heard = field(default_factory=queue.SimpleQueue)
    feedback: Heard = field(default_factory=queue.SimpleQueue)
    ended: Heard = field(default_factory=queue.SimpleQueue)
    """How, and with which result."""


class Peer(Protocol):
    """A node of the graph that does what it is told, besides what :mod:`tests.ros.peer` lists."""

    def publish(self, topic: str, type: str, message: Message, *, latched: bool = False) -> None: ...

    def listen(self, topic: str, type: str) -> Heard: ...

    def call(self, service: str, type: str, request: Message, *, limit_s: float = CALL_S) -> Heard:
        """Its response, or None where nobody has been there to answer in this time."""
        ...

    def goal(self, action: str, type: str, goal: Message) -> PeerGoal: ...

    def close(self) -> None: ...

    def kill(self) -> None: ...


class RosPeer:
    """The one of rclpy."""

    def __init__(self, python: Path, surroundings: Mapping[str, str]) -> None:
        self._ids = itertools.count(1)
        self._ready = threading.Event()
        self._topics: dict[str, Heard] = {}
        self._calls: dict[str, Heard] = {}
        self._goals: dict[str, PeerGoal] = {}
        self.program = Program([python, "-m", "tests.ros.peer"], surroundings, self._hear)
        assert self._ready.wait(START_S), "the peer does not start"

    def publish(self, topic: str, type: str, message: Message, *, latched: bool = False, wait_s: float = 0.0) -> None:
        """The first one on a topic waits so long at most until somebody listens."""
        told = {"topic": topic, "type": type, "message": message, "latched": latched, "wait_s": wait_s}
        self.program.tell({"do": "publish", **told})

    def listen(self, topic: str, type: str) -> Heard:
        self._topics[topic] = queue.SimpleQueue()
        self.program.tell({"do": "listen", "topic": topic, "type": type})
        return self._topics[topic]

    def call(self, service: str, type: str, request: Message, *, limit_s: float = CALL_S) -> Heard:
        id = str(next(self._ids))
        self._calls[id] = queue.SimpleQueue()
        told = {"service": service, "type": type, "request": request, "limit_s": limit_s}
        self.program.tell({"do": "call", "id": id, **told})
        return self._calls[id]

    def goal(self, action: str, type: str, goal: Message) -> PeerGoal:
        id = str(next(self._ids))
        self._goals[id] = PeerGoal(lambda: self.program.tell({"do": "cancel", "id": id}))
        self.program.tell({"do": "goal", "id": id, "action": action, "type": type, "goal": goal})
        return self._goals[id]

    def close(self) -> None:
        self.program.close()

    def kill(self) -> None:
        self.program.kill()

    def _hear(self, line: Line) -> None:
        match line:
            case {"ready": _}:
                self._ready.set()
            case {"heard": topic, "message": message}:
                self._topics[topic].put(message)
            case {"response": id, "message": message}:
                self._calls[id].put(message)
            case {"accepted": id, "yes": yes}:
                self._goals[id].accepted.put(yes)
            case {"progress": id, "message": message}:
                self._goals[id].feedback.put(message)
            case {"ended": id, "how": how, "result": result}:
                self._goals[id].ended.put((how, result))


class DoorPeer:
    """One that is a door itself, and serves the same."""

    def __init__(self, door: RemoteDoor) -> None:
        self._door = door
        door.serve("/peer/set", "std_srvs/srv/SetBool", _set)
        door.serve("/peer/mute", "std_srvs/srv/Trigger", lambda message, reply: None)
        for name in SERVERS:
            door.serve_action(f"/peer/{name}", FIBONACCI, _Server(name, self.kill))

    def publish(self, topic: str, type: str, message: Message, *, latched: bool = False) -> None:
        assert not latched, "no door latches"
        self._door.publish(topic, type, message, every=True)

    def listen(self, topic: str, type: str) -> Heard:
        heard: Heard = queue.SimpleQueue()
        self._door.subscribe(topic, type, heard.put)
        return heard

    def call(self, service: str, type: str, request: Message, *, limit_s: float = CALL_S) -> Heard:
        heard: Heard = queue.SimpleQueue()
        self._door.call(service, type, request, lambda outcome: heard.put(outcome.result or None), limit_s=limit_s)
        return heard

    def goal(self, action: str, type: str, goal: Message) -> PeerGoal:
        made = PeerGoal(lambda: sent.cancel())

        def ended(outcome: Any) -> None:
            if outcome.code == "rejected":
                made.accepted.put(False)
            else:
                made.accepted.put(True)
                made.ended.put((outcome.code, outcome.result))

        sent = self._door.send_goal(action, type, goal, ended, feedback=made.feedback.put)
        return made

    def close(self) -> None:
        self._door.close()

    def kill(self) -> None:
        self._door.program.process.kill()


def _set(message: Message, reply: Reply) -> None:
    reply({"success": message["data"], "message": f"it was {message['data']}"})


class _Server:
    """An action of the peer, as :mod:`tests.ros.peer` has it."""

    def __init__(self, name: str, die: Callable[[], object]) -> None:
        self._name, self._die = name, die
        self._cancelled: dict[int, threading.Event] = {}

    def begin(self, execution: Execution) -> bool:
        if self._name == "picky":
            return False
        self._cancelled[id(execution)] = threading.Event()
        threading.Thread(target=functools.partial(self._carry_out, execution), daemon=True).start()
        return True

    def cancel(self, execution: Execution) -> None:
        self._cancelled[id(execution)].set()

    def _carry_out(self, execution: Execution) -> None:
        sequence, cancelled = [0, 1], self._cancelled[id(execution)]
        for step in range(execution.goal["order"]):
            if cancelled.wait(STEP_S) and self._name != "stubborn":
                execution.end("canceled", {"sequence": sequence})
                return
            if step == 2 and self._name == "dying":
                self._die()
                return
            if step == 2 and self._name == "failing":
                execution.end("aborted", {"sequence": sequence})
                return
            sequence.append((sequence[-1] + sequence[-2]) % 2**31)
            execution.feedback({"sequence": sequence})
        execution.end("succeeded", {"sequence": sequence})
