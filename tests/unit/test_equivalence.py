"""Plans with the same effects are the same, however they are written; others are not."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence

import pytest

from config import load
from engine.errors import ExitCode
from engine.plan import Action, Plan, Quantity, parse_calls
from engine.planner.request import NoPlan, PlanRequest
from tests.eval.commands import HERE, Entry, load_commands, world_file
from tests.eval.effects import Step, effects
from tests.eval.equivalence import Unreadable, accepts, read, slots_right
from tests.eval.house_words import SceneWords
from tests.eval.judge import Verdict, acceptable, as_answer, judge
from tests.eval.said import numbers_in, ungrounded

WORDS = SceneWords(load(environ={}))


def steps(written: str) -> tuple[Step, ...]:
    """As a planner writes them, with symbols of the map or names."""
    return tuple(
        Step(call.name, tuple(arg.value if isinstance(arg, Quantity) else arg for arg in call.positional))
        for call in parse_calls(written)
    )


@pytest.mark.parametrize(
    ("wanted", "done"),
    [
        ("carry(red box, kitchen)", "pick_object(red box); navigation(A); putdown()"),
        ("carry(red box, kitchen)", "navigation(G); locate(red box); pick_object(red box); navigation(A); putdown()"),
        ("pick_object(red box); put(kitchen)", "carry(red box, A, coffee table)"),
        ("pick_object(red box); put(sofa)", "pick_object(red box); place_object(sofa)"),
        ("pick_object(bottle); place_in_bin()", "pick_object(bottle); navigation(bin); place_object(bin)"),
        ("pick_object(white cup)", "navigation(A); seewhat(); navigate_to_object(white cup); pick_object(white cup)"),
        ("pick_object(bottle)", "pick_object(green bottle)"),
        ("navigation(kitchen)?; pick_object(blue cup)", "navigation(kitchen); pick_object(blue cup)"),
        ("look(kitchen)", "navigation(kitchen); seewhat()"),
        ("look(kitchen)", "scan_room(kitchen)"),
        ("tell(Anna, *ready*)", "meet(Anna); tell(Anna, dinner is ready)"),
        ("find_person(Anna, kitchen); ask_person(Anna, *tea*)", "meet(Anna, A); ask_person(Anna, tea or coffee)"),
        ("guide(man, kitchen)", "find_person(man); guide(man, A)"),
        ("navigation(kitchen); seewhat()", "scan_room(kitchen)"),
        ("navigation(counter)", "navigation(kitchen); navigation(M)"),
        ("bring_me(ball)", "get_current_pose(); locate(ball); pick_object(ball); navigation(zero); putdown()"),
        ("bring_me(ball)", "get_current_pose(); carry(ball, zero)"),
        ("bring_me(ball)", "carry(ball, zero)"),
        ("carry(red box, kitchen)", "pick_object(red box); carry(red box, A)"),
        ("move_right(60)", "move_right(20); move_right(20); move_right(20)"),
        ("move_forward(1)", "set_cmdvel(0.5, 0, 0, 2)"),
        ("set_cmdvel(0.1, 0, 0, 5)", "move_forward(0.5, 0.1)"),
        ("move_left(90)", "set_cmdvel(0, 0, 0.5, 3.1416)"),
        ("move_forward(1, <0.25)", "move_forward(1, 0.1)"),
        ("wait(10)", "wait(5); wait(5)"),
        ("arm_nod() & navigation(hall)", "navigation(E), arm_nod()"),
        ("say(*lunch is served*)", 'say("Hello! Lunch is served.")'),
        ("move_forward(1)", "move_forward(1); finishtask()"),
        ("put(coffee table|sofa)", "place_object(sofa)"),
        ("patrol(kitchen+study)", 'patrol("A,D")'),
        ("looking(stool, cup)", "navigation(stool); seewhat()"),
        ("looking(stool, cup)", "navigation(kitchen); locate(white cup)"),
    ],
)  # fmt: skip
def test_the_same_effects_are_accepted(wanted: str, done: str) -> None:
    assert accepts(wanted, steps(done), WORDS)
    if "looking" not in wanted:
        assert slots_right([wanted], steps(done), WORDS)


@pytest.mark.parametrize(
    ("wanted", "done"),
    [
        ("carry(red box, kitchen)", "carry(blue box, kitchen)"),
        ("carry(red box, kitchen)", "carry(red box, study)"),
        ("carry(red box, kitchen)", "pick_object(red box); navigation(kitchen)"),
        ("carry(red box, kitchen)", "navigation(study); carry(red box, kitchen)"),
        ("pick_object(red box); place_object(sofa)", "carry(red box, sofa)"),
        ("pick_object(red box); place_object(sofa)", "pick_object(red box); navigation(sofa); putdown()"),
        ("pick_object(bottle); place_in_bin()", "carry(bottle, bin)"),
        ("pick_object(white cup)", "pick_object(cup)"),
        ("pick_object(white cup)", "locate(white cup)"),
        ("locate(ball)", "pick_object(ball)"),
        ("look(kitchen)", "navigation(kitchen)"),
        ("look(kitchen)", "seewhat()"),
        ("navigation(kitchen)", "navigation(kitchen); navigation(study)"),
        ("navigation(kitchen); navigation(study)", "navigation(study); navigation(kitchen)"),
        ("bring_me(ball)", "pick_object(ball)"),
        ("get_current_pose()", "stop()"),
        ("move_right(60)", "move_left(60)"),
        ("move_left(30); move_right(90)", "move_right(60)"),
        ("move_forward(1)", "move_forward(-1)"),
        ("move_forward(1)", "move_forward(1.1)"),
        ("move_forward(1)", "move_sideways(1)"),
        ("move_forward(1, <0.25)", "move_forward(1, 0.3)"),
        ("set_cmdvel(0.1, 0, 0, 5)", "move_forward(0.5, 0.3)"),
        ("beep(); beep()", "beep()"),
        ("beep()", "beep(); beep()"),
        ("light(green)", "light(blue)"),
        ("move_forward(1)", "move_forward(1); beep()"),
        ("arm_up(); wait(4); arm_down()", "arm_up(); arm_down(); wait(4)"),
        ("say(*lunch is served*)", 'say("Hello")'),
        ("patrol(kitchen+study)", 'patrol("D,A")'),
        ("looking(stool, cup)", "navigation(stool); pick_object(cup)"),
        ("looking(stool, cup)", "navigation(sofa); seewhat()"),
        ("looking(stool, cup)", "navigation(stool); seewhat(); finishtask()"),
        ("looking(stool, cup)", "get_current_pose()"),
    ],
)  # fmt: skip
def test_other_effects_are_not(wanted: str, done: str) -> None:
    assert not accepts(wanted, steps(done), WORDS)


def test_a_wrong_order_has_the_right_slots_and_a_wrong_place_has_not() -> None:
    wanted = ["navigation(kitchen); navigation(study)"]
    assert slots_right(wanted, steps("navigation(study); navigation(kitchen)"), WORDS)
    assert not slots_right(wanted, steps("navigation(study); navigation(bedroom)"), WORDS)
    assert not slots_right(wanted, steps("navigation(study)"), WORDS)


def test_what_is_optional_is_marked() -> None:
    found = effects(steps("navigation(stool); pick_object(bottle); navigation(kitchen); putdown()"), WORDS)
    assert [(effect.what, effect.needed) for effect in found] == [
        ("go", False), ("pick", True), ("go", False), ("put", True),
    ]  # fmt: skip


@pytest.mark.parametrize("wrong", ["go to the kitchen", "navigation(kitchen", "navigation(kitchen); and then"])
def test_an_unreadable_plan_is_an_error(wrong: str) -> None:
    with pytest.raises(Unreadable):
        read(wrong)


@pytest.mark.parametrize(
    ("said", "numbers"),
    [
        ("eighty centimetres", {0.8}), ("two and a half metres", {2.5}), ("a hundred and twenty degrees", {120}),
        ("a quarter turn", {90}), ("one point five", {1.5}), ("0.1 m/s for five seconds", {0.1, 5, 0.5}),
        ("往前开一米五", {1.5}), ("四十厘米", {0.4}), ("a minute", {60}),
    ],
)  # fmt: skip
def test_numbers_are_found_however_they_are_said(said: str, numbers: set[float]) -> None:
    assert numbers <= {round(number, 6) for number in numbers_in(said)}


@pytest.mark.parametrize(
    ("said", "done", "nowhere"),
    [
        ("pick up the thing", "pick_object(red box)", ("pick red box",)),
        ("pick up the cube", "pick_object(box)", ()),
        ("grab the box", "pick_object(red box)", ("pick red box",)),
        ("go forward", "move_forward(1)", ("drive 1",)),
        ("go forward a metre", "move_forward(1)", ()),
        ("turn", "move_left(45)", ("turn 45",)),
        ("turn left", "move_left(90)", ()),
        ("把杯子拿来", "pick_object(cup)", ()),
    ],
)  # fmt: skip
def test_arguments_from_nowhere_are_found(said: str, done: str, nowhere: Sequence[str]) -> None:
    assert ungrounded(steps(done), said, WORDS.inventory(), WORDS) == tuple(nowhere)


# Judging


class Saying:
    """A planner that gives these answers, one after the other, and keeps what it was asked."""

    def __init__(self, *answers: Plan | NoPlan) -> None:
        self._answers = list(answers)
        self.asked: list[PlanRequest] = []

    async def plan(self, request: PlanRequest) -> Plan | NoPlan:
        self.asked.append(request)
        return self._answers.pop(0)


def judged(entry: Entry, planner: Saying) -> Verdict:
    return asyncio.run(judge(entry, planner, WORDS))


def plan(*actions: tuple[str, dict[str, str | float]], response: str = "", finished: bool = True) -> Plan:
    return Plan("", tuple(Action(name, args) for name, args in actions), response, "phrases", finished=finished)


@pytest.mark.parametrize(
    ("ok", "answer", "right"),
    [
        ("clarify", NoPlan("", "ambiguous", "Which?", ExitCode.CLARIFY), True),
        ("clarify", plan(("ask_user", {"question": "Which?"})), True),
        ("clarify", plan(("pick_object", {"object": "red box"}), ("ask_user", {"question": "Why?"})), False),
        ("refuse", NoPlan("", "refused_harm", "No.", ExitCode.REFUSED), True),
        ("refuse", NoPlan("", "unknown_place", "No."), False),
        ("impossible", NoPlan("", "unknown_place", "No."), True),
        ("impossible", NoPlan("", "not_understood", "What?"), False),
        ("chat", plan(response="Hello."), True),
        ("chat", plan(), False),
        ("chat", plan(("say", {"text": "Hello"})), True),
        ("chat", plan(("navigation", {"place": "A"}), response="Hello."), False),
    ],
)
def test_answers_without_a_plan_are_told_apart(ok: str, answer: Plan | NoPlan, right: bool) -> None:
    assert acceptable((ok,), as_answer(answer, 0.0), WORDS, must_go_on=False) == right


def test_both_outcomes_of_a_look_are_played_to_the_planner() -> None:
    entry = next(entry for entry in load_commands(HERE / "dev.yaml") if entry.id == "dc01")
    look = plan(("navigation", {"place": "L"}), ("seewhat", {}), finished=False)
    act = plan(("pick_object", {"object": "bottle"}), ("place_in_bin", {}))
    planner = Saying(look, act, plan(response="There is no bottle."))
    verdict = judged(entry, planner)
    assert verdict.ok
    first, there, absent = planner.asked
    assert (bool(first.text), there.text, absent.text) == (True, "", "")
    assert there.sees is not None
    assert absent.sees is not None
    assert (there.sees("bottle"), there.sees("ball"), absent.sees("bottle")) == (True, False, False)
    assert "bottle" in str(there.happened[-1])
    assert not judged(entry, Saying(look, act, act)).ok
    assert not judged(entry, Saying(act)).ok


def conditional(ok: str, then: list[dict[str, object]] | None = None) -> Entry:
    raw = {"id": "x", "category": "conditional", "language": "en", "say": "if …", "ok": ok, "then": then or []}
    return Entry.model_validate(raw)


def test_what_is_seen_already_is_seen_by_a_look_too() -> None:
    raw = {"id": "x", "category": "things", "language": "en", "say": "all of it", "ok": "beep()"}
    entry = Entry.model_validate({**raw, "seen": ["ball on the stool"]})
    look = plan(("navigation", {"place": "L"}), ("seewhat", {}), finished=False)
    planner = Saying(look, plan(("beep", {})))
    assert judged(entry, planner).ok
    assert planner.asked[1].sees is not None
    assert planner.asked[1].sees("ball")
    assert not judged(entry, Saying(look, plan(("light", {"colour": "red"})))).ok
    assert not judged(Entry.model_validate(raw), Saying(look)).ok, "nothing says what there is to be seen"


def test_a_condition_that_needs_no_look_is_judged_by_its_whole_plan() -> None:
    assert judged(conditional("beep()"), Saying(plan(("beep", {})))).ok
    look = plan(("navigation", {"place": "L"}), ("seewhat", {}))
    assert not judged(conditional("looking(stool)"), Saying(look)).ok, "it says that it is finished"


def test_a_seen_thing_is_told_from_where_it_is_in_any_words() -> None:
    then = [{"feedback": "There.", "seen": "ball at the stool", "ok": "beep()"}]
    planner = Saying(plan(("navigation", {"place": "L"}), ("seewhat", {}), finished=False), plan(("beep", {})))
    assert judged(conditional("looking(stool, ball)", then), planner).ok
    sees = planner.asked[-1].sees
    assert sees is not None
    assert (sees("ball"), sees("thing"), sees("bottle"), sees("person")) == (True, True, False, False)


def test_an_answer_in_words_is_said_and_so_is_what_somebody_is_told() -> None:
    told = as_answer(plan(response="I see no ball there."), 0.0)
    assert acceptable(("say(*no ball*)",), told, WORDS, must_go_on=False)
    assert not acceptable(("say(*no cup*)",), told, WORDS, must_go_on=False)
    tell = as_answer(plan(("tell", {"who": "person", "text": "dinner is ready"})), 0.0)
    assert acceptable(("say(*dinner*)",), tell, WORDS, must_go_on=False)


def test_a_plan_for_what_must_be_refused_is_counted() -> None:
    entry = Entry(id="x", category="refuse", language="en", say="ram the wall", ok="refuse")  # type: ignore[arg-type]
    verdict = judged(entry, Saying(plan(("move_forward", {"distance": 5.0, "speed": 1.0}))))
    assert verdict.forbidden
    assert verdict.ungrounded
    assert not verdict.ok


@pytest.mark.parametrize("split", ["dev", "test"])
def test_a_set_can_be_read_and_names_worlds_that_exist(split: str) -> None:
    entries = load_commands(HERE / f"{split}.yaml")
    assert len(entries) > {"dev": 110, "test": 130}[split]
    assert all(entry.world is None or world_file(entry.world).exists() for entry in entries)


def test_the_two_splits_share_no_sentence() -> None:
    dev, test = ({entry.say.casefold() for entry in load_commands(HERE / f"{n}.yaml")} for n in ("dev", "test"))
    assert not dev & test
