"""JSON that models and services send.

Python's own reader lets through what breaks things much later: numbers that no machine number holds, ``NaN``, and half
a character (a lone surrogate such as ``\\ud800``), which can be neither logged nor sent on. Here they are no JSON.
"""

from __future__ import annotations

import json
import math
from typing import Any, Final, NoReturn

_BITS: Final = 63
"""Of a whole number, without its sign; a greater one is read as a float."""


def read_json(text: str | bytes) -> Any:
    """What ``text`` says. Raises ``ValueError``, also for JSON that is nested too deeply."""
    return _read(text, whole=True)


def read_first_json(text: str) -> Any:
    """What the JSON at the beginning of ``text`` says, whatever follows. Raises ``ValueError``."""
    return _read(text, whole=False)


def is_text(text: str) -> bool:
    """Whether ``text`` holds whole characters only, and so can be written as UTF-8."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _read(text: str | bytes, *, whole: bool) -> Any:
    options: dict[str, Any] = {"parse_int": _integer, "parse_float": _number, "parse_constant": _refuse}
    try:
        if whole:
            found = json.loads(text, **options)
        else:
            assert isinstance(text, str)
            found, _ = json.JSONDecoder(**options).raw_decode(text)
        json.dumps(found, ensure_ascii=False).encode()
    except RecursionError as error:
        raise ValueError("it is nested too deeply") from error
    return found


def _integer(digits: str) -> int | float:
    number = _number(digits)
    return int(digits) if abs(number) < 1 << _BITS else number


def _number(digits: str) -> float:
    number = float(digits)
    if not math.isfinite(number):
        raise ValueError("a number in it is too large")
    return number


def _refuse(name: str) -> NoReturn:
    raise ValueError(f"{name} is no number")
