"""Nothing in a plan comes from nowhere: what was not said, seen or known is asked about."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from config import load
from engine.plan import Action, parse_calls
from engine.planner.build import build_registry
from engine.planner.grounding.doubt import Doubt, ungrounded
from engine.planner.worlds.house import build_vocabulary
from engine.planner.worlds.world_file import read_world
from engine.skills.library import LIBRARY
from engine.skills.places import Places
from engine.skills.registry import SkillRegistry

SETTINGS = load(environ={})
VOCABULARY = build_vocabulary(SETTINGS)
REGISTRY = build_registry(SETTINGS)


def actions_of(written: str, registry: SkillRegistry = REGISTRY) -> tuple[Action, ...]:
    return tuple(registry.resolve(call) for call in parse_calls(written))


def doubt(
    written: str, *said: str, seen: tuple[str, ...] = (), known: tuple[str, ...] = (), language: str = "en"
) -> Doubt | None:
    """What is doubted in a plan for what was said, newest last."""
    return ungrounded(
        actions_of(written),
        REGISTRY,
        said,
        VOCABULARY,
        seen=seen,
        known=known,
        language="zh" if language == "zh" else "en",
    )


@pytest.mark.parametrize(
    ("said", "written"),
    [
        ("could you see to it that the red box ends up in the kitchen", "carry(red box, A)"),
        ("the cup belongs on the low table", "pick_object(cup); place_object(coffee table)"),
        ("the lounge is where I want you", "navigation(B)"),
        ("I want you at the kitchen's counter", "navigation(M)"),
        ("get yourself to place B", "navigation(B)"),
        ("whichever mugs you find, bring them here", "carry(cup, zero)"),
        ("the box that is blue should be in my bedroom", "carry(blue box, C)"),
        ("fetch tag number 3 for me", "carry(block 3, zero)"),
        ("half a metre ahead would be nice", "move_forward(0.5)"),
        ("ninety to the left", "move_left(90)"),
        ("just a quarter turn to the right", "move_right(90)"),
        ("about turn, face the other way round", "move_left(180)"),
        ("do a couple of beeps", "beep(); beep()"),
        ("beep twice", "beep(); beep()"),
        ("beep, turn around, and beep again", "beep(); move_left(180); beep()"),
        ("quickly go two metres forward", "move_forward(2, 0.5)"),
        ("advance quickly for 1 metre", "set_cmdvel(0.5, 0, 0, 2)"),
        ("back away slowly half a metre like a turtle", "set_cmdvel(-0.1, 0, 0, 5)"),
        ("spin ninety degrees to the left", "set_cmdvel(0, 0, 0.785398, 2)"),
        ("three feet forward", "move_forward(0.91)"),
        ("drive for 4 seconds", "set_cmdvel(0.3, 0, 0, 4)"),
        ("make the lights turquoise", "light(cyan)"),
        ("lights out", "light(off)"),
        ("go to every room and tell me what is there", "navigation(A); seewhat(); navigation(B); seewhat()"),
        ("throw the bottle out", "pick_object(bottle); place_in_bin()"),
        ("tell everybody that dinner is ready", "say(Dinner is ready in the garden at 8)"),
        ("take everything red to the stool", "tidy(red, stool)"),
        ("square of 1 m", "move_forward(1); move_left(90); move_forward(1); move_left(90); move_forward(1); "
                          "move_left(90)"),
        ("把红色的盒子拿到厨房去", "carry(red box, A)"),
        ("麻烦你到客厅看一下", "navigation(B); seewhat()"),
        ("往前走一米五", "move_forward(1.5)"),
        ("向左转九十度", "move_left(90)"),
        ("把杯子给我", "carry(cup, zero)"),
        ("三号积木放到桌子上", "pick_object(block 3); place_object(dining table)"),
        ("灯变成蓝色", "light(blue)"),
        ("叫两声", "beep(); beep()"),
    ],
)  # fmt: skip
def test_what_was_said_in_whatever_words_is_a_ground(said: str, written: str) -> None:
    assert doubt(written, said) is None


@pytest.mark.parametrize(
    ("said", "written", "parameter", "question"),
    [
        ("pick up the thing", "pick_object(red box)", "object", "Which thing do you mean?"),
        ("bring me that stuff", "carry(cup, zero)", "object", "Which thing do you mean?"),
        ("pick up the box", "pick_object(red box)", "object", "Which thing do you mean?"),
        ("pick up the red cup", "pick_object(red box)", "object", "Which thing do you mean?"),
        ("pick up the red cup and the box", "pick_object(red box)", "object", "Which thing do you mean?"),
        ("pick up the cup", "pick_object(bottle)", "object", "Which thing do you mean?"),
        ("pick it up", "pick_object(bottle)", "object", "Which thing do you mean?"),
        ("bring the cup over there", "carry(cup, A)", "place", "Where to?"),
        ("go there", "navigation(A)", "place", "Where to?"),
        ("bring the cup", "carry(cup, A)", "place", "Where to?"),
        ("a cup would be good", "navigation(A)", "place", "Where to?"),
        ("bring the cup to the kitchen", "carry(cup, A, dining table)", "source", "Where shall I put it?"),
        ("put the cup away", "pick_object(cup); place_object(shelf)", "surface", "Where shall I put it?"),
        ("clean up", "clean_room(bedroom)", "room", "Which room?"),
        ("go forward", "move_forward(1)", "distance", "How far?"),
        ("go forward a bit", "move_forward(0.2)", "distance", "How far?"),
        ("go forward 2 metres", "move_forward(3)", "distance", "How far?"),
        ("go forward 2 metres", "move_forward(2, 1)", "speed", "How fast?"),
        ("go forward 2 metres", "set_cmdvel(0.7, 0, 0, 2)", "linear_x", "How fast?"),
        ("rotate", "move_left(37)", "angle", "By how many degrees?"),
        ("turn left", "move_left(45)", "angle", "By how many degrees?"),
        ("wait a moment", "wait(5)", "seconds", "For how long?"),
        ("follow the tag", "apriltag_follow(3)", "tag", "Which number?"),
        ("remove the tall blocks", "apriltag_remove_higher(0.05)", "height", "How high?"),
        ("light on", "light(red)", "colour", "Which colour?"),
        ("go to a kitchenette", "navigation(A)", "place", "Where to?"),
        ("把那个东西拿起来", "pick_object(red box)", "object", "你指的是哪个东西？"),
        ("去那边", "navigation(A)", "place", "去哪里？"),
        ("往前走", "move_forward(1)", "distance", "多远？"),
        ("向前走两米", "move_forward(1)", "distance", "多远？"),
        ("把杯子拿走", "carry(cup, A)", "place", "去哪里？"),
    ],
)
def test_what_came_from_nowhere_is_asked_about(said: str, written: str, parameter: str, question: str) -> None:
    found = doubt(written, said, language="en" if said.isascii() else "zh")
    assert found is not None
    action = actions_of(written)[found.action_index]
    number = next(p for p in REGISTRY[action.name].parameters if p.name == found.parameter)
    assert (found.question, number.name in (parameter, "duration", "color", "time")) == (question, True)


def test_the_first_doubtful_action_is_named_by_its_index() -> None:
    found = doubt("move_left(90); move_forward(1); navigation(A)", "turn left and go on")
    assert found == Doubt(1, "distance", "How far?")


def test_an_action_comes_as_often_as_it_was_said() -> None:
    assert doubt("beep(); beep(); beep()", "beep three times") is None
    assert doubt("dance(); dance()", "dance") == Doubt(1, "", "How many times?")
    assert doubt("dance(); dance(); dance()", "dance and beep") == Doubt(2, "", "How many times?")


def test_it_is_what_was_named_last_in_the_task() -> None:
    assert doubt("pick_object(red box)", "find the red box", "pick it up") is None
    assert doubt("pick_object(red box)", "find the red box", "find the cup", "pick it up") is not None
    assert doubt("pick_object(cup)", "find the red box", "find the cup", "now pick it up") is None
    assert doubt("carry(cup, C)", "find the cup", "thank you", "bring it to the bedroom") is None


def test_an_answer_completes_what_was_asked() -> None:
    assert doubt("pick_object(red box)", "pick up the box", "the red one") is None
    assert doubt("pick_object(blue box)", "pick up the box", "the red one") is not None
    assert doubt("carry(cup, A)", "bring the cup over there", "to the kitchen") is None
    assert doubt("move_forward(2)", "go forward", "two metres") is None
    assert doubt("pick_object(red box)", "把那个盒子拿起来", "红色的", language="zh") is None


def test_a_colour_that_was_not_said_needs_the_only_such_thing_that_was_seen() -> None:
    one = ("a red box on the stool", "a blue cup on the counter")
    assert doubt("pick_object(red box)", "pick up the box", seen=one) is None
    two = (*one, "a blue box on the floor")
    found = doubt("pick_object(red box)", "pick up the box", seen=two)
    assert found == Doubt(0, "object", "Which box: the blue one or the red one?")
    found = doubt("pick_object(red box)", "把盒子拿起来", seen=two, language="zh")
    assert found == Doubt(0, "object", "哪个盒子：蓝色的还是红色的？")


def test_what_was_seen_is_a_ground_for_whatever_was_asked_for_without_a_name() -> None:
    seen = ("I see a red box on the coffee table in the living room.",)
    assert doubt("pick_object(red box)", "pick up whatever is lying about", seen=seen) is None
    assert doubt("pick_object(green box)", "pick up whatever is lying about", seen=seen) is not None
    assert doubt("pick_object(red box)", "pick up the thing", seen=seen) is not None
    assert doubt("pick_object(red box)", "pick up the cup", seen=seen) is not None
    assert doubt("navigation(B); pick_object(red box)", "fetch the red box", seen=seen) is None


def test_what_the_user_wrote_down_is_a_ground() -> None:
    known = ('When I say "I\'m thirsty", bring me a bottle from the kitchen.',)
    assert doubt("navigation(A); carry(bottle, zero)", "I'm thirsty, can you bring me what I like", known=known) is None
    assert doubt("navigation(A)", "I'm thirsty") is not None


def test_a_word_that_means_several_surfaces_is_asked_about_by_their_names() -> None:
    vocabulary = build_vocabulary(SETTINGS, Places({}))
    registry = SkillRegistry(LIBRARY, capabilities=frozenset({"base", "arm", "camera", "voice"}))
    found = ungrounded(
        actions_of("place_object(coffee table)", registry), registry, ["put it on the table"], vocabulary
    )
    assert found is not None
    assert found.question.startswith("Which table: ")
    assert "coffee table" in found.question


WORLD = read_world(
    {
        "places": {"living_room": ["lounge"], "kitchen": None, "user": None},
        "objects": {"fruit": ["apple", "banana"],
            "toy": [{"name": "teddy_bear"}, {"name": "red_mug"}, {"name": "blue_mug"}]},
        "people": ["Anna"],
    },
    "test",
).vocabulary()  # fmt: skip
WORLD_REGISTRY = SkillRegistry(
    LIBRARY, capabilities=frozenset({"base", "arm", "camera", "voice"}), vocabulary=WORLD.resolvers()
)


@pytest.mark.parametrize(
    ("said", "written", "question"),
    [
        ("bring the apple to the lounge", "carry(apple, living_room)", None),
        ("bring me a fruit", "carry(banana, user)", None),
        ("bring the teddy to Anna", "carry(teddy_bear, Anna)", None),
        ("bring the red mug to me", "carry(red_mug, user)", None),
        ("bring the mug to me", "carry(red_mug, user)", "Which mug: red mug or blue mug?"),
        ("bring the apple to the kitchen", "carry(banana, kitchen)", "Which thing do you mean?"),
        ("bring the apple", "carry(apple, kitchen)", "Where to?"),
    ],
)
def test_other_worlds_have_grounds_of_their_own(said: str, written: str, question: str | None) -> None:
    found = ungrounded(actions_of(written, WORLD_REGISTRY), WORLD_REGISTRY, [said], WORLD)
    assert (found.question if found else None) == question


@settings(deadline=None, max_examples=100)
@given(st.lists(st.text(max_size=60), max_size=3), st.lists(st.text(max_size=60), max_size=2))
def test_any_text_is_judged_without_an_error(said: list[str], seen: list[str]) -> None:
    plan = actions_of("pick_object(red box); navigation(A); move_forward(1); light(red); carry(block 3, B, stool)")
    ungrounded(plan, REGISTRY, said, VOCABULARY, seen=seen)
