"""No key that is named on the screen is dead: in every state, on every page and in every pane, what a hint names acts.

The screen is read as a person reads it: a key beside the words of a hint. That it acts is asked of the console
(``Stage.acting``); those that a moment is about are pressed, and something has to change.
"""

from __future__ import annotations

import re
from collections.abc import Awaitable, Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest

from config import load
from config.changing import Layers
from config.schema import Settings
from engine import events as ev
from tests.tui import conversation, scripted
from tests.tui.desk import Desk, console
from tests.tui.house import offer
from tests.tui.scripted import PARTS_READY, ScriptedEngine, flat, robot_at
from tui.doctor.examiner import Examiner
from tui.doctor.finding import Check, Finding
from tui.keys.keys import BY_ID, shown
from tui.screens.doctor import DoctorScreen
from tui.screens.help import HelpScreen
from tui.screens.settings import SettingsScreen
from tui.widgets.status import StatusLine
from tui.words import strings, strings_zh
from tui.words.hints import JOINT
from tui.words.language import Language

Happening = Callable[[Desk], Awaitable[None]]
EXAMINED: list[str] = []
"""What the doctor has looked at."""


async def nothing(desk: Desk) -> None:
    """It is idle, and nothing was asked for yet."""


async def talked(desk: Desk) -> None:
    conversation.play(desk.engine, conversation.ALL)


async def acting(desk: Desk) -> None:
    desk.engine.play(scripted.acting())


async def planning(desk: Desk) -> None:
    desk.engine.publish(conversation.typed("go to the kitchen"))
    desk.engine.publish(ev.StateChanged("IDLE", "PLANNING", "a request was understood"))


async def asking(desk: Desk) -> None:
    desk.engine.publish(ev.ClarificationAsked("Shall I go to the bedroom?", "go to the bedrom"))


def waiting(*texts: str) -> Happening:
    async def happens(desk: Desk) -> None:
        desk.engine.play(scripted.acting())
        requests = tuple(ev.WaitingRequest(f"R{number}", text) for number, text in enumerate(texts))
        desk.engine.publish(ev.RequestsWaiting(texts, requests))

    return happens


async def done(desk: Desk) -> None:
    """All of it can be undone, and done again."""
    conversation.play(desk.engine, conversation.ALL)
    turn = conversation.ALL[-1].turn
    desk.engine.publish(ev.OffersMade(resume=turn, undo=turn, again=turn, acted=turn), turn=None)


async def gone(desk: Desk) -> None:
    """The robot is."""
    desk.engine.robot = None
    desk.app.redraw()


async def pressed(desk: Desk) -> None:
    desk.engine.robot = replace(robot_at(0.0, 0.0, 0.0), estop=True)
    desk.app.redraw()
    await desk.until(lambda: "E-STOP" in desk.text or "急停" in desk.text)


async def stopped_by_hand(desk: Desk) -> None:
    await desk.press("g")
    await pressed(desk)


async def failed(desk: Desk) -> None:
    desk.engine.publish(ev.ErrorRaised("path_blocked", "No way leads there.", "Move the chair."))


async def ended(desk: Desk) -> None:
    desk.engine.publish(ev.SessionEnded("asked to"))


async def quiet_log(desk: Desk) -> None:
    desk.engine.publish(ev.Log("info", "robot", "one"), turn=None)


async def loud_log(desk: Desk) -> None:
    conversation.play(desk.engine, conversation.ALL)
    desk.engine.publish(ev.Log("error", "camera", "two"), turn=conversation.ALL[-1].turn)


async def remembered(desk: Desk) -> None:
    desk.app.main.line.remember(["go home"])
    desk.app.redraw()


async def remembered_at_work(desk: Desk) -> None:
    await acting(desk)
    await remembered(desk)


async def nowhere(desk: Desk) -> None:
    """No place on the map has a name."""
    desk.engine.robot = robot_at(-4.0, 3.0, 0.0)


async def settings(desk: Desk) -> None:
    await desk.press("o")
    await desk.until(lambda: isinstance(desk.app.screen, SettingsScreen) and desk.app.screen.meant is not None)


