"""What was said, by whom, and what came of it."""

from __future__ import annotations

from typing import Final

from textual.content import Content

from tui import strings
from tui.facts import Line
from tui.model import ConsoleModel
from tui.widgets.lines import Drawn, Lines

_GUTTER: Final = 7
_STYLES: Final = {
    "you": (f"{strings.YOU:>5}  ", "$text-primary", "$foreground"),
    "robot": (f"{strings.ROBOT:>5}  ", "$text-success", "$foreground"),
    "unheard": ("    ∅  ", "$foreground 60%", "italic $foreground 60%"),
    "mark": ("    ■  ", "$text-warning", "$foreground 60%"),
    "done": ("    ✓  ", "$text-success", "$foreground 60%"),
    "problem": ("    ✗  ", "$text-error", "$foreground"),
    "partial": (f"{strings.YOU:>5}  ", "$text-primary", "italic $foreground 60%"),
    "hint": (" " * _GUTTER, "", "$foreground 60%"),
    "welcome": ("    ○  ", "$text-primary", "$foreground"),
}


class Conversation(Lines[tuple[str, str, str]]):
    """The transcript, oldest first; words still being heard stand last, in italics."""

    def update_from(self, model: ConsoleModel, welcome: str) -> None:
        """Show the model's conversation, or ``welcome``, which says how to begin one."""
        items = [_item(line) for line in model.conversation]
        if model.partial:
            items.append(("partial", model.partial + " …", ""))
        if not items:
            items = [("welcome", welcome, ""), ("hint", "", "")]
            items += [
                ("hint", f"{strings.TRY if not number else ' ' * len(strings.TRY)}  {example}", "")
                for number, example in enumerate(strings.EXAMPLES)
            ]
        self.show(items, matters=None if model.conversation or model.partial else 0)

    def drawn(self, item: tuple[str, str, str]) -> Drawn:
        kind, text, note = item
        gutter, sign_style, text_style = _STYLES[kind]
        body = Content.styled(text, text_style)
        if note:
            body = Content.assemble(body, (f"  {note}", "$foreground 40%"))
        return Drawn(Content.styled(gutter, sign_style), body)


def _item(line: Line) -> tuple[str, str, str]:
    return line.who, line.text, line.note
