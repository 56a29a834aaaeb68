"""A platform that is sent a recording, and answers in JSON.

It is asked as one is who answers with words (``engine.llm.service``): the same key, kept as secret, the same patience,
and the same names for whatever goes wrong.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from config.schema import Platform
from engine.llm.service import Failure, Service
from engine.strict_json import read_json


class RecordingService:
    """One platform. Belongs to the loop in which it is asked; another one may ask once it is closed."""

    def __init__(self, name: str, platform: Platform, kind: str, remedy: str) -> None:
        """``kind`` is what it should be, in words, and ``remedy`` what to look at when it refuses."""
        self.name = name
        self._service = Service(name, platform, kind, remedy)

    async def send(self, path: str, wav: bytes, fields: Mapping[str, str]) -> Any:
        """POST a WAV file as ``file`` of a form; the answer, read as JSON. Raises ``ChatError``."""
        return await self._service.ask(lambda: self._attempt(path, wav, fields))

    async def close(self) -> None:
        await self._service.close()

    async def _attempt(self, path: str, wav: bytes, fields: Mapping[str, str]) -> Any | Failure:
        client = await self._service.client()
        import httpx2

        try:
            response = await client.post(
                f"{self._service.base_url}{path}", data=dict(fields), files={"file": ("speech.wav", wav, "audio/wav")}
            )
        except (httpx2.HTTPError, httpx2.InvalidURL, OSError) as error:
            return self._service.broken(error)
        if response.status_code != httpx2.codes.OK:
            return self._service.refused(response.status_code, response.content, response.headers)
        try:
            return read_json(self._service.blotted(response.content.decode("utf-8", "replace")))
        except ValueError:
            return Failure(self._service.unreadable("it is no JSON"))
