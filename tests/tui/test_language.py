"""The console in Chinese: every word has its twin, every column stays where it is, and English pays nothing for it."""

from __future__ import annotations

import ast
import string
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import get_args

import pytest
from rich.cells import cell_len

import tui
from config import load
from engine import events as ev
from engine.han import is_chinese
from engine.perception.memory import World
from engine.skills.outcome import Result
from engine.skills.registry import Skill
from engine.wording import build_wording
from tests.tui import conversation, scripted
from tests.tui.desk import Desk, console
from tests.tui.house import offer
from tests.tui.scripted import ScriptedEngine, flat, robot_at
from tui.doctor.examiner import Examiner
from tui.doctor.finding import Check, Finding
from tui.keys.keys import ALL_KEYS
from tui.options import every
from tui.palette.entries import about_skill
from tui.palette.palette import Palette
from tui.plan.floor import draw, fit
from tui.screens.turn import TurnScreen
from tui.words import strings, strings_zh
from tui.words.language import Language, Telling, chosen, of_environment, speak, told
from tui.words.widths import centred, left, right

SAME = frozenset({"NAME", "GO_TO", "GO_TO_NAMED", "GO_TO_HAN", "RULE_SPEECH", "RULE_QUIET", "FORM_BECOMES"})
"""What is the same in both languages: names, requests, and signs."""
SIZES = [(120, 40), (60, 24)]


@cache
def wording() -> Telling:
    return build_wording(load(environ={})).told


def words_of(module: object) -> dict[str, object]:
    return {name: word for name, word in vars(module).items() if name.isupper()}


def slots(word: str) -> list[str]:
    """What is put into it, with formats; those without names keep their order."""
    return sorted(field for _, field, *_rest in string.Formatter().parse(word) if field is not None)


def texts(word: object) -> Iterator[tuple[object, str]]:
    """The texts of an entry, each with its key."""
    if isinstance(word, str):
        yield "", word
    elif isinstance(word, Mapping):
        yield from word.items()
    elif isinstance(word, tuple):
        for number, part in enumerate(word):
            yield (number, part) if isinstance(part, str) else part


# Words


def test_every_word_has_a_twin_with_the_same_slots() -> None:
    english, chinese = words_of(strings), words_of(strings_zh)
    assert english.keys() - chinese.keys() == SAME
    assert not chinese.keys() - english.keys()
    for name in chinese.keys() - {"PHRASES", "EXAMPLES", "SETTING_ABOUTS"}:
        ours, twins = dict(texts(english[name])), dict(texts(chinese[name]))
        assert ours.keys() == twins.keys(), name
        for key in ours:
            assert slots(ours[key]) == slots(twins[key]), (name, key)
            assert twins[key] or not ours[key], (name, key)


def test_what_a_setting_means_is_told_in_chinese_for_every_setting() -> None:
    assert strings_zh.SETTING_ABOUTS.keys() == set(every())
    for name, about in strings_zh.SETTING_ABOUTS.items():
        assert is_chinese(about), name


def test_every_way_to_a_plan_has_words() -> None:
    assert strings.PLAN_BY.keys() == set(get_args(ev.PlanSource))


def test_every_key_has_a_sentence() -> None:
    assert {key.id for key in ALL_KEYS} == strings.ABOUT_KEYS.keys()


