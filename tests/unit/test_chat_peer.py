"""An OpenAI-compatible service that is somebody else's work: llama.cpp's own server, with a real model in it."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest

from config import load
from config.schema import Platform
from engine.llm.chat import Ask, Message, Reply
from engine.llm.llama import LlamaProcess, Shape
from engine.llm.openai import OpenAIChat
from engine.parts.loading import gguf_of

GGUF = gguf_of(load(environ={}), "local")
QUESTION = (Message("system", "Answer briefly."), Message("user", "Which colours does the flag of France have?"))
COLOURS = {
    "type": "object",
    "properties": {"colours": {"type": "array", "items": {"enum": ["red", "white", "blue", "green"]}, "maxItems": 4}},
    "required": ["colours"],
    "additionalProperties": False,
}


@pytest.mark.model
@pytest.mark.skipif(not GGUF.is_file(), reason="the model is not here: sayso models pull")
def test_a_real_service_streams_counts_and_holds_to_a_form(tmp_path: Path) -> None:
    async def test(chat: Callable[..., Awaitable[Reply]]) -> None:
        pieces: list[str] = []
        free = await chat(Ask(QUESTION, max_tokens=24), pieces.append)
        assert len(pieces) > 3
        assert "".join(pieces).strip() == free.text
        assert free.prompt_tokens > free.cached_tokens
        assert 0 < free.reply_tokens <= 24

        formed = await chat(Ask(QUESTION, schema=COLOURS, max_tokens=64))
        assert set(json.loads(formed.text)["colours"]) <= {"red", "white", "blue", "green"}
        assert formed.cached_tokens > 0
        assert not formed.cut_off

        held = await chat(Ask(QUESTION, schema=COLOURS, grammar='root ::= "certainly" | "hardly"'))
        assert held.text in ("certainly", "hardly")

        cut = await chat(Ask((Message("user", "Count from one to a hundred in words."),), max_tokens=5))
        assert cut.cut_off
        assert cut.reply_tokens == 5

    async def run() -> None:
        process = await LlamaProcess.start(Shape(GGUF, tmp_path, threads=2, slots=1, context=1024), "")
        try:
            platform = Platform(kind="openai", model="any", timeout_s=60)
            chat = OpenAIChat("peer", platform, uds=process.socket, takes_grammar=True, extra={"cache_prompt": True})
            await test(chat.reply)
            await chat.close()
        finally:
            process.kill()

    asyncio.run(run())