async def doctor(desk: Desk) -> None:
    def examine(settings: Settings) -> Finding:
        EXAMINED.append("python")
        return Finding("python", "ok", "3.13.1, 2 cores")

    desk.app.examining.know(lambda: Examiner(load(environ={}), checks=[Check("python", examine)]))
    await desk.press("d")
    await desk.until(lambda: isinstance(desk.app.screen, DoctorScreen) and not desk.app.screen.is_examining)


@dataclass(frozen=True, slots=True)
class Moment:
    """What has happened, and the keys that were pressed then."""

    happens: Happening = nothing
    keys: tuple[str, ...] = ()
    names: tuple[str, ...] = ()
    """Actions that must be named; their keys are pressed. A console begins anew for each, which takes its time: what
    else is named is only asked whether it acts."""
    silent: tuple[str, ...] = ()
    """Actions that must not be."""
    deaf: bool = False
    in_line: bool = False
    one_line: bool = False
    size: tuple[int, int] = (120, 40)
    keymap: dict[str, str] = field(default_factory=dict)
    places: bool = True


LINE = ("back", "interrupt", "send", "earlier", "recall")
MOMENTS = {
    "the line": Moment(in_line=True, names=("back", "wake"), silent=("earlier", "recall")),
    "the line, with a history": Moment(remembered, in_line=True, names=("earlier", "recall", "pane_next")),
    "the line, at the first of the history": Moment(
        remembered, ("up",), in_line=True, names=("send",), silent=("earlier",)
    ),
    "the line with a request": Moment(remembered, (*"go",), in_line=True, names=LINE[:4], silent=("wake", "add")),
    "the line with a request, at work": Moment(remembered_at_work, (*"go",), in_line=True, names=("add", "send")),
    "the line with blanks": Moment(keys=(*"a", "space", "home", "delete"), in_line=True, silent=("send", "add")),
    "no microphone": Moment(deaf=True, in_line=True, silent=("wake",)),
    "panes": Moment(
        names=("wake", "end_task", "type", "map", "camera", "help", "leave", "pane_log"), silent=("turn_back", "undo")
    ),
    "panes, after a conversation": Moment(talked, names=("turn_back", "turn"), silent=("turn_on",)),
    "panes, at an older turn": Moment(talked, ("left_square_bracket",), names=("turn_back", "turn_on", "turn")),
    "offers": Moment(done, names=("resume", "undo", "again")),
    "offers at the actions": Moment(done, ("3",), names=("resume", "undo", "again")),
    "planning": Moment(planning),
    "acting": Moment(acting),
    "asking": Moment(asking, in_line=True),
    "emergency stop": Moment(pressed, names=("release",)),
    "emergency stop, on the map": Moment(pressed, ("m", "tab"), names=("release", "map"), silent=("map_go",)),
    "emergency stop, by hand": Moment(stopped_by_hand, names=("release", "back"), silent=("hand_ahead",)),
    "emergency stop, while typing": Moment(pressed, (*"go",), in_line=True, names=("release",)),
    "something failed": Moment(failed, names=("back",)),
    "something failed, while typing": Moment(failed, (*"go",), in_line=True, names=("back",)),
    "whether to quit": Moment(acting, ("q",), names=("leave",)),
    "whether to quit, while typing": Moment(acting, ("q", "slash"), names=("back",), silent=("leave",)),
    "ended": Moment(ended, silent=("wake", "end_task", "type")),
    "ended, in the line": Moment(ended, (*"go",), in_line=True, silent=("send", "add"), names=("leave_now",)),
    "actions, nothing waits": Moment(acting, ("3",), silent=("queue_drop", "queue_later")),
    "actions, one waits": Moment(
        waiting("beep"), ("3",), names=("queue_drop", "queue_change"), silent=("queue_later", "queue_down")
    ),
    "actions, two wait": Moment(
        waiting("beep", "nod"),
        ("3",),
        names=("queue_later", "queue_down"),
        silent=("queue_earlier", "queue_up"),
        size=(180, 40),
    ),
    "actions, at the last of two": Moment(
        waiting("beep", "nod"), ("3", "down"), names=("queue_earlier", "queue_up"), size=(180, 40)
    ),
    "a pane with all the room": Moment(acting, ("1", "z"), names=("zoom",)),
    "the conversation, scrolled back": Moment(talked, ("1", "pageup"), size=(80, 24)),
    "the log, without errors": Moment(
        quiet_log, ("5",), names=("log_level",), silent=("log_trouble_before", "log_turn")
    ),
    "the log, with errors": Moment(loud_log, ("5",), names=("log_trouble_before", "log_turn")),
    "the log, nothing fits": Moment(quiet_log, ("5", "v", "v"), names=("log_all",)),
    "the search of the log": Moment(quiet_log, ("5", "s"), names=("send",)),
    "the map": Moment(keys=("m",), names=("map_follow", "map_go", "map_nearer", "map"), silent=("map_farther",)),
    "the map, closer": Moment(keys=("m", "plus"), names=("map_farther",)),
    "the map, closest": Moment(keys=("m", *["plus"] * 8), silent=("map_nearer",)),
    "the map, pointing": Moment(keys=("m", "tab"), names=("map_go",)),
    "the map's question": Moment(keys=("m", "tab", "enter"), names=("map_go",), silent=("map_follow", "map_nearer")),
    "the map, without a robot": Moment(gone, ("m", "tab"), names=("map",), silent=("map_go", "map_follow", "by_hand")),
    "the map, other keys": Moment(keys=("m", "tab"), keymap={"map_go": "x"}, names=("map_go",)),
    "the map, where nothing has a name": Moment(nowhere, ("m",), places=False),
    "by hand": Moment(keys=("g",), names=("hand_ahead", "hand_faster", "back")),
    "by hand, fastest": Moment(keys=("g", *["plus"] * 5), names=("hand_slower",), silent=("hand_faster",)),
    "a turn page without a turn": Moment(keys=("enter",), silent=("turn_back", "turn_on", "unfold"), names=("back",)),
    "a turn page": Moment(talked, ("enter",), names=("turn_back", "unfold"), silent=("turn_on",)),
    "a turn page, the first of them": Moment(
        talked, (*["left_square_bracket"] * 5, "enter"), names=("turn_on", "unfold"), silent=("turn_back",)
    ),
    "a turn page with nothing to unfold": Moment(talked, ("left_square_bracket", "enter"), silent=("unfold",)),
    "the palette": Moment(keys=("ctrl+p",), names=("send", "back")),
    "the palette, with words": Moment(keys=("ctrl+p", *"kit"), names=("send", "back")),
    "the palette, nothing fits": Moment(keys=("ctrl+p", *"zzzz"), silent=("send",), names=("back",)),
    "earlier requests": Moment(remembered, ("ctrl+r",), names=("send",)),
    "earlier requests, without any": Moment(keys=("ctrl+r",), silent=("send",), names=("back",)),
    "a form": Moment(keys=("ctrl+p", *"carry", "enter"), names=("send",)),
    "help": Moment(keys=("question_mark",), names=("newer", "back"), silent=("older",), size=(80, 24)),
    "help, at its end": Moment(
        keys=("question_mark", *["pagedown"] * 4), names=("older",), silent=("newer",), size=(120, 60)
    ),
    "help, with words": Moment(keys=("question_mark", *"emerg"), silent=("newer",), names=("back",)),
    "the doctor": Moment(doctor, names=("examine", "copy", "back"), silent=("newer", "older")),
    "settings": Moment(settings, names=("setting_take", "setting_find", "setting_down"), silent=("setting_up",)),
    "settings, further down": Moment(settings, ("down", "down"), names=("setting_up",)),
    "a value of the settings": Moment(
        settings, ("down", "down", "enter"), names=("send", "setting_up"), silent=("setting_take", "setting_find")
    ),
    "the search of the settings": Moment(
        settings, ("s",), names=("send", "setting_down"), silent=("setting_take", "setting_find", "setting_default")
    ),
    "the search of the settings, nothing fits": Moment(settings, ("s", *"zzz"), silent=("setting_down",)),
    "one line": Moment(in_line=True, one_line=True, size=(120, 2), silent=("recall", "back", "earlier")),
    "one line, with a request": Moment(
        remembered_at_work, (*"go",), in_line=True, one_line=True, size=(120, 2), names=("add",), silent=("back",)
    ),
    "too small": Moment(acting, size=(40, 10), names=("leave_now",), silent=("map", "type")),
}


