"""What the doctor finds, and what it examines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from config.schema import Settings
from engine.handle import PartName

State = Literal["ok", "limited", "missing"]


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was examined. ``needed``: sayso cannot do without it."""

    name: str
    state: State
    detail: str
    fix: str = ""
    needed: bool = False


@dataclass(frozen=True, slots=True)
class Check:
    """One thing to examine."""

    name: str
    look: Callable[[Settings], Finding]
    part: PartName | None = None
    """The part of an engine that has it open or loaded, and is asked in its place."""
    device: bool = False
    """Only one can have it: it is left alone beside an engine, even one that tells nothing of it."""
