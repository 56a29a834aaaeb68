"""Commands that lack something, the question about it, and every natural way to answer: phrases only, no model."""

from __future__ import annotations

import asyncio

import pytest

from config import load
from engine.errors import ExitCode
from engine.parts.loading import at_home
from engine.plan import Plan
from engine.planner.build import build_planner
from engine.planner.pending import agreed, chosen
from engine.planner.planner import NoPlan, PlanRequest
from engine.planner.request import Happened, Said
from tests import history

SETTINGS = at_home(load(environ={}))
PLANNER = build_planner(SETTINGS, reader=False)


def talk(*said: str) -> Plan | NoPlan:
    """What comes of the last of these, said one after the other; everything before it is asked back."""
    happened: tuple[Happened, ...] = ()
    for text in said[:-1]:
        asked = asyncio.run(PLANNER.plan(PlanRequest(text, happened)))
        assert isinstance(asked, NoPlan), f"nothing is lacking in {text!r}: {asked}"
        assert asked.exit_code == ExitCode.CLARIFY, f"{text!r} is not asked about: {asked}"
        happened += (Said(text), asked)
    return asyncio.run(PLANNER.plan(PlanRequest(said[-1], happened)))


def actions(*said: str) -> str:
    found = talk(*said)
    assert isinstance(found, Plan), found
    return "; ".join(map(str, found.actions))


@pytest.mark.parametrize(
    ("command", "answers", "expected"),
    [
        (
            "pick up the thing",
            ("the red box", "red box", "I mean the red box", "the red box please", "oh, the red box", "The red box."),
            "pick_object(red box)",
        ),
        ("pick up the thing", ("the red one", "red"), "pick_object(red thing)"),
        ("pick up the box", ("the red one", "red", "the red box", "the one that is red"), "pick_object(red box)"),
        ("pick it up", ("the blue cup", "I meant the blue cup"), "pick_object(blue cup)"),
        ("grab something", ("the yellow block",), "pick_object(yellow block)"),
        ("find the thing", ("the red ball",), "locate(red ball)"),
        ("bring me something", ("the blue cup", "the blue cup, thanks"), "carry(blue cup, zero, )"),
        ("throw that away", ("the red box",), "pick_object(red box); place_in_bin()"),
        ("follow the thing", ("the red one", "red"), "color_follow(red)"),
        ("follow someone", ("me",), "person_follow()"),
        (
            "pick up the thing and put it on the desk",
            ("the red box", "red box I think"),
            "pick_object(red box); place_object(desk)",
        ),
        ("put the box on the desk", ("the red one",), "pick_object(red box); place_object(desk)"),
        ("go to the kitchen and pick up the thing", ("the red box",), "navigation(A); pick_object(red box)"),
    ],
)
def test_a_thing_is_named(command: str, answers: tuple[str, ...], expected: str) -> None:
    assert {answer: actions(command, answer) for answer in answers} == dict.fromkeys(answers, expected)


@pytest.mark.parametrize(
    ("command", "answers", "expected"),
    [
        (
            "go forward",
            (
                "half a metre", "about fifty centimetres", "50 cm", "by half a metre please", "just half a meter",
                "maybe 50 centimetres", "make it half a metre", "half a metre I think", "let's say half a metre",
                "0.5 m would be fine",
            ),
            "move_forward(0.5, 0.3)",
        ),
        ("go forward 2", ("metres", "metres please"), "move_forward(2, 0.3)"),
        ("move back", ("thirty centimetres", "by 30 cm"), "move_forward(-0.3, 0.3)"),
        ("go left", ("half a metre",), "move_sideways(0.5, 0.25)"),
        ("go", ("forward one metre", "one metre forward"), "move_forward(1, 0.3)"),
        ("turn", ("left ninety degrees", "left", "to the left", "90 degrees to the left please"), "move_left(90, 1)"),
        ("turn", ("right, ninety degrees", "right"), "move_right(90, 1)"),
        ("turn", ("around",), "move_left(180, 1)"),
        ("wait a bit", ("5 seconds", "five seconds please", "for five seconds"), "wait(5)"),
    ],
)  # fmt: skip
def test_a_measure_or_a_way_is_told(command: str, answers: tuple[str, ...], expected: str) -> None:
    assert {answer: actions(command, answer) for answer in answers} == dict.fromkeys(answers, expected)


