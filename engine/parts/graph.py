"""sayso as a part of a ROS 2 graph, with the names of the older pipeline: what comes from there goes to the session
like everything else, and what happens here is told there.

What a peer sends is handled in the door's own thread, which nobody may hold up: a stop from there stops the robot
before anything else is done. Whatever fails here becomes a line of the log.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from ulid import ULID

from config.schema import Settings
from engine import events
from engine.audio.vad import make_vad
from engine.bus import Emit, Subscriber
from engine.commands import Command, Interrupt, Say, Wake, check_request
from engine.errors import DeviceError, ModelError, SaysoError, UsageError, one_line
from engine.events import Event, Log, State
from engine.graph.complaints import Complaints
from engine.graph.goals import Goals, TopicGoals
from engine.graph.messages import (
    EMPTY,
    EXECUTE_PLAN,
    GET_PLAN,
    STRING,
    as_json,
    full_name,
    object_in,
    string,
    text_in,
)
from engine.graph.news import News
from engine.graph.own import OwnMessages
from engine.graph.planning import Planning
from engine.graph.sound import TYPES, Onset, pcm_in
from engine.parts.part import Loading, Part
from engine.planner.phrases.stopping import is_stop
from engine.planner.request import Plans
from engine.ros.door import Door, Message, Take
from engine.ros.opening import open_door
from engine.skills.registry import SkillRegistry
from engine.states import REST
from engine.strict_json import read_json
from engine.wording import Wording

WATCH_S: Final = 0.5
"""Between two looks whether anything passes, s."""
PATIENCE_S: Final = 5.0
"""How long nothing may pass at first until that is told, s."""
SENTENCES: Final = 8
"""Sentences of peers that may wait for their turn."""
SOUNDS: Final = 100
"""Pieces of sound that may wait for the loop: 10 s of the usual ones."""
SHOWN: Final = 80
"""Characters of a peer's sentence that a line of the log quotes."""


@dataclass(frozen=True, slots=True)
class Uses:
    """What the graph uses of the engine."""

    ask: Callable[[Command], object]
    """Gives the session a command; in any thread."""
    state: Callable[[], State]
    """Of the session; in any thread."""
    subscribe: Callable[[Subscriber], Callable[[], None]]
    emit: Emit
    hear: Callable[[bytes], bool]
    """Takes sound, in the loop's thread; whether it did."""
    planner: Loading[Plans]
    registry: SkillRegistry
    wording: Wording
    place_names: Mapping[str, str]


