"""``sayso --web``: the console in a browser, with a real engine and real physics in real time."""

from __future__ import annotations

import asyncio
import http.client
import json
import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, quote, urlsplit

import cv2
import numpy as np
import psutil
import pytest
from aiohttp import ClientSession, WSMsgType

from engine.errors import ExitCode
from tests.e2e import browser
from tests.e2e.browser import Browser
from tests.e2e.sayso import LIMIT_S, command, environment, sayso
from tui.web.server import GONE_REASON, TAKEN_REASON
from tui.web.tab import ENDED, FAILED


@dataclass
class Served:
    """A running ``sayso --web``."""

    process: subprocess.Popen[str]
    url: str
    state: Path

    def at(self, path: str) -> str:
        """The address of something else there, with the token."""
        return self.url.replace("/?", f"/{path}?")

    @property
    def consoles(self) -> list[psutil.Process]:
        """One for each tab that has one."""
        return psutil.Process(self.process.pid).children()

    def events(self) -> list[dict[str, Any]]:
        """Everything in the session logs so far, oldest session first, except what is just being written."""
        logs = sorted((self.state / "logs").glob("*.jsonl"))
        lines = [line for log in logs for line in log.read_bytes().splitlines(True)]
        return [json.loads(line) for line in lines if line.endswith(b"\n")]

    def last(self, kind: str) -> dict[str, Any]:
        """Body of the newest event of this kind, or {}."""
        return next((event["body"] for event in reversed(self.events()) if event["kind"] == kind), {})

    def is_driving(self) -> bool:
        return self.last("robot.state").get("twist", {}).get("vx", 0.0) > 0.2

    def is_at_rest(self) -> bool:
        return self.last("robot.state").get("moving") is False

    def end(self, number: signal.Signals) -> int:
        """The exit code; nothing is left behind."""
        family = psutil.Process(self.process.pid).children(recursive=True)
        self.process.send_signal(number)
        code = self.process.wait(LIMIT_S)
        assert psutil.wait_procs(family, timeout=10)[1] == []
        return code


@contextmanager
def serving(state: Path, *arguments: str) -> Iterator[Served]:
    """``sayso --web`` at a port of its own; afterwards it is gone."""
    argv = command("--web", "--web-port", "0", *arguments)
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(argv, env=environment(state), **pipes) as process:
        try:
            assert process.stdout is not None
            assert process.stderr is not None
            url = process.stdout.readline().strip()
            assert url, process.stderr.read()
            yield Served(process, url, state)
        finally:
            process.terminate()  # its consoles end with it
            process.wait(LIMIT_S)


@pytest.fixture
def chromium() -> Iterator[Browser]:
    if reason := browser.missing():
        pytest.fail(reason) if "TEST_WEB" in os.environ else pytest.skip(reason)  # make test-web sets it
    with browser.browser() as running:
        yield running


def test_a_request_is_typed_in_a_browser_and_esc_stops_the_robot(tmp_path: Path, chromium: Browser) -> None:
    with serving(tmp_path) as served:
        tab = chromium.tab()
        tab.open(served.url)
        tab.until(lambda: "✓ robot" in tab.text)
        tab.type("/go to the kitchen")
        tab.press("Enter", 13)
        tab.until(lambda: served.is_driving() and "ACTING" in tab.text and "Going to the kitchen." in tab.text)
        tab.press("Escape", 27)
        tab.until(lambda: served.last("action.finished").get("outcome") == "interrupted")
        tab.until(lambda: served.is_at_rest() and "READY" in tab.text)
        assert 0.01 < served.last("robot.state")["pose"]["y"] < 1.9
        tab.press("Tab", 9)  # to the panes, where letters are keys
        tab.type("i")
        tab.until(lambda: re.search(r"line \d+ ms", tab.text))  # the browser reports what it has drawn
        assert shades(tab.picture()) > 50, "nothing was drawn"
        here = urlsplit(served.url).netloc
        assert {urlsplit(address).netloc for address in tab.fetched} == {here}, "something came from elsewhere"
        assert any("RobotoMono" in address for address in tab.fetched)
        assert served.end(signal.SIGINT) == ExitCode.INTERRUPTED
        tab.until(lambda: tab.told == GONE_REASON)


def shades(picture: bytes) -> int:
    """How many colours there are in it."""
    pixels = cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR)
    assert pixels is not None
    return len(np.unique(pixels.reshape(-1, 3), axis=0))


def test_one_tab_has_the_robot_and_closing_it_stops_the_robot(tmp_path: Path, chromium: Browser) -> None:
    with serving(tmp_path) as served:
        first, second = chromium.tab(), chromium.tab()
        first.open(served.url)
        first.until(lambda: "✓ robot" in first.text)
        second.open(served.url)
        second.until(lambda: second.told == TAKEN_REASON)
        assert len(served.consoles) == 1
        first.type("/go to the bedroom")
        first.press("Enter", 13)
        first.until(lambda: served.is_driving())
        first.close()
        second.until(lambda: served.events()[-1]["kind"] == "session.ended")
        assert served.last("action.finished")["outcome"] == "interrupted"
        second.press("Enter", 13)  # of the only button there is
        second.until(lambda: "READY" in second.text and not second.told)
        console = served.consoles[0].pid
        second.open(served.url)  # once more: its own former self is not another one
        second.until(lambda: served.consoles and served.consoles[0].pid != console)
        second.until(lambda: "READY" in second.text and not second.told)
        second.press("Tab", 9)  # to the panes
        second.type("q")
        second.until(lambda: second.told == ENDED)
        assert served.consoles == []
        assert served.end(signal.SIGTERM) == ExitCode.DONE


