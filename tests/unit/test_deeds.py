"""What a small model adds of its own accord is left out: a dance, a nod, a beep that nobody spoke of."""

from __future__ import annotations

import pytest

from engine.plan import Action
from engine.planner.grounding.deeds import asked_for


def names(text: str, *planned: str, before: tuple[str, ...] = ()) -> list[str]:
    return [action.name for action in asked_for([Action(name, {}) for name in planned], (*before, text))]


@pytest.mark.parametrize(
    ("text", "planned"),
    [
        ("show us some moves", "dance"),
        ("say yes with your arm", "arm_nod"),
        ("honk twice", "beep"),
        ("stay right behind me", "person_follow"),
        ("跳个舞", "dance"),
        ("响一声", "beep"),
    ],
)
def test_what_was_asked_for_in_any_words_is_done(text: str, planned: str) -> None:
    assert names(text, planned) == [planned]


def test_what_nobody_spoke_of_is_left_out() -> None:
    assert names("Carry on with what we were doing.", "dance") == []
    assert names("go to the kitchen", "navigation", "beep") == ["navigation"]


def test_what_was_asked_for_before_may_be_asked_for_again_without_its_name() -> None:
    assert names("do that once more", "dance", before=("dance",)) == ["dance"]
    assert names("and the other way", "beep", before=("go to the study",)) == []
