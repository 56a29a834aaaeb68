"""What is said once for several acts, and what closed classes of words say of a meaning whatever a reader has made."""

from __future__ import annotations

import pytest

from engine.plan import Plan
from engine.planner.accounted import accounted
from engine.planner.request import Heard, Language, NoPlan, PlanRequest, Said
from engine.planner.understood import Understood
from engine.understanding.meaning import Meaning, meaning_of
from engine.understanding.notation import read
from tests.unit.test_conditions import after, shown
from tests.unit.test_understood import Written, plan, planner, reader, understood

__all__ = ["planner", "reader", "understood"]


def meaning(line: str) -> Meaning:
    example = read(line)
    return meaning_of(example.text, example.steps)


def in_language(understood: Understood, text: str, language: Language, **about: str) -> str:
    return shown(understood.plan(Heard(PlanRequest(text, language=language, **about), text, language)))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("line", "done"),
    [
        (
            "forward backward | drive {1.amount: 60 centimetres} ahead, {2.amount: 40} back",
            "move_forward(0.6); move_forward(-0.4)",
        ),
        ("wait beep wait | wait {1.time: 3 seconds}, beep, wait {3.time: 2 more}", "wait(3); beep(0.2); wait(2)"),
        (
            "forward turn_left | {1.amount: a metre} ahead, {2.amount: 30} to the left",
            "move_forward(1); move_left(30, 1)",
        ),
        ("wait beep | hang on {1.time: a sec} then beep", "wait(1); beep(0.2)"),
    ],
)
def test_a_bare_number_has_the_unit_of_the_amount_before(
    understood: Understood, reader: Written, line: str, done: str
) -> None:
    found = shown(plan(understood, reader.knows(line)))
    assert found.startswith(done.split("(")[0])
    assert [part.split(",")[0].rstrip(")") for part in found.split("; ")] == [
        part.split(",")[0].rstrip(")") for part in done.split("; ")
    ]


@pytest.mark.parametrize(
    "line",
    [
        "forward | drive {amount: 40} ahead",
        "forward backward | drive {1.amount: one metre} ahead and {2.amount: 40} back",
    ],
)
def test_a_bare_number_that_is_not_meant_in_that_unit_says_too_little(
    understood: Understood, reader: Written, line: str
) -> None:
    assert isinstance(plan(understood, reader.knows(line)), NoPlan)


def test_the_same_that_is_not_meant_is_taken_back(understood: Understood, reader: Written) -> None:
    said = reader.knows("go instead | go to {1.place: the hall}, no, not to {2.place: the hall}")
    found = plan(understood, said)
    assert not (isinstance(found, Plan) and found.actions)


def test_each_of_several_people_is_told(understood: Understood, reader: Written) -> None:
    said = reader.knows("tell | let {person: Anna} and {person: Tom} know {text: dinner is ready}")
    found = shown(plan(understood, said))
    assert found == "meet(Anna, ); tell(Anna, dinner is ready); meet(Tom, ); tell(Tom, dinner is ready)"


def test_who_is_named_only_afterwards_is_meant_before(understood: Understood, reader: Written) -> None:
    said = reader.knows("find tell | tell {2.person: Anna}, as soon as you see {1.person: her}, {2.text: I am late}")
    assert shown(plan(understood, said)) == "meet(Anna, ); tell(Anna, I am late)"


@pytest.mark.parametrize(
    ("line", "stands"),
    [
        ("throw_away | bin {thing: all boxes}, but not {except: the red one}", True),
        ("throw_away | don't bin {thing: all boxes} but {except: the red one}", False),
        ("throw_away ; throw_away | {1.thing: the ball} in the bin. {2.thing: the bottle}, bin too", True),
        (
            "bring ; bring | {1.thing: the ball}, the bottle and then {2.thing: the red box} to {2.place: the desk}",
            False,
        ),
        ("bring | three things on {place: the desk}: {thing: ball}, {thing: bottle}, {thing: red box}", True),
        ("bring | four things on {place: the desk}: {thing: ball}, {thing: bottle}, {thing: red box}", False),
        ("go | over to {place: the desk} by way of the hall", False),
        ("go | over to {place: the desk by way of the hall}", True),
        ("put | 算了，还是放在{place: 书桌上}吧", False),  # what is taken back has to stand in the meaning
        ("retract put | 算了，还是放在{place: 书桌上}吧", True),
        ("go | 去{place: 书桌}还是沙发", False),
        ("follow | 跟着{person: 我}，还是我自己去吧", False),
        ("follow instead | 跟着{1.person: 我}，还是{2.person: 我}自己去吧", False),
        ("go instead | 去{1.place: 书桌}，不对不对，{2.place: 沙发}", True),
    ],
)
def test_words_that_stop_a_plan_stand_in_the_meaning(line: str, stands: bool) -> None:
    assert accounted(meaning(line), ("ball", "bottle", "red box", "bin", "desk")) == stands