class GraphPart:
    """Takes part while :meth:`keep` runs. Made in the loop. ``clock`` gives s."""

    def __init__(self, settings: Settings, uses: Uses, clock: Callable[[], float] = time.monotonic) -> None:
        assert settings.ros.door is not None, "nothing connects unasked"
        self._settings = settings.ros
        self._address = settings.ros.door
        self._vad = settings.vad
        self._pre_roll_s = settings.endpoint.pre_roll_s
        self._uses = uses
        self._clock = clock
        self._loop = asyncio.get_running_loop()
        self._complain = Complaints(self._tell, clock)
        self._own = OwnMessages(clock)
        self._goals = Goals(uses.ask, uses.registry, settings.session.busy, self._complain)
        self._planning = Planning(
            uses.planner,
            uses.registry,
            uses.wording,
            uses.place_names,
            self._complain,
            uses.emit,
            limit_s=settings.session.turn_limit_s,
        )
        self._asked: dict[str, str] = {}  # sentences that the session has not begun, by their ids
        self._sounds: deque[bytes] = deque()
        self._onset: Onset | None = None
        self._heard = True  # the last sound was taken

    async def keep(self, part: Part[Door]) -> None:
        """Take part until this is cancelled."""
        if self._settings.names.audio is not None and self._settings.listens == "speech":
            try:
                self._onset = Onset(await asyncio.to_thread(make_vad, self._vad))
            except ModelError as error:
                self._tell(str(error))
        part.begin()
        try:
            door = await asyncio.to_thread(open_door, self._address)
        except SaysoError as error:
            part.fail(error)
            return
        unsubscribe = self._uses.subscribe(self._join(door))
        try:
            await self._watch(door, part)
        finally:
            await self._planning.close()
            self._goals.close()
            self._complain.catch_up(at_once=True)
            unsubscribe()
            await asyncio.to_thread(door.close)

    def _join(self, door: Door) -> Subscriber:
        """Listen and serve, and give what is to be told of every event."""
        names = self._settings.names
        if names.stop is not None:
            self._subscribe(door, names.stop, EMPTY, lambda message: self._uses.ask(Interrupt()))
        if names.command is not None:
            self._subscribe(door, names.command, STRING, self._said)
        if names.audio is not None:
            self._subscribe(door, names.audio, TYPES[self._settings.sound], self._sounded)
        if names.get_plan is not None:
            self._offer_plans(door, names.get_plan)
        if names.execute_plan is not None:
            self._offer_execution(door, names.execute_plan)
        news = News(
            self._uses.registry,
            transcript=self._publisher(door, names.command, before=self._own.publishing),
            intent=self._publisher(door, names.intent),
            feedback=self._publisher(door, names.voice_feedback),
            plan=self._publisher(door, names.plan),
            outcome=self._publisher(door, names.outcome),
        )

        def see(event: Event) -> None:
            for follow in (self._follow, self._goals.see, news.see):
                try:
                    follow(event)
                except Exception as error:  # noqa: BLE001 - one boundary: a fault here ends nothing else
                    self._complain(f"Telling the ROS graph of {event.kind} has failed: {error!r}.")

        return see

    def _offer_plans(self, door: Door, name: str) -> None:
        """``get_plan``, and the same by topics."""
        answered = self._publisher(door, f"{name}/response")

        def asked(message: Message) -> None:
            wanted = object_in(message)

            def reply(response: Message) -> None:
                plan = read_json(response["plan"]) if response["success"] else None
                answered(as_json({"id": wanted.get("id"), **response, "plan": plan}))

            self._planning.answer(wanted, reply)

        door.serve(self._full(name), GET_PLAN, self._planning.answer)
        self._subscribe(door, f"{name}/request", STRING, asked)

    def _offer_execution(self, door: Door, name: str) -> None:
        """``execute_plan``, and the same by topics."""
        feedback = self._publisher(door, f"{name}/feedback")
        result = self._publisher(door, f"{name}/result")
        goals = TopicGoals(self._goals, lambda it: feedback(as_json(it)), lambda it: result(as_json(it)))

        def cancelled(message: Message) -> None:
            if not goals.cancel(object_in(message)):
                raise UsageError("There is no goal with this id to cancel.")

        door.serve_action(self._full(name), EXECUTE_PLAN, self._goals)
        self._subscribe(door, f"{name}/goal", STRING, lambda message: goals.begin(object_in(message)))
        self._subscribe(door, f"{name}/cancel", STRING, cancelled)

    def _subscribe(self, door: Door, name: str, type: str, take: Take) -> None:
        topic = self._full(name)

        def guarded(message: Message) -> None:
            try:
                take(message)
            except SaysoError as error:
                self._complain(f"A message on {topic} was refused: {one_line(str(error))}")
            except Exception as error:  # noqa: BLE001 - one boundary: nothing raises in the door's thread
                self._complain(f"A message on {topic} has met a fault: {one_line(repr(error))}.")

        door.subscribe(topic, type, guarded, every=True)

    def _publisher(
        self, door: Door, name: str | None, before: Callable[[str], None] = lambda text: None
    ) -> Callable[[str], None]:
        if name is None:
            return lambda text: None
        topic = self._full(name)
        door.advertise(topic, STRING)

        def publish(text: str) -> None:
            message = string(text)
            before(message["data"])
            door.publish(topic, STRING, message, every=True)

        return publish

    def _full(self, name: str) -> str:
        return full_name(self._settings.namespace, name)

    # What comes; in the door's thread

    def _said(self, message: Message) -> None:
        """A sentence of a peer, or our own transcript."""
        text = text_in(message)
        if self._own.is_own(text):
            if is_stop(text) and self._uses.state() == "ACTING":  # somebody says it again, or ours is late
                self._uses.ask(Interrupt())
            return
        check_request(text)
        if len(self._asked) >= SENTENCES and not is_stop(text):
            raise UsageError(f"{SENTENCES} sentences wait already.")
        id = str(ULID())
        self._asked[id] = text
        self._uses.ask(Say(text, id=id))

    def _sounded(self, message: Message) -> None:
        pcm = pcm_in(message, self._settings.sound)
        if len(self._sounds) >= SOUNDS:
            raise UsageError("Sound comes faster than it can be heard.")
        self._sounds.append(pcm)
        self._soon(self._hear)

    # In the loop

    def _hear(self) -> None:
        pcm = self._sounds.popleft()
        heard, self._heard = self._heard, self._uses.hear(pcm)
        if not self._heard:
            if heard:
                self._complain("Sound from the ROS graph is not heard: it comes from elsewhere; try --source none.")
            return
        if self._onset is None or (began_s := self._onset.push(pcm)) is None or self._uses.state() not in REST:
            return
        self._uses.ask(Wake("speech", ago_s=min(1.0, began_s + self._pre_roll_s)))

    def _follow(self, event: Event) -> None:
        """What became of the sentences of peers."""
        match event.body:
            case events.Ack(do="say", id=id, ok=ok, message=message) if id in self._asked:
                text = self._asked.pop(id)
                if not ok:
                    self._complain(f"“{one_line(text, SHOWN)}” from the ROS graph was not done: {message}")

    async def _watch(self, door: Door, part: Part[Door]) -> None:
        """Say when nothing passes any more, and when it does again."""
        passes: bool | None = None  # nobody knows yet
        patient_until = self._clock() + PATIENCE_S
        while True:
            trouble = door.trouble
            if trouble:
                self._own.wait()
                if passes or (passes is None and self._clock() >= patient_until):
                    passes = False
                    part.fail(DeviceError(f"No way to the ROS graph: {trouble}."))
            elif not passes:
                passes = True
                part.succeed(door, self._address)
            self._complain.catch_up()
            await asyncio.sleep(WATCH_S)

    def _tell(self, words: str) -> None:
        """Write a line of the log, from any thread."""
        self._soon(lambda: self._uses.emit(Log("warning", "ros", words)))

    def _soon(self, act: Callable[[], Any]) -> None:
        with contextlib.suppress(RuntimeError):  # the engine has ended
            self._loop.call_soon_threadsafe(act)
