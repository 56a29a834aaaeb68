"""Where the palette is opened, and where what was chosen in it is done."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from textual.actions import parse

from engine.commands import EStop
from tui.keys.keys import KEYS, LINE_KEYS
from tui.shown.facts import printable
from tui.words import strings

if TYPE_CHECKING:
    from textual.dom import DOMNode

    from engine.skills.registry import Skill
    from tui.palette.entries import Choice, Entry, Where
    from tui.rooms.changing import Changing
    from tui.rooms.keeping import Keeping
    from tui.stage import Stage


class Choosing:
    """Opens panels over the main screen and acts on their answers; their modules are read when one is opened."""

    def __init__(self, stage: Stage, changing: Changing, keeping: Keeping) -> None:
        """``changing`` changes settings, and opens their page; ``keeping`` tells what is to be read."""
        self._stage = stage
        self._changing = changing
        self._keeping = keeping

    async def open(self) -> None:
        """Everything that can be done; once more: not that."""
        stage = self._stage
        if stage.main.has_class("-tiny") or await self._was_there(strings.PALETTE):
            return
        from config.folders import paths
        from tui.palette.entries import entries

        places = stage.handle.places() if stage.handle is not None else {}
        skills = stage.offer.skills if stage.offer is not None else ()
        file = str(paths().config / "config.yaml")
        themes = sorted(stage.available_themes, key=lambda name: "sayso" not in name)
        found = entries(stage.listed_keys, places, skills, stage.main.line.offered, file, themes, stage.possible)
        await self._show(found, strings.PALETTE)

    async def recall(self) -> None:
        """What was asked for before; once more: not that."""
        main = self._stage.main
        if main.has_class("-tiny") or await self._was_there(strings.PALETTE_RECENT):
            return
        from tui.palette.entries import requests

        await self._show(requests(main.line.history), strings.PALETTE_RECENT, guesses=False)

    async def _was_there(self, title: str) -> bool:
        """Close the panel of this title, if it is the one that is open."""
        main = self._stage.main
        return main.panel == title and await main.uncover()

    async def search_log(self) -> None:
        """The lines of the log, to find one of them."""
        from tui.palette.entries import log_lines

        await self._show(log_lines(self._stage.shown.model.log), strings.PALETTE_LOG)

    async def chosen(self, choice: Choice) -> None:
        """Do what was chosen."""
        from tui.palette.entries import Act, Change, Fill, Put, Send, Show, Tell, Write

        stage = self._stage
        await stage.main.uncover()
        match choice:
            case Act(key, where):
                await self._act(key.action, where)
            case Write(text):
                self._write(text)
            case Tell(text):
                stage.notify(text, title=strings.NAME, markup=False)
                stage.note("info", printable(text))
            case Send(text):
                self._send(text)
            case Change(setting):
                self._changing.open(setting)
            case Put(setting, value):
                self._changing.put(setting, value)
            case Show(line):
                stage.main.go_to_line(line)
            case Fill(skill):
                await self._fill(skill)

    async def composed(self, text: str) -> None:
        """A form is filled in: do what it says."""
        await self._stage.main.uncover()
        self._send(text)

    def _send(self, text: str) -> None:
        """As if it had been typed into the line and sent."""
        self._stage.main.line.send(text)

    async def _show(self, entries: Sequence[Entry], title: str, *, guesses: bool = True) -> None:
        from tui.palette.palette import Palette

        stage = self._stage
        stage.come_back()
        await stage.main.cover(Palette(entries, stage.acting, title=title, guesses=guesses))

    async def act(self, action: str) -> None:
        """What a click on a key in the status line does: what the key does. Nobody quits by a slip of the hand."""
        if (of_line := next((key for key in LINE_KEYS if key.id == action), None)) is not None:
            await self._stage.run_action(of_line.action, self._stage.main.line)
            return
        key = next(key for key in KEYS if key.id == ("leave" if action == "leave_now" else action))
        await self._act(key.action, "console")

    async def _act(self, action: str, where: Where) -> None:
        """What the key does, where it does it; on the page of the settings nothing is meant before it is there."""
        stage = self._stage
        if action == "interrupt":
            stage.interrupt()
        if action == "estop" and not stage.is_headless:  # where its own key has not been pressed, which does it
            stage.send(EStop())
        if where == "console":
            await self._run(action, stage, action)
            return
        if where == "map":
            stage.main.point(stay=True)
            await self._run(action, stage.main.floor, where)
            return
        if where == "queue":
            stage.main.go_to("actions")
            await self._run(action, stage.main.queue, where if not stage.main.queue.has_waiting else "")
            return
        if where == "log":
            stage.main.go_to("log")
            await self._run(action, stage.main.log_pane, where)
            return
        if where == "hand" and not stage.check_action("by_hand", ()):
            await stage.run_action("by_hand")  # which says why not
            return
        if where == "hand":
            await stage.run_action(action, stage.main.drive_by_hand())
            return
        if where in ("settings", "doctor"):  # where nothing is meant yet, or all is examined as it is opened
            await stage.run_action(where)
            return
        await stage.run_action("turn")
        stage.screen.call_after_refresh(stage.run_action, action, stage.screen)

    async def _run(self, action: str, target: DOMNode, about: str) -> None:
        """Do it there. Where it does nothing now, that is said, unless it says so itself."""
        _, name, parameters = parse(action)
        if not target.check_action(name, parameters):
            self._keeping.remark(strings.NO_USE.get(about, strings.NO_USE[""]))
        await self._stage.run_action(action, target)

    async def _fill(self, skill: Skill) -> None:
        """Ask for the arguments of a skill, if it has any."""
        from tui.palette.arguments import blanks
        from tui.palette.calls import as_written
        from tui.palette.form import Form

        stage = self._stage
        if not skill.parameters or stage.offer is None or stage.handle is None:
            self._send(as_written(skill, {}))
            return
        seen = tuple(dict.fromkeys(thing.name for thing in stage.handle.world().things))
        await stage.main.cover(Form(skill, blanks(skill, stage.offer, seen), stage.acting))

    def _write(self, text: str) -> None:
        """Into the line, where somebody sends it or not."""
        self._stage.main.type()
        self._stage.main.line.write(text)
