"""Plain commands become plans; everything else is not guessed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from config import load as load_settings
from config.schema import Place, Position
from engine.errors import UsageError
from engine.plan import ActionCall, Quantity
from engine.planner.phrases.phrases import Matched, NoMatch, PhrasePlanner, UnknownPlace, is_end_task, is_stop
from engine.planner.text.language import load
from engine.planner.text.words import digits
from engine.robot.robot import Capability
from engine.skills.external.host import external_skill
from engine.skills.library import LIBRARY
from engine.skills.places import Places
from engine.skills.registry import SkillRegistry

SPOT = Position(x=0, y=0)
PLACES = {
    "A": Place(name="kitchen", position=SPOT),
    "B": Place(name="living room", aliases=("lounge", "Sitting Room"), position=SPOT),
    "C": Place(name="The Bed & Breakfast Room", position=SPOT),
    "D": Place(name="room 2", aliases=("St. Mary's",), position=SPOT),
    "E": Place(name="charging dock", aliases=("charger", "home"), position=SPOT),
}
ALL: frozenset[Capability] = frozenset({"base", "arm", "camera", "voice"})
PATROL = external_skill("patrol", load_settings(environ={}).skills["patrol"])
PLANNER = PhrasePlanner(PLACES, skills=(*LIBRARY, PATROL))
REGISTRY = SkillRegistry([*LIBRARY, PATROL], capabilities=ALL, vocabulary={"place": Places(PLACES).symbol})
COMMANDS = Path(__file__).parents[3] / "shared" / "data" / "commands_dev.json"


def shown(call: ActionCall) -> str:
    """The action with its numbers in the skill's own unit, as people would write it."""
    arguments = (digits(a.value) if isinstance(a, Quantity) else a for a in call.positional)
    return f"{call.name}({', '.join(arguments)})"


