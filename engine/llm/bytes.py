"""A platform that answers with bytes, such as sound, instead of words.

It is asked as one is who answers with words (``engine.llm.service``): the same key, kept as secret, the same patience,
and the same names for whatever goes wrong.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, Mapping
from contextlib import AsyncExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from config.schema import Platform
from engine.llm.service import Failure, Service

if TYPE_CHECKING:
    import httpx2


@dataclass(frozen=True, slots=True)
class Begun:
    """An answer that has begun to come."""

    kind: str  # its media type
    pieces: AsyncGenerator[bytes]


class ByteService:
    """One platform. Belongs to the loop in which it is asked first."""

    def __init__(self, name: str, platform: Platform, kind: str, remedy: str) -> None:
        """``kind`` is what it should be, in words, and ``remedy`` what to look at when it refuses."""
        self.name = name
        self._service = Service(name, platform, kind, remedy)
        self._timeout_s = platform.timeout_s

    async def ask(self, path: str, body: Mapping[str, Any]) -> Begun:
        """POST ``body`` as JSON; the answer, once it begins. Whoever has enough closes its pieces. Both raise
        ``ChatError``."""
        return await self._service.ask(lambda: self._attempt(path, body))

    async def close(self) -> None:
        await self._service.close()

    async def warm(self) -> None:
        """Get ready, so that the first question does not wait for it."""
        await self._service.client()

    async def _attempt(self, path: str, body: Mapping[str, Any]) -> Begun | Failure:
        client = await self._service.client()
        import httpx2

        async with AsyncExitStack() as closing:
            try:
                asking = client.stream("POST", f"{self._service.base_url}{path}", json=dict(body))
                response = await closing.enter_async_context(asking)
                if response.status_code != httpx2.codes.OK:
                    return self._service.refused(response.status_code, await response.aread(), response.headers)
            except (httpx2.HTTPError, httpx2.InvalidURL, OSError) as error:
                return self._service.broken(error)
            kind = response.headers.get("content-type", "").partition(";")[0].strip().lower()
            return Begun(kind, self._pieces(response, closing.pop_all()))

    async def _pieces(self, response: httpx2.Response, open_: AsyncExitStack) -> AsyncGenerator[bytes]:
        import httpx2

        failure: Failure | None = None
        async with open_:
            coming = aiter(response.aiter_bytes())
            while True:
                try:
                    async with asyncio.timeout(self._timeout_s):
                        piece = await anext(coming)
                except StopAsyncIteration:
                    break
                except (httpx2.HTTPError, OSError, TimeoutError) as error:
                    failure = self._service.broken(error, begun=True)
                    break
                except Exception as error:  # noqa: BLE001 - whatever else the service brings about is its failure
                    failure = Failure(self._service.unreadable(f"it breaks off ({type(error).__name__})"))
                    break
                yield piece
        if failure is not None:
            raise failure.error  # here, where no exception is being handled whose request has the key in it
