"""What the user wrote down is found when it is needed, and a file that cannot be read stops nothing."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.planner.stages.knowledge import (
    FEW,
    MAX_FACT,
    MAX_FACTS,
    MAX_FILE,
    Knowledge,
    KnowledgeError,
    packaged,
    parse,
    read,
)

MANY = """
# What I mean

- When I say "I'm thirsty", bring me a **bottle** of water from the kitchen.
- "Good night" means: go to the charging dock
  and turn the light off.

# Where things are kept

* The blue cup usually stands on the kitchen counter.
* Toys belong on the shelf in the study.
* My glasses are kept on the bedside table.

Anna is usually at her desk in the study.
She does not like beeps.

1. 我渴了的意思是给我拿一瓶水。
2. 小明的玩具放在卧室的架子上。
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "knowledge.md"
    path.write_text(MANY, "utf-8")
    return path


def rewritten(path: Path, text: str) -> None:
    """Write a file so that it looks changed, however coarse the clock of the file system is."""
    before = path.stat().st_mtime_ns if path.exists() else 0
    path.write_text(text, "utf-8")
    os.utime(path, ns=(before + 10**9, before + 10**9))


def test_bullets_and_paragraphs_are_facts_and_headings_are_none(file: Path) -> None:
    facts = Knowledge(file).facts()
    assert facts[0] == 'When I say "I\'m thirsty", bring me a bottle of water from the kitchen.'
    assert facts[1] == '"Good night" means: go to the charging dock and turn the light off.'
    assert "Anna is usually at her desk in the study. She does not like beeps." in facts
    assert len(facts) == 8


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("I am thirsty", "bottle of water"),
        ("I'm so thirsty!", "bottle of water"),
        ("good night, robot", "charging dock"),
        ("bring me the blue cups", "kitchen counter"),
        ("put the toy where it belongs", "shelf in the study"),
        ("where did I put my glasses", "bedside table"),
        ("bring this to Anna", "desk in the study"),
        ("我好渴了", "给我拿一瓶水"),
        ("把小明的玩具收好", "卧室的架子"),
    ],
)
def test_the_fact_that_shares_words_with_the_request_comes_first(file: Path, text: str, part: str) -> None:
    assert part in Knowledge(file).facts_for(text, 1)[0]


def test_a_request_that_shares_nothing_is_told_nothing(file: Path) -> None:
    assert Knowledge(file).facts_for("turn left ninety degrees", 4) == ()


def test_no_more_facts_are_told_than_asked_for(file: Path) -> None:
    knowledge = Knowledge(file)
    assert len(knowledge.facts_for("the kitchen and the study", 2)) == 2
    assert knowledge.facts_for("the kitchen and the study", 0) == ()


def test_a_small_file_is_told_as_a_whole_the_best_first(file: Path) -> None:
    rewritten(file, "- one\n- two is about the kitchen\n- three\n")
    assert FEW >= 3
    assert Knowledge(file).facts_for("go to the kitchen", 9) == ("two is about the kitchen", "one", "three")


def test_the_file_is_read_again_when_it_has_changed(file: Path) -> None:
    knowledge = Knowledge(file)
    assert knowledge.facts()
    rewritten(file, "- a new fact\n")
    assert knowledge.facts() == ("a new fact",)
    file.unlink()
    assert knowledge.facts() == ()
    rewritten(file, "- it is back\n")
    assert knowledge.facts() == ("it is back",)


def test_nobody_needs_such_a_file(tmp_path: Path) -> None:
    for knowledge in (Knowledge(), Knowledge(tmp_path / "none.md"), Knowledge(tmp_path / "none" / "none.md")):
        assert knowledge.facts_for("I am thirsty", 4) == ()
        assert knowledge.trouble is None


def test_a_file_that_is_not_utf_8_is_told_with_its_line_and_the_old_facts_stay(file: Path) -> None:
    knowledge = Knowledge(file)
    before = knowledge.facts()
    file.write_bytes("- fine\n- na\xefve\n".encode("latin-1"))
    os.utime(file, ns=(1, 1))
    assert knowledge.facts() == before
    assert knowledge.trouble is not None
    assert f"{file}:2: this is not UTF-8" in str(knowledge.trouble)
    rewritten(file, "- mended\n")
    assert knowledge.facts() == ("mended",)
    assert knowledge.trouble is None


def test_a_folder_or_an_unreadable_file_is_an_error_for_people(tmp_path: Path) -> None:
    with pytest.raises(KnowledgeError, match="cannot be read"):
        read(tmp_path)
    knowledge = Knowledge(tmp_path)
    assert knowledge.facts() == ()
    assert knowledge.trouble is not None
    assert knowledge.trouble.hint


def test_too_much_is_an_error_for_people(file: Path) -> None:
    file.write_text("- x\n" * (MAX_FILE // 4 + 1), "utf-8")
    with pytest.raises(KnowledgeError, match="longer than"):
        read(file)
    file.write_text("".join(f"- fact {index}\n" for index in range(MAX_FACTS + 1)), "utf-8")
    with pytest.raises(KnowledgeError, match="are read at most"):
        read(file)


def test_a_long_fact_is_cut_at_a_word() -> None:
    (fact,) = parse("- " + "word " * MAX_FACT)
    assert len(fact) <= MAX_FACT + 1
    assert fact.endswith("word…")


def test_comments_code_fences_and_markup_are_no_facts() -> None:
    text = "<!-- - no\n\n- fact -->\n## [Title](x)\n```\n```\n- see [the *list*](http://x) for `more`\n---\n"
    text += "<!-- never closed\n- no"
    assert parse(text) == ("see the list for more",)


def test_the_packaged_file_holds_three_examples_and_is_a_comment_otherwise() -> None:
    facts = parse(packaged())
    assert len(facts) == 3
    assert "thirsty" in facts[0]


def test_a_byte_order_mark_and_windows_line_ends_do_no_harm(file: Path) -> None:
    file.write_bytes(b"\xef\xbb\xbf# Title\r\n\r\n- one\r\n- two\r\n")
    assert Knowledge(file).facts() == ("one", "two")


@settings(deadline=None)
@given(st.text(max_size=500), st.text(max_size=100))
def test_any_text_is_read_and_asked_without_an_error(
    tmp_path_factory: pytest.TempPathFactory, text: str, asked: str
) -> None:
    facts = parse(text)
    assert all(fact.isprintable() and len(fact) <= MAX_FACT + 1 for fact in facts)
    path = tmp_path_factory.mktemp("knowledge") / "knowledge.md"
    path.write_text(text, "utf-8", errors="replace")
    assert len(Knowledge(path).facts_for(asked, 3)) <= 3
