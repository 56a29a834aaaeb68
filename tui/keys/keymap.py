"""The keys that somebody chose in place of the usual ones, and what is wrong with that choice.

A key that cannot be had is reported and the action keeps its own: no mistake in a file leaves a robot without the key
that stops it. Knows no Textual, so that ``sayso config check`` can say the same.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from config.nearest import nearest
from tui.keys.keys import (
    DOCTOR_KEYS,
    EDITING,
    EVERYWHERE,
    HAND_KEYS,
    KEYS,
    LOG_KEYS,
    MAP_KEYS,
    PUNCTUATION,
    QUEUE_KEYS,
    SETTING_KEYS,
    TURN_KEYS,
    Key,
)
from tui.words import strings

GROUPS: Final[tuple[tuple[Key, ...], ...]] = (
    KEYS,
    MAP_KEYS,
    QUEUE_KEYS,
    LOG_KEYS,
    TURN_KEYS,
    DOCTOR_KEYS,
    HAND_KEYS,
    SETTING_KEYS,
)
"""Those of the console, and those that go before them while the map, or a page, has the keyboard."""

_SPELLINGS: Final = {
    **PUNCTUATION, "esc": "escape", "return": "enter", "page up": "pageup", "page down": "pagedown", "del": "delete",
}  # fmt: skip
_SPECIAL: Final = EDITING | {"escape", "insert", "pageup", "pagedown"}
_SAME: Final = {"ctrl+i": "tab", "ctrl+m": "enter", "ctrl+h": "backspace"}
"""What a terminal sends the same bytes for."""
_PORTABLE: Final = re.compile(r"\w|ctrl\+[a-y]|f(?:[1-9]|1[0-2])")


@dataclass(frozen=True, slots=True)
class Mistake:
    """Something wrong with the key of one action; a sentence that says what to do."""

    action: str
    message: str


@dataclass(frozen=True, slots=True)
class Keymap:
    """The keys in use by action id, several separated by commas, and why some are not those that were chosen."""

    keys: Mapping[str, str]
    mistakes: tuple[Mistake, ...] = ()


def keymap(chosen: Mapping[str, str], groups: Sequence[Sequence[Key]] = GROUPS) -> Keymap:
    """The usual keys, with those that were chosen in their place wherever that is possible."""
    actions = {key.id: key for group in groups for key in group}
    usual = {name: key.key for name, key in actions.items()}
    mistakes: list[Mistake] = []
    wanted: dict[str, str] = {}
    for action, written in chosen.items():
        keys = tuple(map(_named, _split(written)))
        if why := _unknown(action, tuple(actions)) or _unfit(keys, actions[action]):
            mistakes.append(Mistake(action, why))
        else:
            wanted[action] = ",".join(keys)
    while (clash := _clash(usual | wanted, tuple(wanted), groups)) is not None:
        action, key, other = clash
        mistakes.append(Mistake(action, strings.KEY_TAKEN.format(key=_shown(key), other=other)))
        del wanted[action]
    return Keymap(usual | wanted, tuple(mistakes))


def _unknown(action: str, known: Sequence[str]) -> str:
    if action in known:
        return ""
    near = nearest(action, known)
    return strings.NO_ACTION.format(strings.DID_YOU_MEAN.format(near) if near else ", ".join(known))


def _unfit(keys: Sequence[str], action: Key) -> str:
    """Why these keys are none for this action; empty when they are."""
    if not keys:
        return strings.NO_KEY
    reasons = [_reason(key) for key in keys]
    if all(reasons):  # one that arrives everywhere is enough
        return reasons[0]
    if action.id in EVERYWHERE:
        for key in keys:
            if key in EDITING or re.fullmatch(r"\w", key) or key in PUNCTUATION.values():
                return strings.KEY_IS_TYPED.format(key=_shown(key))
    return ""


def _reason(key: str) -> str:
    """Why a key does not arrive from every terminal; empty when it does."""
    if key in _SAME:
        return strings.KEY_IS_ANOTHER.format(key=_shown(key), other=_shown(_SAME[key]))
    if key in _SPECIAL or key in PUNCTUATION.values() or _PORTABLE.fullmatch(key):
        return ""
    return (strings.KEY_NOT_PORTABLE if "+" in key else strings.KEY_UNKNOWN).format(key=_shown(key))


def _clash(
    keys: Mapping[str, str], wanted: Sequence[str], groups: Sequence[Sequence[Key]]
) -> tuple[str, str, str] | None:
    """An action whose chosen key is that of another one, the key, and the other. What was chosen last gives way."""
    for action in reversed(wanted):
        rivals = [rival.id for rival in _rivals(action, groups)]
        for key in keys[action].split(","):
            for rival in rivals:
                if key in keys[rival].split(","):
                    return action, key, rival
    return None


def _rivals(action: str, groups: Sequence[Sequence[Key]]) -> Iterator[Key]:
    """The actions that cannot have the same key: those that are there at the same time, but for the console's behind
    those of the map, which go before them."""
    home = next(group for group in groups if any(key.id == action for key in group))
    ahead = any(key.id == action and key.ahead for key in home)
    for group in groups:
        for key in group:
            if key.id != action and (group is home or ahead or key.ahead):
                yield key


def _split(written: str) -> list[str]:
    """Keys as they are written, separated by commas."""
    return (
        [","]
        if written.strip() == ","
        else [part if part == " " else part.strip() for part in written.split(",") if part]
    )


def _named(key: str) -> str:
    """A key as Textual calls it."""
    if len(key) == 1:
        return _SPELLINGS.get(key, key)
    key = re.sub(r"^(?:control|ctrl|c)[-+](?=.)", "ctrl+", key.casefold())
    key = re.sub(r"^(shift|alt)-(?=.)", r"\1+", key)
    return _SPELLINGS.get(key, key)


def _shown(key: str) -> str:
    """As people write it; without Textual, which a command without a screen does not load."""
    signs = {name: sign for sign, name in PUNCTUATION.items() if sign != " "}
    return strings.KEY_NAMES.get(key) or signs.get(key, key)
