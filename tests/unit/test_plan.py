"""The reader of action strings: calls or a PlanError, and never evaluation."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.errors import PlanError
from engine.events import ActionView
from engine.plan import MAX_ACTIONS, MAX_TEXT, Action, ActionCall, Plan, Quantity, parse_call, parse_calls


def bare(*numbers: float) -> tuple[Quantity, ...]:
    return tuple(Quantity(float(number)) for number in numbers)


@pytest.mark.parametrize(
    ("text", "call"),
    [
        ("set_cmdvel(0.5, 0, 0, 2)", ActionCall("set_cmdvel", bare(0.5, 0, 0, 2))),
        ("set_cmdvel(-0.1,0,0,5)", ActionCall("set_cmdvel", bare(-0.1, 0, 0, 5))),
        ("  nod ( ) ", ActionCall("nod")),
        ("nod", ActionCall("nod")),
        ("wait(+.5e1)", ActionCall("wait", bare(5))),
        ("wait(5.)", ActionCall("wait", bare(5))),
        ("move_forward(50 cm)", ActionCall("move_forward", (Quantity(50, "cm"),))),
        ("move_forward(50cm)", ActionCall("move_forward", (Quantity(50, "cm"),))),
        ("turn(90°)", ActionCall("turn", (Quantity(90, "°"),))),
        ("go(0.2 m/s)", ActionCall("go", (Quantity(0.2, "m/s"),))),
        ("go(0.2 m / s)", ActionCall("go", (Quantity(0.2, "m/s"),))),
        ("navigation(B)", ActionCall("navigation", ("B",))),
        ("navigation(living room)", ActionCall("navigation", ("living room",))),
        ("navigation(room 2)", ActionCall("navigation", ("room 2",))),
        ('say("hello, (world)")', ActionCall("say", ("hello, (world)",))),
        ("say('it is \\'fine\\'')", ActionCall("say", ("it is 'fine'",))),
        ('say("a\\nb\\\\c\\"d")', ActionCall("say", ('a\nb\\c"d',))),
        ('say("")', ActionCall("say", ("",))),
        ("move(by=-1 m, speed = 0.2)", ActionCall("move", (), {"by": Quantity(-1, "m"), "speed": Quantity(0.2)})),
        ("move(1, speed=0.2)", ActionCall("move", bare(1), {"speed": Quantity(0.2)})),
        ("move(1,)", ActionCall("move", bare(1))),
        ("导航(厨房)", ActionCall("导航", ("厨房",))),
    ],
)
def test_an_action_is_read_as_written(text: str, call: ActionCall) -> None:
    assert parse_call(text) == call


def test_a_list_of_actions_keeps_its_order() -> None:
    assert [call.name for call in parse_calls("a(1), b; c('x, y'),d")] == ["a", "b", "c", "d"]
    assert parse_calls("") == parse_calls(" \n ") == ()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a(", "an argument"),
        ("a(1", "',' or ')'"),
        ("a)", "',', '&' or the end"),
        ("a(,)", "an argument"),
        ("a(1 2)", "'2' at character 5"),
        ("a(b=)", "an argument"),
        ("a(b=1, 2)", "without a name follows"),
        ("a(b=1, b=2)", "b is given twice"),
        ("a(x=y=z)", "'='"),
        ("a(((((1)))))", "an argument"),
        ("a()()", "',', '&' or the end"),
        ("a b", "'b' at character 3"),
        ("1(2)", "the name of an action"),
        ("()", "the name of an action"),
        ("a,,b", "the name of an action"),
        (", a", "the name of an action"),
        ("a(-)", "Cannot read"),
        ("a('x)", "Cannot read"),
        ("a('x\n')", "Cannot read"),
        ("a(1e999)", "too large"),
        ("a($HOME)", "Cannot read"),
        ("__import__('os').system('x')", "Cannot read"),
        ("a([1, 2])", "Cannot read"),
        ("a(b(1))", "',' or ')'"),
    ],
)
def test_a_fault_is_named_with_its_place(text: str, said: str) -> None:
    with pytest.raises(PlanError) as raised:
        parse_calls(text)
    assert said in raised.value.message


@pytest.mark.parametrize("text", ["", "a, b"])
def test_one_action_is_exactly_one(text: str) -> None:
    with pytest.raises(PlanError, match="Expected one action"):
        parse_call(text)


def test_a_runaway_list_is_turned_down() -> None:
    assert len(parse_calls(",".join(["a"] * MAX_ACTIONS))) == MAX_ACTIONS
    with pytest.raises(PlanError, match="More than"):
        parse_calls(",".join(["a"] * (MAX_ACTIONS + 1)))
    with pytest.raises(PlanError, match="at most"):
        parse_calls(" " * (MAX_TEXT + 1))


@settings(deadline=None)
@given(st.text(max_size=200) | st.text("ab12.,;()='\"\\-+ e°/%\n", max_size=60))
def test_any_text_becomes_calls_or_a_plan_error(text: str) -> None:
    try:
        calls = parse_calls(text)
    except PlanError:
        return
    assert all(isinstance(call, ActionCall) for call in calls)


NAMES = st.from_regex(r"[a-z_]{1,12}", fullmatch=True).filter(lambda name: name != "_")
NUMBERS = st.floats(allow_nan=False, allow_infinity=False)


@settings(deadline=None)
@given(NAMES, st.lists(NUMBERS, max_size=6))
def test_every_number_is_read_back_exactly(name: str, numbers: list[float]) -> None:
    assert parse_call(f"{name}({', '.join(map(repr, numbers))})") == ActionCall(name, bare(*numbers))


@settings(deadline=None)
@given(st.text(st.characters(exclude_characters="\n"), max_size=50))
def test_every_string_is_read_back_exactly(said: str) -> None:
    escaped = said.replace("\\", "\\\\").replace('"', '\\"')
    assert parse_call(f'say("{escaped}")').positional == (said,)


def test_an_action_shows_as_it_could_be_written() -> None:
    action = Action("set_cmdvel", {"linear_x": 0.5, "linear_y": 0.0, "angular_z": -1.0, "duration": 2.0})
    assert str(action) == "set_cmdvel(0.5, 0, -1, 2)"


def test_a_plan_becomes_the_event_that_announces_it() -> None:
    plan = Plan("go home", (Action("navigation", {"place": "E"}),), "Going home.", "phrases", ("Go home.",))
    event = plan.as_event()
    assert event.actions == (ActionView("navigation", {"place": "E"}),)
    assert (event.goal, event.steps, event.response, event.source) == (
        "go home",
        ("Go home.",),
        "Going home.",
        "phrases",
    )
