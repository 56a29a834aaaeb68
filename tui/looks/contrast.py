"""What makes a theme of high contrast keep its promise everywhere: words that are too faint are made stronger.

Panes write what matters less in a fainter colour. Here every word is brought to 7:1 against its ground, and every
frame to 3:1 (WCAG 2.1, 1.4.6 and 1.4.11), whichever pane draws it. Pictures made of characters stay as they are.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Final

from rich.segment import Segment
from rich.style import Style
from textual.color import BLACK, WHITE, Color
from textual.filter import LineFilter

WORDS: Final = 7.0
FRAMES: Final = 3.0
_FRAME: Final = frozenset("─│╭╮╰╯")
_STEPS: Final = 20


class Lift(LineFilter):
    """Strengthens what is faint, line by line."""

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        """Colours are those that would be sent: after all other filters."""
        return [_lifted(segment, background) for segment in segments]


def ratio(one: Color, other: Color) -> float:
    """Contrast of two colours, 1…21, as WCAG defines it."""
    dark, light = sorted((_luminance(one), _luminance(other)))
    return (light + 0.05) / (dark + 0.05)


def _luminance(colour: Color) -> float:
    def linear(value: float) -> float:
        return value / 12.92 if value <= 0.03928 else ((value + 0.055) / 1.055) ** 2.4

    red, green, blue = map(linear, colour.normalized)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def _lifted(segment: Segment, background: Color) -> Segment:
    text, style, control = segment
    if style is None or style.color is None or control:
        return segment
    wanted = WORDS if any(map(str.isalnum, text)) else FRAMES if not _FRAME.isdisjoint(text) else 0.0
    return Segment(text, _stronger(style, background, wanted)) if wanted else segment


@lru_cache(maxsize=512)
def _stronger(style: Style, background: Color, wanted: float) -> Style:
    assert style.color is not None
    ink = Color.from_rich_color(style.color)
    ground = Color.from_rich_color(style.bgcolor) if style.bgcolor is not None else background
    best = max((WHITE, BLACK), key=lambda colour: ratio(colour, ground))
    for step in range(_STEPS + 1):
        stronger = ink.blend(best, step / _STEPS)
        if ratio(stronger, ground) >= wanted:
            break
    return style if stronger == ink else style + Style(color=stronger.rich_color)
