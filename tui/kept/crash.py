"""A fault of the console, written down so that it can be reported: what happened where, and nobody's secrets.

The values of local variables are left out, as they may be anything. What an error says about itself may hold a key
as well: every secret of the settings and of the environment is masked, and what looks like one.
"""

from __future__ import annotations

import os
import platform
import re
import traceback
from collections.abc import Iterable, Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from pydantic import BaseModel, SecretStr

from engine import __version__

MASK: Final = "********"
_NAMES: Final = re.compile(r"KEY|TOKEN|SECRET|PASSW|CREDENTIAL|COOKIE", re.IGNORECASE)
_SHORTEST: Final = 6
"""Characters; what is shorter would mask words that are none."""
_LOOKS: Final = (
    re.compile(r"(?<=Bearer )\S+", re.IGNORECASE),
    re.compile(r"\b(?:sk|app|ghp|hf)[-_][A-Za-z0-9_-]{16,}"),
    re.compile(r"(?<=://)[^/\s:@]+:[^/\s@]+(?=@)"),
)


def secrets_in(found: object) -> Iterator[str]:
    """Every secret of some settings, wherever it stands."""
    match found:
        case SecretStr():
            yield found.get_secret_value()
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
    """The traceback as it can be shown to anybody."""
    lines = traceback.TracebackException.from_exception(error, capture_locals=False).format()
    return masked("".join(lines), secrets, os.environ if environ is None else environ)


def write(folder: Path, text: str, now: datetime | None = None) -> Path:
    """Into a new file of this folder, for its owner alone. Raises ``OSError``."""
    when = now or datetime.now(UTC)
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    path = folder / f"crash-{when:%Y%m%dT%H%M%SZ}-{os.getpid()}.txt"
    head = f"sayso {__version__}, Python {platform.python_version()}, {platform.system()}, {when:%Y-%m-%d %H:%M:%S} UTC"
    number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)
    with os.fdopen(number, "w", encoding="utf-8", errors="backslashreplace") as file:
        file.write(f"{head}\n\n{text}")
    return path
