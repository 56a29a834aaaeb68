"""``S`` keeps the session and a picture of the screen where only their owner reads them, and says where."""

from __future__ import annotations

import resource
import stat
from datetime import UTC, datetime
from pathlib import Path
from xml.etree import ElementTree

import pytest

from config.folders import Paths, paths
from engine.errors import StorageError
from engine.event_log import EventLog
from tests.tui import scripted
from tests.tui.desk import console
from tests.tui.scripted import ScriptedEngine
from tui.kept.saving import EVENTS, PICTURE, save

NOON = datetime(2026, 3, 1, 12, 0, tzinfo=UTC)


@pytest.fixture
def folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Paths:
    monkeypatch.setenv("SAYSO_STATE_DIR", str(tmp_path / "state"))
    return paths()


def logged(engine: ScriptedEngine, folders: Paths, session: str, *, max_bytes: int = 1_000_000) -> EventLog:
    """The log that the engine writes, as the real one does."""
    log = EventLog(folders.logs, session, max_bytes=max_bytes, keep=10)
    log.open()
    engine.subscribe(log.write)
    return log


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


async def test_s_saves_the_events_and_the_picture_and_says_where(folders: Paths) -> None:
    engine = ScriptedEngine()
    session = engine.publish(scripted.OPENING[0].body).session
    log = logged(engine, folders, session)
    async with console(engine) as desk:
        engine.play(scripted.acting())
        await desk.settled()
        await desk.press("S")
        await desk.until(lambda: desk.app.keeping.told)
        await desk.settled()
        (folder,) = (folders.state / "saved").iterdir()
        assert f"saved in {folder}"[:30] in desk.text.splitlines()[0]
        assert f"saved in {folder}" in desk.app.shown.model.log[-1].message
        assert (folder / EVENTS).read_bytes() == (folders.logs / f"{session}.jsonl").read_bytes() != b""
        picture = (folder / PICTURE).read_text()
        assert ElementTree.fromstring(picture).tag.endswith("svg")
        assert "ACTING" in picture
        assert "url(http" not in picture
        assert [mode(path) for path in (folder, folder / EVENTS, folder / PICTURE)] == [0o700, 0o600, 0o600]
    log.close()


async def test_a_session_without_a_log_keeps_its_picture_and_says_so(folders: Paths) -> None:
    async with console() as desk:
        await desk.press("S")
        await desk.until(lambda: desk.app.keeping.told)
        (folder,) = (folders.state / "saved").iterdir()
        assert [path.name for path in folder.iterdir()] == [PICTURE]
        assert desk.app.keeping.told == f"this session has no log; only the picture is saved: {folder}"


async def test_a_folder_that_takes_nothing_is_told_in_the_console_which_goes_on(folders: Paths) -> None:
    folders.state.write_text("a file in its place")
    async with console() as desk:
        await desk.press("S")
        await desk.until(lambda: desk.app.keeping.told)
        await desk.settled()
        told = desk.app.shown.model.log[-1]
        assert told.level == "error"
        assert told.message.startswith(f"The session could not be saved in {folders.state / 'saved'}: ")
        assert "SAYSO_STATE_DIR" in told.message
        await desk.press("escape")
        assert len(desk.engine.sent) == 1


def test_what_does_not_fit_on_the_disk_leaves_nothing_behind_and_says_why(folders: Paths) -> None:
    folders.logs.mkdir(parents=True)
    (folders.logs / "S1.jsonl").write_bytes(b"{}\n" * 100_000)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, hard))  # the kernel refuses as a full disk does
    try:
        with pytest.raises(StorageError, match=r"The session could not be saved in .*saved: .+\."):
            save(folders, "S1", "<svg/>", NOON)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert list((folders.state / "saved").iterdir()) == []


def test_a_log_in_parts_is_saved_in_order_without_a_half_line_or_another_session(folders: Paths) -> None:
    folders.logs.mkdir(parents=True)
    for name, text in {"S1": "1\n", "S1.2": "2\n3\n", "S1.3": "4\nhal", "S12": "other\n", "S0": "other\n"}.items():
        (folders.logs / f"{name}.jsonl").write_text(text)
    saved = save(folders, "S1", "<svg/>", NOON)
    assert (saved.folder / EVENTS).read_text() == "1\n2\n3\n4\n"
    assert saved.folder.name == "20260301T120000Z"


def test_two_saved_within_a_second_stand_side_by_side(folders: Paths) -> None:
    names = [save(folders, "", "<svg/>", NOON).folder.name for _ in range(3)]
    assert names == ["20260301T120000Z", "20260301T120000Z.2", "20260301T120000Z.3"]
