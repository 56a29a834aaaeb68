"""Secrets, and text without them: what a fault says can be shown to anybody, and be reported.

The values of local variables are left out of tracebacks, as they may be anything. What an error says about itself may
hold a key as well: every secret of the settings and of the environment is masked, and what looks like one.
"""

from __future__ import annotations

import contextlib
import logging
import os
import re
import sys
import traceback
from collections.abc import Iterable, Iterator, Mapping
from typing import Final
from urllib.parse import unquote, urlsplit

from pydantic import BaseModel, SecretStr

MASK: Final = "********"
_NAMES: Final = re.compile(r"KEY|TOKEN|SECRET|PASSW|CREDENTIAL|COOKIE", re.IGNORECASE)
_NAMED_IN_URL: Final = re.compile(
    rf"{_NAMES.pattern}|AUTH|PWD|SESSION|BEARER|JWT|^SIG$|SIGNATURE|^(?:X-)?(?:CODE|PASS|PIN|AK|SK)$", re.IGNORECASE
)
_USER: Final = re.compile(r"(?<=://)[^/?#\s]*(?=@)")
_PAIR: Final = re.compile(r"([?&;#])([^=&;#]*)=([^&;#]*)")
LINE: Final = 1000
"""Longest line of a traceback, characters."""
_SHORTEST: Final = 6
"""Characters; what is shorter would mask words that are none."""
_LOOKS: Final = (
    re.compile(r"(?<=Bearer )\S+", re.IGNORECASE),
    re.compile(r"\b(?:sk|app|ghp|hf)[-_][A-Za-z0-9_-]{16,}"),
    re.compile(r"(?<=://)[^/\s:@]+:[^/\s@]+(?=@)"),
)

_known: set[str] = set()
"""Secrets of all settings that were read in this process."""


def secrets_of_url(url: str) -> Iterator[str]:
    """What opens a door in an address: the password before the host (or the only thing there, which is a token then),
    and values that are named like a secret; as written, and as a program decodes it."""
    try:
        parts = urlsplit(url)
    except ValueError:  # it is none
        return
    if not parts.scheme or not parts.netloc:
        return
    user, colon, password = parts.netloc.rpartition("@")[0].partition(":")
    pairs = _PAIR.findall(f"?{parts.query}#{parts.fragment}")
    found = (password if colon else user, *(value for _, name, value in pairs if _NAMED_IN_URL.search(unquote(name))))
    for secret in found:
        yield from filter(None, dict.fromkeys((secret, unquote(secret))))


def without_secrets(url: str) -> str:
    """The address with all of that masked; a text that is no address stays as it is."""
    if next(secrets_of_url(url), None) is None:
        return url
    shown = _USER.sub(MASK, url, count=1)
    return _PAIR.sub(lambda m: f"{m[1]}{m[2]}={MASK}" if _NAMED_IN_URL.search(unquote(m[2])) else m[0], shown)


def secrets_in(found: object) -> Iterator[str]:
    """Every secret of some settings, wherever it stands."""
    match found:
        case SecretStr():
            yield found.get_secret_value()
        case str():
            yield from secrets_of_url(found)
        case BaseModel():
            yield from (secret for _, value in found for secret in secrets_in(value))
        case Mapping():
            yield from (secret for value in found.values() for secret in secrets_in(value))
        case list() | tuple():
            yield from (secret for value in found for secret in secrets_in(value))


def masked(text: str, secrets: Iterable[str], environ: Mapping[str, str]) -> str:
    """The text without those secrets, and without what variables hold that are named like one."""
    held = [value for name, value in environ.items() if _NAMES.search(name)]
    known = {part for secret in (*secrets, *held) for part in (secret, secret.strip(), repr(secret)[1:-1])}
    for secret in sorted((part for part in known if len(part) >= _SHORTEST), key=len, reverse=True):
        text = text.replace(secret, MASK)
    for look in _LOOKS:
        text = look.sub(MASK, text)
    return text


def told(error: BaseException, secrets: Iterable[str], environ: Mapping[str, str] | None = None) -> str:
    """The traceback as it can be shown to anybody; what an error says of itself is cut off where it is very long."""
    lines = traceback.TracebackException.from_exception(error, capture_locals=False).format()
    return shortened(masked("".join(lines), secrets, os.environ if environ is None else environ))


def shortened(text: str) -> str:
    """The text with no line longer than anybody reads."""
    return "\n".join(line if len(line) <= LINE else f"{line[:LINE]}…" for line in text.split("\n"))


def remember(settings: object) -> None:
    """From now on this process knows the secrets in these settings, and shows them in no traceback: not in those of
    :func:`show_fault`, nor in what a library reports where nobody has set up logging, as asyncio does."""
    _known.update(secrets_in(settings))
    if logging.lastResort is not None:
        logging.lastResort.setFormatter(_Masked())


def show_fault(error: BaseException | None) -> None:
    """The traceback, on stderr. For ``sys.excepthook`` and ``threading.excepthook``."""
    if error is None or isinstance(error, SystemExit):
        return
    with contextlib.suppress(OSError, ValueError, AttributeError):  # nobody reads stderr
        sys.stderr.write(told(error, _known))
        sys.stderr.flush()


class _Masked(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        return shortened(masked(super().format(record), _known, os.environ))
