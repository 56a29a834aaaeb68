"""One tab of a browser, and the process of the console that draws in it.

The process has pipes in the place of a terminal (:mod:`tui.terminal.web_driver`), which textual-serve joins to the
socket of the tab. It ends with its tab: the robot stops first, and a process that does not go by itself is killed.
"""

from __future__ import annotations

import asyncio
import sys
from asyncio.subprocess import PIPE, Process
from collections.abc import Sequence
from contextlib import suppress
from typing import Final

from aiohttp import WSCloseCode, web
from textual_serve.app_service import AppService
from textual_serve.download_manager import DownloadManager

from engine.errors import ExitCode

LEAVE_LIMIT_S: Final = 8.0
"""In which the console ends by itself, s: it gives its engine three, and itself three more."""
ENDED: Final = "The console has ended, and the robot has stopped."
"""What the tab says then. A reason may have 123 bytes (RFC 6455, 5.5)."""
FAILED: Final = "The console has failed (exit code {}), and the robot has stopped. Where sayso --web runs, it says why."

_BOOT: Final = "from tui.cli import entry; entry()"


class Tab(AppService):
    """A console of these ``arguments`` (as on the command line) for the tab at the end of this socket."""

    def __init__(self, socket: web.WebSocketResponse, arguments: Sequence[str]) -> None:
        super().__init__(
            "sayso",
            write_bytes=socket.send_bytes,
            write_str=socket.send_str,
            close=self._leaving,
            download_manager=DownloadManager(),
        )
        self._socket = socket
        self._arguments = arguments

    async def _leaving(self) -> None:
        """It says that it ends, which may take a moment; the tab is closed when it has."""

    def _build_environment(self, width: int = 80, height: int = 24) -> dict[str, str]:
        """As textual-serve's; what the terminal of the server can do is nothing to a browser."""
        return {**super()._build_environment(width, height), "TERM": "xterm-256color"}

    async def _open_app_process(self, width: int = 80, height: int = 24) -> Process:
        """As textual-serve's, without a shell, and out of reach of the Ctrl-C that ends the server."""
        self._process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-P", "-c", _BOOT, "--tab", *self._arguments),
            stdin=PIPE,
            stdout=PIPE,
            stderr=PIPE,
            env=self._build_environment(width, height),
            start_new_session=True,
        )
        assert self._process.stdin is not None
        self._stdin = self._process.stdin
        return self._process

    async def run(self) -> None:
        """As textual-serve's; a console that is gone, even without a word, closes its tab."""
        assert self._process is not None
        await super().run()
        code = await self._process.wait()
        reason = ENDED if code in (ExitCode.DONE, ExitCode.INTERRUPTED) else FAILED.format(code)
        await self._socket.close(code=WSCloseCode.OK, message=reason.encode())

    async def stop(self) -> None:
        """End the console; it is gone when this returns."""
        task, self._task = self._task, None
        if task is None or self._process is None:
            return
        try:
            async with asyncio.timeout(LEAVE_LIMIT_S):
                await self.send_meta({"type": "quit"})  # one that hangs and reads nothing does not take it
                self.stdin.close()
                await asyncio.shield(task)
        except TimeoutError:
            with suppress(ProcessLookupError):
                self._process.kill()
            await task
