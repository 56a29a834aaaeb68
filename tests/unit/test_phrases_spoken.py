"""Commands as people speak them: hesitant, polite, by the way. What only sounds like a command is none."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import pytest

from config import load as load_settings
from engine.planner.build import build_registry
from engine.planner.phrases.phrases import Matched, NoMatch, PhrasePlanner
from engine.planner.text.language import load
from engine.planner.worlds.house import build_vocabulary
from engine.planner.worlds.world_file import load_world
from tests.eval.commands import world_file
from tests.unit.test_phrases import shown

SETTINGS = load_settings(environ={})
REGISTRY = build_registry(SETTINGS)
PLANNERS = {
    language: PhrasePlanner(SETTINGS.places, language, vocabulary=build_vocabulary(SETTINGS), skills=REGISTRY)
    for language in ("en", "zh")
}


def plan(text: str, language: str = "en") -> str:
    """The actions of a plan, all of which the robot can do; fails when ``text`` makes none."""
    found = PLANNERS[language].plan(text)
    assert isinstance(found, Matched), f"{text!r}: {found}"
    assert found.kind == "plan"
    for call in found.calls:
        REGISTRY.resolve(call)
    return "; ".join(map(shown, found.calls))


def is_no_command(text: str, language: str = "en") -> bool:
    """Whether ``text`` makes no plan, nor the question for what is missing in a command."""
    found = PLANNERS[language].plan(text)
    return isinstance(found, NoMatch) and not found.question


@pytest.mark.parametrize(
    "polite",
    [
        "um could you {}", "so uh {}", "well you know {}", "could you maybe {}", "you can {} now", "you must {}",
        "please you {}", "I'd like you to {}", "I'd love you to {}", "I need you to {}", "I want you {}",
        "would you be so kind as to {}", "be a dear and {}", "do me a favour and {}", "I was wondering if you could {}",
        "do you think you could {}", "if you don't mind {}", "{} if you can", "{} when you get a chance",
        "when you have a moment, {}", "{} if possible", "try to {}", "go on and {}", "{} would you", "I'm thirsty {}",
        "you look tired, {}", "great, {}", "{} right away",
    ],
)  # fmt: skip
@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("go to the kitchen", "navigation(A)"),
        ("bring me the bottle", "carry(bottle, zero)"),
        ("turn left", "move_left(90)"),
    ],
)
def test_politeness_and_hesitation_change_nothing(polite: str, said: str, actions: str) -> None:
    assert plan(polite.format(said)) == actions


@pytest.mark.parametrize(
    "said",
    [
        "please don't {}", "you must not {}", "you should never {}", "I don't want you to {}", "I wish you wouldn't {}",
        "why did you {}", "would you like to {}", "do you want to {}", "do you have to {}", "I would like to {}",
        "when you can see the cup {}", "if you can see a cup {}", "if you can {}", "when I {}", "Ben has to {}",
        "I thought you could {}", "would you mind not {}", "before you {}", "you and Ben {}", "nobody can {}",
    ],
)  # fmt: skip
@pytest.mark.parametrize("command", ["go to the kitchen", "bring me the bottle", "turn left"])
def test_politeness_takes_no_negation_condition_or_other_person_with_it(said: str, command: str) -> None:
    assert not isinstance(PLANNERS["en"].plan(said.format(command)), Matched)


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("would you mind reversing 40 centimetres?", "move_forward(-0.4)"),
        ("would you mind going to the kitchen and bringing me the cup", "navigation(A); carry(cup, zero)"),
        ("how about going to the kitchen", "navigation(A)"),
        ("start moving forward one metre", "move_forward(1)"),
        ("could you go to the uh the kitchen", "navigation(A)"),
        ("go forward like two metres", "move_forward(2)"),
        ("go forward 1 m like a turtle", "move_forward(1, 0.1)"),
    ],
)
def test_gerunds_and_fillers_are_read_for_what_they_mean(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    "said",
    ["going to the kitchen", "bringing me the cup", "without going to the kitchen", "avoid going to the kitchen",
     "would you mind not turning left", "do you mind if I go to the kitchen", "how about not going to the kitchen",
     "would you mind the gap", "I like the red box"],
)  # fmt: skip
def test_a_gerund_alone_asks_for_nothing(said: str) -> None:
    assert is_no_command(said)


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("pop over to the couch would you", "navigation(H)"),
        ("nip into the parlour please", "navigation(B)"),
        ("off you go to the study", "navigation(D)"),
        ("make for the kitchen", "navigation(A)"),
        ("I need you in the bedroom", "navigation(C)"),
        ("i want you by the wardrobe now", "navigation(S)"),
        ("could you maybe wait for me in the study", "navigation(D)"),
        ("out of the way please go and stand in the corridor", "navigation(E)"),
        ("take up position at the kitchen door", "navigation(T)"),
        ("stay in the kitchen for ten seconds", "navigation(A); wait(10)"),
        ("wait ten seconds in the hall", "navigation(E); wait(10)"),
        ("desk now", "navigation(N)"),
        ("um the bedroom please", "navigation(C)"),
        ("drive to the workbench and from there on to the closet", "navigation(P); navigation(S)"),
        ("Start in the living room, carry on to the study, and finish up at the dock.",
         "navigation(B); navigation(D); navigation(F)"),
        ("swing by the kitchen the study and the bedroom in that order",
         "navigation(A); navigation(D); navigation(C)"),
        ("visit the kitchen the study and the hall", "navigation(A); navigation(D); navigation(E)"),
        ("go to the kitchen and once you're there beep", "navigation(A); beep()"),
        ("keep going back and forth between the study and the kitchen till I say otherwise", "patrol(D,A)"),
        ("you look tired go and charge yourself", "navigation(F)"),
        ("go charge", "navigation(F)"),
        ("back to your charger", "navigation(F)"),
    ],
)  # fmt: skip
def test_there_are_many_words_for_going(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    "said",
    ["kitchen", "in the kitchen", "the kitchen is nice", "not the bedroom please", "a please", "I now", "start now",
     "I'm home now", "you must be in the kitchen", "you might be in the kitchen", "are you going to the kitchen",
     "I don't want you in the kitchen", "I didn't want you in the kitchen", "I want you out of the kitchen",
     "stay out of the kitchen", "go past the kitchen", "go around the table", "go behind the sofa",
     "wait in the kitchen until I come", "wait for Ben in the kitchen", "join Ben in the kitchen",
     "be in the kitchen at noon", "go for a walk", "off with his head", "charge my phone", "the phone is charging",
     "don't charge", "who is in charge", "once I'm there go to the kitchen", "when you see me go to the kitchen"],
)  # fmt: skip
def test_what_only_names_a_place_leads_nowhere(said: str) -> None:
    assert not isinstance(PLANNERS["en"].plan(said), Matched)


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("which room have you ended up in", "report_pose()"),
        ("whereabouts are you", "report_pose()"),
        ("keep this spot in mind", "get_current_pose()"),
        ("memorise where you are standing", "get_current_pose()"),
        ("what sort of stuff are you able to do", "list_skills()"),
        ("is there anything lying on the coffee table", "navigation(G); seewhat()"),
        ("what have we got on the workbench", "navigation(P); seewhat()"),
        ("have a nose round the study and tell me what you find", "scan_room(study)"),
        ("where's the orange ball got to", "locate(orange ball)"),
        ("is the bottle still standing on the stool", "navigation(L); locate(bottle)"),
        ("inspect the kitchen and after that the bedroom", "scan_room(kitchen); scan_room(bedroom)"),
        ("clean the bedroom and the study", "clean_room(bedroom); clean_room(study)"),
        ("the bedroom is a mess sort it out please", "clean_room(bedroom)"),
        ("the study needs a good clean", "clean_room(study)"),
    ],
)
def test_questions_and_rooms_have_their_words(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    "said",
    ["where are you from", "where are you going", "what room is Ben in", "what sort of things do you like",
     "keep in mind that I am busy", "remember me", "the bedroom is a mess", "is the bedroom a mess",
     "the bedroom isn't a mess", "who left the kitchen in such a mess", "the kitchen is a mess but leave it",
     "the study doesn't need a clean", "is there anything wrong with the table", "tell me what you find",
     "was the cup on the table", "where did I put my glasses", "clean the bedroom but not the study"],
)  # fmt: skip
def test_remarks_and_other_questions_are_not_taken_for_them(said: str) -> None:
    assert is_no_command(said)


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("chuck the bottle in the trash can would you", "pick_object(bottle); place_in_bin()"),
        ("you can pop that down on the floor now", "place_object(floor)"),
        ("put it by the bed", "navigation(Q); putdown()"),
        ("put the cup next to the sofa", "carry(cup, H)"),
        ("block number two belongs in the bedroom", "carry(block 2, C)"),
        ("the white cup should be on the workbench", "pick_object(white cup); place_object(workbench)"),
        ("the bottle needs to go back on the stool", "pick_object(bottle); place_object(stool)"),
        ("I want the red cube over on the workbench", "pick_object(red box); place_object(workbench)"),
        ("red box to the sofa, blue box to the bed", "carry(red box, H); carry(blue box, Q)"),
        ("fetch me the bottle that's standing on the stool", "carry(bottle, zero, stool)"),
        ("I could really use a cup over here", "carry(cup, zero)"),
        ("bring me the bottle and after that the ball", "carry(bottle, zero); carry(ball, zero)"),
        ("throw away the ball and then the bottle",
         "pick_object(ball); place_in_bin(); pick_object(bottle); place_in_bin()"),
        ("take the blue cup to the kitchen and the white one to the bedroom",
         "carry(blue cup, A); carry(white cup, C)"),
        ("put the bottle and the cup on the stool",
         "pick_object(bottle); place_object(stool); pick_object(cup); place_object(stool)"),
        ("bring the bottle and the cup to the kitchen", "carry(bottle, A); carry(cup, A)"),
        ("fetch the cup from the stool and take it to the kitchen", "carry(cup, A, stool)"),
        ("fetch the bottle and put it in the bin", "pick_object(bottle); place_in_bin()"),
        ("fetch the bottle, beep and bring it to the kitchen", "carry(bottle, zero); beep(); carry(bottle, A)"),
    ],
)  # fmt: skip
def test_things_are_put_and_brought_in_many_words(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    "said",
    ["the cup goes well with the bottle", "the cup is on the table", "the cup used to be on the table",
     "the cup should not be on the table", "the cup doesn't belong on the table", "should the cup be on the table",
     "where does the cup go", "did you put the cup on the table", "Ben took the cup to the kitchen",
     "I put the cup on the table", "Ben should put the cup on the table", "the cup on the table",
     "the cup should have been on the table", "the cup belongs to me", "the cup goes on the table after dinner",
     "I don't want the cup over on the table", "I want the cup on the table", "he wants the cup over on the table",
     "I'd like the cup washed", "I can use the cup", "can I use the cup", "I could use a hand", "I fancy a coffee",
     "bring me the bottle but not the ball", "bring me the bottle and leave the ball", "the box", "the blue one",
     "pick up the cup and the bottle", "put the cup next to the ball", "leave the cup by the bed", "give her a hand",
     "fetch the bottle and don't bring it to me"],
)  # fmt: skip
def test_what_is_said_about_things_is_no_errand(said: str) -> None:
    assert is_no_command(said)


def test_people_of_a_world_are_brought_things() -> None:
    world = load_world(world_file("office"), lambda message: None)
    planner = PhrasePlanner(world.places, vocabulary=world.vocabulary())
    for said in ("hand Tom his headphones", "give the headphones to Tom", "Tom is waiting for his headphones"):
        found = planner.plan(said)
        assert isinstance(found, Matched), said
        assert [(call.name, call.positional[1]) for call in found.calls] == [("carry", "Tom")]


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("everything in here that's blue goes on the coffee table", "tidy(blue, coffee table)"),
        ("all the green stuff goes into the bin", "tidy(green, bin)"),
        ("bin all the red stuff that's lying around here", "tidy(red, bin)"),
        ("take away all the blocks that stick up more than 6 cm", "apriltag_remove_higher(0.06)"),
        ("follow the blue line and shove aside whatever's in the way", "follow_line_clear(blue)"),
        ("that number three block wants putting where it belongs", "apriltag_sort(3)"),
        ("sort the block tagged 2", "apriltag_sort(2)"),
        ("drive along that blue tape on the floor till it ends", "follow_line(blue)"),
        ("come along with me and don't fall behind", "person_follow()"),
        ("drive up to the red box but don't touch it", "navigate_to_object(red box)"),
    ],
)
def test_tidying_and_following_have_more_words(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    "said",
    ["everything that's blue is on the table", "everything that isn't blue goes on the table", "everything blue",
     "all the green stuff is in the bin", "not all the red things go in the bin", "who binned the red stuff",
     "bin all the red stuff except the cup", "remove no blocks higher than 6 cm", "block two is in the bedroom",
     "does block number two belong in the bedroom", "follow the line unless it ends"],
)  # fmt: skip
def test_what_is_tidy_is_left_alone(said: str) -> None:
    assert is_no_command(said)


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("creep forward 10 cm", "move_forward(0.1)"),
        ("back it up a yard", "move_forward(-0.9144)"),
        ("you must go 20 inch in front and after this turn 45 degree on right side",
         "move_forward(0.508); move_right(45)"),
        ("shuffle a foot over to your left without turning", "move_sideways(0.3048)"),
        ("go left ten centimeters but don't turn", "move_sideways(0.1)"),
        ("spin round once anticlockwise", "move_left(360)"),
        ("give me a three sixty", "move_left(360)"),
        ("roll ahead a metre and a half, but take it slow please", "move_forward(1.5, 0.1)"),
        ("turn right right now", "move_right(90)"),
        ("get that arm of yours up in the air", "arm_up()"),
        ("you can tuck your arm back in now", "arm_down()"),
        ("point the arm all the way to the left using servo one", "servo1_move(180)"),
        ("how about a round of applause", "arm_applaud()"),
        ("let me see your best dance moves", "dance()"),
        ("nod away", "arm_nod()"),
        ("shake your arm as if to say no", "arm_shake()"),
        ("let everyone know dinner is ready", "say(dinner is ready)"),
        ("tell him that dinner is ready", "say(dinner is ready)"),
        ("first make your light blue then drive to the study and once you're there switch it off",
         "light(blue); navigation(D); light(off)"),
        ("make the light red, wait 2 seconds and turn it blue", "light(red); wait(2); light(blue)"),
    ],
)  # fmt: skip
def test_motions_gestures_and_light_have_more_words(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    "said",
    ["don't turn", "go half a metre but don't stop", "45 degrees is hot", "back the car up half a metre",
     "switch it off", "make it red", "raise your arm and switch it off", "turn the light red and the music off",
     "turn the light red and never switch it off", "stick your hand in the bin", "put your hand on the table",
     "give me a hand", "a little dance was nice", "nod if you understand", "let him know if dinner is ready",
     "let me know that you are there", "tell him to come here", "tell her about the moon", "let him go"],
)  # fmt: skip
def test_what_means_something_else_moves_nothing(said: str) -> None:
    assert is_no_command(said)


@pytest.mark.parametrize(
    ("said", "question"),
    [
        ("put the white cup on the", "Where should it go?"),
        ("bring the cup to", "Where should it go?"),
        ("take that over to him would you", "Where should it go?"),
        ("put the ball on one of the tables", "Where should it go?"),
        ("could you fetch the uh the thingy", "Which one?"),
        ("get rid of that", "Which one?"),
        ("fetch it", "Which one?"),
        ("could you say it to her please", "What should I say?"),
        ("I want you go to the the how you call it", "Where to?"),
        ("remove all the blocks that are too high", "Higher than what?"),
    ],
)
def test_what_is_missing_is_asked_for(said: str, question: str) -> None:
    found = PLANNERS["en"].plan(said)
    assert isinstance(found, NoMatch)
    assert found.question.startswith(question)


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("麻烦您去一下厨房", "navigation(A)"),
        ("能不能麻烦你往前挪个三十厘米", "move_forward(0.3)"),
        ("你应该去厨房", "navigation(A)"),
        ("可以的话，去厨房", "navigation(A)"),
        ("在沙发旁边等我", "navigation(H)"),
        ("到厨房等十秒", "navigation(A); wait(10)"),
        ("去厨房卧室和书房", "navigation(A); navigation(C); navigation(D)"),
        ("快没电了吧，回去充会儿电", "navigation(F)"),
        ("去书房，到了以后挥手", "navigation(D); arm_shake()"),
        ("你跑哪儿去了", "report_pose()"),
        ("帮我瞧瞧茶几上都有啥", "navigation(G); seewhat()"),
        ("看看四周然后告诉我发现了什么", "scan_room()"),
        ("卧室太乱了，收拾一下", "clean_room(bedroom)"),
        ("我口渴了，能不能把瓶子拿来给我", "carry(bottle, zero)"),
        ("那个瓶子不要了，扔了吧", "pick_object(bottle); place_in_bin()"),
        ("瓶子应该放在茶几上", "pick_object(bottle); place_object(coffee table)"),
        ("把杯子和瓶子拿到厨房", "carry(cup, A); carry(bottle, A)"),
        ("把红盒子扔进垃圾桶，还有绿色的盒子",
         "pick_object(red box); place_in_bin(); pick_object(green box); place_in_bin()"),
        ("取回瓶子，把它放到茶几上", "pick_object(bottle); place_object(coffee table)"),
        ("带来瓶子", "carry(bottle, zero)"),
        ("打开灯，等两秒，再关掉", "light(white); wait(2); light(off)"),
    ],
)  # fmt: skip
def test_chinese_has_its_own_ways_of_saying_it(said: str, actions: str) -> None:
    assert plan(said, "zh") == actions


@pytest.mark.parametrize(
    "said",
    ["你不应该去厨房", "我不要你去厨房", "你别去厨房等我", "你去厨房了吗", "你在厨房吗", "我在厨房等你", "我要去厨房",
     "小明去厨房了", "他把杯子放到桌子上了", "杯子在桌子上", "杯子不应该放在桌子上", "杯子应该在桌子上吗", "杯子坏了",
     "手机该充电了", "给手机充电", "你在充电吗", "别回去充电", "他在充电", "卧室太乱了", "卧室不乱不用收拾", "厨房",
     "桌子上有东西", "关掉", "变成红色", "告诉我发现了什么", "我口渴了", "快没电了"],
)  # fmt: skip
def test_chinese_negations_questions_and_remarks_are_no_commands(said: str) -> None:
    assert is_no_command(said, "zh")


NEEDS: Mapping[str, set[str]] = {
    "Go": {"place"}, "GoAndWait": {"place"}, "GoThrough": {"first"}, "Carry": {"place"}, "CarryBoth": {"place"},
    "Fetch": {"place"}, "Put": {"place", "surface"}, "PutBoth": {"place", "surface"}, "ThrowAway": {"surface"},
    "Tidy": {"surface"}, "Move": {"way"}, "Run": {"way"}, "Spin": {"spin"}, "Light": {"colour"},
}  # fmt: skip


@pytest.mark.parametrize("language", ["en", "zh"])
@pytest.mark.parametrize("intent", sorted(NEEDS))
def test_every_template_says_what_its_meaning_needs(language: str, intent: str) -> None:
    sections = load(language)

    def slots(template: str) -> set[str]:
        found = {slot.rpartition(":")[2] for slot in re.findall(r"\{([a-z_:]+)\}", template)}
        return found.union(*(slots(sections["expansion_rules"][rule]) for rule in re.findall("<([a-z_]+)>", template)))

    data: list[dict[str, Any]] = sections["intents"][intent]["data"]
    lacking = [
        template
        for part in data
        for template in part["sentences"]
        if not NEEDS[intent] & (slots(template) | part.get("slots", {}).keys())
    ]
    assert lacking == []
