"""The settings on a page of their own: what each is, what it means, where it comes from, and what may stand there.

The page shows what it is told and asks for changes; reading, testing and writing is the business of
``tui.rooms.changing``.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, ClassVar, Final, Protocol

from rich.cells import cell_len
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.content import Content
from textual.screen import Screen
from textual.widgets import Input, Static

from tui.keys.bindings import SETTING_BINDINGS
from tui.options import Option, about, found, kept, origin_of, overridden, shown, written
from tui.shown.facts import printable
from tui.widgets.lines import Drawn, Lines
from tui.widgets.status import StatusLine
from tui.widgets.text_line import TextLine
from tui.words import strings
from tui.words.hints import EDGES, Acting, hint_line
from tui.words.links import marked_up
from tui.words.widths import left

if TYPE_CHECKING:
    from tui.messages import Settled
    from tui.shown.view import View

_NAME: Final = 30
_VALUE: Final = 26
_DIM: Final = "$foreground 60%"
Row = tuple[str, str, str, bool, bool]
"""Name, value, where it comes from, whether it is the one that is meant, whether the value is only tried."""


class Wardrobe(Protocol):
    """Where settings are read and kept."""

    def read(self) -> None:
        """Ask for the settings as they are; the page is told them."""
        ...

    def keep(self, option: Option, text: str) -> None:
        """Set one for good; the page is told what came of it."""
        ...

    def give_back(self, option: Option) -> None:
        """Set one to what sayso comes with; the page is told what came of it."""
        ...

    def try_on(self, theme: str | None) -> None:
        """Look like this for now; None: as the settings say."""
        ...


class OptionList(Lines[Row | str]):
    """One line a setting, under the heading of its group; a sign says which one is meant."""

    def drawn(self, item: Row | str) -> Drawn:
        if isinstance(item, str):
            return Drawn(Content(""), Content.styled(item, "bold $text-primary"), nowrap=True)
        name, value, origin, meant, tried = item
        style = "bold $text-accent" if meant else "$foreground"
        text = Content(f"‹ {value} ›" if tried else value).truncate(_VALUE, ellipsis=True)
        body = Content.assemble((f"{left(name, _NAME - 1)} ", style), (text.plain, style if meant else "$text-primary"))
        gutter = Content.styled("▸ " if meant else "  ", style)
        room = self.size.width - gutter.cell_length - body.cell_length - 2
        return Drawn(gutter, body, Content.styled(_end_of(origin, room), _DIM), nowrap=True)


def _end_of(text: str, columns: int) -> str:
    """As much of its end as there is room for: of a path, the file."""
    if cell_len(text) <= columns:
        return text
    while text and cell_len(text) >= columns:
        text = text[1:]
    return f"…{text}" if columns > 0 else ""


class SettingsScreen(Screen[None]):
    """Not modal, so that every key of the console works here too: above all the one that stops the robot."""

    CSS_PATH = "settings.tcss"
    AUTO_FOCUS = ""
    place: ClassVar[str] = "settings"
    BINDINGS: ClassVar[list[BindingType]] = SETTING_BINDINGS

    def __init__(self, acting: Acting, wardrobe: Wardrobe, view: View, at: str = "") -> None:
        """``acting`` says which keys act now; ``at`` is the setting, by its dotted name, that is meant to begin
        with."""
        super().__init__()
        self._acting = acting
        self._titles = ("", "")
        self._wardrobe = wardrobe
        self._view = view
        self._status = StatusLine()
        self._list = OptionList(classes="pane", id="options")
        self._about = Static(id="about", markup=False)
        self._line = TextLine(id="line", max_length=500)
        self._every: tuple[Option, ...] = ()
        self._options: tuple[Option, ...] = ()  # of these, the ones that are shown
        self._finding = False  # the line is where one searches
        self._typed = ""  # what is searched for
        self._begin_at = at
        self._at = 0
        self._tried: str | None = None  # a value that is looked at, but not taken
        self._told: Content = Content("")  # what came of the last change

    def compose(self) -> ComposeResult:
        yield self._status
        yield self._list
        yield self._line
        yield self._about

    def on_mount(self) -> None:
        self._line.display = False
        self._told = Content.styled(strings.SETTINGS_READING, _DIM)
        self._draw()
        self.show(self._view)
        self._wardrobe.read()

    def on_unmount(self) -> None:
        self._wardrobe.try_on(None)

    def show(self, view: View) -> None:
        """Bring the status line up to date."""
        self._view = view
        if self._status.is_attached:
            self._status.update_from(view)
            self._hint()

    def settled(self, message: Settled) -> None:
        """Settings were read, or one of them was set, or could not be."""
        if message.failed:  # what was written stays there, to be mended
            self._told = Content.styled(f"✗ {message.failed}", "$text-error")
        else:
            if self.meant is not None and self.meant.key == message.key and not self._finding:
                self._close_line()
            first, meant = not self._every, self.meant
            self._every = message.options
            self._options = found(self._every, self._typed)
            at = self._begin_at if first else meant.key if meant is not None else ""
            self._at = next((n for n, option in enumerate(self._options) if option.key == at), 0)
            self._told = Content.assemble(*self._outcome(message))
        self._tried = None
        self._draw()

    def on_resize(self) -> None:
        self._draw()

    def reword(self) -> None:
        """Words are in another language now."""
        self._list.redraw()
        self._draw()
        self.show(self._view)

    def scroll_page(self, direction: int) -> None:
        """As many settings further as there is room for."""
        self.action_step(direction * max(1, self._list.size.height - 2))

    def can_scroll(self, direction: int) -> bool:
        """There are more settings up (−1) or down (1)."""
        return 0 <= self._at + direction < len(self._options)

    def step_back(self) -> bool:
        """Out of the line, where something was being written."""
        writing = self._line.display
        self._close_line()
        self._draw()
        return writing

    @property
    def meant(self) -> Option | None:
        """The setting that keys act on."""
        return self._options[self._at] if self._at < len(self._options) else None

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Whether there is another setting, another value, or anything to keep."""
        option = self.meant
        match action, parameters:
            case "step", (int(step),):
                return self.can_scroll(step) or None
            case "turn", (int(step),):
                return (option is not None and self._beside(option, step) not in ("", self._tried)) or None
            case "take", _:
                return option is not None or None
            case "default", _:
                return (option is not None and bool(option.origin or self._tried)) or None
            case "find", _:
                return bool(self._every) or None
        return super().check_action(action, parameters)

    def action_step(self, step: int) -> None:
        """To another setting; what was only tried or half written is let go."""
        if not self._options:
            return
        self._close_line()
        self._try(None)
        self._at = max(0, min(len(self._options) - 1, self._at + step))
        self._told = Content("")
        self._draw()

    def action_turn(self, step: int) -> None:
        """Look at another value of those that there are."""
        if self.meant is not None and (there := self._beside(self.meant, step)):
            self._told = Content("")
            self._try(there)
            self._draw()

    def action_take(self) -> None:
        """Keep the value that is looked at; where none is, the next one, or what is written now."""
        option = self.meant
        if option is None:
            return
        if not option.choices:
            self._open_line(option)
        elif value := self._tried or self._beside(option, 1):
            self._wardrobe.keep(option, value)

    def action_default(self) -> None:
        """What sayso comes with."""
        if self.meant is not None:
            self._try(None)
            self._wardrobe.give_back(self.meant)

    def action_find(self) -> None:
        """Show those settings alone in which what is typed occurs."""
        self._try(None)
        self._told = Content("")
        self._finding, self._line.display, self._line.value = True, True, self._typed
        self.set_focus(self._line)
        self._draw()

    def on_input_changed(self, event: Input.Changed) -> None:
        event.stop()
        if not self._finding and self._told.plain:  # why it was refused is about what was written before
            self._told = Content("")
            self._draw()
        if self._finding and event.value != self._typed:
            meant = self.meant
            self._typed = event.value
            self._options = found(self._every, self._typed)
            self._at = next((n for n, option in enumerate(self._options) if option is meant), 0)
            self._draw()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        event.stop()
        if self._finding:
            self._close_line()
            self._draw()
            return
        if self.meant is not None:
            self._wardrobe.keep(self.meant, event.value)

    def _beside(self, option: Option, step: int) -> str:
        """The value so many further in the list."""
        here = self._tried or shown(option.value)
        at = option.choices.index(here) if here in option.choices else -1
        return option.choices[(at + step) % len(option.choices)] if option.choices else ""

    def _try(self, value: str | None) -> None:
        option = self.meant
        self._tried = value if option is None or value != shown(option.value) else None
        if option is not None and option.key == "console.theme":
            self._wardrobe.try_on(self._tried)

    def _open_line(self, option: Option) -> None:
        self._finding, self._told = False, Content("")
        self._line.value = written(option.value)
        self._line.display = True
        self.set_focus(self._line)
        self._draw()

    def _close_line(self) -> None:
        self._line.display = self._finding = False
        self.set_focus(None)

    def _draw(self) -> None:
        rows: list[Row | str] = []
        matters = 0
        for number, option in enumerate(self._options):
            if not number or option.group != self._options[number - 1].group:
                rows.append(strings.SETTING_GROUPS.get(option.group, option.group))
            matters = len(rows) if number == self._at else matters
            rows.append(self._row(number, option))
        if not rows and self._every:
            rows.append(strings.NOTHING_FITS)
        self._list.show(rows, matters=matters)
        self._about.update(Content("\n").join(self._explained()))
        self._hint()

    def _hint(self) -> None:
        """Write into the frame what is searched for, and the keys that act now."""
        title = f"{strings.NAME} · {strings.SETTINGS_TITLE}{f' · {self._typed}' if self._typed else ''}"
        hints = hint_line(strings.SETTINGS_KEYS, self._acting, max(1, self.size.width - EDGES), last=2)
        if (titles := (title, hints)) != self._titles:  # others repaint the frame
            self._titles = titles
            self._list.border_title, self._list.border_subtitle = map(Content, titles)

    def _row(self, number: int, option: Option) -> Row:
        meant = number == self._at
        tried = self._tried if meant else None
        value = strings.SETTING_VALUES.get(tried or shown(option.value), tried or shown(option.value))
        return option.name, value, origin_of(option), meant, tried is not None

    def _explained(self) -> Iterator[Content]:
        """What there is to know of the setting that is meant."""
        option = self.meant
        if option is not None:
            yield Content.assemble((f"{option.key}  ", "bold $text-primary"), (printable(about(option)), "$foreground"))
            words = ", ".join(strings.SETTING_VALUES.get(word, word) for word in option.choices)
            if words:
                yield Content.styled(words, _DIM)
            yield Content.styled(strings.SETTING_LIVE if option.live else strings.SETTING_RESTART, _DIM)
            if option.over:
                yield Content.styled(f"▲ {overridden(option)}", "$text-warning")
        if self._told.plain and not self._finding:
            yield self._told
        if self._line.display:
            words = strings.SETTINGS_FIND if self._finding else strings.SETTINGS_LINE
            yield Content.styled(hint_line(words, self._acting), _DIM)

    def _outcome(self, message: Settled) -> Iterator[Any]:
        if not message.key:
            return
        option = next(option for option in message.options if option.key == message.key)
        file = printable(message.file)
        yield Content.from_markup(marked_up(kept(option.name, file), file)).stylize_before("$text-success")
        if not option.live and not option.over:
            yield f" {strings.SETTING_RESTART}", "$text-warning"
