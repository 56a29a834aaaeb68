"""What the robot says when it is asked what it can do: what these skills can, in the words of the house."""

from __future__ import annotations

import pytest

from config import load
from engine.planner.phrases.phrases import Phrases
from engine.planner.request import Language
from engine.skills.library import LIBRARY
from engine.wording import build_wording

SETTINGS = load(environ={})
PLACES = SETTINGS.places
DRIVES = tuple(skill for skill in LIBRARY if skill.name in ("navigation", "move_forward", "light"))


def test_it_lists_what_it_can_do_and_sends_nobody_in_a_circle() -> None:
    said = Phrases(PLACES, "en", skills=LIBRARY).abilities
    assert said.startswith("I can go to places such as the kitchen, drive by a distance, turn by an angle, ")
    assert said.endswith(", move my arm and set my light.")
    assert "what can you do" not in said


def test_only_what_these_skills_can_is_listed() -> None:
    assert Phrases(PLACES, "en", skills=DRIVES).abilities == (
        "I can go to places such as the kitchen, drive by a distance and set my light."
    )
    assert Phrases({}, "en", skills=DRIVES[:2]).abilities in ("I can drive by a distance.",)
    assert Phrases(PLACES, "zh", skills=DRIVES).abilities == "我会去厨房这样的地方、行驶一段距离和设置灯光。"


@pytest.mark.parametrize("language", ["en", "zh"])
def test_who_asks_in_another_language_than_the_phrases_is_answered_in_it(language: Language) -> None:
    english, chinese = (Phrases(PLACES, spoken, skills=LIBRARY).abilities for spoken in ("en", "zh"))
    told = build_wording(SETTINGS).worded(english, language)
    assert told == (chinese if language == "zh" else english)
