"""What is copied to the clipboard: a part of what the console shows, as plain text.

The terminal holds the clipboard, and it may be far away (OSC 52), so that the text goes down the line and is as short
as it can be. Terminals drop what is too long for them: of such a text the newest part is copied.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final, Literal

from tui.screens.turn import rows
from tui.shown.timeline import Bar
from tui.widgets.page import Row
from tui.widgets.plan import plan_items
from tui.widgets.queue import SIGNS
from tui.widgets.sound import Wave
from tui.widgets.timeline import Total, milliseconds
from tui.words import strings
from tui.words.language import told
from tui.words.widths import left, right

if TYPE_CHECKING:
    from tui.shown.facts import Line, LogLine
    from tui.shown.turn import Turn
    from tui.shown.view import View

Part = Literal["turn", "conversation", "plan", "actions", "log"]
PARTS: Final[tuple[Part, ...]] = ("turn", "conversation", "plan", "actions", "log")
"""In the order in which one asks for them by asking again."""
MAX_BYTES: Final = 74_994
"""What a sequence of 100 000 bytes holds, which is as much as hterm, tmux and others take."""


def next_part(part: Part) -> Part:
    """The one that is copied when the same key is pressed once more."""
    return PARTS[(PARTS.index(part) + 1) % len(PARTS)]


def plain(part: Part, view: View) -> str:
    """That part as text; empty when there is nothing in it yet. Turn: that is browsed to, or else the newest one."""
    model = view.model
    match part:
        case "turn":
            turn = view.turn or (model.turns.kept[-1] if model.turns.kept else None)
            lines = list(_turn(turn, view.now)) if turn is not None else []
        case "conversation":
            lines = [_line(line) for line in model.conversation]
        case "plan":
            lines = [f"{sign}{text}" for _, sign, text, _ in plan_items(model.plan)] if model.plan is not None else []
        case "actions":
            lines = [
                f"{SIGNS[row.phase][0]} {row.index} {told(row.call)}{f'  {told(row.message)}' if row.message else ''}"
                for row in model.queue
            ]
        case "log":
            lines = [_logged(line) for line in model.log]
    return fitting("\n".join(line.rstrip() for line in lines).strip("\n"))


def fitting(text: str) -> str:
    """Its newest whole lines that a terminal takes."""
    data = text.encode()
    if len(data) <= MAX_BYTES:
        return text
    kept = data[-MAX_BYTES:]
    return kept[kept.find(b"\n") + 1 :].decode(errors="ignore")


def _turn(turn: Turn, now: float) -> Iterator[str]:
    """The page of a turn; pictures made of characters are left out, their figures stay."""
    for item in rows(turn, now, unfolded=True):
        match item:
            case Row():
                body, aside = ("".join(text for text, _ in pieces) for pieces in (item.body, item.aside))
                yield f"{left(item.part, 11)}{' ' * item.indent}{body}{f'  {aside}' if aside else ''}"
            case Bar():
                yield f"{'':<11}{left(strings.STAGES[item.stage], 10)}{milliseconds(item.milliseconds / 1000):>10}"
            case Total():
                yield f"{'':<11}{left(item.name, 10)}{milliseconds(item.ended - item.began):>10}  {item.since}"
            case Wave():
                pass


def _line(line: Line) -> str:
    who = {
        "you": strings.YOU,
        "robot": strings.ROBOT,
        "unheard": "∅",
        "mark": "■",
        "lost": "■",
        "done": "✓",
        "problem": "✗",
    }
    text = told(line.text) if line.who in ("done", "problem") else line.text
    note = strings.REASONS.get(line.note, line.note)
    return f"{right(who[line.who], 5)}  {text}{f'  ({note})' if note else ''}"


def _logged(line: LogLine) -> str:
    return f"{line.t:8.2f} {line.level:<7} {line.source} {told(line.message)}"
