"""The whole console on one line, for a pane beside other work: state, what is heard, said or done, what waits, and
where the robot is. What there is no room for is left out as a whole, the least urgent first; words that are longer than
that have the rows below, where there are some, and end with an ellipsis where there is no more room."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.cells import cell_len
from textual.content import Content
from textual.widgets import Static

from engine.states import REST
from tui.widgets.conversation import STYLES, as_told
from tui.widgets.status import chip
from tui.words import strings
from tui.words.hints import JOINT
from tui.words.language import told

if TYPE_CHECKING:
    from tui.shown.facts import Ended
    from tui.shown.view import View

Piece = tuple[str, str]
_WIDE = 48
"""With fewer columns, what happens begins right behind the sign, wherever that ends."""


class OneLine(Static):
    """One line, or a few; it is drawn anew only when its words change."""

    def __init__(self) -> None:
        super().__init__(id="one-line", markup=False)
        self._shown: Content = Content("")
        self._view: View | None = None

    def update_from(self, view: View) -> None:
        self._view = view
        sign = chip(view) if self.size.width >= _WIDE else chip(view).rstrip().pad_right(1)
        words, style = happening(view)
        room, below = max(0, self.size.width - sign.cell_length - 2), self.size.height - 1
        words, right = _fitting(view, words, room) if below < 1 else (words, _beside(view, 0, room))
        first = max(1, room - cell_len(right))
        rows = [words] if below < 1 else _wrapped(words, first, self.size.width, below)
        left = Content.styled(rows[0], style).truncate(first, ellipsis=True, pad=True)
        shown = Content.assemble(sign, " ", left, " ", (right, "$foreground 60%"))
        for row in rows[1:]:
            shown = Content.assemble(shown, "\n", Content.styled(row, style).truncate(self.size.width, ellipsis=True))
        if not shown.is_same(self._shown):
            self._shown = shown
            self.update(shown, layout=False)

    def on_resize(self) -> None:
        if self._view is not None:
            self.update_from(self._view)


def happening(view: View, *, progress: bool = True, ends_first: bool = False) -> Piece:
    """What one has to know: what is the case now, why nothing moves, and how requests ended that were not done. Where
    nothing else is the case than that nothing moves, the last that was said stands before it. An engine that is lost
    for good is told behind the ends, as it stays and they do not. ``progress``: with how far what runs has come;
    ``ends_first``: before what runs."""
    ended, problem = _ended(view.ends) if view.ends else "", view.model.problem
    now = _urgent(view) or _now(view, progress=progress) or (None if ended else _said_last(view))
    words, style = now or ("", "$text-warning")
    if now is None and not view.standstill and not ended:
        return strings.ONE_LINE, "$foreground 60%"
    if now is None and view.standstill:
        style = "bold $text-error"
    pieces = [words, view.standstill, view.remark, ended]
    if ends_first:
        pieces = [ended, words, view.standstill, view.remark]
    if problem is not None and problem.fatal:
        pieces = [ended, words, view.standstill]
    return JOINT.join(filter(None, pieces)), style


def _fitting(view: View, words: str, room: int) -> tuple[str, str]:
    """The words in one row of so many columns, which may be cut there, and what stands beside them. Before an end is
    cut or how many requests wait is left out, how far what runs has come leaves. How many wait has its room also before
    more than half of the row has what runs, and before what is asked and how others ended: nothing else shows that a
    request was taken."""
    waiting = _waiting(view)
    if view.standstill and cell_len(words) > room:  # the sign says that the emergency stop is pressed
        ended = _ended(view.ends) if view.ends else ""
        now = _now(view, progress=False) or (None if ended else _said_last(view))
        brief = JOINT.join(filter(None, (now[0] if now else "", view.release, view.remark, ended)))
        return brief, _beside(view, min(cell_len(brief), room // 2), room, where=False)
    if cell_len(JOINT.join(filter(None, (words, waiting)))) <= room:
        return words, _beside(view, cell_len(words), room)
    if not (view.ends or waiting):
        return words, ""
    brief = happening(view, progress=False)[0]
    if view.ends and view.model.running is not None and _urgent(view) is None:
        named = brief.partition(_ended(view.ends))[0] + _names(view.ends)
        if cell_len(JOINT.join(filter(None, (named, waiting)))) > room:  # it goes in some seconds, and what runs stays
            brief = happening(view, progress=False, ends_first=True)[0]
    least = cell_len(brief)
    if waiting and _urgent(view) is None:
        beside = room - cell_len(JOINT) - cell_len(waiting)
        least = min(least, room // 2 if view.model.running is not None and not view.ends else beside)
    return brief, _beside(view, least, room, where=False)


def _beside(view: View, taken: int, room: int, *, where: bool = True) -> str:
    """How many requests wait, and ``where`` the robot is, as far as there is room beside so many columns."""
    parts = [part for part in (_waiting(view), _where(view) if where else "") if part]
    between = cell_len(JOINT) if taken else 0
    while parts and cell_len(JOINT.join(parts)) + between + taken > room:
        parts.pop()
    return JOINT.join(parts)


def _urgent(view: View) -> Piece | None:
    """A notice, trouble of which no end tells, or what is heard: the most urgent of them."""
    model = view.model
    if view.notice and not view.standstill:
        return view.notice, "bold $text-warning"
    if model.problem is not None and view.is_true(model.problem):
        trouble = told(model.problem.message)
        if not any(told(end.message).startswith(trouble) for end in view.ends):
            return f"✗ {trouble}", "$text-error"
    if model.partial:
        return f"“{model.partial}…”", "$text-accent"
    return None


def _now(view: View, *, progress: bool) -> Piece | None:
    """What is done, asked or said now: the most urgent of them."""
    model = view.model
    if (row := model.running) is not None:
        come = told(row.message) if progress else ""
        return JOINT.join(filter(None, (f"▸ {told(row.call)}", come))), "$text-success"
    if model.plan is not None and model.plan.stage == "thinking":
        return f"{strings.YOU}: {model.plan.goal}", "$foreground"
    if model.plan is not None and model.asking and model.plan.message:
        return f"{strings.ROBOT}: {model.plan.message}", "$foreground"
    speaks = model.state not in REST and model.conversation and model.conversation[-1].who == "robot"
    return _said_last(view) if speaks else None


def _said_last(view: View) -> Piece | None:
    """The last of the conversation that is true; that the emergency stop was pressed is told by itself."""
    last = view.model.conversation[-1] if view.model.conversation else None
    if last is not None and view.is_true(last) and not (view.standstill and last.note == "estop"):
        kind, text, note = as_told(last)
        who = STYLES[kind][0] or {"you": f"{strings.YOU}:", "robot": f"{strings.ROBOT}:"}[kind]
        return f"{who} {text}" + (f"  {note}" if note and kind != "you" else ""), "$foreground"
    return None


def _ended(ends: Sequence[Ended]) -> str:
    """How these ended, all in the same way: how many and which first, as the end is cut where there is no room."""
    names = _names(ends)
    return f"{names}{strings.COLON}{told(ends[0].message)}" if ends[0].message else f"{names}  {ends[0].note}"


def _names(ends: Sequence[Ended]) -> str:
    count = f"({len(ends)}) " if len(ends) > 1 else ""
    mark = "✓" if ends[0].done else STYLES["lost"][0]
    return f"{mark} {count}{strings.COMMA.join(end.text for end in ends)}"


def _wrapped(words: str, first: int, columns: int, below: int) -> list[str]:
    """The words in rows: one of ``first`` columns, and so many ``below`` it at most, the last of which has the rest."""
    head = Content(words).wrap(first)[0].plain.rstrip()
    rest = words[len(head) :].strip()
    lines = [line.plain.rstrip() for line in Content(rest).wrap(max(1, columns))] if rest else []
    return [head, *lines[: below - 1], " ".join(lines[below - 1 :])]


def _waiting(view: View) -> str:
    count = len(view.model.waiting)
    return strings.REQUESTS_WAIT.format(count) if count else ""


def _where(view: View) -> str:
    if view.robot is None:
        return ""
    pose = view.robot.pose
    if not all(map(math.isfinite, (pose.x, pose.y, pose.yaw))):
        return ""
    x, y = (round(value, 1) + 0.0 for value in (pose.x, pose.y))  # without the minus of −0
    return f"{x:.1f} {y:.1f} m {round(math.degrees(pose.yaw)) % 360}°"
