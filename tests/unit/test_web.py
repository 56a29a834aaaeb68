"""``sayso --web``: who may ask, where it is found, and what a console in a tab is started with."""

from __future__ import annotations

import asyncio
import signal
import socket
from pathlib import Path
from typing import cast
from unittest.mock import AsyncMock

import aiohttp.web
import pytest

from engine.errors import DeviceError, ExitCode
from tui import cli
from tui.commands import web
from tui.web import tab
from tui.web.server import GONE_REASON, TAKEN_REASON, is_ours
from tui.web.tab import ENDED, FAILED


@pytest.mark.parametrize(
    ("host", "ours"),
    [
        ("127.0.0.1:8300", True),
        ("[::1]:8300", True),
        ("192.168.1.7", True),
        ("localhost:9000", True),
        ("Robot.local:8300", True),
        ("robot.local.", True),
        ("evil.example:8300", False),
        ("localhost.evil.example", False),
        ("robot.local@evil.example", False),
        ("127.0.0.1.evil.example", False),
        ("", False),
        ("[", False),
    ],
)
def test_only_an_address_or_a_name_of_this_machine_is_answered(host: str, ours: bool) -> None:
    assert is_ours(host, ("robot.local",)) is ours


def test_what_a_tab_is_told_fits_into_the_end_of_its_line() -> None:
    assert max(len(reason.encode()) for reason in (ENDED, FAILED.format(-15), GONE_REASON, TAKEN_REASON)) <= 123


def test_a_console_in_a_tab_has_the_settings_that_were_given(tmp_path: Path) -> None:
    given = ["--config", str(tmp_path / "a.yaml"), "--set", "console.fps=4", "--set", "voice.backend=none"]
    asked = cli.build_parser().parse_args(["--web", "--demo", "--speed", "max", *given])
    assert asked.run == "tui.commands.web:run"
    in_tab = cli.build_parser().parse_args(["--tab", *web.console_arguments(asked)])
    assert in_tab.run == "tui.commands.console:run"
    for name in ("config", "set", "scene", "speed", "model", "demo"):
        assert getattr(in_tab, name) == getattr(asked, name), name


@pytest.mark.parametrize("port", ["-1", "65536", "http", ""])
def test_what_is_no_port_is_refused(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(["--web", f"--web-port={port}"])
    assert ended.value.code == ExitCode.USAGE
    assert "is no port" in capsys.readouterr().err


def test_a_port_that_is_taken_says_what_to_do() -> None:
    with (
        socket.create_server(("127.0.0.1", 0)) as taken,
        pytest.raises(DeviceError, match=r"already in use.*--web-port 0"),
    ):
        web.listening("127.0.0.1", taken.getsockname()[1])


def test_it_is_found_by_a_name_where_it_listens_everywhere() -> None:
    for host, found in (("127.0.0.1", "127.0.0.1"), ("localhost", "localhost"), ("0.0.0.0", socket.gethostname())):
        with web.listening(host, 0) as listener:
            assert web.address(listener, host) == f"http://{found}:{listener.getsockname()[1]}/"


def test_without_its_package_it_says_how_to_get_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(web, "find_spec", lambda name: None)
    assert cli.main(["--web"]) == ExitCode.MISSING
    assert "pip install 'sayso[web]'" in capsys.readouterr().err


def test_a_console_that_hangs_and_reads_nothing_does_not_keep_its_tab(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tab, "LEAVE_LIMIT_S", 0.3)
    monkeypatch.setattr(tab, "_BOOT", "import time; print('__GANGLION__', flush=True); time.sleep(600)")

    async def left() -> int | None:
        console = tab.Tab(cast(aiohttp.web.WebSocketResponse, AsyncMock()), [])
        await console.start(80, 24)
        assert console._process is not None
        console.stdin.write(b"x" * 1_000_000)  # more than a pipe holds
        async with asyncio.timeout(30):
            await console.stop()
        return console._process.returncode

    assert asyncio.run(left()) == -signal.SIGKILL
