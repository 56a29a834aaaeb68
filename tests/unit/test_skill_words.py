"""The words of a skill stand in its record: built-in skills have a file, external ones declare them."""

from __future__ import annotations

import asyncio
import re
from string import Formatter
from typing import Any

import pytest
import yaml
from pydantic import ValidationError

from config import load
from config.schema import ExternalSkill, Settings, SkillWords
from engine.plan import Action, Plan
from engine.planner.build import build_planner, build_registry
from engine.planner.request import NoPlan, PlanRequest
from engine.robot.geometry import Pose
from engine.skills.places import Places
from engine.skills.record import records
from engine.skills.registry import Skill
from engine.wording import build_wording

SETTINGS = load(environ={})
REGISTRY = build_registry(SETTINGS)
PLANNER = build_planner(SETTINGS, REGISTRY, reader=False)
WORDING = build_wording(SETTINGS)
SILENT = {"grasp_obj", "track", "get_dist", "ask_user", "finishtask"}
"""Skills that only models use: nobody is told about them by name."""

WATER = """
does: Water a plant.
external: [python, water.py]
occupies: [base, arm]
parameters:
  plant: {kind: object}
  room: {kind: room, default: ""}
  time: {unit: s, min: 1, max: 60, default: 5}
words:
  en:
    asked: ["(water|give water to) {plant} [in {room}] [for {time}]"]
    told: [{step: "Water {plant}[ in the {room}][ for {time}].", doing: "watering {plant}"}]
  zh:
    called: 浇水
    asked: ["给{plant}浇水"]
    told: [{step: "给{plant}浇水。"}]
"""


def with_skill(**changes: Any) -> Settings:
    declared = ExternalSkill.model_validate({**yaml.safe_load(WATER), **changes})
    return SETTINGS.model_copy(update={"skills": {**SETTINGS.skills, "water": declared}})


def planned(settings: Settings, text: str) -> Plan | NoPlan:
    return asyncio.run(build_planner(settings).plan(PlanRequest(text)))


def slots(text: str) -> set[str]:
    return {name for _, name, _, _ in Formatter().parse(text) if name}


@pytest.mark.parametrize("skill", list(REGISTRY), ids=lambda skill: skill.name)
def test_every_skill_has_words_in_both_languages(skill: Skill) -> None:
    english, chinese = skill.words.en, skill.words.zh
    assert chinese.called
    assert set(chinese.arguments) == {parameter.name for parameter in skill.parameters}
    for words in (english, chinese):
        assert bool(words.told) != (skill.name in SILENT)
        for told in words.told:
            assert slots(told.step) | slots(told.doing or "") | set(told.when) <= set(chinese.arguments)
    assert [told.when for told in english.told] == [told.when for told in chinese.told]


def test_every_record_belongs_to_a_skill() -> None:
    assert set(records()) == {skill.name for skill in REGISTRY}


@pytest.mark.parametrize(
    ("text", "action", "step"),
    [
        ("water the red box", "water(red box, , 5)", "Water the red box."),
        ("could you water the ball for ten seconds please", "water(ball, , 10)", "Water the ball for 10 seconds."),
        ("go to the hall, then give water to the ball in the kitchen", "water(ball, kitchen, 5)",
         "Water the ball in the kitchen."),
        ("给球浇水", "water(ball, , 5)", "给球浇水。"),
    ],
)  # fmt: skip
def test_an_external_skill_is_asked_for_and_told_in_its_own_words(text: str, action: str, step: str) -> None:
    found = planned(with_skill(), text)
    assert isinstance(found, Plan), found
    assert (str(found.actions[-1]), found.steps[-1]) == (action, step)


def test_an_external_skill_without_words_is_told_by_what_it_does() -> None:
    found = planned(with_skill(words={}), 'water(plant="ball")')
    assert isinstance(found, Plan)
    assert found.steps == ("Water a plant.",)


