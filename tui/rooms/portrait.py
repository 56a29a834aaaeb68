"""The screen as a picture that is kept (SVG): as it stands. Where the terminal shows what the camera sees in pixels of
its own, of which no text knows, that is drawn in characters here."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.segment import Segment, Segments
from textual.strip import Strip

from tui.words import strings

if TYPE_CHECKING:
    from textual.app import App
    from textual.geometry import Region

    from tui.stage import Stage


def portrait(stage: Stage) -> str:
    """What is on the screen now."""
    camera = stage.main.camera
    place = camera.place() if stage.screen is stage.main else None
    blocks = camera.blocks() if place is not None else ()
    if place is None or not blocks:
        return stage.export_screenshot(title=strings.NAME)
    console = recorder(stage)
    console.print(Segments(list(_with_camera(stage, place, blocks))), end="")
    return console.export_svg(title=strings.NAME)


def recorder(app: App[Any]) -> Console:
    """What remembers the characters that are printed on it, in their colours; as large as the screen."""
    width, height = app.size
    return Console(
        width=width,
        height=height,
        file=io.StringIO(),
        force_terminal=True,
        color_system="truecolor",
        record=True,
        legacy_windows=False,
        safe_box=False,
    )


def _with_camera(stage: Stage, place: Region, blocks: Sequence[Strip]) -> Iterator[Segment]:
    """The characters of the screen, with these in that place."""
    for row, line in enumerate(stage.main._compositor.render_strips()):
        if row:
            yield Segment.line()
        if place.y <= row < place.bottom:
            camera = blocks[row - place.y]
            for line_filter in stage.get_line_filters():
                camera = camera.apply_filter(line_filter, stage.main.background_colors[1])
            yield from Strip.join([line.crop(0, place.x), camera, line.crop(place.right)])
        else:
            yield from line
