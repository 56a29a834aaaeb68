"""What was typed is there in the next session, belongs to its owner alone, and never disturbs."""

from __future__ import annotations

import os
import resource
import stat
import threading
from pathlib import Path

import pytest

from engine import events as ev
from engine.commands import Say
from tests.tui.desk import console
from tui.kept.history import MAX_LINE, MAX_REQUESTS, RequestHistory
from tui.palette.palette import Palette
from tui.widgets.ask import Ask


def kept(path: Path, *requests: str) -> None:
    """A session in which this is typed."""
    history = RequestHistory(path)
    history.read()
    for request in requests:
        history.add(request)
    history.close(30)


def read(path: Path) -> tuple[str, ...]:
    history = RequestHistory(path)
    history.read()
    return history.earlier


def test_requests_are_kept_from_one_session_to_the_next(tmp_path: Path) -> None:
    path = tmp_path / "state" / "requests"
    assert read(path) == ()
    kept(path, "go to the kitchen", "去厨房")
    kept(path, "dance")
    assert read(path) == ("go to the kitchen", "去厨房", "dance")


def test_only_the_owner_may_read_the_file(tmp_path: Path) -> None:
    path = tmp_path / "requests"
    kept(path, "dance")
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_a_file_that_others_could_read_is_closed_to_them(tmp_path: Path) -> None:
    path = tmp_path / "requests"
    path.write_text("dance\n")
    path.chmod(0o644)
    kept(path, "nod")
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_no_more_is_kept_than_is_recalled(tmp_path: Path) -> None:
    path = tmp_path / "requests"
    path.write_text("".join(f"wait {n} seconds\n" for n in range(3 * MAX_REQUESTS)))
    found = read(path)
    assert len(found) == MAX_REQUESTS
    assert found[-1] == f"wait {3 * MAX_REQUESTS - 1} seconds"
    assert len(path.read_text().splitlines()) == MAX_REQUESTS
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert [file.name for file in tmp_path.iterdir()] == ["requests"]


def test_a_huge_file_is_read_from_its_end(tmp_path: Path) -> None:
    path = tmp_path / "requests"
    path.write_bytes(b"x" * 3_000_000 + b"\nnod\n")
    assert read(path) == ("nod",)
    assert path.stat().st_size == 4


def test_what_is_no_text_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "requests"
    path.write_bytes(b"nod\n\xff\xfe\x00broken\n\x1b[31mred\n" + b"y" * (MAX_LINE + 1) + b"\n\n  dance \n")
    assert read(path) == ("nod", "dance")


def test_one_line_is_one_request(tmp_path: Path) -> None:
    path = tmp_path / "requests"
    kept(path, "nod\nrm -rf /", "dance")
    assert read(path) == ("dance",)


def told(path: Path) -> list[str]:
    """What a session says that cannot keep what is typed."""
    words: list[str] = []
    history = RequestHistory(path)
    history.read(words.append)
    for request in ("nod", "dance"):
        history.add(request)
    history.close(30)
    return words


def test_a_full_disk_is_told_once(tmp_path: Path) -> None:
    usual = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, usual[1]))  # nobody can write to a file, as on a full disk
    try:
        words = told(tmp_path / "requests")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, usual)
    assert len(words) == 1


def test_a_device_in_place_of_the_file_stays_as_it_is(tmp_path: Path) -> None:
    device = Path("/dev/null")
    before = device.stat().st_mode
    (tmp_path / "requests").symlink_to(device)
    assert len(told(tmp_path / "requests")) == 1
    assert device.stat().st_mode == before


def test_a_folder_in_place_of_the_file_is_told_once(tmp_path: Path) -> None:
    (tmp_path / "requests").mkdir()
    assert len(told(tmp_path / "requests")) == 1


def test_a_state_folder_that_cannot_be_made_is_told_once(tmp_path: Path) -> None:
    (tmp_path / "state").write_text("a file")
    assert len(told(tmp_path / "state" / "requests")) == 1


def test_a_pipe_in_place_of_the_file_holds_nobody_up(tmp_path: Path) -> None:
    path = tmp_path / "requests"
    os.mkfifo(path)
    ended: list[list[str]] = []
    thread = threading.Thread(target=lambda: ended.append(told(path)), daemon=True)
    thread.start()
    thread.join(30)
    assert ended
    assert len(ended[0]) == 1


