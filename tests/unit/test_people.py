"""Who the robot remembers to have seen: people walk, and are told apart by what they wear."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import cast, get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.perception.describe import in_words
from engine.perception.gestures import gesture_of
from engine.perception.memory import WorldMemory
from engine.perception.naming import wanted
from engine.perception.people import FASTEST, LONGEST_S, Looks, PeopleMemory, PersonSeen
from engine.perception.sighting import Colour, Figure, Sight, Sighting
from engine.robot.camera import Lens, Mount, Picture
from engine.robot.company import Gesture, Posture
from engine.robot.geometry import Pose
from engine.skills.context import SkillContext
from engine.skills.library.people import are_one, as_now

LENS = Lens.of_view(160, 120, math.radians(48))
AHEAD = Mount(np.array([[0, 0, 1.0], [-1.0, 0, 0], [0, -1.0, 0]]), np.array([0.0, 0.0, 0.5]))
"""A camera 50 cm above the floor that looks straight ahead."""
COLOURS = get_args(Colour)


def somebody(
    shirt: Colour | None = "red",
    x: float = 2.0,
    y: float = 0.0,
    *,
    trousers: Colour | None = None,
    posture: Posture | None = None,
    gesture: Gesture | None = None,
    hand: tuple[float, float, float] | None = None,
    tag: int | None = None,
) -> Sighting:
    figure = Figure(posture, gesture, shirt, trousers, hand)
    return Sighting("person", shirt or "grey", (60, 10, 100, 110), (x, y, 0.8), 0.08, (0.5, 1.5), x, 0.0, None, tag,
                    True, figure)  # fmt: skip


def saw(memory: PeopleMemory, *people: Sighting, t: float = 0.0, depth: float = 1.0) -> tuple[PersonSeen, ...]:
    """In a picture of a wall at ``depth``."""
    return memory.update(sight(*people, t=t, depth=depth))


def sight(*things: Sighting, t: float = 0.0, depth: float = 1.0) -> Sight:
    shape = (LENS.height, LENS.width)
    far = np.full(shape, depth, dtype=np.float32)
    return Sight(Picture(t, np.zeros((*shape, 3), dtype=np.uint8), far, LENS, AHEAD, Pose(0, 0, 0)), things, ())


def test_somebody_who_has_walked_on_is_the_same() -> None:
    memory = PeopleMemory()
    (first,) = saw(memory, somebody(x=2.0))
    (second,) = saw(memory, somebody(x=3.4), t=1.0)
    assert first.number == second.number
    assert [person.position[0] for person in memory.everybody] == [3.4]


def test_nobody_runs_through_the_house_in_a_second_but_in_a_minute_they_may_be_anywhere() -> None:
    memory = PeopleMemory()
    (first,) = saw(memory, somebody(x=1.0))
    (second,) = saw(memory, somebody(x=9.0), t=1.0)
    assert first.number != second.number
    memory = PeopleMemory()
    (first,) = saw(memory, somebody(x=1.0))
    (second,) = saw(memory, somebody(x=60.0), t=LONGEST_S + 1)
    assert first.number == second.number


@pytest.mark.parametrize("posture", ["sitting", "lying"])
def test_who_lies_or_sits_has_not_become_somebody_who_stands_elsewhere_until_their_place_is_seen_empty(
    posture: Posture,
) -> None:
    memory = PeopleMemory()
    (first,) = saw(memory, somebody("green", posture=posture))
    (second,) = saw(memory, somebody("green", 5.0, 2.0, posture="standing"), t=7.0)
    assert second.number != first.number
    assert len(memory.everybody) == 2
    memory.name_them(first.number, "William")
    saw(memory, t=8.0, depth=4.0)  # past where he was
    (third,) = saw(memory, somebody("green", 2.0, 1.5, posture="standing"), t=9.0)
    assert third.name == "William"


def test_somebody_of_whom_no_clothes_show_is_not_taken_for_one_who_was_elsewhere() -> None:
    memory = PeopleMemory()
    (first,) = saw(memory, somebody("orange", trousers="blue", posture="standing"))
    (second,) = saw(memory, somebody(None, 6.0, 2.0), t=5.0)
    assert second.number != first.number


@pytest.mark.parametrize(("apart", "posture", "later", "one"), [
    (0.8, "lying", 1.0, True), (0.8, "lying", 0.0, False), (1.2, "lying", 1.0, False),
    (0.8, "standing", 1.0, False), (0.3, "standing", 1.0, True),
])  # fmt: skip
def test_who_lies_is_long_and_two_in_one_picture_are_two(
    apart: float, posture: Posture, later: float, one: bool
) -> None:
    memory = PeopleMemory()
    if later:
        (first,) = saw(memory, somebody("blue", posture=posture))
        (second,) = saw(memory, somebody("white", 2.0 + apart, posture=posture), t=later)
    else:
        first, second = saw(
            memory, *(somebody(c, x, posture=posture) for c, x in (("blue", 2.0), ("white", 2.0 + apart)))
        )
    assert are_one(first, second) == one


@given(
    one=st.sampled_from(COLOURS), other=st.sampled_from(COLOURS), away=st.floats(0, 5), dt=st.floats(0, 100),
    by_trousers=st.booleans(),
)  # fmt: skip
def test_two_who_wear_different_clothes_are_never_one(
    one: Colour, other: Colour, away: float, dt: float, by_trousers: bool
) -> None:
    memory = PeopleMemory()
    first, second = (
        somebody("white", x, trousers=colour) if by_trousers else somebody(colour, x)
        for colour, x in ((one, 2.0), (other, 2.0 + away))
    )
    (before,) = saw(memory, first)
    (after,) = saw(memory, second, t=dt)
    near = away <= FASTEST * dt or dt > LONGEST_S
    if away < 0.35 and {one, other} in ({"white", "grey"}, {"grey", "black"}):
        return  # a shadow makes the one of the other
    assert (before.number == after.number) == (one == other and (near or away < 0.9)) or (one == other and not near)


def test_nobody_is_where_somebody_else_has_been_seen_since() -> None:
    memory = PeopleMemory()
    saw(memory, somebody("blue", trousers="black"), somebody("green", 4.0))
    (other,) = saw(memory, somebody("red", 2.1, 0.1, trousers="black"), t=3.0)
    assert {person.shirt for person in memory.everybody} == {"red", "green"}
    memory.name_them(other.number, "James")
    saw(memory, somebody("yellow", 2.1, 0.1), t=4.0)
    [james] = [person for person in memory.everybody if person.name == "James"]
    assert james.gone


def test_nobody_is_where_the_robot_stands() -> None:
    memory = PeopleMemory()
    saw(memory, somebody(x=2.0), somebody("blue", x=2.6))
    memory.update(replace(sight(t=9.0), picture=replace(sight(t=9.0).picture, pose=Pose(1.9, 0.1, 0.0))))
    assert [person.shirt for person in memory.everybody] == ["blue"]


def test_a_shadow_makes_nobody_of_somebody() -> None:
    memory = PeopleMemory()
    (first,) = saw(memory, somebody("white", trousers="black"))
    (shaded,) = saw(memory, somebody("grey", 2.2, trousers="black"), t=1.0)
    assert (shaded.number, shaded.shirt) == (first.number, "white")
    (other,) = saw(memory, somebody("grey", 3.4, trousers="black"), t=2.0)
    assert other.number != first.number


@given(st.lists(st.tuples(st.sampled_from(COLOURS), st.floats(1, 6), st.floats(-3, 3)), max_size=6), st.randoms())
def test_those_who_stay_where_they_are_keep_their_numbers(people: list[tuple[Colour, float, float]], random) -> None:  # type: ignore[no-untyped-def]
    apart = [
        one for i, one in enumerate(people)
        if all(math.dist(one[1:], other[1:]) > 0.1 for other in people[:i])
    ]  # fmt: skip
    memory = PeopleMemory()
    order = [somebody(colour, x, y) for colour, x, y in apart]
    before = saw(memory, *order)
    assert len({person.number for person in before}) == len(order)
    shuffled = random.sample(range(len(order)), len(order))
    after = saw(memory, *(order[index] for index in shuffled), t=1.0)
    assert [person.number for person in after] == [before[index].number for index in shuffled]


def test_the_clothes_that_do_not_show_now_are_those_that_did() -> None:
    memory = PeopleMemory()
    saw(memory, somebody("red", trousers="blue"))
    (person,) = saw(memory, somebody(None), t=0.5)
    assert (person.shirt, person.trousers) == ("red", "blue")


def test_of_two_the_one_who_is_nearer_keeps_the_number() -> None:
    memory = PeopleMemory()
    left, right = saw(memory, somebody(y=1.0), somebody(y=-1.0))
    now = saw(memory, somebody(y=-0.7), somebody(y=0.7), t=1.0)
    assert [person.number for person in now] == [right.number, left.number]


FAMILY = {"Anna": Looks("red", "blue"), "Ben": Looks("red", "grey"), "Cleo": Looks("green"), "Dan": Looks(tag=120)}


def test_a_known_person_has_their_name_by_what_nobody_else_wears() -> None:
    memory = PeopleMemory({name: looks for name, looks in FAMILY.items() if name != "Dan"})
    anna, nobody, cleo, other = saw(
        memory, somebody("red", y=1.0, trousers="blue"), somebody("red", y=0.0), somebody("green", y=-1.0),
        somebody("blue", y=2.0),
    )  # fmt: skip
    assert [person.name for person in (anna, nobody, cleo, other)] == ["Anna", None, "Cleo", None]


def test_a_name_comes_when_the_trousers_show() -> None:
    memory = PeopleMemory({name: looks for name, looks in FAMILY.items() if name != "Dan"})
    assert saw(memory, somebody("red"))[0].name is None
    assert saw(memory, somebody("red", trousers="grey"), t=1.0)[0].name == "Ben"
    assert saw(memory, somebody("red"), t=2.0)[0].name == "Ben"


def test_two_who_are_dressed_alike_have_no_name_unless_one_has_said_it() -> None:
    memory = PeopleMemory({"Cleo": Looks("green")})
    people = saw(memory, somebody("green", y=1.0), somebody("green", y=-1.0))
    assert [person.name for person in people] == [None, None]
    memory.name_them(people[0].number, "Cleo")
    assert [person.name for person in saw(memory, somebody("green", y=1.0), somebody("green", y=-1.0), t=1.0)] == [
        "Cleo", None,
    ]  # fmt: skip


def test_what_somebody_has_said_counts_more_than_what_they_wear() -> None:
    memory = PeopleMemory({"Cleo": Looks("green")})
    (person,) = saw(memory, somebody("green"))
    memory.name_them(person.number, "William")
    assert [person.name for person in memory.everybody] == ["William"]
    assert saw(memory, somebody("green"), t=1.0)[0].name == "William"


def test_a_tag_tells_who_it_is_wherever_they_are() -> None:
    memory = PeopleMemory(FAMILY)
    (dan,) = saw(memory, somebody("white", tag=120))
    (again,) = saw(memory, somebody("black", x=40.0, tag=120), t=1.0)
    assert (dan.name, again.name, again.number) == ("Dan", "Dan", dan.number)


def test_a_known_person_is_the_same_however_far_they_have_got() -> None:
    memory = PeopleMemory({"Cleo": Looks("green"), "Anna": Looks("red")})
    (cleo,) = saw(memory, somebody("green", x=1.0))
    assert saw(memory, somebody("green", x=20.0), t=2.0)[0].number == cleo.number


def test_whoever_is_not_there_any_more_is_forgotten_unless_they_have_a_name() -> None:
    memory = PeopleMemory({"Cleo": Looks("green")})
    _, cleo = saw(memory, somebody("red", y=0.3), somebody("green", y=-0.3))
    saw(memory, t=1.0, depth=1.0)  # a wall hides them
    assert len(memory.everybody) == 2
    saw(memory, t=2.0, depth=4.0)
    (left,) = memory.everybody
    assert (left.number, left.name, left.gone) == (cleo.number, "Cleo", True)
    assert saw(memory, somebody("green", x=1.0), t=3.0)[0].gone is False


def test_who_is_too_far_to_be_seen_plainly_is_not_forgotten() -> None:
    memory = PeopleMemory()
    saw(memory, somebody("red", x=3.6))
    saw(memory, t=2.0, depth=5.0)
    assert len(memory.everybody) == 1


def test_they_are_found_by_what_is_asked_the_nearest_first() -> None:
    memory = PeopleMemory()
    saw(memory, somebody("red", 1.0, posture="sitting"), somebody("blue", 2.0, posture="sitting"),
        somebody("green", 3.0, posture="standing"))  # fmt: skip
    found = memory.find(lambda person: person.posture == "sitting", near=(3.0, 0.0))
    assert [person.shirt for person in found] == ["blue", "red"]


def test_a_posture_that_does_not_show_is_kept_where_somebody_stays() -> None:
    memory = PeopleMemory()
    saw(memory, somebody(posture="sitting"))
    assert saw(memory, somebody(), t=1.0)[0].posture == "sitting"
    assert saw(memory, somebody(x=3.0), t=2.0)[0].posture is None


def test_a_hand_that_is_up_and_moves_waves() -> None:
    still = [somebody(gesture="raising the left arm", hand=(2.0, 0.3, 1.7)) for _ in range(3)]
    moves = [somebody(gesture="raising the left arm", hand=(2.0, y, 1.6)) for y in (0.2, 0.4)]
    assert gesture_of(still) == "raising the left arm"
    assert gesture_of(moves) == "waving"
    assert gesture_of(moves[:1]) == "raising the left arm"
    assert gesture_of([]) is None


def test_somebody_who_walks_with_a_hand_up_does_not_wave() -> None:
    looks = [somebody(x=x, gesture="raising the left arm", hand=(x, 0.3, 1.7)) for x in (2.0, 2.4)]
    assert gesture_of(looks) == "raising the left arm"


def test_the_memory_sees_waving_in_looks_that_follow_each_other() -> None:
    memory = PeopleMemory()
    saw(memory, somebody(gesture="raising the right arm", hand=(2.0, 0.2, 1.6)))
    (person,) = saw(memory, somebody(gesture="raising the right arm", hand=(2.0, 0.4, 1.6)), t=0.4)
    assert person.gesture == "waving"
    (person,) = saw(memory, somebody(gesture="raising the right arm", hand=(2.0, 0.2, 1.6)), t=9.0)
    assert person.gesture == "raising the right arm"


def test_people_are_no_things_but_are_found_where_people_are_asked_for() -> None:
    memory = WorldMemory()
    box = Sighting("box", "red", (0, 0, 9, 9), (0.5, 0.0, 0.02), 0.01, (0.04, 0.04), 0.5, 0.0)
    assert [thing.name for thing in memory.update(sight(somebody("red"), box))] == ["red box"]
    assert [thing.name for thing in memory.things] == ["red box"]
    assert [person.shirt for person in memory.snapshot().people] == ["red"]
    (person,) = memory.find(wanted("person"))
    assert person.kind == "person"
    assert memory.find(wanted("red thing")) == memory.things
    memory.forget(person)
    assert memory.people.everybody == ()
    assert len(memory.things) == 1


@pytest.mark.parametrize(
    ("person", "words"),
    [
        (somebody("orange", trousers="blue", posture="sitting"),
         "A person in an orange shirt and blue trousers is sitting"),
        (somebody("green", posture="standing", gesture="waving"), "Cleo is standing and waving"),
        (somebody(None), "A person is"),
    ],
)  # fmt: skip
def test_somebody_in_words(person: Sighting, words: str) -> None:
    assert in_words(saw(PeopleMemory({"Cleo": Looks("green")}), person)[0]) == words


def test_one_of_two_is_where_they_were_when_they_are_taken_for_the_other_from_close_by() -> None:
    world = WorldMemory()
    context = cast(SkillContext, SimpleNamespace(world=world))
    one, other = saw(world.people, somebody("black", 0.0, trousers="blue"), somebody("green", 2.0))
    saw(world.people, somebody(x=0.3, shirt="black", trousers="blue"), t=1.0)
    assert as_now(context, one, (one, other)).position[0] == 0.3
    saw(world.people, somebody(x=1.9, shirt="black", trousers="blue"), t=3.0)
    assert as_now(context, one, (one, other)).position[0] == 0.0


def test_what_arms_did_is_forgotten_where_it_is_looked_at_anew() -> None:
    memory = PeopleMemory()
    saw(memory, somebody(gesture="raising the left arm"))
    memory.forget_gestures()
    assert [person.gesture for person in memory.everybody] == [None]
    [person] = saw(memory, somebody(), t=0.2)
    assert person.gesture is None, "what was seen before does not count"
