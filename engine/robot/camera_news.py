"""How a robot's camera is doing, for whoever follows it: it is opening, delivers, was lost, or cannot be had."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from engine.errors import CameraError


@dataclass(frozen=True, slots=True)
class Opening:
    """It is being started, for the first time or again."""


@dataclass(frozen=True, slots=True)
class Opened:
    """It delivers pictures."""

    detail: str  # "opengl (egl) 160×120"
    note: str = ""  # what people should know about how that came


@dataclass(frozen=True, slots=True)
class Lost:
    """It delivers no more, and is being replaced."""

    error: CameraError


@dataclass(frozen=True, slots=True)
class GivenUp:
    """It cannot be had."""

    error: CameraError


CameraNews = Opening | Opened | Lost | GivenUp
TellOfCamera = Callable[[CameraNews], None]
