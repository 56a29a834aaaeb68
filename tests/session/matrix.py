"""What happens when: every state of a session, and every way to interrupt it.

The table is written by hand and says what a person would expect; ``CONSEQUENCES`` says what each of its phrases means
exactly, and ``test_matrix`` tries every cell. None of it is derived from the engine's own tables, which are under test.
``python -m tests.session.matrix`` prints the table for the README.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final, Literal

from engine.commands import Command, Drive, EndTask, EStop, Halted, Heard, Interrupt, Quit, Say, Wake
from engine.events import Scope, State

WHAT_HAPPENS: Final[dict[tuple[State, ...], dict[str, str]]] = {
    ("IDLE", "WAITING"): {
        "wake": "listens",
        "interrupt": "nothing to stop",
        "estop": "nothing to stop",
        "by-hand": "drives",
        "end-task": "arm home, new task",
        "end-task-phrase": "arm home, new task",
        "end-task-chinese": "arm home, new task",
        "stop": "says so",
        "stop-chinese": "says so",
        "stop-overheard": "not overheard",
        "command": "does it",
        "command-queue": "does it",
        "command-reject": "does it",
        "halted": "goes on",
        "quit": "ends",
    },
    ("LISTENING",): {
        "wake": "restarts the recording",
        "interrupt": "stops",
        "estop": "stops",
        "by-hand": "stops, drives",
        "end-task": "stops, arm home, new task",
        "end-task-phrase": "stops, arm home, new task",
        "end-task-chinese": "stops, arm home, new task",
        "stop": "stops, says so",
        "stop-chinese": "stops, says so",
        "stop-overheard": "not overheard",
        "command": "stops, does it",
        "command-queue": "waits",
        "command-reject": "not taken",
        "halted": "goes on",
        "quit": "stops, ends",
    },
    ("TRANSCRIBING", "DECIDING", "PLANNING"): {
        "wake": "stops, listens",
        "interrupt": "stops",
        "estop": "stops",
        "by-hand": "stops, drives",
        "end-task": "stops, arm home, new task",
        "end-task-phrase": "stops, arm home, new task",
        "end-task-chinese": "stops, arm home, new task",
        "stop": "stops, says so",
        "stop-chinese": "stops, says so",
        "stop-overheard": "not overheard",
        "command": "stops, does it",
        "command-queue": "waits",
        "command-reject": "not taken",
        "halted": "goes on",
        "quit": "stops, ends",
    },
    ("CLARIFYING", "SPEAKING", "ACTING", "FEEDBACK"): {
        "wake": "stops, arm home, listens",
        "interrupt": "stops",
        "estop": "stops",
        "by-hand": "stops, drives",
        "end-task": "stops, arm home, new task",
        "end-task-phrase": "stops, arm home, new task",
        "end-task-chinese": "stops, arm home, new task",
        "stop": "stops, says so",
        "stop-chinese": "stops, says so",
        "stop-overheard": "stops, says so",
        "command": "stops, does it",
        "command-queue": "waits",
        "command-reject": "not taken",
        "halted": "stops, says why",
        "quit": "stops, ends",
    },
}
"""By the state that a session is in: what each interruption does to it."""


@dataclass(frozen=True, slots=True)
class Interruption:
    """Something that happens to a session."""

    head: str
    """For people."""
    command: Command
    scope: Scope
    """What it counts as where it interrupts."""
    busy: Literal["interrupt", "queue", "reject"] = "interrupt"
    """The setting ``session.busy``."""
    told: Mapping[str, str] = field(default_factory=dict)
    """What is said in another language than the consequences are written in."""


INTERRUPTIONS: Final[dict[str, Interruption]] = {
    "wake": Interruption("wake (`space`)", Wake(id="it"), "wake"),
    "interrupt": Interruption("interrupt (`esc`)", Interrupt(id="it"), "interrupt"),
    "estop": Interruption("emergency stop (`ctrl+x`)", EStop(id="it"), "estop"),
    "by-hand": Interruption("driving by hand", Drive(vx=0.2, id="it"), "by_hand"),
    "end-task": Interruption("end of the task (`e`)", EndTask(id="it"), "end_task"),
    "end-task-phrase": Interruption("“end the current task”", Say("End the current task.", id="it"), "end_task"),
    "end-task-chinese": Interruption("“结束当前任务”", Say("结束当前任务", id="it"), "end_task"),
    "stop": Interruption("“stop”", Say("Stop!", id="it"), "stop"),
    "stop-chinese": Interruption("“停”", Say("停", id="it"), "stop", told={"Stopped.": "停下了。"}),
    "stop-overheard": Interruption("“stop” overheard", Heard("stop"), "stop"),
    "command": Interruption("new command", Say("turn left 90 degrees", id="it"), "replaced"),
    "command-queue": Interruption("with `queue`", Say("turn left 90 degrees", id="it"), "replaced", "queue"),
    "command-reject": Interruption("with `reject`", Say("turn left 90 degrees", id="it"), "replaced", "reject"),
    "halted": Interruption("robot halts by itself", Halted("heartbeat lost"), "halted"),
    "quit": Interruption("quit (`q`)", Quit(id="it"), "shutdown"),
}

OVERHEARING: Final[frozenset[State]] = frozenset({"CLARIFYING", "SPEAKING", "ACTING", "FEEDBACK"})
"""Where a "stop" counts that no wake has announced."""


@dataclass(frozen=True, slots=True)
class Consequence:
    """What a phrase of the table means. What it does not mention does not happen."""

    path: tuple[State, ...] = ()
    """The states from then on, in this order; where a turn runs and is left alone, those that follow its own."""
    turn: Literal["left alone", "interrupted", "failed"] = "left alone"
    """What becomes of the turn that runs, if any."""
    raised: bool = False
    """It is on record as an interruption."""
    recordings: tuple[Literal["new", "restarted"], ...] = ()
    arm_home: bool = False
    new_cycle: bool = False
    """The history is forgotten, and the task cycle has the next number."""
    does: tuple[str, ...] = ()
    """Actions that start from then on and end well, by name."""
    by_hand: bool = False
    """It moves as a person has it move."""
    says: tuple[str, ...] = ()
    """Sentences that are said from then on, to their end."""
    error: str = ""
    """What is shown as an error."""
    acknowledged: bool = True
    """Whoever sent the command is told that it was taken."""
    ends_session: bool = False


_RESTS: Final = Consequence(("WAITING",), "interrupted", raised=True)
_TURNS: Final[tuple[State, ...]] = ("PLANNING", "ACTING", "FEEDBACK", "WAITING")
_TURNED: Final = ("Turning left 90 degrees.", "Turned 90° left.")
_HALTED: Final = "I stopped by myself: heartbeat lost."

CONSEQUENCES: Final[dict[str, Consequence]] = {
    # where nothing runs
    "listens": Consequence(("LISTENING",), recordings=("new",)),
    "nothing to stop": Consequence(raised=True),
    "arm home, new task": Consequence(("IDLE",), arm_home=True, new_cycle=True),
    "says so": Consequence(("SPEAKING", "WAITING"), says=("Stopped.",)),
    "does it": Consequence(_TURNS, does=("move_left",), says=_TURNED),
    "ends": Consequence(ends_session=True),
    "drives": Consequence(by_hand=True),
    # what runs goes on
    "not overheard": Consequence(),
    "goes on": Consequence(),
    "waits": Consequence(_TURNS, does=("move_left",), says=_TURNED),
    "not taken": Consequence(acknowledged=False),
    # what runs ends
    "stops": _RESTS,
    "restarts the recording": replace(_RESTS, path=("WAITING", "LISTENING"), recordings=("restarted",)),
    "stops, listens": replace(_RESTS, path=("WAITING", "LISTENING"), recordings=("new",)),
    "stops, arm home, listens": replace(_RESTS, path=("WAITING", "LISTENING"), recordings=("new",), arm_home=True),
    "stops, arm home, new task": replace(_RESTS, path=("WAITING", "IDLE"), arm_home=True, new_cycle=True),
    "stops, drives": replace(_RESTS, by_hand=True),
    "stops, says so": replace(_RESTS, path=("WAITING", "SPEAKING", "WAITING"), says=("Stopped.",)),
    "stops, does it": replace(_RESTS, path=("WAITING", *_TURNS), does=("move_left",), says=_TURNED),
    "stops, says why": replace(_RESTS, turn="failed", error=_HALTED),
    "stops, ends": replace(_RESTS, ends_session=True),
}


def markdown() -> str:
    """The table for the README; interruptions that do the same in every state share a column."""
    heads: dict[tuple[str, ...], list[str]] = {}
    for name, interruption in INTERRUPTIONS.items():
        column = tuple(row[name] for row in WHAT_HAPPENS.values())
        heads.setdefault(column, []).append(interruption.head)
    lines = [["in", *(", ".join(head) for head in heads.values())], ["---"] * (len(heads) + 1)]
    for index, states in enumerate(WHAT_HAPPENS):
        lines.append([" ".join(f"`{state}`" for state in states), *(column[index] for column in heads)])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


if __name__ == "__main__":
    print(markdown())