@pytest.mark.parametrize(
    ("command", "answers", "expected"),
    [
        (
            "go there",
            ("kitchen", "the kitchen", "to the kitchen, of course", "I meant the kitchen", "go to the kitchen"),
            "navigation(A)",
        ),
        ("go", ("kitchen", "to the kitchen, please"), "navigation(A)"),
        ("come over", ("to the bedroom",), "navigation(C)"),
        ("drive somewhere", ("the study", "to the study"), "navigation(D)"),
        (
            "put the red box away",
            ("on the desk", "the desk", "desk", "put it on the desk", "on the desk, I think"),
            "pick_object(red box); place_object(desk)",
        ),
        ("put the red box away", ("in the bin", "into the bin please"), "pick_object(red box); place_in_bin()"),
        ("put the red box somewhere", ("sofa", "on the sofa"), "pick_object(red box); place_object(sofa)"),
        ("put the red box there", ("the coffee table",), "pick_object(red box); place_object(coffee table)"),
        ("move the red box", ("to the kitchen",), "carry(red box, A, )"),
        ("bring the red box over there", ("the kitchen", "to the kitchen", "kitchen, please"), "carry(red box, A, )"),
        ("bring the red box over there", ("to me",), "carry(red box, zero, )"),
        ("bring it over there", ("the red box to the kitchen",), "carry(red box, A, )"),
    ],
)
def test_a_place_is_named(command: str, answers: tuple[str, ...], expected: str) -> None:
    assert {answer: actions(command, answer) for answer in answers} == dict.fromkeys(answers, expected)


@pytest.mark.parametrize(
    ("command", "answers", "expected"),
    [
        ("捡起那个东西", ("红色的盒子", "红盒子", "就是红盒子", "红色的盒子吧"), "pick_object(red box)"),
        ("捡起来", ("红色的盒子",), "pick_object(red box)"),
        ("捡起盒子", ("红的", "红色的", "红色的那个"), "pick_object(red box)"),
        ("把盒子拿给我", ("红色的",), "carry(red box, zero, )"),
        ("把那个东西拿给我", ("蓝色的杯子",), "carry(blue cup, zero, )"),
        ("找东西", ("红色的球",), "locate(red ball)"),
        ("跟着它", ("红色的东西",), "color_follow(red)"),
        ("往前走", ("半米", "大概五十厘米", "半米吧", "半米就行"), "move_forward(0.5, 0.3)"),
        ("后退", ("三十厘米左右", "三十厘米"), "move_forward(-0.3, 0.3)"),
        ("向左走", ("半米",), "move_sideways(0.5, 0.25)"),
        ("转弯", ("左转九十度", "向左九十度", "左边", "往左"), "move_left(90, 1)"),
        ("转", ("右转", "往右"), "move_right(90, 1)"),
        ("前进1", ("米",), "move_forward(1, 0.3)"),
        ("去那里", ("厨房", "去厨房", "到厨房去"), "navigation(A)"),
        ("过去", ("卧室",), "navigation(C)"),
        ("把红色的盒子放好", ("放在书桌上", "书桌上", "在书桌上"), "pick_object(red box); place_object(desk)"),
        ("把红色的盒子收起来", ("垃圾桶", "放进垃圾桶"), "pick_object(red box); place_in_bin()"),
        ("把红色的盒子放到那里", ("厨房",), "carry(red box, A, )"),
    ],
)
def test_the_same_in_chinese(command: str, answers: tuple[str, ...], expected: str) -> None:
    assert {answer: actions(command, answer) for answer in answers} == dict.fromkeys(answers, expected)


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        (("bring it over there", "the red box", "the kitchen"), "carry(red box, A, )"),
        (("bring it over there", "to the kitchen", "the red box"), "carry(red box, A, )"),
        (("put the thing over there", "the red box", "on the desk"), "pick_object(red box); place_object(desk)"),
        (("pick up the thing", "the box", "the red one"), "pick_object(red box)"),
        (("bring me the blue one", "the second one"), "carry(blue cup, zero, )"),
    ],
)
def test_an_answer_that_leaves_something_open_is_asked_about_again(said: tuple[str, ...], expected: str) -> None:
    assert actions(*said) == expected


