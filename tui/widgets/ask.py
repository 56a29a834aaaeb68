"""The line to type in, with the memory of a shell and a guess at what comes next."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import ClassVar, Final

from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal
from textual.message import Message
from textual.suggester import Suggester
from textual.widgets import Input, Static

from tui.widgets.completion import Completion
from tui.widgets.text_line import Commands, TextLine
from tui.words import strings
from tui.words.hints import Acting, hint_line, sentence

_MAX_HISTORY = 200
_MAX_LENGTH: Final = 20_000
"""Characters of the line: ten of the longest requests."""
_BREAK: Final = "⏎"
"""Stands between requests that were pasted on lines of their own."""


def requests_of(written: str) -> tuple[str, ...]:
    """What is asked for by what stands in the line: one request, or several that were pasted."""
    return tuple(part for part in map(str.strip, written.split(_BREAK)) if part)


def _as_one(lines: Sequence[str]) -> str:
    """Lines as they stand in the line, each a request of its own."""
    return f" {_BREAK} ".join(filter(None, map(str.strip, lines)))


class Ask(TextLine):
    """Sends what was typed; up and down recall it, right and tab take what is suggested. In the empty line a key that
    no request begins with does what it does outside. Of what is pasted, each line is a request of its own."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("up", "recall(-1)", show=False, id="earlier"),
        Binding("down", "recall(1)", show=False),
        Binding("tab", "complete(1)", show=False),
        Binding("shift+tab", "complete(-1)", show=False),
        Binding("end", "newest", show=False),
    ]

    class Asked(Message):
        """The user typed a request, or pasted several: ``text`` is what stood in the line."""

        def __init__(self, text: str, *, waits: bool, here: bool) -> None:
            """``waits``: it is done after all that was asked for before; ``here``: it stood in the line."""
            super().__init__()
            self.text = text
            self.requests = requests_of(text)
            self.waits = waits
            self.here = here

    def __init__(self, acting: Acting, commands: Commands) -> None:
        """``acting`` says which keys act now; ``commands`` as in ``TextLine``."""
        super().__init__(
            commands=commands,
            select_on_focus=False,  # a draft that one comes back to is not typed over
            max_length=_MAX_LENGTH,
            suggester=Guess(lambda text: self._completion.rest(text, self.offered)),
        )
        self.ended = False
        """The session is over: nothing is sent any more."""
        self._acting = acting
        self._early = ""  # what has to be loaded before a request is begun
        self._failed = False  # the engine did not start: nothing that is typed is ever done
        self._history: list[str] = []
        self._in_vain: set[str] = set()  # of these, those of which nothing was made
        self._at = 0  # place in the history; its length stands for the line being written
        self._draft = ""
        self._completion = Completion(phrases=strings.PHRASES)

    @property
    def history(self) -> Sequence[str]:
        """What was sent, the newest last."""
        return self._history

    @property
    def offered(self) -> Sequence[str]:
        """What was sent and may be meant again, the newest last: nothing that was refused or not understood, and not
        several that were pasted."""
        return [text for text in self._history if text not in self._in_vain and _BREAK not in text]

    def mark(self, text: str) -> bool:
        """Nothing was made of this: it is not offered again. False where it is not among what was sent."""
        if text not in self._history:
            return False
        self._in_vain.add(text)
        return True

    def remember(self, earlier: Sequence[str], in_vain: Iterable[str] = ()) -> None:
        """Put what was sent in earlier sessions before what was in this one; of what was sent ``in_vain``, nothing was
        made."""
        self._in_vain.update(text for text in in_vain if text not in self._history)
        self._history = [*earlier, *self._history][-_MAX_HISTORY:]
        self._at = len(self._history)

    def know(self, names: Sequence[str]) -> None:
        """Complete these names from now on."""
        self._completion = Completion(tuple(names), strings.PHRASES)

    def reword(self) -> None:
        """Words are in another language now."""
        self._completion = Completion(self._completion.names, strings.PHRASES)
        self.prompt()

    def wait_for(self, parts: str, *, failed: bool = False) -> None:
        """A request waits until these have been loaded, for people; empty: for nothing. ``failed``: it waits in vain,
        as the engine did not start."""
        if (parts, failed) != (self._early, self._failed):
            self._early, self._failed = parts, failed
            self.prompt()

    def prompt(self) -> None:
        """Say in the empty line what it is for, and which keys act; elsewhere, which key leads to it."""
        if self._failed:
            self.placeholder = hint_line(strings.PLACEHOLDER_FAILED, self._acting, max(1, self.size.width - 1))
            return
        if self.app.focused is self:
            words = strings.PLACEHOLDER_TYPING_EARLY if self._early else strings.PLACEHOLDER_TYPING
            self.placeholder = hint_line(words, self._acting, max(1, self.size.width - 1), last=2, parts=self._early)
            return
        words = strings.PLACEHOLDER_EARLY if self._early else strings.PLACEHOLDER
        self.placeholder = sentence(words, self._acting, parts=self._early)

    def on_resize(self) -> None:
        self.prompt()

    def write(self, text: str) -> None:
        """Put a request into the line, for somebody to send."""
        self._at = len(self._history)
        self.value = text
        self.cursor_position = len(text)

    def _on_paste(self, event: events.Paste) -> None:
        """In place of Textual's, which takes the first line only."""
        event.stop()
        event.prevent_default()
        self.paste(event.text)

    def paste(self, text: str) -> None:
        """Put it where the cursor is, each line as a request of its own."""
        pasted = _as_one(text.splitlines())
        before = self.value
        self.replace(pasted, *self.selection)
        if pasted and self.value == before:
            self._tell_too_long()

    def _tell_too_long(self) -> None:
        self.app.notify(strings.PASTED_TOO_LONG.format(_MAX_LENGTH), severity="warning", markup=False)

    def take(self, text: str) -> None:
        """Whole lines that came at once are sent as one, the first together with what stands here; what is behind the
        last of them is written."""
        *whole, rest = text.split("\n")
        at = self.cursor_position
        written = _as_one((f"{self.value[:at]}{whole[0]}{self.value[at:]}", *whole[1:]))
        if len(written) > _MAX_LENGTH:
            self._tell_too_long()
            return
        self.value = ""
        self.send(written, here=True)
        self.insert_text_at_cursor(rest)

    @property
    def sends(self) -> bool:
        """There is something to send, and somebody to send it to."""
        return not self.ended and bool(requests_of(self.value))

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """In the empty line, the keys of the text are the console's: they go to the panes, or to the newest line."""
        match action, parameters:
            case "submit", _:
                return self.sends or None
            case "recall", (int(step),):
                return 0 <= self._at + step <= len(self._history) or None
            case (("complete" | "newest"), _):
                return bool(self.value)
        return super().check_action(action, parameters)

    def action_complete(self, step: int) -> None:
        """Take what is suggested."""
        if self.cursor_at_end and self._suggestion:
            self.action_cursor_right()

    def action_newest(self) -> None:
        """To the end of the text."""
        self.action_end()

    async def action_submit(self) -> None:
        self.submit()

    def submit(self, *, waits: bool = False) -> None:
        """Ask for what stands here; ``waits``: to be done after all that was asked for before."""
        self.value, text = "", self.value
        self.send(text, waits=waits, here=True)

    def send(self, text: str, *, waits: bool = False, here: bool = False) -> None:
        """Ask for what was written, ``here`` or elsewhere; it is remembered."""
        text = text.strip()
        if not requests_of(text):
            return
        self._in_vain.discard(text)
        if not self._history or self._history[-1] != text:
            self._history = [*self._history[1 - _MAX_HISTORY :], text]
        self._at, self._draft = len(self._history), ""
        self.app.post_message(self.Asked(text, waits=waits, here=here))  # before the keys behind it

    def action_recall(self, step: int) -> None:
        """Go back (−1) or forth (1) in what was sent; what was being written is kept."""
        if self._at == len(self._history):
            self._draft = self.value
        self._at = max(0, min(len(self._history), self._at + step))
        self.value = self._draft if self._at == len(self._history) else self._history[self._at]
        self.cursor_position = len(self.value)


