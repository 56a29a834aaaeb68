"""What a person takes along: a part of the screen on the clipboard, the session and its picture in a folder.

What has become of it stands in the status line for a while.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Final, Literal

from textual.notifications import Notification, Notify

from engine import events as ev
from engine.errors import StorageError
from tui.messages import Told
from tui.screens.pages import Copied
from tui.shown.facts import printable
from tui.shown.view import View
from tui.widgets.status import has_room
from tui.words import strings
from tui.words.hints import Acting, hint_line
from tui.words.language import told

if TYPE_CHECKING:
    from textual.timer import Timer

    from tui.rooms.copying import Part
    from tui.stage import Stage

Holds = Callable[[View], bool]
"""Whether what is told is true, as things are."""
TOLD_S: Final = 6.0
"""How long the status line says what was copied or saved."""


def always(view: View) -> bool:
    """Of what has happened."""
    return True


def while_still(view: View) -> bool:
    """Of what is true unless something is under way."""
    return not view.model.busy


class Keeping:
    """Copies and saves, and says so. In the UI thread."""

    def __init__(self, stage: Stage) -> None:
        self.told = ""
        """What stands in the status line for a while."""
        self._holds: Holds = always
        self._has_held = False  # since it is told
        self._stage = stage
        self._untold: Timer | None = None
        self._boxes: dict[str, Notification] = {}  # what was told over the screen, by its words
        self._copied: Part | None = None  # while the status line says so…
        self._words: Callable[[], str] = str  # …in these words, with the key that copies more where that acts
        self._here = False  # what stands there is true only where the keyboard is now

    def copy(self) -> None:
        """What is in sight goes to the clipboard; again while the status line says so: the next part."""
        from tui.rooms.copying import fitting, next_part, plain

        stage = self._stage
        if isinstance(stage.screen, Copied):
            page = fitting(stage.screen.plain())
            if page:
                stage.copy_to_clipboard(page)
            self.tell(strings.COPIED_PAGE.format(lines=_lines(page)) if page else strings.NOTHING_FOUND_YET)
            return
        part = next_part(self._copied) if self._copied is not None else self._in_sight
        words = strings.COPY_PARTS
        named, other = words[part], words[next_part(part)]
        text = plain(part, stage.shown)
        if text:
            stage.copy_to_clipboard(text)
        told_so = strings.COPIED if text else strings.NOTHING_TO_COPY

        def wording(acting: Acting = stage.acting) -> str:
            return hint_line(told_so, acting, lines=_lines(text), part=named, other=other)

        self._show(wording(), "info")
        stage.note("info", wording(lambda action: None))
        self._copied, self._words = part, wording

    def save(self) -> None:
        """The session and a picture of the screen; behind the screen, as a disk takes its time."""
        from tui.rooms.portrait import portrait

        picture = portrait(self._stage)
        session = self._stage.shown.session
        threading.Thread(target=self._save, args=(session, picture), name="save", daemon=True).start()

    def tell(
        self, text: str, level: Literal["info", "error"] = "info", file: str = "", *, holds: Holds = always
    ) -> None:
        """In the status line for a while, and in the log for good. Where the status line has no room for it, and where
        the ``file`` that it names can be opened, it lies over the screen. ``holds``: as in :meth:`remark`."""
        self._show(text, level, file, holds=holds)
        self._stage.note(level, self.told)

    def hear(self, body: ev.Body) -> None:
        """A key was refused: why is said where one looks. The log has it already; how a request in words ended has a
        row."""
        if isinstance(body, ev.Ack) and not body.ok and body.do != "say" and (why := told(body.message)) != self.told:
            self._show(why, "info")

    def _show(self, text: str, level: Literal["info", "error"], file: str = "", *, holds: Holds = always) -> None:
        from tui.words.links import marked_up

        self.remark(text, holds=holds)
        stage = self._stage
        if file or level == "error" or not has_room(self.told, stage.shown, stage.size.width):
            severity: Literal["error", "information"] = "error" if level == "error" else "information"
            self._clear(self.told)
            box = Notification(marked_up(self.told, printable(file)), severity=severity, timeout=TOLD_S, markup=True)
            self._boxes[self.told] = box
            stage.post_message(Notify(box))

    def take_away(self, text: str) -> None:
        """What was told is over: it stands nowhere any longer but in the log."""
        text = printable(text)
        self._clear(text)
        if self.told == text:
            self.forget()

    def _clear(self, told: str) -> None:
        """Nothing over the screen says this any more."""
        if (box := self._boxes.pop(told, None)) is not None:
            self._stage.call_later(self._stage.withdraw, box)  # behind the message that brings it

    def remark(self, text: str, *, holds: Holds = always, here: bool = False) -> None:
        """In the status line for a while, and no longer than it ``holds``; ``here``: until the keyboard goes
        elsewhere."""
        self.told, self._holds, self._copied, self._here = printable(text), holds, None, here
        self._has_held = False
        if self._untold is not None:
            self._untold.stop()
        self._untold = self._stage.set_timer(TOLD_S, self.forget)
        self._stage.redraw()

    def notice(self, view: View) -> str:
        """What stands in the status line, as things are now. What held and does no more is told no more."""
        if self._copied is not None:
            self.told = printable(self._words())
        if not self.told or self._holds(view):
            self._has_held = True
            return self.told
        if self._has_held:
            self.take_away(self.told)
        return ""

    def forget(self) -> None:
        """It has stood there for long enough."""
        self.told, self._copied = "", None
        self._stage.redraw()

    def moved(self) -> None:
        """The keyboard has gone elsewhere."""
        if self._here and self.told:
            self.forget()

    def _save(self, session: str, picture: str) -> None:
        from config.folders import paths
        from tui.kept.saving import save

        try:
            saved = save(paths(), session, picture)
        except StorageError as error:
            self._stage.post_message(Told(f"{error.message} {error.hint}", "error"))
        else:
            words = strings.SAVED if saved.events else strings.SAVED_PICTURE
            self._stage.post_message(Told(words.format(folder=saved.folder), file=str(saved.folder)))

    @property
    def _in_sight(self) -> Part:
        """The part that a person looks at: the pane with the keyboard or all the room, or else the turn."""
        stage = self._stage
        match stage.main.pane if stage.screen is stage.main else None:
            case "conversation" | "plan" | "actions" | "log" as part:
                return part
            case _:
                return "turn"


def _lines(text: str) -> str:
    """How many lines that is, for people."""
    number = len(text.splitlines())
    return strings.LINES[number != 1].format(number)