@pytest.mark.parametrize(
    "line",
    [
        "go instead | I want you in {1.place: the study}, not {2.place: the bedroom}",
        "go instead | 你要去的是{1.place: 书房}，可不是{2.place: 卧室}",
    ],
)
def test_what_is_not_meant_corrects_nothing(understood: Understood, reader: Written, line: str) -> None:
    language: Language = "en" if line.isascii() else "zh"
    assert in_language(understood, reader.knows(line), language) == "navigation(D)"


def test_a_place_on_the_way_is_gone_to_first(understood: Understood, reader: Written) -> None:
    found = plan(understood, reader.knows("go | off to {place: the desk by way of the hall}"))
    assert shown(found) == "navigation(E); navigation(N)"
    found = plan(understood, reader.knows("leave | out of {place: the kitchen} and into {place: the hall}"))
    assert shown(found) == "navigation(E)"


def test_but_not_unless_is_only_if(understood: Understood, reader: Written) -> None:
    said = reader.knows(
        "if unseen then throw_away end | bin {2.thing: the ball}, but not unless {1.thing: it} is in "
        "{1.place: the hall}"
    )
    assert after(understood, said, "ball") == "pick_object(ball); place_in_bin()"
    assert after(understood, said) == "I see no ball there."


@pytest.mark.parametrize("over", ["five seconds are over", "five seconds have passed"])
def test_a_time_that_is_over_is_waited_for(understood: Understood, reader: Written, over: str) -> None:
    said = reader.knows(f"if event then go end | once {{1.topic: {over}}} drive to {{2.place: the hall}}")
    assert shown(plan(understood, said)) == "wait(5); navigation(E)"


def test_a_block_is_sorted_into_its_tray(understood: Understood, reader: Written) -> None:
    for line in (
        "sort | sort {thing: block 2} into {place: its tray}",
        "put | {thing: block 2} goes in {place: its tray}",
    ):
        assert shown(plan(understood, reader.knows(line))) == "apriltag_sort(2)"
    assert (
        in_language(understood, reader.knows("put | 把{thing: 二号积木}放进{place: 它的托盘}"), "zh")
        == "apriltag_sort(2)"
    )


def test_what_it_has_got_needs_no_look(understood: Understood, reader: Written) -> None:
    said = reader.knows(
        "if seen then put end | if that is {1.thing: the red box you've got} {1.place: there}, {2.thing: it} goes on "
        "{2.place: the desk}"
    )
    assert shown(plan(understood, said, holding="red box")) == "place_object(desk)"
    assert shown(plan(understood, said, holding="ball")) == "All right."


def test_the_second_is_brought_where_the_first_is_missing(understood: Understood, reader: Written) -> None:
    said = reader.knows(
        "bring ; if unseen then bring end | 给{1.person: 我}拿{1.thing: 白杯子}，找不到就拿{2.thing: 蓝的} ~3.thing"
    )
    assert in_language(understood, said, "zh") == "carry(white cup, zero, )"


@pytest.mark.parametrize(
    ("line", "done"),
    [
        ("put | 把{thing: 红盒子}都放到{place: 书桌}上", "pick_object(red box); place_object(desk)"),
        ("throw_away | {source: 书桌上}的{thing: 东西}全部扔掉", "navigation(N); seewhat()"),
        ("bring | 帮{person: 我}把{thing: 球}送到{place: 书房}", "carry(ball, D, )"),
        ("bring | 给{person: 我}拿{thing: 球}来", "carry(ball, zero, )"),
        ("put | 那{thing: 把它}放到{place: 书桌上}", "place_object(desk)"),
        (
            "if is_not then bring end | {1.person: 你}要是不{1.state: 忙}，把{2.thing: 球}送到{2.place: 书房}",
            "carry(ball, D, )",
        ),
    ],
)
def test_chinese_says_some_things_elsewhere(understood: Understood, reader: Written, line: str, done: str) -> None:
    holding = "ball" if "它" in line else ""
    assert in_language(understood, reader.knows(line), "zh", holding=holding) == done


def test_more_than_one_is_counted(understood: Understood, reader: Written) -> None:
    said = reader.knows("if is_not then beep end | {1.place: 书桌上}的{1.thing: 盒子}要是不{1.state: 止一个}就响一声")
    assert after(understood, said, "red box", "blue box", language="zh") == "beep(0.2)"
    assert after(understood, said, "red box", language="zh") != "beep(0.2)"


