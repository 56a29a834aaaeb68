"""``sayso wyoming``: this machine's recogniser and voice for other programs, such as Home Assistant; no robot runs.

It listens on loopback unless ``--uri`` says otherwise: the protocol asks nobody who they are. Runs until it is ended;
exit code 0 by SIGTERM, SIGHUP or SIGQUIT, 130 by Ctrl-C.
"""

from __future__ import annotations

import asyncio
from argparse import Namespace
from contextlib import AsyncExitStack, closing

from config.schema import Settings
from engine import wyoming
from engine.asr.recogniser import Recogniser
from engine.errors import ExitCode, SaysoError, UsageError
from engine.parts.loading import languages_said, make_isolated_recogniser, make_synthesiser
from engine.serving import Server, is_private
from engine.tts.synthesis import Synthesiser
from engine.visit import Offer
from tui.commands.settings import load_settings
from tui.output import ENDING, json_line, say


def run(arguments: Namespace) -> int:
    """Serve until told to end. Exit code 3 where there is nothing to serve."""
    settings = load_settings(arguments)
    private = is_private(arguments.uri)
    wyoming.require()
    for name, server in (("asr", settings.asr.server), ("voice", settings.voice.server)):
        if server == arguments.uri and getattr(settings, name).backend == "wyoming":
            raise UsageError(f"{arguments.uri} is {name}.server, so this would ask itself.", hint="Choose another one.")
    if not private:
        say(f"sayso: warning: whoever reaches {arguments.uri} can use this. There is no password: mind your firewall.")
    asyncio.run(_serve(settings, arguments.uri, only=arguments.only, json=arguments.json))
    return int(ExitCode.DONE)


async def _serve(settings: Settings, uri: str, *, only: str | None, json: bool) -> None:
    ended = asyncio.Event()
    for number in ENDING:
        asyncio.get_running_loop().add_signal_handler(number, ended.set)
    async with AsyncExitStack() as opened:
        recogniser = await _recogniser(settings, opened, needed=only == "asr") if only != "tts" else None
        voice = await _voice(settings, opened, needed=recogniser is None) if only != "asr" else None
        hears = settings.asr.languages if settings.asr.language == "auto" else (settings.asr.language,)
        offer = Offer(recogniser, voice, hears, languages_said(settings))
        server = await opened.enter_async_context(Server(offer, uri, lambda words: say(f"sayso: {words}")))
        asr, tts = recogniser.name if recogniser else None, voice.name if voice else None
        if json:
            json_line({"uri": server.address, "asr": asr, "tts": tts})
        say(f"sayso: {' and '.join(filter(None, (asr, tts)))} at {server.address}; Ctrl-C ends it.")
        await ended.wait()


async def _recogniser(settings: Settings, opened: AsyncExitStack, *, needed: bool) -> Recogniser | None:
    """Loaded, and closed in the end. One that is missing is told where it is not ``needed``, else raised."""
    try:
        made = make_isolated_recogniser(settings)
        opened.enter_context(closing(made))
        await asyncio.to_thread(made.load)
    except SaysoError as error:
        if needed:
            raise
        say(f"sayso: no recogniser: {error}")
        return None
    return made


async def _voice(settings: Settings, opened: AsyncExitStack, *, needed: bool) -> Synthesiser | None:
    """As above."""
    try:
        made = make_synthesiser(settings, lambda words: say(f"sayso: {words}"))
        opened.push_async_callback(made.close)
        await made.load()
    except SaysoError as error:
        if needed:
            raise
        say(f"sayso: no voice: {error}")
        return None
    return made
