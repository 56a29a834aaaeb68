"""Services over rclpy. Everything in here is touched in the loop's thread only, but for what says so."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Final

from engine.ros.door import Message, Outcome, Reply, Then
from engine.ros.rclpy.loop import Loop
from engine.ros.rclpy.messages import BadTypeError, to_mapping, to_message

LOOK_S: Final = 0.05
"""Between two looks for a server that is not there yet: rclpy has no event for it."""


class Call:
    """One call of a service. ``end`` gets its outcome."""

    def __init__(self, loop: Loop, service: str, request: Any, limit_s: float, end: Then) -> None:
        self._loop, self._service, self._request, self._limit_s = loop, service, request, limit_s
        self._end = end
        self._began = time.monotonic()
        self._absent_at = self._began + min(limit_s, loop.patience_s)

    def start(self, client: Any, absent: Callable[[], Outcome]) -> None:
        """Send it as soon as its server is there; ``absent`` says why it is not."""
        if client.service_is_ready():
            self._send(client)
        elif time.monotonic() < self._absent_at:
            self._loop.later(LOOK_S, lambda: self.start(client, absent))
        else:
            self._end(absent())

    def _send(self, client: Any) -> None:
        future = client.call_async(self._request)

        def silent() -> None:
            client.remove_pending_request(future)
            self._end(Outcome("timed_out", why=f"{self._service} has not answered for {self._limit_s:g} s"))

        limit = self._loop.later(max(0.0, self._began + self._limit_s - time.monotonic()), silent)

        def answered(done: Any) -> None:
            limit.cancel()
            self._end(Outcome("succeeded", to_mapping(done.result())))

        future.add_done_callback(answered)


def serve(
    loop: Loop, service: str, type: Any, answer: Callable[[Message, Reply], object], wrong: Callable[[str], object]
) -> Any:
    """A service. rclpy sends a response when its callback returns; this one, when the answer is there. ``wrong`` gets
    to know in words of an answer that does not fit."""

    def asked(request: Any, response: Any) -> _Answer:
        given = _Answer(loop)
        loop.call(answer, to_mapping(request), given)
        return given

    made = loop.node.create_service(type, service, asked)
    send = made.send_response

    def respond(given: _Answer, header: Any) -> None:
        def ready(message: Message) -> None:
            try:
                response = to_message(type.Response, message)
            except BadTypeError as error:
                wrong(str(error))
            else:
                send(response, header)

        given.when(ready)

    made.send_response = respond
    return made


class _Answer:
    """The answer to one request, and what sends it: whichever comes first waits for the other."""

    def __init__(self, loop: Loop) -> None:
        self._loop = loop
        self._message: Message | None = None
        self._send: Callable[[Message], object] | None = None

    def __call__(self, message: Message) -> None:
        """From any thread; only the first counts."""
        self._loop.soon(lambda: self._give(message))

    def when(self, send: Callable[[Message], object]) -> None:
        self._send = send
        if self._message is not None:
            send(self._message)

    def _give(self, message: Message) -> None:
        if self._message is None:
            self._message = message
            if self._send is not None:
                self._send(message)
