"""Serves the console to a browser: textual-serve, for one tab at a time, and for nobody who was not meant.

There is one robot, so there is one console: whoever opens a second tab is told so. A tab that is reloaded is let in as
soon as its former self is gone.

Loopback is open to every account of this machine, so a browser has to show the token that only the printed address
has; from then on a cookie does. A browser also opens sockets to this machine for any page that asks, so a tab must come
from our own page, and under a name that is ours: another one may be somebody's who lets it lead here (DNS rebinding).
"""

from __future__ import annotations

import asyncio
import hmac
import ipaddress
import socket
from collections.abc import Awaitable, Callable, Sequence
from pathlib import Path
from typing import Final
from urllib.parse import urlsplit

from aiohttp import WSCloseCode, web
from textual_serve.server import Server, to_int

from tui.web.tab import LEAVE_LIMIT_S, Tab

HEARTBEAT_S: Final = 6.0
"""A tab is asked so often whether it is there; one that has not answered after half that time again is gone, and the
robot stops."""
PATIENCE_S: Final = LEAVE_LIMIT_S + 2
"""How long a tab waits for one that is on its way out, s."""
GRACE_S: Final = 1.0
"""How long a tab waits for one that does not look as if it went, s: of a reloaded one, the end may come late."""
TAKEN: Final = 4001
"""The code a tab is closed with where another one has the robot (RFC 6455, 7.4.2: free for use)."""
TAKEN_REASON: Final = "Another tab or browser has this robot. Close it there first, then try again here."
GONE_REASON: Final = "sayso --web ends, and the robot stops with it."

_HEADERS: Final = {
    "Content-Security-Policy": "default-src 'self' 'unsafe-inline'; img-src 'self' data:; frame-ancestors 'none'",
    "Cache-Control": "no-cache",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
"""Nothing is fetched from elsewhere, and no page of others has ours in a frame."""


IN_URL: Final = "token"
"""What the part of the printed address is called that lets a browser in."""
_STRANGER: Final = (
    "Open the address that sayso --web printed where it was started: without its token nobody is let in.\n"
)


def is_ours(host: str, names: Sequence[str]) -> bool:
    """Whether this is an address or one of these names; ``host`` as a request has it, with or without a port."""
    try:
        name = (urlsplit(f"//{host}").hostname or "").removesuffix(".")
    except ValueError:
        return False
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return name in {"localhost", *map(str.lower, names)}
    return True  # nobody can let an address lead elsewhere


def _cookie(request: web.Request) -> str:
    """Its name: a browser sends the cookies of one port to all ports of a host."""
    return f"sayso-{request.url.port}"


class ConsoleServer(Server):
    """Serves the console of these ``arguments`` (as on the command line)."""

    def __init__(self, arguments: Sequence[str], host: str, token: str) -> None:
        """``token`` is what a browser must know."""
        super().__init__("sayso", host=host, title="sayso", templates_path=Path(__file__).parent)
        self._arguments = arguments
        self._token = token
        own = socket.gethostname().lower()
        self._names = (host, own, f"{own}.local", socket.getfqdn().lower())
        self._seat = asyncio.Lock()  # held by the tab that has the robot
        self._tab: web.WebSocketResponse | None = None

    async def application(self) -> web.Application:
        """What aiohttp serves."""
        application = await self._make_app()
        application.middlewares.append(self._guard)
        return application

    @web.middleware
    async def _guard(
        self, request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]
    ) -> web.StreamResponse:
        origin = request.headers.get("Origin")
        foreign = origin is not None and origin.partition("://")[2].lower() != request.host.lower()
        if foreign or not is_ours(request.host, self._names):
            raise web.HTTPForbidden(text="sayso is not served to other sites, or under this name.\n")
        shown = request.query.get(IN_URL)
        if not self._is_token(request.cookies.get(_cookie(request), "") if shown is None else shown):
            raise web.HTTPForbidden(text=_STRANGER)
        if shown is not None and request.path == "/":  # out of the address, which is shown, and kept by the browser
            response: web.StreamResponse = web.HTTPSeeOther(str(request.rel_url.without_query_params(IN_URL)))
            response.set_cookie(_cookie(request), self._token, httponly=True, samesite="Strict")
        else:
            response = await handler(request)
        if not response.prepared:
            response.headers.update(_HEADERS)
        return response

    def _is_token(self, shown: str) -> bool:
        return hmac.compare_digest(shown.encode("utf-8", "replace"), self._token.encode())

    async def handle_websocket(self, request: web.Request) -> web.WebSocketResponse:
        """One tab, from its beginning to its end."""
        tab = web.WebSocketResponse(heartbeat=HEARTBEAT_S)
        await tab.prepare(request)
        if not await self._seated():
            await tab.close(code=TAKEN, message=TAKEN_REASON.encode())
            return tab
        self._tab = tab
        console = Tab(tab, self._arguments)
        try:
            await console.start(to_int(request.query.get("width", ""), 80), to_int(request.query.get("height", ""), 24))
            await self._process_messages(tab, console)
        finally:
            try:
                await console.stop()
            finally:
                self._tab = None
                self._seat.release()
        return tab

    async def _seated(self) -> bool:
        """Whether the robot is ours; waits for a tab that goes."""
        for patience in (GRACE_S, PATIENCE_S):
            try:
                async with asyncio.timeout(patience):
                    return await self._seat.acquire()
            except TimeoutError:
                if self._tab is None or not self._tab.closed:
                    return False
        return False

    async def on_startup(self, app: web.Application) -> None:
        """Whoever starts us says where we are."""

    async def on_shutdown(self, app: web.Application) -> None:
        """The tab is told, and its console ends with it."""
        if self._tab is not None:
            await self._tab.close(code=WSCloseCode.GOING_AWAY, message=GONE_REASON.encode())
