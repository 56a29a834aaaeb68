"""Plain commands in Chinese become plans, as the English ones do; everything else is not guessed."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from config import load as load_settings
from engine.errors import PlanError
from engine.han import is_chinese
from engine.perception.naming import UnknownObject, wanted
from engine.plan import Quantity
from engine.planner.build import build_registry
from engine.planner.phrases.meanings import INTENTS
from engine.planner.phrases.phrases import Matched, NoMatch, PhrasePlanner, UnknownPlace
from engine.planner.text.language import all_phrases, language_of, load
from engine.planner.text.words import digits
from engine.planner.worlds.house import build_vocabulary
from engine.skills.vocabulary import Ambiguous
from tests.unit.test_phrases import shown

SETTINGS = load_settings(environ={})
VOCABULARY = build_vocabulary(SETTINGS)
REGISTRY = build_registry(SETTINGS)
PLANNER = PhrasePlanner(SETTINGS.places, "zh", vocabulary=VOCABULARY, skills=REGISTRY)
SCENES = Path(__file__).parents[2] / "assets" / "scenes"


def plan(text: str) -> str:
    """The actions of a plan, all of which the robot can do; fails when ``text`` makes none."""
    found = PLANNER.plan(text)
    assert isinstance(found, Matched), f"{text!r}: {found}"
    assert found.kind == "plan"
    assert len(found.steps) == len(found.calls)
    for call in found.calls:
        REGISTRY.resolve(call)
    return "; ".join(map(shown, found.calls))


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("前进一米", "move_forward(1)"),
        ("向前走半米", "move_forward(0.5)"),
        ("往前走一米五", "move_forward(1.5)"),
        ("前进１.5米", "move_forward(1.5)"),
        ("一直向前走大约两米", "move_forward(2)"),
        ("走两米", "move_forward(2)"),
        ("再往前走一米", "move_forward(1)"),
        ("后退30厘米", "move_forward(-0.3)"),
        ("請向後退半公尺", "move_forward(-0.5)"),
        ("往后退一米左右", "move_forward(-1)"),
        ("向左移动20厘米", "move_sideways(0.2)"),
        ("左移半米", "move_sideways(0.5)"),
        ("向右平移0.5米", "move_sideways(-0.5)"),
        ("向前以每秒零点三米的速度走两米", "move_forward(2, 0.3)"),
        ("以每秒0.2米的速度前进3秒", "set_cmdvel(0.2, 0, 0, 3)"),
        ("后退两秒", "set_cmdvel(-0.3, 0, 0, 2)"),
        ("向左走三秒", "set_cmdvel(0, 0.3, 0, 3)"),
        ("走一个边长一米的正方形", "; ".join(["move_forward(1); move_left(90)"] * 4)),
    ],
)
def test_distances_and_velocities_are_driven_as_said(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("左转九十度", "move_left(90)"),
        ("向右转45°", "move_right(45)"),
        ("左转90", "move_left(90)"),
        ("向左轉九十度", "move_left(90)"),
        ("逆时针旋转半圈", "move_left(180)"),
        ("顺时针转一圈", "move_right(360)"),
        ("向左转四分之一圈", "move_left(90)"),
        ("左转", "move_left(90)"),
        ("往右拐", "move_right(90)"),
        ("转身", "move_left(180)"),
        ("向后转", "move_left(180)"),
        ("掉头", "move_left(180)"),
        ("转180度", "move_left(180)"),
        ("原地转一圈", "move_left(360)"),
        ("转个圈", "move_left(360)"),
        ("左转90度三次", "move_left(90); move_left(90); move_left(90)"),
        ("向左转3秒", "set_cmdvel(0, 0, 1, 3)"),
        ("以每秒0.5弧度向右转4秒", "set_cmdvel(0, 0, -0.5, 4)"),
    ],
)
def test_turns_are_to_the_side_and_by_the_angle_that_was_said(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    ("said", "symbol"),
    [
        ("去厨房", "A"),
        ("去厨房！！", "A"),
        ("请你去厨房好吗", "A"),
        ("你能去厨房吗？", "A"),
        ("麻烦你去一下厨房，谢谢", "A"),
        ("好的。请去厨房吧。", "A"),
        ("快去厨房", "A"),
        ("去去厨房", "A"),
        ("去「厨房」", "A"),
        ("去 kitchen", "A"),
        ("到客厅去", "B"),
        ("去living room", "B"),
        ("去B点", "B"),
        ("回卧室", "C"),
        ("走到书房里", "D"),
        ("去充电", "F"),
        ("前往沙发旁边", "H"),
        ("去桌子那里", "I"),
        ("到廚房門口去", "T"),
        ("回来", "zero"),
        ("返回起点", "zero"),
        ("回到刚才记住的位置", "zero"),
    ],
)
def test_places_are_found_by_their_names_in_both_languages(said: str, symbol: str) -> None:
    assert plan(said) == f"navigation({symbol})"


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("巡逻", "patrol()"),
        ("在全屋巡逻一圈", "patrol()"),
        ("巡逻厨房、客厅和书房", "patrol(A,B,D)"),
        ("在厨房和客厅之间来回走", "patrol(A,B)"),
        ("记住这个位置", "get_current_pose()"),
        ("举起手臂", "arm_up()"),
        ("把手抬起来", "arm_up()"),
        ("放下手臂", "arm_down()"),
        ("点点头", "arm_nod()"),
        ("点三下头", "arm_nod(); arm_nod(); arm_nod()"),
        ("摇头", "arm_shake()"),
        ("挥挥手", "arm_shake()"),
        ("请鼓掌", "arm_applaud()"),
        ("给我跳支舞", "dance()"),
        ("漂移一下", "drift()"),
        ("等十秒", "wait(10)"),
        ("停五秒", "wait(5)"),
        ("等一分三十秒", "wait(90)"),
        ("鸣笛", "beep()"),
        ("鸣笛三声", "beep(); beep(); beep()"),
        ("鸣笛两秒", "beep(2)"),
        ("开灯", "light(white)"),
        ("把灯关掉", "light(off)"),
        ("把灯变成红色", "light(red)"),
        ("亮紫灯", "light(purple)"),
        ("你现在在哪里？", "report_pose()"),
        ("请告诉我你在哪里", "report_pose()"),
        ("报告位置", "report_pose()"),
        ("你能做什么", "list_skills()"),
        ("帮助", "list_skills()"),
        ("说你好", "say(你好)"),
        ("说“你好，世界”", "say(你好，世界)"),
        ("說飯好了", "say(飯好了)"),
        ("张开夹爪", "open_gripper()"),
        ("松手", "open_gripper()"),
        ("合上夹爪", "close_gripper()"),
        ("把一号舵机转到四十五度", "servo1_move(45)"),
    ],
)
def test_the_other_skills_have_their_words(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("拿起红盒子", "pick_object(red box)"),
        ("帮我拿起红色的盒子", "pick_object(red box)"),
        ("把那个绿色的盒子拿起来", "pick_object(green box)"),
        ("拿个杯子", "pick_object(cup)"),
        ("抓住3号块", "pick_object(block 3)"),
        ("拿起三号积木", "pick_object(block 3)"),
        ("捡起地上的球", "pick_object(ball)"),
        ("拿桌上的红盒子", "navigation(I); pick_object(red box)"),
        ("去厨房拿杯子", "navigation(A); pick_object(cup)"),
        ("把它放到桌子上", "place_object(dining table)"),
        ("放到桌上", "place_object(dining table)"),
        ("放到地上", "place_object(floor)"),
        ("把它扔进垃圾桶", "place_in_bin()"),
        ("放下", "putdown()"),
        ("把它放在这里", "putdown()"),
        ("把红盒子放在茶几上", "pick_object(red box); place_object(coffee table)"),
        ("把红盒子扔进垃圾桶里", "pick_object(red box); place_in_bin()"),
        ("把杯子扔掉", "pick_object(cup); place_in_bin()"),
        ("把红盒子放到厨房里", "carry(red box, A)"),
        ("把红盒子拿到厨房", "carry(red box, A)"),
        ("幫我把紅色盒子拿到廚房裡", "carry(red box, A)"),
        ("把餐桌上的红盒子拿到厨房", "carry(red box, A, dining table)"),
        ("把红盒子从餐桌上拿到厨房", "carry(red box, A, dining table)"),
        ("给我拿瓶子", "carry(bottle, zero)"),
        ("把瓶子拿给我", "carry(bottle, zero)"),
        ("去厨房给我拿个杯子", "carry(cup, zero, kitchen)"),
        ("去厨房拿一个杯子过来", "carry(cup, zero, kitchen)"),
        ("拿起红盒子，放到桌子上", "pick_object(red box); place_object(dining table)"),
        ("拿起红盒子然后把它放到茶几上", "pick_object(red box); place_object(coffee table)"),
        ("找到球，捡起来，扔掉", "locate(ball); pick_object(ball); place_in_bin()"),
        ("去卧室找杯子，然后拿给我", "navigation(C); locate(cup); carry(cup, zero)"),
        ("举起手臂，拿起杯子，放下", "arm_up(); pick_object(cup); putdown()"),
        ("把手抬起来，等五秒，再放下", "arm_up(); wait(5); arm_down()"),
    ],
)
def test_things_are_fetched_and_put_where_it_was_said(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("看看", "seewhat()"),
        ("你看到了什么", "seewhat()"),
        ("看看桌子上有什么", "navigation(I); seewhat()"),
        ("环顾四周", "scan_room()"),
        ("看看厨房", "scan_room(kitchen)"),
        ("打扫房间", "clean_room()"),
        ("把客厅收拾干净", "clean_room(living room)"),
        ("把所有红色的东西扔进垃圾桶", "tidy(red, bin)"),
        ("把蓝色的东西都放到桌子上", "tidy(blue, dining table)"),
        ("扔掉所有红色的东西", "tidy(red, bin)"),
        ("红球在哪里", "locate(red ball)"),
        ("你看到红盒子了吗", "locate(red box)"),
        ("你能看到杯子吗", "locate(cup)"),
        ("厨房里有杯子吗", "navigation(A); locate(cup)"),
        ("找一下蓝杯子", "locate(blue cup)"),
        ("走到红盒子旁边", "navigate_to_object(red box)"),
        ("靠近瓶子", "navigate_to_object(bottle)"),
        ("跟着我", "person_follow()"),
        ("跟我来", "person_follow()"),
        ("跟着二维码", "qr_follow()"),
        ("跟着3号标签", "apriltag_follow(3)"),
        ("跟着标签走", "apriltag_follow()"),
        ("沿着蓝线走", "follow_line(blue)"),
        ("巡线", "follow_line()"),
        ("沿着线走并清除障碍", "follow_line_clear()"),
        ("跟踪红色的东西", "color_follow(red)"),
        ("分拣3号标签", "apriltag_sort(3)"),
        ("移走高于6厘米的积木", "apriltag_remove_higher(0.06)"),
        ("把比六厘米高的方块拿走", "apriltag_remove_higher(0.06)"),
        ("移走高于5厘米的红色东西", "color_remove_higher(red, 0.05)"),
    ],
)
def test_looking_cleaning_following_and_sorting_have_their_words(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("去厨房，然后左转九十度", "navigation(A); move_left(90)"),
        ("去厨房 左转九十度", "navigation(A); move_left(90)"),
        ("到厨房后左转", "navigation(A); move_left(90)"),
        ("去厨房之后后退一米", "navigation(A); move_forward(-1)"),
        ("先去厨房，再去客厅，最后回来", "navigation(A); navigation(B); navigation(zero)"),
        ("去厨房和客厅", "navigation(A); navigation(B)"),
        ("去厨房然后停下", "navigation(A)"),
        ("去厨房，然后结束任务", "navigation(A); finish_dialogue()"),
        ("左转，九十度。", "move_left(90)"),
        ("去厨房的同时举起手臂", "navigation(A); arm_up()"),
        (
            "快速前进一米，然后像乌龟一样慢慢后退0.5米，左转30度，右转90度，向左走0.5米，再向右走10厘米",
            "move_forward(1, 0.5); move_forward(-0.5, 0.1); move_left(30); move_right(90); move_sideways(0.5); "
            "move_sideways(-0.1)",
        ),
    ],
)
def test_several_commands_in_one_sentence_become_one_plan(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    ("said", "together"),
    [
        ("去厨房，同时举起手臂", [False, True]),
        ("一边去厨房一边举手", [False, True]),
        ("去厨房的同时点头，然后鸣笛", [False, True, False]),
        ("去厨房，然后举起手臂", [False, False]),
    ],
)
def test_what_is_to_happen_at_the_same_time_starts_together(said: str, together: list[bool]) -> None:
    match = PLANNER.plan(said)
    assert isinstance(match, Matched)
    assert [call.alongside for call in match.calls] == together


@pytest.mark.parametrize(
    "said",
    [
        "别去厨房", "不要左转", "不要去厨房，去客厅", "别再去厨房", "不去厨房", "千万别去厨房", "先不去厨房",
        "去厨房。不。", "能不去厨房吗", "禁止去厨房", "没看到杯子", "拿起不是红色的盒子", "说你好但是别动",
        "如果看到杯子就去厨房", "如果看到杯子，去厨房", "要是看到球，就拿起来", "看到红盒子就停下",
        "看到红盒子以后鸣笛", "去厨房的时候鸣笛", "去厨房之前鸣笛", "鸣笛，去厨房之后", "前进直到看到墙",
        "除非天黑，否则去厨房", "一到厨房就鸣笛", "假如你去厨房", "说如果你看到杯子就停", "去厨房或者客厅",
        "去厨房还是去客厅", "去厨房洗杯子", "去睡觉", "去洗碗", "去厨房慢慢地", "去厨房🙂", "去厨房吗",
        "你去厨房了吗", "你刚才去厨房了", "我去厨房", "走到厨房会撞墙吗", "去厨房要多久", "厨房", "红盒子",
        "拿起除了红盒子以外的东西", "拿起所有的盒子", "拿两个盒子", "拿起红盒子和蓝盒子", "拿起杯子或者瓶子",
        "拿起杯子，然后拿起瓶子", "拿起杯子，然后把瓶子放到桌子上", "拿起人", "拿起苹果", "把盒子放到杯子旁边",
        "把盒子放到桌子下面", "给我拿咖啡", "打扫窗户", "跟着钱", "跟着红球", "把所有东西扔进垃圾桶", "左转200米",
        "前进90度", "鸣笛1.5次", "前进三四米", "往前走几步", "全速前进", "开门", "说明一下", "你是谁", "你好", "谢谢",
        "停猫", "，。", "然后", "去" * 900,
    ],
)  # fmt: skip
def test_a_word_too_many_is_no_match_and_never_a_guess(said: str) -> None:
    assert isinstance(PLANNER.plan(said), NoMatch)


@pytest.mark.parametrize(
    ("said", "question"),
    [
        ("前进", "多远？"),
        ("向左移动，然后左转", "多远？"),
        ("前进5", "用什么单位？"),
        ("转", "往哪边？"),
        ("转90度", "往哪边？"),
        ("去那里", "去哪里？"),
        ("过来", "去哪里？"),
        ("等会儿再去厨房", "多久？"),
        ("说", "要我说什么？"),
        ("拿起那个东西", "哪一个？"),
        ("把它拿到厨房", "哪一个？"),
        ("分拣积木", "哪一个？"),
        ("把红盒子放好", "放到哪里？"),
        ("移走高的积木", "高于多少？"),
    ],
)
def test_what_is_missing_is_asked_for(said: str, question: str) -> None:
    found = PLANNER.plan(said)
    assert isinstance(found, NoMatch)
    assert found.question.startswith(question)


@pytest.mark.parametrize(
    ("said", "name"),
    [("去月球", "月球"), ("去月球然后左转", "月球"), ("前往五楼的会议室", "五楼的会议室"), ("把杯子拿到月球", "月球")],
)
def test_a_journey_to_a_place_off_the_map_is_told_apart_and_those_on_it_are_named(said: str, name: str) -> None:
    found = PLANNER.plan(said)
    assert isinstance(found, UnknownPlace)
    assert found.name == name
    assert found.known[:2] == ("厨房", "客厅")


@pytest.mark.parametrize(
    ("said", "response", "steps"),
    [
        ("去厨房，然后左转九十度", "去厨房，然后左转90度。", ("去厨房。", "左转90度。")),
        ("向右移动20厘米，速度0.2米每秒", "向右移动20厘米，速度0.2米每秒。", ("向右移动20厘米，速度0.2米每秒。",)),
        ("鸣笛两次", "鸣笛2次。", ("鸣笛。", "鸣笛。")),
        ("去B，同时关灯", "去客厅，同时关灯。", ("去客厅。", "同时关灯。")),
        ("回来", "去记住的位置。", ("去记住的位置。",)),
        ("巡逻厨房、客厅和书房", "巡逻厨房、客厅和书房。", ("巡逻：厨房、客厅和书房。",)),
        ("拿起红盒子，放到茶几上", "拿起红色盒子，然后放到茶几上。", ("拿起红色盒子。", "放到茶几上。")),
        ("拿起3号块", "拿起3号积木。", ("拿起3号积木。",)),
        ("看看客厅", "环顾客厅。", ("环顾客厅。",)),
        ("沿着蓝线走", "沿着蓝色的线走。", ("沿着蓝色的线走。",)),
        ("你看到了什么", "", ("说出我看到什么。",)),
    ],
)
def test_answers_are_in_chinese(said: str, response: str, steps: tuple[str, ...]) -> None:
    found = PLANNER.plan(said)
    assert isinstance(found, Matched)
    assert (found.response, found.steps) == (response, steps)


def test_a_word_for_several_pieces_is_asked_about() -> None:
    found = PLANNER.plan("把它放到椅子上")
    assert isinstance(found, Matched)
    with pytest.raises(Ambiguous, match="north chair"):
        REGISTRY.resolve(found.calls[0])


@pytest.mark.parametrize("said", ["停", "停下来，然后左转", "stop", "别动"])
def test_stop_is_understood_in_every_language(said: str) -> None:
    found = PLANNER.plan(said)
    assert isinstance(found, Matched)
    assert found.kind == "stop"
    assert found.response.startswith("停下了。")


@pytest.mark.parametrize("said", ["结束任务", "that's all", "再见", "你休息一下吧"])
def test_the_end_of_a_task_is_understood_in_every_language(said: str) -> None:
    found = PLANNER.plan(said)
    assert isinstance(found, Matched)
    assert found.kind == "end_task"


def test_chinese_has_all_that_english_has() -> None:
    english, chinese = load("en"), load("zh")
    assert chinese.keys() == english.keys()
    assert chinese["intents"].keys() | chinese["open_intents"].keys() == INTENTS | {"Somewhere"}
    for section in ("answers", "stop", "things"):
        assert chinese[section].keys() == english[section].keys()
    for part in ("questions", "things", "units"):
        assert chinese["answers"][part].keys() == english["answers"][part].keys()
    colours = english["things"]["colours"].keys()
    assert chinese["things"]["colours"].keys() == colours <= chinese["answers"]["words"].keys()


def test_perception_knows_every_chinese_word_for_a_thing_by_its_english_name() -> None:
    things = all_phrases()["zh"]["things"]
    nouns = [(said, kind) for part in ("one", "many") for kind, words in things[part].items() for said in words]
    for said, kind in (*nouns, *((word, "thing") for word in things["vague"])):
        assert str(wanted(said)) == kind
        assert str(wanted(f"红色的{said}")) == str(wanted(f"紅{said}")) == f"red {kind}"
    for colour in ("red", "orange", "yellow", "green", "blue", "purple", "white", "grey", "black"):
        for said in things["colours"][colour]:
            assert VOCABULARY.colour(said) == colour
            assert VOCABULARY.object(f"{said}盒子") == f"{colour} box"


@pytest.mark.parametrize(
    ("said", "meant"),
    [("3号块", "block 3"), ("三号积木", "block 3"), ("标签12", "block 12"), ("一个蓝杯子", "blue cup")],
)
def test_a_thing_is_named_in_chinese(said: str, meant: str) -> None:
    assert VOCABULARY.object(said) == meant


@pytest.mark.parametrize("said", ["苹果", "红色的苹果", "粉色的盒子", "厨房"])
def test_a_thing_that_perception_cannot_tell_is_unknown_in_chinese_too(said: str) -> None:
    with pytest.raises(UnknownObject):
        VOCABULARY.object(said)


@pytest.mark.parametrize("scene", sorted(path.stem for path in SCENES.glob("*.yaml")))
def test_every_place_of_the_scenes_has_a_chinese_name(scene: str) -> None:
    from engine.parts.loading import at_home

    settings = at_home(load_settings(environ={}, overrides=[f"robot.scene={scene}"]))
    planner = PhrasePlanner(settings.places, "zh", vocabulary=build_vocabulary(settings))
    for symbol, place in settings.places.items():
        names = [word for word in place.aliases if is_chinese(word)]
        assert names, place.name
        for name in names:
            found = planner.plan(f"去{name}")
            assert isinstance(found, Matched), name
            assert [shown(call) for call in found.calls] == [f"navigation({symbol})"]


@pytest.mark.parametrize(
    ("text", "language"), [("去厨房", "zh"), ("go to the kitchen", "en"), ("OK停", "zh"), ("", "en"), ("90 °", "en")]
)
def test_the_language_of_a_request_is_seen_in_its_characters(text: str, language: str) -> None:
    assert language_of(text) == language


def test_words_that_mean_nothing_here_are_told_by_name() -> None:
    found = PLANNER.plan("拿起粉色的盒子")
    assert isinstance(found, Matched)
    with pytest.raises(PlanError, match="red, orange"):
        REGISTRY.resolve(found.calls[0])


WAYS = {
    "向前": ("move_forward", 1),
    "往后": ("move_forward", -1),
    "向左": ("move_sideways", 1),
    "朝右": ("move_sideways", -1),
}
LENGTHS = {"米": 1.0, "厘米": 0.01, "m": 1.0, "公分": 0.01}


@settings(deadline=None)
@given(
    st.sampled_from(["走", "移动", "平移", ""]), st.decimals(min_value=0, max_value=1000, places=2).map(float),
    st.sampled_from(sorted(LENGTHS)), st.sampled_from(sorted(WAYS)), st.sampled_from(["", "请", "麻烦你"]),
)  # fmt: skip
def test_every_distance_arrives_as_it_was_said(verb: str, number: float, unit: str, way: str, polite: str) -> None:
    found = PLANNER.plan(f"{polite}{way}{verb}{digits(number)}{unit}")
    assert isinstance(found, Matched)
    (call,) = found.calls
    name, sign = WAYS[way]
    (distance,) = call.positional
    assert call.name == name
    assert isinstance(distance, Quantity)
    assert distance.value == pytest.approx(sign * number * LENGTHS[unit], abs=1e-8)


COLOURS = {"": "", "红": "red ", "灰色的": "grey ", "紫色": "purple "}
NOUNS = {"盒子": "box", "球": "ball", "水杯": "cup", "瓶子": "bottle"}
VERBS = {
    "拿起{}": "pick_object({})",
    "请把{}捡起来": "pick_object({})",
    "{}在哪里": "locate({})",
    "走到{}旁边": "navigate_to_object({})",
    "把{}拿到书房": "carry({}, D)",
    "帮我把{}扔进垃圾桶": "pick_object({}); place_in_bin()",
}


@settings(deadline=None)
@given(
    st.sampled_from(sorted(VERBS)), st.sampled_from(["那个", "一个", "这只", ""]), st.sampled_from(sorted(COLOURS)),
    st.sampled_from(sorted(NOUNS)),
)  # fmt: skip
def test_every_plain_thing_is_understood_in_every_command(verb: str, article: str, colour: str, noun: str) -> None:
    assert plan(verb.format(f"{article}{colour}{noun}")) == VERBS[verb].format(f"{COLOURS[colour]}{NOUNS[noun]}")


HEAP = (
    "去 厨房 客厅 然后 左转 右转 九十 度 一 米 半 前进 后退 再 把 它 放 到 桌子 上 拿起 红 色的 盒子 杯子 瓶子 "
    "扔掉 找 在哪里 跟着 我 给我 先 之后 同时 请 一下 吧 不 别 没 如果 就 慢慢 两 次 鸣笛 垃圾桶 里 所有 东西 都 吗 "
    "， 。 3 号 块 看看"
)


@settings(deadline=None, max_examples=300)
@given(st.lists(st.sampled_from(HEAP.split()), min_size=1, max_size=20).map("".join))
def test_nothing_but_what_was_said_is_ever_done(text: str) -> None:
    found = PLANNER.plan(text)
    if not isinstance(found, Matched) or found.kind != "plan":
        return
    assert not any(word in text for word in ("不", "别", "没", "如果", "就"))
    words = {"厨房": "A", "客厅": "B", "桌子": "I", "垃圾桶": "K"}
    places = {call.positional[0] for call in found.calls if call.name == "navigation"}
    assert places <= {symbol for word, symbol in words.items() if word in text} | {"zero"}
    things = {call.positional[0] for call in found.calls if call.name in ("pick_object", "carry", "locate")}
    nouns = {"盒子": "box", "杯子": "cup", "瓶子": "bottle", "3": "block 3", "东西": "thing"}
    for thing in things:
        assert isinstance(thing, str)
        assert any(word in text and thing.endswith(noun) for word, noun in nouns.items())
        assert "red" not in thing or "红" in text


@settings(deadline=None)
@given(st.text(alphabet="去厨房把红色的盒子拿到客厅然后左转九十度，。不别如果说你好3m０ ", max_size=60))
def test_any_text_has_an_answer(text: str) -> None:
    assert isinstance(PLANNER.plan(text), (Matched, UnknownPlace, NoMatch))
