"""A real browser without a screen: Chromium, told what to do through a pipe (the Chrome DevTools Protocol).

What its tab receives is fed to a terminal emulator as well: a test reads there what a person reads in the picture.
"""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import Any

import pyte

LIMIT_S = 60
PROGRAMS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")

WIRE = """
import os, sys
from fcntl import F_DUPFD_CLOEXEC, fcntl
for number, fd in enumerate([fcntl(int(fd), F_DUPFD_CLOEXEC, 10) for fd in sys.argv[1:3]], 3):
    os.dup2(fd, number)
os.execv(sys.argv[3], sys.argv[3:])
"""
"""Chromium reads descriptor 3 and writes descriptor 4, whatever they were called before."""


def missing() -> str | None:
    """Why no browser can be started here."""
    return None if _program() else "no Chromium is installed (make test-web installs it as root)"


def _program() -> str | None:
    return next(filter(None, map(shutil.which, PROGRAMS)), None)


class Tab:
    """One tab of the browser."""

    def __init__(self, browser: Browser, session: str) -> None:
        self._browser = browser
        self._session = session
        self._screen = pyte.Screen(80, 24)
        self._stream = pyte.ByteStream(self._screen)
        self.fetched: list[str] = []
        """The addresses of everything that was asked for."""
        for domain in ("Page", "Runtime", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        return self._browser.call(method, self._session, **parameters)

    def open(self, address: str) -> None:
        self.call("Page.navigate", url=address)

    def run(self, script: str) -> Any:
        """The value of an expression of the page."""
        return self.call("Runtime.evaluate", expression=script, returnByValue=True)["result"].get("value")

    def type(self, text: str) -> None:
        for sign in text:
            self.call("Input.dispatchKeyEvent", type="keyDown", text=sign, key=sign)
            self.call("Input.dispatchKeyEvent", type="keyUp", key=sign)

    def press(self, key: str, code: int) -> None:
        """A key with a name, by that and the number that browsers know it by."""
        text = {"text": "\r"} if key == "Enter" else {}
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, code=key, windowsVirtualKeyCode=code, **text)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key, code=key, windowsVirtualKeyCode=code)

    def picture(self) -> bytes:
        """What is to be seen, as PNG."""
        return base64.b64decode(self.call("Page.captureScreenshot")["data"])

    def close(self) -> None:
        self.call("Page.close")

    @property
    def text(self) -> str:
        """The terminal in it, line by line."""
        return "\n".join(self._screen.display)

    @property
    def told(self) -> str:
        """What the page says about a line that is closed; nothing while it is open."""
        return self.run('document.body.matches(".-closed") ? document.getElementById("why").textContent : ""') or ""

    def until(self, seen: Callable[[], object]) -> None:
        """Listen until ``seen`` holds; fails with the screen after ``LIMIT_S``."""
        end = time.monotonic() + LIMIT_S
        while not seen():
            if time.monotonic() > end:
                raise AssertionError(f"not seen within {LIMIT_S} s:\n{self.text}\n{self.told}")
            self._browser.listen(0.05)

    def happened(self, method: str, told: dict[str, Any]) -> None:
        match method:
            case "Network.requestWillBeSent":
                self.fetched.append(told["request"]["url"])
            case "Network.webSocketCreated":
                self.fetched.append(told["url"])
            case "Network.webSocketFrameReceived" if told["response"]["opcode"] == 2:
                self._stream.feed(base64.b64decode(told["response"]["payloadData"]))
            case "Network.webSocketFrameSent" if told["response"]["payloadData"].startswith('["resize"'):
                size = json.loads(told["response"]["payloadData"])[1]
                self._screen.resize(size["height"], size["width"])


class Browser:
    """A running Chromium. It writes and reads JSON, each with a zero byte behind it."""

    def __init__(self, to: int, of: int) -> None:
        self._to, self._of = to, of
        self._numbers = count(1)
        self._read = b""
        self._answers: dict[int, dict[str, Any]] = {}
        self._tabs: dict[str, Tab] = {}

    def tab(self) -> Tab:
        """A new one, which is the one in front."""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        tab = self._tabs[session] = Tab(self, session)
        return tab

    def call(self, method: str, session: str | None = None, **parameters: Any) -> dict[str, Any]:
        number = next(self._numbers)
        to = {} if session is None else {"sessionId": session}
        asked = json.dumps({"id": number, "method": method, "params": parameters, **to})
        os.write(self._to, asked.encode() + b"\0")
        end = time.monotonic() + LIMIT_S
        while number not in self._answers:
            assert time.monotonic() < end, f"no answer to {method}"
            self.listen(0.05)
        answer = self._answers.pop(number)
        assert "error" not in answer, answer
        result: dict[str, Any] = answer["result"]
        return result

    def listen(self, seconds: float) -> None:
        """Take what the browser says within this time."""
        while select.select([self._of], [], [], seconds)[0]:
            data = os.read(self._of, 1 << 20)
            assert data, "the browser has ended"
            *messages, self._read = (self._read + data).split(b"\0")
            for message in map(json.loads, messages):
                if "id" in message:
                    self._answers[message["id"]] = message
                elif (tab := self._tabs.get(message.get("sessionId", ""))) is not None:
                    tab.happened(message["method"], message["params"])
            seconds = 0


@contextmanager
def browser() -> Iterator[Browser]:
    """A browser that knows nothing of its owner; afterwards it is gone."""
    program = _program()
    assert program is not None
    theirs_in, to = os.pipe()
    of, theirs_out = os.pipe()
    with tempfile.TemporaryDirectory(prefix="browser", ignore_cleanup_errors=True) as profile:
        argv = [
            program,
            "--headless=new",
            "--remote-debugging-pipe",
            "--window-size=1200,800",
            f"--user-data-dir={Path(profile)}",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-dev-shm-usage",
            *(["--no-sandbox"] if os.getuid() == 0 else []),  # the sandbox refuses root; only our own page is opened
        ]
        wired = [sys.executable, "-S", "-c", WIRE, str(theirs_in), str(theirs_out), *argv]
        quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        process = subprocess.Popen(wired, pass_fds=(theirs_in, theirs_out), start_new_session=True, **quiet)
        os.close(theirs_in)
        os.close(theirs_out)
        try:
            yield Browser(to, of)
        finally:
            os.close(to)  # at the end of its pipe it ends, too
            os.close(of)
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