def test_no_word_is_kept_from_the_time_before_the_language_was_known() -> None:
    """What a module or a class keeps, or a parameter has for a default, would stay English."""
    kept = []
    for file in Path(tui.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            early: list[ast.AST] = []
            if isinstance(node, ast.Module | ast.ClassDef):
                early += [part for part in node.body if isinstance(part, ast.Assign | ast.AnnAssign)]
            elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
                early += [part for part in (*node.args.defaults, *node.args.kw_defaults) if part is not None]
            kept += [f"{file.name}: {ast.unparse(part)}" for part in early if _names_a_word(part)]
    assert [line for line in kept if not line.endswith("strings.NAME")] == []


def _names_a_word(node: ast.AST) -> bool:
    attributes = (part for part in ast.walk(node) if isinstance(part, ast.Attribute))
    return any(isinstance(part.value, ast.Name) and part.value.id == "strings" for part in attributes)


# Which language


@pytest.mark.parametrize(
    ("environ", "language"),
    [
        ({"LANG": "zh_CN.UTF-8"}, "zh"),
        ({"LANG": "zh"}, "zh"),
        ({"LANG": "zh_TW.UTF-8", "LC_MESSAGES": "en_GB.UTF-8"}, "en"),
        ({"LANG": "en_GB.UTF-8", "LC_ALL": "zh_CN"}, "zh"),
        ({"LANG": "zh_CN.UTF-8", "LC_ALL": ""}, "zh"),
        ({"LANG": "zha_CN.UTF-8"}, "en"),
        ({"LANG": "C.UTF-8"}, "en"),
        ({}, "en"),
    ],
)
def test_the_environment_names_the_language_as_for_other_programs(environ: dict[str, str], language: str) -> None:
    assert of_environment(environ) == language


def test_the_setting_goes_before_the_language_of_requests_and_that_before_the_environment() -> None:
    chinese, english = {"LANG": "zh_CN"}, {"LANG": "en_GB"}
    assert chosen("en", "zh", chinese) == "en"
    assert chosen("zh", "en", english) == "zh"
    assert chosen("auto", "zh", english) == "zh"
    assert chosen("auto", "auto", chinese) == "zh"
    assert chosen("auto", "auto", english) == "en"


def test_english_reads_nothing_of_chinese() -> None:
    code = "import sys, tui.app, tui.words.language; print(*sys.modules, sep='\\n')"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"tui.words.strings_zh", "engine.wording"} & set(ran.stdout.split())


def test_what_is_spoken_can_be_taken_back() -> None:
    before = words_of(strings)
    try:
        assert speak("zh", wording())
        assert not speak("zh", wording())
        assert (strings.PANES["map"], told("kitchen")) == ("地图", "厨房")
    finally:
        speak("en")
    assert words_of(strings) == before
    assert told("kitchen") == "kitchen"


# On the screen


def widths(desk: Desk) -> set[int]:
    return {cell_len(line) for line in desk.text.splitlines()}


@pytest.mark.parametrize("size", SIZES, ids=str)
async def test_every_line_is_as_wide_as_the_terminal_whatever_is_shown(size: tuple[int, int]) -> None:
    engine = ScriptedEngine(robot=robot_at(-1.35, 0.05, 0.4), floor=flat())
    engine.offers = offer()
    async with console(engine, size=size, language="zh", wording=wording()) as desk:
        conversation.play(engine, conversation.ALL)
        engine.play(scripted.acting())
        await desk.settled()
        for keys in (
            "", "4", "tab", "plus", "f", "backspace", "6", "z", "c", "question_mark", "backspace", "enter", "j",
            "pagedown", "enter", "ctrl+p", "ctrl+g", "slash",
        ):  # fmt: skip
            await desk.press(*filter(None, [keys]))
            assert widths(desk) == {size[0]}, keys


async def test_the_robot_may_stand_on_a_name_of_two_columns_a_character() -> None:
    engine = ScriptedEngine(robot=robot_at(0, 0, 0), floor=flat())
    async with console(engine, language="zh", wording=wording()) as desk:
        frame = desk.app.main.floor._frame
        assert frame is not None
        plan = desk.app.main.floor._cells
        at = [(y, x) for y, row in enumerate(plan) for x, cell in enumerate(row) if not cell.char]
        assert at, "no name is written on the map"
        for row, column in at[:6]:
            for beside in (column - 1, column):
                x, y = frame.left + (beside + 0.5) * frame.cell_width, frame.top - (row + 0.5) * frame.cell_height
                engine.robot = robot_at(x, y, 0.0)
                desk.app.drawing.ask()
                await desk.settled()
                shown = desk.app.main.floor.render_line(row)
                assert shown.cell_length == cell_len(shown.text) == frame.columns
                assert "→" in shown.text


