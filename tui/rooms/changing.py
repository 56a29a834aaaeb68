"""Where the page of the settings is opened, and where settings are read and written for it.

That happens one after the other in a thread of its own, as a disk takes its time; what comes of it is taken up in the
UI thread (``tui.rooms.dressing``).
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

from tui.messages import Settled
from tui.rooms.dressing import Dressing, language_of, wording_of
from tui.shown.facts import printable
from tui.words import strings

if TYPE_CHECKING:
    from pathlib import Path

    from config.changing import Layers
    from config.editing import Value
    from tui.options import Option
    from tui.screens.settings import SettingsScreen
    from tui.stage import Stage


class Changing:
    """Changes settings for a person. In the UI thread."""

    def __init__(self, stage: Stage, dressing: Dressing) -> None:
        self._stage = stage
        self._dressing = dressing
        self._page: SettingsScreen | None = None
        self._jobs: queue.SimpleQueue[Callable[[], Settled] | None] = queue.SimpleQueue()
        self._worker: threading.Thread | None = None

    def open(self, at: str = "") -> None:
        """The page of the settings, whose module is read when it is opened, at the setting of this name; there
        already: leave it."""
        from tui.screens.settings import SettingsScreen

        stage = self._stage
        leaving = isinstance(stage.screen, SettingsScreen)
        stage.come_back()
        if leaving or stage.main.has_class("-tiny"):
            return
        self._page = SettingsScreen(stage.acting, self, stage.shown, at)
        stage.open_page(self._page)

    def read(self) -> None:
        """Ask for the settings as they are."""
        self._do(lambda layers, themes: Settled(_options(layers, themes)), self._dressing.theme)

    def keep(self, option: Option, text: str) -> None:
        """Set a setting to what was written, for good; take it up where that is possible."""
        from tui.options import value_of

        value, before = value_of(option, text), self._dressing.theme
        if option.key == "console.theme" and text in self._stage.available_themes:
            self._dressing.theme = text  # until it is known otherwise, so that nothing flickers

        def job(layers: Layers, themes: Sequence[str]) -> Settled:
            from config.changing import NotWritten, change

            if why := _wrong(layers, option, value):
                raise NotWritten(why)
            return self._settled(layers, themes, option, change(layers, option.path, value).file)

        self._do(job, before)

    def put(self, key: str, value: str) -> None:
        """Set the setting of this name without its page."""
        from config.changing import choices
        from tui.options import Option

        path = tuple(key.split("."))
        self.keep(Option(key, None, "", choices(path) or (value,), "", ""), value)

    def give_back(self, option: Option) -> None:
        """Set a setting to what sayso comes with."""

        def job(layers: Layers, themes: Sequence[str]) -> Settled:
            from config.changing import give_back

            return self._settled(layers, themes, option, give_back(layers, option.path).file)

        self._do(job, self._dressing.theme)

    def try_on(self, theme: str | None) -> None:
        """Look like this for now; None: as the settings say."""
        self._dressing.try_on(theme)

    def close(self) -> None:
        """What was kept is written, unless the disk keeps us waiting."""
        if self._worker is not None:
            self._jobs.put(None)
            self._worker.join(1.0)

    def settled(self, message: Settled) -> None:
        """Settings were read or written, or could not be."""
        if message.settings is not None:
            self._dressing.take_up(message.key, message.settings, message.wording)
        elif message.failed:
            if message.theme:
                self._dressing.theme = message.theme
                self._dressing.try_on(None)
            self._stage.note("warning", message.failed)
        page = self._page
        if page is not None and page.is_attached:
            page.settled(message)
        elif told := message.failed or _kept(message):
            from tui.words.links import marked_up

            severity: Literal["error", "information"] = "error" if message.failed else "information"
            self._stage.notify(marked_up(told, printable(message.file)), severity=severity)
        self._stage.redraw()

    def _do(self, job: Callable[[Layers, Sequence[str]], Settled], before: str) -> None:
        """In the thread of the settings. ``before``: the theme that stays where nothing comes of it."""
        layers, themes = (
            self._dressing.layers,
            sorted(self._stage.available_themes, key=lambda name: "sayso" not in name),
        )
        if layers is None:
            self.settled(Settled((), failed=strings.SETTINGS_NOT_READ))
            return
        self._jobs.put(lambda: _done(lambda: job(layers, themes), before))
        if self._worker is None:
            self._worker = threading.Thread(target=self._work, name="settings", daemon=True)
            self._worker.start()

    def _work(self) -> None:
        while (job := self._jobs.get()) is not None:
            self._stage.post_message(job())

    def _settled(self, layers: Layers, themes: Sequence[str], option: Option, file: Path | None) -> Settled:
        settings = layers.load()
        words = wording_of(settings) if option.key == "console.language" and language_of(settings) == "zh" else None
        return Settled(_options(layers, themes), option.key, settings=settings, wording=words, file=str(file or ""))


def _wrong(layers: Layers, option: Option, value: Value) -> str:
    """Why `sayso config check` would not have this value, beyond the schema, which is asked where it is written."""
    from config.editing import NotEditable, as_yaml
    from config.errors import ConfigError
    from tui.checking import wrong_names

    try:
        as_set = replace(layers, overrides=(*layers.overrides, f"{option.key}={as_yaml(value)}"))
        problems = list(wrong_names(as_set.load(), tuple(as_set.explain().values())))
    except (ConfigError, NotEditable):
        return ""
    return next((problem.message for problem in problems if problem.key == option.key), "")


def _options(layers: Layers, themes: Sequence[str]) -> tuple[Option, ...]:
    from tui.options import options

    return options(layers, themes)


def _kept(message: Settled) -> str:
    """That a setting is kept, and from when on it holds; empty where none was set."""
    from tui.options import kept, overridden

    option = next((option for option in message.options if option.key == message.key), None)
    if option is None:
        return ""
    said = kept(strings.SETTING_NAMES[option.key], printable(message.file))
    if option.over:
        return f"{said} {overridden(option)}"
    return f"{said} {strings.SETTING_LIVE if option.live else strings.SETTING_RESTART}"


def _done(job: Callable[[], Settled], theme: str) -> Settled:
    """What came of it; in the thread of the settings. ``theme`` is the one that stays if nothing did."""
    from config.changing import NotWritten
    from config.errors import ConfigError

    try:
        return job()
    except NotWritten as error:
        return Settled((), failed=printable(str(error)), theme=theme)
    except ConfigError as error:
        return Settled((), failed=printable(error.message), theme=theme)
