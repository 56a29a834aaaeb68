"""Commands about things, rooms and what the camera sees become plans; what is meant by "it" is never guessed."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from config import load
from engine.errors import PlanError
from engine.perception.naming import KINDS
from engine.plan import Quantity
from engine.planner.build import build_registry
from engine.planner.phrases.errands import ERRANDS, NEEDED
from engine.planner.phrases.phrases import Matched, NoMatch, PhrasePlanner, UnknownPlace
from engine.planner.text.words import digits
from engine.planner.worlds.house import build_vocabulary
from engine.skills.places import Places
from engine.skills.vocabulary import House, Vocabulary
from tests.unit.test_phrases import shown

SETTINGS = load(environ={})
REGISTRY = build_registry(SETTINGS)
PLANNER = PhrasePlanner(SETTINGS.places, vocabulary=build_vocabulary(SETTINGS), skills=REGISTRY)


def plan(text: str) -> str:
    """The actions of a plan, all of which the robot can do; fails when ``text`` makes none."""
    found = PLANNER.plan(text)
    assert isinstance(found, Matched), f"{text!r}: {found}"
    assert len(found.steps) == len(found.calls)
    for call in found.calls:
        REGISTRY.resolve(call)
    return "; ".join(map(shown, found.calls))


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("pick up the red box", "pick_object(red box)"),
        ("Could you please pick up a red cube for me?", "pick_object(red box)"),
        ("pick that green box up", "pick_object(green box)"),
        ("grab a cup", "pick_object(cup)"),
        ("take the bottle", "pick_object(bottle)"),
        ("grasp tag 3", "pick_object(block 3)"),
        ("pick up block number two", "pick_object(block 2)"),
        ("get hold of the gray mug", "pick_object(grey cup)"),
        ("pick up the grey mug", "pick_object(grey cup)"),
        ("pick up the red one", "pick_object(red thing)"),
        ("pick up the violet ball", "pick_object(purple ball)"),
        ("go and get the bottle", "pick_object(bottle)"),
        ("pick up the the red box", "pick_object(red box)"),
        ("pick up the red box from the floor", "pick_object(red box)"),
        ("take the bottle from the stool", "navigation(L); pick_object(bottle)"),
        ("pick up the cup in the kitchen", "navigation(A); pick_object(cup)"),
    ],
)
def test_a_thing_is_picked_up_by_what_it_looks_like(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("put it on the table", "place_object(dining table)"),
        ("put it down on the coffee table", "place_object(coffee table)"),
        ("place it on the workbench", "place_object(workbench)"),
        ("put it in the bin", "place_in_bin()"),
        ("throw it into the trash", "place_in_bin()"),
        ("throw it away", "place_in_bin()"),
        ("put it down", "putdown()"),
        ("put it down here please", "putdown()"),
        ("drop it here", "putdown()"),
        ("put down what you are holding", "putdown()"),
        ("put it in the kitchen", "navigation(A); putdown()"),
        ("put the red box in the bin", "pick_object(red box); place_in_bin()"),
        ("throw the bottle in the bin", "pick_object(bottle); place_in_bin()"),
        ("bring the bottle to the bin", "pick_object(bottle); place_in_bin()"),
        ("throw the cup away", "pick_object(cup); place_in_bin()"),
        ("throw away the cup", "pick_object(cup); place_in_bin()"),
        ("put the red box on the coffee table", "pick_object(red box); place_object(coffee table)"),
        ("set the bottle on the floor", "pick_object(bottle); place_object(floor)"),
        ("put the cup from the stool on the table", "navigation(L); pick_object(cup); place_object(dining table)"),
        ("put the red box in the kitchen", "carry(red box, A)"),
        (
            "put the green box in the trash and then the blue box on the shelf",
            "pick_object(green box); place_in_bin(); pick_object(blue box); place_object(shelf)",
        ),
    ],
)
def test_things_are_put_where_it_was_said(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("bring the red box to the kitchen", "carry(red box, A)"),
        ("bring the red box from the table to the kitchen", "carry(red box, A, dining table)"),
        ("bring the red box to the kitchen from the coffee table", "carry(red box, A, coffee table)"),
        ("carry the blue cup to the bedroom", "carry(blue cup, C)"),
        ("take the red box to the study", "carry(red box, D)"),
        ("move the blue box to the sofa", "carry(blue box, H)"),
        ("fetch me the bottle", "carry(bottle, zero)"),
        ("fetch the bottle from the kitchen", "carry(bottle, zero, kitchen)"),
        ("bring me the blue cup", "carry(blue cup, zero)"),
        ("give the bottle to me", "carry(bottle, zero)"),
        ("bring the cup here", "carry(cup, zero)"),
        ("I need the bottle", "carry(bottle, zero)"),
        ("can I have the bottle from the kitchen please", "carry(bottle, zero, kitchen)"),
    ],
)
def test_things_are_brought_to_places_and_to_where_people_are(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("pick up the red box and put it on the table", "pick_object(red box); place_object(dining table)"),
        ("Pick up the red box. Put it on the stool.", "pick_object(red box); place_object(stool)"),
        ("pick up the bottle and bring it to me", "pick_object(bottle); carry(bottle, zero)"),
        ("find the blue cup and bring it to the kitchen", "locate(blue cup); carry(blue cup, A)"),
        ("find the ball, pick it up and throw it away", "locate(ball); pick_object(ball); place_in_bin()"),
        ("find the red box and put it on the stool", "locate(red box); pick_object(red box); place_object(stool)"),
        ("go to the bedroom, find the cup and bring it to me", "navigation(C); locate(cup); carry(cup, zero)"),
        ("pick up the red box, go to the kitchen and put it down", "pick_object(red box); navigation(A); putdown()"),
        ("pick up the red box, beep and put the box on the stool", "pick_object(red box); beep(); place_object(stool)"),
        ("put the cup in the bin and put the ball on the stool",
         "pick_object(cup); place_in_bin(); pick_object(ball); place_object(stool)"),
        ("raise your arm and put it down", "arm_up(); arm_down()"),
        ("raise your arm, pick up the cup and put it down", "arm_up(); pick_object(cup); putdown()"),
        ("pick up the cup, raise your arm and lower it", "pick_object(cup); arm_up(); arm_down()"),
    ],
)  # fmt: skip
def test_it_is_what_was_named_last_or_what_is_held(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("clean the room", "clean_room()"),
        ("clean up", "clean_room()"),
        ("tidy the kitchen", "clean_room(kitchen)"),
        ("clean the living room", "clean_room(living room)"),
        ("tidy up the lounge", "clean_room(living room)"),
        ("put all red things in the bin", "tidy(red, bin)"),
        ("put the blue things on the table", "tidy(blue, dining table)"),
        ("put everything green on the stool", "tidy(green, stool)"),
        ("throw all the red things away", "tidy(red, bin)"),
        ("collect all the red toys and put them in the bin", "tidy(red, bin)"),
        ("scan the room", "scan_room()"),
        ("look around", "scan_room()"),
        ("look around in the kitchen", "scan_room(kitchen)"),
        ("what do you see", "seewhat()"),
        ("what can you see?", "seewhat()"),
        ("look", "seewhat()"),
        ("look behind you", "move_left(180); seewhat()"),
        ("what is behind you?", "move_left(180); seewhat()"),
        ("look to your right", "move_right(90); seewhat()"),
        ("go to the office and tell me what you see", "navigation(D); seewhat()"),
        ("where is the red ball", "locate(red ball)"),
        ("where's the bottle?", "locate(bottle)"),
        ("find the blue cup", "locate(blue cup)"),
        ("look for the bottles", "locate(bottle)"),
        ("do you see a cup", "locate(cup)"),
        ("can you see the person", "locate(person)"),
        ("are there any boxes here", "locate(box)"),
        ("find the cup in the kitchen", "navigation(A); locate(cup)"),
        ("search the kitchen for the cup", "navigation(A); locate(cup)"),
        ("is there a cup in the kitchen?", "navigation(A); locate(cup)"),
        ("tell me where the bottle is", "locate(bottle)"),
        ("check what is on the table", "navigation(I); seewhat()"),
        ("what's in the kitchen?", "scan_room(kitchen)"),
        ("get closer to the bottle", "navigate_to_object(bottle)"),
        ("go to the red box", "navigate_to_object(red box)"),
        ("drive to the bottle", "navigate_to_object(bottle)"),
        ("find the ball and go to it", "locate(ball); navigate_to_object(ball)"),
        ("go to the kitchen", "navigation(A)"),
        ("go to the table", "navigation(I)"),
    ],
)
def test_rooms_are_cleaned_and_things_looked_for(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("follow the red thing", "color_follow(red)"),
        ("follow the red object", "color_follow(red)"),
        ("follow the colour red", "color_follow(red)"),
        ("follow the color gray", "color_follow(grey)"),
        ("follow the tag", "apriltag_follow()"),
        ("follow tag number 3", "apriltag_follow(3)"),
        ("follow me", "person_follow()"),
        ("follow the person", "person_follow()"),
        ("follow the QR code", "qr_follow()"),
        ("follow the blue line", "follow_line(blue)"),
        ("drive along the red line", "follow_line(red)"),
        ("follow the line", "follow_line()"),
        ("follow the line and clear the obstacles", "follow_line_clear()"),
        ("follow the blue line, clear the obstacles", "follow_line_clear(blue)"),
        ("follow the line and clear the obstacles from the line", "follow_line_clear()"),
        ("clear the line", "follow_line_clear()"),
        ("sort tag 3", "apriltag_sort(3)"),
        ("sort block two", "apriltag_sort(2)"),
        ("remove blocks higher than 6 cm", "apriltag_remove_higher(0.06)"),
        ("remove all blocks that are taller than six centimeters", "apriltag_remove_higher(0.06)"),
        ("remove red things higher than 5 centimetres", "color_remove_higher(red, 0.05)"),
        ("turn servo 1 to 45 degrees", "servo1_move(45)"),
        ("move servo one to ninety degrees", "servo1_move(90)"),
        ("open the gripper", "open_gripper()"),
        ("open your hand", "open_gripper()"),
        ("close the hand", "close_gripper()"),
    ],
)
def test_followers_sorters_and_servos_have_their_words(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    "said",
    [
        "don't pick up the box",
        "never follow me",
        "stop following the line if it ends",
        "if you see a cup bring it",
        "pick up everything except the red box",
        "pick up all the boxes",
        "pick up two boxes",
        "pick up the red and the blue box",
        "pick up a cup or a bottle",
        "pick up the box that is not red",
        "pick up the box when I say so",
        "pick up the cup and pick up the bottle",
        "pick up the cup and put the bottle on the stool",
        "pick up the box, find the cup and put it on the stool",
        "find the ball and put it down",
        "the box",
        "red",
        "pick up the person",
        "pick up the apple",
        "pick up the box slowly",
        "put the box next to the cup",
        "put the box under the table",
        "leave the box on the stool",
        "put it on",
        "put the cup on the table in the kitchen",
        "I need the cup on the table",
        "I don't need the cup",
        "check whether there is a cup",
        "put the box down",
        "bring the red box",
        "bring me a coffee",
        "bring the kitchen",
        "clean the windows",
        "tidy the red box",
        "put everything in the bin",
        "where is everybody",
        "what colour is the box",
        "how many boxes do you see",
        "look at the red box",
        "follow the money",
        "follow the red ball",
        "follow the line backwards",
        "follow me to the kitchen",
        "drive around the box",
        "remove the red box",
        "remove everything higher than 6 cm",
        "put the red things away",
        "sort the red boxes",
        "turn servo 2 to 45 degrees",
        "close the door",
        "I picked up the box",
        "look what is on the table, if there is an apple bring it to the kitchen",
    ],
)
def test_what_is_not_plain_is_left_to_whoever_understands_it(said: str) -> None:
    assert isinstance(PLANNER.plan(said), NoMatch)


@pytest.mark.parametrize(
    ("said", "question"),
    [
        ("pick up the thing", "Which one?"),
        ("pick it up", "Which one?"),
        ("bring it to the kitchen", "Which one?"),
        ("bring it over there", "Where should it go?"),
        ("put it away", "Where should it go?"),
        ("put the red box", "Where should it go?"),
        ("sort the blocks", "Which one?"),
        ("clear the tall blocks", "Higher than what?"),
        ("remove the tall red things", "Higher than what?"),
    ],
)
def test_what_is_missing_is_asked_for(said: str, question: str) -> None:
    found = PLANNER.plan(said)
    assert isinstance(found, NoMatch)
    assert found.question.startswith(question)


def test_a_thing_is_not_brought_to_a_place_off_the_map() -> None:
    found = PLANNER.plan("bring the cup to the moon")
    assert isinstance(found, UnknownPlace)
    assert found.name == "moon"


@pytest.mark.parametrize(
    ("said", "told"),
    [("pick up the pink box", "red, orange"), ("follow the pink thing", "red, orange"),
     ("put it on the chair", "north chair")],
)  # fmt: skip
def test_words_that_mean_nothing_here_are_told_by_name(said: str, told: str) -> None:
    found = PLANNER.plan(said)
    assert isinstance(found, Matched)
    with pytest.raises(PlanError, match=told):
        REGISTRY.resolve(found.calls[0])


@pytest.mark.parametrize(
    ("said", "response"),
    [
        ("pick up the red box and put it on the stool", "Picking up the red box, then putting it on the stool."),
        ("pick up tag 3", "Picking up block 3."),
        ("bring me the cup from the kitchen", "Bringing the cup from the kitchen to the remembered place."),
        ("clean the room", "Cleaning the room."),
        ("tidy the lounge", "Cleaning the living room."),
        ("put all red things in the bin", "Putting everything red into the bin."),
        ("follow the blue line", "Following the blue line."),
        ("sort tag 3, then open the hand", "Sorting tag 3, then opening the gripper."),
        ("remove blocks higher than 6 cm", "Removing blocks higher than 6 centimetres."),
        ("what do you see", ""),  # the skill itself answers
    ],
)
def test_answers_tell_what_becomes_of_things(said: str, response: str) -> None:
    found = PLANNER.plan(said)
    assert isinstance(found, Matched)
    assert found.response == response


COLOURS = {"": "", "red ": "red ", "gray ": "grey ", "violet ": "purple "}
NOUNS = {"box": "box", "cube": "box", "ball": "ball", "mug": "cup", "bottle": "bottle"}
VERBS = {
    "pick up {}": "pick_object({})",
    "grab {} please": "pick_object({})",
    "where is {}": "locate({})",
    "drive to {}": "navigate_to_object({})",
    "bring {} to the study": "carry({}, D)",
    "could you put {} in the bin": "pick_object({}); place_in_bin()",
}


@settings(deadline=None)
@given(
    st.sampled_from(sorted(VERBS)), st.sampled_from(["the ", "a ", "my ", ""]), st.sampled_from(sorted(COLOURS)),
    st.sampled_from(sorted(NOUNS)),
)  # fmt: skip
def test_every_plain_thing_is_understood_in_every_command(verb: str, article: str, colour: str, noun: str) -> None:
    assert plan(verb.format(f"{article}{colour}{noun}")) == VERBS[verb].format(f"{COLOURS[colour]}{NOUNS[noun]}")


@settings(deadline=None)
@given(st.decimals(min_value=1, max_value=50, places=1).map(float))
def test_heights_arrive_as_they_were_said(height: float) -> None:
    found = PLANNER.plan(f"remove the blocks higher than {digits(height)} cm")
    assert isinstance(found, Matched)
    (quantity,) = found.calls[0].positional
    assert isinstance(quantity, Quantity)
    assert quantity.value == pytest.approx(height / 100)


HEAP = (
    "pick up put throw bring find follow clean the a red blue box cup bottle it them on in to table bin floor kitchen "
    "and then not if away down all things line tag 3 me where is look around everything except"
)


@settings(deadline=None, max_examples=300)
@given(st.lists(st.sampled_from(HEAP.split()), min_size=1, max_size=20).map(" ".join))
def test_nothing_but_what_was_said_is_ever_touched(text: str) -> None:
    found = PLANNER.plan(text)
    if isinstance(found, Matched):
        assert not {"not", "if", "except"} & set(text.split())
        things = {call.positional[0] for call in found.calls if call.name in ("pick_object", "carry", "locate")}
        for thing in things:
            assert isinstance(thing, str)
            assert set(thing.split()) <= {*text.split(), "block", "thing"}


def test_phrases_for_what_the_robot_cannot_do_are_left_out() -> None:
    clumsy = PhrasePlanner(SETTINGS.places, skills=[REGISTRY["navigation"], REGISTRY["locate"]])
    assert isinstance(clumsy.plan("find the cup"), Matched)
    for said in ("pick up the cup", "put it down", "follow me", "clean up"):
        assert isinstance(clumsy.plan(said), NoMatch)


def test_things_with_names_of_their_own_are_understood_by_them() -> None:
    house = House(things={"salt and pepper": "white box", "teddy": "black thing"})
    planner = PhrasePlanner(SETTINGS.places, vocabulary=Vocabulary(Places(SETTINGS.places), house))
    for said, thing in (("the salt and pepper", "white box"), ("Teddy", "black thing")):
        found = planner.plan(f"pick up {said} and throw it away")
        assert isinstance(found, Matched)
        assert [shown(call) for call in found.calls] == [f"pick_object({thing})", "place_in_bin()"]


@pytest.mark.parametrize("noun", sorted(set(KINDS) - {"tag"}))
def test_whatever_perception_can_name_can_be_looked_for(noun: str) -> None:
    assert plan(f"find the {noun if KINDS[noun] != 'thing' else f'red {noun}'}").startswith("locate(")


def test_every_errand_names_the_skills_it_needs_and_the_robot_has_them() -> None:
    assert ERRANDS.keys() == NEEDED.keys()
    assert set().union(*NEEDED.values()) <= {skill.name for skill in REGISTRY}