async def test_up_recalls_what_was_typed_in_an_earlier_session(tmp_path: Path) -> None:
    kept(tmp_path / "requests", "go to the kitchen", "dance")
    async with console() as desk:
        desk.app.dress("sayso-dark", 30, history=RequestHistory(tmp_path / "requests"))
        line = desk.app.query_one(Ask)
        await desk.until(lambda: line.history)
        await desk.press("slash", *"nod", "enter", "up", "up", "up")
        assert line.value == "go to the kitchen"
        assert desk.engine.sent == [Say("nod")]
        await desk.until(lambda: read(tmp_path / "requests") == ("go to the kitchen", "dance", "nod"))


async def test_without_a_file_only_this_session_is_recalled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SAYSO_STATE_DIR", str(tmp_path))
    async with console() as desk:
        desk.app.dress("sayso-dark", 30)
        await desk.press("slash", *"nod", "enter", "slash", "up")
        assert desk.app.query_one(Ask).value == "nod"
    assert os.listdir(tmp_path) == []  # noqa: PTH208


async def test_a_history_that_cannot_be_kept_is_said_in_the_log_and_typing_goes_on(tmp_path: Path) -> None:
    (tmp_path / "requests").mkdir()
    async with console() as desk:
        desk.app.dress("sayso-dark", 30, history=RequestHistory(tmp_path / "requests"))
        await desk.until(lambda: any("not saved" in line.message for line in desk.app.shown.model.log))
        await desk.press("slash", *"nod", "enter")
        assert desk.engine.sent == [Say("nod")]


def test_of_what_nothing_was_made_is_known_in_the_next_session_until_it_is_asked_for_again(tmp_path: Path) -> None:
    path = tmp_path / "requests"
    history = RequestHistory(path)
    history.read()
    for request in ("pick up the red bx", "dance", "nod"):
        history.add(request)
    history.mark("pick up the red bx")
    history.mark("dance")
    history.add("dance")
    history.close(30)
    history = RequestHistory(path)
    history.read()
    assert history.earlier == ("pick up the red bx", "dance", "nod", "dance")
    assert history.in_vain == {"pick up the red bx"}
    history._rewrite()
    history.read()
    assert history.in_vain == {"pick up the red bx"}


@pytest.mark.parametrize(
    "told",
    [
        ev.PlanRejected("pick up the red bx", "I don't know a red bx.", "unknown_object"),
        ev.RefusalMade("That is not safe.", "pick up the red bx"),
        ev.ClarificationAsked("Shall I pick up the red box?", "pick up the red bx"),
    ],
)
async def test_what_was_refused_or_not_understood_is_recalled_and_not_offered(told: ev.Body, tmp_path: Path) -> None:
    async with console(in_line=True) as desk:
        desk.app.dress("sayso-dark", 30, history=RequestHistory(tmp_path / "requests"))
        await desk.press(*"pick up the red bx", "enter", *"pick up the red")
        ask = desk.app.query_one(Ask)
        assert ask._suggestion == "pick up the red bx"
        desk.engine.publish(told)
        await desk.press("space", "backspace")
        assert ask._suggestion == ""
        await desk.press("ctrl+u", "ctrl+p")
        palette = desk.app.query_one(Palette)
        assert "pick up the red bx" not in [entry.title for entry in palette.shown]
        await desk.press("ctrl+g", "ctrl+r")
        assert "pick up the red bx" in [entry.title for entry in desk.app.query_one(Palette).shown]
        await desk.press("ctrl+g", "up")
        assert ask.value == "pick up the red bx"
    history = RequestHistory(tmp_path / "requests")
    history.read()
    assert history.in_vain == {"pick up the red bx"}


async def test_what_was_not_understood_as_an_answer_is_not_offered(tmp_path: Path) -> None:
    async with console(in_line=True) as desk:
        desk.app.dress("sayso-dark", 30, history=RequestHistory(tmp_path / "requests"))
        for text in ("dance", "snorf"):
            await desk.press(*text, "enter")
            desk.engine.publish(ev.TranscriptFinal(text, "text", "", 1.0, 0.0, 0.0, 0.0, 0.0))
            about = "go to the bedrom" if text == "snorf" else ""  # a skill has asked the first time
            desk.engine.publish(ev.ClarificationAsked("Shall I go to the bedroom?", about))
            await desk.settled()
    history = RequestHistory(tmp_path / "requests")
    history.read()
    assert history.in_vain == {"snorf"}


async def test_several_that_were_pasted_are_not_offered() -> None:
    async with console(in_line=True) as desk:
        ask = desk.app.query_one(Ask)
        ask.paste("zig\nzag")
        await desk.press("enter", *"zi")
        assert ask._suggestion == ""
        await desk.press("ctrl+u", "up")
        assert ask.value == "zig ⏎ zag"
