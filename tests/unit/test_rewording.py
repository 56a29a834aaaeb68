"""The files with other words for the same request, and how their patterns are written."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.resources import files
from typing import Any

import pytest
import yaml

from engine.planner.readings.rewording import Rewording, Rewordings, names
from engine.planner.text.patterns import written_out

LANGUAGES = ("en",)
HOUSE = ("place_name", "stop_name", "room", "door", "furniture", "piece", "spot", "thing", "colour", "verb")
COUNTED = ("one", "ten", "past", "use")
"""What the code tells of a house, and of numbers and verbs."""


def sections(language: str) -> dict[str, Any]:
    found: dict[str, Any] = yaml.safe_load((files("assets") / "rewordings" / f"{language}.yaml").read_text("utf-8"))
    return found


def rules(language: str) -> Iterator[tuple[str, Rewording]]:
    house = dict.fromkeys((*HOUSE, *COUNTED), "hall")
    rewordings = Rewordings(language, house)  # type: ignore[arg-type]
    for name, section in sections(language).items():
        if isinstance(section, list) and name != "uses":
            for rule in rewordings.rules(name, say="{place}"):
                yield name, rule


@pytest.mark.parametrize("language", LANGUAGES)
def test_what_is_said_instead_names_only_what_the_pattern_finds(language: str) -> None:
    found = list(rules(language))
    assert found
    for section, rule in found:
        told = set(re.findall(r"\\g<(\w+)>", rule.words))
        assert told <= set(rule.pattern.groupindex), f"{section}: {rule.words}"


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_part_is_words_and_is_used(language: str) -> None:
    found = sections(language)
    text = yaml.safe_dump(found, allow_unicode=True, width=10_000)
    in_code = {"opening", "opened", "afterwards"}
    for name, part in found["parts"].items():
        assert isinstance(part, str) or all(isinstance(word, str) for word in part), f"{name}: on and no want quotes"
        assert f"<{name}>" in text or name in in_code, f"nobody uses <{name}>"


def test_a_pattern_may_be_broken_anywhere_grouped_and_made_of_parts() -> None:
    parts = {"way": "(to|into)", "spot": ["hall", "hall way"]}
    pattern = re.compile(written_out("go <way>\n <spot>( now)?", parts))
    assert pattern.fullmatch("go into hall way now")
    assert pattern.groups == 0


def test_of_the_words_of_a_part_the_longest_counts() -> None:
    assert written_out("<spot>", {"spot": ["hall", "hall way"]}) == "(?:hall way|hall)"


def test_words_of_a_house_are_taken_as_they_are() -> None:
    assert re.fullmatch(written_out("<spot>", {}, {"spot": names(["the (old) <hall>"])}), "the (old) <hall>")
    assert names([]) == "(?!)"


def test_a_part_that_nobody_knows_is_told() -> None:
    with pytest.raises(KeyError, match="elsewhere"):
        written_out("<elsewhere>", {})
