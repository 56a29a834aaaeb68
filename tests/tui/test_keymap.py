"""Keys that somebody chose: those that can be had are used, the others are reported with what to do."""

from __future__ import annotations

from pathlib import Path

import pytest

from engine.commands import Interrupt, Wake
from tests.tui.desk import console
from tui.commands.config import config_check
from tui.keys.keymap import GROUPS, keymap
from tui.keys.keys import ALL_KEYS


def complaints(chosen: dict[str, str]) -> dict[str, str]:
    return {mistake.action: mistake.message for mistake in keymap(chosen).mistakes}


def test_the_usual_keys_have_no_conflict_and_arrive_from_every_terminal() -> None:
    usual = {key.id: key.key for group in GROUPS for key in group}
    found = keymap(usual)
    assert found.mistakes == ()
    assert found.keys == usual


def test_a_chosen_key_replaces_the_usual_one() -> None:
    found = keymap({"wake": "w", "palette": "Ctrl-K", "help": "f1", "log": "&"})
    assert found.mistakes == ()
    assert found.keys["wake"] == "w"
    assert found.keys["palette"] == "ctrl+k"
    assert found.keys["help"] == "f1"
    assert found.keys["log"] == "ampersand"
    assert found.keys["interrupt"] == "escape"


def test_two_actions_may_exchange_their_keys() -> None:
    found = keymap({"wake": "e", "end_task": "space"})
    assert found.mistakes == ()
    assert (found.keys["wake"], found.keys["end_task"]) == ("e", "space")


def test_a_key_that_another_action_has_is_refused_and_the_action_keeps_its_own() -> None:
    found = keymap({"wake": "e"})
    assert found.keys["wake"] == "space"
    [mistake] = found.mistakes
    assert mistake.action == "wake"
    assert "end_task" in mistake.message


def test_of_two_that_want_the_same_key_the_first_gets_it() -> None:
    found = keymap({"camera": "C", "log": "C"})
    assert (found.keys["camera"], found.keys["log"]) == ("C", "l")
    assert [mistake.action for mistake in found.mistakes] == ["log"]


def test_no_map_page_or_hand_takes_the_keys_that_go_back() -> None:
    for action in ("map_whole", "unfold", "hand_ahead", "setting_take", "log"):
        for key in ("backspace", "ctrl+g"):
            assert "is the key of back" in complaints({action: key})[action]
    assert complaints({"back": "ctrl+l"}) == {}
    assert "map_follow" in complaints({"back": "f"})["back"]


def test_keys_of_the_map_go_before_those_of_the_console_but_not_before_those_that_act_everywhere() -> None:
    assert complaints({"map_whole": "c"}) == {}
    assert "interrupt" in complaints({"map_whole": "escape"})["map_whole"]
    assert "map_follow" in complaints({"map_whole": "f"})["map_whole"]


@pytest.mark.parametrize(
    ("action", "key", "complaint"),
    [
        ("interupt", "f2", "did you mean interrupt?"),
        ("fly", "f2", "interrupt, back, wake"),
        ("log", "", "no key"),
        ("log", "alt+l", "does not work in every terminal"),
        ("log", "ctrl+shift+l", "does not work in every terminal"),
        ("log", "ctrl+i", "from tab"),
        ("log", "hyper", "is not a key"),
        ("interrupt", "x", "must stay free for typing"),
        ("interrupt", "?", "must stay free for typing"),
        ("newer", "enter", "must stay free for typing"),
    ],
)
def test_a_key_that_cannot_be_had_is_reported(action: str, key: str, complaint: str) -> None:
    found = keymap({action: key})
    assert complaint in found.mistakes[0].message
    assert found.keys == keymap({}).keys


def test_a_key_that_is_not_sent_everywhere_is_fine_beside_one_that_is() -> None:
    assert complaints({"log": "alt+l,L"}) == {}


def test_the_configuration_check_names_file_line_and_remedy(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("console:\n  keys:\n    wake: e\n    log: f5\n    camera: alt+c\n")
    assert config_check([file]) == 2
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith(f"{file}:3: console.keys.wake: e is the key of end_task; choose another")
    assert lines[1].startswith(f"{file}:5: console.keys.camera: alt+c does not work")
    assert len(lines) == 2


def test_a_configuration_with_good_keys_is_right(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("console: {keys: {wake: w, palette: ctrl+k}}\n")
    assert config_check([file]) == 0


async def test_the_console_uses_the_keys_of_the_settings_and_shows_them() -> None:
    async with console() as desk:
        desk.app.dress("sayso-dark", 30, keys={"interrupt": "f2", "wake": "w", "turn_back": "b"})
        await desk.until(lambda: "f2 stop" in desk.text)
        await desk.press("f2", "w", "space")
        assert desk.engine.sent == [Interrupt(), Wake("key")]
        await desk.press("question_mark")
        await desk.until(lambda: "  w  Listen now" in desk.text)
        await desk.press(*"turn_back")
        assert "  b  Look at the turn before" in desk.text


async def test_what_is_wrong_with_the_keys_stands_in_the_log_and_nothing_is_lost() -> None:
    async with console() as desk:
        desk.app.dress("sayso-dark", 30, keys={"interrupt": "space", "fly": "f9"})
        await desk.until(lambda: len([line for line in desk.app.shown.model.log if line.source == "console"]) == 2)
        words = [line.message for line in desk.app.shown.model.log]
        assert any("console.keys.interrupt" in text and "interrupt keeps esc" in text for text in words)
        assert any("console.keys.fly: there is no such action" in text for text in words)
        await desk.press("escape")
        assert desk.engine.sent == [Interrupt()]


async def test_the_help_page_has_every_action_with_its_key_and_can_be_scrolled() -> None:
    async with console(size=(80, 24)) as desk:
        await desk.press("question_mark")
        await desk.until(lambda: "tab goes to the panes" in desk.text)
        seen = desk.text
        for _ in range(8):
            await desk.press("pagedown")
            seen += desk.text
        for key in ALL_KEYS:
            assert key.about[:40] in seen, key.id
        await desk.press(*["pageup"] * 9)
        assert "tab goes to the panes" in desk.text
