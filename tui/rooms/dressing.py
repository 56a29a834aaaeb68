"""What the settings say of the console: how it looks, what its keys are, what it remembers, and how it speaks.

They are read behind the first picture, and taken up in the UI thread; once more where somebody changes one of them
(``tui.rooms.changing``).
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Literal, NamedTuple

from engine import events as ev
from engine.commands import SetVolume
from engine.scheduling import prefer, raise_priority
from tui.messages import CameraChoice, Dressed, Measured, Recalled, Warned
from tui.rooms.drawing import CALM_S, Drawing
from tui.rooms.early import Early
from tui.rooms.examining import Examining
from tui.rooms.leaving import Leaving
from tui.rooms.viewing import Viewing
from tui.shown.facts import printable
from tui.terminal.feed import FASTEST_S
from tui.words import strings
from tui.words.language import Language, Telling, Wordy, speak

if TYPE_CHECKING:
    from config.changing import Layers
    from config.schema import Settings
    from engine.session.inbox import Busy
    from tui.doctor.examiner import Examiner
    from tui.graphics.asking import GraphicsChoice
    from tui.kept.history import RequestHistory
    from tui.kept.sizes import Shares, SizeFile
    from tui.kept.tour import Tour
    from tui.stage import Stage

Motion = Literal["full", "reduced"]
Notify = Literal["auto", "off"]


class Rooms(NamedTuple):
    """Those that settings have something to say about."""

    drawing: Drawing
    viewing: Viewing
    examining: Examining
    leaving: Leaving
    early: Early


class Dressing:
    """Takes up settings. In the UI thread, but for :meth:`dress`."""

    def __init__(self, stage: Stage, rooms: Rooms) -> None:
        self.layers: Layers | None = None
        """Where settings come from; None: they are not read yet."""
        self.sizes: SizeFile | None = None
        """Where the sizes of the panes are kept."""
        self._stage = stage
        self._rooms = rooms
        self.stop_keys, self.estop_keys = _stopping(stage.keys)
        """Those that stop the robot, and those that press the emergency stop."""
        self._animation = stage.animation_level  # by the environment, where nothing is to be still
        self.theme = stage.theme
        """By the settings; another one may be tried on."""
        self._history: RequestHistory | None = None
        self._said = ""  # what was said last

    # At the start

    def dress(
        self,
        theme: str,
        fps: float,
        *,
        prompt: bool = False,
        camera: CameraChoice = "off",
        graphics: GraphicsChoice = "blocks",
        motion: Motion = "full",
        notify: Notify = "auto",
        busy: Busy = "interrupt",
        language: Language | None = None,
        wording: Telling | None = None,
        keys: Mapping[str, str] | None = None,
        history: RequestHistory | None = None,
        sizes: SizeFile | None = None,
        tour: Tour | None = None,
        layers: Layers | None = None,
        secrets: Sequence[str] = (),
        doctor: Callable[[], Examiner] | None = None,
    ) -> None:
        """Look as the settings say. Thread-safe.

        ``prompt``: the thread that reads the keyboard goes before others, where the system allows it.
        ``camera``: whether what it sees is shown from the start; auto: where there is room for everything.
        ``graphics``: what pictures are drawn with.
        ``motion``: whether anything moves by itself oftener than once a second.
        ``notify``: whether the end of a long task is told to people who look at something else.
        ``busy``: what a new request does while there is another one.
        ``language``: that of all words; None: as it is. ``wording``: puts what the engine says into it.
        ``keys``: those to use in place of the usual ones, by action id.
        ``history``: where what is typed is kept for later sessions; None: nowhere.
        ``sizes``: where the sizes of the panes are kept; None: nowhere.
        ``tour``: whether somebody needs one; None: nobody.
        ``layers``: where settings come from, for whoever wants to change some.
        ``doctor``: makes what examines everything, once somebody wants that.
        ``secrets``: those of the settings, which no report of a fault may tell.
        """
        stage, rooms = self._stage, self._rooms
        rooms.leaving.secrets = tuple(secrets)
        rooms.drawing.alerting.on, rooms.early.busy = notify != "off", busy
        if prompt and (reader := getattr(stage.terminal, "reader", None)) is not None:
            raise_priority(reader)
            prefer(threading.main_thread().native_id or 0)
            if (writer := getattr(stage.terminal, "writer", None)) is not None:
                prefer(writer)
        if doctor is not None:
            rooms.examining.know(doctor)
        if tour is not None:
            tour.read()
        self.layers, rooms.drawing.tour = layers, tour
        stage.post_message(Dressed(theme, fps, camera, graphics, motion, language, wording))
        if history is not None:
            history.read(lambda why: self._warn(strings.NOT_KEPT.format(printable(why))))
        stage.post_message(Recalled(keys or {}, history))
        if sizes is not None:
            shares = sizes.read(lambda why: self._warn(strings.SIZES_NOT_KEPT.format(printable(why))))
            stage.post_message(Measured(shares, sizes))

    def dressed(self, message: Dressed) -> None:
        """The settings are read."""
        stage, rooms = self._stage, self._rooms
        if message.language is not None:
            self.speak(message.language, message.wording)
        if message.theme in stage.available_themes:
            stage.theme = self.theme = message.theme
        else:
            from config.nearest import nearest

            near = filter(None, [nearest(message.theme, stage.available_themes)])
            told = (strings.UNKNOWN_THEME.format(message.theme), *map(strings.DID_YOU_MEAN_THEME.format, near))
            stage.note("warning", " ".join(told))
            stage.remark(" ".join(told))
        rooms.viewing.choose(message.graphics)
        self._look(message.camera, or_not=False)
        self._move(message.motion)
        rooms.drawing.pace(message.fps)
        stage.redraw()

    def recalled(self, keys: Mapping[str, str], history: RequestHistory | None) -> None:
        """What was typed in earlier sessions is read, and the keys that somebody chose are known."""
        self._history = history
        if history is not None:
            self._stage.main.line.remember(history.earlier, history.in_vain)
            self._stage.redraw()  # there is something to recall now
        if keys:
            self._use_keys(keys)

    def measured(self, shares: Shares, file: SizeFile) -> None:
        """How the panes shared the room in earlier sessions is read."""
        self.sizes = file
        self._stage.main.share(shares)

    def speak(self, language: Language, wording: Telling | None = None) -> None:
        """Show all words in this language from now on, those of the engine by ``wording``."""
        stage = self._stage
        if not speak(language, wording):
            return
        stage.use_keys({})
        for screen in stage.screen_stack:
            if isinstance(screen, Wordy):
                screen.reword()
        stage.redraw()

    def typed(self, request: str) -> None:
        """Somebody asked for something in the line."""
        if self._history is not None:
            self._history.add(request)

    def hear(self, body: ev.Body) -> None:
        """What was refused or not understood is not offered to be asked for once more."""
        match body:
            case ev.TranscriptFinal():
                self._said = body.text
            case ev.PlanRejected(text=text) | ev.RefusalMade(text=text):
                self._mark(text)
            case ev.ClarificationAsked() if body.about:
                self._mark(body.about)
                self._mark(self._said)  # where it was no answer, the question is still about what was said before it

    def _mark(self, text: str) -> None:
        if self._stage.main.line.mark(text) and self._history is not None:
            self._history.mark(text)

    def close(self) -> None:
        """What is kept for later sessions is written to the end."""
        for file in (self._history, self.sizes, self._rooms.drawing.tour):
            if file is not None:
                file.close()

    # While it runs

    def try_on(self, theme: str | None) -> None:
        """Look like this for now; None: as the settings say."""
        theme = theme or self.theme
        if theme in self._stage.available_themes and theme != self._stage.theme:
            self._stage.theme = theme

    def take_up(self, key: str, settings: Settings, wording: Telling | None) -> None:
        """Look, or sound, as one of the settings says."""
        console = settings.console
        match key:
            case "console.theme":
                self.theme = console.theme
                self.try_on(None)
            case "console.language":
                self.speak(language_of(settings), wording)
            case "console.fps":
                self._rooms.drawing.pace(console.fps)
            case "console.camera":
                self._look(camera_of(settings), or_not=True)
            case "console.motion":
                self._move(console.motion)
            case "voice.volume":
                self._stage.send(SetVolume(settings.voice.volume))
            case "console.notify":
                self._rooms.drawing.alerting.on = console.notify != "off"

    def _look(self, camera: CameraChoice, *, or_not: bool) -> None:
        """Show what the camera sees, if it is to be shown; ``or_not``: else no longer."""
        stage = self._stage
        wanted = camera == "on" or (camera == "auto" and stage.main.has_room_for_all)
        if wanted or (or_not and stage.main.camera_shown):
            self._rooms.viewing.show(wanted)

    def _move(self, motion: Motion) -> None:
        stage, calm = self._stage, motion == "reduced"
        stage.animation_level = "none" if calm else self._animation
        self._rooms.drawing.calm = calm
        self._rooms.viewing.pace(CALM_S if calm else FASTEST_S)

    def _use_keys(self, chosen: Mapping[str, str]) -> None:
        """Those of them that can be had; the log says why others cannot."""
        from tui.keys.keymap import keymap

        stage, found = self._stage, keymap(chosen)
        stage.set_keymap(dict(found.keys))
        self.stop_keys, self.estop_keys = _stopping(found.keys)
        stage.use_keys(found.keys)
        stage.main.hint()
        for mistake in found.mistakes:
            action = printable(mistake.action)
            key = stage.shown_keys.get(mistake.action)
            stays = strings.KEY_STAYS.format(action=action, key=key) if key is not None else ""
            self._warn(strings.KEY_MISTAKE.format(action=action, message=printable(mistake.message)) + stays)
        stage.redraw()

    def _warn(self, text: str) -> None:
        """In the log. Thread-safe."""
        self._stage.post_message(Warned(text))


def _stopping(keys: Mapping[str, str]) -> tuple[frozenset[str], frozenset[str]]:
    return frozenset(keys["interrupt"].split(",")), frozenset(keys["estop"].split(","))


def camera_of(settings: Settings) -> CameraChoice:
    """Whether the camera is shown from the start, at this terminal."""
    from tui.terminal.terminal import over_ssh

    camera = settings.console.camera
    return "off" if camera == "auto" and over_ssh(os.environ) else camera


def wording_of(settings: Settings) -> Telling:
    """Puts what the engine says into Chinese. What that needs is read now: later somebody waits for a frame."""
    from engine.wording import build_wording

    wording = build_wording(settings)
    for place in settings.places.values():
        wording.told(place.name)
    return wording.told


def language_of(settings: Settings) -> Language:
    """That of the console, at this terminal."""
    from tui.words.language import chosen

    return chosen(settings.console.language, settings.planner.language, os.environ)
