"""The command sets: what is said, after what, and what is acceptable then.

A set is a YAML file with a list of entries under each category. An entry has ``say`` and ``ok`` (one answer or
several: plans as :mod:`tests.eval.equivalence` reads them, or ``clarify``, ``refuse``, ``impossible``, ``chat``), and
where it matters ``language``, ``world`` (a file of ``worlds/``), ``holding``, ``seen``, ``context`` (earlier turns,
oldest first: ``user`` with ``plan`` and ``feedback``, or with the ``question`` that was asked) and ``then``: for a plan
that only looks, what may come of it, each with ``feedback``, ``seen`` and what is acceptable next.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Final

import yaml
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from engine.planner.request import Happened, Language, Said
from tests.eval.equivalence import read
from tests.history import asked, planned, ran

HERE: Final = Path(__file__).parent
OUTCOMES: Final = ("clarify", "refuse", "impossible", "chat")


def _several(value: Any) -> Any:
    return (value,) if isinstance(value, str) else value


Several = Annotated[tuple[str, ...], BeforeValidator(_several)]


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Turn(_Part):
    """An earlier turn."""

    user: str
    plan: str = ""
    feedback: str = Field(default="ok", description="What became of the plan; ok: all of it was done.")
    question: str = ""

    def happened(self) -> Iterator[Happened]:
        """As a planner is told it."""
        yield Said(self.user)
        if self.question:
            yield asked(self.question)
        if self.plan:
            actions = [action.strip() for action in self.plan.split(";")]
            yield planned(*actions)
            if self.feedback == "ok":
                yield from (ran(action) for action in actions)
            else:
                failed = self.feedback.startswith("failed")
                told = self.feedback.removeprefix("failed").removeprefix("ok").lstrip(".: ")
                yield ran(actions[-1], "failed" if failed else "ok", told)


class Next(_Part):
    """What came of a plan that looked, and what is acceptable then."""

    feedback: str
    seen: Several = ()
    ok: Several


class Entry(_Part):
    """One command."""

    id: str
    category: str
    language: Language
    say: str
    ok: Several
    world: str | None = None
    holding: str = ""
    seen: Several = ()
    context: tuple[Turn, ...] = ()
    then: tuple[Next, ...] = ()

    @property
    def plans(self) -> tuple[str, ...]:
        """The acceptable plans."""
        return plans_in(self.ok)

    def happened(self) -> tuple[Happened, ...]:
        """What was said and done before."""
        return tuple(entry for turn in self.context for entry in turn.happened())


def plans_in(ok: tuple[str, ...]) -> tuple[str, ...]:
    """Those of the acceptable answers that are plans."""
    return tuple(answer for answer in ok if answer not in OUTCOMES)


def load_commands(path: Path) -> tuple[Entry, ...]:
    """The entries of a set. Raises ``ValueError`` where one is wrong."""
    raw = yaml.safe_load(path.read_text("utf-8"))
    entries = tuple(
        Entry.model_validate({"category": category, "language": "zh" if category == "zh" else "en", **entry})
        for category, entries in raw.items()
        for entry in entries
    )
    ids = [entry.id for entry in entries]
    if twice := {name for name in ids if ids.count(name) > 1}:
        raise ValueError(f"{path}: there twice: {', '.join(sorted(twice))}")
    for entry in entries:
        for answers in (entry.ok, *(after.ok for after in entry.then)):
            for plan in plans_in(answers):
                read(plan)
    return entries


def world_file(name: str) -> Path:
    """Where a world of the sets is."""
    return HERE / "worlds" / f"{name}.yaml"
