"""``get_plan``: what would be done. It is planned beside the session, and nothing is started that could move."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final, get_args

from ulid import ULID

from engine import events
from engine.bus import Emit
from engine.commands import check_request
from engine.errors import SaysoError, UsageError, one_line
from engine.graph.complaints import Complaints
from engine.graph.messages import get_plan_over, plan_told, text_in
from engine.parts.part import Loading
from engine.planner.intent import intent_of
from engine.planner.request import Language, NoPlan, PlanRequest, Plans
from engine.planner.text.language import language_of
from engine.ros.door import Message, Reply
from engine.skills.registry import SkillRegistry
from engine.wording import Wording

WAITING: Final = 8
"""Requests that may wait for their answer; they are planned one after the other."""


class Planning:
    """Answers requests for plans, in any thread; made in the loop, in which it plans. ``limit_s``: what one plan may
    take, s. ``emit`` gets the calls of large models, which are on record whoever asks."""

    def __init__(
        self,
        planner: Loading[Plans],
        registry: SkillRegistry,
        wording: Wording,
        place_names: Mapping[str, str],
        complain: Complaints,
        emit: Emit,
        *,
        limit_s: float,
    ) -> None:
        self._planner = planner
        self._registry = registry
        self._wording = wording
        self._place_names = place_names
        self._complain = complain
        self._emit = emit
        self._limit_s = limit_s
        self._loop = asyncio.get_running_loop()
        self._one = asyncio.Lock()
        self._lock = threading.Lock()
        self._waiting = 0
        self._closed = False
        self._tasks: set[asyncio.Task[None]] = set()

    def answer(self, request: Message, reply: Reply) -> None:
        """Plan what ``command`` says; the reply comes later, exactly one."""
        try:
            command = text_in(request, "command")
            check_request(command)
            language = _language(request.get("language") or "")
            with self._lock:
                if self._waiting >= WAITING:
                    raise UsageError(f"{WAITING} plans are waited for already.")
                self._waiting += 1
        except SaysoError as error:
            self._complain(f"A request for a plan was refused: {one_line(str(error))}")
            reply(get_plan_over(None, str(error)))
            return
        except Exception as error:  # noqa: BLE001 - nothing raises in the door's thread
            self._complain(f"A request for a plan was refused: {one_line(repr(error))}")
            reply(get_plan_over(None, f"A fault in sayso itself: {error!r}."))
            return
        with contextlib.suppress(RuntimeError):  # the engine has ended, and the door is being shut
            self._loop.call_soon_threadsafe(self._begin, command, language, reply)

    async def close(self) -> None:
        """Whoever still waits is told that there will be no plan."""
        self._closed = True
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    def _begin(self, command: str, language: Language | None, reply: Reply) -> None:
        if self._closed:
            reply(get_plan_over(None, "The session ends."))
            return
        answers = [get_plan_over(None, "The session ends.")]  # unless there is a better one

        def over(task: asyncio.Task[None]) -> None:
            self._tasks.discard(task)
            with self._lock:
                self._waiting -= 1
            reply(answers[-1])

        task = self._loop.create_task(self._plan(command, language, answers.append), name="get_plan")
        self._tasks.add(task)
        task.add_done_callback(over)

    async def _plan(self, command: str, language: Language | None, answer: Callable[[Message], None]) -> None:
        try:
            async with self._one, asyncio.timeout(self._limit_s):
                planner = await self._planner.get()
                request = PlanRequest(command, cycle=f"get_plan {ULID()}", language=language, record=self._emit)
                found = await planner.plan(replace(request, warn=self._warn))
        except TimeoutError:
            answer(get_plan_over(None, f"There was no plan within {self._limit_s:g} s."))
            return
        except SaysoError as error:
            answer(get_plan_over(None, str(error)))
            return
        except Exception as error:  # noqa: BLE001 - a fault over one request must not take the others with it
            self._complain(f"A plan for a peer failed by a fault of sayso: {error!r}.")
            answer(get_plan_over(None, f"A fault in sayso itself: {error!r}."))
            return
        intent = intent_of(found, self._place_names)
        if isinstance(found, NoPlan):
            answer(get_plan_over(None, self._wording.worded(found.answer, language or language_of(command))))
            return
        plan = plan_told(found.goal, found.steps, found.actions, found.response, found.source, intent, self._registry)
        answer(get_plan_over(plan, found.response))

    def _warn(self, message: str) -> None:
        self._emit(events.Log("warning", "planner", message))


def _language(code: object) -> Language | None:
    for language in get_args(Language):
        if code == language:
            return language  # type: ignore[no-any-return]
    if code:
        raise UsageError(f"Plans are told in {' and '.join(get_args(Language))}; leave language empty for either.")
    return None
