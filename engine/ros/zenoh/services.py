"""Services of a ROS 2 graph over zenoh: a call is a query, and a server is a queryable."""

from __future__ import annotations

import contextlib
import math
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

from engine.errors import UsageError
from engine.ros.door import Code, Message, Outcome, Reply, Then
from engine.ros.interfaces.cdr import BadMessage
from engine.ros.zenoh.graph import mismatch
from engine.ros.zenoh.node import Announced, Node
from engine.ros.zenoh.wire import Attachment, Endpoint, Qos

if TYPE_CHECKING:
    from zenoh import Query, Session

SERVER_S: Final = 1.0
"""In which a server must have announced itself: whoever has just come in does not know of all yet."""

_LONGEST_S: Final = 30 * 24 * 3600.0  # of a query; ROS 2 has no limit for the results of goals
Answer = Callable[[Message, Reply], object]


class Clients:
    """Calls of ours. In the door's thread, all of it."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._announced: dict[Endpoint, Announced] = {}
        self._calls: set[_Call] = set()

    def call(
        self,
        service: str,
        type: str,
        request: Message,
        then: Then,
        limit_s: float,
        wanted: Callable[[], bool] = lambda: True,
    ) -> None:
        """There must be a session. ``wanted``: see :class:`engine.ros.actions.parts.Carrier`."""
        try:
            data = self._node.codec.encode(f"{type}_Request", request)
        except (BadMessage, UsageError) as error:
            then(Outcome("bad_type", why=str(error)))
            return
        if (endpoint := self._node.endpoint(service, type)) is None:
            then(Outcome("bad_type", why=self._node.complaints[service]))
            return
        if endpoint not in self._announced:
            self._announced[endpoint] = self._node.announce("SC", endpoint, Qos())
        call = _Call(self._node, self._announced[endpoint], data, then, self._calls.discard, wanted)
        self._calls.add(call)
        call.begin(limit_s)

    def waiting(self, service: str) -> int:
        """How many calls it has not answered yet."""
        return sum(call.endpoint.name == service for call in tuple(self._calls))

    def changed(self, service: str) -> None:
        """Its servers have changed."""
        for call in tuple(self._calls):
            if call.endpoint.name == service:
                call.look()

    def give_up(self, why: str) -> None:
        """Nobody can answer any more."""
        for call in tuple(self._calls):
            call.end("lost", why)


class _Call:
    def __init__(
        self,
        node: Node,
        client: Announced,
        data: bytes,
        then: Then,
        over: Callable[[_Call], object],
        wanted: Callable[[], bool],
    ) -> None:
        assert client.entity.endpoint is not None
        self.endpoint = client.entity.endpoint
        self._node = node
        self._client = client
        self._data = data
        self._then: Then | None = then
        self._over = over
        self._wanted = wanted
        self._timers: list[Callable[[], object]] = []
        self._query: Any = None  # of zenoh's, to cancel it
        self._limit_s = math.inf

    def begin(self, limit_s: float) -> None:
        self._limit_s = min(limit_s, _LONGEST_S)
        if limit_s < math.inf:
            late = f"{self.endpoint.name} has not answered within {limit_s:g} s"
            self._timers.append(self._node.thread.later(limit_s, lambda: self.end("timed_out", late)))
        nobody = f"nobody serves {self.endpoint.name}"
        self._timers.append(self._node.thread.later(min(SERVER_S, limit_s), lambda: self._give_up(nobody)))
        self.look()

    def look(self) -> None:
        """Ask, if there is a server by now."""
        servers = self._node.tokens.of(self.endpoint.name, "SS")
        if self._then is None or self._query is not None or not servers:
            return
        if not self._wanted():
            self.end("canceled", f"nobody wants it of {self.endpoint.name} any more")
            return
        words = [mismatch(self._client.entity, server) for server in servers]
        if all(words):
            self.end("bad_type", words[0])
        else:
            self._ask()

    def end(self, code: Code, why: str = "", result: Message | None = None) -> None:
        """Only the first counts."""
        then, self._then = self._then, None
        if then is None:
            return
        for cancel in self._timers:
            cancel()
        if self._query is not None:
            self._query.cancel()
        self._over(self)
        then(Outcome(code, result or {}, why))

    def _give_up(self, why: str) -> None:
        if self._query is None:
            self.end("no_server", why)

    def _ask(self) -> None:
        import zenoh

        session = self._node.session
        assert session is not None
        self._query = zenoh.CancellationToken()
        session.get(
            self.endpoint.key(self._node.domain),
            zenoh.handlers.Callback(self._hear, self._finish),
            target=zenoh.QueryTarget.ALL_COMPLETE,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=self._limit_s + 1.0,  # ours ends first, and tells better what it was
            payload=self._data,
            attachment=self._client.attachment(),
            cancellation_token=self._query,
        )

    def _hear(self, reply: Any) -> None:
        """In a thread of zenoh's."""
        data = reply.ok.payload.to_bytes() if reply.ok is not None else None
        words = "" if reply.err is None else reply.err.payload.to_bytes().decode(errors="replace")
        self._node.thread.soon(lambda: self._take(data, words))

    def _finish(self) -> None:
        """No reply comes any more; in a thread of zenoh's."""
        gone = f"the server of {self.endpoint.name} went away before it answered"
        self._node.thread.soon(lambda: self.end("lost", gone))

    def _take(self, data: bytes | None, words: str) -> None:
        if data is None:
            self.end("bad_type", f"the server of {self.endpoint.name} cannot answer: {words[:120]}")
            return
        try:
            result = self._node.codec.decode(f"{self.endpoint.type}_Response", data)
        except BadMessage as error:
            self.end("bad_type", str(error))
        else:
            self.end("succeeded", result=result)


