"""The door by rosbridge: JSON over a WebSocket, which robots of any age have.

A thread of its own keeps one connection for topics, and for what we serve, and makes others for calls and goals
(:mod:`engine.ros.rosbridge.line` says why). One that is lost is made again, and everything that was advertised and
subscribed with it.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import Callable, Coroutine, Mapping
from dataclasses import dataclass
from typing import Any, Final

from engine.ros.actions.parts import ENDS, STATUS
from engine.ros.door import CALL_S, End, Execution, Graph, Message, Outcome, Reply, Take, Then, Work
from engine.ros.door import Goal as AnyGoal
from engine.ros.rosbridge.goals import Goal, Statuses, call
from engine.ros.rosbridge.line import GONE, LEAVE_S, OPEN_S, Line, Lines, opened, why

AGAIN_S: Final = 0.5
"""Between two tries to connect."""

_LAST: Final = "/sayso/leaves"
"""A service that nobody has."""

Order = dict[str, Any]
"""One operation of the protocol."""


@dataclass(frozen=True, slots=True)
class _Subscription:
    type: str
    take: Take
    every_s: float
    every: bool


class Rosbridge:
    """A :class:`engine.ros.door.Door` by a bridge at ``ws://…``."""

    def __init__(self, url: str) -> None:
        """Connect in the background."""
        self._url = url
        self.trouble = f"the bridge at {url} has not been reached yet"
        self._lock = threading.Lock()
        self._subscribed: dict[str, _Subscription] = {}
        self._advertised: dict[str, str] = {}
        self._services: dict[str, tuple[str, Callable[[Message, Reply], object]]] = {}
        self._actions: dict[str, tuple[str, Work]] = {}
        self._orders: list[Order] = []  # to go out in this order, in this connection
        self._newest: dict[str, Message] = {}  # to publish, by topic
        self._statuses: dict[str, Statuses] = {}  # by action
        self._executing: dict[str, _Execution] = {}  # goals of peers, by the bridge's id
        self._pursuing: set[asyncio.Task[None]] = set()
        self._lines = Lines(url)
        self._loop = asyncio.new_event_loop()
        self._work = asyncio.Event()  # something waits to go out
        self._left = asyncio.Event()  # the bridge has done all that it was told
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="rosbridge", daemon=True)
        self._thread.start()

    # From any thread

    def mismatches(self) -> Mapping[str, str]:
        return {}  # a bridge tells nobody

    def advertise(self, topic: str, type: str) -> None:
        with self._lock:
            if topic in self._advertised:
                return
            self._advertised[topic] = type
            self._orders.append(_advertise(topic, type))
        self._wake()

    def publish(self, topic: str, type: str, message: Message, *, every: bool = False) -> None:
        self.advertise(topic, type)
        with self._lock:
            if not every:
                self._newest[topic] = message
            elif not self.trouble:
                self._orders.append({"op": "publish", "topic": topic, "msg": message})
        self._wake()

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
        del latched  # a bridge hears what was latched wherever it is
        with self._lock:
            self._subscribed[topic] = found = _Subscription(type, take, every_s, every)
            self._orders.append(_subscribe(topic, found))
        self._wake()

    def call(self, service: str, type: str, request: Message, then: Then, *, limit_s: float = CALL_S) -> None:
        self._pursue(lambda: call(self._lines, service, request, limit_s), then)

    def send_goal(
        self,
        action: str,
        type: str,
        goal: Message,
        then: Then,
        *,
        feedback: Take = lambda message: None,
        limit_s: float | None = None,
    ) -> AnyGoal:
        with self._lock:
            statuses = self._statuses.setdefault(action, Statuses())
        topic = f"{action}/_action/status"
        if topic not in self._subscribed:
            self.subscribe(topic, STATUS, statuses.hear, latched=True)
        sent = Goal(action, type, goal, feedback, limit_s, self._soon, self._tell)
        self._pursue(lambda: sent.run(self._lines, statuses), then)
        return sent

    def serve(self, service: str, type: str, answer: Callable[[Message, Reply], object]) -> None:
        with self._lock:
            self._services[service] = (type, answer)
            self._orders.append({"op": "advertise_service", "service": service, "type": type})
        self._wake()

    def serve_action(self, action: str, type: str, work: Work) -> None:
        with self._lock:
            self._actions[action] = (type, work)
            self._orders.append({"op": "advertise_action", "action": action, "type": type})
        self._wake()

    def graph(self, then: Callable[[Graph], object]) -> None:
        async def asked() -> Graph:
            topics = await call(self._lines, "/rosapi/topics", {}, CALL_S)
            services = await call(self._lines, "/rosapi/services", {}, CALL_S)
            actions = await call(self._lines, "/rosapi/action_servers", {}, CALL_S)
            if topics.code != "succeeded":
                told = "rosapi does not run beside the bridge" if topics.code == "no_server" else topics.why
                return Graph(why=told)
            names = _texts(topics.result, "topics")
            return Graph(
                dict(zip(names, _texts(topics.result, "types"), strict=False)),
                dict.fromkeys(_texts(services.result, "services"), ""),
                dict.fromkeys(_texts(actions.result, "action_servers"), ""),
            )

        async def pursued() -> None:
            then(await asked())

        self._start(pursued)

    def close(self) -> None:
        self._closing = True
        self._wake()
        self._thread.join(LEAVE_S + OPEN_S)

    def _pursue(self, work: Callable[[], Coroutine[Any, Any, Outcome]], then: Then) -> None:
        async def pursued() -> None:
            outcome = Outcome("lost", why=self.trouble or "the door was shut")
            try:
                if not self.trouble:
                    outcome = await work()
            finally:
                then(outcome)

        self._start(pursued)

    def _start(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        def start() -> None:
            task = self._loop.create_task(work())
            self._pursuing.add(task)
            task.add_done_callback(self._pursuing.discard)

        self._soon(start)

    def _soon(self, act: Callable[[], object]) -> None:
        with contextlib.suppress(RuntimeError):  # it has been closed
            self._loop.call_soon_threadsafe(act)

    def _wake(self) -> None:
        self._soon(self._work.set)

    def _tell(self, order: Order) -> None:
        with self._lock:
            self._orders.append(order)
        self._wake()

    # In the thread of the door

    def _run(self) -> None:
        try:
            self._loop.run_until_complete(self._keep())
        finally:
            self._loop.close()

    async def _keep(self) -> None:
        while not self._closing:
            try:
                line = await opened(self._url)
            except GONE as error:
                self.trouble = f"the bridge at {self._url} is gone ({why(error)})"
            else:
                await self._use(line)
            if not self._closing:
                await asyncio.sleep(AGAIN_S)
        self.trouble = "it has been closed"
        for task in tuple(self._pursuing):
            task.cancel()
        await asyncio.gather(*self._pursuing, return_exceptions=True)
        await self._lines.close()

    async def _use(self, line: Line) -> None:
        """Talk over a connection until it or the door is closed."""
        with self._lock:
            self._newest.clear()  # what was to be published then is over
            self._orders = [
                *(_advertise(topic, type) for topic, type in self._advertised.items()),
                *(_subscribe(topic, found) for topic, found in self._subscribed.items()),
                *({"op": "advertise_service", "service": s, "type": t} for s, (t, _) in self._services.items()),
                *({"op": "advertise_action", "action": a, "type": t} for a, (t, _) in self._actions.items()),
            ]
        self._work.set()
        self.trouble = ""
        try:
            await self._talk(line)
            self.trouble = f"the bridge at {self._url} is gone (it has closed the connection)"
        except GONE as error:
            self.trouble = f"the bridge at {self._url} is gone ({why(error)})"
        except Exception as error:  # noqa: BLE001 - one boundary: a fault over one message is not the door's end
            self.trouble = f"the bridge at {self._url} is gone ({error!r:.120})"
        finally:
            await line.close()
            await self._lines.close()
            executing, self._executing = self._executing, {}
            for execution in executing.values():
                execution.work.cancel(execution)  # nobody hears of it any more

    async def _talk(self, line: Line) -> None:
        hearing = asyncio.create_task(self._hear(line))
        try:
            while True:
                work = asyncio.ensure_future(self._work.wait())
                await asyncio.wait((hearing, work), return_when=asyncio.FIRST_COMPLETED)
                work.cancel()
                if hearing.done():
                    hearing.result()
                    return
                self._work.clear()
                await self._send_all(line)
                if self._closing:
                    await self._take_leave(line)
                    return
        finally:
            hearing.cancel()

    async def _take_leave(self, line: Line) -> None:
        """Serve nothing any more, and wait until the bridge has done what it was told: it forgets that when the
        connection ends, but not what was advertised."""
        for service in self._services:
            await line.send({"op": "unadvertise_service", "service": service})
        for action in self._actions:
            await line.send({"op": "unadvertise_action", "action": action})
        await line.send({"op": "call_service", "id": _LAST, "service": _LAST})
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(self._left.wait(), LEAVE_S)

    async def _send_all(self, line: Line) -> None:
        with self._lock:
            orders, self._orders = self._orders, []
            newest, self._newest = self._newest, {}
        for order in orders:
            await line.send(order)
        for topic, message in newest.items():
            await line.send({"op": "publish", "topic": topic, "msg": message})

    async def _hear(self, line: Line) -> None:
        async for order in line.heard():
            match order.get("op"):
                case "service_response" if order.get("id") == _LAST:
                    self._left.set()
                case "publish":
                    message, found = order.get("msg"), self._subscribed.get(str(order.get("topic")))
                    if found is not None and isinstance(message, dict):
                        found.take(message)
                case "call_service":
                    self._answer(order)
                case "send_action_goal":
                    self._begin(order)
                case "cancel_action_goal":
                    if (execution := self._executing.get(str(order.get("id")))) is not None:
                        execution.work.cancel(execution)

    def _answer(self, order: Order) -> None:
        name, request = str(order.get("service")), order.get("args")
        if (found := self._services.get(name)) is None:
            return

        def reply(response: Message) -> None:
            answer = {"op": "service_response", "id": order.get("id"), "service": name}
            self._tell({**answer, "values": response, "result": True})

        found[1](request if isinstance(request, dict) else {}, reply)

    def _begin(self, order: Order) -> None:
        name, goal, id = str(order.get("action")), order.get("args"), str(order.get("id"))
        if (found := self._actions.get(name)) is None:
            return
        execution = _Execution(goal if isinstance(goal, dict) else {}, id, name, found[1], self._tell, self._forget)
        self._executing[id] = execution
        if not found[1].begin(execution):
            execution.end("aborted", {})  # to refuse it in other words makes the bridge fail

    def _forget(self, id: str) -> None:
        self._soon(lambda: self._executing.pop(id, None))


class _Execution:
    """A goal that a peer has sent through the bridge, an :class:`engine.ros.door.Execution`."""

    def __init__(
        self,
        goal: Message,
        id: str,
        action: str,
        work: Work,
        tell: Callable[[Order], None],
        ended: Callable[[str], None],
    ) -> None:
        self.goal = goal
        self.work = work
        self._about = {"id": id, "action": action}
        self._tell = tell
        self._ended = ended
        self._lock = threading.Lock()
        self._over = False

    def feedback(self, message: Message) -> None:
        if not self._over:
            self._tell({"op": "action_feedback", **self._about, "values": message})

    def end(self, how: End, result: Message) -> None:
        with self._lock:
            before, self._over = self._over, True
        if before:
            return
        self._tell({"op": "action_result", **self._about, "values": result, "status": ENDS[how], "result": True})
        self._ended(str(self._about["id"]))


def _texts(result: Message, name: str) -> list[str]:
    found = result.get(name)
    return [str(text) for text in found] if isinstance(found, list) else []


def _advertise(topic: str, type: str) -> Order:
    return {"op": "advertise", "topic": topic, "type": type}


def _subscribe(topic: str, found: _Subscription) -> Order:
    order: Order = {"op": "subscribe", "topic": topic, "type": found.type}
    if not found.every:
        order["queue_length"] = 1
    return {**order, "throttle_rate": round(1000 * found.every_s)} if found.every_s else order


# One module would not show that every door fulfils the same protocol; a checker of types looks here.
_CHECKED: type[Execution] = _Execution
