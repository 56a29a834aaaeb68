"""Settings are changed in the console: tried on, tested, written, and taken up at once where that is possible."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from syrupy.assertion import SnapshotAssertion

from config import allowed, load
from config.changing import Layers
from engine import events as ev
from engine.commands import Say, SetVolume
from tests.tui import scripted
from tests.tui.desk import Desk, console
from tests.tui.scripted import ScriptedEngine, flat, robot_at
from tui.kept.tour import Tour
from tui.options import LIVE, SHOWN
from tui.rooms.drawing import CALM_S
from tui.screens.settings import SettingsScreen
from tui.terminal.feed import Feed
from tui.widgets.text_line import TextLine
from tui.words import strings
from tui.words.language import speak

pytestmark = pytest.mark.filterwarnings("ignore:\\s*Can not relate snapshot")  # pictures are named by what they show

SIZES = [(120, 40), (80, 24)]


@asynccontextmanager
async def settings_page(
    folder: Path, *, size: tuple[int, int] = (120, 40), environ: Mapping[str, str] | None = None, **layers: Any
) -> AsyncIterator[Desk]:
    """A console with the page of the settings, whose files are in ``folder``."""
    async with console(size=size) as desk:
        desk.app.dress("sayso-dark", 30, layers=Layers(environ=environ or {}, folder=folder, **layers))
        await desk.press("o")
        await desk.until(lambda: page(desk).meant is not None)
        await desk.settled()
        yield desk


def page(desk: Desk) -> SettingsScreen:
    screen = desk.app.screen
    assert isinstance(screen, SettingsScreen)
    return screen


async def go_to(desk: Desk, key: str) -> None:
    await desk.pilot.press(*["pageup"] * 6, *["down"] * SHOWN.index(key))
    await desk.settled()
    meant = page(desk).meant
    assert meant is not None
    assert meant.key == key


async def kept(desk: Desk, name: str) -> None:
    """Wait until the page says that a setting is written."""
    await desk.until(lambda: f"✓ {name}: saved in" in desk.text)


def written(folder: Path) -> str:
    return (folder / "config.yaml").read_text()


# The page


@pytest.mark.parametrize("size", SIZES, ids=lambda size: "x".join(map(str, size)))
async def test_the_settings_look_as_in_their_picture(
    size: tuple[int, int], screenshot: SnapshotAssertion, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    folder = tmp_path / ".config/sayso"
    folder.mkdir(parents=True)
    (folder / "config.yaml").write_text("# mine\nconsole:\n  fps: 6\n")
    async with settings_page(folder, size=size, environ={"SAYSO_VOICE__VOLUME": "0.5"}) as desk:
        await go_to(desk, "voice.volume")
        for key in SHOWN:
            assert strings.SETTING_NAMES[key] in desk.text
        assert await desk.picture() == screenshot(name=f"settings_{size[0]}x{size[1]}")


async def test_every_setting_says_what_it_means_where_it_comes_from_and_when_it_counts(tmp_path: Path) -> None:
    (tmp_path / "config.yaml").write_text("voice: {when: never}\n")
    async with settings_page(tmp_path, size=(120, 40), overrides=("console.fps=3",)) as desk:
        for key in SHOWN:
            assert f"{key}  " in desk.text
            assert (strings.SETTING_LIVE if key in LIVE else strings.SETTING_RESTART) in desk.text
            await desk.press("down")
        await go_to(desk, "voice.when")
        assert "config.yaml:1" in desk.text
        assert "Which answers are spoken" in desk.text
        await go_to(desk, "console.fps")
        assert "--set console.fps overrides the file: 3 stays in force" in desk.text


async def test_the_page_is_there_in_chinese_too(tmp_path: Path) -> None:
    try:
        async with settings_page(tmp_path, size=(80, 24)) as desk:
            await go_to(desk, "console.language")
            await desk.press("left", "enter")
            await desk.until(lambda: "已保存在" in desk.text)
            await go_to(desk, "audio.device")
            assert "麦克风的名称" in desk.text
            assert "默认" in desk.text
    finally:
        speak("en")


async def test_what_is_half_written_when_the_page_is_left_is_kept_nowhere(tmp_path: Path) -> None:
    async with settings_page(tmp_path) as desk:
        await go_to(desk, "audio.device")
        await desk.press("enter", "slash", "x", "escape", "ctrl+g")
        assert page(desk).meant is not None
        assert "/x" not in desk.text
        await desk.press("ctrl+g")
        assert desk.app.screen is desk.app.main
    assert os.listdir(tmp_path) == []  # noqa: PTH208


async def test_the_keys_of_the_page_can_be_others_and_the_page_says_which(tmp_path: Path) -> None:
    chosen = {"setting_down": "n", "setting_after": "v", "setting_take": "ctrl+k", "setting_default": "x"}
    async with console() as desk:
        desk.app.dress("sayso-dark", 30, keys=chosen, layers=Layers(environ={}, folder=tmp_path))
        await desk.until(lambda: desk.app.shown_keys["setting_down"] == "n")
        await desk.press("o")
        await desk.until(lambda: page(desk).meant is not None)
        assert "ctrl+k changes · s search" in desk.text
        assert "x default" not in desk.text, "it is the default"
        await desk.press("down", "right")  # which are nobody's keys now
        assert page(desk)._at == 0
        assert desk.app.theme == "sayso-dark"
        assert not (tmp_path / "config.yaml").exists()
        await desk.press("v", "ctrl+k")
        await kept(desk, "Theme")
        await desk.settled()
        assert "x default" in desk.text
        await desk.press("n")
        assert page(desk)._at == 1
        await desk.press("up", "x")
        await desk.until(lambda: "theme" not in written(tmp_path))
        await desk.press("question_mark")
        assert desk.text.index("On the page of the settings") < desk.text.index("To begin"), "where one is comes first"
        assert "ctrl+k  Save the value that is shown" in desk.text


async def test_the_palette_leads_to_the_page_and_changes_nothing_by_itself(tmp_path: Path) -> None:
    async with console() as desk:
        desk.app.dress("sayso-dark", 30, layers=Layers(environ={}, folder=tmp_path))
        await desk.press("ctrl+p", *"setting_take", "enter")
        await desk.until(lambda: isinstance(desk.app.screen, SettingsScreen) and page(desk).meant is not None)
        await desk.settled()
        assert not (tmp_path / "config.yaml").exists()


async def test_the_palette_finds_the_settings(tmp_path: Path) -> None:
    async with console() as desk:
        desk.app.dress("sayso-dark", 30, layers=Layers(environ={}, folder=tmp_path))
        await desk.press("ctrl+p", *"settings", "enter")
        await desk.until(lambda: isinstance(desk.app.screen, SettingsScreen))


async def test_nothing_is_saved_where_no_file_says_anything_of_a_setting(tmp_path: Path) -> None:
    async with settings_page(tmp_path) as desk:
        await go_to(desk, "console.theme")
        await desk.press("right", "d")
        await desk.until(lambda: "Theme: as sayso comes with it." in desk.text)
        assert "saved in" not in desk.text
        assert not (tmp_path / "config.yaml").exists()


async def test_settings_that_are_not_read_yet_are_not_made_up() -> None:
    async with console() as desk:
        await desk.press("o", "enter", "right", "down", "d")
        assert "`sayso config check` lists them" in desk.text


def test_nothing_of_the_page_is_read_before_somebody_opens_it() -> None:
    late = "'tui.screens.settings', 'tui.options', 'config.changing'"
    code = f"import sys, tui.app; print([name for name in ({late}) if name in sys.modules])"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "[]"


# Changing


async def test_a_theme_is_tried_on_and_kept_or_let_go(tmp_path: Path) -> None:
    async with settings_page(tmp_path) as desk:
        assert desk.app.theme == "sayso-dark"
        await desk.press("right")
        tried = desk.app.theme
        assert tried != "sayso-dark"
        assert f"‹ {tried} ›" in desk.text
        await desk.press("down")
        assert desk.app.theme == "sayso-dark"
        await desk.press("up", "right", "backspace")
        assert desk.app.theme == "sayso-dark"
        await desk.press("o")
        await desk.until(lambda: page(desk).meant is not None)
        await desk.press("right", "enter", "backspace")
        await desk.until(lambda: (tmp_path / "config.yaml").exists())
        await desk.settled()
        assert desk.app.theme == tried
    assert written(tmp_path) == f"console:\n  theme: {tried}\n"
    assert stat.S_IMODE((tmp_path / "config.yaml").stat().st_mode) == 0o600


async def test_what_is_kept_stands_beside_what_was_written_and_goes_again(tmp_path: Path) -> None:
    mine = "# mine\nconsole:   # look\n  fps: 6   # slow line\nvoice: {when: spoken} # all\n"
    (tmp_path / "config.yaml").write_text(mine)
    async with settings_page(tmp_path) as desk:
        await go_to(desk, "voice.when")
        await desk.press("enter")
        await kept(desk, "Voice")
        assert strings.SETTING_RESTART in desk.text
        assert written(tmp_path) == mine.replace("spoken}", "always}")
        await go_to(desk, "console.fps")
        await desk.press("d")
        await kept(desk, "Frames a second")
        assert written(tmp_path) == mine.replace("spoken}", "always}").replace("  fps: 6   # slow line\n", "")
    assert load(environ={}, user_folder=tmp_path).voice.when == "always"


async def test_what_is_written_in_the_line_is_tested_before_it_is_kept(tmp_path: Path) -> None:
    async with settings_page(tmp_path) as desk:
        await go_to(desk, "voice.volume")
        await desk.press("enter", *["backspace"] * 3, *"7", "enter")
        await desk.until(lambda: "✗" in desk.text and "from 0 up to 1" in desk.text)
        assert not (tmp_path / "config.yaml").exists()
        line = desk.app.screen.query_one(TextLine)
        assert (line.has_focus, line.value) == (True, "7"), "what was refused can be mended"
        await desk.press("backspace", *"0")
        assert "✗" not in desk.text, "why, only for as long as that stands there"
        assert SetVolume(0.3) not in desk.engine.sent
        await desk.press(*".3", "enter")
        await kept(desk, "Volume")
        assert strings.SETTING_LIVE in desk.text
        assert desk.engine.sent == [SetVolume(0.3)], "it counts at once"
        await go_to(desk, "wake.words")
        await desk.press("enter", *["backspace"] * 4, *"hey rosie, hey you", "enter")
        await kept(desk, "Wake words")
        await go_to(desk, "audio.device")
        await desk.press("enter", *"tcp://127.0.0.1:10700", "enter")
        await kept(desk, "Microphone")
    settings = load(environ={}, user_folder=tmp_path)
    assert (settings.voice.volume, settings.wake.words) == (0.3, ("hey rosie", "hey you"))
    assert settings.audio.device == "tcp://127.0.0.1:10700"


async def test_a_variable_that_goes_before_the_file_is_named(tmp_path: Path) -> None:
    async with settings_page(tmp_path, environ={"SAYSO_CONSOLE__THEME": "nord"}) as desk:
        await desk.press("right", "enter")
        await kept(desk, "Theme")
        assert "SAYSO_CONSOLE__THEME overrides the file: nord stays in force" in desk.text
        assert desk.app.theme == "nord"


async def test_a_file_that_cannot_be_written_is_said_and_the_theme_stays(tmp_path: Path) -> None:
    (tmp_path / "config.yaml").symlink_to("/proc/sayso.yaml")  # where nothing can be made
    async with settings_page(tmp_path) as desk:
        await desk.press("right", "enter")
        await desk.until(lambda: "config.yaml could not be written" in desk.text)
        assert desk.app.theme == "sayso-dark"


async def test_the_camera_is_shown_at_once(tmp_path: Path) -> None:
    async with settings_page(tmp_path) as desk:
        await go_to(desk, "console.camera")
        await desk.press("right", "enter")
        await kept(desk, "Camera")
        assert desk.app.main.camera_shown


# Motion


async def test_with_reduced_motion_the_trace_waits_and_what_happens_does_not(tmp_path: Path) -> None:
    engine = ScriptedEngine(robot=robot_at(-1.35, 0.05, 0.4), floor=flat())
    async with console(engine) as desk:
        desk.app.dress("sayso-dark", 30, motion="reduced", layers=Layers(environ={}, folder=tmp_path))
        await desk.until(lambda: desk.app.drawing.calm)
        assert desk.app.animation_level == "none"
        engine.play(scripted.listening()[:-1])
        await desk.settled()
        before, seldom = desk.app.shown.model.trace, desk.app.drawing._seldom
        engine.publish(ev.ListenLevel(-20.0, -10.0, 0.9, in_speech=True))
        await desk.pilot.pause()
        assert desk.app.shown.model.trace is before
        assert seldom._active.is_set()
        engine.publish(ev.Log("info", "engine", "something"))
        await desk.until(lambda: desk.app.shown.model.trace is not before)
        assert not desk.app.drawing._frames._wanted


async def test_with_reduced_motion_pictures_of_the_camera_change_once_a_second() -> None:
    asked: list[None] = []
    async with console() as desk:
        feed = Feed(desk.app, lambda: asked.append(None))
        feed.least = CALM_S
        feed.open()
        feed.drawn(500)
        assert feed._pause == CALM_S
        feed.close()
    assert asked == [None]


async def test_motion_is_reduced_and_given_back_on_the_page(tmp_path: Path) -> None:
    async with settings_page(tmp_path) as desk:
        await go_to(desk, "console.motion")
        await desk.press("enter")
        await kept(desk, "Motion")
        assert desk.app.drawing.calm
        assert desk.app.viewing._feed.least == CALM_S
        await desk.press("d")
        await desk.until(lambda: not desk.app.drawing.calm)
    assert load(environ={}, user_folder=tmp_path).console.motion == "full"


# The tour


@pytest.mark.parametrize("size", SIZES, ids=str)
async def test_the_first_time_three_lines_say_how_to_begin_until_something_was_asked(
    tmp_path: Path, size: tuple[int, int]
) -> None:
    file = tmp_path / "state/toured"
    async with console(size=size) as desk:
        desk.app.dress("sayso-dark", 30, tour=Tour(file))
        await desk.until(lambda: "esc stops the robot at once" in desk.text and "? shows all keys" in desk.text)
        assert not file.exists()
        await desk.press("slash", *"nod", "enter")
        assert desk.engine.sent == [Say("nod")]
        desk.engine.play(scripted.acting())
        await desk.settled()
        assert "esc stops the robot at once" not in desk.text
        await desk.until(file.exists)
    async with console(size=size) as desk:
        desk.app.dress("sayso-dark", 30, tour=Tour(file))
        await desk.until(lambda: desk.app.drawing.tour is not None)
        await desk.settled()
        assert "esc stops the robot at once" not in desk.text
        await desk.press("question_mark")
        assert "esc stops the robot at once" in desk.text


async def test_whoever_has_asked_for_something_before_needs_no_tour(tmp_path: Path) -> None:
    requests = tmp_path / "requests"
    requests.write_text("nod\n")
    assert not Tour(tmp_path / "toured", requests).read()
    assert Tour(tmp_path / "toured", tmp_path / "none").read()


# All of them


async def test_everything_that_can_be_set_is_there_in_groups_and_can_be_searched(tmp_path: Path) -> None:
    async with settings_page(tmp_path) as desk:
        there = {option.key for option in page(desk)._options}
        assert there == set(allowed.settings())
        for heading in strings.SETTING_GROUPS.values():
            await desk.press("pageup")
            for _ in range(len(there) + 1):
                if heading in desk.text:
                    break
                await desk.press(*["down"] * 5)
            assert heading in desk.text, heading
        await desk.press("s", *"silence")
        assert [option.key for option in page(desk)._options if option.key == "endpoint.silence_s"]
        assert all("silence" in f"{one.key} {one.about}".lower() for one in page(desk)._options)
        await desk.press("enter", "s", *"zzz")
        assert strings.NOTHING_FITS in desk.text


async def test_a_setting_that_only_few_change_is_kept_as_well(tmp_path: Path) -> None:
    async with settings_page(tmp_path) as desk:
        await desk.press("s", *"endpoint.silence_s", "enter", "enter", "ctrl+u", *"0.9", "enter")
        await kept(desk, "endpoint.silence_s")
        assert "silence_s: 0.9" in written(tmp_path)


async def test_the_page_refuses_what_the_check_of_the_configuration_refuses(tmp_path: Path) -> None:
    async with settings_page(tmp_path) as desk:
        await desk.press("s", *"robot.scene", "enter", "enter", "ctrl+u", *"flatt", "enter")
        await desk.until(lambda: "did you mean flat" in desk.text.lower())
        assert not (tmp_path / "config.yaml").exists()


async def test_on_the_smallest_terminal_the_page_says_how_to_search(tmp_path: Path) -> None:
    async with settings_page(tmp_path, size=(60, 20)) as desk:
        assert "s search · ⌫ back · esc stops" in desk.text


async def test_what_is_on_or_off_is_told_so_and_enter_changes_it(tmp_path: Path) -> None:
    async with settings_page(tmp_path) as desk:
        await desk.press("s", *"voice.sounds", "enter")
        row = next(line for line in desk.text.splitlines() if "▸ voice.sounds" in line)
        assert "  on  " in row
        await desk.press("enter")
        await kept(desk, "voice.sounds")
        assert load(environ={}, user_folder=tmp_path).voice.sounds is False
        assert "  off  " in next(line for line in desk.text.splitlines() if "▸ voice.sounds" in line)
        await desk.press("enter")
        await desk.until(lambda: load(environ={}, user_folder=tmp_path).voice.sounds is True)


async def test_no_name_runs_into_its_value_and_what_was_saved_is_not_told_of_another_setting(tmp_path: Path) -> None:
    async with settings_page(tmp_path) as desk:
        await desk.press("s", *"console.history", "enter", "enter")
        await kept(desk, "console.history")
        await desk.press("s", *["backspace"] * 30, *"linear_acceleration", "enter")
        assert "saved in" not in desk.text
        assert "linear_acceleration 1.5" in desk.text
