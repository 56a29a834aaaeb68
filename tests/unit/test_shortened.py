"""What people shorten when they type, written in full."""

from __future__ import annotations

import pytest

from engine.planner.text.shortened import written_in_full


@pytest.mark.parametrize(
    ("typed", "full"),
    [
        ("pls go 2 ur dock n dont beep", "please go to your dock and don't beep"),
        ("while ur at it", "while you're at it"),
        ("if someones there tell em", "if someone's there tell them"),
        ("r u busy", "are you busy"),
        ("its there? whats on it", "it's there? what's on it"),
        ("if its not there nvm", "if it's not there never mind"),
        ("its place", "its place"),
        ("go to N", "go to N"),
        ("u", "u"),
        ("去厨房", "去厨房"),
    ],
)
def test_it_is_written_in_full(typed: str, full: str) -> None:
    assert written_in_full(typed) == full


def test_what_is_written_in_full_stays_as_it_is() -> None:
    full = written_in_full("plz dont go there cuz its wet n u r late")
    assert written_in_full(full) == full
