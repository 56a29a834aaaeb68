"""A :class:`engine.ros.door.Door` in another program: all it is told goes to a :mod:`tests.ros.driver`."""

from __future__ import annotations

import itertools
import queue
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from engine.ros.door import CALL_S, End, Goal, Graph, Message, Outcome, Reply, Take, Then, Work
from tests.ros.lines import Line, Program

ANSWER_S = 10.0


class RemoteDoor:
    """The near end."""

    def __init__(self, door: str, python: Path, surroundings: Mapping[str, str]) -> None:
        self._ids = itertools.count(1)
        self._heard: dict[int, Callable[[Line], object]] = {}
        self._closed = threading.Event()
        self.program = Program([python, "-m", "tests.ros.driver", door], surroundings, self._hear)

    @property
    def trouble(self) -> str:
        answers: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._tell("trouble", lambda line: answers.put(line["trouble"]))
        return answers.get(timeout=ANSWER_S)

    def mismatches(self) -> Mapping[str, str]:
        answers: queue.SimpleQueue[Mapping[str, str]] = queue.SimpleQueue()
        self._tell("mismatches", lambda line: answers.put(line["mismatches"]))
        return answers.get(timeout=ANSWER_S)

    def advertise(self, topic: str, type: str) -> None:
        self.program.tell({"do": "advertise", "topic": topic, "type": type})

    def publish(self, topic: str, type: str, message: Message, *, every: bool = False) -> None:
        self.program.tell({"do": "publish", "topic": topic, "type": type, "message": message, "every": every})

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
        told = {"topic": topic, "type": type, "every_s": every_s, "latched": latched, "every": every}
        self._tell("subscribe", lambda line: take(line["message"]), **told)

    def call(self, service: str, type: str, request: Message, then: Then, *, limit_s: float = CALL_S) -> None:
        told = {"service": service, "type": type, "request": request, "limit_s": limit_s}
        self._tell("call", lambda line: then(Outcome(*line["outcome"])), **told)

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
        def heard(line: Line) -> None:
            if "feedback" in line:
                feedback(line["feedback"])
            else:
                then(Outcome(*line["outcome"]))

        id = self._tell("send_goal", heard, action=action, type=type, goal=goal, limit_s=limit_s)
        return _RemoteGoal(self.program, id)

    def serve(self, service: str, type: str, answer: Callable[[Message, Reply], object]) -> None:
        def asked(line: Line) -> None:
            number = line["asked"]
            answer(
                line["message"],
                lambda message: self.program.tell({"do": "answer", "number": number, "message": message}),
            )

        self._tell("serve", asked, service=service, type=type)

    def serve_action(self, action: str, type: str, work: Work) -> None:
        begun: dict[int, _RemoteExecution] = {}

        def heard(line: Line) -> None:
            if "cancel" in line:
                work.cancel(begun[line["cancel"]])
                return
            number = line["begin"]
            begun[number] = _RemoteExecution(self.program, number, line["goal"])
            self.program.tell({"do": "decide", "takes": work.begin(begun[number])})

        self._tell("serve_action", heard, action=action, type=type)

    def graph(self, then: Callable[[Graph], object]) -> None:
        self._tell("graph", lambda line: then(Graph(*line["graph"])))

    def close(self) -> None:
        if not self._closed.is_set():
            self.program.tell({"do": "close"})
            self._closed.wait(ANSWER_S)
        self.program.close()

    def _tell(self, do: str, heard: Callable[[Line], object], **told: Any) -> int:
        id = next(self._ids)
        self._heard[id] = heard
        self.program.tell({"do": do, "id": id, **told})
        return id

    def _hear(self, line: Line) -> None:
        if "closed" in line:
            self._closed.set()
        else:
            self._heard[line["id"]](line)


class _RemoteGoal:
    def __init__(self, program: Program, id: int) -> None:
        self._program, self._id = program, id

    def cancel(self) -> None:
        self._program.tell({"do": "cancel", "id": self._id})


class _RemoteExecution:
    def __init__(self, program: Program, number: int, goal: Message) -> None:
        self._program, self._number = program, number
        self.goal = goal

    def feedback(self, message: Message) -> None:
        self._program.tell({"do": "feedback", "number": self._number, "message": message})

    def end(self, how: End, result: Message) -> None:
        self._program.tell({"do": "end", "number": self._number, "how": how, "result": result})