async def _open(desk: Desk, moment: Moment, folder: Path) -> None:
    desk.app.dress("sayso-dark", 30, layers=Layers(environ={}, folder=folder))
    await desk.settled()
    await moment.happens(desk)
    await desk.press(*moment.keys)


def _console(moment: Moment, language: Language = "en") -> Any:
    floor = flat()
    engine = ScriptedEngine(
        robot=robot_at(-1.35, 0.05, 0.4), floor=floor if moment.places else replace(floor, rooms=(), furniture=())
    )
    if not moment.places:
        engine.places = dict  # type: ignore[method-assign]
    engine.offers = offer()
    if moment.deaf:
        engine.parts = tuple(
            replace(part, state="missing") if part.name == "microphone" else part for part in PARTS_READY
        )
    return console(
        engine,
        size=moment.size,
        language=language,
        in_line=moment.in_line,
        one_line=moment.one_line,
        keymap=moment.keymap,
    )


# What is named


def _hints(value: object) -> Iterator[str]:
    """Every hint among the words of the console: a part of a line that names an action."""
    if isinstance(value, str):
        yield from (part for part in value.split(JOINT) if set(re.findall(r"{(\w+)}", part)) & BY_ID.keys())
    elif isinstance(value, tuple):
        for one in value:
            yield from _hints(one)
    elif isinstance(value, dict):
        for one in value.values():
            yield from _hints(one)


