"""How requests travel: to one address, and no more comes back than can be an answer.

No redirect is followed, and neither proxies nor credentials are taken from the environment. Of the headers that a
client library would add, those stay that HTTP needs; the key is put in when a request is sent. Slow to import: only
who asks a platform needs it.
"""

from __future__ import annotations

import functools
import ssl
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Final

import certifi
import httpx2
from pydantic import SecretStr

MAX_BYTES: Final = 8 << 20
"""Longest body that is read; what is longer is no answer to a question of ours."""
KEEP_S: Final = 30.0
"""A connection that nobody uses is closed after this."""
_NEEDED: Final = frozenset(
    ("host", "content-type", "content-length", "transfer-encoding", "accept", "connection", "user-agent")
)


class Overlong(httpx2.TransportError):
    """More came than can be an answer."""


def make_client(key: SecretStr, uds: Path | None = None) -> httpx2.AsyncClient:
    """A client that sends ``key`` where it is not empty; with ``uds``, everything goes through that UNIX socket."""
    limits = httpx2.Limits(max_keepalive_connections=1, keepalive_expiry=KEEP_S)
    inner = httpx2.AsyncHTTPTransport(
        verify=_trusted(), limits=limits, trust_env=False, uds=None if uds is None else str(uds)
    )
    return httpx2.AsyncClient(
        transport=_Bounded(inner), timeout=None, trust_env=False, follow_redirects=False, auth=_Signed(key)
    )


class _Signed(httpx2.Auth):
    """Takes out what nobody needs to know, and puts the key in at the last moment."""

    def __init__(self, key: SecretStr) -> None:
        self._key = key

    async def async_auth_flow(self, request: httpx2.Request) -> AsyncIterator[httpx2.Request]:  # type: ignore[override]
        for name in [name for name in request.headers if name.lower() not in _NEEDED]:
            del request.headers[name]
        request.headers["Accept-Encoding"] = "identity"
        request.headers["User-Agent"] = "sayso"
        if self._key.get_secret_value():
            request.headers["Authorization"] = f"Bearer {self._key.get_secret_value()}"
        yield request


class _Bounded(httpx2.AsyncBaseTransport):
    """Lets no more than ``MAX_BYTES`` of a response pass."""

    def __init__(self, inner: httpx2.AsyncBaseTransport) -> None:
        self._inner = inner

    async def handle_async_request(self, request: httpx2.Request) -> httpx2.Response:
        response = await self._inner.handle_async_request(request)
        response.headers.pop("Content-Encoding", None)  # none was asked for, and little can unfold to very much
        assert isinstance(response.stream, httpx2.AsyncByteStream)
        response.stream = _Counted(response.stream)
        return response

    async def aclose(self) -> None:
        await self._inner.aclose()


class _Counted(httpx2.AsyncByteStream):
    def __init__(self, inner: httpx2.AsyncByteStream) -> None:
        self._inner = inner

    async def __aiter__(self) -> AsyncIterator[bytes]:
        count = 0
        async for chunk in self._inner:
            count += len(chunk)
            if count > MAX_BYTES:
                raise Overlong(f"it is longer than {MAX_BYTES >> 20} MB")
            yield chunk

    async def aclose(self) -> None:
        await self._inner.aclose()


@functools.cache
def _trusted() -> ssl.SSLContext:
    """The certificate authorities of the system, and those that come with the HTTP library."""
    context = ssl.create_default_context()
    context.load_verify_locations(certifi.where())
    return context