class Guess(Suggester):
    """Suggests how a line goes on, written behind it in grey."""

    def __init__(self, rest: Callable[[str], str]) -> None:
        super().__init__(use_cache=False, case_sensitive=True)
        self._rest = rest

    async def get_suggestion(self, value: str) -> str | None:
        rest = self._rest(value)
        return value + rest if rest else None


_PROMPT: Final = " › "
_ROOM_FOR_KEY: Final = 50
"""Columns below which the line has all the room."""


class AskLine(Horizontal):
    """The prompt sign, the line, and while something runs and the line has text the key that adds it to what waits."""

    def __init__(self, acting: Acting, commands: Commands) -> None:
        super().__init__()
        self._acting = acting
        self._ask = Ask(acting, commands)
        self._adds = Static(id="adds", markup=False)
        self._prompt = Static(_PROMPT, id="prompt", markup=False)
        self._adds.display = self._busy = False

    def compose(self) -> ComposeResult:
        yield self._prompt
        yield self._ask
        yield self._adds

    def tell(self, *, busy: bool, ended: bool) -> None:
        """Whether something runs or waits, and whether the session is over."""
        self._busy, self._ask.ended = busy, ended

    def on_resize(self) -> None:
        self.offer()

    def offer(self) -> None:
        """Name the key that adds what is written to what waits, where that makes a difference."""
        words = hint_line(strings.ADDS, self._acting) if self._busy and self.size.width >= _ROOM_FOR_KEY else ""
        if words and str(self._adds.content) != f" {words} ":
            self._adds.update(f" {words} ")
        self._adds.display = bool(words)

    def on_input_changed(self, event: Input.Changed) -> None:
        """Say before the line how many requests it holds, where they are several."""
        number = len(requests_of(event.value))
        self._prompt.update(f"{min(number, 99):>2}›" if number > 1 else _PROMPT)
        self.offer()

    @property
    def line(self) -> Ask:
        """What one types in."""
        return self._ask

    def begin(self) -> None:
        """Put the focus where one types."""
        # At once, where focus() would wait for its turn: keys that were typed ahead must not be taken for commands.
        self.screen.set_focus(self._ask)
