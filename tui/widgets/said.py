"""What was said last, where the conversation is out of sight: an open question, or else its newest line."""

from __future__ import annotations

from textual.content import Content
from textual.geometry import Size
from textual.widgets import Static

from tui.shown.facts import Line
from tui.shown.model import ConsoleModel
from tui.widgets.conversation import STYLES, as_told
from tui.words import strings


class Said(Static):
    """Above the microphone; it has no row while there is nothing to say, and a quarter of the screen at most."""

    def __init__(self) -> None:
        super().__init__(id="said", markup=False)
        self._covered = False  # the conversation is
        self._words = self._shown = Content("")

    def cover(self, covered: bool) -> None:
        """Whether another pane stands in the place of the conversation."""
        self._covered = covered
        self.set_class(covered and bool(self._words), "-shown")

    def update_from(self, model: ConsoleModel) -> None:
        """Show the model's newest line."""
        line = model.conversation[-1] if model.conversation else None
        if model.asks and model.plan is not None and model.plan.message:
            line = Line("robot", model.plan.message)
        words = _drawn(line) if line is not None else Content("")
        if not words.is_same(self._words):
            self._words = words
            self._write()
        self.cover(self._covered)

    def on_resize(self) -> None:
        self._write()

    def _write(self) -> None:
        """As much as there is room for; what is cut off ends with an ellipsis."""
        shown = as_fits(self._words, self.screen.size)
        if not shown.is_same(self._shown):
            self._shown = shown
            self.update(shown)


def as_fits(words: Content, screen: Size) -> Content:
    """The words on a quarter of the rows of a screen at most."""
    rows, columns = max(1, screen.height // 4), max(2, screen.width)
    lines = words.wrap(columns)
    if len(lines) <= rows:
        return words
    last = lines[rows - 1].rstrip().truncate(columns - 1)
    return Content("\n").join([*lines[: rows - 1], Content.assemble(last, "…")])


def _drawn(line: Line) -> Content:
    kind, text, note = as_told(line)
    sign, sign_style, text_style = STYLES[kind]
    who = sign or (strings.ROBOT if kind == "robot" else strings.YOU)
    words = Content.assemble((f" {who}  ", sign_style), (text, text_style))
    return Content.assemble(words, (f"  {note}", "$foreground 60%")) if note else words