def test_an_external_skill_is_called_by_its_chinese_name() -> None:
    assert build_wording(with_skill()).told("water") == "浇水"


@pytest.mark.parametrize(
    "words",
    [
        {"asked": ["water the {flower}"]},
        {"told": [{"step": "Water {plants}."}]},
        {"told": [{"when": {"x": "1"}, "step": "Water."}]},
        {"arguments": {"pot": "盆"}},
    ],
)
def test_words_about_a_parameter_that_is_none_are_a_mistake_of_the_file(words: dict[str, Any]) -> None:
    with pytest.raises(ValidationError, match=re.escape("there is: plant, room, time")):
        with_skill(words={"en": words})


# Actions that are written as such


@pytest.mark.parametrize(
    ("text", "actions"),
    [
        ('navigation(place="kitchen")', ["navigation(A)"]),
        ("move_forward(0.5 m); beep() & arm_up()", ["move_forward(0.5, 0.3)", "beep(0.2)", "arm_up()"]),
        ("  dance ( ) ", ["dance()"]),
    ],
)
def test_actions_that_are_written_as_such_are_planned_as_they_stand(text: str, actions: list[str]) -> None:
    found = planned(SETTINGS, text)
    assert isinstance(found, Plan)
    assert [str(action) for action in found.actions] == actions
    assert len(found.steps) == len(actions)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('navigation(place="garage")', "garage"),
        ("move_forward(80 m)", "50"),
        ("move_forward(", "an argument"),
        ("navigation(kitchen) and then dance", "the end"),
        ("dance(); fly()", "fly"),
        ("beep();" * 200, "a plan"),
    ],
)
def test_what_is_wrong_with_such_actions_is_said(text: str, says: str) -> None:
    found = planned(SETTINGS, text)
    assert isinstance(found, NoPlan)
    assert says in found.answer


def test_the_words_of_a_language_may_be_left_out() -> None:
    assert SkillWords() == SkillWords.model_validate({})


EXAMPLES: dict[str | None, str] = {
    "place": "A", "places": "A,B", "object": "red box", "surface": "sofa", "room": "kitchen", "person": "Anna",
    "people": "person in red",
    "colour": "red", "thing_colour": "red", "sentence": "Ж",
}  # fmt: skip


def an_action(skill: Skill) -> Action:
    numbers = {p.name: max(p.low or 0.0, 1.0) for p in skill.parameters if p.type == "number"}
    words = {p.name: EXAMPLES[p.word] for p in skill.parameters if p.type != "number"}
    return Action(skill.name, {p.name: {**numbers, **words}[p.name] for p in skill.parameters})


@pytest.mark.parametrize("skill", [one for one in REGISTRY if one.name not in SILENT], ids=lambda skill: skill.name)
def test_people_are_told_of_an_action_in_words_and_in_chinese_words(skill: Skill) -> None:
    told = PLANNER.in_words(an_action(skill))
    for words in (told.step, told.doing):
        assert words
        assert not re.search(r"[(){}_=]", words), "as a program writes it"
        in_chinese = WORDING.told(f"{words[0].upper()}{words[1:]}: stopped.")
        assert not re.search(r"[A-Za-z]{3,}", in_chinese.replace("Anna", "")), in_chinese


def test_the_place_where_the_robot_started_is_not_called_a_remembered_one_before_somebody_asked_for_that() -> None:
    places = Places(SETTINGS.places)
    places.begin(Pose(0, 0, 0))
    planner = build_planner(SETTINGS, REGISTRY, reader=False, places=places)
    action = Action("carry", {"object": "red box", "place": "zero", "source": ""})
    assert planner.in_words(action).step == "Bring the red box to my starting point"
    assert places.name("zero") == "my starting point"
    places.remember(Pose(1, 0, 0))
    assert planner.in_words(action).doing == "bringing the red box to the remembered place"
    assert places.name("zero") == "the remembered place"
