"""Judges what a planner answers to a command of a set: the right plan, question, refusal, reason or small talk."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from time import perf_counter
from typing import Any, Final, Literal, Protocol

from engine.errors import ExitCode, PlanError, SaysoError
from engine.perception.someone import Someone, someone
from engine.plan import Plan
from engine.planner.doing.sought import ANYTHING, PERSON
from engine.planner.happened import in_words
from engine.planner.request import NoPlan, PlanRequest, Ran, Said
from tests.eval.commands import Entry, Next, plans_in
from tests.eval.effects import Step, Words, effects
from tests.eval.equivalence import accepts, read, slots_right
from tests.eval.said import ungrounded

Outcome = Literal["plan", "clarify", "refuse", "impossible", "chat", "lost", "error"]
"""lost: no plan because nothing was understood or no model gave a usable answer, which is right for nothing."""

LOST: Final = frozenset({"not_understood", "unreadable_reply", "unknown_skill", "invalid_plan"})
TALK: Final = frozenset({"say", "list_skills", "arm_nod", "arm_shake", "arm_applaud"})
"""Skills that may go with small talk."""
LOOKS: Final = frozenset({"seewhat", "scan_room", "locate", "get_current_pose"})
_WHERE: Final = re.compile(r" (?:on|in|at|under|beside|behind|near|by|next to|in front of|lying|standing|sitting)\b")
"""What stands between a thing that was seen and where that was."""
_cycles = itertools.count()


class Plans(Protocol):
    """The planner under judgement."""

    async def plan(self, request: PlanRequest) -> Plan | NoPlan:
        """As ``engine.planner.planner.Planner`` does."""
        ...


class KnownWords(Words, Protocol):
    """Words of a world whose things are known."""

    def inventory(self) -> Sequence[str]:
        """The names of all things."""
        ...


@dataclass(frozen=True, slots=True)
class Answer:
    """What came of one request."""

    outcome: Outcome
    steps: tuple[Step, ...]
    shown: str
    """For people."""
    source: str
    seconds: float
    finished: bool = True
    found: Plan | NoPlan | None = None
    """What the planner answered."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """How an entry went."""

    entry: Entry
    answers: tuple[Answer, ...]
    """To the command, and to every feedback that was given after it."""
    ok: bool
    slots: bool | None
    """Whether the arguments were right; None where no plan was wanted."""
    ungrounded: tuple[str, ...]
    forbidden: bool
    """Something that had to be refused was planned."""

    @property
    def first(self) -> Answer:
        """The answer to the command."""
        return self.answers[0]


class _Known:
    """The words of a world, of whose things some were seen: to fetch one of those is to go there anyway."""

    def __init__(self, words: KnownWords, seen: Sequence[str], say: str = "") -> None:
        self._words = words
        self._said = frozenset(
            words.place(" ".join(behind.split()[:size]))
            for behind in _SOURCE.split(say.casefold())[1:]
            for size in (1, 2)
        )
        self._spots = _spots(seen, words)

    def homes(self, thing: str) -> frozenset[str]:
        """Where a thing is from the start, where it was seen, and where somebody says that it is."""
        seen = {place for things, place in self._spots if thing in things}
        return (
            self._words.homes(thing) | self._said | seen | {room for place in seen if (room := self._words.room(place))}
        )

    def __getattr__(self, name: str) -> Any:
        return getattr(self._words, name)


_SOURCE: Final = re.compile(r"\b(?:from|off|out of|on|in|at|by|inside|under) (?:the |my |your |our )?")
"""What stands before where a thing is said to be."""


def _spots(seen: Sequence[str], words: Words) -> Sequence[tuple[frozenset[str], str]]:
    """The things that are told to have been seen, and where: ``white cup on the stool``."""
    told = [(sentence, _WHERE.search(sentence)) for sentence in seen]
    return [
        (
            words.things(sentence[: at.start()].removeprefix("the ")),
            words.place(sentence[at.end() :].strip(" .").removeprefix("the ")),
        )
        for sentence, at in told
        if at is not None
    ]


async def judge(entry: Entry, planner: Plans, world: KnownWords) -> Verdict:
    """Ask the planner, and judge what it says. Where its plan looks, both outcomes are played to it; what was seen
    before is seen then."""
    name, words = f"judged {next(_cycles)}", _Known(world, entry.seen, entry.say)
    request = PlanRequest(entry.say, entry.happened(), name, entry.language, holding=entry.holding, seen=entry.seen)
    answer = await _ask(planner, request)
    ok = acceptable(entry.ok, answer, words, must_go_on=_waits(entry))
    answers = [answer]
    if ok:
        for after in entry.then if answer.outcome == "plan" else ():
            words = _Known(world, (*entry.seen, *after.seen), entry.say)
            over = answer.finished and not after.feedback.startswith("failed")
            answers.append(NOTHING_MORE if over else await _ask(planner, _after(request, answer, after, words)))
            ok = ok and (
                acceptable(after.ok, answers[-1], words, must_go_on=False)
                or _is_done(after, answer, answers[-1], words)
            )
    elif entry.seen and not entry.then and answer.outcome == "plan" and not answer.finished:
        again = Next(feedback=f"ok: {', '.join(entry.seen)}", seen=entry.seen, ok=entry.ok)
        answers.append(await _ask(planner, _after(request, answer, again, words)))
        ok = acceptable(entry.ok, answers[-1], words, must_go_on=False)
    said = " ".join((entry.say, entry.holding, *entry.seen, *map(in_words, entry.happened())))
    out_of_nowhere = () if ok or answer.outcome != "plan" else _out_of_nowhere(entry, answer, said, words)
    return Verdict(
        entry=entry,
        answers=tuple(answers),
        ok=ok,
        slots=_slots(entry, answer, words),
        ungrounded=out_of_nowhere,
        forbidden=answer.outcome == "plan" and set(entry.ok) <= {"refuse", "impossible"} and "refuse" in entry.ok,
    )


NOTHING_MORE: Final = Answer("plan", (), "nothing more", "", 0.0)
"""After a plan that has done all that was asked for: no planner is asked again then."""


def _is_done(after: Next, first: Answer, then: Answer, words: Words) -> bool:
    """Whether nothing is left to do because the first plan has done it already: it tried, and it went well."""
    done = not after.feedback.startswith("failed") and not then.steps and then.outcome in ("plan", "chat")
    acts = then is NOTHING_MORE and any(step.name not in LOOKS for step in first.steps)
    return done and (acts or acceptable(after.ok, first, words, must_go_on=False))


def acceptable(ok: Sequence[str], answer: Answer, words: Words, *, must_go_on: bool) -> bool:
    """Whether an answer is one of those that are acceptable. ``must_go_on``: the plan waits for feedback."""
    if answer.outcome in ok:
        return True
    if answer.outcome == "chat" and isinstance(answer.found, Plan):
        return any(accepts(plan, (Step("say", (answer.found.response,)),), words) for plan in plans_in(tuple(ok)))
    if answer.outcome != "plan":
        return False
    if "chat" in ok and all(step.name in TALK for step in answer.steps):
        return True
    if "clarify" in ok and _asks(answer.steps):
        return True
    if must_go_on and answer.finished:
        return False
    return any(accepts(plan, answer.steps, words) for plan in plans_in(tuple(ok)))


def _waits(entry: Entry) -> bool:
    """Whether the plan for a command has to wait for what a look shows: not where the robot knows by itself whether the
    condition holds, as with what is in its hand."""
    looks = any(way.about for plan in entry.plans for way in read(plan))
    return entry.category == "conditional" and (looks or bool(entry.then))


def _asks(steps: Sequence[Step]) -> bool:
    """Whether a plan only leads to a question."""
    return bool(steps) and steps[-1].name == "ask_user" and all(step.name in LOOKS for step in steps[:-1])


def _slots(entry: Entry, answer: Answer, words: Words) -> bool | None:
    if len(entry.plans) < len(entry.ok) or not entry.plans:
        return None
    return answer.outcome == "plan" and slots_right(entry.plans, answer.steps, words)


def _out_of_nowhere(entry: Entry, answer: Answer, said: str, words: KnownWords) -> tuple[str, ...]:
    wanted = [e for plan in entry.plans for way in read(plan) for e in effects(way.steps, words, explicit=True)]
    return ungrounded(answer.steps, said, words.inventory(), words, wanted=wanted)


async def _ask(planner: Plans, request: PlanRequest) -> Answer:
    begin = perf_counter()
    try:
        found = await planner.plan(request)
    except SaysoError as error:
        return Answer("error", (), f"{type(error).__name__}: {error}", "", perf_counter() - begin)
    return as_answer(found, perf_counter() - begin)


def as_answer(found: Plan | NoPlan, seconds: float) -> Answer:
    """What a planner's answer comes to."""
    if isinstance(found, NoPlan):
        outcome: Outcome = {ExitCode.CLARIFY: "clarify", ExitCode.REFUSED: "refuse"}.get(  # type: ignore[assignment]
            found.exit_code, "lost" if found.code in LOST or found.code.startswith("model_") else "impossible"
        )
        shown = f"{outcome} ({found.code}): {found.answer}"
        return Answer(outcome, (), shown, "", seconds, found=found)
    steps = tuple(
        Step(action.name, tuple(_value(value) for value in action.args.values()))
        for action in found.actions
        if action.name != "finishtask"
    )
    shown = "; ".join(str(action) for action in found.actions)
    if steps:
        return Answer("plan", steps, shown, found.source, seconds, found.finished, found)
    outcome = "chat" if found.response else "lost"
    return Answer(outcome, (), f"{outcome}: {found.response}", found.source, seconds, True, found)


