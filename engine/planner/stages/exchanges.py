"""What the exchanges of a task tell: what was said last, what the robot asked, how often it has planned since."""

from __future__ import annotations

from collections.abc import Sequence

from engine.planner.request import Exchange

_ASKS = '{"clarification"'  # as ``NoPlan.as_written`` begins where it is a question


def last_said(exchanges: Sequence[Exchange]) -> str:
    """What the user said last; empty where nothing was said."""
    return next((exchange.text for exchange in reversed(exchanges) if exchange.who == "user"), "")


def last_question(exchanges: Sequence[Exchange]) -> str:
    """What the robot wrote last, where that is a question."""
    written = next((exchange.text for exchange in reversed(exchanges) if exchange.who == "robot"), "")
    return written if written.startswith(_ASKS) else ""


def rounds(exchanges: Sequence[Exchange]) -> int:
    """Plans that were made since the user said something."""
    made = 0
    for exchange in reversed(exchanges):
        if exchange.who == "user":
            break
        made += exchange.who == "robot"
    return made


def open_command(exchanges: Sequence[Exchange]) -> tuple[str, ...]:
    """What the user said, and answered, before the question of the robot that was the last thing to happen; oldest
    first."""
    said: list[str] = []
    asked = False
    for exchange in reversed(exchanges):
        if exchange.who == "robot":
            if not exchange.text.startswith(_ASKS):
                break
            asked = True
        elif exchange.who == "user":
            if not asked:
                break
            said.append(exchange.text)
            asked = False
    return tuple(reversed(said))
