"""Hypothesis plays everybody a session deals with: people who wake, speak, type and interrupt at any moment, models
that answer late, twice, never or with a fault, skills that fail, crash or do not let go, a robot that is lost.

After every step the invariants must hold. Time is virtual and the order of everything that runs is the loop's, so a
sequence that breaks one is found again, and made short.
"""

from __future__ import annotations

import asyncio
import gc
import threading
from collections import Counter
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from config import load
from config.schema import Settings
from engine import events
from engine.commands import Command, Drop, EndTask, Halted, Heard, Interrupt, Move, Quit, Say, Snapshot, Wake
from engine.errors import RobotError
from engine.events import Event
from engine.plan import Plan, parse_calls
from engine.planner.build import build_planner, build_registry
from engine.planner.planner import NoPlan, Planner, PlanRequest
from engine.robot.geometry import Twist
from engine.session.history import Acted, Answered, Interrupted, NeverStarted, Said
from engine.skills.context import SkillContext
from engine.skills.outcome import Result, fail, ok
from engine.skills.registry import Skill, SkillRegistry
from engine.states import NEXT, REST
from tests.session.conversation import MODEL_FAULT, NEVER, Conversation, SlowVoice, begin
from tests.virtual_time import VirtualTimeLoop

T = TypeVar("T")

SETTLED_S = 3.0
"""Virtual seconds after which an interrupted session is at rest: the longest graces in a row, and some."""

AFTER = st.one_of(st.integers(0, 3), st.sampled_from([0.05, 0.4, 1.5, 6.0, 15.0]))
"""What passes after a step: a few iterations of the loop, or seconds."""

counts: Counter[str] = Counter()
"""What all machines of this process did: steps, examples, interruptions, outcomes…"""

BUSY = ("interrupt", "queue", "reject")
"""What a new request may do to the present one."""

REQUESTS = (
    "go forward 2 metres",
    "turn left 90 degrees, go forward 10 metres, beep",
    "go to the kitchen",
    "wait 1 second",
    "raise your arm and nod",
    "where are you",
    "go to the moon",  # there is no such place
    "go forward",  # how far?
    "go forward 5 kilometres",  # refused
    "gibberish of all sorts",
    "end the current task",
    "stop",
    "move_forward(3) & arm_nod(), beep()",
    "move_forward(1) & move_left(90)",
    "failing(), beep()",
    "move_forward(5) & failing()",
    "crashing()",
    "losing()",
    "losing(), beep()",
    "quick(), losing()",
    "losing() & arm_nod()",
    "stubborn(), move_forward(1)",
    "stubborn() & move_forward(5) & say('one two three four five six')",
    "quick() & quick(), quick()",
    "say('a sentence of quite a few words'), finish_dialogue()",
)


async def _failing(context: SkillContext) -> Result:
    await context.sleep(0.3)
    return fail("not_supported", "It does not work.")


async def _crashing(context: SkillContext) -> Result:
    await context.sleep(0.1)
    raise ValueError("a fault")


async def _losing(context: SkillContext) -> Result:
    await context.sleep(0.1)
    raise RobotError("The robot was lost.")


async def _quick(context: SkillContext) -> Result:
    del context
    return ok("Quick.")


async def _stubborn(context: SkillContext) -> Result:
    """Drives, talks and reports for four seconds, whoever asks it to stop."""
    end = context.robot.state().t + 4.0
    while context.robot.state().t < end:
        try:
            context.drive(Twist(0.2))
            context.progress(0.5, "still here")
            await context.sleep(0.3)
            await context.say("I go on.")
        except asyncio.CancelledError:
            continue
        except RobotError:
            break
    return ok("Done at last.")


SKILLS = (
    Skill("failing", "Fails.", (), frozenset({"arm"}), _failing),
    Skill("crashing", "Has a fault.", (), frozenset(), _crashing),
    Skill("losing", "Loses the robot.", (), frozenset({"base"}), _losing),
    Skill("quick", "Is done at once.", (), frozenset({"camera"}), _quick),
    Skill("stubborn", "Does not let go.", (), frozenset({"base"}), _stubborn),
)


class Reader:
    """Plans sentences as usual, and reads actions as written."""

    def __init__(self, planner: Planner, registry: SkillRegistry) -> None:
        self._planner = planner
        self._registry = registry
        self.abilities = planner.abilities

    async def plan(self, request: PlanRequest) -> Plan | NoPlan:
        if "(" not in request.text:
            return await self._planner.plan(request)
        return Plan("test", tuple(map(self._registry.resolve, parse_calls(request.text))), "On it.", "direct")


