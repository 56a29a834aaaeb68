"""Wherever somebody writes a name that nobody knows, the nearest known one is offered, and by one function."""

from __future__ import annotations

import ast
from collections.abc import Callable
from pathlib import Path

import pytest

import config
import engine
import tui
from config import ConfigError
from config import load as load_settings
from config.nearest import did_you_mean, nearest
from config.schema import KnownPerson
from engine.errors import SaysoError
from engine.plan import parse_calls
from engine.planner.build import build_registry
from engine.planner.unknown_places import NEAR
from engine.planner.worlds.house import build_vocabulary
from engine.robot.description import described
from engine.robot.sim.scene_file import scene_path
from engine.skills.people import People
from tui.checking import wrong_names
from tui.cli import main
from tui.keys.keymap import keymap
from tui.palette.arguments import blanks, nearest_choice

SETTINGS = load_settings(environ={})
PEOPLE = People({"William": KnownPerson()})
HOUSE = build_vocabulary(SETTINGS, people=PEOPLE)
REGISTRY = build_registry(SETTINGS, people=PEOPLE)


def told(ask: Callable[[], object]) -> str:
    """What one is told by an error."""
    with pytest.raises((SaysoError, ConfigError)) as caught:
        ask()
    return str(caught.value)


def resolved(call: str) -> Callable[[], object]:
    return lambda: REGISTRY.resolve(parse_calls(call)[0])


@pytest.mark.parametrize(
    ("ask", "near"),
    [
        (resolved("navigation(kichen)"), "kitchen"),
        (resolved("clean_room(bedrom)"), "bedroom"),
        (resolved("place_object(cofee table)"), "coffee table"),
        (resolved("color_follow(yelow)"), "yellow"),
        (resolved("pick_object(red bx)"), "red box"),
        (resolved("navigatoin(kitchen)"), "navigation"),
        (resolved("move_forward(distnace=1 m)"), "distance"),
        (lambda: PEOPLE.who("Willam"), "William"),
        (lambda: scene_path("flatt"), "flat"),
        (lambda: described("x3pluss"), "x3plus"),
        (lambda: load_settings(overrides=("endpoint.silense_s=1",), environ={}), "endpoint.silence_s"),
        (lambda: load_settings(overrides=("voice.when=alway",), environ={}), "always"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_an_error_about_a_name_offers_the_nearest_one(ask: Callable[[], object], near: str) -> None:
    words = told(ask)
    assert "you mean" in words
    assert near in words.partition("ou mean")[2].partition("?")[0]


EN = ["kitchen", "bedroom", "hall", "stool", "shelf", "bookshelf", "bin", "bed", "bedside table", "exit"]
ZH = ["厨房", "客厅", "卧室", "书房", "厨房门", "书架", "书桌", "餐桌", "床", "出口"]


@pytest.mark.parametrize(
    ("word", "known", "near"),
    [
        ("shelve", EN, "shelf"),
        ("shelfs", EN, "shelf"),
        ("hal", EN, "hall"),
        ("kitchn", EN, "kitchen"),
        ("厨方", ZH, "厨房"),
        ("客听", ZH, "客厅"),
        ("餐卓", ZH, "餐桌"),
        ("书店", ZH, ""),  # study, shelf or desk
        ("浴室", ZH, ""),  # a room of another kind
        ("bathroom", EN, ""),
        ("store", EN, ""),
        ("moon", EN, ""),
        ("hotel", EN, ""),
        ("", EN, ""),
    ],
)
def test_a_short_name_is_near_where_it_begins_alike_and_few_characters_are_wrong(
    word: str, known: list[str], near: str
) -> None:
    assert nearest(word, known, NEAR) == near


@pytest.mark.parametrize(
    ("line", "near"),
    [
        (["transcibe", "x.wav"], "transcribe"),
        (["config", "chek"], "check"),
        (["scene", "list", "--jsn"], "--json"),
        (["models", "path", "whisper-bse"], "whisper-base"),
    ],
)
def test_the_command_line_offers_the_nearest_command_choice_option_or_model(
    line: list[str], near: str, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        code = main(line)
    except SystemExit as left:
        code = int(left.code or 0)
    assert code in (2, 3)
    assert f"Did you mean {near}?" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("setting", "near"),
    [
        ("console.theme=sayso-drk", "sayso-dark"),
        ("robot.scene=flatt", "flat"),
        ("asr.model=whisper-bas", "whisper-base"),
    ],
)
def test_the_check_of_the_configuration_offers_the_nearest_theme_scene_and_model(setting: str, near: str) -> None:
    settings = load_settings(overrides=(setting,), environ={})
    problems = list(wrong_names(settings, config.explain(overrides=(setting,), environ={})))
    assert f"Did you mean {near}?" in "\n".join(map(str, problems))


def test_an_action_of_the_console_that_there_is_not_gets_the_nearest_one() -> None:
    (mistake,) = keymap({"interupt": "x"}).mistakes
    assert "did you mean interrupt?" in mistake.message


def test_a_form_offers_the_nearest_of_what_is_known_and_only_where_nothing_known_begins_so() -> None:
    from engine.offer import offered

    offer = offered(REGISTRY, HOUSE, ("kitchen", "living room"))
    (place,) = blanks(REGISTRY["navigation"], offer)
    assert nearest_choice(place, "kichen") == "kitchen"
    assert nearest_choice(place, "kit") == ""
    assert nearest_choice(place, "") == ""
    assert nearest_choice(place, "somewhere over there") == ""


def test_what_is_like_nothing_gets_no_offer_and_letter_case_does_not_matter() -> None:
    assert nearest("KICHEN", ["kitchen", "hall"]) == "kitchen"
    assert did_you_mean("xyzzy", ["kitchen", "hall"]) == ""
    assert nearest("k" * 100_000, ["kitchen"]) == ""


def test_there_is_one_function_for_it() -> None:
    folders = [Path(package.__file__ or "").parent for package in (config, engine, tui)]
    users = [
        file.name
        for folder in folders
        for file in folder.rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text("utf-8")))
        if (isinstance(node, ast.Import) and any(name.name == "difflib" for name in node.names))
        or (isinstance(node, ast.ImportFrom) and node.module == "difflib")
    ]
    assert users == ["nearest.py"]
