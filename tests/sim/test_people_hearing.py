"""What the people of a scene understand, who of them reacts, and what they answer."""

from __future__ import annotations

from typing import Any

import pytest

from engine.robot.company import Company, News
from engine.robot.sim.heard import names_of, understood
from engine.robot.sim.people import REPLY_S
from engine.robot.sim.scene import Scene
from engine.robot.sim.world import World
from tests.sim.rig import settings

NAMES = names_of(("William", "Anna", "Robin"))
HALL = {
    "name": "hall",
    "bounds": {"x": [-6, 6], "y": [-3, 3]},
    "start": {"x": 0, "y": 0},
    "rooms": {"west": {"x": [-6, 2], "y": [-3, 3]}, "east": {"x": [2, 6], "y": [-3, 3]}},
    "doors": [{"between": ["west", "east"], "at": 0, "width": 1}],
}


def hall(**people: dict[str, Any]) -> World:
    """A robot in the middle of a hall, looking east, with these people."""
    return World(Scene.model_validate({**HALL, "people": people}), settings())


def company_of(world: World) -> Company:
    assert world.company is not None
    return world.company


def said(world: World, text: str, seconds: float = 1.0) -> list[News]:
    """What people do within so long of a sentence."""
    company = company_of(world)
    company.tell(text)
    for _ in range(round(seconds / 0.002)):
        world.step()
    return list(company.news())


@pytest.mark.parametrize(
    ("text", "wish"),
    [
        ("What is your name?", "name"),
        ("Are you William?", "name"),
        ("Are you Zoe?", "name"),
        ("Please follow me to the kitchen.", "follow"),
        ("Please come along.", "come along"),
        ("Here we are: the kitchen.", "arrived"),
        ("I follow you.", "lead"),
        ("I'll follow you.", "lead"),
        ("Please take the cup.", "take"),
        ("Please give me the cup.", "give"),
        ("May I pass, please?", "pass"),
        ("Please let me pass.", "pass"),
        ("What would you like to drink?", "answer"),
        ("Are you ready?", "answer"),
        ("William, come along.", "come along"),
        ("Excuse me. Please let me pass.", "pass"),
        ("Could you give me the cup?", "give"),
        ("I am at the kitchen.", "nothing"),
        ("I am at the kitchen. I saw nobody come along.", "nothing"),
        ("I asked William to follow me.", "nothing"),
        ("I take the cup to the kitchen.", "nothing"),
        ("你叫什么名字？", "name"),
        ("你是谁？", "name"),
        ("你是William吗？", "name"),
        ("請跟我來。", "follow"),
        ("请跟上。", "come along"),
        ("我们到了。", "arrived"),
        ("我跟着你。", "lead"),
        ("请拿着杯子。", "take"),
        ("请把杯子给我。", "give"),
        ("请让一下。", "pass"),
        ("你想喝什么？", "answer"),
        ("你喜欢茶吗", "answer"),
        ("到了，这里是厨房。", "arrived"),
        ("请跟我来，去厨房。", "follow"),
        ("我在厨房。", "nothing"),
        ("我看到了三个人。", "nothing"),
        ("我到厨房了，没有看到有人跟来。", "nothing"),
    ],
)
def test_a_sentence_wants_what_a_person_would_understand(text: str, wish: str) -> None:
    assert understood(text, NAMES).wish == wish


@pytest.mark.parametrize(
    ("text", "to"),
    [
        ("William, please follow me.", "William"),
        ("William please follow me.", "William"),
        ("Please come along, Anna.", "Anna"),
        ("Hello Robin, may I pass?", "Robin"),
        ("William，请跟我来。", "William"),
        ("Are you William?", None),
        ("What would William like?", None),
        ("Please follow me.", None),
        ("Annabel, come here.", None),
    ],
)
def test_who_is_spoken_to_is_named_at_the_beginning_or_apart(text: str, to: str | None) -> None:
    assert understood(text, NAMES).to == to


def test_a_name_is_told_after_a_moment() -> None:
    world = hall(visitor={"path": [[1.5, 0]], "called": "Robin"})
    heard, says = said(world, "What is your name?")
    assert (heard.who, heard.does, heard.text) == ("visitor", "hears", "What is your name?")
    assert (says.does, says.text) == ("says", "I am Robin.")
    assert says.t - heard.t == pytest.approx(REPLY_S, abs=0.01)


