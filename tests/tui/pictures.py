"""Pictures of the console: SVG as the tests compare it, PNG as the README shows it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.terminal_theme import TerminalTheme
from textual.app import App

from tui.rooms.portrait import recorder

SCREENSHOTS = Path(__file__).parents[2] / "screenshots"
FONT = "DejaVu Sans Mono"
_BACKGROUND, _FOREGROUND = (15, 19, 24), (213, 219, 227)
_FORMAT = """\
<svg class="rich-terminal" viewBox="{terminal_x} {terminal_y} {terminal_width} {terminal_height}" xmlns="http://www.w3.org/2000/svg">
<!-- A picture of sayso's console, made and compared by tests/tui/test_pictures.py -->
<style>
.{unique_id}-matrix {{ font-family: "DejaVu Sans Mono", monospace; font-size: 21px; \
line-height: {line_height}px; font-variant-east-asian: full-width; }}
{styles}
</style>
<defs>
<clipPath id="{unique_id}-clip-terminal">
<rect x="0" y="0" width="{terminal_width}" height="{terminal_height}" />
</clipPath>
{lines}
</defs>
<rect width="{width}" height="{height}" fill="#0f1318" />
<g transform="translate({terminal_x}, {terminal_y})" clip-path="url(#{unique_id}-clip-terminal)">
{backgrounds}
<g class="{unique_id}-matrix">
{matrix}
</g>
</g>
</svg>
"""


def svg_of(app: App[Any]) -> str:
    """The screen as it stands, as SVG that is equal for equal screens and refers to nothing outside itself."""
    console = recorder(app)
    console.print(app.screen._compositor.render_update(full=True, simplify=True))
    theme = TerminalTheme(_BACKGROUND, _FOREGROUND, [_BACKGROUND] * 8)
    return console.export_svg(title="", theme=theme, code_format=_FORMAT, unique_id="sayso")


def png_of(svg: str) -> bytes:
    """The picture in pixels, drawn with the one font whose boxes, blocks and braille line up."""
    import resvg_py

    return bytes(
        resvg_py.svg_to_bytes(svg_string=svg, font_family=FONT, monospace_family=FONT, zoom=1, background="#0f1318")
    )


def main() -> None:
    """Write a PNG beside every SVG baseline: ``python -m tests.tui.pictures``."""
    for svg in sorted(SCREENSHOTS.glob("*.svg")):
        if "_zh_" in svg.stem:  # the font has no Chinese characters
            continue
        png = svg.with_suffix(".png")
        png.write_bytes(png_of(svg.read_text()))
        print(png.relative_to(SCREENSHOTS.parent))


if __name__ == "__main__":
    main()