def read(desk: Desk) -> dict[str, set[str]]:
    """What stands on the screen and names a key, with the actions that may be meant: some share their words."""
    number = rf"{strings.TASK} \d+"  # of the task: not a key of what stands behind it
    lines = [re.sub(number, " ", line, count=1) for line in desk.text.splitlines()]
    text = " ".join(" ".join(map(_plain, lines)).split())
    hints = [hint for name in vars(strings) if name.isupper() for hint in _hints(getattr(strings, name))]
    hints += [f"{{{kind}}} {word}" for kind, word in strings.FOLLOW_UPS.items()]
    hints += [f"{{pane_{name}}} {title}" for name, title in strings.PANES.items()]
    found: dict[str, set[str]] = {}
    for hint in hints:
        actions = [action for action in re.findall(r"{(\w+)}", hint) if action in BY_ID]
        for match in re.finditer(_pattern(desk, hint), text):
            for number, action in enumerate(actions, 1):
                if match[number]:
                    found.setdefault(f"{number}: {match[0].strip()}", set()).add(action)
    for part in desk.app.screen.query(StatusLine):
        line = desk.text.splitlines()[part.region.y] if part.region else ""
        for one in desk.app.shown.hints:
            if one.text.strip() in line:
                found.setdefault(one.text, set()).add(one.action)
    return found


def named(desk: Desk) -> set[str]:
    """The actions whose keys stand on the screen and act."""
    app = desk.app
    return {action for actions in read(desk).values() for action in actions if app.acting(action) is not None}


def listed(desk: Desk) -> set[str]:
    """Those that the help page lists: they act elsewhere."""
    return set(filter(desk.app.possible, BY_ID)) if isinstance(desk.app.screen, HelpScreen) else set()


def _pattern(desk: Desk, hint: str) -> str:
    """What finds a hint on the screen, and which of its keys stand there."""
    pattern, alone = "", len([name for name in re.findall(r"{(\w+)", hint) if name in BY_ID]) == 1
    for part in filter(None, re.split(r"({\w+(?::[^}]*)?})", hint)):
        if part[:1] == "{" and part[1:-1] in BY_ID:
            pattern += _keys_of(desk, part[1:-1]) + ("" if alone else "?") + r"\s*"
        else:
            pattern += ".{1,40}?" if part[:1] == "{" else _words(part)
    return pattern + r"(?!\w)"


def _plain(line: str) -> str:
    return re.sub(r"[│╭╮╰╯─┃┏┓┗┛━]", " ", line)