@pytest.mark.parametrize(
    ("question", "answer"),
    [
        ("Are you Robin?", "Yes."),
        ("Are you William?", "No, I am Robin."),
        ("你叫什么名字？", "我是Robin。"),
        ("你是Robin吗？", "是的。"),
        ("你是William吗？", "不是，我是Robin。"),
        ("What would you like to drink?", "I would like a coke, please."),
        ("Where is the bin?", "I do not know."),
        ("垃圾桶在哪里？", "我不知道。"),
    ],
)
def test_questions_are_answered(question: str, answer: str) -> None:
    world = hall(visitor={"path": [[1, 0]], "called": "Robin", "replies": {"drink": "I would like a coke, please."}})
    assert [news.text for news in said(world, question) if news.does == "says"] == [answer]


def test_who_lies_or_sits_answers_too() -> None:
    world = hall(ann={"path": [[1, 0]], "posture": "lying", "seat": 0.4})
    assert said(world, "What is your name?")[-1].text == "I am ann."


def test_the_nearest_hears_and_nobody_beyond_three_metres() -> None:
    world = hall(near={"path": [[1.2, 0.5]]}, far={"path": [[1.8, 0]]}, away={"path": [[-3.2, 0]]})
    assert {news.who for news in said(world, "What is your name?")} == {"near"}
    alone = hall(away={"path": [[-3.2, 0]]})
    assert said(alone, "What is your name?") == []


def test_the_one_whom_the_robot_looks_at_hears_rather_than_one_behind_it_who_is_nearer() -> None:
    world = hall(behind={"path": [[-1.5, 0]]}, ahead={"path": [[1.8, 0]]})
    assert {news.who for news in said(world, "What is your name?")} == {"ahead"}


@pytest.mark.parametrize("text", ["You in red, please follow me.", "穿红色衣服的那位，请跟我来。"])
def test_who_is_spoken_to_by_their_shirt_reacts_even_if_others_are_nearer(text: str) -> None:
    world = hall(near={"path": [[1.2, 0]], "shirt": "blue"}, far={"path": [[2, 1]], "shirt": "red"})
    assert {news.who for news in said(world, text)} == {"far"}


def test_who_is_named_reacts_even_if_others_are_nearer_and_nobody_does_for_somebody_away() -> None:
    world = hall(Anna={"path": [[1, 0]]}, William={"path": [[1.8, 1]]}, James={"path": [[-4, 0]]})
    assert {news.who for news in said(world, "William, where is the bin?")} == {"William"}
    assert said(world, "James, where is the bin?") == []


def test_who_is_behind_a_wall_hears_only_if_nobody_is_in_sight() -> None:
    world = hall(hidden={"path": [[2.3, -1.5]]}, seen={"path": [[-2.9, 0]]})
    assert {news.who for news in said(world, "Hello?")} == {"seen"}
    alone = hall(hidden={"path": [[2.3, -1.5]]})
    assert {news.who for news in said(alone, "Hello?")} == {"hidden"}


def test_nobody_behind_a_wall_answers_for_whoever_gives_the_tasks_and_is_looked_at() -> None:
    world = hall(hidden={"path": [[2.3, -1.5]]}, you={"path": [[1.4, 0]], "gives_tasks": True})
    assert [(news.who, news.does) for news in said(world, "Are you Robin?")] == [("you", "hears")]


def test_sentences_in_quick_succession_are_all_heard_in_their_order() -> None:
    world = hall(Anna={"path": [[1, 0]]})
    company = company_of(world)
    company.tell("Hello.")
    company.tell("Are you Anna?")
    news = said(world, "Where is the bin?")
    assert [n.text for n in news if n.does == "hears"] == ["Hello.", "Are you Anna?", "Where is the bin?"]
    assert [n.text for n in news if n.does == "says"] == ["Yes.", "I do not know."]


def test_somebody_who_walks_about_stands_while_they_are_spoken_to() -> None:
    world = hall(eve={"path": [[1, -2], [1, 2]], "speed": 0.5})
    eve = world.model.joint("eve y").qposadr[0]
    said(world, "What is your name?")
    before = float(world.data.qpos[eve])
    said(world, "Hello.", 3.0)
    assert world.data.qpos[eve] == pytest.approx(before, abs=1e-3)
    said(world, "Hm.", 8.0)
    assert world.data.qpos[eve] > before + 0.3
