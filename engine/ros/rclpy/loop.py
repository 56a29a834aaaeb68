"""The thread in which a node of rclpy lives, with what is to be done soon or later in it.

Nothing of rclpy is touched by another thread. It logs nothing: a terminal belongs to its interface.
"""

from __future__ import annotations

import heapq
import itertools
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, Final

from engine.errors import RobotError

_QUIET: Final = ("--disable-stdout-logs", "--disable-external-lib-logs", "--disable-rosout-logs")
"""What ROS writes to the terminal, to files and to its own topic."""
_APPEAR_S: Final = 1.0
"""In which a new client has found its server, where one is known."""
_YOUNG_S: Final = 3.0
"""In which a new node has found all others."""
_LONGEST_S: Final = 10.0
"""Between two looks whether something is due, though nothing was said to be."""

Do = Callable[[], object]


class Due:
    """Something that is to be done later, unless it is cancelled before."""

    __slots__ = ("_do",)

    def __init__(self, do: Do) -> None:
        self._do: Do | None = do

    def cancel(self) -> None:
        self._do = None

    def __call__(self) -> None:
        do, self._do = self._do, None
        if do is not None:
            do()


class Loop:
    """One node in one thread."""

    def __init__(self, name: str, domain: int | None, arguments: Sequence[str]) -> None:
        """Raises RobotError where there is no rclpy."""
        try:
            import rclpy  # type: ignore[import-not-found]  # noqa: F401
        except ImportError as error:
            raise RobotError(
                f"rclpy cannot be imported ({error}).",
                hint="Start sayso in a shell that has sourced ROS 2 (source /opt/ros/…/setup.bash), with the Python of"
                " that ROS; or go by a rosbridge or by zenoh, which need no ROS here.",
            ) from error
        self._name, self._domain, self._arguments = name, domain, arguments
        self.node: Any = None
        """Of rclpy; None before it is there and after it is gone."""
        self._opened_at = time.monotonic()
        self.trouble = "the ROS graph has not been joined yet"
        self.wrong: dict[str, str] = {}
        """What does not work though the rest does, by topic, service or action, in words for people."""
        self._orders: deque[Do] = deque()
        self._due: list[tuple[float, int, Due]] = []
        self._count = itertools.count()
        self._guard: Any = None
        self._closing = False
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._run, name="rclpy", daemon=True)

    def start(self, closing: Do) -> None:
        """``closing`` is done last, while the node is still there."""
        self._at_end = closing
        self._thread.start()

    def soon(self, do: Do) -> bool:
        """Have it done in the loop; False where that is closed. From any thread."""
        with self._lock:
            if self._closing:
                return False
            self._orders.append(do)
            if self._guard is not None:
                self._guard.trigger()
        return True

    def later(self, seconds: float, do: Do) -> Due:
        """Have it done after this time. Only in the loop."""
        due = Due(do)
        heapq.heappush(self._due, (time.monotonic() + seconds, next(self._count), due))
        return due

    @property
    def patience_s(self) -> float:
        """After which a server that has not been found is not there."""
        return max(_APPEAR_S, self._opened_at + _YOUNG_S - time.monotonic())

    @property
    def young_s(self) -> float:
        """Until what is there has been found."""
        return max(0.0, self._opened_at + _APPEAR_S - time.monotonic())

    def close(self, limit_s: float) -> None:
        """Do what is left to do, and leave the graph."""
        with self._lock:
            self._closing = True
            if self._guard is not None:
                self._guard.trigger()
        if threading.current_thread() is not self._thread:
            self._thread.join(limit_s)

    def call(self, given: Callable[..., object], *arguments: Any) -> Any:
        """Call what was given to the door. An error in it is reported as one of this thread, and ends nothing."""
        try:
            return given(*arguments)
        except Exception as error:  # noqa: BLE001 - whatever it is, the door goes on
            threading.excepthook(
                threading.ExceptHookArgs((type(error), error, error.__traceback__, threading.current_thread()))
            )
            return None

    # In the thread

    def _run(self) -> None:
        import rclpy
        from rclpy.context import Context  # type: ignore[import-not-found]
        from rclpy.exceptions import NameValidationException  # type: ignore[import-not-found]
        from rclpy.executors import (  # type: ignore[import-not-found]
            ExternalShutdownException,
            SingleThreadedExecutor,
        )
        from rclpy.signals import SignalHandlerOptions  # type: ignore[import-not-found]

        context = Context()
        try:
            rclpy.init(
                args=["--ros-args", *_QUIET, *self._arguments],
                context=context,
                domain_id=self._domain,
                signal_handler_options=SignalHandlerOptions.NO,
            )
            node = rclpy.create_node(self._name, context=context, enable_rosout=False, start_parameter_services=False)
        except (RuntimeError, ValueError, OSError, NameValidationException) as error:
            self.trouble = f"the ROS graph cannot be joined: {error}"
            self._end()
            return
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        with self._lock:
            self.node, self._guard = node, node.create_guard_condition(lambda: None)
        self._opened_at = time.monotonic()
        self.trouble = ""
        try:
            while True:
                self._do_orders()
                if self._closing:
                    break
                self._spin(executor)
        except ExternalShutdownException:
            self.trouble = "ROS has been shut down in this program"
        finally:
            self._end()
            executor.shutdown(0)
            with self._lock:
                self.node = self._guard = None
            node.destroy_node()
            context.try_shutdown()

    def _end(self) -> None:
        self.trouble = self.trouble or "it has been closed"
        with self._lock:
            self._closing = True
        if self.node is None:
            self._orders.clear()
        self._do_orders()
        self._at_end()

    def _do_orders(self) -> None:
        while self._orders:
            self._try(self._orders.popleft())
        now = time.monotonic()
        while self._due and self._due[0][0] <= now:
            self._try(heapq.heappop(self._due)[2])

    def _spin(self, executor: Any) -> None:
        wait = self._due[0][0] - time.monotonic() if self._due else _LONGEST_S
        self._try(lambda: executor.spin_once(timeout_sec=max(0.0, wait)))

    def _try(self, do: Do) -> None:
        """One message that cannot be taken or sent, to a peer that has gone for instance, is no end."""
        try:
            do()
        except RuntimeError as error:
            if type(error).__name__ != "RCLError":
                raise
            self.wrong["the last message"] = f"ROS says: {error}"