def _value(value: object) -> str | float:
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else str(value)


def _after(request: PlanRequest, answer: Answer, after: Next, words: Words) -> PlanRequest:
    """What is asked when the plan is done, and this is what came of it."""
    assert isinstance(answer.found, Plan)
    *before, last = answer.found.actions
    nobody = last.name in _FINDS_PEOPLE and _NOBODY.search(after.feedback) is not None
    how: Literal["ok", "failed"] = "failed" if nobody or after.feedback.startswith("failed") else "ok"
    done = (*(Ran(action, "ok") for action in before), Ran(last, how, after.feedback, _found(after.feedback)))
    said = (*request.happened, Said(request.text), answer.found, *done)
    return PlanRequest(
        "", said, request.cycle, request.language, holding=request.holding, seen=after.seen, sees=_sees(after, words),
        may_be_at=_may_be_at(after, words),
    )  # fmt: skip


def _may_be_at(after: Next, words: Words) -> Callable[[str, str], bool]:
    """Whether a thing that is seen may be at a place: ``white cup on the stool`` is not on the shelf. Where the world
    tells no rooms, one may be in the other."""
    spots = _spots(after.seen, words)

    def may_be_at(thing: str, place: str) -> bool:
        where = [at for things, at in spots if thing == ANYTHING or words.things(thing) & things]
        there = words.place(place)
        return not where or any(_may_be_the_same(at, there, words) for at in where)

    return may_be_at


