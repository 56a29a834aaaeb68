"""The log: what the engine's parts say about themselves. It follows the newest line until somebody scrolls back, shows
one level or part of it on demand, and leads from a line to the turn in which it was told."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Final, Literal, NamedTuple

from textual import events
from textual.binding import BindingType
from textual.content import Content
from textual.message import Message

from tui.keys.bindings import LOG_BINDINGS
from tui.shown.facts import LogLine
from tui.shown.model import ConsoleModel
from tui.widgets.growing import Growing, mark
from tui.widgets.lines import Drawn
from tui.words import strings
from tui.words.hints import JOINT, Acting, hint_line
from tui.words.language import told

Level = Literal["debug", "info", "warning", "error"]
LEVELS: Final[tuple[Level, ...]] = ("debug", "info", "warning", "error")
"""From the least to the most serious."""
_SIGNS: Final = {
    "debug": ("·", "$foreground 40%"),
    "info": ("·", "$foreground 60%"),
    "warning": ("▲", "$text-warning"),
    "error": ("✗", "$text-error"),
}
_SERIOUS: Final = ("warning", "error")


class Shown(NamedTuple):
    """A line as it stands in the pane."""

    line: LogLine
    marked: bool


class LogView(Growing[Shown | str]):
    """Log lines, oldest first."""

    BINDINGS: ClassVar[list[BindingType]] = LOG_BINDINGS

    class Opened(Message):
        """Somebody wants to see the turn of this line."""

        def __init__(self, turn: str | None) -> None:
            super().__init__()
            self.turn = turn

    class Wanted(Message):
        """Somebody wants to search the log."""

    def __init__(self, acting: Acting, *, classes: str | None = None) -> None:
        """``acting`` says which keys act now."""
        super().__init__(classes=classes)
        self._acting = acting
        self.known: tuple[LogLine, ...] = ()
        """All lines that there are, whatever is shown of them."""
        self._least: Level = "debug"
        self._part: str | None = None
        self._marked: LogLine | None = None
        self._turns: frozenset[str] = frozenset()  # the ids of those that are kept

    def update_from(self, model: ConsoleModel) -> None:
        self.count(self.known, model.log, self._fits)
        self.known = model.log
        self._turns = frozenset(turn.id for turn in model.turns.kept)
        self._look()

    def drawn(self, item: Shown | str) -> Drawn:
        if isinstance(item, str):
            return Drawn(Content(""), Content.styled(item, "$foreground 60%"))
        line, marked = item
        sign, style = _SIGNS[line.level]
        gutter = Content.assemble((f"{line.t:8.2f} ", "$foreground 60%"), (f"{sign} ", style))
        source = strings.SOURCES.get(line.source, line.source)
        words = "bold $text-accent" if marked else "$foreground 80%"
        return Drawn(gutter, Content.assemble((f"{source} ", "$foreground 60%"), (told(line.message), words)))

    @property
    def lines(self) -> Sequence[LogLine]:
        """Those that are shown."""
        return [item.line for item in self.items if isinstance(item, Shown)]

    def go_to(self, line: LogLine) -> None:
        """Mark a line and show it, whatever was left out before."""
        if not self._fits(line):
            self._least, self._part = "debug", None
        self._mark(line)

    def entitle(self) -> None:
        """Below the pane: how many lines are new, what is left out, and the keys while it has the keyboard."""
        fresh = mark(strings.NEW_LINES.format(self._fresh), "log") if self._fresh else Content("")
        parts = [strings.LOG_LEVELS[self._least]] if self._least != "debug" else []
        parts += ["{part}"] if self._part is not None else []
        if self.is_attached and self.screen.focused is self:  # has_focus is not true yet when the keyboard comes
            parts += [strings.LOG_ALL, strings.LOG_KEYS]
        room = max(1, self.size.width - 2 - (fresh.cell_length + len(JOINT) if fresh else 0))
        part = strings.SOURCES.get(self._part or "", self._part)
        words = Content(hint_line(JOINT.join(parts), self._acting, room, last=0, part=part))
        whole = Content(JOINT).join([part for part in (fresh, words) if part])
        self.write_foot(whole)

    # Actions

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Whether it would lead to anything else than what is shown."""
        match action, parameters:
            case (("log_level" | "log_part" | "log_find"), _):
                return bool(self.known) or None
            case "log_all", _:
                return self._least != "debug" or self._part is not None or None
            case "log_trouble", (int(step),):
                return self._trouble(step) is not None or None
            case "log_turn", _:
                return self._turn in self._turns or None
            case "log_follow", _:
                return self._held or self._marked is not None or None
        return super().check_action(action, parameters)

    def action_log_level(self) -> None:
        """From which level on lines are shown: the next more serious one."""
        self._least = LEVELS[(LEVELS.index(self._least) + 1) % len(LEVELS)]
        self._look()

    def action_log_part(self) -> None:
        """Which part's lines are shown: those of the next one that has any; after the last one all."""
        parts = list(dict.fromkeys(line.source for line in self.known))
        at = parts.index(self._part) + 1 if self._part in parts else 0
        self._part = parts[at] if at < len(parts) else None
        self._look()

    def action_log_all(self) -> None:
        """Whatever was left out is shown again."""
        self._least, self._part = "debug", None
        self._look()

    def action_log_find(self) -> None:
        self.post_message(self.Wanted())

    def action_log_trouble(self, step: int) -> None:
        """To the next warning or error, or the one before; from the newest one backwards where none is marked."""
        if (found := self._trouble(step)) is not None:
            self._mark(found)

    def _trouble(self, step: int) -> LogLine | None:
        lines = self.lines
        at = _index(self._marked, lines, len(lines) if step < 0 else -1)
        ahead = lines[at + 1 :] if step > 0 else lines[:at][::-1]
        return next((line for line in ahead if line.level in _SERIOUS), None)

    def action_log_follow(self) -> None:
        """Show the newest line, and each that comes."""
        self._marked = None
        self._look()
        self.follow()

    def action_log_turn(self) -> None:
        """The turn of the marked line, or of the newest warning or error that is shown."""
        self.post_message(self.Opened(self._turn))

    @property
    def _turn(self) -> str | None:
        newest = next((line for line in reversed(self.lines) if line.level in _SERIOUS and line.turn), None)
        line = self._marked or newest
        return line.turn if line is not None else None

    # Mouse and keyboard

    def on_click(self, event: events.Click) -> None:
        """A line is marked; once more: its turn."""
        at = self.clicked(event)
        item = self.items[at] if at is not None else ""
        if isinstance(item, str):
            return
        if item.marked:
            self.action_log_turn()
        else:
            self._mark(item.line, scroll=False)

    def on_resize(self, event: events.Resize) -> None:
        super().on_resize(event)
        self.entitle()

    # What is shown

    def _fits(self, line: LogLine) -> bool:
        least = LEVELS.index(self._least)
        return LEVELS.index(line.level) >= least and self._part in (None, line.source)

    def _look(self) -> None:
        shown = [Shown(line, line is self._marked) for line in self.known if self._fits(line)]
        self.show(shown or ([hint_line(strings.LOG_NOTHING_FITS, self._acting)] if self.known else []))
        self.entitle()

    def _mark(self, line: LogLine, *, scroll: bool = True) -> None:
        self._marked = line
        self._look()
        if scroll:
            self._show_line(next(number for number, item in enumerate(self.items) if item == Shown(line, True)))
            self.entitle()


def _index(line: LogLine | None, lines: Sequence[LogLine], otherwise: int) -> int:
    return next((number for number, one in enumerate(lines) if one is line), otherwise)
