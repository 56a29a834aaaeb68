"""The palette finds everything that can be done, moves no robot by itself, and stops one at every moment."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from textual import events

from config.changing import Layers, described
from engine import events as ev
from engine.commands import EndTask, Interrupt, Quit, Say, Wake
from tests.tui import scripted
from tests.tui.desk import Desk, console
from tests.tui.house import offer
from tests.tui.scripted import PLACES, ScriptedEngine, flat, robot_at
from tui.keys.keys import ALL_KEYS, KEYS
from tui.options import SHOWN
from tui.palette.entries import Change, Entry, Fill, Send, entries, found, nearest
from tui.palette.form import Form
from tui.palette.palette import Palette, PaletteLine
from tui.screens.help import HelpScreen
from tui.screens.settings import SettingsScreen
from tui.screens.turn import TurnScreen
from tui.widgets.ask import Ask
from tui.widgets.floor_view import FloorView
from tui.words import strings
from tui.words.language import Language


def engine_of_the_house() -> ScriptedEngine:
    engine = ScriptedEngine(robot=robot_at(-1.35, 0.05, 0.4), floor=flat())
    engine.offers = offer()
    return engine


def keyed(text: str) -> list[str]:
    names = {" ": "space", "_": "underscore", "-": "minus", ".": "full_stop"}
    return [names.get(char, char) for char in text]


def panel(desk: Desk) -> Palette | None:
    found = desk.app.screen.query(Palette)
    return found.first() if found else None


async def chosen(desk: Desk, typed: str) -> None:
    """Open the palette, type, and choose what stands first."""
    await desk.press("ctrl+p", *keyed(typed), "enter")


def line(desk: Desk) -> Ask:
    return desk.app.screen_stack[0].query_one(Ask)


# What it lists


def listed(recent: tuple[str, ...] = ()) -> tuple[Entry, ...]:
    keys = {key.id: key.key for key in ALL_KEYS}
    file = "/home/me/.config/sayso/config.yaml"
    return entries(keys, PLACES, offer().skills, recent, file, ("sayso-dark", "nord"))


def test_every_action_place_and_skill_has_an_entry() -> None:
    words = {entry.title: entry for entry in listed()}
    for key in ALL_KEYS:
        if key.id != "palette":
            assert any(entry.title == key.about and key.key in entry.beside for entry in listed()), key.id
    for place in PLACES.values():
        assert words[f"go to the {place.name}"].choice == Send(f"go to the {place.name}")
    filled = {entry.choice.skill.name for entry in listed() if isinstance(entry.choice, Fill)}
    assert filled == {skill.name for skill in offer().skills}


def test_every_setting_is_found_by_its_name_its_key_and_what_it_means() -> None:
    for key in SHOWN:
        about = described(tuple(key.split(".")))
        for typed in (key, strings.SETTING_NAMES[key], about):
            assert Change(key) in [entry.choice for entry in found(listed(), typed)[:2]], typed


def test_what_was_asked_for_comes_first_the_newest_once() -> None:
    first = [entry.title for entry in listed(("nod", "dance", "nod"))[:3]]
    assert first == ["nod", "dance", "go to the kitchen"]


@pytest.mark.parametrize(
    ("typed", "first"),
    [
        ("kitchen", "go to the kitchen"),
        ("kit", "go to the kitchen"),
        ("go kit", "go to the kitchen"),
        ("ktchn", "go to the kitchen"),
        ("move_left", "Turn left on the spot by an angle in degrees."),
        ("beep", "Sound the buzzer."),
        ("end_task", "Stop, reset arm and history, and begin a new task."),
        ("camera", "Show what the camera sees, or no longer."),
        ("settings", "Settings: look at them and change them, or leave that page."),
        ("theme", "Setting: Theme"),
        ("wake words", "Setting: Wake words"),
        ("volume", "Setting: Volume"),
        ("audio.device", "Setting: Microphone"),
        ("answers are spoken", "Setting: Voice"),
        ("thm", "Setting: Theme"),
        ("them", "Setting: Theme"),
        ("releas", "Release the emergency stop."),
        ("vlm", "Setting: Volume"),
        ("gttk", "go to the kitchen"),
        ("nord", "Setting: Theme → nord"),
        ("theme dark", "Setting: Theme → sayso-dark"),
        ("camera off", "Setting: Camera → off"),
        ("settings are", "Settings are in /home/me/.config/sayso/config.yaml"),
    ],
)
def test_a_part_of_a_name_finds_it(typed: str, first: str) -> None:
    assert found(listed(), typed)[0].title == first


def test_what_is_called_so_comes_before_what_was_asked_for_and_what_only_speaks_of_it() -> None:
    shown = found(listed(("I said relase it", "please release it")), "release")
    assert [entry.kind for entry in shown[:2]] == ["action", "recent"]
    assert [entry.kind for entry in found(listed(("tell them",)), "them")[:2]] == ["setting", "recent"]


def test_every_word_counts_and_nonsense_finds_nothing() -> None:
    assert found(listed(), "kitchen zzz") == ()
    assert found(listed(), "  ") == listed()


@pytest.mark.parametrize(
    ("typed", "first"),
    [("kitxen", "go to the kitchen"), ("go to the stuty", "go to the study"), ("themme", "Setting: Theme")],
)
def test_what_nothing_fits_comes_near_to_something(typed: str, first: str) -> None:
    assert found(listed(), typed) == ()
    assert nearest(listed(), typed)[0].title == first


def test_what_nothing_comes_near_to_can_still_be_asked_for() -> None:
    [asked] = nearest(listed(), "zzzz qqqq")
    assert asked.choice == Send("zzzz qqqq")


# Opening and leaving


async def test_ctrl_p_opens_the_palette_and_leaves_it_without_stopping_the_robot() -> None:
    async with console(engine_of_the_house()) as desk:
        desk.engine.play(scripted.acting())
        await desk.press("ctrl+p")
        assert panel(desk) is not None
        assert "go to the kitchen" in desk.text
        await desk.press("ctrl+p")
        assert panel(desk) is None
        assert desk.app.focused is None
        assert desk.engine.sent == []


async def test_the_palette_opens_from_everywhere() -> None:
    async with console(engine_of_the_house()) as desk:
        for before in ("slash", "question_mark", "enter", "m", "c"):
            await desk.press(before, "ctrl+p", *"study")
            assert panel(desk) is not None, before
            assert "go to the study" in desk.text, before
            await desk.press("ctrl+g", "ctrl+g")


async def test_the_console_goes_on_around_the_palette() -> None:
    async with console(engine_of_the_house()) as desk:
        await desk.press("ctrl+p", *"zzz")
        desk.engine.play(scripted.acting())
        await desk.until(lambda: "ACTING" in desk.text)
        assert "esc stop" in desk.text


async def test_keys_that_were_typed_ahead_are_looked_for_and_are_no_commands() -> None:
    async with console(engine_of_the_house()) as desk:
        for key, character in (("ctrl+p", None), ("q", "q"), ("e", "e"), ("space", " "), ("slash", "/")):
            desk.app.post_message(events.Key(key, character))  # as a slow link delivers them
        await desk.until(lambda: panel(desk) is not None)
        await desk.settled()
        assert desk.engine.sent == []
        assert "qe /" in desk.text


async def test_a_terminal_that_is_too_small_has_no_palette() -> None:
    async with console(size=(40, 10)) as desk:
        await desk.press("ctrl+p", "ctrl+r", "escape")
        assert panel(desk) is None
        assert desk.engine.sent == [Interrupt()]


async def test_a_resized_terminal_keeps_the_palette_in_sight() -> None:
    async with console(engine_of_the_house()) as desk:
        await desk.press("ctrl+p")
        await desk.pilot.resize_terminal(80, 24)
        await desk.settled()
        here = panel(desk)
        assert here is not None
        assert here.region.right <= 80
        assert here.region.bottom <= 24


# Stopping


async def test_escape_stops_the_robot_from_every_line_of_a_form() -> None:
    async with console(engine_of_the_house()) as desk:
        desk.engine.play(scripted.acting())
        await chosen(desk, "move_left")
        for number, keys in enumerate(((), ("9",), ("tab",), ("x", "enter", "enter")), 1):
            await desk.press(*keys, "escape")
            assert desk.engine.sent == [Interrupt()] * number
            assert desk.app.screen.query(Form)
        await desk.press("ctrl+g", "space")
        assert desk.engine.sent[-1] == Wake("key")


# Choosing


async def test_a_place_is_gone_to_as_if_it_had_been_typed() -> None:
    async with console(engine_of_the_house(), in_line=True) as desk:
        await desk.press(*"dra")
        await chosen(desk, "bedroom")
        assert desk.engine.sent == [Say("go to the bedroom")]
        assert line(desk).value == "dra"
        assert line(desk).has_focus
        await desk.press("up")
        assert line(desk).value == "go to the bedroom", "it is remembered"


async def test_an_earlier_request_goes_into_the_line_to_be_changed() -> None:
    async with console(engine_of_the_house(), in_line=True) as desk:
        await desk.press(*"nod", "enter")
        await chosen(desk, "nod")
        assert line(desk).value == "nod"
        assert desk.engine.sent == [Say("nod")]


async def test_up_and_down_choose_another_one() -> None:
    async with console(engine_of_the_house()) as desk:
        await desk.press("ctrl+p", *"go", "down", "down", "up", "enter")
        assert desk.engine.sent == [Say("go to the living room")]


async def test_an_action_of_the_console_acts_at_once() -> None:
    async with console(engine_of_the_house()) as desk:
        await chosen(desk, "end_task")
        assert desk.engine.sent == [EndTask()]
        await chosen(desk, "wake")
        assert desk.engine.sent == [EndTask(), Wake("key")]
        await chosen(desk, "help")
        await desk.until(lambda: isinstance(desk.app.screen, HelpScreen))
        await chosen(desk, "interrupt")
        assert desk.engine.sent == [EndTask(), Wake("key"), Interrupt()]


async def test_every_action_of_the_console_can_be_chosen() -> None:
    done: list[str] = []
    async with console(engine_of_the_house()) as desk:
        run = desk.app.run_action

        async def recorded(action: str, *where: object) -> bool:
            done.append(action)
            return await run(action, *where)  # type: ignore[arg-type]

        desk.app.run_action = recorded  # type: ignore[method-assign, assignment]
        for key in KEYS:
            if key.id not in ("palette", "leave", "leave_now"):
                await desk.pilot.press("ctrl+p")
                desk.app.screen.query_one(PaletteLine).value = key.about
                await desk.pilot.press("enter")
                assert (key.does or key.id) in done[-2:]
                desk.app.come_back()
                while desk.app.main.panel:
                    await desk.pilot.press("ctrl+g")
        assert desk.engine.sent.count(Wake("key")) == 1


@pytest.mark.parametrize("action", ["leave", "leave_now"])
async def test_the_console_can_be_left_by_the_palette(action: str) -> None:
    async with console(engine_of_the_house()) as desk:
        await desk.press("ctrl+p", *keyed(action))
        await desk.pilot.press("enter")
        await desk.until(lambda: desk.engine.sent == [Quit()])


async def test_an_action_of_the_map_goes_to_the_map() -> None:
    async with console(engine_of_the_house()) as desk:
        await chosen(desk, "map_nearer")
        floor = desk.app.screen.query_one(FloorView)
        assert floor.has_focus
        assert floor.viewport.zoom > 1
        await chosen(desk, "map_whole")
        assert floor.has_focus
        assert floor.viewport.zoom == 1


async def test_an_action_of_the_page_of_a_turn_opens_it() -> None:
    async with console(engine_of_the_house()) as desk:
        desk.engine.play(scripted.done())
        await chosen(desk, "unfold")
        await desk.until(lambda: isinstance(desk.app.screen, TurnScreen))


async def test_a_skill_without_arguments_is_done() -> None:
    async with console(engine_of_the_house()) as desk:
        await chosen(desk, "dance")
        assert desk.engine.sent == [Say("dance()")]


async def test_a_value_of_a_setting_is_kept_at_once_and_that_is_said(tmp_path: Path) -> None:
    async with console(engine_of_the_house()) as desk:
        desk.app.dress("sayso-dark", 30, layers=Layers(environ={}, folder=tmp_path))
        await chosen(desk, "nord")
        await desk.until(lambda: desk.app.theme == "nord")
        await desk.until(lambda: any("Theme: saved in" in told.message for told in desk.app._notifications))
        assert (tmp_path / "config.yaml").read_text() == "console:\n  theme: nord\n"
        await chosen(desk, "voice never")
        await desk.until(lambda: any("started again" in told.message for told in desk.app._notifications))


async def test_a_setting_that_cannot_be_kept_says_why() -> None:
    async with console(engine_of_the_house()) as desk:
        await chosen(desk, "nord")
        await desk.until(lambda: any("config check" in told.message for told in desk.app._notifications))


async def test_the_settings_entry_says_where_they_are() -> None:
    async with console(engine_of_the_house()) as desk:
        await chosen(desk, "settings file")
        await desk.until(lambda: any("config.yaml" in entry.message for entry in desk.app.shown.model.log))


async def test_a_setting_opens_the_page_of_the_settings_at_it(tmp_path: Path) -> None:
    async with console(engine_of_the_house()) as desk:
        desk.app.dress("sayso-dark", 30, layers=Layers(environ={}, folder=tmp_path))
        await chosen(desk, "volume")
        page = desk.app.screen
        assert isinstance(page, SettingsScreen)
        await desk.until(lambda: page.meant is not None)
        assert page.meant is not None
        assert page.meant.key == "voice.volume"
        await desk.press("down", "d")
        assert page.meant.key == "audio.device", "where one goes from there is where one stays"
        await desk.press("o")
        assert desk.app.screen is desk.app.main
        assert desk.engine.sent == []


async def test_the_palette_begins_with_few_earlier_requests_and_then_all_that_can_be_done() -> None:
    async with console(in_line=True) as desk:
        for number in range(9):
            await desk.press(*keyed(f"wait {number}"), "enter")
        await desk.press("ctrl+p")
        shown = desk.app.query_one(Palette).shown
        assert [entry.title for entry in shown[:5]] == [f"wait {number}" for number in (8, 7, 6, 5, 4)]
        assert shown[5].kind != "recent"
        assert [entry.title for entry in shown[-4:]] == [f"wait {number}" for number in (3, 2, 1, 0)]


async def test_the_frame_says_whether_enter_does_it_or_puts_it_into_the_line() -> None:
    async with console(in_line=True) as desk:
        await desk.press(*"nod", "enter", "ctrl+r")
        assert "enter fills the line" in desk.text
        await desk.press("enter")
        assert desk.app.main.line.value == "nod"
        await desk.press("ctrl+u", "ctrl+p")
        assert "enter fills the line" in desk.text
        await desk.press("down")
        assert "enter does it" in desk.text


async def test_several_lines_pasted_into_the_palette_are_refused_and_one_is_taken() -> None:
    async with console(in_line=True) as desk:
        await desk.press("ctrl+p")
        desk.app.query_one(PaletteLine).post_message(events.Paste("nod\nbeep\n"))
        await desk.settled()
        assert desk.app.query_one(PaletteLine).value == ""
        assert [told.message for told in desk.app._notifications] == [strings.PASTED_LINES]
        desk.app.query_one(PaletteLine).post_message(events.Paste("kit\n"))
        await desk.settled()
        assert desk.app.query_one(PaletteLine).value == "kit"


async def test_a_click_chooses() -> None:
    async with console(engine_of_the_house()) as desk:
        await desk.press("ctrl+p", *"bedroom")
        here = panel(desk)
        assert here is not None
        await desk.pilot.click(here.query_one("OptionList"), offset=(3, 0))
        await desk.until(lambda: desk.engine.sent == [Say("go to the bedroom")])


async def test_nothing_that_fits_chooses_nothing() -> None:
    async with console(engine_of_the_house()) as desk:
        await desk.press("ctrl+p", *"zzz", "enter")
        assert "No matches" in desk.text
        assert desk.engine.sent == []
        assert panel(desk) is not None


async def test_what_only_comes_near_is_chosen_by_hand() -> None:
    async with console(engine_of_the_house()) as desk:
        await desk.press("ctrl+p", *"kitxen", "enter")
        assert "No matches; the nearest:" in desk.text
        assert desk.engine.sent == []
        await desk.press("down", "enter")
        assert desk.engine.sent == [Say("go to the kitchen")]
        await desk.press("ctrl+p", *"kitxen", "down", "up", "down", "down", "enter")
        assert len(desk.engine.sent) == 2
        await desk.press("ctrl+p", *"zzz", "down", "enter")
        assert desk.engine.sent[-1] == Say("zzz")


# Forms


async def test_a_form_shows_what_its_arguments_may_be_and_composes_a_request() -> None:
    async with console(engine_of_the_house()) as desk:
        await chosen(desk, "move_left")
        assert "0 to 3600" in desk.text
        assert "angle is missing" in desk.text
        await desk.press(*"90", "enter", *keyed("0.5"))
        await desk.until(lambda: "move_left(angle=90 deg, angular_speed=0.5 rad/s)" in desk.text)
        assert desk.engine.sent == []
        await desk.press("enter")
        assert desk.engine.sent == [Say("move_left(angle=90 deg, angular_speed=0.5 rad/s)")]


async def test_a_form_completes_the_names_of_the_house() -> None:
    async with console(engine_of_the_house()) as desk:
        await chosen(desk, "carry")
        await desk.press(*"red")
        await desk.until(lambda: "red box" in desk.text.split("object")[1].split("\n")[0])
        await desk.press("tab", "tab", *"stu")
        await desk.until(lambda: re.search(r"\bplace .*study", desk.text))
        await desk.press("tab", "enter", "enter")
        assert desk.engine.sent == [Say('carry(object="red box", place="study")')]


async def test_enter_twice_at_once_ends_a_form_of_two_lines() -> None:
    async with console(engine_of_the_house()) as desk:
        await chosen(desk, "move_left")
        for key in ("9", "0", "enter", "enter"):  # as a slow link delivers them
            desk.app.post_message(events.Key(key, key if len(key) == 1 else None))
        await desk.until(lambda: desk.engine.sent)
        assert desk.engine.sent == [Say("move_left(angle=90 deg)")]


async def test_enter_at_the_end_of_a_form_that_is_not_right_goes_to_the_mistake() -> None:
    async with console(engine_of_the_house()) as desk:
        await chosen(desk, "move_left")
        await desk.press(*"9999", "tab", "enter")
        form = desk.app.screen.query_one(Form)
        assert form.query("BlankLine").first().has_focus
        assert "angle must be 0 to 3600 deg" in desk.text
        assert desk.engine.sent == []


# What was asked for before


async def test_ctrl_r_searches_what_was_asked_for() -> None:
    async with console(engine_of_the_house()) as desk:
        await desk.press("slash", *"nod", "enter", *"dance", "enter", *"beep", "enter")
        await desk.press("ctrl+r", *"da")
        here = panel(desk)
        assert here is not None
        assert [entry.title for entry in here.shown] == ["dance"], "and nothing else that could be done"
        await desk.press("enter")
        assert line(desk).value == "dance"


async def test_ctrl_r_begins_with_an_empty_search_and_the_draft_is_there_until_something_is_chosen() -> None:
    async with console(engine_of_the_house()) as desk:
        await desk.press("slash", *"dance", "enter", *"nod", "enter", *"dan", "ctrl+r")
        here = panel(desk)
        assert here is not None
        assert [entry.title for entry in here.shown] == ["nod", "dance"]
        await desk.press("ctrl+r", "c")
        assert line(desk).value == "danc"
        await desk.press("ctrl+r", "enter")
        assert line(desk).value == "nod"


# What it costs


def test_the_palette_is_not_loaded_before_it_is_opened() -> None:
    code = "import sys, tui.app; print([name for name in sys.modules if 'palette' in name or 'option_list' in name])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True)
    assert "tui.palette" not in done.stdout


async def test_the_map_keeps_the_keyboard_and_is_the_pane_that_is_enlarged() -> None:
    async with console(engine_of_the_house()) as desk:
        await desk.press("1", "4", "ctrl+p", "backspace")
        assert desk.app.screen.query_one(FloorView).has_focus
        await chosen(desk, "zoom")
        assert "Map · z back" in desk.text


@pytest.mark.parametrize("language", ["en", "zh"])
@pytest.mark.parametrize("action", ["queue_drop", "queue_earlier", "queue_change", "turn_back", "turn_on", "zoom"])
async def test_what_does_nothing_now_says_so(action: str, language: Language) -> None:
    async with console(engine_of_the_house(), language=language) as desk:
        await chosen(desk, action)
        said = strings.NO_USE.get("queue" if action.startswith("queue") else action)
        if said is None:
            assert desk.app.keeping.told == ""
        else:
            assert said in desk.text.splitlines()[0]


async def test_what_does_nothing_with_what_waits_says_so() -> None:
    async with console(engine_of_the_house()) as desk:
        desk.engine.publish(ev.RequestsWaiting(("nod",), (ev.WaitingRequest("R1", "nod"),)))
        await chosen(desk, "queue_earlier")
        assert strings.NO_USE[""] in desk.text.splitlines()[0]
