"""``sayso ask``: typed requests, one after the other, and what became of them."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Iterator

from engine.commands import Say, check_request
from engine.errors import ExitCode, UsageError
from engine.parts.loading import Sound
from tui.commands.headless import Headless, headless
from tui.commands.settings import load_settings


def run(arguments: Namespace) -> int:
    """Perform the request, or every line of stdin. Exit code of the first one that was not done."""
    settings = load_settings(arguments)
    with headless(settings, mode="ask", json=arguments.json, sound=Sound("none")) as engine:
        return perform_all(engine, requests(arguments.text), arguments)


def requests(text: str) -> Iterator[str]:
    """``text``, or the non-empty lines of stdin when it is ``-``. Raises :class:`UsageError`."""
    if text != "-":
        check_request(text)
        yield text
        return
    try:
        for line in sys.stdin:
            if line.strip():
                check_request(line.strip())
                yield line.strip()
    except UnicodeDecodeError as error:
        raise UsageError(f"stdin is not UTF-8 text: {error}.") from error


def perform_all(engine: Headless, texts: Iterator[str], arguments: Namespace) -> int:
    code = int(ExitCode.DONE)
    for text in texts:
        result = engine.perform(Say(text), arguments.timeout)
        if engine.lost is not None:
            return int(engine.lost)
        engine.report(result)
        code = code or result.exit_code
    return code