def _words(part: str) -> str:
    """The words of a hint, wherever the line broke."""
    return r"\s*".join(map(re.escape, part.split())) if part.strip() else r"\s*"


def _keys_of(desk: Desk, action: str) -> str:
    keys = map(shown, desk.app.keys[action].split(","))
    return r"\s*(" + "|".join(map(re.escape, sorted(keys, key=len, reverse=True))) + ")"


@pytest.mark.parametrize("language", ["en", "zh"])
@pytest.mark.parametrize("name", MOMENTS)
async def test_no_key_is_named_that_does_nothing(name: str, language: Language, tmp_path: Path) -> None:
    moment = MOMENTS[name]
    async with _console(moment, language) as desk:
        await _open(desk, moment, tmp_path)
        seen = named(desk)
        dead = [words for words, actions in read(desk).items() if not actions & (seen | listed(desk))]
        assert not dead, desk.text
        assert seen >= set(moment.names), (set(moment.names) - seen, desk.text)
        assert not seen & set(moment.silent), desk.text


@pytest.mark.parametrize("name", MOMENTS)
async def test_keys_that_are_named_do_something(name: str, tmp_path: Path) -> None:
    moment = MOMENTS[name]
    async with _console(moment) as desk:
        await _open(desk, moment, tmp_path)
        pressed = named(desk) & set(moment.names)
        keys = {action: desk.app.acting(action) for action in pressed}
        assert all(keys.values())
    for action, key in keys.items():
        async with _console(moment) as desk:
            await _open(desk, moment, tmp_path)
            before = _all_of(desk)
            written = next(one for one in desk.app.keys[action].split(",") if shown(one) == key)
            await desk.pilot.press(written)
            if desk.app._exit:
                continue
            await _until(desk, lambda before=before: _all_of(desk) != before, f"{key} ({action})")  # type: ignore[misc]


async def _until(desk: Desk, condition: Callable[[], object], what: str) -> None:
    """Some of it is done in a thread, as a disk takes its time."""
    try:
        await desk.until(condition)
    except AssertionError:
        pytest.fail(f"{what} does nothing:\n{desk.text}")


def _all_of(desk: Desk) -> tuple[object, ...]:
    """All that a key can change."""
    app = desk.app
    pages = tuple(map(type, app.screen_stack))
    said = desk.text, app.clipboard, app.main.line.value, app.main.floor.viewport
    return *said, len(desk.engine.sent), len(EXAMINED), pages, app.focused


# Words


def test_no_hint_names_a_key_by_its_usual_name() -> None:
    """A key stands for its action, so that it is the one in use, and is left out where it does nothing."""
    for words in (strings, strings_zh):
        for name in vars(words):
            for hint in _texts(getattr(words, name)) if name.isupper() and not _about_keys(name) else ():
                assert not re.search(r"\b(enter|esc|tab|space|ctrl\+\w)\b|⌫|↑|回车|空格|上键", hint), (name, hint)


def _texts(value: object) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, tuple | list):
        for one in value:
            yield from _texts(one)
    elif isinstance(value, dict):
        for one in value.values():
            yield from _texts(one)


def _about_keys(name: str) -> bool:
    """What a key is called, and what is wrong with one that somebody chose."""
    return name in ("KEY_NAMES", "ABOUT_KEYS") or name.startswith(("KEY_", "NO_KEY"))


async def test_without_a_microphone_the_help_and_the_palette_name_no_key_that_wakes(tmp_path: Path) -> None:
    async with _console(Moment(deaf=True)) as desk:
        await desk.press("question_mark", *"listen")
        assert "Listen now" not in desk.text
        await desk.press("ctrl+u")
        assert "Press space" not in desk.text
        await desk.press("backspace", "ctrl+p", *"listen")
        assert "Listen now" not in desk.text


async def test_a_key_that_can_do_nothing_now_still_says_why() -> None:
    async with _console(Moment(deaf=True)) as desk:
        await desk.press("space")
        assert "Nobody can be heard" in desk.text
        await desk.press("u")
        assert "There is nothing that could be undone" in desk.text
        assert desk.engine.sent == []
