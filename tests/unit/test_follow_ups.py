"""Words that ask for what the console offers after a turn."""

from __future__ import annotations

import pytest

from engine.planner.phrases.follow_ups import FollowUp, follow_up


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("continue", "resume"), ("Go on.", "resume"), ("继续。", "resume"), ("undo", "undo"), ("Undo that!", "undo"),
        ("撤销", "undo"), ("again", "again"), ("Do that again", "again"), ("再来一次", "again"),
    ],
)  # fmt: skip
def test_a_word_by_itself_is_understood_without_a_reader(text: str, kind: FollowUp) -> None:
    assert follow_up(text) == kind


@pytest.mark.parametrize(
    "text", ["", "go on to the kitchen", "don't continue", "undo the red box", "不要继续", "再来一杯"]
)
def test_anything_more_is_not_these_words(text: str) -> None:
    assert follow_up(text) is None
