"""sayso's own colours, dark, light and of high contrast; every theme of Textual works as well."""

from __future__ import annotations

from typing import Final

from textual.theme import Theme

DARK: Final = Theme(
    name="sayso-dark",
    primary="#5aa9e6",
    secondary="#7f9bb3",
    accent="#e5c07b",
    success="#7bc48f",
    warning="#e0a458",
    error="#e06c75",
    foreground="#d5dbe3",
    background="#0f1318",
    surface="#171d25",
    panel="#232b36",
)

LIGHT: Final = Theme(
    name="sayso-light",
    primary="#1f6fb2",
    secondary="#557086",
    accent="#8a5a00",
    success="#2c7a45",
    warning="#9a5b00",
    error="#b3261e",
    foreground="#1d252e",
    background="#f7f8fa",
    surface="#eceff3",
    panel="#dde3ea",
    dark=False,
)

CONTRAST: Final = Theme(
    name="sayso-contrast",
    primary="#66ccff",
    secondary="#ffffff",
    accent="#ffff00",
    success="#33ff66",
    warning="#ffb000",
    error="#ff8080",
    foreground="#ffffff",
    background="#000000",
    surface="#000000",
    panel="#303030",
    variables={"text-muted": "#e0e0e0", "foreground-muted": "#e0e0e0"},
)
"""White and strong colours on black: for tired eyes, bad screens and sunlight."""

THING_COLOURS: Final = {
    "red": "#e0564f",
    "orange": "#ee8a38",
    "yellow": "#e3bd32",
    "green": "#4fae62",
    "blue": "#4a86d8",
    "purple": "#9a6bc4",
    "white": "#b9bdc2",
    "grey": "#8d9095",
    "black": "#5b5f66",
}
"""How things of these colours are shown on the map: seen well on a dark and on a light ground."""
