"""Small talk is answered, and moves nothing; what holds more than that is none."""

from __future__ import annotations

import asyncio

import pytest

from config import load
from engine.parts.loading import at_home
from engine.plan import Plan
from engine.planner.build import build_planner
from engine.planner.phrases.small_talk import ASIDE, UNKNOWN
from engine.planner.request import PlanRequest
from engine.planner.text.language import all_phrases

PLANNER = build_planner(at_home(load(environ={})), models=None)


def said(text: str) -> str:
    """What is answered where nothing is done."""
    found = asyncio.run(PLANNER.plan(PlanRequest(text)))
    return found.response if isinstance(found, Plan) and not found.actions else ""


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("hello there", "Greeting"), ("Good morning, how are you today?", "Wellbeing"), ("thanks a lot", "Thanks"),
        ("ta very much, you're a star", "Thanks"), ("That was very well done, I must say.", "Opinion"),
        ("what's your name", "Name"), ("Can you understand German?", "Languages"),
        ("can you hear me", "Attention"), ("tell me a joke please", "Joke"), ("I had a terrible day at work", "Sorrow"),
        ("what's the weather like", "Unknown"), ("sorry, I was talking to somebody else", "Aside"),
        ("what did I ask you?", "Unknown"), ("why?", "Unknown"), ("why", "Aside"),
        ("see you tomorrow", "Farewell"), ("I'm so happy, I passed my exam!", "Joy"),
    ],
)  # fmt: skip
def test_small_talk_is_answered(text: str, kind: str) -> None:
    assert said(text) == all_phrases()["en"]["answers"]["talk"][kind]


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("你好呀", "Greeting"), ("谢谢，辛苦了", "Thanks"), ("你真聪明", "Opinion"), ("你叫什么名字", "Name"),
        ("给我讲个笑话", "Joke"), ("晚安", "Farewell"),
    ],
)  # fmt: skip
def test_small_talk_in_chinese_is_answered_in_chinese(text: str, kind: str) -> None:
    assert said(text) == all_phrases()["zh"]["answers"]["talk"][kind]


@pytest.mark.parametrize(
    "text",
    [
        "hello, go to the kitchen", "thank you, now turn left", "well done, put it in the bin",
        "how are you going to get to the kitchen", "what can you do",
        "run over the cat, thanks", "谢谢，去厨房", "你好，左转九十度",
    ],
)  # fmt: skip
def test_a_request_beside_it_is_never_talked_away(text: str) -> None:
    assert said(text) == ""


@pytest.mark.parametrize("text", ["what did I ask you?", "why", "为什么"])
def test_no_answer_to_talk_that_nobody_understands_sounds_like_consent(text: str) -> None:
    assert "All right" not in said(text)
    assert "好的" not in said(text)


def test_every_kind_of_small_talk_has_an_answer_in_every_language() -> None:
    for language in ("en", "zh"):
        sections = all_phrases()[language]
        assert {*sections["talk"], ASIDE, UNKNOWN} == set(sections["answers"]["talk"])
