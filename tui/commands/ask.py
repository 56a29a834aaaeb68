"""``sayso ask``: typed requests, one after the other, and what became of them."""

from __future__ import annotations

import io
import sys
from argparse import Namespace
from collections.abc import Iterator

from engine.commands import Say, check_request
from engine.errors import ExitCode, UsageError
from engine.parts.loading import Sound
from tui.commands.headless import Headless, headless
from tui.commands.settings import load_settings, make_state_folder


def run(arguments: Namespace) -> int:
    """Perform the request, or every line of stdin. Exit code of the first one that was not done."""
    make_state_folder()
    settings = load_settings(arguments)
    with headless(settings, mode="ask", json=arguments.json, sound=Sound("none")) as engine:
        return perform_all(engine, requests(arguments.text), arguments)


def requests(text: str) -> Iterator[str | UsageError]:
    """``text``, or the non-empty lines of stdin when it is ``-``: a line that is no request is told as what is wrong
    with it, in its place. Raises :class:`UsageError` for ``text``, and where stdin cannot be read."""
    if text != "-":
        check_request(text)
        yield text
        return
    if isinstance(sys.stdin, io.TextIOWrapper):
        sys.stdin.reconfigure(encoding="utf-8", errors="surrogateescape")  # bad bytes spoil their line alone
    try:
        for number, line in enumerate(sys.stdin, 1):
            if line.strip():
                yield _request(line.strip(), number)
    except OSError as error:
        raise UsageError(f"stdin cannot be read: {error.strerror or error}.") from error


def _request(line: str, number: int) -> str | UsageError:
    try:
        check_request(line)
    except UsageError as error:
        return UsageError(f"Line {number}: {error.message}", hint=error.hint)
    return line


def perform_all(engine: Headless, texts: Iterator[str | UsageError], arguments: Namespace) -> int:
    code = int(ExitCode.DONE)
    for text in texts:
        if isinstance(text, UsageError):
            engine.refuse(text)
            code = code or int(text.exit_code)
            continue
        result = engine.perform(Say(text), arguments.timeout)
        if engine.lost is not None:
            return int(engine.lost)
        engine.report(result)
        code = code or result.exit_code
    return code
