"""``sayso --web``: the console in a browser, by textual-serve.

It listens on loopback unless ``--web-host`` says otherwise. stdout is the address for a browser, with a token in it:
only a browser that has it can drive the robot. Runs until it is ended; exit code 0 by SIGTERM, SIGHUP or
SIGQUIT, 130 by Ctrl-C.
"""

from __future__ import annotations

import asyncio
import contextlib
import ipaddress
import logging
import secrets
import socket
import sys
from argparse import Namespace
from importlib.util import find_spec
from typing import Final

from pydantic import SecretStr

from config.secrets import remember
from engine.errors import DeviceError, ExitCode, ModelError
from tui.commands.settings import load_settings, make_state_folder
from tui.output import ENDING, data, say

INSTALL: Final = "pip install 'sayso[web]'"


def run(arguments: Namespace) -> int:
    """Serve until told to end. Exit code 3 where nothing can be served."""
    make_state_folder()
    load_settings(arguments)  # what is wrong with them is told here, and not in a tab
    if find_spec("textual_serve") is None:
        raise ModelError("The package textual-serve is not installed.", hint=f"Install it: {INSTALL}.")
    listener = listening(arguments.web_host, arguments.web_port)
    url = address(listener, arguments.web_host)
    if not ipaddress.ip_address(listener.getsockname()[0].partition("%")[0]).is_loopback:
        say(f"sayso: warning: {url} is open to the network, and what is sent there, the token too, is not encrypted.")
    asyncio.run(_serve(listener, url, arguments))
    return int(ExitCode.DONE)


def listening(host: str, port: int) -> socket.socket:
    """A socket that listens there; port 0 is any that is free. Raises ``DeviceError``."""
    where = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
    try:
        family, _, _, _, found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        return socket.create_server(found[:2], family=family)
    except PermissionError as error:
        raise DeviceError(
            f"The console cannot be served at {where}: {error.strerror}.", hint="Choose a port from 1024: --web-port."
        ) from error
    except OSError as error:
        hint = "Another program, perhaps another sayso --web, has it. End that, or choose another one: --web-port 0."
        in_use = "address already in use" in str(error).lower()
        raise DeviceError(
            f"The console cannot be served at {where}: {error.strerror}.",
            hint=hint if in_use else "Name this machine, or one of its addresses: --web-host.",
        ) from error


def address(listener: socket.socket, host: str) -> str:
    """Where a browser finds it. For all of a machine's addresses, by its name."""
    own, port = listener.getsockname()[:2]
    if ipaddress.ip_address(own.partition("%")[0]).is_unspecified:
        host = socket.gethostname()
    return f"http://[{host}]:{port}/" if ":" in host else f"http://{host}:{port}/"


def console_arguments(arguments: Namespace) -> list[str]:
    """What the console of a tab is started with: the settings of ours."""
    given = [f"--config={file.absolute()}" for file in arguments.config or ()]
    given += [f"--set={setting}" for setting in arguments.set or ()]
    given += [
        f"--{name}={value}" for name in ("scene", "speed", "model", "theme") if (value := getattr(arguments, name))
    ]
    return [*given, "--demo"] if arguments.demo else given


async def _serve(listener: socket.socket, url: str, arguments: Namespace) -> None:
    from aiohttp import web

    from tui.web.server import IN_URL, ConsoleServer
    from tui.web.tab import LEAVE_LIMIT_S

    ended = asyncio.Event()
    for number in ENDING:
        asyncio.get_running_loop().add_signal_handler(number, ended.set)
    token = secrets.token_urlsafe(32)
    remember(SecretStr(token))
    logging.getLogger("aiohttp.server").addFilter(_of_ours)
    server = ConsoleServer(console_arguments(arguments), arguments.web_host, token)
    runner = web.AppRunner(await server.application(), access_log=None, shutdown_timeout=LEAVE_LIMIT_S + 2)
    await runner.setup()
    try:
        await web.SockSite(runner, listener).start()
        data(f"{url}?{IN_URL}={token}")
        say("sayso: open that in a browser; Ctrl-C ends it.")
        with contextlib.redirect_stdout(sys.stderr):  # textual-serve prints the last words of a console
            await ended.wait()
    finally:
        await runner.cleanup()


def _of_ours(record: logging.LogRecord) -> bool:
    """Whether a report of aiohttp's is about a fault of ours. A request that cannot be read, because its address is too
    long for instance, is answered with a status of 4xx, and that is all."""
    from aiohttp.http_exceptions import HttpProcessingError

    return not (record.exc_info and isinstance(record.exc_info[1], HttpProcessingError))