def _may_be_the_same(one: str, other: str, words: Words) -> bool:
    rooms = words.room(one), words.room(other)
    return one == other or rooms[0] == other or rooms[1] == one or not any(rooms)


def _sees(after: Next, words: Words) -> Callable[[str], bool]:
    """Whether a thing is among what is seen now: ``white cup on the stool`` shows a cup."""
    heads = [_WHERE.split(sentence)[0] for sentence in after.seen]
    people = [someone(head) for head in heads if _PERSON.match(head)]
    things = [words.things(head) for head in heads if not _PERSON.match(head)]

    def sees(thing: str) -> bool:
        if any(words.things(thing) & seen for seen in things) or (thing == ANYTHING and bool(things)):
            return True
        try:
            who = someone(thing)
        except PlanError:
            return False
        known = thing == PERSON or not words.things(thing)
        return known and any(_may_be(who, other) for other in people)

    return sees


def _may_be(who: Someone, seen: Someone) -> bool:
    """Whether somebody who was seen is meant; what is not told of them may be so."""
    told = ((getattr(who, part.name), getattr(seen, part.name)) for part in fields(who) if part.name != "name")
    return who.name in ("", seen.name) and all(wanted is None or has in (None, wanted) for wanted, has in told)


_FINDS_PEOPLE: Final = frozenset({"meet", "find_person"})
"""Skills that fail where nobody is found."""
_NOBODY: Final = re.compile(r"\b(?:nobody|no one|not (?:there|found|in)|isn't)\b|没有?人|不在|没看到")
_PERSON: Final = re.compile(
    r"(?:the |an? )?(?:person|people|somebody|someone|man|woman|boy|girl|child|kid|guest|visitor)s?\b|"
    r"[A-Z]|有?人|[男女]"
)
"""How people are told of among what is seen."""


def _found(feedback: str) -> dict[str, object]:
    """How many people are told of; and what somebody may have answered."""
    found = re.search(r"\b(no|one|two|three|four|five|\d+) (?:person|people)\b", feedback)
    if found is None:
        return {"answer": feedback.partition(":")[2].strip() or feedback}
    names = ("no", "one", "two", "three", "four", "five")
    return {"people": names.index(found[1]) if found[1] in names else int(found[1])}