def test_names_on_the_plan_are_written_whole_or_not_at_all() -> None:
    floor = flat()
    try:
        speak("zh", wording())
        for columns in range(10, 70):
            plan = draw(floor, scripted.PLACES, fit(floor, columns, columns // 3))
            for row in plan:
                assert cell_len("".join(cell.char for cell in row)) == columns
    finally:
        speak("en")


async def test_a_place_may_have_a_symbol_of_two_columns() -> None:
    places = {"厨": scripted.PLACES["A"], "室": scripted.PLACES["F"]}
    plan = draw(flat(), places, fit(flat(), 40, 14))
    assert {cell_len("".join(cell.char for cell in row)) for row in plan} == {40}


async def test_a_setting_changes_the_language_of_everything_in_sight_and_back() -> None:
    engine = ScriptedEngine(robot=robot_at(-1.35, 0.05, 0.4), floor=flat())
    async with console(engine) as desk:
        engine.play(scripted.acting())
        await desk.settled()
        english = desk.text
        assert not is_chinese(english)
        desk.app.dress("sayso-dark", 8.0, language="zh", wording=wording())
        await desk.until(lambda: "执行中" in desk.text)
        await desk.settled()
        for words in ("对话", "计划", "动作", "地图", "日志", "各轮", "机器人", "esc 停止", "空格 唤醒", "厨房", "夹爪",
                      "识别", "按 / 输入", "去厨房", "离厨房还有2.9米"):  # fmt: skip
            assert words in desk.text, words
        desk.app.dress("sayso-dark", 8.0, language="en")
        await desk.until(lambda: "ACTING" in desk.text)
        await desk.settled()
        assert desk.text == english


async def test_pages_that_are_open_change_their_language_as_well() -> None:
    async with console() as desk:
        conversation.play(desk.engine, conversation.ALL)
        await desk.settled()
        await desk.press("enter")
        assert isinstance(desk.app.screen, TurnScreen)
        count = len(conversation.ALL)
        desk.app.speak("zh", wording())
        await desk.until(lambda: f"第 {count} 轮，共 {count} 轮" in desk.text and "思考" in desk.text)
        await desk.press("enter", "question_mark")
        assert "立即停止一切" in desk.text
        desk.app.speak("en")
        await desk.until(lambda: "Stop everything at once" in desk.text)


async def test_what_the_engine_says_in_english_is_told_in_chinese() -> None:
    async with console(language="zh", wording=wording()) as desk:
        engine = desk.engine
        engine.publish(ev.StateChanged("ACTING", "WAITING", "x", ev.TurnResult(1, "failed", "I am at the kitchen.")))
        engine.publish(ev.ErrorRaised("path_blocked", "No way leads there.", "No way leads there."))
        engine.publish(ev.PlanRejected("x", "No way leads there.", "y"))
        engine.publish(ev.TaskEnded("asked"))
        await desk.until(lambda: "我到厨房了。" in desk.text and desk.text.count("没有路能到那里。") >= 2)
        assert "新任务  按要求" in desk.text


async def test_the_map_sends_one_to_a_place_in_chinese_words() -> None:
    async with console(language="zh", wording=wording()) as desk:
        await desk.press("m", "tab", "enter")
        assert "去厨房吗？" in desk.text
        await desk.press("enter")
        assert [command.text for command in desk.engine.sent if hasattr(command, "text")] == ["去厨房"]


async def test_the_palette_finds_skills_by_both_languages() -> None:
    engine = ScriptedEngine(robot=robot_at(0, 0, 0), floor=flat(), seen=World())
    engine.offers = offer()
    async with console(engine, language="zh", wording=wording()) as desk:
        for typed in ("点头", "nod"):
            await desk.press("ctrl+p", *typed)
            assert "用手臂点头，表示是。" in desk.text
            await desk.press("ctrl+g")


async def test_what_begins_so_comes_first_in_the_palette_also_where_english_is_typed() -> None:
    engine = ScriptedEngine(robot=robot_at(0, 0, 0), floor=flat())
    engine.offers = offer()
    async with console(engine, language="zh", wording=wording()) as desk:
        await desk.press("ctrl+p", *"them")
        palette = desk.app.screen.query_one(Palette)
        assert palette.shown[0].title == "设置：主题"


async def test_whatever_the_palette_says_of_skills_is_chinese_and_so_is_their_form() -> None:
    engine = ScriptedEngine(robot=robot_at(0, 0, 0), floor=flat())
    engine.offers = offer()
    async with console(engine, language="zh", wording=wording()) as desk:
        await desk.press("ctrl+p")
        palette = desk.app.screen.query_one(Palette)
        skills = [entry for entry in palette._entries if entry.kind == "skill"]
        assert len(skills) > 40
        assert [entry.title for entry in skills if not is_chinese(entry.title)] == []
        await desk.press(*"move_left", "enter")
        await desk.until(lambda: "原地左转一个角度（度）。" in desk.text)


def test_a_skill_that_nobody_has_put_into_chinese_keeps_its_sentence() -> None:
    async def run(context: object) -> Result:
        raise NotImplementedError

    try:
        speak("zh", wording())
        mine = Skill("circle", "Drive in a circle.", (), frozenset(), run)
        assert about_skill(mine) == "Drive in a circle."
        assert about_skill(replace(mine, name="arm_nod")) == "点头 · Drive in a circle."
    finally:
        speak("en")


async def test_the_log_is_told_in_chinese_with_who_tells_it() -> None:
    async with console(size=(200, 50), language="zh", wording=wording()) as desk:
        desk.engine.play(scripted.OPENING)
        desk.engine.publish(
            ev.Log(
                "warning",
                "engine",
                "The engine did not respond for 2.5 s. A robot that was moving has stopped by itself.",
            )
        )
        await desk.settled()
        for words in ("会话 sayso 0.1.0，模拟机器人（flat）", "机器人 就绪：模拟机器人（flat）", "规划 就绪",
                      "识别 就绪：whisper-base", "引擎 引擎2.5秒没有响应。正在移动的机器人已自己停下。"):  # fmt: skip
            assert words in desk.text, words


async def test_the_doctor_finds_in_chinese() -> None:
    findings = (
        Finding("python", "ok", "3.12.1, 2 cores"),
        Finding("scheduling", "limited", "real-time priority is switched off (robot.realtime_priority)"),
        Finding("voice", "limited", "espeak-ng; piper sounds better in English", "pip install 'sayso[voice]'"),
        Finding("graphics", "limited", "no OpenGL: camera 160×120 by ray casting", "apt install libosmesa6"),
        Finding("serial ports", "limited", "none: no wake module attached"),
        Finding(
            "microphone",
            "missing",
            "There is no microphone.",
            "Check that it is plugged in. sayso keeps looking for it.",
        ),
    )
    async with console(language="zh", wording=wording()) as desk:
        checks = [Check(one.name, lambda settings, one=one: one) for one in findings]  # type: ignore[misc]
        desk.app.examining.know(lambda: Examiner(load(environ={}), checks=checks))
        await desk.press("d")
        await desk.until(lambda: "3 受限" in desk.text or "4 受限" in desk.text)
        for words in ("3.12.1，2个核", "实时优先级已关闭", "英语用piper更好听", "没有OpenGL：相机160×120，用光线投射",
                      "没有：未接唤醒模块", "没有麦克风。", "sayso会一直找它"):  # fmt: skip
            assert words in desk.text, words


@pytest.mark.parametrize("size", SIZES, ids=str)
async def test_no_character_is_torn_where_something_ends_under_a_panel(size: tuple[int, int]) -> None:
    engine = ScriptedEngine(robot=robot_at(0, 0, 0), floor=flat())
    engine.offers = offer()
    async with console(engine, size=size, language="zh", wording=wording()) as desk:
        conversation.play(engine, conversation.ALL)
        await desk.press("ctrl+p")
        palette = desk.app.screen.query_one(Palette)
        whole = [*(entry.title[:12] for entry in palette.shown[:6]), "回车执行 · ⌫ 返回 · esc 停止"]
        for words in whole:
            assert words in desk.text
        for _ in range(3):
            await desk.press("down")
            assert all(words in desk.text for words in whole)


# Columns


@pytest.mark.parametrize("text", ["", "map", "地图", "a地b", "é", "很长的一行文字"])
@pytest.mark.parametrize("columns", [1, 5, 6, 9])
def test_text_is_put_into_columns(text: str, columns: int) -> None:
    wanted = max(columns, cell_len(text))
    assert cell_len(left(text, columns)) == cell_len(right(text, columns)) == wanted
    assert cell_len(centred(text, columns)) == columns
    if text.isascii() and len(text) <= columns:
        assert centred(text, columns) == text.center(columns)


def test_languages_are_those_of_the_setting() -> None:
    for language in ("en", "zh"):
        spoken: Language = load(overrides=(f"console.language={language}",), environ={}).console.language  # type: ignore[assignment]
        assert spoken == language
