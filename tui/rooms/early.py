"""The requests that are typed while the engine starts. They wait in the console until it is there.

What is typed does to what waits what it would do with the engine there (``engine.session.inbox``), and at once: a new
request replaces it, as far as ``session.busy`` says so, and a stop or the end of the task drops it.

Each has its id from the moment in which it is typed, and the engine takes that over: a request is dropped, moved and
changed by the same id before and after. They are sent as they were asked for, unless somebody has chosen their order:
then they are one queue, of which each is done after the one before.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from msgspec.structs import replace

from engine.commands import Say
from tui.shown.facts import Line, Waiting, printable
from tui.words import strings

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from engine.events import Scope
    from engine.session.inbox import Busy
    from tui.rooms.drawing import Drawing
    from tui.stage import Stage


@dataclass(slots=True)
class _Asked:
    """One request."""

    id: str
    text: str
    waits: bool
    """It interrupts nothing."""
    follows: bool
    """It was asked for together with the one before it, or has been put behind that."""


class Early:
    """Holds them, and has them shown as all that waits. In the UI thread."""

    def __init__(self, stage: Stage, drawing: Drawing) -> None:
        self.busy: Busy = "interrupt"
        """What a new request does while there is another one."""
        self._stage = stage
        self._drawing = drawing
        self._asked: list[_Asked] = []

    def add(self, command: Say, behind: Sequence[str] = ()) -> Scope | None:
        """It waits before the first of those of these ids that still does, or after all others. Gives what it
        interrupts, which never begins; a stop is over with that."""
        from engine.planner.phrases.joints import comes_after  # all of which nobody needs before the first picture
        from engine.session.inbox import Request, scope_said

        if comes_after(command.text):
            command = replace(command, wait=True)
        scope = scope_said(command, self.busy)
        if self._asked and self.busy == "reject" and not command.wait and scope is None:
            self._lose((command.text, *command.then), strings.LOST["rejected"])
            return None
        before, rest = Request(command, 0, scope).since_its_stop()
        assert isinstance(rest.command, Say)
        new = _one_by_one(rest.command)
        if scope == "replaced":
            self.leave(strings.LOST["replaced"])
        elif scope is not None:
            said = new.pop(0)
            line = Line("you", printable(said.text), strings.HOW_SAID["text"])
            self._drawing.model = self._drawing.model.with_line(line)
            note = strings.LOST_BY.format(reason=strings.REASONS[scope])
            self.leave(note)
            self._lose((one.text for one in before), note)
        self._insert(new, behind)
        return scope

    def leave(self, note: str) -> int:
        """None of them begins, which has a row with this note each; how many that are."""
        asked, self._asked = self._asked, []
        self._lose((one.text for one in asked), note)
        if asked:  # else the engine says what waits
            self._show()
        return len(asked)

    def _lose(self, texts: Iterable[str | None], note: str) -> None:
        for text in texts:
            self._drawing.left_out(text or "", note)

    def _insert(self, new: list[_Asked], behind: Sequence[str]) -> None:
        at = next((at for id in behind if (at := self._place(id)) is not None), None)
        place = len(self._asked) if at is None else at
        self._asked[place:place] = new
        if at is not None:
            self._chain()
        for one in new:
            self._stage.note("info", strings.ASKED_EARLY.format(printable(one.text)))
        self._show()

    def drop(self, id: str) -> str | None:
        """Without the one of this id; its text. None: it does not wait here."""
        if (at := self._place(id)) is None:
            return None
        text = self._asked.pop(at).text
        self._show()
        return text

    def move(self, id: str, before: str | None) -> bool:
        """The one of this id to before another one, or behind all; whether it waits here."""
        if (at := self._place(id)) is None:
            return False
        moved = self._asked.pop(at)
        place = self._place(before) if before is not None else None
        self._asked.insert(len(self._asked) if place is None else place, moved)
        self._chain()
        self._show()
        return True

    def take(self) -> list[Say]:
        """All of them, as they are sent; none waits here any more."""
        asked, self._asked = self._asked, []
        commands: list[Say] = []
        for one in asked:
            if one.follows and commands:
                last = commands[-1]
                commands[-1] = replace(last, then=(*last.then, one.text), requests=(*last.requests, one.id))
            else:
                commands.append(Say(one.text, wait=one.waits, requests=(one.id,)))
        if asked:
            self._show()
        return commands

    def _place(self, id: str) -> int | None:
        return next((at for at, one in enumerate(self._asked) if one.id == id), None)

    def _chain(self) -> None:
        """Somebody has chosen an order: none of them takes the place of another."""
        for one in self._asked:
            one.follows = True

    def _show(self) -> None:
        waiting = tuple(Waiting(one.id, printable(one.text)) for one in self._asked)
        self._drawing.model = replace(self._drawing.model, waiting=waiting)
        self._stage.redraw()


def _one_by_one(command: Say) -> list[_Asked]:
    """Its requests, each of which has an id."""
    from ulid import ULID

    texts = (command.text, *command.then)
    ids = (*command.requests, *(str(ULID()) for _ in texts[len(command.requests) :]))
    return [_Asked(id, text, command.wait, at > 0) for at, (id, text) in enumerate(zip(ids, texts, strict=True))]
