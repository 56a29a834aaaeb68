"""Saved prompts: the nearest one is found, a damaged one never reaches the model, and no more are kept than allowed."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from engine.llm.chat import Message
from engine.llm.prompt_cache import KEEP, PromptCache, rendered, shared


@pytest.fixture
def cache(tmp_path: Path) -> PromptCache:
    made = PromptCache(tmp_path / "prompts", ("model", 1))
    made.open()
    return made


def save(cache: PromptCache, text: str, state: bytes = b"state") -> None:
    draft = cache.draft()
    (cache.folder / draft).write_bytes(state)
    cache.keep(draft, text)


def files(cache: PromptCache) -> list[str]:
    return sorted(path.suffix for path in cache.folder.iterdir())


def test_the_prompt_that_begins_like_the_wanted_one_for_longest_is_found(cache: PromptCache) -> None:
    save(cache, "rules, skills, the flat")
    save(cache, "rules and poems")
    found = cache.nearest("rules, skills, the workshop")
    assert found is not None
    assert found.text == "rules, skills, the flat"
    assert (cache.folder / found.name).read_bytes() == b"state"


def test_a_prompt_that_has_nothing_in_common_is_not_found(cache: PromptCache) -> None:
    save(cache, "rules")
    assert cache.nearest("poems") is None


def test_what_another_model_or_llama_has_read_is_not_found(cache: PromptCache) -> None:
    save(cache, "rules")
    assert PromptCache(cache.folder, ("model", 2)).nearest("rules") is None


@pytest.mark.parametrize("damage", [b"stat", b"State", b"states"], ids=["cut short", "altered", "longer"])
def test_a_state_that_is_not_as_it_was_written_is_dropped(cache: PromptCache, damage: bytes) -> None:
    save(cache, "rules")
    next(cache.folder.glob("*.state")).write_bytes(damage)
    assert cache.nearest("rules") is None
    assert files(cache) == []


def test_a_note_that_cannot_be_read_takes_its_state_with_it(cache: PromptCache) -> None:
    save(cache, "rules")
    next(cache.folder.glob("*.json")).write_bytes(b"\xff{")
    assert cache.nearest("rules") is None
    assert files(cache) == []


def test_the_newest_few_are_kept_and_using_one_makes_it_new(cache: PromptCache) -> None:
    for number in range(KEEP):
        save(cache, f"{number} rules")
    for age, state in enumerate(sorted(cache.folder.glob("*.state"))):
        os.utime(state, (age, age))
    oldest = min(cache.folder.glob("*.state"), key=lambda state: state.stat().st_mtime)
    text = next(f"{number} rules" for number in range(KEEP) if cache.nearest(f"{number} rules") is not None)
    assert text == "0 rules"  # all of them were used just now
    os.utime(oldest, (0, 0))
    save(cache, "one too many")
    assert not oldest.exists()
    assert files(cache) == [".json"] * KEEP + [".state"] * KEEP


def test_what_a_killed_save_left_is_cleared_and_a_running_one_is_not(cache: PromptCache) -> None:
    for name, age in (("left.part", 0), ("left.note", 0), ("running.part", None)):
        (cache.folder / name).write_bytes(b"half")
        if age is not None:
            os.utime(cache.folder / name, (age, age))
    cache.open()
    assert [path.name for path in cache.folder.iterdir()] == ["running.part"]


def test_nobody_else_can_read_what_is_kept(cache: PromptCache) -> None:
    before = os.umask(0)
    try:
        save(cache, "where I live")
    finally:
        os.umask(before)
    assert cache.folder.stat().st_mode & 0o777 == 0o700
    assert {path.stat().st_mode & 0o777 for path in cache.folder.iterdir()} == {0o600}


def test_messages_that_begin_alike_are_rendered_so() -> None:
    rules, told = Message("system", "rules"), Message("user", "go")
    assert shared(rendered([rules]), rendered([rules, told])) == len(rendered([rules]))
    assert rendered([rules]) != rendered([Message("user", "rules")])
