"""``sayso scene``: which scenes there are, and what one looks like from above."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.errors import ExitCode, StorageError
from tui.commands.settings import load_settings
from tui.output import data, json_line, say

if TYPE_CHECKING:
    from rich.console import Console

    from config.schema import Place, Settings
    from engine.robot.sim.scene import Scene
    from engine.robot.sim.sketch import Sketch

MADE_UP = "clutter-SEED"
_WIDEST = 110
_FINE = 40.0  # pixels per metre of the drawing that a terminal's picture is made of


def run(arguments: Namespace) -> int:
    """The command as the command line gives it."""
    if arguments.action == "list":
        return scene_list(json=arguments.json)
    return scene_show(load_settings(arguments), arguments.name, png=arguments.png, json=arguments.json)


def scene_list(*, json: bool = False) -> int:
    """One line a scene: name, size, rooms, furniture, things, people."""
    from engine.robot.sim.scene_file import load_scene, scene_names, scene_path

    for name in scene_names():
        facts = _facts(load_scene(scene_path(name)))
        if json:
            json_line(facts)
        else:
            width, depth = facts["size"]
            data(f"{name:<14} {width:g} × {depth:g} m  {_counted(facts)}")
    if json:
        json_line({"name": MADE_UP, "made_up": True})
    else:
        data(f"{MADE_UP:<14} made up from a number: clutter-7 is the same tomorrow")
    return int(ExitCode.DONE)


def scene_show(settings: Settings, name: str | None, *, png: Path | None = None, json: bool = False) -> int:
    """A picture from above with its legend, a PNG file of it, or everything as JSON. Without a name: the scene of the
    settings."""
    from engine.robot.sim.scene_file import load_scene, scene_path

    scene = load_scene(scene_path(name or settings.robot.scene))
    places = scene.known_places() or settings.places
    if png is not None:
        _write(scene, png)
    if json:
        json_line({**_facts(scene), **_contents(scene, places)})
    elif png is None:
        _draw(scene, places)
    return int(ExitCode.DONE)


def _facts(scene: Scene) -> dict[str, Any]:
    (x0, x1), (y0, y1) = scene.bounds.x, scene.bounds.y
    return {
        "name": scene.name,
        "size": [round(x1 - x0, 2), round(y1 - y0, 2)],
        "rooms": len(scene.rooms),
        "furniture": len(scene.furniture),
        "things": len(scene.objects),
        "landmarks": len(scene.landmarks),
        "people": len(scene.people),
    }


def _contents(scene: Scene, places: dict[str, Place]) -> dict[str, Any]:
    return {
        "start": {"x": scene.start.x, "y": scene.start.y, "yaw_deg": scene.start.yaw},
        "rooms": {name: {"x": room.x, "y": room.y} for name, room in scene.rooms.items()},
        "furniture": {
            name: {"kind": piece.kind, "at": piece.stands, "size": piece.size}
            for name, piece in scene.furniture.items()
        },
        "things": {
            name: {"kind": loose.kind, "colour": loose.colour, "at": loose.at, "stands_on": loose.stands_on}
            for name, loose in scene.objects.items()
        },
        "places": {
            symbol: {"name": place.name, "x": place.position.x, "y": place.position.y}
            for symbol, place in places.items()
        },
        "landmarks": [{"id": mark.id, "at": mark.at} for mark in scene.landmarks],
        "people": list(scene.people),
    }


def _counted(facts: dict[str, Any]) -> str:
    rooms = "1 room" if facts["rooms"] == 1 else f"{facts['rooms']} rooms"
    counted = [rooms, f"{facts['furniture']} pieces of furniture", f"{facts['things']} things"]
    if people := facts["people"]:
        counted.append("somebody who walks about" if people == 1 else f"{people} people")
    return ", ".join(counted)


def _write(scene: Scene, file: Path) -> None:
    """Raises :class:`StorageError`."""
    import cv2

    from engine.robot.sim.sketch import sketch

    picture = sketch(scene).picture
    good, png = cv2.imencode(".png", picture[:, :, ::-1])
    assert good, "PNG takes every picture"
    try:
        file.write_bytes(png.tobytes())
    except OSError as error:
        raise StorageError(f"{file} cannot be written: {error.strerror}.") from error
    say(f"sayso: {picture.shape[1]}×{picture.shape[0]} pixels in {file}")


def _draw(scene: Scene, places: dict[str, Place]) -> None:
    """The picture as wide as the terminal, and what is what; without colours only the latter."""
    from rich.console import Console

    from engine.robot.sim.sketch import sketch

    console = Console(highlight=False)
    if console.color_system is not None:
        _blocks(console, sketch(scene, scale=_FINE, words=False), places)
    _legend(console, scene, places)


def _blocks(console: Console, drawing: Sketch, places: dict[str, Place]) -> None:
    """Two pixels in every character: the upper one in the colour of the letter, the lower one behind it."""
    import cv2
    import numpy as np
    from rich.color import Color
    from rich.segment import Segment, Segments
    from rich.style import Style

    height, width = drawing.picture.shape[:2]
    columns = min(console.width, _WIDEST)
    rows = round(columns * height / width / 2)
    pixels = np.asarray(cv2.resize(drawing.picture, (columns, 2 * rows), interpolation=cv2.INTER_AREA))
    letters: dict[tuple[int, int], str] = {}
    for symbol, place in places.items():
        column, row = drawing.pixel(place.position.x, place.position.y)
        letters[int(row / height * rows), int(column / width * columns)] = symbol[0]
    for row in range(rows):
        line = []
        for column in range(columns):
            upper, lower = (tuple(int(v) for v in pixels[2 * row + i, column]) for i in (0, 1))
            behind = Color.from_rgb(*lower)
            if (letter := letters.get((row, column))) is not None:
                line.append(Segment(letter, Style(bold=True, color="red", bgcolor=behind)))
            else:
                line.append(Segment("▀", Style(color=Color.from_rgb(*upper), bgcolor=behind)))
        console.print(Segments([*line, Segment.line()]), end="")


def _legend(console: Console, scene: Scene, places: dict[str, Place]) -> None:
    from rich.text import Text

    from engine.robot.sim.colours import PALETTE

    def told(what: str, words: Text | str) -> None:
        console.print(Text.assemble((f"{what:<10} ", "bold"), words), soft_wrap=True)

    told(scene.name, f"{'{} × {} m'.format(*_facts(scene)['size'])}: {_counted(_facts(scene))}")
    told("rooms", ", ".join(scene.rooms))
    told("furniture", ", ".join(scene.furniture))
    things = Text()
    for name, loose in scene.objects.items():
        things += Text("● ", style=PALETTE.get(loose.colour, loose.colour)) + Text(name)
        things += Text(f" ({loose.stands_on})  " if loose.stands_on else "  ")
    told("things", things)
    told("places", "  ".join(f"{symbol} {place.name}" for symbol, place in places.items()))
    if scene.people:
        told("people", ", ".join(scene.people))
