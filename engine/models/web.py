"""A file from a URL, resumed from the bytes that are already there.

Only https, and plain http to this machine, also behind redirects. What the bytes are worth is for the caller's hash
to say.
"""

from __future__ import annotations

import http.client
import ipaddress
import urllib.error
import urllib.parse
import urllib.request
from collections.abc import Callable
from http import HTTPStatus
from pathlib import Path
from typing import IO

from engine.errors import ModelError
from engine.models.storage import storing

CHUNK = 1 << 18  # bytes
TIMEOUT_S = 30.0
"""Longest silence of the server."""
_OTHER_FILE = "The server has another file than this version of sayso was made for; update sayso."


def download(url: str, target: Path, size: int, done: Callable[[int], None]) -> None:
    """Make ``target`` the ``size`` bytes of ``url``; ``done`` hears how many there are, and cancels by raising.

    A connection that breaks is taken up again as long as every attempt brings bytes. Raises ModelError, and leaves
    what was received for the next time; StorageError when ``target`` cannot be written.
    """
    _check(url)
    have = target.stat().st_size if target.exists() else 0
    while have != size:
        before = have if have < size else 0
        have = _attempt(url, target, before, size, done)
        if have <= before:
            message = f"{url} cannot be fetched: it ended after {have} of {size} bytes."
            raise ModelError(message, hint="Check the network, then run it again: what was fetched is kept.")


def _attempt(url: str, target: Path, have: int, size: int, done: Callable[[int], None]) -> int:
    """One connection; returns how many bytes ``target`` has then."""
    opener = urllib.request.build_opener(_CheckedRedirects())
    request = urllib.request.Request(url, headers={"Range": f"bytes={have}-"} if have else {})  # noqa: S310  # checked
    try:
        response = opener.open(request, timeout=TIMEOUT_S)
    except urllib.error.HTTPError as error:
        if error.code == HTTPStatus.REQUESTED_RANGE_NOT_SATISFIABLE:
            with storing(target):
                target.unlink()
            raise ModelError(f"{url} has fewer bytes than the {size} expected.", hint=_OTHER_FILE) from error
        message = f"{url} cannot be fetched: the server answers {error.code} {error.reason}."
        raise ModelError(message, hint="Check the address, or try again later.") from error
    except (OSError, http.client.HTTPException) as error:
        hint = "Check the network and proxy, then run it again: what was fetched is kept."
        raise ModelError(f"{url} cannot be fetched: {error}.", hint=hint) from error
    with response:
        if have and not response.headers.get("Content-Range", "").startswith(f"bytes {have}-"):
            have = 0  # the server cannot resume and sends everything
        with storing(target), target.open("ab" if have else "wb") as file:
            while chunk := _read(response):
                have += len(chunk)
                if have > size:
                    file.truncate(0)
                    raise ModelError(f"{url} has more bytes than the {size} expected.", hint=_OTHER_FILE)
                file.write(chunk)
                done(have)
    return have


def _read(response: IO[bytes]) -> bytes:
    """A broken connection ends the body like its end does; the caller counts."""
    try:
        return response.read(CHUNK)
    except (OSError, http.client.HTTPException):
        return b""


class _CheckedRedirects(urllib.request.HTTPRedirectHandler):
    def redirect_request(
        self,
        req: urllib.request.Request,
        fp: IO[bytes],
        code: int,
        msg: str,
        headers: http.client.HTTPMessage,
        newurl: str,
    ) -> urllib.request.Request | None:
        _check(newurl)
        return super().redirect_request(req, fp, code, msg, headers, newurl)


def _check(url: str) -> None:
    parts = urllib.parse.urlsplit(url)
    host = parts.hostname or ""
    try:
        local = host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        local = False
    if parts.scheme != "https" and not (parts.scheme == "http" and local):
        raise ModelError(f"{url} is not an https address.", hint="Models come over https, or from this machine.")
