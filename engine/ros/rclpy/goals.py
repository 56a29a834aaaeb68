"""Goals of actions over rclpy: those that we send, and those that peers send to us.

Nothing in here is touched by another thread than the loop's, but for what says so.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from engine.ros.actions.parts import CANCEL_AGAIN_S, CODES
from engine.ros.door import ACCEPT_S, Code, End, Message, Outcome, Take, Then, Work
from engine.ros.rclpy.loop import Due, Loop
from engine.ros.rclpy.messages import BadTypeError, to_mapping, to_message
from engine.ros.rclpy.services import LOOK_S

_WATCH_S: Final = 0.5
"""Between two looks whether the server of a goal is still there."""
_GRACE_S: Final = 2.0
"""In which a goal that took too long has to end once it is cancelled."""


class SentGoal:
    """A :class:`engine.ros.door.Goal` on its way. ``end`` gets its outcome."""

    def __init__(
        self, loop: Loop, action: str, message: Message, end: Then, feedback: Take, limit_s: float | None
    ) -> None:
        self._loop, self.action, self._message = loop, action, message
        self._end, self._feedback, self._limit_s = end, feedback, limit_s
        self._client: Any = None
        self._handle: Any = None  # of rclpy, once its server has taken it
        self._due: list[Due] = []
        self._cancelled = self._late = self._over = False

    def cancel(self) -> None:
        """From any thread."""
        self._loop.soon(self._cancel)

    def start(self, client: Any, wrong_type: Callable[[], str]) -> None:
        """Send it as soon as its server is there."""
        self._client, self._wrong_type = client, wrong_type
        self._within(min(ACCEPT_S, self._loop.patience_s), self._not_there)
        if self._limit_s is not None:
            self._within(self._limit_s, self._too_late)
        self._look()

    def over(self, code: Code, result: Message | None = None, why: str = "") -> None:
        """It has ended; only the first counts."""
        if self._over:
            return
        self._over = True
        for due in self._due:
            due.cancel()
        if self._late and code != "lost":
            code, why = "timed_out", f"{self.action} took longer than {self._limit_s:g} s"
        self._end(Outcome(code, result or {}, why))

    def _within(self, seconds: float, do: Callable[[], object]) -> Due:
        due = self._loop.later(seconds, do)
        self._due.append(due)
        return due

    def _look(self) -> None:
        if self._over:
            return
        if not self._client.server_is_ready():
            self._loop.later(LOOK_S, self._look)
            return
        self._due.pop(0).cancel()
        if self._cancelled:
            self.over("canceled", why="it was cancelled before it was sent")
            return
        try:
            goal = to_message(self._client._action_type.Goal, self._message)
        except BadTypeError as error:
            self.over("bad_type", why=str(error))
            return
        self._unanswered = self._within(ACCEPT_S, self._not_taken)
        sent = self._client.send_goal_async(goal, feedback_callback=self._progress)
        sent.add_done_callback(lambda future: self._answered(future.result()))

    def _not_there(self) -> None:
        if why := self._wrong_type():
            self.over("bad_type", why=why)
        else:
            self.over("no_server", why=f"nobody serves {self.action}")

    def _not_taken(self) -> None:
        self.over("timed_out", why=f"{self.action} has not answered for {ACCEPT_S:g} s")

    def _answered(self, handle: Any) -> None:
        self._unanswered.cancel()
        if not handle.accepted:
            self.over("rejected", why=f"{self.action} does not take this goal")
            return
        self._handle = handle
        if self._over:  # it was taken too late, and nobody waits for it
            handle.cancel_goal_async()
        elif self._cancelled:
            self._keep_cancelling()
        if not self._over:
            handle.get_result_async().add_done_callback(lambda future: self._result(future.result()))
            self._watch()

    def _progress(self, message: Any) -> None:
        if not self._over:
            self._loop.call(self._feedback, to_mapping(message.feedback))

    def _result(self, response: Any) -> None:
        code = CODES.get(response.status, "lost")
        why = "" if code == "succeeded" else f"{self.action} has {code} it"
        self.over(code, to_mapping(response.result), why if code != "lost" else f"{self.action} knows it no more")

    def _watch(self) -> None:
        if self._over:
            return
        if not self._client.server_is_ready():
            self.over("lost", why=f"the server of {self.action} is gone")
            return
        self._within(_WATCH_S, self._watch)

    def _cancel(self) -> None:
        if not self._cancelled and not self._over:
            self._cancelled = True
            if self._handle is not None:
                self._keep_cancelling()

    def _keep_cancelling(self) -> None:
        """Until it has ended."""
        if not self._over:
            self._handle.cancel_goal_async()
            self._loop.later(CANCEL_AGAIN_S, self._keep_cancelling)

    def _too_late(self) -> None:
        if self._handle is None:
            self._late = True
            self._cancelled = True
            self.over("timed_out")
            return
        self._cancel()
        self._late = True
        self._within(_GRACE_S, lambda: self.over("timed_out"))


class ReceivedGoal:
    """A :class:`engine.ros.door.Execution`."""

    def __init__(self, loop: Loop, server: ActionServer, goal: Any) -> None:
        self._loop, self._server = loop, server
        self._goal = to_mapping(goal)
        self.handle: Any = None  # of rclpy, once it is taken
        self._ended: tuple[End, Message] | None = None
        self._over = False

    @property
    def goal(self) -> Message:
        return self._goal

    def feedback(self, message: Message) -> None:
        """From any thread."""
        self._loop.soon(lambda: self._say(message))

    def end(self, how: End, result: Message) -> None:
        """From any thread."""
        self._loop.soon(lambda: self._finish(how, result))

    def taken(self, handle: Any) -> None:
        """It is carried out from now on."""
        self.handle = handle
        handle.execute()
        if self._ended is not None:
            self._finish(*self._ended)

    def _say(self, message: Message) -> None:
        if self.handle is None or self._over or not self.handle.is_active:
            return
        try:
            self.handle.publish_feedback(to_message(self._server.type.Feedback, message))
        except BadTypeError as error:
            self._loop.wrong[self._server.action] = str(error)

    def _finish(self, how: End, result: Message) -> None:
        if self._over:
            return
        if self.handle is None:  # before it has been taken: it ends as soon as it is
            self._ended = self._ended or (how, result)
            return
        self._over = True
        self._server.finish(self, how, result)


class ActionServer:
    """Gives the goals of one action to whoever carries them out."""

    def __init__(self, loop: Loop, action: str, type: Any, work: Work) -> None:
        from rclpy.action import (  # type: ignore[import-not-found]
            ActionServer as RosActionServer,
        )
        from rclpy.action import CancelResponse, GoalResponse

        class Server(RosActionServer):  # type: ignore[misc]
            """rclpy's own wants a function that lasts as long as the goal; ours ends when it is told to."""

            def notify_execute(self, goal_handle: Any, execute_callback: Any) -> None:
                if execute_callback is not None:
                    super().notify_execute(goal_handle, execute_callback)

        self._loop, self.action, self.type, self._work = loop, action, type, work
        self._begun: ReceivedGoal | None = None
        self._goals: list[ReceivedGoal] = []
        self._accept, self._reject, self._cancels = GoalResponse.ACCEPT, GoalResponse.REJECT, CancelResponse.ACCEPT
        self._server = Server(
            loop.node,
            type,
            action,
            execute_callback=lambda handle: type.Result(),
            goal_callback=self._begin,
            handle_accepted_callback=self._taken,
            cancel_callback=self._cancel,
        )

    def destroy(self) -> None:
        self._server.destroy()

    def finish(self, goal: ReceivedGoal, how: End, result: Message) -> None:
        """End a goal."""
        self._goals.remove(goal)
        try:
            message = to_message(self.type.Result, result)
        except BadTypeError as error:
            self._loop.wrong[self.action] = str(error)
            how, message = "aborted", self.type.Result()

        def ended(handle: Any) -> Any:
            if how == "succeeded":
                handle.succeed()
            elif how == "canceled" and handle.is_cancel_requested:
                handle.canceled()
            else:
                handle.abort()
            return message

        self._server.notify_execute(goal.handle, ended)

    def _begin(self, message: Any) -> Any:
        goal = ReceivedGoal(self._loop, self, message)
        if not self._loop.call(self._work.begin, goal):
            return self._reject
        self._begun = goal
        return self._accept

    def _taken(self, handle: Any) -> None:
        goal, self._begun = self._begun, None
        assert goal is not None  # rclpy asks `_begin` just before, in the same step
        self._goals.append(goal)
        goal.taken(handle)

    def _cancel(self, handle: Any) -> Any:
        goal = next((goal for goal in self._goals if goal.handle is handle), None)
        if goal is not None:
            self._loop.soon(lambda: self._loop.call(self._work.cancel, goal))  # once rclpy knows it, too
        return self._cancels
