"""What may be asked about the past in a word, and which turn that is about: continue, undo and again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, get_args

from engine.states import REST
from tui.shown.model import ConsoleModel
from tui.words import strings
from tui.words.hints import JOINT

FollowUp = Literal["resume", "undo", "again"]


def offered(model: ConsoleModel, turn: str | None = None) -> tuple[FollowUp, ...]:
    """What is offered now, about this ``turn`` or about any; nothing while the robot is at something, or may not move
    at all."""
    if model.state not in REST or model.ended is not None or model.pressed:
        return ()
    offers = model.offers
    about: Mapping[FollowUp, str | None] = {"resume": offers.resume, "undo": offers.undo, "again": offers.again}
    kinds: tuple[FollowUp, ...] = get_args(FollowUp)
    return tuple(kind for kind in kinds if about[kind] is not None and turn in (None, about[kind]))


def in_words(kinds: Sequence[FollowUp], keys: Mapping[str, str]) -> str:
    """Each with its key."""
    return JOINT.join(f"{keys[kind]} {strings.FOLLOW_UPS[kind]}" for kind in kinds)