def test_what_is_put_where_nothing_is_is_put_there(understood: Understood, reader: Written) -> None:
    said = reader.knows(
        "if is then put else put end | {1.place: 书桌上}{1.state: 空着}就放{2.thing: 球}，"
        "有东西就放{3.place: 架子} ~3.thing"
    )
    assert after(understood, said, language="zh") == "pick_object(ball); place_object(desk)"
    assert after(understood, said, "bottle", "thing", language="zh") == "pick_object(ball); place_object(shelf)"


def test_another_colour_is_asked_about(understood: Understood, reader: Written) -> None:
    assert "colour" in shown(plan(understood, reader.knows("light | make it {colour: the other colour}")))


def test_it_says_which_places_it_knows(understood: Understood, reader: Written) -> None:
    found = shown(plan(understood, reader.knows("report | {topic: which rooms} do you know?")))
    assert found.startswith("I know kitchen, living room")


def test_what_a_person_has_said_is_reported(understood: Understood, reader: Written) -> None:
    before = reader.knows("ask | ask {person: Anna} {text: what she wants}")
    asked = plan(understood, before)
    assert isinstance(asked, Plan)
    said = reader.knows("report | {topic: what did she say}?")
    assert shown(plan(understood, said, happened=(Said(before), asked))) == "report_answer()"


@pytest.mark.parametrize(
    ("line", "done"),
    [
        ("go wait | over to {1.place: the hall} and wait at {2.place: the hall}", "navigation(E)"),
        (
            "guide | lead {person: Anna} at {place: the desk} to {place: the hall}",
            "meet(Anna, desk); guide(Anna, E)",
        ),
        (
            "if is then come end | come back to me when {1.person: two minutes} are {1.state: up}",
            "wait(120); navigation(zero)",
        ),
        (
            "bring ; if event then go end | bring {1.person: me} {1.thing: the ball} and when {2.topic: I have it} go "
            "to {3.place: the hall}",
            "carry(ball, zero, ); navigation(E)",
        ),
        ("find ; report | find {1.thing: the ball} and say {2.topic: which room it's in}", "locate(ball)"),
        ("talk | I am Sophie. Remember my name, will you?", "learn_name(Sophie)"),
    ],
)
def test_what_is_said_twice_or_of_course_is_done_once(
    understood: Understood, reader: Written, line: str, done: str
) -> None:
    assert shown(plan(understood, reader.knows(line))) == done


def test_as_much_as_before_is_measured_by_that(understood: Understood, reader: Written) -> None:
    before = reader.knows("forward | ahead by {amount: 60 centimetres}")
    went = plan(understood, before)
    assert isinstance(went, Plan)
    said = reader.knows("backward | and {amount: the same distance} backwards")
    assert shown(plan(understood, said, happened=(Said(before), went))) == "move_forward(-0.6, 0.3)"
    said = reader.knows("backward | come back {amount: half of that}")
    assert shown(plan(understood, said, happened=(Said(before), went))) == "move_forward(-0.3, 0.3)"


@pytest.mark.parametrize(
    ("line", "done"),
    [
        ("nod applaud go | nod and clap and beep and go to {3.place: the hall}",
         "arm_nod(1); arm_applaud(1); beep(0.2); navigation(E)"),
        ("arm_up applaud go | raise your arm and clap and beep and go to {3.place: the hall}",
         "arm_up(); arm_applaud(1); beep(0.2); navigation(E)"),
        ("go light go | to {1.place: the hall}, beep, {2.colour: red} light, then {3.place: the desk}",
         "navigation(E); beep(0.2); light(red); navigation(N)"),
        ("nod applaud go | nod, clap, then go to {3.place: the hall}", "arm_nod(1); arm_applaud(1); navigation(E)"),
        ("go nod | go to {1.place: the hall}, beep and nod", "navigation(E); beep(0.2); arm_nod(1)"),
        ("nod applaud go nod applaud | nod and clap and beep and go to {3.place: the hall} and nod and clap",
         "arm_nod(); arm_applaud(); beep(); navigation(E); arm_nod(); arm_applaud()"),
        ("nod say | nod and say {2.text: clap and beep}", "arm_nod(1); say(clap and beep)"),
    ],
)  # fmt: skip
def test_no_act_of_a_list_is_left_out(understood: Understood, reader: Written, line: str, done: str) -> None:
    found = shown(plan(understood, reader.knows(line)))
    assert [part.partition("(")[0] for part in found.split("; ")] == [
        part.partition("(")[0] for part in done.split("; ")
    ]
