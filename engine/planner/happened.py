"""What the history of a task tells: what was said last, what the robot asked, how often it has planned since."""

from __future__ import annotations

from collections.abc import Sequence

from engine.errors import ExitCode
from engine.plan import Plan
from engine.planner.request import Happened, NoPlan, Noted, Ran, Said


def last_said(happened: Sequence[Happened]) -> str:
    """What the user said last; empty where nothing was said."""
    return next((entry.text for entry in reversed(happened) if isinstance(entry, Said)), "")


def last_question(happened: Sequence[Happened]) -> NoPlan | None:
    """What the robot answered last, where that is a question."""
    answer = next((entry for entry in reversed(happened) if isinstance(entry, Plan | NoPlan)), None)
    return answer if isinstance(answer, NoPlan) and is_question(answer) else None


def is_question(answer: Plan | NoPlan) -> bool:
    """Whether the robot wants to know something."""
    return isinstance(answer, NoPlan) and answer.exit_code is ExitCode.CLARIFY


def rounds(happened: Sequence[Happened]) -> int:
    """Plans that were made since the user said something."""
    made = 0
    for entry in reversed(happened):
        if isinstance(entry, Said):
            break
        made += isinstance(entry, Plan | NoPlan)
    return made


def open_command(happened: Sequence[Happened]) -> tuple[str, ...]:
    """What the user said, and answered, before the question of the robot that was the last thing to happen; oldest
    first."""
    said: list[str] = []
    asked = False
    for entry in reversed(happened):
        if isinstance(entry, Plan | NoPlan):
            if not is_question(entry):
                break
            asked = True
        elif isinstance(entry, Said):
            if not asked:
                break
            said.append(entry.text)
            asked = False
    return tuple(reversed(said))


def in_words(entry: Happened) -> str:
    """The same in words: what was said, an answer as models write it, what became of an action."""
    match entry:
        case Plan() | NoPlan():
            return entry.as_written()
        case Ran():
            return str(entry)
        case Said(text) | Noted(text):
            return text
