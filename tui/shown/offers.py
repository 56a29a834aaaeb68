"""What may be asked about the past in a word, and which turn that is about: continue, undo and again."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Literal, get_args

from engine.states import REST
from tui.shown.model import ConsoleModel
from tui.words import strings
from tui.words.hints import JOINT, Acting
from tui.words.language import told

if TYPE_CHECKING:
    from tui.shown.view import View

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


def why_not(kind: FollowUp, model: ConsoleModel, keys: Mapping[str, str]) -> tuple[str, Callable[[View], bool]]:
    """Why this is not offered, for people, and how long that is so. ``keys`` are those of each action."""
    if model.pressed:
        return strings.NOT_WHILE_PRESSED.format(**keys), lambda view: view.pressed
    if model.state not in REST:
        return strings.NOT_NOW.format(**keys), lambda view: view.model.state not in REST
    why = told(model.offers.no_undo) if kind == "undo" else ""
    return why or strings.NOT_OFFERED[kind], lambda view: kind not in offered(view.model)


def in_pieces(kinds: Sequence[FollowUp], acting: Acting) -> tuple[tuple[str, str], ...]:
    """Each as text and style, with the key that asks for it where ``acting`` knows one that does so now; so does a
    click."""
    pieces: list[tuple[str, str]] = []
    for kind in kinds:
        words = " ".join(filter(None, (acting(kind), strings.FOLLOW_UPS[kind])))
        pieces += [(JOINT, "$foreground 60%"), (words, f"$text-accent @click=app.{kind}")]
    return tuple(pieces[1:])
