"""The robot with people, in real physics and with real pictures: it finds, meets, follows, guides, tells and asks them,
and hands things over. What they heard and did is told by them, not by the robot."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest

from config import load
from config.schema import KnownPerson
from engine.perception.memory import WorldMemory
from engine.perception.people import PeopleMemory, PersonSeen
from engine.robot.company import News
from engine.robot.geometry import Pose
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_file import load_scene, scene_path
from engine.robot.sim.scene_parts import Start
from engine.skills.library import LIBRARY
from engine.skills.library.household import who_waits
from engine.skills.meeting import face_point
from engine.skills.outcome import Result
from engine.skills.people import People, looks_of
from engine.skills.places import Places
from tests.eval.gpsr.goal import Guest, Needs
from tests.eval.houses import house
from tests.sim.inhand import HandRobot, context_of

SKILLS = {skill.name: skill for skill in LIBRARY}
PLACES = load(environ={}).places
LIMIT_S = 240.0
"""Robot time that a test takes at most."""


class Family:
    """A robot among people: what it says is heard, and what they answer is heard."""

    def __init__(self, scene: Scene, known: dict[str, KnownPerson] | None = None) -> None:
        self.robot = HandRobot(scene)
        self.people = People(scene.known_people() if known is None else known)
        self.world = WorldMemory(PeopleMemory(looks_of(self.people)))
        self.news: list[News] = []
        self.said: list[str] = []
        self.context = replace(
            context_of(self.robot, self.world), people=self.people, places=Places(PLACES), say=self._say, ask=self._ask
        )

    def do(self, *plan: tuple[str, dict[str, Any]]) -> list[Result]:
        """Run these one after the other, until one is not ok."""
        return asyncio.run(self._do(plan))

    async def _do(self, plan: Sequence[tuple[str, dict[str, Any]]]) -> list[Result]:
        results: list[Result] = []
        for name, arguments in plan:
            skill = SKILLS[name]
            defaults = {p.name: p.default for p in skill.parameters if p.default is not None}
            results.append(await skill.run(self.context, **{**defaults, **arguments}))
            if not results[-1].ok:
                break
        for _ in range(60):  # what was said last has its effect
            await self.robot.tick()
        self._listen()
        assert self.robot.state().t < LIMIT_S
        return results

    def heard(self, who: str) -> list[str]:
        return [news.text for news in self.news if news.who == who and news.does == "hears"]

    def place_of(self, who: str) -> tuple[float, float]:
        x, y = (float(self.robot.world.data.joint(f"{who} {axis}").qpos[0]) for axis in "xy")
        return x, y

    def _listen(self) -> list[News]:
        assert self.robot.company is not None
        found = list(self.robot.company.news())
        self.news += found
        return found

    async def _say(self, text: str) -> None:
        assert self.robot.company is not None
        self.said.append(text)
        self.robot.company.tell(text)

    async def _ask(self, question: str, limit_s: float = 10.0) -> str | None:
        self._listen()
        await self._say(question)
        end = self.robot.state().t + limit_s
        while self.robot.state().t < end:
            await self.robot.tick()
            if (said := next((news.text for news in self._listen() if news.does == "says"), None)) is not None:
                return said
        return None


@pytest.fixture
def family() -> Family:
    return Family(load_scene(scene_path("family")))


def changed(**people: dict[str, Any] | None) -> Scene:
    """The family with some of them changed, or away."""
    raw = load_scene(scene_path("family")).model_dump(mode="json")
    for name, change in people.items():
        if change is None:
            del raw["people"][name]
        else:
            raw["people"][name] |= change
    return Scene.model_validate(raw)


def test_somebody_is_found_in_a_room_and_told_something(family: Family) -> None:
    found, told = family.do(
        ("find_person", {"who": "William", "where": "living room"}),
        ("tell", {"who": "William", "text": "dinner is ready"}),
    )
    assert found.message == "I found William in the living room."
    assert told.ok
    assert family.heard("William") == ["William, dinner is ready"]
    x, y = family.place_of("William")
    assert 0.6 < math.dist((x, y), (family.context.pose.x, family.context.pose.y)) < 2.2, "near, and not too near"


def test_everybody_in_a_room_is_told_by_themselves(family: Family) -> None:
    [told] = family.do(("tell_everyone", {"text": "dinner is ready", "where": "living room"}))
    assert told.data["told"] == 2
    assert family.heard("Elizabeth") == ["Elizabeth, dinner is ready"]
    assert family.heard("William") == ["William, dinner is ready"]
    assert family.heard("Anna") == []


def test_the_one_who_gives_the_task_is_followed_to_a_room(family: Family) -> None:
    [followed] = family.do(("person_follow", {"who": "me", "to": "A"}))
    assert followed.message == "I followed the person in purple to the kitchen."


def test_nobody_of_this_look_is_there(family: Family) -> None:
    [found] = family.do(("find_person", {"who": "person in purple", "where": "kitchen"}))
    assert (found.outcome, found.error_code) == ("failed", "object_not_found")


def test_a_stranger_is_met_and_known_from_then_on(family: Family) -> None:
    learnt: list[str] = []
    family.people.on_added = lambda name, person: learnt.append(name)
    (met,) = family.do(("meet", {"who": "Robin", "where": "bedroom"}))
    assert met.message == "I met Robin in the bedroom."
    assert family.heard("visitor") == ["Hello. Are you Robin?"]
    assert learnt == ["Robin"]
    assert [p.name for p in family.world.people.everybody if p.name == "Robin"] == ["Robin"]


def test_whoever_has_a_name_may_have_stepped_aside_from_where_they_are_to_be_met(family: Family) -> None:
    (met,) = family.do(("meet", {"who": "Robin", "where": "wardrobe"}))
    assert met.message == "I met Robin in the bedroom."


def test_who_is_asked_answers_and_the_answer_is_reported(family: Family) -> None:
    asked, reported = family.do(
        ("ask_person", {"who": "Anna", "question": "What would you like to drink?"}), ("report_answer", {})
    )
    assert asked.data["answer"] == "I would like a coke, please."
    assert reported.ok
    assert family.said[-1] == "Anna said: “I would like a coke, please.”."


def test_whoever_is_led_by_is_followed_to_the_room(family: Family) -> None:
    _, followed = family.do(("meet", {"who": "James"}), ("person_follow", {"who": "James", "to": "D"}))
    assert followed.message == "I followed James to the study."
    x, y = family.place_of("James")
    assert math.dist((x, y), (family.context.pose.x, family.context.pose.y)) < 2.0


def test_whoever_strays_is_called_and_brought_along() -> None:
    family = Family(changed(William={"strays": 1.5}))
    [guided] = family.do(("guide", {"who": "William", "to": "A"}))
    assert guided.ok, guided.message
    assert "William, please come along." in family.heard("William")
    kitchen = family.context.places.pose("A")
    assert kitchen is not None
    assert math.dist(family.place_of("William"), (kitchen.x, kitchen.y)) < 1.8


def test_people_in_a_room_are_counted_and_described(family: Family) -> None:
    counted, described = family.do(
        ("count_people", {"who": "person", "where": "kitchen"}),
        ("describe_person", {"who": "Anna", "what": "gender"}),
    )
    assert counted.data["people"] == 1
    assert described.message == "Anna is a woman."


def test_whoever_has_no_question_is_given_no_answer() -> None:
    family = Family(changed(Anna={"replies": {"question": "I do not know."}}))
    (answered,) = family.do(("answer_question", {"who": "Anna"}))
    assert not answered.ok
    assert answered.message == "Anna asked nothing."


def test_a_thing_is_taken_from_one_and_given_to_another() -> None:
    family = Family(changed(William={"holds": "blue cup"}, Elizabeth={"holds": None}, James=None))
    taken, given = family.do(
        ("take_from", {"who": "William", "thing": "blue cup"}),
        ("hand_over", {"who": "Anna"}),
    )
    assert taken.ok, taken.message
    assert given.ok, given.message
    assert [(news.who, news.does, news.text) for news in family.news if news.does in ("gives", "takes")] == [
        ("William", "gives", "blue cup"),
        ("Anna", "takes", "blue cup"),
    ]
    assert family.world.held is None


def test_what_is_fetched_is_brought_to_whoever_has_stepped_aside_meanwhile() -> None:
    family = Family(changed(you={"path": [[2.1, -0.3]]}, James=None))
    family.context.places.remember(family.context.pose)
    family.robot.put("ball", -0.8, 0.3, 0.0)  # nearby
    [brought] = family.do(("carry", {"object": "orange ball", "place": "zero"}))
    assert brought.message.startswith("I brought the orange ball to the person"), brought.message
    assert math.dist(family.robot.where("ball")[:2], family.place_of("you")) < 1.5


def test_nobody_answers_for_whom_they_stand_before() -> None:
    family = Family(changed(you={"path": [[1.65, -2.0]]}))
    (counted,) = family.do(("count_people", {"who": "man", "where": "bedroom"}))
    assert counted.message == "In the bedroom I see no man, and 2 people of whom I cannot tell."
    assert family.heard("visitor").count("Excuse me, are you a man or a woman?") == 1


def test_nobody_in_the_picture_is_given_what_whoever_stands_behind_it_has_asked_for() -> None:
    family = Family(changed(you={"path": [[-0.5, -0.6]]}, James={"path": [[2.3, 0.3]]}))

    async def look_ahead() -> PersonSeen | None:
        await family.robot.tick()
        await face_point(family.context, (2.3, 0.3, 1.0))
        await family.context.see()
        assert [person.shirt for person in family.world.people.everybody] == ["blue"], "James, and nobody else"
        return await who_waits(family.context)

    assert asyncio.run(look_ahead()) is None, "you are right here"


def test_nothing_is_handed_over_by_an_empty_hand(family: Family) -> None:
    [given] = family.do(("hand_over", {"who": "Anna"}))
    assert given.error_code == "nothing_held"


def test_whoever_stands_in_the_way_is_asked_and_not_pushed() -> None:
    scene = changed(William={"path": [[-1.22, 0.0]], "facing": 0.0}, James=None)
    raw = scene.model_dump(mode="json")
    raw["doors"] = [{**door, "width": 0.8} for door in raw["doors"] if set(door["between"]) == {"hall", "living room"}]
    family = Family(Scene.model_validate(raw))
    [went] = family.do(("navigation", {"place": "B"}))
    assert "May I pass, please?" in family.heard("William")
    assert went.ok, went.message


def test_who_is_hidden_by_the_wall_beside_a_door_is_looked_for_where_they_were_seen_last() -> None:
    scene = house(17001055, Needs((Guest("dishwasher", "James", "male", leads_to="entrance"),)))
    leads = scene.people["person 1"].leads
    assert leads[2] == (-2.83, -1.32), "through the door of the house in which the robot has lost them"
    family = Family(scene.model_copy(update={"start": Start(x=-4.2, y=-2.64, yaw=97)}))
    [followed] = family.do(("person_follow", {"who": "person in orange", "stands": 6.0}))
    assert followed.ok, followed.message
    assert math.dist(family.place_of("person 1"), leads[-1]) < 0.2


def test_who_says_that_they_are_somebody_else_is_left_and_the_next_one_is_asked() -> None:
    family = Family(
        changed(you={"path": [[1.0, -0.2]], "gives_tasks": False}, visitor={"path": [[-3.0, -2.2]]}, James=None)
    )
    [met] = family.do(("meet", {"who": "Robin"}))
    assert "Hello. Are you Robin?" in family.heard("you")
    assert met.message.startswith("I met Robin"), met.message
    assert "Hello. Are you Robin?" in family.heard("visitor")


def test_who_is_guided_past_somebody_stays_known_beside_them() -> None:
    scene = house(17001132, Needs((Guest("couch", "Mary", "female"),)))
    family = Family(scene.model_copy(update={"start": Start(x=-2.19, y=-4.06, yaw=141)}))
    family.context.places.remember(Pose(2.9, -0.1, 0.0))
    [guided] = family.do(("guide", {"who": "person in green", "to": "zero"}))
    assert guided.ok, guided.message
    assert "May I pass, please?" in family.heard("operator")
    assert math.dist(family.place_of("person 1"), (2.9, -0.1)) < 1.5
