"""What became of a command, judged from outside: whether it was understood, done, and told truly.

*Understood*: the plan comes to what the command wants, and to nothing else that matters. *Done*: it has come true, and
nobody was run into. *Told*: what was asked for was told; commands that ask for nothing have no such verdict. *Made up*
is what the robot told that is not so, also that something was done that was not.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from tests.eval.gpsr.acts import Names, acts_of, unwanted
from tests.eval.gpsr.facts import made_up, untold
from tests.eval.gpsr.goal import Command
from tests.eval.gpsr.truths import Run, contacts, untrue


@dataclass(frozen=True, slots=True)
class Verdict:
    """Each list has what is wrong, in words."""

    number: int
    category: str
    kind: str
    text: str
    misunderstood: tuple[str, ...]
    undone: tuple[str, ...]
    untold: tuple[str, ...] | None  # None: nothing is asked for
    made_up: tuple[str, ...]
    contacts: tuple[str, ...]
    cannot: str
    plan: tuple[str, ...]
    result: str
    words: str
    asked: tuple[str, ...] = ()
    people: tuple[str, ...] = ()  # what they did
    robot_s: float = 0.0
    wall_s: float = 0.0

    @property
    def understood(self) -> bool:
        return not self.misunderstood

    @property
    def done(self) -> bool:
        return not self.undone and not self.contacts

    @property
    def told(self) -> bool | None:
        return None if self.untold is None else not self.untold

    @property
    def good(self) -> bool:
        return self.understood and self.done and self.told is not False and not self.made_up


def judge(command: Command, run: Run, now: datetime) -> Verdict:
    """The verdicts on a run."""
    goal = command.goal
    names = Names(run.evidence.scene, run.evidence.places)
    candidates = [*run.plans, run.started] if run.started else list(run.plans)
    wrong = min((unwanted(goal.wants, acts_of(calls), names) for calls in candidates), key=len, default=("no plan",))
    if goal.facts and not untold(goal.facts, run, now) and not goal.truths:
        wrong = ()  # who answers a question rightly has understood it
    undone = untrue(goal.truths, run)
    if goal.cannot:
        undone = (f"cannot: {goal.cannot}",)
    else:  # what is told to somebody is what there is to do; and so is any answer, where there is nothing else
        undone += untold([fact for fact in goal.facts if fact.to or not goal.truths], run, now)
    answered = bool(run.plans) or run.evidence.result == "done"  # that it did not understand is no claim
    invented = list(made_up(goal.facts, run)) if answered else []
    if run.evidence.result == "done" and run.plans and (goal.cannot or (goal.truths and undone)):
        invented.append("said that it is done")  # without a plan it was an answer
    last = run.plans[-1] if run.plans else ()
    return Verdict(
        number=command.number,
        category=command.category,
        kind=command.kind,
        text=command.text,
        misunderstood=wrong,
        undone=undone,
        untold=untold(goal.facts, run, now) if goal.facts else None,
        made_up=tuple(invented),
        contacts=contacts(run),
        cannot=goal.cannot,
        plan=tuple(f"{name}({', '.join(str(value) for value in args.values())})" for name, args in last),
        result=run.evidence.result,
        words=run.evidence.words,
        asked=tuple(run.asked),
        people=tuple(f"{news.who} {news.does} {news.text}".rstrip() for news in run.news),
        robot_s=run.evidence.end.t - run.evidence.start.t,
    )