def test_a_tab_whose_console_is_killed_is_told(tmp_path: Path) -> None:
    async def told(served: Served) -> str:
        async with ClientSession() as client, asyncio.timeout(LIMIT_S), client.ws_connect(served.at("ws")) as tab:
            assert (await tab.receive()).type is WSMsgType.BINARY, "it draws"
            served.consoles[0].kill()
            while (message := await tab.receive()).type is WSMsgType.BINARY:
                pass
            return str(message.extra)

    with serving(tmp_path) as served:
        assert asyncio.run(told(served)) == FAILED.format(-9)


def status(url: str, path: str, headers: dict[str, str]) -> int:
    """What the server answers to such a request."""
    here = urlsplit(url)
    connection = http.client.HTTPConnection(here.hostname or "", here.port, timeout=LIMIT_S)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    answer.read()
    connection.close()
    return answer.status


def test_pages_of_others_and_other_names_are_turned_away(tmp_path: Path) -> None:
    with serving(tmp_path) as served:
        here = urlsplit(served.url).netloc
        asks: Callable[..., int] = lambda path, **headers: status(served.url, path, headers)  # noqa: E731
        token = urlsplit(served.url).query
        assert asks(f"/static/js/textual.js?{token}") == 200
        assert asks(f"/?{token}", Host="localhost:9000") == 303, "a tunnel that ends at another port"
        assert asks(f"/?{token}", Host="evil.example") == 403
        upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13"}
        upgrade |= {"Sec-WebSocket-Key": "c2F5c28gc2F5c28gc2F5cw=="}
        assert asks(f"/ws?{token}", **upgrade, Origin="https://evil.example") == 403
        assert asks(f"/ws?{token}", **upgrade, Origin="null") == 403
        assert served.consoles == []
        assert asks(f"/?{token}", Host=here, Origin=f"http://{here}") == 303


def test_nobody_is_let_in_without_the_token_of_the_printed_address(tmp_path: Path) -> None:
    with serving(tmp_path) as served:
        here = urlsplit(served.url)
        token = parse_qs(here.query)["token"][0]
        name = f"sayso-{here.port}"
        upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13"}
        upgrade |= {"Sec-WebSocket-Key": "c2F5c28gc2F5c28gc2F5cw=="}
        asks: Callable[..., int] = lambda path, **headers: status(served.url, path, headers)  # noqa: E731
        for wrong in (
            "",
            "?token=",
            "?token=x",
            f"?token={token}x",
            f"?token={token[:-1]}",
            "?token=%ff%00é",
            "?Token=x",
        ):
            path = quote(wrong, safe="?=%")
            assert [asks(f"/{path}"), asks(f"/ws{path}", **upgrade), asks(f"/static/css/xterm.css{path}")] == [403] * 3
        assert asks("/", Cookie=f"{name}=x") == 403
        assert asks("/", Cookie=f"other={token}") == 403
        assert asks(f"/?token={token}") == 303
        assert asks("/", Cookie=f"{name}={token}") == 200
        assert asks("/?token=x", Cookie=f"{name}={token}") == 403
        assert asks("/static/css/xterm.css", Cookie=f"{name}={token}") == 200
        assert served.consoles == []


def test_a_request_that_cannot_be_read_is_answered_and_no_more(tmp_path: Path) -> None:
    with serving(tmp_path) as served:
        token = urlsplit(served.url).query
        for path in (f"/?{token}&{'a' * 20_000}", f"/{'a' * 20_000}?{token}"):
            assert 400 <= status(served.url, path, {}) < 500
        assert 400 <= status(served.url, f"/?{token}", {"X": "a" * 20_000}) < 500
        assert served.end(signal.SIGTERM) == ExitCode.DONE
        assert served.process.stderr is not None
        told = served.process.stderr.read()
        assert "Traceback" not in told
        assert token.partition("=")[2] not in told


def test_a_port_that_is_taken_and_an_address_of_others_are_told(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        done = sayso("--web", "--web-port", str(taken.getsockname()[1]), state=tmp_path)
    assert done.returncode == ExitCode.MISSING
    assert "--web-port" in done.stderr.decode()
    done = sayso("--web", "--web-host", "192.0.2.1", state=tmp_path)  # RFC 5737: it is nobody's
    assert done.returncode == ExitCode.MISSING
    assert "--web-host" in done.stderr.decode()
    assert done.stdout == b""


@pytest.mark.skipif(sys.platform != "linux", reason="127.0.0.2 is Linux's")
def test_whoever_serves_beyond_this_machine_is_warned_and_others_are_not(tmp_path: Path) -> None:
    for host, warned in (("0.0.0.0", True), ("127.0.0.2", False)):
        with serving(tmp_path, "--web-host", host) as served:
            assert served.end(signal.SIGHUP) == ExitCode.DONE
            assert served.process.stderr is not None
            told = served.process.stderr.read()
            assert ("not encrypted" in told) is warned
            assert "Traceback" not in told
