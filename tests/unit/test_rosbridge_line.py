"""What a bridge says that is no JSON, or hardly any."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator
from typing import Any, cast

from engine.ros.rosbridge.line import Line


class Socket:
    """Says these texts."""

    def __init__(self, *texts: str) -> None:
        self._texts = texts

    async def __aiter__(self) -> AsyncIterator[str]:
        for text in self._texts:
            yield text


def heard(*texts: str) -> list[dict[str, Any]]:
    async def hear() -> list[dict[str, Any]]:
        return [order async for order in Line(cast("Any", Socket(*texts))).heard()]

    return asyncio.run(hear())


def test_numbers_that_are_none_are_read_and_what_nobody_can_read_is_left_out() -> None:
    deep = '{"a":' * 100_000 + "1" + "}" * 100_000
    found = heard('{"msg": [NaN, Infinity]}', deep, "[1]", "{", '{"op": "publish"}')
    assert [list(order) for order in found] == [["msg"], ["op"]]
    assert math.isnan(found[0]["msg"][0])
    assert found[0]["msg"][1] == math.inf
