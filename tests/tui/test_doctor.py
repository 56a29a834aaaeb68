"""The doctor inside: findings come one by one, in a thread, and the console works on meanwhile."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import pytest
from syrupy.assertion import SnapshotAssertion

from config import load
from engine.commands import Interrupt
from engine.handle import PartStatus
from tests.tui.desk import Desk, console
from tests.tui.test_copying import copied
from tui.doctor.examiner import Examiner
from tui.doctor.finding import Check, Finding
from tui.screens.console import ConsoleScreen
from tui.screens.doctor import DoctorScreen

FINDINGS = (
    Finding("python", "ok", "3.13.1, 2 cores"),
    Finding("voice", "limited", "espeak; piper sounds better", "sayso models pull piper"),
    Finding("terminal", "missing", "no terminal", needed=True),
)


@dataclass
class Ward:
    """Checks that end when a test says so."""

    go_on: threading.Semaphore = field(default_factory=lambda: threading.Semaphore(0))
    threads: list[str] = field(default_factory=list)

    def examiner(self) -> Examiner:
        return Examiner(load(environ={}), checks=[Check(one.name, self._check(one)) for one in FINDINGS])

    def _check(self, finding: Finding):  # type: ignore[no-untyped-def]
        def look(settings: object) -> Finding:
            self.threads.append(threading.current_thread().name)
            assert self.go_on.acquire(timeout=20)
            return finding

        return look


def found(desk: Desk) -> int:
    screen = desk.app.screen
    return len(screen._found) if isinstance(screen, DoctorScreen) else 0


async def opened(desk: Desk, ward: Ward) -> None:
    desk.app.examining.know(ward.examiner)
    await desk.press("d")
    assert isinstance(desk.app.screen, DoctorScreen)


async def all_found(desk: Desk, ward: Ward) -> None:
    ward.go_on.release(len(FINDINGS))
    await desk.until(lambda: found(desk) == len(FINDINGS) and "examined so far" not in desk.text)


async def test_each_finding_is_shown_as_it_comes_with_a_sign_a_word_and_what_to_do() -> None:
    ward = Ward()
    async with console() as desk:
        await opened(desk, ward)
        await desk.until(lambda: "◌ python … 0 examined so far" in desk.text)
        ward.go_on.release()
        await desk.until(lambda: "✓ fine      python          3.13.1, 2 cores" in desk.text)
        await desk.until(lambda: "◌ voice … 1 examined so far" in desk.text)
        await all_found(desk, ward)
        for words in (
            "! limited   voice",
            "→ sayso models pull piper",
            "✗ missing   terminal",
            "✓ 1 fine · ! 1 limited",
        ):
            assert words in desk.text
        assert not any(name.startswith("Main") for name in ward.threads)


async def test_escape_stops_the_robot_and_one_can_leave_while_a_check_still_hangs() -> None:
    ward = Ward()
    async with console() as desk:
        await opened(desk, ward)
        await desk.press("escape")
        assert desk.engine.sent == [Interrupt()]
        await desk.press("backspace")
        assert isinstance(desk.app.screen, ConsoleScreen)
        ward.go_on.release(len(FINDINGS))


async def test_r_examines_everything_once_more_and_not_twice_at_a_time() -> None:
    ward = Ward()
    async with console() as desk:
        await opened(desk, ward)
        await desk.press("r")
        await all_found(desk, ward)
        assert len(ward.threads) == len(FINDINGS)
        await desk.press("r")
        assert "0 examined so far" in desk.text
        await all_found(desk, ward)
        assert len(ward.threads) == 2 * len(FINDINGS)


async def test_r_is_a_key_of_the_page_alone_and_the_help_says_so() -> None:
    ward = Ward()
    async with console() as desk:
        desk.app.examining.know(ward.examiner)
        await desk.press("r")
        assert desk.app.screen is desk.app.main
        await opened(desk, ward)
        await all_found(desk, ward)
        await desk.press("question_mark")
        first, _, _ = desk.text.partition("To begin")
        assert "On the page of the doctor" in first
        assert "Examine everything once more." in first


async def test_y_copies_what_was_found(monkeypatch: pytest.MonkeyPatch) -> None:
    ward = Ward()
    async with console() as desk:
        await opened(desk, ward)
        await all_found(desk, ward)
        lines = (await copied(desk, monkeypatch, "y")).splitlines()
        assert lines[0] == "✓ fine      python          3.13.1, 2 cores"
        assert lines[2].strip() == "→ sayso models pull piper"
        assert f"to clipboard: {len(lines)} lines" in desk.text.splitlines()[0]


@pytest.mark.parametrize("size", [(120, 40), (80, 24)])
async def test_the_page_looks_as_in_its_picture(size: tuple[int, int], screenshot: SnapshotAssertion) -> None:
    ward = Ward()
    async with console(size=size) as desk:
        await opened(desk, ward)
        await all_found(desk, ward)
        assert await desk.picture() == screenshot(name=f"doctor_{size[0]}x{size[1]}")


async def test_the_engine_is_asked_for_what_it_has() -> None:
    asked: list[Sequence[PartStatus]] = []

    class Asked(Examiner):
        def examine(self, parts: Sequence[PartStatus], begins: Callable[[str], object] = str) -> Iterator[Finding]:
            asked.append(parts)
            return super().examine(parts, begins)

    async with console() as desk:
        desk.app.examining.know(lambda: Asked(load(environ={}), checks=[]))
        await desk.press("d")
        await desk.until(lambda: asked)
        assert tuple(asked[0]) == desk.engine.parts


async def test_before_the_settings_are_read_it_says_so() -> None:
    async with console() as desk:
        await desk.press("d")
        assert isinstance(desk.app.screen, ConsoleScreen)
        assert "The settings are not read yet" in desk.text
