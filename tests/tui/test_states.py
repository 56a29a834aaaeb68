"""Every state and every screen of the console looks as it looked, at three sizes, dark and light.

A state is a moment of a real session that was recorded; each has one sheet with six pictures of it. After a change that
is meant: ``pytest tests/tui/test_states.py --snapshot-update``, and look at the sheets in ``screenshots/states/``.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import get_args

import pytest
from syrupy.assertion import SnapshotAssertion

from config import load
from config.changing import Layers
from engine import events as ev
from engine.handle import PartStatus
from tests.tui.desk import Desk, console
from tests.tui.house import offer
from tests.tui.replay import Replay, read
from tests.tui.sheets import Shot, sheet_of, shot_of
from tests.tui.test_replay import WHOLE_TASK
from tui.doctor.examiner import Examiner
from tui.doctor.finding import Check, Finding
from tui.screens.doctor import DoctorScreen
from tui.screens.settings import SettingsScreen
from tui.shown.watchdog import SILENT_S

pytestmark = pytest.mark.filterwarnings("ignore:\\s*Can not relate snapshot")  # sheets are named by what they show

SIZES = ((120, 40), (80, 24), (60, 16))
THEMES = ("sayso-dark", "sayso-light")


@dataclass(frozen=True, slots=True)
class Moment:
    """When a picture is taken: after so many events of this kind for which ``met`` holds, and after these keys."""

    told: type[ev.Body]
    met: Callable[..., object] = lambda body: True
    keys: tuple[str, ...] = field(default=())


def enters(state: ev.State) -> Callable[[ev.StateChanged], bool]:
    return lambda body: body.state == state


READY = Moment(ev.Log, lambda body: body.source == "recogniser")
ON_ITS_WAY = Moment(ev.ActionProgress, lambda body: body.name == "navigation" and (body.fraction or 0) > 0.5)
OVER = Moment(ev.StateChanged, lambda body: body.result is not None and body.result.outcome == "interrupted")

STATES: dict[str, Moment] = {
    "IDLE": READY,
    "LISTENING": Moment(ev.TranscriptPartial, lambda body: body.stable_words),
    "TRANSCRIBING": Moment(ev.StateChanged, enters("TRANSCRIBING")),
    "DECIDING": Moment(ev.StateChanged, enters("DECIDING")),
    "PLANNING": Moment(ev.StateChanged, lambda body: (body.previous, body.state) == ("DECIDING", "PLANNING")),
    "CLARIFYING": Moment(ev.SpeechStarted, lambda body: body.text.startswith("Which")),
    "SPEAKING": Moment(ev.SpeechStarted, lambda body: body.text.startswith("I won't")),
    "ACTING": ON_ITS_WAY,
    "FEEDBACK": Moment(ev.StateChanged, lambda body: (body.state, body.reason) == ("FEEDBACK", "not done")),
    "WAITING": OVER,
}
"""When the recorded session is in each state."""
TROUBLE: dict[str, Moment] = {
    "loading": Moment(ev.SessionStarted),
    "ended": Moment(ev.SessionEnded),
    "robot lost": ON_ITS_WAY,
    "engine hangs": ON_ITS_WAY,
    "microphone lost": READY,
    "estop": OVER,
}
"""What is no state of the session."""
SCREENS: dict[str, Moment] = {
    "help": Moment(ON_ITS_WAY.told, ON_ITS_WAY.met, ("question_mark",)),
    "by hand": Moment(OVER.told, OVER.met, ("g", "plus")),
    "turn": Moment(OVER.told, OVER.met, ("enter",)),
    "palette": Moment(ON_ITS_WAY.told, ON_ITS_WAY.met, ("ctrl+p",)),
    "form": Moment(ON_ITS_WAY.told, ON_ITS_WAY.met, ("ctrl+p", *"carry", "enter", *"red", "tab", "tab", *"kit")),
}


def robot_lost(engine: Replay) -> None:
    engine.part(PartStatus("robot", "failed", "The robot process does not answer."))
    words = ("The robot process does not answer any more (no state for 1.0 s).", "Quit and start sayso again.")
    engine.publish(ev.ErrorRaised("robot_lost", *words, fatal=True))


def engine_hangs(engine: Replay) -> None:
    engine.silence = SILENT_S + 1


def microphone_lost(engine: Replay) -> None:
    engine.part(PartStatus("microphone", "missing", "It was unplugged."))
    words = ("The microphone was unplugged.", "Typing goes on. It is looked for until it is back.")
    engine.publish(ev.ErrorRaised("device_lost", *words))


def estop(engine: Replay) -> None:
    assert engine.robot is not None, "the recording has moved it"
    engine.robot = replace(engine.robot, estop=True)
    engine.publish(ev.InterruptRaised("estop", "estop", "WAITING"))


HAPPENS: dict[str, Callable[[Replay], None]] = {
    "robot lost": robot_lost,
    "engine hangs": engine_hangs,
    "microphone lost": microphone_lost,
    "estop": estop,
}
"""What happens then that no recording tells."""
FINDINGS = (
    Finding("python", "ok", "3.13.1, 2 cores"),
    Finding("voice", "limited", "espeak; piper sounds better", "sayso models pull piper"),
    Finding("camera", "missing", "no picture within 5 s", "Set robot.camera to rays.", needed=True),
)


async def settings_open(desk: Desk, folder: Path) -> None:
    desk.app.dress("sayso-dark", 30, layers=Layers(environ={"SAYSO_VOICE__VOLUME": "0.5"}, folder=folder))
    await desk.press("o")
    await desk.until(lambda: isinstance(desk.app.screen, SettingsScreen) and desk.app.screen.meant is not None)


async def doctor_open(desk: Desk, folder: Path) -> None:
    checks = [Check(found.name, lambda settings, found=found: found) for found in FINDINGS]  # type: ignore[misc]
    desk.app.examining.know(lambda: Examiner(load(environ={}), checks=checks))
    await desk.press("d")
    await desk.until(lambda: "Set robot.camera to rays" in desk.text)
    await desk.until(lambda: isinstance(desk.app.screen, DoctorScreen) and not desk.app.screen.is_examining)


OPENED: dict[str, Callable[[Desk, Path], Awaitable[None]]] = {"settings": settings_open, "doctor": doctor_open}
"""Screens that show something of this machine."""
MOMENTS = STATES | TROUBLE | SCREENS | dict.fromkeys(OPENED, READY)


def test_every_state_has_a_picture() -> None:
    assert set(STATES) == set(get_args(ev.State))


@pytest.mark.parametrize("name", MOMENTS)
async def test_it_looks_as_on_its_sheet(
    name: str, screenshot: SnapshotAssertion, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("SAYSO_CONFIG_DIR", "/home/me/.config/sayso")  # which the palette tells
    async with _at(name, tmp_path) as desk:
        shots = [await _shots(desk, theme) for theme in THEMES]
    dark, light = ([shot.text for shot in row] for row in shots)
    changed = [rows for both in zip(dark, light, strict=True) for rows in zip(*map(str.splitlines, both), strict=True)]
    assert [rows for rows in changed if len(set(rows)) > 1] == [], "a theme changes colours only"
    assert sheet_of([[row[0] for row in shots], [shot for row in shots for shot in row[1:]]]) == screenshot(
        name=f"states/{name.lower().replace(' ', '_')}"
    )


@asynccontextmanager
async def _at(name: str, folder: Path) -> AsyncIterator[Desk]:
    """A console at that moment."""
    replay, moment = Replay(read(WHOLE_TASK)), MOMENTS[name]
    replay.offers = offer()
    async with console(replay, in_line=not moment.keys and name not in OPENED) as desk:
        replay.until(moment.told, moment.met)
        await desk.until(lambda: desk.app.shown.parts == replay.parts)
        await desk.press(*moment.keys)
        if name in OPENED:
            await OPENED[name](desk, folder)
        if name in HAPPENS:
            HAPPENS[name](replay)
            told = (lambda: desk.shown_problem) if name != "estop" else (lambda: "E-STOP" in desk.text)
            await desk.until(lambda: told() and desk.app.shown.parts == replay.parts)
        yield desk


async def _shots(desk: Desk, theme: str) -> list[Shot]:
    """It at every size."""
    desk.app.theme = theme
    shots = []
    for columns, rows in SIZES:
        await desk.pilot.resize_terminal(columns, rows)
        await desk.picture()
        shots.append(shot_of(desk.app, f"{columns}×{rows} {theme}"))
    return shots
