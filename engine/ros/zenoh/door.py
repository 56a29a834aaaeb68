"""The door by zenoh: straight to the nodes of a robot whose ROS 2 runs with rmw_zenoh, through its router.

Nothing of ROS 2 is needed here: messages, types and the graph are written as rmw_zenoh_cpp of ROS 2 Jazzy does
(:mod:`engine.ros.zenoh.wire`).
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from engine.errors import SaysoError
from engine.ros.actions.clients import ActionClients
from engine.ros.actions.servers import ActionServers
from engine.ros.door import CALL_S, Door, Goal, Graph, Message, Outcome, Reply, Take, Then, Work
from engine.ros.door_thread import DoorThread
from engine.ros.zenoh.graph import graph_of
from engine.ros.zenoh.link import Link
from engine.ros.zenoh.node import Node
from engine.ros.zenoh.services import Clients, Servers
from engine.ros.zenoh.topics import Topics
from engine.ros.zenoh.wire import tokens

if TYPE_CHECKING:
    from zenoh import Session

KNOWN_S: Final = 1.0
"""After which a door that has just opened knows all that there is."""

_THREAD_S: Final = 1.0  # in which the door's thread ends
_SHUT: Final = "the door was shut"


class ZenohDoor:
    """A :class:`engine.ros.door.Door` by a router at ``tcp/HOST:PORT``."""

    def __init__(self, locator: str, domain: int, *, definitions: Sequence[Path] = (), name: str = "sayso") -> None:
        """Connect in the background to the ROS 2 domain ``domain``; ``name`` is that of our node. ``definitions`` are
        folders with types that are not standard. Raises DeviceError where the packages that this needs are not
        installed, and UsageError for a locator that is none."""
        self._thread = DoorThread("zenoh-door")
        self._closing = threading.Event()
        self._asking: list[Callable[[Graph], object]] = []  # for the graph
        try:
            self._node = Node(domain, name, definitions, self._thread)
            self._link = Link(locator, self._thread, self._opened, self._ended)
        except SaysoError:
            self._thread.close(_THREAD_S)
            raise
        self._topics = Topics(self._node)
        self._clients = Clients(self._node)
        self._servers = Servers(self._node)
        self._goals = ActionClients(self)
        self._works = ActionServers(self)
        self._link.start()

    @property
    def trouble(self) -> str:
        return self._link.trouble

    def mismatches(self) -> Mapping[str, str]:
        """Topics, services and actions of ours that cannot work because a peer means another type by their name, or
        because we do not know theirs: why, in words for people."""
        return self._node.mismatches()

    def publish(self, topic: str, type: str, message: Message, *, every: bool = False, latched: bool = False) -> None:
        """Also ``latched``: who comes later gets the last message, too. It holds for all messages of the topic."""
        if not self.trouble:
            self._topics.publish(topic, type, message, latched)

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
        del every  # none is dropped, within reason
        self.soon(lambda: self._topics.subscribe(topic, type, take, every_s, latched))

    def call(
        self,
        service: str,
        type: str,
        request: Message,
        then: Then,
        *,
        limit_s: float = CALL_S,
        wanted: Callable[[], bool] = lambda: True,
    ) -> None:
        """See also :class:`engine.ros.actions.parts.Carrier`."""

        def call() -> None:
            if self.trouble:
                then(Outcome("lost", why=self.trouble))
            else:
                self._clients.call(service, type, request, then, limit_s, wanted)

        self._do_or(call, lambda: then(Outcome("lost", why=_SHUT)))

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
        sent = self._goals.prepare(action, type, goal, then, feedback, limit_s)
        self._do_or(sent.begin, lambda: then(Outcome("lost", why=_SHUT)))
        return sent

    def serve(self, service: str, type: str, answer: Callable[[Message, Reply], object]) -> None:
        self.soon(lambda: self._servers.serve(service, type, answer))

    def serve_action(self, action: str, type: str, work: Work) -> None:
        self.soon(lambda: self._works.serve(action, type, work))

    def graph(self, then: Callable[[Graph], object]) -> None:
        def tell() -> None:
            # From what has been heard: zenoh answers a question for all tokens too early now and then (1.10.2) when the
            # same session hears of them
            new_s = KNOWN_S - self._link.open_s
            if self.trouble or new_s <= 0.0:
                self._tell_graph(then)
            else:
                self._asking.append(then)
                self.later(new_s, self._tell_asking)

        self._do_or(tell, lambda: then(Graph(why=_SHUT)))

    def close(self) -> None:
        if self._closing.is_set():
            return
        self._closing.set()
        if self._thread.is_current():
            self._ended(_SHUT)
            threading.Thread(target=self._link.close, name="zenoh-closer", daemon=True).start()
        else:
            ended = threading.Event()
            self.soon(lambda: self._ended(_SHUT))
            self.soon(ended.set)
            ended.wait(_THREAD_S)
            self._link.close()
        self._thread.close(_THREAD_S)

    # What actions are built from, too

    def advertise(self, topic: str, type: str, *, latched: bool = False) -> None:
        """Let peers know that it will be published."""
        self.soon(lambda: self._topics.advertise(topic, type, latched))

    def soon(self, act: Callable[[], object]) -> None:
        """Do it in the door's thread."""
        self._thread.soon(act)

    def later(self, delay_s: float, act: Callable[[], object]) -> Callable[[], object]:
        """Do it in the door's thread after a while; what is returned cancels it."""
        return self._thread.later(delay_s, act)

    # In the door's thread

    def _do_or(self, act: Callable[[], object], shut: Callable[[], object]) -> None:
        """Do it, or what is to be done instead where the door has been closed."""
        if not self._thread.soon(lambda: shut() if self._closing.is_set() else act()):
            shut()

    def _opened(self, session: Session) -> None:
        import zenoh

        self._node.opened(session)
        callback = zenoh.handlers.Callback(self._hear_token)
        self._tokens = session.liveliness().declare_subscriber(tokens(self._node.domain), callback, history=True)
        self._topics.opened(session)
        self._servers.opened(session)

    def _ended(self, why: str = "") -> None:
        self._tell_asking()
        self._clients.give_up(why or self.trouble)
        self._works.give_up()

    def _tell_asking(self) -> None:
        asking, self._asking = self._asking, []
        for then in asking:
            self._tell_graph(then)

    def _hear_token(self, sample: Any) -> None:
        """Of a peer that came or went, in a thread of zenoh's."""
        import zenoh

        token, is_there = str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT
        self.soon(lambda: self._tell_token(token, is_there))

    def _tell_token(self, token: str, is_there: bool) -> None:
        if not is_there:
            self._node.tokens.remove(token)
        elif name := self._node.tokens.add(token):
            self._clients.changed(name)

    def _tell_graph(self, then: Callable[[Graph], object]) -> None:
        session = self._node.session
        if self.trouble or session is None:
            then(Graph(why=self.trouble))
        else:
            then(graph_of(self._node.tokens.all(), str(session.zid())))


_CHECKED: type[Door] = ZenohDoor