def plan(text: str) -> str:
    """The actions of a plan; fails when ``text`` makes none."""
    found = PLANNER.plan(text)
    assert isinstance(found, Matched), f"{text!r}: {found}"
    assert found.kind == "plan"
    assert len(found.steps) == len(found.calls)
    for call in found.calls:
        REGISTRY.resolve(call)  # raises when a skill or an argument does not exist
    return "; ".join(map(shown, found.calls))


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("go forward half a metre", "move_forward(0.5)"),
        ("move forward 1.5 m", "move_forward(1.5)"),
        ("Go forward 10 meters.", "move_forward(10)"),
        ("go forward ten meters", "move_forward(10)"),
        ("drive two metres straight ahead", "move_forward(2)"),
        ("drive straight ahead for three metres at 0.4 m/s", "move_forward(3, 0.4)"),
        ("Could you move forward about 50 centimeters?", "move_forward(0.5)"),
        ("move 30 cm", "move_forward(0.3)"),
        ("inch forward 5 cm", "move_forward(0.05)"),
        ("scoot left 10 cm", "move_sideways(0.1)"),
        ("a metre and a half forward", "move_forward(1.5)"),
        ("back up one and a half meters", "move_forward(-1.5)"),
        ("move one metre backwards", "move_forward(-1)"),
        ("go back 30 cm", "move_forward(-0.3)"),
        ("walk back three feet", "move_forward(-0.9144)"),
        ("move 20 centimetres to the left", "move_sideways(0.2)"),
        ("step left 30 cm", "move_sideways(0.3)"),
        ("strafe right half a metre", "move_sideways(-0.5)"),
        ("slide sideways to the right by 1 m", "move_sideways(-1)"),
        ("go forward at 0.2 metres per second for 3 seconds", "set_cmdvel(0.2, 0, 0, 3)"),
        ("reverse for 2 seconds at 10 cm/s", "set_cmdvel(-0.1, 0, 0, 2)"),
        ("strafe left at 0.1 m/s for 2 s", "set_cmdvel(0, 0.1, 0, 2)"),
    ],
)
def test_distances_and_velocities_are_driven_as_said(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("turn left 90 degrees", "move_left(90)"),
        ("turn left 45°", "move_left(45)"),
        ("turn 45 degrees to the right", "move_right(45)"),
        ("turn left 30", "move_left(30)"),
        ("rotate clockwise a quarter turn", "move_right(90)"),
        ("rotate 45 degrees counter-clockwise", "move_left(45)"),
        ("turn half a turn to the right", "move_right(180)"),
        ("make two full turns to the left", "move_left(720)"),
        ("make a 30 degree left turn", "move_left(30)"),
        ("turn left 90 degrees at 0.5 radians per second", "move_left(90, 0.5)"),
        ("turn left minus 90 degrees", "move_right(90)"),
        ("turn left", "move_left(90)"),
        ("Turn to your right.", "move_right(90)"),
        ("take a left", "move_left(90)"),
        ("face right", "move_right(90)"),
        ("rotate left by ninety", "move_left(90)"),
        ("do a 180", "move_left(180)"),
        ("spin around twice", "move_left(360); move_left(360)"),
        ("turn around", "move_left(180)"),
        ("turn around to the right", "move_right(180)"),
        ("turn 180 degrees", "move_left(180)"),
        ("do a full turn", "move_left(360)"),
        ("turn left 90 degrees three times", "move_left(90); move_left(90); move_left(90)"),
        ("spin in place to the left at half a radian per second for 4 seconds", "set_cmdvel(0, 0, 0.5, 4)"),
        ("spin clockwise for two seconds at 30 degrees per second", "set_cmdvel(0, 0, -0.523599, 2)"),
    ],
)
def test_turns_are_to_the_side_and_by_the_angle_that_was_said(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    ("said", "symbol"),
    [
        ("go to the kitchen", "A"),
        ("GO TO THE KITCHEN!!", "A"),
        ("head over to the kitchen please", "A"),
        ("could you please go to the kitchen", "A"),
        ("Okay. Please go to the kitchen now, thank you.", "A"),
        ("hey robot, go to the kitchen", "A"),
        ("go kitchen", "A"),
        ("go back to the kitchen", "A"),
        ("Go. To the kitchen.", "A"),
        ('go to the "kitchen"', "A"),
        ("drive to the lounge", "B"),
        ("enter the sitting room", "B"),
        ("go to the living-room", "B"),
        ("navigate to place B", "B"),
        ("go to b", "B"),
        ("go to the bed and breakfast room", "C"),
        ("visit the Bed & Breakfast Room", "C"),
        ("go to room two", "D"),
        ("go to room 2.", "D"),
        ("go to St. Mary’s", "D"),
        ("return to your charger", "E"),
        ("go home", "E"),
        ("return", "zero"),
        ("come back", "zero"),
        ("come back here", "zero"),
        ("go back where you came from", "zero"),
        ("swing by the kitchen", "A"),
        ("show me the way to the lounge", "B"),
        ("go back to where you started", "zero"),
        ("return to the remembered place", "zero"),
        ("go to zero", "zero"),
    ],
)
def test_places_are_found_by_name_alias_and_symbol(said: str, symbol: str) -> None:
    assert plan(said) == f"navigation({symbol})"


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("patrol", "patrol()"),
        ("Please patrol the flat.", "patrol()"),
        ("patrol the whole house until I tell you to stop", "patrol()"),
        ("do your rounds", "patrol()"),
        ("keep watch", "patrol()"),
        ("start patrolling", "patrol()"),
        ("patrol the kitchen", "patrol(A)"),
        ("patrol between the kitchen and the lounge", "patrol(A,B)"),
        ("patrol the kitchen, the living room and room 2", "patrol(A,B,D)"),
        ("patrol between the Bed & Breakfast Room and the kitchen", "patrol(C,A)"),
        ("go back and forth between the kitchen and the charger", "patrol(A,E)"),
        ("go to the kitchen, then keep watch", "navigation(A); patrol()"),
    ],
)
def test_a_patrol_goes_through_the_places_that_were_said_or_all_rooms(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize("said", ["patrol between the kitchen", "patrol if you hear something", "patrol the wine"])
def test_half_a_patrol_is_not_guessed(said: str) -> None:
    assert not isinstance(PLANNER.plan(said), Matched)


@pytest.mark.parametrize("said", ["stop patrolling", "stop the patrol!"])
def test_a_patrol_is_stopped_by_its_name(said: str) -> None:
    assert is_stop(said)


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("remember this place", "get_current_pose()"),
        ("raise your arm", "arm_up()"),
        ("put your hands up", "arm_up()"),
        ("arm down", "arm_down()"),
        ("nod twice", "arm_nod(); arm_nod()"),
        ("shake your head", "arm_shake()"),
        ("wave at me", "arm_shake()"),
        ("raise both arms", "arm_up()"),
        ("do a little dance for us", "dance()"),
        ("what room are you in", "report_pose()"),
        ("tell everyone that dinner is ready", "say(dinner is ready)"),
        ("please clap", "arm_applaud()"),
        ("dance", "dance()"),
        ("drift", "drift()"),
        ("wait ten seconds", "wait(10)"),
        ("wait half a minute", "wait(30)"),
        ("pause for 1 minute and 30 seconds", "wait(90)"),
        ("beep", "beep()"),
        ("beep for two seconds", "beep(2)"),
        ("beep three times", "beep(); beep(); beep()"),
        ("turn the light red", "light(red)"),
        ("set the lights to violet", "light(purple)"),
        ("switch off the lamp", "light(off)"),
        ("where are you right now?", "report_pose()"),
        ("what can you do", "list_skills()"),
        ("Help!", "list_skills()"),
        ("say dinner is ready", "say(dinner is ready)"),
        ("Say: “Hello, everyone. Stop there.”", "say(Hello, everyone. Stop there)"),
        ("say hello please", "say(hello)"),
        ("say please", "say(please)"),
        ("say 5 metres and a half is far", "say(5 metres and a half is far)"),
        ("say 'if you like' and nod", "say(if you like); arm_nod()"),
    ],
)
def test_the_other_skills_have_their_words(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize(
    ("said", "actions"),
    [
        ("wait 5 seconds and then beep", "wait(5); beep()"),
        ("move forward half a metre, then 20 centimetres to the left", "move_forward(0.5); move_sideways(0.2)"),
        ("turn left 30 degrees and then 90 degrees to the right", "move_left(30); move_right(90)"),
        ("turn left then right", "move_left(90); move_right(90)"),
        ("go forward one metre and 20 cm to the left", "move_forward(1); move_sideways(0.2)"),
        ("raise your arm, wait 5 seconds and lower it again", "arm_up(); wait(5); arm_down()"),
        ("go to the kitchen, the lounge and the charger", "navigation(A); navigation(B); navigation(E)"),
        ("go to the kitchen and back", "navigation(A); navigation(zero)"),
        ("First go to the kitchen. After that, beep; finally return!", "navigation(A); beep(); navigation(zero)"),
        ("go to the bed and breakfast room and beep", "navigation(C); beep()"),
        ("go to the kitchen and say dinner is ready", "navigation(A); say(dinner is ready)"),
        ("go to the kitchen and stop", "navigation(A)"),
        ("go to the kitchen and end the task", "navigation(A); finish_dialogue()"),
        ("Turn left, 90 degrees.", "move_left(90)"),
        (
            "drive in a square with one metre sides",
            "; ".join(["move_forward(1); move_left(90)"] * 4),
        ),
        (
            "Move forward quickly for 1 metre, then slowly back away 0.5 m like a turtle, turn left 30 degrees, turn "
            "right 90 degrees, move 0.5 m to the left, then 10 cm to the right",
            "move_forward(1, 0.5); move_forward(-0.5, 0.1); move_left(30); move_right(90); move_sideways(0.5); "
            "move_sideways(-0.1)",
        ),
    ],
)
def test_several_commands_in_one_sentence_become_one_plan(said: str, actions: str) -> None:
    assert plan(said) == actions


@pytest.mark.parametrize("adverb", ["slowly", "quickly", "very slowly", "like a snail"])
def test_a_word_for_speed_changes_driving_and_is_left_over_elsewhere(adverb: str) -> None:
    assert plan(f"go forward 1 m {adverb}") == f"move_forward(1, {0.5 if adverb == 'quickly' else 0.1})"
    assert plan(f"{adverb} turn left 45 degrees") == f"move_left(45, {2 if adverb == 'quickly' else 0.5})"
    assert isinstance(PLANNER.plan(f"go to the kitchen {adverb}"), NoMatch)


@pytest.mark.parametrize(
    "said",
    [
        "don't go to the kitchen",
        "do not turn left",
        "no don't go to the kitchen",
        "go to the kitchen. No.",
        "if you see a cup go to the kitchen",
        "if you see a cup, go to the kitchen",
        "go to the kitchen unless it is dark",
        "go forward 1 m until you see a wall",
        "after you beep, go to the kitchen",
        "say hello if you see a cup",
        "say hello but don't move",
        "say hello and iron the shirts",
        "go to the kitchen or the lounge",
        "go to the kitchen and wash the cup",
        "go to the moon and wash the cup",
        "pick up the thing",
        "go to the kitchen slowly",
        "go to the kitchen 🙂",
        "drive through the wall at full speed",
        "fly to the moon",
        "go to sleep",
        "come to me",
        "never mind",
        "turn left 200 metres",
        "move forward 90 degrees",
        "beep 1.5 times",
        "who are you",
        "hello",
        "please please",
        "",
        "   ",
        "...",
        "then",
        "去厨房",
        "go to the kitchen\x00",
        "stop the cat",
        "x" * 100_000,
        "turn left and " * 10_000,
    ],
)
def test_a_word_too_many_is_no_match_and_never_a_guess(said: str) -> None:
    assert isinstance(PLANNER.plan(said), NoMatch)


@pytest.mark.parametrize(
    ("said", "leftover"),
    [
        ("go to the kitchen and wash the cup", "wash the cup"),
        ("Turn left, juggle three balls, then beep", "juggle three balls"),
        ("beep\x1b[2J and juggle", "beep [2J"),
    ],
)
def test_the_answer_names_the_part_that_was_not_understood(said: str, leftover: str) -> None:
    found = PLANNER.plan(said)
    assert isinstance(found, NoMatch)
    assert found.leftover == leftover
    assert "go to the kitchen" in found.understood


@pytest.mark.parametrize(
    ("said", "question"),
    [
        ("move left", "How far?"),
        ("move forward and turn left 90 degrees", "How far?"),
        ("go forward 5", "In which unit?"),
        ("turn", "Which way?"),
        ("turn 90 degrees", "Which way?"),
        ("go there", "Where to?"),
        ("come over here", "Where to?"),  # the robot does not know where anybody is
        ("wait a moment", "How long?"),
        ("say", "What should I say?"),
    ],
)
def test_a_command_that_lacks_something_gets_the_question_for_it(said: str, question: str) -> None:
    found = PLANNER.plan(said)
    assert isinstance(found, NoMatch)
    assert found.question.startswith(question)


@pytest.mark.parametrize(
    ("said", "name"),
    [
        ("go to the moon", "moon"),
        ("go to the moon then turn left", "moon"),
        ("please drive to my desk now", "desk"),
        ("walk to Paris", "Paris"),
        ("go to the kitchen table", "kitchen table"),
        ("go to room 5", "room 5"),
        ("go to the kitchen, the moon and the lounge", "moon"),
    ],
)
def test_a_journey_to_a_place_off_the_map_is_told_apart(said: str, name: str) -> None:
    assert PLANNER.plan(said) == UnknownPlace(name, tuple(place.name for place in PLACES.values()))


@pytest.mark.parametrize(
    "said",
    [
        "stop",
        "Stop!",
        "STOP",
        "stop stop stop",
        "Stop. Stop.",
        "stop right now",
        "please stop",
        "hey robot, stop",
        "oh no, stop!",
        "no no no stop",
        "halt",
        "freeze",
        "whoa",
        "don't move",
        "Don’t move!",
        "emergency stop",
        "wait",
        "hold on",
        "go left, no, stop!",
        "stop and turn around",
        "stop, you are going to hit the cat",
        "stop " * 150,
    ],
)
def test_stop_is_understood_however_it_is_said(said: str) -> None:
    assert is_stop(said)
    found = PLANNER.plan(said)
    assert isinstance(found, Matched)
    assert found.kind == "stop"
    assert found.calls == (ActionCall("stop"),)


@pytest.mark.parametrize(
    "said",
    ["don't stop", "say stop", 'say "stop!"', "go to the kitchen and stop", "wait 5 seconds", "stop for 5 seconds"],
)
def test_a_stop_that_is_not_meant_stops_nothing(said: str) -> None:
    assert not is_stop(said)


def test_a_stop_with_more_behind_it_asks_to_say_the_rest_again() -> None:
    found = PLANNER.plan("stop and turn around")
    assert isinstance(found, Matched)
    assert "again" in found.response


@pytest.mark.parametrize(
    "said", ["end the current task", "End current task.", "take a break", "OK, that's all, thanks.", "goodbye"]
)
def test_the_end_of_a_task_is_understood_as_a_whole_sentence(said: str) -> None:
    assert is_end_task(said)
    assert not is_stop(said)
    found = PLANNER.plan(said)
    assert isinstance(found, Matched)
    assert found.kind == "end_task"
    assert not is_end_task(f"{said} and go to the kitchen")


def test_the_answer_tells_in_one_sentence_what_will_be_done() -> None:
    found = PLANNER.plan("go to the kitchen, then turn left 90 degrees")
    assert isinstance(found, Matched)
    assert found.response == "Going to the kitchen, then turning left 90 degrees."
    assert found.steps == ("Go to the kitchen.", "Turn left 90 degrees.")


@pytest.mark.parametrize(
    ("said", "response"),
    [
        ("go forward 1 m", "Driving 1 metre forward."),
        ("move 20 cm to the right at 0.2 m/s", "Moving 20 centimetres to the right at 0.2 metres per second."),
        ("walk back two feet", "Driving 0.61 metres backward."),
        ("go forward for 2 s", "Driving forward at 0.3 metres per second for 2 seconds."),
        ("beep twice", "Beeping 2 times."),
        ("go to B and light off", "Going to the living room, then turning the light off."),
        ("return", "Going to the remembered place."),
        ("where are you", ""),  # the skill itself answers
        ("patrol", "Patrolling from room to room."),
        ("patrol the kitchen, lounge and room 2", "Patrolling the kitchen, the living room and the room 2."),
    ],
)
def test_answers_are_told_in_the_words_of_people(said: str, response: str) -> None:
    found = PLANNER.plan(said)
    assert isinstance(found, Matched)
    assert found.response == response


def test_a_long_plan_is_not_recited() -> None:
    found = PLANNER.plan("beep, nod, dance, clap, drift, and then wait 5 seconds")
    assert isinstance(found, Matched)
    assert found.response == "Beeping, then nodding, then dancing, and 3 more steps."


WAYS = {"forward": ("move_forward", 1), "backward": ("move_forward", -1)} | {
    f"to the {side}": ("move_sideways", sign) for side, sign in (("left", 1), ("right", -1))
}
LENGTHS = {"m": 1.0, " metres": 1.0, "cm": 0.01, " centimeters": 0.01, " feet": 0.3048}


@settings(deadline=None)
@given(
    st.sampled_from(["go", "move", "drive", "please walk"]),
    st.decimals(min_value=0, max_value=1000, places=2).map(float),
    st.sampled_from(sorted(LENGTHS)),
    st.sampled_from(sorted(WAYS)),
    st.booleans(),
)
def test_every_distance_arrives_as_it_was_said(verb: str, number: float, unit: str, way: str, way_first: bool) -> None:
    length = f"{digits(number)}{unit}"
    found = PLANNER.plan(f"{verb} {way} {length}" if way_first else f"{verb} {length} {way}")
    assert isinstance(found, Matched)
    (call,) = found.calls
    name, sign = WAYS[way]
    (distance,) = call.positional
    assert call.name == name
    assert isinstance(distance, Quantity)
    assert distance.unit == "m"
    assert distance.value == pytest.approx(sign * number * LENGTHS[unit], abs=1e-8)


@settings(deadline=None)
@given(
    st.lists(
        st.tuples(st.sampled_from(["left", "right"]), st.integers(min_value=0, max_value=3600)), min_size=1, max_size=10
    ),
    st.sampled_from([" and ", ", ", " then ", ", and then ", ". ", "; "]),
)
def test_every_chain_of_turns_arrives_in_order(turns: list[tuple[str, int]], joint: str) -> None:
    found = PLANNER.plan(joint.join(f"turn {side} {angle} degrees" for side, angle in turns))
    assert isinstance(found, Matched)
    assert [shown(call) for call in found.calls] == [f"move_{side}({angle})" for side, angle in turns]


@settings(deadline=None)
@given(st.text(max_size=2000))
def test_any_text_has_an_answer(text: str) -> None:
    assert isinstance(PLANNER.plan(text), (Matched, UnknownPlace, NoMatch))
    is_stop(text)
    is_end_task(text)


HEAP = (
    'go to the kitchen a and then turn left 90 degrees metres half one . , ! please say " hello back up at for m/s '
    "0.5 slowly twice around arm raise your moon beep stop it can you another about square hundred point minus of "
    "in place with if not"
)


@settings(deadline=None)
@given(st.lists(st.sampled_from(HEAP.split()), max_size=60).map(" ".join))
def test_any_heap_of_known_words_has_an_answer_that_keeps_to_what_was_said(text: str) -> None:
    found = PLANNER.plan(text)
    if isinstance(found, Matched):
        places = {call.positional[0] for call in found.calls if call.name == "navigation"}
        assert places <= {"A", "zero"}
        assert "not" not in text.split() or any(call.name in ("say", "stop") for call in found.calls)
        condition = "if" in text.replace("if you can", "").split()  # which is politeness
        assert not condition or any(call.name in ("say", "stop") for call in found.calls)


def test_an_empty_map_is_no_obstacle() -> None:
    planner = PhrasePlanner({})
    assert planner.plan("go to the moon") == UnknownPlace("moon", ())
    nothing = planner.plan("juggle")
    assert isinstance(nothing, NoMatch)
    assert "{" not in nothing.understood


def test_a_language_without_phrases_is_a_usage_error() -> None:
    with pytest.raises(UsageError, match="tlh"):
        PhrasePlanner(PLACES, "tlh")


def test_every_intent_of_the_phrase_file_has_a_meaning() -> None:
    from engine.planner.phrases.meanings import INTENTS

    sections = load("en")
    written = sections["intents"].keys() | sections["open_intents"].keys()
    assert written == INTENTS | {"Somewhere"}


@pytest.mark.skipif(not COMMANDS.exists(), reason="needs the development commands in ../shared/data")
def test_requests_that_need_more_than_phrases_get_no_plan() -> None:
    beyond = ("cond", "clarify", "refuse", "chat")
    commands = [c["command"] for c in json.loads(COMMANDS.read_text()) if c["category"] in beyond]
    assert len(commands) > 15
    assert [text for text in commands if isinstance(PLANNER.plan(text), Matched)] == []


@pytest.mark.parametrize(
    "said", ["go go forward 10 meters", "Go, go forward 10 meters.", "go forward forward 10 meters"]
)
def test_a_stammer_is_forgiven(said: str) -> None:
    assert PLANNER.plan(said) == PLANNER.plan("go forward 10 meters")


def test_a_repeated_number_is_no_stammer() -> None:
    assert isinstance(PLANNER.plan("go forward 2 2 meters"), NoMatch)


@pytest.mark.parametrize(
    ("said", "together"),
    [
        ("go to the kitchen and raise your arm at the same time", [False, True]),
        ("raise your arm and simultaneously turn left 90 degrees", [False, True]),
        ("go to the kitchen, and meanwhile nod, then beep", [False, True, False]),
        ("at the same time raise your arm", [False]),  # as what?
        ("go to the kitchen, then raise your arm", [False, False]),
    ],
)
def test_what_is_to_happen_at_the_same_time_starts_together(said: str, together: list[bool]) -> None:
    match = PLANNER.plan(said)
    assert isinstance(match, Matched)
    assert [call.alongside for call in match.calls] == together


def test_an_answer_says_what_happens_at_the_same_time() -> None:
    match = PLANNER.plan("go to the kitchen and raise your arm at the same time, then beep")
    assert isinstance(match, Matched)
    assert match.response == "Going to the kitchen and at the same time raising the arm, then beeping."
