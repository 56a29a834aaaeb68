"""A request that hangs on what is there is taken apart, or left alone."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.planner.readings.conditions import conditional
from engine.planner.request import Conditional


@pytest.mark.parametrize(
    ("text", "before", "thing", "where", "negated", "then", "otherwise"),
    [
        ("if there is an apple on the table, bring it to the kitchen", "", "apple", "the table", False,
         "bring the apple to the kitchen", ""),
        ("If there's an apple on the table, bring it to the kitchen, otherwise beep.", "", "apple", "the table", False,
         "bring the apple to the kitchen", "beep"),
        ("if there is an apple on the table bring it to the kitchen (otherwise beep)", "", "apple", "the table", False,
         "bring the apple to the kitchen", "beep"),
        ("check the bedroom and if you see a sock pick it up", "go to the bedroom", "sock", "", False,
         "pick the sock up", ""),
        ("look in the kitchen, and if you find a red box there, bring it to me", "go to the kitchen", "red box",
         "", False,
         "bring the red box to me", ""),
        ("when the cup is on the table, put it in the bin", "", "cup", "the table", False,
         "put the cup in the "
        "bin", ""),
        ("look whether there is a red box on the stool, if so bring it to me", "", "red box", "the stool", False,
         "bring the red box to me", ""),
        ("see if the blue cup is on the coffee table; if it is, bring it to the bedroom, otherwise go to the "
         "bedroom", "",
         "blue cup", "the coffee table", False,
         "bring the blue cup to the bedroom", "go to the bedroom"),
        ("Can you see if there is a cup on the desk? If so, bring it to me.", "", "cup", "the desk", False,
         "bring the cup to me", ""),
        ("go to the kitchen and if there is a bottle on the counter, fetch it", "go to the kitchen", "bottle",
         "the counter",
         False,
         "fetch the bottle", ""),
        ("go to the living room, and if you find the red box there, take it to the study; if not, come back",
         "go to the living room", "red box", "", False,
         "take the red box to the study", "come back"),
        ("beep if you see a cup", "", "cup", "", False,
         "beep", ""),
        ("bring the cup to the kitchen if it is on the table", "", "cup", "the table", False,
         "bring the cup to the "
        "kitchen", ""),
        ("bring me the bottle if there is one on the counter", "", "bottle", "the counter", False,
         "bring me the bottle", ""),
        ("if there is no cup on the table, beep twice", "", "cup", "the table", True,
         "beep twice", ""),
        ("if there isn't a cup on the desk then go to the kitchen", "", "cup", "the desk", True,
         "go to the kitchen", ""),
        ("if the cup is not on the table, look for it", "", "cup", "the table", True,
         "look for the cup", ""),
        ("if you don't see a ball, turn around", "", "ball", "", True,
         "turn around", ""),
        ("unless there is a box on the stool, go to the kitchen", "", "box", "the stool", True,
         "go to the kitchen", ""),
        ("if someone is in the bedroom, say hello", "", "person", "the bedroom", False,
         "say hello", ""),
        ("if nobody is in the study, turn the light off", "", "person", "the study", True,
         "turn the light off", ""),
        ("if the table is empty, put the cup on it", "", "thing", "the table", True,
         "put the cup on the table", ""),
        ("if there is anything on the floor, pick it up", "", "thing", "", False,
         "pick the thing up", ""),
        ("if there are any red boxes on the floor, put them in the bin, else go to the dock", "", "red boxes",
         "",
         False,
         "put the red boxes in the bin", "go to the dock"),
        ("如果桌子上有苹果，就把它拿到厨房", "", "苹果", "桌子", False,
         "把苹果拿到厨房", ""),
        ("如果桌子上有苹果，就拿到厨房，否则鸣笛", "", "苹果", "桌子", False,
         "把苹果拿到厨房", "鸣笛"),
        ("去卧室看看，如果看到袜子就捡起来", "去卧室", "袜子", "", False,
         "把袜子捡起来", ""),
        ("看看桌子上有没有杯子，有的话拿给我，没有就回来", "", "杯子", "桌子", False,
         "把杯子拿给我", "回来"),
        ("要是杯子在餐桌上，就把它扔进垃圾桶", "", "杯子", "餐桌", False,
         "把杯子扔进垃圾桶", ""),
        ("如果厨房里没有瓶子，就回充电座", "", "瓶子", "厨房", True,
         "回充电座", ""),
        ("如果杯子不在桌子上，就去厨房", "", "杯子", "桌子", True,
         "去厨房", ""),
        ("如果看到红色的球就跟着它走", "", "红色的球", "", False,
         "跟着红色的球走", ""),
    ],
)  # fmt: skip
def test_a_condition_on_what_can_be_seen_is_taken_apart(
    text: str, before: str, thing: str, where: str, negated: bool, then: str, otherwise: str
) -> None:
    assert conditional(text) == Conditional(before, thing, where, negated, then, otherwise)


@pytest.mark.parametrize(
    "text",
    [
        "go to the kitchen",
        "bring the apple to the kitchen",
        "if the battery is low, go to the dock",
        "if the door is open, go to the kitchen",
        "if it rains, go home",
        "if there is a problem, beep",
        "if you are in the kitchen, beep",
        "when you are done, come back",
        "if you hit the wall, stop",
        "what if there is a cat",
        "if there is an apple on the table",
        "if there is an apple on the table, the apple is red",
        "if there is an apple on the table and a cup on the stool, beep",
        "if there is an apple, and if it is red, bring it",
        "tell me if there is a cup on the table",
        "check whether my keys are on the desk and tell me",
        "bring it if it is there",
        "if so, beep",
        "if there is a cup on the table, bring it while dancing until I say stop",
        "when I say go, drive forward",
        "say if you see a cup then beep when there is one",
        "如果电量低，就去充电座",
        "如果你有时间，就去厨房",
        "桌子上有没有苹果",
        "去厨房",
        "如果桌子上有苹果",
        "if",
        "",
    ],
)
def test_what_is_not_understood_in_full_is_no_condition(text: str) -> None:
    assert conditional(text) is None


@pytest.mark.parametrize(
    ("text", "before", "thing", "where", "negated", "then", "otherwise"),
    [
        # looked, and then
        ("go find out if block two is still standing on the desk and if it isn't make your light blue", "", "block 2",
         "the desk", True,
         "make your light blue", ""),
        ("check that nobody's in the study and if it's empty turn the light off", "", "person", "the study", True,
         "turn the light off", ""),
        ("check nothing is on the stool and if it's free put the white cup on it", "", "thing", "the stool", True,
         "put the white cup on the stool", ""),
        ("go check the table and if it's clear put the box on it", "", "thing", "the table", True,
         "put the box on the table", ""),
        ("look at the box on the table, and if it is red bring it to me", "", "red box", "the table", False,
         "bring the red box to me", ""),
        ("look for the cup in the study and if it isn't there try the hall", "", "cup", "the study", True,
         "look for the cup in the hall", ""),
        ("see if you can find the green box in the study; bring it here if you do", "", "green box", "the study", False,
         "bring the green box here", ""),
        ("have a look if there's a bottle on the desk; if there isn't one, beep twice, otherwise bring it here", "",
         "bottle", "the desk", True,
         "beep twice", "bring the bottle here"),
        ("check if anyone is in the hall, if yes applaud, if no beep", "", "person", "the hall", False,
         "applaud", "beep"),
        # other words for "if"
        ("unless there's something on the shelf already put the cup on it", "", "thing", "the shelf", True,
         "put the cup on the shelf", ""),
        ("put the box on the stool unless there is something on it", "", "thing", "the stool", True,
         "put the box on the stool", ""),
        ("bring me the cup, but only if it is on the table", "", "cup", "the table", False,
         "bring me the cup", ""),
        ("go check the hall and in case you spot a ball bring it to me", "go to the hall", "ball", "", False,
         "bring the ball to me", ""),
        ("should there be a bottle on the desk, put it in the bin", "", "bottle", "the desk", False,
         "put the bottle in the bin", ""),
        ("whenever you see a cup in here put it in the bin", "", "cup", "", False,
         "put the cup in the bin", ""),
        ("look into the study and beep if anybody is there", "go to the study", "person", "", False,
         "beep", ""),
        # questions
        ("is there a ball in the hall? then bring it to the sofa", "", "ball", "the hall", False,
         "bring the ball to the sofa", ""),
        ("is the red box on the table? if so beep, otherwise come back", "", "red box", "the table", False,
         "beep", "come back"),
        ("anything green lying about in the hall then put it in the bin", "", "green thing", "the hall", False,
         "put the green thing in the bin", ""),
        ("anybody in the kitchen? if not go there", "", "person", "the kitchen", True,
         "go to the kitchen", ""),
        ("is the stool empty? then put the box on it", "", "thing", "the stool", True,
         "put the box on the stool", ""),
        ("is someone in the hall? nod if so", "", "person", "the hall", False,
         "nod", ""),
        ("pick up the ball if you see one and beep", "", "ball", "", False,
         "pick up the ball and beep", ""),
        ("go to the sofa and check for cups, if there are any beep", "go to the sofa", "cups", "", False,
         "beep", ""),
        # people
        ("check the study and if someone's standing about give them a clap else off you go to the dock",
         "go to the study", "person", "", False,
         "give them a clap", "off you go to the dock"),
        ("if Tom happens to be in the kitchen tell him his tea is ready", "", "Tom", "the kitchen", False,
         'say "your tea is ready"', ""),
        ("if grandma is in the kitchen tell her that lunch is ready", "", "grandma", "the kitchen", False,
         'say "lunch is ready"', ""),
        ("if the cup is on the desk bring it to her", "", "cup", "the desk", False,
         "bring the cup to her", ""),
        ("if we're out of bananas let the cashier know", "", "bananas", "", True,
         'go to the cashier and say "I did not see any bananas"', ""),
        ("if you see somebody in the hall greet them", "", "person", "the hall", False,
         "say hello", ""),
        # what is left out
        ("if there's a red thing on the desk turn the light red, otherwise green", "", "red thing", "the desk", False,
         "turn the light red", "turn the light green"),
        ("if there's a cup on the desk bring it to the kitchen, otherwise to the study", "", "cup", "the desk", False,
         "bring the cup to the kitchen", "bring the cup to the study"),
        ("if somebody is in the bedroom leave them alone, otherwise beep", "", "person", "the bedroom", False,
         "", "beep"),
        ("if the bedroom is empty turn the light off", "", "person", "the bedroom", True,
         "turn the light off", ""),
        ("if the cup isn't on the table any more bring it there", "", "cup", "the table", True,
         "bring the cup to the table", ""),
        ("看一下厨房里有没有人，如果没有就把灯关掉", "", "人", "厨房", True,
         "把灯关掉", ""),
        ("去书房看看有没有红色的盒子，有就拿给我，没有的话就回来", "去书房", "红色的盒子", "", False,
         "把红色的盒子拿给我", "回来"),
        ("要是有人在厨房，就告诉他晚饭好了", "", "人", "厨房", False,
         "说晚饭好了", ""),
        ("如果客厅没人就去客厅", "", "人", "客厅", True,
         "去客厅", ""),
        ("如果凳子是空的，就把红色的盒子放上去", "", "东西", "凳子", True,
         "把红色的盒子放到凳子上", ""),
        ("除非凳子上有东西，否则把绿色的盒子放上去", "", "东西", "凳子", True,
         "把绿色的盒子放到凳子上", ""),
        ("桌子上有杯子吗？有的话拿给我", "", "杯子", "桌子", False,
         "把杯子拿给我", ""),
        ("找一下客厅里的球，如果不在就去卧室找", "", "球", "客厅", True,
         "去卧室找球", ""),
        ("沙发上要是有球，就把它放到书架上", "", "球", "沙发", False,
         "把球放到书架上", ""),
        ("如果桌上的盒子是红色的就拿给我", "", "红色的盒子", "桌子", False,
         "把红色的盒子拿给我", ""),
        ("把杯子拿到厨房，如果它在桌子上的话", "", "杯子", "桌子", False,
         "把杯子拿到厨房", ""),
    ],
)  # fmt: skip
def test_a_condition_may_take_many_forms(
    text: str, before: str, thing: str, where: str, negated: bool, then: str, otherwise: str
) -> None:
    assert conditional(text) == Conditional(before, thing, where, negated, then, otherwise)


@pytest.mark.parametrize(
    "text",
    [
        "when it's six o'clock, go to the kitchen",
        "check the battery and if it's low go to the dock",
        "is it late? then go to the dock",
        "unless it rains, go to the kitchen",
        "check the weather and if it's clear go to the hall",
        "if you are tired go home",
        "if Tom is in the mood, dance",
        "if my wife is on the phone, be quiet",
        "if there was a cup on the table, bring it",
        "if you saw a cup on the table, bring it here",
        "if I were you I'd go to the kitchen",
        "I wonder if there is a cup on the table",
        "dance as if there is a box on the table",
        "bring the cup even if it is on the table",
        "if there's a box on the table tomorrow beep",
        "if you find time, clean the kitchen",
        "if there is nobody to talk to, dance",
        "if the kitchen light is red turn around",
        "ask Tom if there is a cup on the table, then come back",
        "do you know if there is a cup on the table? then bring it",
        "if there are two cups on the table, beep",
        "if there is more than one box on the desk, beep",
        "count what's on the workbench and beep if it's more than two things",
        "if you see the cup or the box, bring it",
        "if there is never anyone in the hall beep",
        "if the cup is in your hand put it on the table",
        "go to the study and tell me if there's a box",
        "see the box on the table, then bring it",
        "go to the kitchen, is there anything you need?",
        "if somebody is in the bedroom leave them alone",
        "如果昨天桌子上有苹果，就拿给我",
        "如果下雨就关门",
        "如果我是你，我就去厨房",
        "如果有两个杯子就拿一个给我",
        "如果有人叫你就过来",
        "有空吗？有的话过来",
        "看看桌子上有没有杯子，告诉我",
    ],
)
def test_what_no_look_tells_is_no_condition(text: str) -> None:
    assert conditional(text) is None


@settings(deadline=None)
@given(st.text(max_size=300))
def test_any_text_is_read_without_an_error(text: str) -> None:
    conditional(text)


WORDS = "if there is a an apple on the table , bring it to kitchen and then otherwise check see you not look whether so"
WORDS_ZH = "如果 有 没有 的话 就 ， 看看 桌子上 杯子 在 不在 吗 否则 拿给我"
PIECES_ZH = st.sampled_from(WORDS_ZH.split())
PIECES = st.sampled_from(WORDS.split())


@settings(deadline=None, max_examples=50)
@given(st.lists(PIECES, min_size=20, max_size=60).map(" ".join))
def test_confused_sentences_are_read_in_bounded_time(text: str) -> None:
    conditional(f"if there is {text}")  # patterns that backtrack would never come back


@settings(deadline=None, max_examples=50)
@given(st.lists(PIECES_ZH, max_size=100).map("".join))
def test_confused_chinese_sentences_are_read_in_bounded_time(text: str) -> None:
    conditional(text)
