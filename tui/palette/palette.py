"""The palette: a line to type in, and below it what fits, the best first."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.content import Content
from textual.message import Message
from textual.widgets import Input, OptionList
from textual.widgets.option_list import Option

from tui.palette.entries import Choice, Entry, Write, found, nearest
from tui.palette.over import Over
from tui.widgets.text_line import TextLine
from tui.words import strings
from tui.words.hints import Acting


class PaletteLine(TextLine):
    """What is looked for."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("up", "choose(-1)", show=False),
        Binding("down,tab", "choose(1)", show=False),
        Binding("shift+tab", "choose(-1)", show=False),
    ]

    class Moved(Message):
        """Another entry is meant, so many lines further down."""

        def __init__(self, step: int) -> None:
            super().__init__()
            self.step = step

    def __init__(self, finds: Callable[[], bool]) -> None:
        """``finds``: an entry is meant, which enter chooses."""
        super().__init__(placeholder=strings.PALETTE_PROMPT, max_length=200)
        self._finds = finds

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "submit":
            return self._finds() or None
        return super().check_action(action, parameters)

    def action_choose(self, step: int) -> None:
        self.post_message(self.Moved(step))


class Palette(Over):
    """Tells which entry was chosen; does nothing itself."""

    DEFAULT_CSS = """
    Palette {
        PaletteLine { border: none; padding: 0; height: 1; background: $surface; }
        OptionList {
            height: auto;
            max-height: 100%;
            border: none;
            padding: 0;
            margin: 1 0 0 0;
            background: $surface;
            scrollbar-size-vertical: 1;
            & > .option-list--option-highlighted { background: $primary 40%; text-style: bold; }
        }
    }
    """

    class Chosen(Message):
        """Somebody wants this."""

        def __init__(self, choice: Choice) -> None:
            super().__init__()
            self.choice = choice

    def __init__(self, entries: Sequence[Entry], acting: Acting, *, title: str, guesses: bool = True) -> None:
        """``acting`` says which keys act now; ``guesses``: where nothing fits, what comes near is shown."""
        super().__init__(acting)
        self._entries = tuple(entries)
        self._guesses = guesses
        self._line = PaletteLine(lambda: self._meant is not None)
        self._list = OptionList(markup=False)
        self._list.can_focus = False
        self.border_title = title
        self.shown: tuple[Entry, ...] = ()
        """What fits, or comes near it, as it stands below the line."""
        self._fits = True  # else it only comes near
        self._width = 0  # for which it was drawn, columns

    def compose(self) -> ComposeResult:
        yield self._line
        yield self._list

    def on_mount(self) -> None:
        self._look()

    def begin(self) -> None:
        """Put the focus where one types, before the next key is dealt out."""
        self.screen.set_focus(self._line)

    def place(self) -> None:
        super().place()
        self._look()

    def on_input_changed(self, event: Input.Changed) -> None:
        event.stop()
        self._look()

    def on_palette_line_moved(self, event: PaletteLine.Moved) -> None:
        event.stop()
        if self.shown:
            here = self._list.highlighted
            at = self._above if here is None else here + event.step
            self._list.highlighted = max(self._above, min(self._list.option_count - 1, at))

    def on_input_submitted(self, event: Input.Submitted) -> None:
        event.stop()
        self._choose(self._list.highlighted)

    def on_option_list_option_highlighted(self, event: OptionList.OptionHighlighted) -> None:
        """Say what enter does with it."""
        event.stop()
        self.hint()

    @property
    def hints(self) -> str:
        fills = self._meant is not None and isinstance(self._meant.choice, Write)
        return strings.PALETTE_KEYS_FILL if fills else strings.PALETTE_KEYS

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """By the mouse: the keyboard is with the line."""
        event.stop()
        self._choose(event.option_index)

    def _choose(self, number: int | None) -> None:
        if (entry := self._entry(number)) is not None:
            self.post_message(self.Chosen(entry.choice))

    def _entry(self, number: int | None) -> Entry | None:
        """The entry on a line of the list."""
        at = -1 if number is None else number - self._above
        return self.shown[at] if 0 <= at < len(self.shown) else None

    @property
    def _meant(self) -> Entry | None:
        """The entry that enter chooses."""
        self._look()  # all that was typed counts, also what has not been looked for yet
        return self._entry(self._list.highlighted)

    @property
    def _above(self) -> int:
        """Lines that stand above the first entry."""
        return 0 if self._fits else 1

    def _look(self) -> None:
        """Show what fits what is typed."""
        shown = found(self._entries, self._line.value)
        fits = bool(shown)
        if not fits and self._guesses:
            shown = nearest(self._entries, self._line.value)
        width = self.columns - 5  # border, padding, scroll bar
        if (shown, width) == (self.shown, self._width) and self._list.option_count:
            return
        at = self._list.highlighted if shown == self.shown else None
        self.shown, self._width, self._fits = shown, width, fits
        self._list.clear_options()
        if not fits:
            words = strings.NEAREST if len(shown) > 1 else strings.NOTHING_FITS
            self._list.add_option(Option(Content.styled(words, "$text-muted"), disabled=True))
        self._list.add_options([Option(_drawn(entry, width)) for entry in shown])
        self._list.highlighted = at if at is not None or not fits else 0  # what only comes near is chosen by hand


def _drawn(entry: Entry, width: int) -> Content:
    """The entry on one line, with its key or its kind at the right."""
    beside = Content(entry.beside).truncate(width // 3, ellipsis=True)
    title = Content(entry.title).truncate(width - beside.cell_length - 2, ellipsis=True, pad=True)
    style = "bold $text-accent" if entry.kind == "action" else "$foreground 60%"
    return Content.assemble(title, "  ", Content.styled(beside.plain, style))
