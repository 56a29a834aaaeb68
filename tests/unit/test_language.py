"""The language of a request is that of the words that hold it together."""

from __future__ import annotations

import pytest

from engine.planner.text.language import language_of


@pytest.mark.parametrize(
    "text",
    [
        "去厨房", "去 kitchen", "把 red box 拿到 kitchen", "说 I am here", "OK 停", "robot，去厨房", "red box 在哪里",
        "左转 90 degrees", "“你好”怎么说", "3号积木", "ＯＫ，去厨房",
    ],
)  # fmt: skip
def test_a_chinese_sentence_may_hold_english_names(text: str) -> None:
    assert language_of(text) == "zh"


@pytest.mark.parametrize(
    "text",
    [
        "", "90 °", "go to the kitchen", "go to the 厨房", "Please go to 客厅 and then 书房", "say 你好，很高兴认识你",
        "turn left 九十度", "Where is the 红盒子?", "bring me the 杯子",
    ],
)  # fmt: skip
def test_an_english_sentence_may_hold_chinese_names_and_words_to_say(text: str) -> None:
    assert language_of(text) == "en"
