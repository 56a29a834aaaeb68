"""What was taken back, forbidden, reported, supposed or asked about moves nothing, whatever a model makes of it."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.plan import Plan
from engine.planner.accounted import accounted
from engine.planner.not_an_order import marks
from engine.planner.planner import NoPlan, Planner, PlanRequest
from engine.planner.request import Happened, Said
from engine.understanding.meaning import Meaning, meaning_of
from engine.understanding.notation import read
from tests.history import asked
from tests.unit.test_two_stage import Model, planner_with

COMMANDS = [
    "go to the kitchen",
    "move back half a metre",
    "bring me the red box",
    "would you fetch the thing by the bed",
]
DRIVES = '{"action": ["navigation(kitchen)"], "response": "Going."}'
"""A model that is sure of itself."""
WORDS_ALONE = planner_with(Model([DRIVES]))
READ = planner_with(Model([DRIVES]), reader=True)


def planned(text: str, *before: Happened, planner: Planner = READ) -> Plan | NoPlan:
    """What comes of ``text`` where a model would drive to the kitchen."""
    return asyncio.run(planner.plan(PlanRequest(text, before)))


def moved(text: str, planner: Planner = READ) -> list[str]:
    found = planned(text, planner=planner)
    return [str(action) for action in found.actions] if isinstance(found, Plan) else []


@pytest.mark.parametrize(
    "ending",
    [
        "never mind", "forget it", "forget about that", "scrap that", "cancel that", "just kidding", "I take that back",
        "actually no", "actually don't", "on second thought don't", "leave it", "maybe later", "not now", "nah", "no",
        "I changed my mind", "don't bother", "better not", "there's no need", "wrong one", "ignore what I said",
    ],
)  # fmt: skip
def test_what_is_taken_back_at_the_end_moves_nothing(ending: str) -> None:
    for command, joint in product(COMMANDS, (", ", ". ", " oh ")):
        assert moved(f"{command}{joint}{ending}") == []
        assert moved(f"{command}{joint}{ending}", WORDS_ALONE) == []


@pytest.mark.parametrize(
    "text",
    [
        "you must not go to the kitchen", "never go into the bedroom", "don't bring me the red box",
        "there's no need to go to the study", "keep the red box where it is", "stay out of the kitchen",
        "I would never go to the kitchen", "I don't want you in the bedroom", "leave the cup alone",
        "I don't want the red box on the desk",
        "nobody moves the red box, and that includes you", "I wish I'd let you take the bottle to the bin",
        "you've got no business looking in the wardrobe", "next I'll be telling you to dance on the desk",
        "shame we never got the red box onto the shelf", "you should have turned left at the sofa",
        "put the red box on the shelf? Scratch that, it's fine on the desk", "get the bottle. Too late, I've got it.",
        "bring the white cup to the counter, but it doesn't matter any more",
        "my brother told you to go to the kitchen", "she said go to the kitchen", "Anna asks you to turn left",
        "if I say go to the kitchen what do you do", "suppose you go to the kitchen", "what if you turn left",
        "for example go to the kitchen", "I used to go to the kitchen", "the command go to the kitchen",
        "you would have gone to the kitchen", "when I said turn left I was asleep",
        "why did you go to the kitchen", "how do you go to the kitchen", "did you bring the red box to the kitchen",
        "what happens if you drive forward", "have you been to the kitchen", "should I go to the kitchen",
    ],
)  # fmt: skip
def test_what_is_forbidden_reported_supposed_or_asked_moves_nothing(text: str) -> None:
    assert moved(text) == []
    assert moved(text, WORDS_ALONE) == []


@pytest.mark.parametrize(
    "text",
    [
        "去厨房，算了", "左转九十度，还是别转了", "把红色盒子拿过来，不用了", "去书房，我开玩笑的",
        "去卧室，下次再说吧", "去厨房，不去了", "go to the 厨房，算了", "不要去厨房", "别把红色盒子拿走",
        "妈妈说去厨房", "如果我说左转你会怎么样", "你为什么去厨房", "你刚才去过厨房吗",
    ],
)  # fmt: skip
def test_the_same_in_chinese(text: str) -> None:
    assert moved(text) == []
    assert moved(text, WORDS_ALONE) == []


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("go to the kitchen, never mind, go to the study", "navigation(D)"),
        ("no, raise your arm", "arm_up()"),
        ("turn left 90 degrees, scratch that, 45", "move_left(45, 1)"),
        ("don't go to the kitchen, go to the study", "navigation(D)"),
        ("go to the study, not to the kitchen", "navigation(D)"),
        ("instead of going to the kitchen, go to the study", "navigation(D)"),
        ("don't forget to go to the study", "navigation(D)"),
        ("why don't you go to the study", "navigation(D)"),
        ("if you don't mind, go to the study", "navigation(D)"),
        ("不要去厨房，去书房", "navigation(D)"),
        ("能不能去书房", "navigation(D)"),
        ("别忘了去书房", "navigation(D)"),
    ],
)
def test_what_is_left_of_it_is_done(text: str, expected: str) -> None:
    assert "; ".join(moved(text)) == expected


def test_what_a_condition_leaves_undone_is_no_retraction() -> None:
    found = planned("if there is a cup on the table bring it here, else don't bother")
    assert isinstance(found, Plan)
    assert [action.name for action in found.actions] == ["navigation", "seewhat"]


def test_the_robot_says_what_it_heard_and_asks() -> None:
    found = planned("you must not go to the kitchen", planner=WORDS_ALONE)
    assert isinstance(found, NoPlan)
    assert found.answer == "I heard “must not”, so I do nothing. What shall I do?"
    taken_back = planned("go to the kitchen, scrap that")
    assert isinstance(taken_back, Plan)
    assert (taken_back.actions, taken_back.response) == ((), "All right.")


def test_a_question_is_answered_in_words_and_never_by_a_motion() -> None:
    chat = asyncio.run(
        planner_with(Model(['{"response": "Because of dust in the air."}'])).plan(PlanRequest("why is the sky red"))
    )
    assert isinstance(chat, Plan)
    assert not chat.actions
    found = planned("why is there a kitchen in every flat")
    assert isinstance(found, NoPlan)


@given(st.text(max_size=80))
def test_any_text_has_marks_that_stand_in_it(text: str) -> None:
    found = marks(text)
    assert all(mark.words and 0 <= mark.start < mark.end for mark in found)


def test_talk_about_an_order_reaches_no_model() -> None:
    model = Model([DRIVES])
    asyncio.run(planner_with(model).plan(PlanRequest("she said that you should go to where the books are")))
    assert not model.asked


def test_what_was_taken_back_before_a_question_was_answered_stays_taken_back() -> None:
    before = (Said("pick up the box"), asked("Which one: the red box?"))
    found = planned("oh leave it", *before)
    assert isinstance(found, Plan)
    assert not found.actions


def read_as(line: str, *, sure: float = 1.0) -> Meaning:
    example = read(line)
    return replace(meaning_of(example.text, example.steps), confidence=sure)


@pytest.mark.parametrize(
    "line",
    [
        "follow | follow {person: me} and don't lose me",
        "follow | 跟着{person: 我}，别跟丢了",
        "go | go to {place: the bedroom}, don't wake the baby",
        "sideways_left | slide left {amount: 25 cm}, don't turn",
        "wait | count to {time: ten seconds} without moving",
        "put | put {thing: the box} on {place: the bed}, not on the floor",
        "put charge | put {1.thing: the box} on {1.place: the bed}, then leave me in peace and go charge",
        "go_back | come back to where you came from",
        "if seen then pick_up else come end | if {1.thing: the ball} is there get {2.thing: it} and if you do "
        "not see it come",
        "turn_around | you're facing the wrong way, turn round",
        "bring | bring me {thing: the cup}, I can never remember where it is",
        "throw_away | I don't need {thing: the green box} any more, throw it away",
        "throw_away | {thing: 黄盒子}不要了，丢掉吧",
        "go bring | step one go to {1.place: the sofa} step two bring {2.thing: the ball} to {2.place: the hall}",
        "bring bring | swap these two: {1.thing: the ball} to {1.place: the desk}, {2.thing: a cup} to {2.place: me}",
        "come | come back 2 {person: me}",
        "forward | come forward a touch, let's say {amount: fifteen centimetres}",
        "forward turn_right | take 2 steps: {1.amount: half a metre} forward, right {2.amount: 90 degrees}",
        "turn_around | do a full turn on the spot",
        "turn_around say | 先转一个圈圈然后说{2.text: 你好}",
        "throw_away | {thing: 黄盒子}我不要了，扔掉。",
        "clean patrol | clean {1.place: the study} 1st then patrol",
        "go look | once you have been to {1.place: the bedroom}, look round {2.place: the hall}",
        "clean | if you've nothing else to do, clean {place: the hall}",
        "bring | I should be ever so glad if {thing: the blue box} were taken to {place: the bedroom}",
        "if unseen then bring end | bring {2.thing: the cup} if {1.thing: the red one} can't be found",
        "pick_up | pick up {thing: the cup} and don't let go",
        "tell | 去找爸爸跟他说{text: 我饿了}",
        "if seen then beep else nod end | beep if {1.thing: the ball} is in {1.place: the hall} and nod if it's not",
        "if seen then throw_away end | should you see {1.thing: the ball} in {1.place: the hall}, bin {2.thing: it}",
        "ask tell | ask {1.person: Lucy} {1.text: if she is well} and tell {2.person: me} what she says",
    ],
)
def test_a_caution_a_reason_and_a_count_of_steps_do_not_stop_it(line: str) -> None:
    assert accounted(read_as(line))


@pytest.mark.parametrize(
    "line",
    [
        "go | go to {place: the kitchen}, don't turn",
        "bring | bring {thing: the box}, I don't need it",
        "bring | bring {thing: the box} I don't want the cup",
        "go | go to {place: the kitchen} and don't go in",
        "bring | bring {thing: the cup} two times three",
        "go | go to {place: the kitchen}, no it's not",
        "put | put {thing: the box} on {place: the bed}, not on the bed",
    ],
)
def test_what_forbids_something_else_still_does(line: str) -> None:
    assert not accounted(read_as(line))