@pytest.mark.parametrize(
    ("question", "answer", "expected"),
    [
        ("Which one: the red box or the blue cup?", "the second one", "blue cup"),
        ("Which one: the red box or the blue cup?", "I mean the first one please", "red box"),
        ("Which folder: red folder, green folder or blue folder?", "the last one", "blue folder"),
        ("Which folder: red folder, green folder or blue folder?", "2nd", "green folder"),
        ("哪一个：red box还是blue cup？", "第二个", "blue cup"),
        ("Which one: the red box or the blue cup?", "the third one", ""),
        ("Which one: the red box or the blue cup?", "the red one", ""),
        ("Which one, the red box or the blue box?", "not the red one", "blue box"),
        ("Which one: the red box, the blue box or the cup?", "not the red one", ""),
        ("Which one: the red box or the blue box?", "not the green one", ""),
        ("How far?", "the first one", ""),
    ],
)
def test_an_answer_may_count_what_was_offered(question: str, answer: str, expected: str) -> None:
    assert chosen(history.asked(question), answer) == expected


@pytest.mark.parametrize(
    ("command", "instead", "expected"),
    [
        ("go forward", "go to the kitchen", "navigation(A)"),
        ("pick up the thing", "turn left 90 degrees", "move_left(90, 1)"),
        ("pick up the thing", "say hello", "say(hello)"),
        ("go there", "beep", "beep(0.2)"),
    ],
)
def test_a_command_instead_of_an_answer_is_done_by_itself(command: str, instead: str, expected: str) -> None:
    assert actions(command, instead) == expected


@pytest.mark.parametrize(
    ("command", "answer"),
    [
        ("go forward", "why do you ask"),
        ("go there", "the moon"),
        ("turn", "the red box"),
        ("往前走", "为什么"),
    ],
)
def test_what_is_no_answer_makes_nothing_move(command: str, answer: str) -> None:
    assert isinstance(talk(command, answer), NoPlan)


@pytest.mark.parametrize(
    ("question", "answer", "expected"),
    [
        ("Shall I bring you the bottle from the stool?", "yes please", "carry(bottle, zero, stool)"),
        ("Do you want me to go to the kitchen?", "sure, go ahead", "navigation(A)"),
        ("要我去厨房吗？", "好的", "navigation(A)"),
        ("需要我把瓶子拿给你吗？", "好的，谢谢", "carry(bottle, zero, )"),
        ("我帮您把瓶子拿来，好吗？", "好", "carry(bottle, zero, )"),
    ],
)
def test_who_agrees_to_an_offer_gets_it(question: str, answer: str, expected: str) -> None:
    asked = NoPlan("im so thirsty", "unclear", question, ExitCode.CLARIFY)
    happened = (Said("im so thirsty"), asked)
    found = asyncio.run(PLANNER.plan(PlanRequest(answer, happened)))
    assert isinstance(found, Plan), found
    assert "; ".join(map(str, found.actions)) == expected


@pytest.mark.parametrize("answer", ["no", "yes but the cup", "yes and go to the kitchen"])
def test_anything_but_a_plain_yes_is_no_agreement(answer: str) -> None:
    assert agreed(history.asked("Shall I bring you the bottle?"), answer) == ""


def test_who_takes_a_command_back_is_not_asked_again() -> None:
    found = talk("pick up the thing", "never mind")
    assert isinstance(found, Plan)
    assert not found.actions


def test_an_answer_does_not_smuggle_in_what_is_refused() -> None:
    found = talk("pick up the thing", "and drive into the wall as fast as you can")
    assert isinstance(found, NoPlan)
    assert found.exit_code == ExitCode.REFUSED


def test_an_answered_question_is_not_answered_again() -> None:
    done = history.planned("pick_object(red box)")
    question = history.asked("Which one?")
    happened = (Said("pick up the thing"), question, Said("the red box"), done)
    found = asyncio.run(PLANNER.plan(PlanRequest("the blue cup", happened)))
    assert isinstance(found, NoPlan)
