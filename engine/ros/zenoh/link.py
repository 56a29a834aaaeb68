"""One zenoh session with a router, opened again and again until the router is there.

Once it is open, zenoh itself connects again after a loss, and declares all that was declared before. What is left to do
here is to notice: a connection that ends is told by zenoh at once, and a router that answers no more is found out by
asking it, since a network that is cut says nothing for a minute.
"""

from __future__ import annotations

import contextlib
import json
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from engine.errors import DeviceError, UsageError, one_line
from engine.ros.door_thread import DoorThread
from engine.ros.interfaces.definitions import INSTALL

if TYPE_CHECKING:
    from zenoh import Config, Session

AGAIN_S: Final = 0.5
"""Between two tries to connect."""
PING_S: Final = 1.0
"""Between two questions to the router."""
ANSWER_S: Final = 2.0
"""In which it must have answered; less would be a false alarm now and then, on a machine that is busy."""
LEAVE_S: Final = 0.5
"""In which what was published goes out before the session is closed."""

_NOWHERE: Final = "@ros2_lv/sayso/ping"  # a liveliness token that nobody has: the router answers that there is none


class Link:
    """A session that is kept open. What it calls is called in the door's thread."""

    def __init__(
        self, locator: str, thread: DoorThread, opened: Callable[[Session], object], ended: Callable[[], object]
    ):
        """``opened`` is called once, with the session; ``ended`` whenever the router has
        gone away. Raises DeviceError where zenoh is not installed, and UsageError for a locator that is none."""
        try:
            import zenoh
        except ImportError as error:
            raise DeviceError("A zenoh router is reached with the package eclipse-zenoh.", hint=INSTALL) from error
        self._zenoh = zenoh
        self._locator = locator
        self._config()  # raises, here and now
        self._thread = thread
        self._opened = opened
        self._ended = ended
        self.session: Session | None = None
        self.trouble = f"the zenoh router at {locator} has not been reached yet"
        self._connected = False
        self._since = 0.0  # when it was connected last, by the monotonic clock
        self._closing = threading.Event()
        self._opener = threading.Thread(target=self._open, name="zenoh-opener", daemon=True)

    def start(self) -> None:
        """Connect, in the background."""
        self._opener.start()

    @property
    def open_s(self) -> float:
        """How long nothing has been in trouble."""
        return time.monotonic() - self._since

    def close(self) -> None:
        """Close the session; not in the door's thread."""
        self._closing.set()
        self._opener.join(LEAVE_S)
        self.trouble = "it has been closed"
        if (session := self.session) is not None:
            # A session whose router does not answer takes 10 s to close, for which nobody should have to wait
            closer = threading.Thread(target=_close, args=(session,), name="zenoh-closer", daemon=True)
            closer.start()
            closer.join(LEAVE_S)

    def _config(self) -> Config:
        config = self._zenoh.Config()
        settings: dict[str, Any] = {
            "mode": "client",
            "connect/endpoints": [self._locator],
            "connect/timeout_ms": 0,  # to open: one try, for ours are made here
            "connect/retry": {"period_init_ms": 200, "period_max_ms": 500, "period_increase_factor": 1.5},
            "scouting/multicast/enabled": False,
            "scouting/gossip/enabled": False,
            "timestamping/enabled": True,  # without it no message is kept for those who come later
            "transport/unicast/open_timeout": 2000,
        }
        try:
            for key, value in settings.items():
                config.insert_json5(key, json.dumps(value))
        except self._zenoh.ZError as error:
            hint = "It is written as tcp/HOST:PORT."
            raise UsageError(f"{self._locator!r} is no address of a zenoh router.", hint=hint) from error
        return config

    # In a thread of its own, which ends once there is a session

    def _open(self) -> None:
        while not self._closing.is_set():
            try:
                session = self._zenoh.open(self._config())
            except self._zenoh.ZError as error:
                self.trouble = f"the zenoh router at {self._locator} cannot be reached ({_why(error)})"
            else:
                if self._closing.is_set():
                    _close(session)
                else:
                    self._thread.soon(partial(self._begin, session))
                return
            self._closing.wait(AGAIN_S)

    # In the door's thread

    def _begin(self, session: Session) -> None:
        self.session = session
        if self._closing.is_set():
            _close(session)
            return
        self._opened(session)
        # Callbacks are run by threads of Python (zenoh's default), here and everywhere. Run by zenoh's own, they want
        # the interpreter's lock while zenoh holds one that Session.is_closed(), for one, waits for with the other in
        # hand: all stands still
        callback = self._zenoh.handlers.Callback(self._hear)
        self._listener = session.info.declare_transport_events_listener(callback, history=True)
        self._ping()

    def _hear(self, event: Any) -> None:
        """Of a connection that was made or lost, in a thread of zenoh's."""
        is_there = event.kind == self._zenoh.SampleKind.PUT
        self._thread.soon(lambda: self._tell(is_there, "is gone"))

    def _tell(self, is_there: bool, what: str) -> None:
        if is_there == self._connected or self._closing.is_set():
            return
        self._connected = is_there
        self._since = time.monotonic()
        self.trouble = "" if is_there else f"the zenoh router at {self._locator} {what}"
        if not is_there:
            self._ended()

    def _ping(self) -> None:
        if self.session is None or self._closing.is_set():
            return
        failed: list[object] = []

        def answered() -> None:
            self._thread.soon(lambda: self._answered(not failed))

        callback = self._zenoh.handlers.Callback(failed.append, answered)
        try:
            self.session.liveliness().get(_NOWHERE, callback, timeout=ANSWER_S)
        except self._zenoh.ZError:
            self._answered(False)

    def _answered(self, in_time: bool) -> None:
        there = bool(self.session and list(self.session.info.routers_zid()))
        self._tell(in_time and there, "does not answer" if there else "is gone")
        self._thread.later(PING_S, self._ping)


def _close(session: Session) -> None:
    import zenoh

    with contextlib.suppress(zenoh.ZError):  # its router does not answer, so there is nobody to part from
        session.close()  # type: ignore[no-untyped-call]


def _why(error: Exception) -> str:
    return one_line(str(error).partition(" at /")[0], 120)
