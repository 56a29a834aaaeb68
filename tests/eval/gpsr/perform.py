"""Performs a command with a whole engine in a house of its own, and keeps what there is to judge.

The engine has processes of its own and a simulation as fast as the machine; a witness reads the truth from the robot's
shared memory. Where the robot asks what a command leaves open, it is answered as the goal says.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime
from typing import Any, cast, get_args

from engine import events
from engine.commands import Interrupt, Quit, Say
from engine.engine import Engine
from engine.events import Event
from engine.parts.loading import Sound
from engine.robot.company import Happening, News
from engine.robot.host.memory import Memory
from engine.robot.sim.scene import Scene
from engine.robot.sim.world import World
from tests.eval.checker import Done, Evidence, Sample
from tests.eval.gpsr.acts import Called
from tests.eval.gpsr.goal import Command
from tests.eval.gpsr.judge import Verdict, judge
from tests.eval.gpsr.truths import Run, Spoken, who_hears
from tests.eval.houses import house
from tests.eval.runner import _LOOK_S, PATIENCE_S, SETTLE_S, _sample_of, _scene_file, _settings, _Witness
from tests.eval.tasks import Trial

AFTER_S = 15.0
"""How long somebody who was followed stands before whoever asked says that it is enough, robot time."""
_ANSWERS = 3  # that are given at most
_STILL = 0.5  # m from the end of a way


@dataclass
class Heard:
    """What an engine tells of a command."""

    plans: list[tuple[Called, ...]] = field(default_factory=list)
    started: list[Called] = field(default_factory=list)
    finished: list[Done] = field(default_factory=list)
    spoken: list[tuple[float, str]] = field(default_factory=list)  # with the robot time
    asked: list[str] = field(default_factory=list)
    news: list[News] = field(default_factory=list)
    result: events.TurnResult | None = None
    ready: threading.Event = field(default_factory=threading.Event)
    over: threading.Event = field(default_factory=threading.Event)
    now: float = 0.0
    """Robot time that the witness saw last, s."""

    def hear(self, event: Event) -> None:
        match event.body:
            case events.Log(source="robot", message=message) if message.startswith("ready"):
                self.ready.set()
            case events.PlanMade(actions=actions):
                self.plans.append(tuple((action.name, action.args) for action in actions))
            case events.ActionStarted(name=name, args=args):
                self.started.append((name, args))
            case events.ActionFinished(name=name, outcome=outcome, error_code=code, data=data):
                self.finished.append(Done(name, outcome, code, data or {}))
            case events.SpeechStarted(text=text):
                self.spoken.append((self.now, text))
            case events.PersonActed(who=who, does=does, text=text, robot_t=t) if does in get_args(Happening):
                self.news.append(News(t, who, cast(Happening, does), text))
            case events.ClarificationAsked(question=question):
                self.asked.append(question)
            case events.StateChanged(result=events.TurnResult() as result):
                self.result = result
                self.over.set()
            case events.SessionEnded():
                self.over.set()


def perform(
    command: Command, *, speed: str = "max", limit_s: float = 600, settings: Mapping[str, str] | None = None
) -> Verdict:
    """Perform a command and judge it. Raises ``NoHouse``."""
    began = time.monotonic()
    seed = command.seed * 1000 + command.number
    scene = house(seed, command.needs, language=command.language, name=f"gpsr-{command.seed}-{command.number}")
    run = run_in(scene, command, speed=speed, limit_s=limit_s, settings=settings or {})
    verdict = judge(command, run, datetime.now())
    return replace(verdict, wall_s=time.monotonic() - began)


def run_in(scene: Scene, command: Command, *, speed: str, limit_s: float, settings: Mapping[str, str]) -> Run:
    """Say the command to an engine in a scene, and look on until it is over."""
    trial = Trial(
        kind=command.kind, seed=command.number, say=command.text, scene=scene, settings=dict(settings),
        limit_s=limit_s, watch_s=None, success=({"collisions": 0},),
    )  # fmt: skip
    with _scene_file(trial) as file:
        return _perform(trial, command, _settings(trial, file, speed, []))


def _perform(trial: Trial, command: Command, settings: Any) -> Run:
    heard = Heard()
    engine = Engine(settings, mode="bench", sound=Sound("none"))
    engine.subscribe(heard.hear)
    engine.start()
    try:
        if not heard.ready.wait(PATIENCE_S):
            raise RuntimeError("the robot did not start")
        memory: Memory = engine._robot.memory  # type: ignore[attr-defined]
        witness = _Witness(memory)
        reason = _converse(trial, command, engine, heard, witness)
        world = World(trial.scene, settings.robot, memory.state.get(), pictures=False)
        for _ in range(round(SETTLE_S / world.model.opt.timestep)):
            world.step()
        result = heard.result
        evidence = Evidence(
            scene=trial.scene,
            places=engine.places(),
            samples=[*witness.samples, _sample_of(world)],
            actions=heard.finished,
            result=reason or (result.outcome if result else "no result"),
            words=result.message if result else "",
        )
    finally:
        engine.send(Quit())
        engine.join(PATIENCE_S)
    spoken = [Spoken(t, text, who_hears(evidence, _at(evidence.samples, t))) for t, text in heard.spoken]
    return Run(evidence, heard.plans, heard.started, spoken, heard.asked, heard.news)


def _at(samples: Any, t: float) -> Sample:
    found: Sample = min(samples, key=lambda sample: abs(sample.t - t))
    return found


def _converse(trial: Trial, command: Command, engine: Engine, heard: Heard, witness: _Witness) -> str:
    """Say the command and answer what is asked; why it had to be ended, if it had."""
    said, reason = trial.say, ""
    for _ in range(1 + _ANSWERS):
        heard.over.clear()
        engine.send(Say(said))
        reason = _watch(trial, command, engine, heard, witness)
        outcome = heard.result.outcome if heard.result else ""
        answer = _answer(command, heard.asked[-1] if heard.asked else "")
        if reason or outcome != "clarify" or not answer:
            break
        said = answer
    return reason


def _answer(command: Command, question: str) -> str:
    return next((answer for asked, answer in command.goal.answers.items() if asked in question), "")


def _watch(trial: Trial, command: Command, engine: Engine, heard: Heard, witness: _Witness) -> str:
    """Look on until the turn is over; says why it had to be ended, if it had."""
    reason = ""
    followed = _Followed(trial.scene, command)
    stuck = time.monotonic() + PATIENCE_S
    while not heard.over.wait(_LOOK_S):
        if witness.look():
            heard.now = witness.samples[-1].t
            stuck = time.monotonic() + PATIENCE_S
        late, still = witness.elapsed > trial.limit_s, time.monotonic() > stuck
        if not reason and (late or still or followed.is_enough(witness.samples[-1])):
            reason = "the robot's clock stood still" if still else "time limit" if late else "told that it is enough"
            engine.send(Interrupt())
            stuck = time.monotonic() + PATIENCE_S
        elif reason and still:
            return "the engine did not end the turn"
    witness.look(always=True)
    return reason


class _Followed:
    """Whether the robot was only to follow, and whom it follows has stood at the end of their way for a while."""

    def __init__(self, scene: Scene, command: Command) -> None:
        last = command.goal.truths[-1] if command.goal.truths else None
        self._who = last.who if last is not None and last.what == "accompanied" else ""
        self._truth = Evidence(scene, {}, (), (), "", "")
        self._since: float | None = None

    def is_enough(self, now: Sample) -> bool:
        if not self._who:
            return False
        end = self._truth.scene.people[self._who].leads[-1]
        if math.dist(self._truth.at(self._who, now)[:2], end) > _STILL:
            self._since = None
        elif self._since is None:
            self._since = now.t
        return self._since is not None and now.t - self._since > AFTER_S
