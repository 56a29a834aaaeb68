"""What was said, by whom, and what came of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from rich.cells import cell_len
from textual.content import Content
from textual.message import Message

from tui.shown.facts import Line
from tui.shown.model import ConsoleModel
from tui.widgets.growing import Growing, mark
from tui.widgets.lines import Drawn
from tui.words import strings
from tui.words.language import told
from tui.words.widths import left, right

_GUTTER: Final = 7
_WAITING: Final = 3
"""Requests that wait and are shown; of the others, only how many they are."""
STYLES: Final = {
    "you": ("", "$text-primary", "$foreground"),
    "robot": ("", "$text-success", "$foreground"),
    "unheard": ("∅", "$foreground 60%", "italic $foreground 60%"),
    "lost": ("■", "$text-warning", "$foreground"),
    "mark": ("■", "$text-warning", "$foreground 60%"),
    "done": ("✓", "$text-success", "$foreground 60%"),
    "problem": ("✗", "$text-error", "$foreground"),
    "partial": ("", "$text-primary", "italic $foreground 60%"),
    "waits": ("○", "$foreground 60%", "$foreground 60%"),
    "hint": (" ", "", "$foreground 60%"),
    "welcome": ("○", "$text-primary", "$foreground"),
}
"""The sign of each kind of line, empty where a name stands there; the style of that, and of the words."""


class Conversation(Growing[tuple[str, str, str]]):
    """The transcript, oldest first; what waits for its turn and words still being heard stand last, in italics where
    they may still change."""

    class Covered(Message):
        """Another pane stands in its place, or none any more."""

        def __init__(self, covered: bool) -> None:
            super().__init__()
            self.covered = covered

    _said: Sequence[Line] = ()
    _newest = ""  # the key that leads to the newest line

    def on_show(self) -> None:
        self.post_message(self.Covered(False))

    def on_hide(self) -> None:
        self.post_message(self.Covered(True))

    def update_from(
        self, model: ConsoleModel, welcome: Sequence[str], examples: Sequence[str], newest: str = ""
    ) -> None:
        """Show the model's conversation, or the lines of ``welcome``, which say how to begin one, and ``examples``.
        ``newest`` is the key that leads to the newest line, where one does so now."""
        self.count(self._said, model.conversation)
        self._said, self._newest = model.conversation, newest
        self.entitle()
        items = [as_told(line) for line in model.conversation]
        items += [("waits", request.text, strings.WAITS) for request in model.waiting[:_WAITING]]
        if (more := len(model.waiting) - _WAITING) > 0:
            items.append(("waits", strings.MORE_WAIT.format(more), ""))
        if model.partial:
            from engine.asr.agreement import first_words  # expressions that nothing needs before the first picture

            certain = first_words(model.partial, model.stable) if model.stable else ""
            items.append(("partial", certain, f"{model.partial.removeprefix(certain)} …"))
        begun = model.partial or model.waiting or any(line.who != "mark" for line in model.conversation)
        if not begun:  # whatever else has happened, somebody may sit here for the first time
            items += [*(("welcome", line, "") for line in welcome), ("hint", "", "")]
            items += [
                ("hint", f"{strings.TRY if not number else ' ' * cell_len(strings.TRY)}  {example}", "")
                for number, example in enumerate(examples)
            ]
        self.show(items, matters=None if begun else len(model.conversation))

    def entitle(self) -> None:
        """Below the pane: how many lines are new."""
        words = strings.NEW_LINES.format(self._fresh) if self._fresh else ""
        self.write_foot(mark(words, "conversation", self._newest) if words else Content(""))

    def drawn(self, item: tuple[str, str, str]) -> Drawn:
        kind, text, note = item
        sign, sign_style, text_style = STYLES[kind]
        who = sign or (strings.ROBOT if kind == "robot" else strings.YOU)
        gutter = left(right(who, _GUTTER - 2), _GUTTER)
        if kind == "partial":
            return Drawn(
                Content.styled(gutter, sign_style), Content.assemble((text, "$foreground"), (note, text_style))
            )
        body = Content.styled(text, text_style)
        if note:
            body = Content.assemble(body, (f"  {note}", "$foreground 60%"))
        return Drawn(Content.styled(gutter, sign_style), body)


def as_told(line: Line) -> tuple[str, str, str]:
    """Who or what it comes from, its words, and the remark beside them, in the language of the console."""
    ours = line.who in ("done", "problem")
    return line.who, told(line.text) if ours else line.text, strings.REASONS.get(line.note, line.note)