@cache
def _settings(busy: str) -> Settings:
    return load(overrides=[f"session.busy={busy}", "session.turn_limit_s=60"], environ={})


def _with_more(registry: SkillRegistry) -> SkillRegistry:
    return SkillRegistry(
        [*registry, *SKILLS],
        capabilities=frozenset({"base", "arm", "camera", "voice"}),
        vocabulary=registry._vocabulary,
    )


@cache
def planner(busy: str) -> Reader:
    """What every conversation plans with that deals like this with a new request while it is busy."""
    registry = _with_more(build_registry(_settings(busy)))
    made = build_planner(_settings(busy), registry)
    made.warm_up()  # whatever it opens is open before files are counted
    return Reader(made, registry)


class SessionMachine(RuleBasedStateMachine):
    """One session, from its first request to its end."""

    def __init__(self) -> None:
        super().__init__()
        gc.collect()  # what the conversation before this one has left…
        gc.freeze()  # …and what Hypothesis keeps of them all, which need not be looked through again
        counts["examples"] += 1
        self._threads = threading.active_count()
        self._files = _open_files()
        self._loop = VirtualTimeLoop()
        self._looked = 0  # events already checked
        self._moved = 0  # movements already checked
        self._open: dict[str, str] = {}  # actions that have started and not ended: id -> turn
        self._planned: set[int] = set()  # epochs with a validated plan
        self._begun: set[int] = set()  # epochs in which an action has started
        self._turns: set[str] = set()  # turns that have begun and have no result yet
        self._state: events.State = "IDLE"
        self._history: list[object] = []  # of the present cycle, put together from events
        self._waiting: dict[str, dict[str, str]] = {}  # turn -> actions that are queued and have not started
        self._words: dict[str, set[str]] = {}  # turn -> what somebody said or typed
        self._asked = 0  # requests in words that were sent
        self._ended: dict[str, str] = {}  # requests in words that have ended: id -> how
        self._listed: tuple[events.WaitingRequest, ...] = ()  # what waits, as it was told last
        self._ever_listed: set[str] = set()
        self._faults: list[str] = []
        self.talk: Conversation | None = None

    @initialize(busy=st.sampled_from(BUSY))
    def begin(self, busy: str) -> None:
        self.talk = self._run(begin(_settings(busy), SlowVoice(), _with_more, planner(busy)))
        self.talk.on_event = self._see
        self._session = self._loop.create_task(self.talk.session.run())

    # People

    @rule(text=st.sampled_from(REQUESTS), after=AFTER)
    def types(self, text: str, after: float) -> None:
        self._ask(Say(text), after)

    @rule(text=st.sampled_from(REQUESTS), seconds=st.sampled_from([1.0, 3.0, 8.0, 30.0]))
    def types_and_waits(self, text: str, seconds: float) -> None:
        self._ask(Say(text), seconds)

    @rule(text=st.sampled_from(REQUESTS), then=st.lists(st.sampled_from(REQUESTS), min_size=1, max_size=3), after=AFTER)
    def types_several(self, text: str, then: list[str], after: float) -> None:
        self._ask(Say(text, then=tuple(then)), after)

    @rule(
        first=st.booleans(),
        then=st.lists(st.sampled_from(REQUESTS), min_size=1, max_size=3),
        which=st.integers(0, 8),
        before=st.none() | st.integers(0, 8),
        move=st.booleans(),
        after=AFTER,
    )
    def changes_what_waits(
        self, first: bool, then: list[str], which: int, before: int | None, move: bool, after: float
    ) -> None:
        """Drops one of those that wait, or moves it: those of now, or some that are asked for to begin with."""
        if first:
            self._ask(Say("go forward 2 metres", then=tuple(then)), 0.4)
        there = None if before is None else self._one_listed(before)
        one = self._one_listed(which)
        self._ask(Move(one, there, id="move") if move else Drop(one, id="drop"), after)

    @rule(text=st.sampled_from([None, "", *REQUESTS]), pause=AFTER, after=AFTER)
    def wakes_and_speaks(self, text: str | None, pause: float, after: float) -> None:
        self._ask(Wake("key"), pause)
        counts["heard"] += self._talk.hearing.speak(text)
        self._let_pass(after)

    @rule(after=AFTER)
    def wakes(self, after: float) -> None:
        self._ask(Wake("key"), after)

    @rule(text=st.sampled_from(REQUESTS), after=AFTER)
    def speaks(self, text: str, after: float) -> None:
        counts["heard"] += self._talk.hearing.speak(text)
        self._let_pass(after)

    @rule(
        first=st.sampled_from([None, *REQUESTS]),
        pause=st.sampled_from([0.4, 1.0]),
        text=st.sampled_from(REQUESTS),
        adds=st.booleans(),
        after=AFTER,
    )
    def goes_on(self, first: str | None, pause: float, text: str, adds: bool, after: float) -> None:
        """Somebody says more after a request: of now, or whichever was the last."""
        if first is not None:
            self._ask(Wake("key"), SETTLED_S)
            counts["heard"] += self._talk.hearing.speak(first)
            self._let_pass(pause)
        told = self._talk.hearing.go_on(text, adds=adds)
        counts["added"] += told
        self._asked += told
        self._let_pass(after)

    @rule(command=st.sampled_from([Interrupt(), EndTask(), Snapshot("s"), Say("stop")]), after=AFTER)
    def interrupts(self, command: Command, after: float) -> None:
        self._ask(command, after)

    @rule(
        pause=st.sampled_from([0.4, 0.8, 1.5, 2.0]),
        command=st.sampled_from([Wake("key"), Say("stop"), Say("wait 1 second"), Interrupt()]),
        after=AFTER,
    )
    def interrupts_the_end_of_a_dialogue(self, pause: float, command: Command, after: float) -> None:
        self._ask(Say("quick(), finish_dialogue()"), pause)
        self._ask(command, after)

    @rule(text=st.sampled_from(["Stop!", "no, stop", "what a nice day"]), after=AFTER)
    def is_overheard(self, text: str, after: float) -> None:
        self._ask(Heard(text), after)

    @rule(
        drive=st.booleans(),
        sure=st.booleans(),
        likelier=st.booleans(),
        stop=st.sampled_from([True, False, None]),
        pause=AFTER,
        after=AFTER,
    )
    def may_have_said_stop(
        self, drive: bool, sure: bool, likelier: bool, stop: bool | None, pause: float, after: float
    ) -> None:
        """A spotter thinks so; the recogniser agrees, perhaps in two looks, does not, or never says."""
        if drive:
            self._ask(Say("go forward 2 metres"), 1.0)
        acting, paused = self._talk.session.state == "ACTING", self._talk.robot.paused
        self._talk.hesitation.suspect("stop", sure=sure)
        if sure and acting and not paused and self._talk.hearing.overhears:
            counts["pauses"] += 1
            assert self._talk.robot.state().twist.is_zero, "it still moves when it is paused"
        self._let_pass(pause)
        if likelier:
            self._talk.hearing.grow_likelier()
        if stop:
            self._ask(Heard("Stop."), 0)
        if stop is not None:
            self._talk.hearing.settle()
        self._let_pass(after)

    # Parts

    @rule(decode_s=st.sampled_from([0.0, 0.3, 5.0, NEVER]))
    def hearing_takes(self, decode_s: float) -> None:
        self._talk.hearing.decode_s = decode_s

    @rule(decide_s=st.sampled_from([0.0, 0.0, 0.4]), plan_s=st.sampled_from([0.0, 0.0, 0.7, 4.0, NEVER]))
    def the_model_takes(self, decide_s: float, plan_s: float) -> None:
        self._talk.planner.decide_s, self._talk.planner.plan_s = decide_s, plan_s

    @rule(stubborn=st.booleans(), faulty=st.sampled_from([False, False, True]))
    def the_model_is(self, stubborn: bool, faulty: bool) -> None:
        self._talk.planner.stubborn = stubborn
        self._talk.planner.fault = MODEL_FAULT if faulty else None

    @rule(which=st.integers(0, 20), stage=st.sampled_from(["DECIDING", "PLANNING"]))
    def a_generation_that_is_over_reports_again(self, which: int, stage: Any) -> None:
        if len(asked := self._talk.planner.asked) > 1:
            asked[which % (len(asked) - 1)].enter(stage)

    @rule(seconds=st.sampled_from([0.02, 2.0]))
    def the_robot_is_away(self, seconds: float) -> None:
        self._talk.robot.lost = True
        self._let_pass(seconds)
        self._talk.robot.lost = False

    @rule(reason=st.sampled_from(["heartbeat lost", "it tipped over"]), lost=st.booleans(), after=AFTER)
    def the_robot_stops_by_itself(self, reason: str, lost: bool, after: float) -> None:
        self._ask(Halted(reason, self._talk.epoch.current, lost), after)

    # Time

    @rule(seconds=st.sampled_from([0.001, 0.1, 0.5, 2.0, 12.0]))
    def time_passes(self, seconds: float) -> None:
        self._let_pass(seconds)

    @rule()
    def an_interrupted_session_comes_to_rest(self) -> None:
        self._ask(Interrupt(), SETTLED_S)
        assert self._talk.session.state in REST
        assert not self._open, f"actions without an end: {self._open}"
        assert not self._turns, f"turns without a result: {self._turns}"
        self._every_request_has_ended()
        moved = len(self._talk.robot.moved)
        self._let_pass(5.0)
        assert len(self._talk.robot.moved) == moved, "it moved after an interrupt"

    # What must be true at every moment

    @precondition(lambda self: self.talk is not None)
    @invariant()
    def at_most_one_turn_is_current(self) -> None:
        counts["steps"] += 1
        running = [task for task in asyncio.all_tasks(self._loop) if task.get_name().startswith("turn ")]
        assert len(running) <= 1, running

    @precondition(lambda self: self.talk is not None)
    @invariant()
    def nothing_of_an_old_epoch_has_an_effect(self) -> None:
        for when, epoch, twist in self._talk.robot.moved[self._moved :]:
            assert epoch in self._planned, f"moved {twist} at {when} without a validated plan"
            assert epoch in self._begun, f"moved {twist} at {when} before an action of its epoch began"
        self._moved = len(self._talk.robot.moved)

    @precondition(lambda self: self.talk is not None)
    @invariant()
    def the_session_lives_and_says_nothing_wrong(self) -> None:
        assert not self._faults, self._faults
        assert not self._session.done(), self._session.exception()
        assert self._talk.session.state == self._state
        faults = [e.body for e in self._talk.seen[self._looked :] if isinstance(e.body, events.ErrorRaised)]
        assert all(fault.code not in ("internal", "subscriber_failed") for fault in faults), faults
        self._looked = len(self._talk.seen)
        assert self._talk.hearing.overhearing == (self._state in ("CLARIFYING", "SPEAKING", "ACTING", "FEEDBACK"))

    @precondition(lambda self: self.talk is not None)
    @invariant()
    def the_history_is_what_happened(self) -> None:
        kept = self._talk.session._cycle.entries
        assert [fact for fact in map(_fact, kept) if fact] == self._history
        for entry in kept:
            if isinstance(entry, Said):
                assert entry.text in self._words[entry.turn]
            if isinstance(entry, NeverStarted):
                assert [action.name for action in entry.actions] == list(self._waiting[entry.turn].values())

    def teardown(self) -> None:
        if self.talk is None:
            self._loop.close()
            return
        self.talk.send(Quit())
        self._run(asyncio.wait_for(self._session, SETTLED_S))
        assert not self._open, f"actions without an end: {self._open}"
        assert not self._turns, f"turns without a result: {self._turns}"
        self._every_request_has_ended()
        self._run(asyncio.sleep(2 * NEVER))  # even the most stubborn one comes to its end
        left = asyncio.all_tasks(self._loop)
        assert not left, f"tasks left over: {left}"
        self._loop.run_until_complete(self._loop.shutdown_default_executor())
        self._loop.close()
        gc.collect()
        assert threading.active_count() <= self._threads, threading.enumerate()
        assert _open_files() <= self._files, "files left open"

    # How it works

    @property
    def _talk(self) -> Conversation:
        assert self.talk is not None
        return self.talk

    def _one_listed(self, which: int) -> str:
        """The id of one that waits; for 0, and where none does, of one that has ended."""
        if self._listed and which:
            return self._listed[which % len(self._listed)].request
        return next(iter(self._ended), "nobody's")

    def _every_request_has_ended(self) -> None:
        """Once each: a second end is found when it is told."""
        assert not self._listed, "something waits in a session at rest"
        assert self._ever_listed <= self._ended.keys(), "what waited has no end"
        assert len(self._ended) == self._asked, f"{self._asked} requests, {len(self._ended)} ends"

    def _ask(self, command: Command, after: float) -> None:
        """Ask between two iterations of the loop, as another thread would, and let something pass."""
        if isinstance(command, Say):
            self._asked += 1 + len(command.then)
        before = self._talk.epoch.current
        self._talk.send(command)
        if self._talk.epoch.current != before:
            counts["interruptions"] += 1
            if not self._talk.robot.lost:
                assert self._talk.robot.state().twist.is_zero, "it still moves when the interruption returns"
        self._let_pass(after)

    def _let_pass(self, after: float) -> None:
        """Iterations of the loop if ``after`` is whole, else seconds."""
        if isinstance(after, float):
            self._run(asyncio.sleep(after))
            return
        for _ in range(after):
            self._loop.call_soon(self._loop.stop)
            self._loop.run_forever()

    def _run(self, work: Any) -> Any:
        return self._loop.run_until_complete(work)

    def _see(self, event: Event) -> None:
        try:
            self._check(event)
        except AssertionError as error:  # the bus would drop a listener that raises
            self._faults.append(f"{event}: {error}")

    def _check(self, event: Event) -> None:
        """Every event, at the moment in which it is published."""
        body, turn = event.body, event.turn or ""
        match body:
            case events.StateChanged():
                assert body.previous == self._state
                assert body.state in NEXT[body.previous]
                self._state = body.state
                if body.result is not None and turn:
                    assert turn in self._turns, "a result of a turn that is not running"
                    self._turns.discard(turn)
                    counts[f"turns {body.result.outcome}"] += 1
            case events.Ack(ok=True) if turn:
                assert turn not in self._words, "a turn began twice"
                self._turns.add(turn)
                self._words[turn] = set()
            case events.TranscriptFinal():
                if turn not in self._words:  # overheard, or added: nobody asked, so nobody is answered
                    self._turns.add(turn)
                self._words.setdefault(turn, set()).add(body.text)
            case events.RequestsWaiting():
                assert body.texts == tuple(one.text for one in body.requests)
                assert not {one.request for one in body.requests} & self._ended.keys(), "it waits and has ended"
                self._listed = body.requests
                self._ever_listed |= {one.request for one in body.requests}
                counts["waited"] += len(body.requests)
            case events.RequestEnded():
                assert body.request not in self._ended, "a request ended twice"
                assert turn not in self._turns, "a request ended before its turn"
                self._ended[body.request] = body.outcome
                counts[f"requests {body.outcome}"] += 1
            case events.Ack(do="drop" | "move", ok=True):
                counts[f"{body.do} taken"] += 1
            case events.PlanMade():
                self._planned.add(event.epoch)
            case events.ActionQueued():
                self._waiting.setdefault(turn, {})[body.action] = body.name
            case events.ActionStarted():
                del self._waiting[turn][body.action]  # fails when it starts twice, or was never queued
                assert turn in self._turns, "an action of a turn that is over"
                self._open[body.action] = turn
                self._begun.add(event.epoch)
                counts["actions"] += 1
                self._must_be_current(event)
            case events.ActionProgress():
                assert body.action in self._open, "progress of an action that does not run"
            case events.ActionFinished():
                assert body.action in self._open, "an end without a start, or a second one"
                del self._open[body.action]
                self._history.append((turn, "acted", body.name, body.outcome, body.message))
                self._must_be_on_record()
                counts[f"actions {body.outcome}"] += 1
                if body.outcome == "ok":
                    self._must_be_current(event)
            case events.SpeechStarted():
                self._must_be_current(event)
            case events.SpeechEnded():
                assert body.text.startswith(body.heard)
                self._history.append((turn, "answered", body.text, body.heard))
                self._must_be_on_record()
            case events.InterruptRaised() if turn:
                entries = self._talk.session._cycle.entries
                if any(isinstance(entry, Said) and entry.turn == turn for entry in entries):
                    self._history.append((turn, "interrupted", body.scope))
            case events.TaskEnded():
                self._history.clear()

    def _must_be_on_record(self) -> None:
        """The history has it before anybody is told."""
        facts = [fact for fact in map(_fact, self._talk.session._cycle.entries) if fact]
        assert facts[-1] == self._history[-1]

    def _must_be_current(self, event: Event) -> None:
        current = self._talk.epoch.current
        assert event.epoch == current, f"an effect of epoch {event.epoch} in epoch {current}"


def _fact(entry: object) -> object:
    """An entry of the history as the events tell it; None for what has no event of its own."""
    match entry:
        case Acted(turn, ran):
            return (turn, "acted", ran.action.name, ran.result.outcome, ran.result.message)
        case Answered(turn, text, heard):
            return (turn, "answered", text, heard)
        case Interrupted(turn, scope):
            return (turn, "interrupted", scope)
    return None


def _open_files() -> int:
    folder = Path("/proc/self/fd")
    return len(list(folder.iterdir())) if folder.is_dir() else 0
