"""What the history of a task tells: what was said last, what the robot asked, how often it has planned since."""

from __future__ import annotations

from collections.abc import Sequence

from engine.errors import ExitCode
from engine.plan import Action, Plan
from engine.planner.reply import FINISH
from engine.planner.request import Happened, NoPlan, Noted, Ran, Said, Withdrawn


def last_said(happened: Sequence[Happened]) -> str:
    """What the user said last; empty where nothing was said."""
    return next((entry.text for entry in reversed(happened) if isinstance(entry, Said)), "")


def last_question(happened: Sequence[Happened]) -> NoPlan | None:
    """What the robot answered last, where that is a question that is still open; as it was put first."""
    answer = _last_answer(_understood(happened))
    return answer if isinstance(answer, NoPlan) and is_question(answer) else None


def to_repeat(happened: Sequence[Happened]) -> NoPlan | None:
    """The open question, where it may be put once more: it has been put once, and an answer completes a request."""
    question, answer = last_question(happened), _last_answer(happened)
    again = isinstance(answer, NoPlan) and answer.repeats
    return question if question is not None and question.leaves_open and not again else None


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


def open_command(happened: Sequence[Happened]) -> tuple[tuple[str, str], ...]:
    """What the user said, and answered, before the question of the robot that was the last thing to happen, oldest
    first; each with what the question lacked to which it was the answer (``NoPlan.lacks``)."""
    said: list[tuple[str, str]] = []
    asked = False
    for entry in reversed(_understood(happened)):
        if isinstance(entry, Plan | NoPlan):
            if not is_question(entry):
                break
            if said and isinstance(entry, NoPlan):
                said[-1] = (said[-1][0], entry.lacks)
            asked = True
        elif isinstance(entry, Withdrawn):
            break
        elif isinstance(entry, Said):
            if not asked:
                break
            said.append((entry.text, ""))
            asked = False
    return tuple(reversed(said))


def planned_last(happened: Sequence[Happened]) -> tuple[Action, ...]:
    """What was planned last; of a plan that failed, only what has not been done."""
    done = 0
    for entry in reversed(happened):
        if isinstance(entry, Ran):
            done += entry.outcome == "ok"
        elif isinstance(entry, Plan):
            actions = tuple(action for action in entry.actions if action.name not in (FINISH, "finish_dialogue"))
            if actions:
                return actions[done:] or actions
    return ()


def named_last(happened: Sequence[Happened], kind: str) -> str:
    """The thing (``object``) or the place (``place``) that an action of the newest plan which names one has."""
    plans = (entry for entry in reversed(happened) if isinstance(entry, Plan))
    named = (action.args[kind] for plan in plans for action in reversed(plan.actions) if action.args.get(kind))
    return str(next(named, ""))


def counted_last(happened: Sequence[Happened]) -> int | None:
    """How many people the last action has counted; None where it has counted none."""
    last = next((entry for entry in reversed(happened) if isinstance(entry, Ran)), None)
    people = last.data.get("people") if last is not None and last.outcome == "ok" else None
    return people if isinstance(people, int) else None


def answered_last(happened: Sequence[Happened]) -> str:
    """What somebody has answered whom the last action asked; empty where none did."""
    last = next((entry for entry in reversed(happened) if isinstance(entry, Ran)), None)
    return str(last.data.get("answer", "")) if last is not None else ""


def worked_last(happened: Sequence[Happened]) -> bool | None:
    """Whether the last action went well; None where there was none."""
    last = next((entry for entry in reversed(happened) if isinstance(entry, Ran)), None)
    return None if last is None else last.outcome == "ok"


def decided_last(happened: Sequence[Happened]) -> tuple[bool, ...]:
    """How the conditions of the newest plan were decided."""
    last = next((entry for entry in reversed(happened) if isinstance(entry, Plan)), None)
    return last.decided if last is not None else ()


def is_open(happened: Sequence[Happened]) -> bool:
    """Whether the newest plan of a reader has left something to be decided."""
    last = next((entry for entry in reversed(happened) if isinstance(entry, Plan | NoPlan)), None)
    return isinstance(last, Plan) and last.source == "reader" and not last.finished


def in_words(entry: Happened) -> str:
    """The same in words: what was said, an answer as models write it, what became of an action."""
    match entry:
        case Plan() | NoPlan():
            return entry.as_written()
        case Ran():
            return str(entry)
        case Said(text) | Noted(text):
            return text
        case Withdrawn():
            return "Nobody will answer that question: the user interrupted."


def _last_answer(happened: Sequence[Happened]) -> Plan | NoPlan | Withdrawn | None:
    return next((entry for entry in reversed(happened) if isinstance(entry, Plan | NoPlan | Withdrawn)), None)


def _understood(happened: Sequence[Happened]) -> Sequence[Happened]:
    """Without what was said to a question and was not understood, and without the question that was put once more."""
    kept: list[Happened] = []
    for entry in happened:
        if not (isinstance(entry, NoPlan) and entry.repeats):
            kept.append(entry)
        elif kept and isinstance(kept[-1], Said):
            kept.pop()
    return kept
