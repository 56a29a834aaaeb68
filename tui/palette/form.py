"""A form made from a skill's signature: one line an argument, and below them the request that comes of it.

The request goes into the input line, where somebody reads and sends it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal
from textual.content import Content
from textual.message import Message
from textual.widgets import Input, Static

from engine.skills.registry import Skill
from tui.palette.arguments import Blank, NotRight, nearest_choice, values
from tui.palette.calls import as_written
from tui.palette.entries import about_skill
from tui.palette.over import Over
from tui.shown.facts import printable
from tui.widgets.ask import Guess
from tui.widgets.completion import Completion
from tui.widgets.text_line import TextLine
from tui.words import strings
from tui.words.hints import Acting
from tui.words.language import told


class BlankLine(TextLine):
    """Where one argument is written."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("up,shift+tab", "leave(-1)", show=False),
        Binding("down", "leave(1)", show=False),
        Binding("tab", "complete", show=False),
    ]

    def __init__(
        self, blank: Blank, leave: Callable[[BlankLine, int], None], submit: Callable[[BlankLine], None]
    ) -> None:
        """Calls ``leave`` and ``submit`` at once, where messages would wait: enter may have been pressed again."""
        completion = Completion(phrases=blank.choices)
        super().__init__(
            placeholder=blank.usual,
            max_length=500,
            suggester=Guess(completion.rest) if blank.choices else None,
        )
        self.blank = blank
        self._leave = leave
        self._submit = submit

    async def action_submit(self) -> None:
        self._submit(self)

    def action_leave(self, step: int) -> None:
        self._leave(self, step)

    def action_complete(self) -> None:
        """Take what is suggested, or go on."""
        if self.cursor_at_end and self._suggestion:
            self.action_cursor_right()
        else:
            self.action_leave(1)


class Form(Over):
    """Tells the request that was composed; enter on the last line is the end of it."""

    DEFAULT_CSS = """
    Form {
        .about { height: auto; color: $text-muted; margin: 0 0 1 0; }
        Horizontal { height: 1; }
        .name { width: 18; color: $foreground; }
        .unit { width: 24; color: $text-muted; padding: 0 0 0 1; }
        BlankLine { width: 1fr; height: 1; border: none; padding: 0 1; background: $panel; }
        #choices { height: auto; max-height: 3; color: $text-muted; margin: 1 0 0 0; }
        #result { height: auto; margin: 1 0 0 0; }
    }
    """

    class Composed(Message):
        """This is what is to be asked for."""

        def __init__(self, text: str) -> None:
            super().__init__()
            self.text = text

    def __init__(self, skill: Skill, blanks: tuple[Blank, ...], acting: Acting) -> None:
        """``acting`` says which keys act now."""
        super().__init__(acting)
        self._skill = skill
        self._lines = tuple(BlankLine(blank, self._go, self._submitted) for blank in blanks)
        self._choices = Static(id="choices", markup=False)
        self._result = Static(id="result", markup=False)
        self.border_title = told(skill.name)

    def compose(self) -> ComposeResult:
        yield Static(about_skill(self._skill), classes="about", markup=False)
        for line in self._lines:
            blank = line.blank
            with Horizontal():
                yield Static(told(blank.name), classes="name", markup=False)
                yield line
                limits = blank.limits if blank.parameter.type == "number" else ""
                yield Static(f"{blank.unit:<6}{limits}".rstrip(), classes="unit", markup=False)
        yield self._choices
        yield self._result

    @property
    def hints(self) -> str:
        return strings.FORM_KEYS

    def begin(self) -> None:
        """Put the focus where one types, before the next key is dealt out."""
        self.screen.set_focus(self._lines[0])
        self._show()

    def on_descendant_focus(self) -> None:
        self._show()

    def on_input_changed(self, event: Input.Changed) -> None:
        event.stop()
        self._show()

    def _submitted(self, line: BlankLine) -> None:
        if line is not self._lines[-1]:
            self._go(line, 1)
            return
        try:
            text = self._composed()
        except NotRight:
            self._go_to_mistake()
            return
        self.post_message(self.Composed(text))

    def _go(self, line: BlankLine, step: int) -> None:
        at = self._lines.index(line) + step
        self.screen.set_focus(self._lines[at % len(self._lines)])

    def _go_to_mistake(self) -> None:
        for line in self._lines:
            try:
                values({line.blank: line.value})
            except NotRight:
                self.screen.set_focus(line)
                return

    def _composed(self) -> str:
        """The request. Raises :class:`NotRight` while there is none."""
        return as_written(self._skill, values({line.blank: line.value for line in self._lines}))

    def _show(self) -> None:
        """What may stand in the line that has the keyboard, and what the request is."""
        here = next((line for line in self._lines if line.has_focus), None)
        near = nearest_choice(here.blank, here.value) if here is not None else ""
        limits = here.blank.limits if here is not None and here.blank.choices else ""
        question = Content.styled(f"{strings.DID_YOU_MEAN.format(told(near))} ", "$text-warning") if near else ""
        self._choices.update(Content.assemble(question, limits))
        self._choices.display = here is not None and bool(here.blank.choices)
        try:
            text = self._composed()
        except NotRight as error:
            self._result.update(Content.styled(str(error), "$text-warning"))
            return
        self._result.update(Content.styled(strings.FORM_BECOMES.format(printable(text)), "bold"))