class Servers:
    """What we serve. In the door's thread, all of it."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._served: dict[str, _Server] = {}

    def serve(self, service: str, type: str, answer: Answer) -> None:
        """Answer from now on; whoever did before does no more."""
        if (before := self._served.pop(service, None)) is not None:
            before.close()
        if (endpoint := self._node.endpoint(service, type)) is None:
            return
        self._served[service] = server = _Server(self._node, endpoint, answer)
        if self._node.session is not None:
            server.open(self._node.session)

    def opened(self, session: Session) -> None:
        """Serve all that is to be served."""
        for server in self._served.values():
            server.open(session)


class _Server:
    def __init__(self, node: Node, endpoint: Endpoint, answer: Answer) -> None:
        self._node = node
        self._endpoint = endpoint
        self._answer = answer
        self._queryable: Any = None
        self._announced: Announced | None = None

    def open(self, session: Session) -> None:
        import zenoh

        callback = zenoh.handlers.Callback(self._arrive)
        key = self._endpoint.key(self._node.domain)
        self._queryable = session.declare_queryable(key, callback, complete=True)
        self._announced = self._node.announce("SS", self._endpoint, Qos())

    def close(self) -> None:
        if self._announced is not None:
            self._queryable.undeclare()
            self._node.withdraw(self._announced)

    def _arrive(self, query: Query) -> None:
        """In a thread of zenoh's."""
        self._node.thread.soon(lambda: self._take(query))

    def _take(self, query: Query) -> None:
        try:
            attachment = Attachment.parse(query.attachment.to_bytes() if query.attachment is not None else b"")
            data = query.payload.to_bytes() if query.payload is not None else b""
            request = self._node.codec.decode(f"{self._endpoint.type}_Request", data)
        except ValueError as error:
            _refuse(query, str(error))
            return
        self._answer(request, _Reply(self._node, self._endpoint, query, attachment))


class _Reply:
    """Answers one request, the first time that it is called, in any thread."""

    def __init__(self, node: Node, endpoint: Endpoint, query: Query, request: Attachment) -> None:
        self._node = node
        self._endpoint = endpoint
        self._request = request
        self._query: Query | None = query
        self._lock = threading.Lock()

    def __call__(self, response: Message) -> None:
        import zenoh

        with self._lock:
            query, self._query = self._query, None
        if query is None:
            return
        try:
            data = self._node.codec.encode(f"{self._endpoint.type}_Response", response)
        except BadMessage as error:
            self._node.complaints[self._endpoint.name] = f"an answer of ours cannot be sent: {error}"
            _refuse(query, str(error))
            return
        attachment = self._request._replace(stamp=time.time_ns()).pack()
        with contextlib.suppress(zenoh.ZError):  # the session has been closed
            query.reply(self._endpoint.key(self._node.domain), data, attachment=attachment)
        query.drop()  # type: ignore[no-untyped-call]


def _refuse(query: Query, why: str) -> None:
    import zenoh

    with contextlib.suppress(zenoh.ZError):  # the session has been closed
        query.reply_err(why.encode())
    query.drop()  # type: ignore[no-untyped-call]
