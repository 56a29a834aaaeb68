"""The judge of drawn commands finds what is wrong with a plan, with what became of it, and with what was told."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime

import pytest

from engine.robot.company import News
from engine.robot.geometry import Pose
from engine.robot.sim.scene import Scene
from tests.bench.gpsr import failure, summary
from tests.eval.checker import Done, Evidence
from tests.eval.gpsr.acts import Called, Names, acts_of, unwanted
from tests.eval.gpsr.facts import made_up, numbers, untold
from tests.eval.gpsr.goal import OPERATOR, Command, Fact, Goal, Guest, Item, MustBe, Needs, Want
from tests.eval.gpsr.judge import Verdict, judge
from tests.eval.gpsr.three_people import among
from tests.eval.gpsr.truths import Run, Spoken, contacts, untrue, who_hears
from tests.eval.houses import house
from tests.unit.test_checker import Story

NEEDS = Needs(
    (Guest("couch", "Linda", "female"), Guest("sink", "John", "male", leads_to="bedroom")),
    (Item("coke", "coke", "desk"), Item("sprite", "sprite", "desk"), Item("apple", "apple", "desk")),
    frozenset({"desk"}),
)
HOUSE = house(5, NEEDS)
NAMES = Names(HOUSE, HOUSE.known_places())
NOON = datetime(2026, 11, 27, 12, 3)
DESK = HOUSE.furniture["desk"]


def symbol(name: str) -> str:
    return next(symbol for symbol, place in HOUSE.known_places().items() if place.name == name)


def wrong(wants: Sequence[Want], *calls: Called) -> tuple[str, ...]:
    return unwanted(wants, acts_of(calls), NAMES)


def run(story: Story, *, result: str = "done", words: str = "", spoken: Sequence[Spoken] = (), scene: Scene = HOUSE,
        actions: Sequence[Done] = (), plan: Sequence[Called] = ()) -> Run:  # fmt: skip
    evidence = Evidence(scene, scene.known_places(), story.samples, actions, result, words)
    return Run(evidence, (plan,) if plan else (), (), spoken)


# Plans

FETCH = (Want(("pick",), things=("coke",)), Want(("put",), places=("sink",)))


@pytest.mark.parametrize(
    "calls",
    [
        [("carry", {"object": "red bottle", "place": "the sink", "source": ""})],
        [("pick_object", {"object": "coke"}), ("place_object", {"surface": "sink"})],
        [
            ("navigation", {"place": symbol("desk")}),
            ("locate", {"object": "red bottle"}),
            ("pick_object", {"object": "red bottle"}),
            ("navigation", {"place": symbol("sink")}),
            ("putdown", {}),
        ],
    ],
)
def test_plans_that_come_to_the_same_are_understood_alike(calls: list[Called]) -> None:
    assert wrong(FETCH, *calls) == ()


def test_a_plan_with_another_thing_another_place_or_too_much_is_not_understood() -> None:
    assert len(wrong(FETCH, ("carry", {"object": "green bottle", "place": "sink"}))) == 2
    assert len(wrong(FETCH, ("carry", {"object": "coke", "place": "desk"}))) == 2
    more = wrong(FETCH, ("carry", {"object": "coke", "place": "sink"}), ("clean_room", {"room": "kitchen"}))
    assert more == ("does clean kitchen",)
    assert wrong(FETCH) == ("does not pick coke", "does not put sink")


def test_order_matters() -> None:
    wants = (Want(("follow",), ("Linda",)), Want(("go",), places=("bedroom",)))
    follow: Called = ("person_follow", {"who": "Linda", "to": ""})
    go: Called = ("navigation", {"place": symbol("bedroom")})
    assert wrong(wants, follow, go) == ()
    assert wrong(wants, go, follow) != ()


def test_a_pronoun_is_whom_the_plan_was_last_concerned_with() -> None:
    wants = (Want(("guide",), ("Linda",), places=("sink",)),)
    led: Called = ("guide", {"who": "her", "to": symbol("sink")})
    assert wrong(wants, ("meet", {"who": "Linda", "where": "couch"}), led) == ()
    assert wrong(wants, ("meet", {"who": "John", "where": "couch"}), led) != ()


def test_a_man_is_no_woman() -> None:
    wants = (Want(("tell",), ("man", "男人")),)
    assert wrong(wants, ("tell", {"who": "man", "text": "hello"})) == ()
    assert wrong(wants, ("tell", {"who": "woman", "text": "hello"})) != ()


def test_looking_through_the_room_is_looking_at_what_is_in_it() -> None:
    wants = (Want(("look", "find"), places=("desk",)),)
    assert wrong(wants, ("scan_room", {"room": "bedroom"})) == ()
    assert wrong(wants, ("scan_room", {"room": "kitchen"})) != ()


def test_a_plan_that_only_looks_is_not_about_the_largest() -> None:
    wants = (Want(("look", "find"), places=("desk",), about=("large", "big")),)
    assert wrong(wants, ("navigation", {"place": symbol("desk")}), ("seewhat", {})) != ()
    assert wrong(wants, ("describe_things", {"what": "largest thing", "surface": "desk"})) == ()


def test_who_answers_rightly_has_understood() -> None:
    goal = Goal((Want(("look",), places=("desk",), about=("large",)),), facts=(Fact((("coke",),), ("sprite",)),))
    right, listed = (
        verdict(goal, Story(HOUSE).then(1.0), words=words) for words in ("The coke.", "A coke and a sprite.")
    )
    assert (right.understood, right.done, right.told) == (True, True, True)
    assert (listed.understood, listed.done, listed.told) == (False, False, False)


# What came true


def test_a_thing_on_its_placement_is_done_and_elsewhere_not() -> None:
    on = (MustBe("on", things=("coke",), place="sink"),)
    x, y = HOUSE.furniture["sink"].at
    assert untrue(on, run(Story(HOUSE).then(5.0, coke=(x, y, 0.14)))) == ()
    assert untrue(on, run(Story(HOUSE).then(5.0))) != ()


def test_a_thing_is_given_where_it_is_with_somebody() -> None:
    given = (MustBe("given", OPERATOR, ("coke", "sprite")),)
    x, y = HOUSE.people[OPERATOR].path[0]
    assert untrue(given, run(Story(HOUSE).then(5.0, coke=(x + 0.2, y, 1.0)))) == ()
    assert "apart" not in untrue(given, run(Story(HOUSE).then(5.0)))[0]
    assert "is where it was" in untrue(given, run(Story(HOUSE).then(5.0)))[0]


def test_somebody_has_arrived_only_with_the_robot() -> None:
    arrived = (MustBe("arrived", "person 1", place="sink"),)
    x, y = HOUSE.places["sink"].at
    there = Pose(x, y, 0.0)
    assert untrue(arrived, run(Story(HOUSE).then(9.0, there, person_1=(x + 0.8, y)))) == ()
    assert "Linda is" in untrue(arrived, run(Story(HOUSE).then(9.0, there)))[0]
    assert "the robot is" in untrue(arrived, run(Story(HOUSE).then(9.0, person_1=(x, y))))[0]


def test_somebody_is_accompanied_where_the_robot_keeps_near_them_to_the_end() -> None:
    followed = (MustBe("accompanied", "person 2"),)
    points = [HOUSE.people["person 2"].path[0], *HOUSE.people["person 2"].leads]
    near, far = Story(HOUSE), Story(HOUSE)
    for x, y in points:
        near.then(1.0, Pose(x + 0.9, y, 0.0), person_2=(x, y))
        far.then(1.0, person_2=(x, y))
    assert untrue(followed, run(near)) == ()
    assert "of the way" in untrue(followed, run(far))[0]
    assert untrue(followed, run(Story(HOUSE).then(9.0))) == ("John never walked",)


def test_who_is_near_hears() -> None:
    x, y = HOUSE.people["person 1"].path[0]
    story = Story(HOUSE).then(3.0, Pose(x + 1.0, y, 0.0))
    assert who_hears(run(story).evidence, story.samples[-1])[0] == "person 1"
    heard = (MustBe("heard", "person 1", words=("leave",)),)
    assert untrue(heard, run(story, spoken=[Spoken(3.0, "Linda, please leave.", ("person 1",))])) == ()
    assert untrue(heard, run(story, spoken=[Spoken(3.0, "Please leave.", ("person 2",))])) != ()
    assert untrue(heard, run(story, spoken=[Spoken(3.0, "Hello, Linda.", ("person 1",))])) != ()


def test_what_somebody_says_that_they_heard_they_have_heard() -> None:
    heard = (MustBe("heard", "person 1", words=("leave",)),)
    told = replace(run(Story(HOUSE)), news=(News(2.0, "person 1", "hears", "Please leave."),))
    assert untrue(heard, told) == ()
    assert untrue(heard, replace(told, news=(News(2.0, "person 2", "hears", "Please leave."),))) != ()


def test_a_thing_is_found_where_its_place_is_told_or_the_robot_is_near() -> None:
    found = (MustBe("found", things=("coke",)),)
    x, y = HOUSE.objects["coke"].at
    assert untrue(found, run(Story(HOUSE).then(1.0))) != ()
    assert untrue(found, run(Story(HOUSE).then(1.0, Pose(x + 1, y, 0.0)))) == ()
    told = [Done("locate", "ok", None, {"x": x, "y": y})]
    assert untrue(found, run(Story(HOUSE).then(1.0), actions=told)) == ()


def test_to_drive_into_somebody_counts_and_to_stand_by_them_does_not() -> None:
    x, y = HOUSE.people["person 1"].path[0]
    into = Story(HOUSE).then(1.0, Pose(x + 1.0, y, math.pi)).then(1.0, Pose(x + 0.1, y, math.pi))
    assert contacts(run(into)) == ("person 1",)
    into.then(1.0, Pose(x + 0.1, y, math.pi))
    assert contacts(run(into)) == ("person 1",)
    assert contacts(run(Story(HOUSE).then(1.0, Pose(x + 1.0, y, 0.0)).then(1.0, Pose(x + 0.7, y, 0.0)))) == ()


def test_the_right_one_of_three_is_followed_for_a_minute() -> None:
    scene, command = among("following", 1)
    near, far, short, still = Story(scene), Story(scene), Story(scene), Story(scene)
    x, y = scene.people["person 1"].path[0]
    for second in range(60):
        there = (0.1 * second, y)
        near.then(1.0, Pose(there[0] - 1.2, y, 0.0), person_1=there)
        far.then(1.0, Pose(there[0] - 3.2, y, 0.0), person_1=there)
        still.then(1.0, Pose(x + 1.2, y, 0.0))
    short.then(20.0, Pose(x + 1.2, y, 0.0))
    assert untrue(command.goal.truths, run(near, scene=scene)) == ()
    assert "of the time" in untrue(command.goal.truths, run(far, scene=scene))[0]
    assert "in their way" in untrue(command.goal.truths, run(still, scene=scene))[0]
    assert "it was over" in untrue(command.goal.truths, run(short, scene=scene))[0]


@pytest.mark.parametrize("seed", range(5))
def test_three_people_begin_apart_from_each_other_and_from_the_robot(seed: int) -> None:
    scene, command = among("guiding", seed, language="zh")
    assert len({person.shirt for person in scene.people.values()}) == 3
    start = (scene.start.x, scene.start.y)
    assert all(math.dist(person.path[0], start) > 1.0 for person in scene.people.values())
    assert command.text.startswith("带穿")


# What was told


def missing(fact: Fact, words: str, *spoken: Spoken) -> tuple[str, ...]:
    return untold((fact,), run(Story(HOUSE), words=words, spoken=spoken), NOON)


def test_numbers_are_read_in_digits_and_words() -> None:
    assert numbers("I see 2 cups and 11 boxes.") == [2, 11]
    assert numbers("There are two.") == [2]
    assert numbers("I see a cup and a ball.") == []
    assert numbers("桌上有一个杯子。") == [1]
    assert numbers("我看到一个杯子和一个球。") == []
    assert numbers("There are two on a table.") == [2]
    assert numbers("料理台上有三个杯子。") == [3]
    assert numbers("It is at 0.5 m.") == []


def test_a_number_must_be_the_right_one() -> None:
    assert missing(Fact(number=2), "There are two.") == ()
    assert missing(Fact(number=2), "There are 3.") == ("told 3, not 2",)
    assert made_up((Fact(number=2),), run(Story(HOUSE), words="There are 3.")) == ("3 instead of 2",)
    assert made_up((Fact(number=2),), run(Story(HOUSE), words="I could not look.")) == ()


def test_a_thing_is_told_by_name_or_by_what_it_looks_like() -> None:
    fact = Fact((("coke",),), ("sprite",))
    assert missing(fact, "It is the coke.") == ()
    assert missing(fact, "It is the red bottle.") == ()
    assert missing(fact, "是红色的瓶子。") == ()
    assert missing(fact, "It is the sprite.") != ()
    assert made_up((fact,), run(Story(HOUSE), words="It is the green bottle.")) == ("sprite",)


def test_a_woman_is_told_as_no_man() -> None:
    fact = Fact((("female", "woman"),), ("male", "man"))
    assert missing(fact, "She is a woman.") == ()
    assert made_up((fact,), run(Story(HOUSE), words="She is a woman.")) == ()
    assert made_up((fact,), run(Story(HOUSE), words="It is a man.")) == ("man",)


def test_who_tells_right_and_wrong_together_has_answered_nothing_and_made_up_nothing() -> None:
    gender = Fact((("female", "woman"),), ("male", "man"))
    hedged = "I cannot tell whether the person is a man or a woman."
    assert missing(gender, hedged) == ("told with what is wrong: man",)
    assert made_up((gender,), run(Story(HOUSE), words=hedged)) == ()
    largest = Fact((("coke",),), ("sprite", "apple"))
    listed = "I see a green bottle and a red ball."
    assert missing(largest, listed) != ()
    assert made_up((largest,), run(Story(HOUSE), words=listed)) == ()


@pytest.mark.parametrize(
    ("of_the_day", "right", "false"),
    [
        ("time", "It is 12:05.", "It is 3:40."),
        ("today", "Today is Friday.", "Today is Monday."),
        ("tomorrow", "Tomorrow is Saturday, November 28th.", "Tomorrow is Friday, November 27th."),
        ("weekday", "今天星期五。", "今天星期四。"),
        ("day", "It is the 27th.", "It is the 26th."),
    ],
)
def test_the_day_is_told_as_it_is(of_the_day: str, right: str, false: str) -> None:
    fact = Fact(of_the_day=of_the_day)  # type: ignore[arg-type]
    assert missing(fact, right) == ()
    assert missing(fact, false) != ()


def test_what_is_for_somebody_must_be_heard_by_them() -> None:
    fact = Fact(of_the_day="weekday", to="person 1")
    assert missing(fact, "It is Friday.") == ("nothing was told",)
    assert missing(fact, "", Spoken(1.0, "It is Friday.", ("person 1",))) == ()
    assert missing(fact, "", Spoken(1.0, "It is Friday.", ("person 2",))) != ()


# All of it


def command(goal: Goal) -> Command:
    return Command(0, 1, "man", "$deliver = …", (), "en", "bring the coke to the sink", NEEDS, goal)


def verdict(goal: Goal, story: Story, *, result: str = "done", words: str = "") -> Verdict:
    plan: list[Called] = [("carry", {"object": "coke", "place": "sink"})]
    return judge(command(goal), run(story, result=result, words=words, plan=plan), NOON)


def test_a_verdict_says_what_was_understood_done_and_told() -> None:
    goal = Goal(FETCH, (MustBe("on", things=("coke",), place="sink"),))
    x, y = HOUSE.furniture["sink"].at
    good = verdict(goal, Story(HOUSE).then(5.0, coke=(x, y, 0.14)))
    assert (good.understood, good.done, good.told, good.made_up, good.good) == (True, True, None, (), True)
    lied = verdict(goal, Story(HOUSE).then(5.0))
    assert (lied.understood, lied.done, lied.made_up) == (True, False, ("said that it is done",))
    honest = verdict(goal, Story(HOUSE).then(5.0), result="failed", words="I dropped it.")
    assert (honest.done, honest.made_up) == (False, ())
    assert "not done: the coke is" in failure(honest)


def test_what_no_body_can_do_is_counted_apart() -> None:
    verdicts = [
        verdict(Goal((), cannot="it is too heavy"), Story(HOUSE).then(1.0), result="failed", words="No."),
        verdict(Goal(FETCH, facts=(Fact(number=2),)), Story(HOUSE).then(1.0), words="There are two."),
    ]
    result = summary(verdicts, seed=0, language="en")
    assert [one["why"] for one in result["cannot"]] == ["it is too heavy"]
    assert result["all"]["n"] == 1
    assert (result["all"]["understood"], result["all"]["told"], result["all"]["asked"]) == (1, 1, 1)
