"""A door in a program of its own, driven by JSON lines: ``python -m tests.ros.driver DOOR``, where DOOR is what
``engine.ros.opening`` takes. :mod:`tests.ros.remote` is the other end."""

from __future__ import annotations

import queue
import sys
import threading
from typing import Any

from engine.ros.door import Door, Execution, Goal, Message
from engine.ros.opening import open_door
from tests.ros.lines import Line, read, write

DECIDE_S = 10.0
"""In which the test has to say whether it takes a goal."""


class Driver:
    """The door, and what has been begun with it, by ids."""

    def __init__(self, door: Door) -> None:
        self.door = door
        self.goals: dict[int, Goal] = {}
        self.answers: dict[int, Any] = {}
        self.executions: dict[int, Execution] = {}
        self.decisions: queue.SimpleQueue[bool] = queue.SimpleQueue()
        self.count = 0

    def do(self, line: Line) -> None:
        getattr(self, f"do_{line.pop('do')}")(**line)

    def do_trouble(self, id: int) -> None:
        write({"id": id, "trouble": self.door.trouble})

    def do_mismatches(self, id: int) -> None:
        write({"id": id, "mismatches": dict(self.door.mismatches())})

    def do_advertise(self, topic: str, type: str) -> None:
        self.door.advertise(topic, type)

    def do_publish(self, **told: Any) -> None:
        self.door.publish(told.pop("topic"), told.pop("type"), told.pop("message"), **told)

    def do_subscribe(self, id: int, **told: Any) -> None:
        self.door.subscribe(take=lambda message: write({"id": id, "message": message}), **told)

    def do_call(self, id: int, **told: Any) -> None:
        self.door.call(then=lambda outcome: write({"id": id, "outcome": _told(outcome)}), **told)

    def do_send_goal(self, id: int, **told: Any) -> None:
        self.goals[id] = self.door.send_goal(
            then=lambda outcome: write({"id": id, "outcome": _told(outcome)}),
            feedback=lambda message: write({"id": id, "feedback": message}),
            **told,
        )

    def do_cancel(self, id: int) -> None:
        self.goals[id].cancel()

    def do_graph(self, id: int) -> None:
        self.door.graph(
            lambda graph: write(
                {"id": id, "graph": [dict(graph.topics), dict(graph.services), dict(graph.actions), graph.why]}
            )
        )

    def do_serve(self, id: int, service: str, type: str) -> None:
        def answer(message: Message, reply: Any) -> None:
            self.count += 1
            self.answers[self.count] = reply
            write({"id": id, "asked": self.count, "message": message})

        self.door.serve(service, type, answer)

    def do_answer(self, number: int, message: Line) -> None:
        self.answers.pop(number)(message)

    def do_serve_action(self, id: int, action: str, type: str) -> None:
        self.door.serve_action(action, type, _Work(self, id))

    def do_decide(self, takes: bool) -> None:
        self.decisions.put(takes)

    def do_feedback(self, number: int, message: Line) -> None:
        self.executions[number].feedback(message)

    def do_end(self, number: int, how: Any, result: Line) -> None:
        self.executions[number].end(how, result)

    def do_close(self) -> None:
        self.door.close()
        write({"closed": True})


class _Work:
    def __init__(self, driver: Driver, id: int) -> None:
        self._driver, self._id = driver, id

    def begin(self, execution: Execution) -> bool:
        self._driver.count += 1
        number = self._driver.count
        self._driver.executions[number] = execution
        write({"id": self._id, "begin": number, "goal": execution.goal})
        return self._driver.decisions.get(timeout=DECIDE_S)

    def cancel(self, execution: Execution) -> None:
        number = next(key for key, known in self._driver.executions.items() if known is execution)
        write({"id": self._id, "cancel": number})


def _told(outcome: Any) -> list[Any]:
    return [outcome.code, outcome.result, outcome.why]


def main() -> None:
    driver = Driver(open_door(sys.argv[1], "driven"))
    for line in read():
        driver.do(line)
    driver.door.close()
    for thread in threading.enumerate():
        assert thread is threading.main_thread() or thread.daemon


if __name__ == "__main__":
    main()
