"""How somebody begins who goes on from what was asked for before: "and then …", "afterwards …", 然后…."""

from __future__ import annotations

import re
from typing import Final

from engine.planner.phrases.stopping import is_stop

_JOINT: Final = re.compile(
    r"(?:\W*(?:(?:and|then|also|afterwards|after (?:that|this|it))\b|然后|接着|接下来|之后|并且|再|还有))+\W*",
    re.IGNORECASE,
)


def goes_on(text: str) -> bool:
    """Whether a request begins as one that belongs to another one."""
    return _JOINT.match(text) is not None


def comes_after(text: str) -> bool:
    """Whether a request is to be done after what runs: it begins so, and what follows is no stop, which waits for
    nothing."""
    joint = _JOINT.match(text)
    return joint is not None and joint.end() < len(text) and not is_stop(text[joint.end() :])
