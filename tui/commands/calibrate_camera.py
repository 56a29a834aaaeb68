"""``sayso robot calibrate camera``: a printed chessboard is held before the camera, and then laid on the floor.

Nothing is shown but words, so that it works where there is no window. Pictures are taken by themselves, while a person
moves the board. Of a camera on the arm the lens alone is measured: its place is the arm's.
"""

from __future__ import annotations

import contextlib
import math
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from config.writing import write_whole
from engine.errors import ExitCode, RobotError, StorageError, UsageError
from tui.commands.guided import answer, today
from tui.output import data, say

if TYPE_CHECKING:
    from config.schema import Camera, Settings
    from engine.robot.calibration.chessboard import Chessboard
    from engine.robot.calibration.lens import FoundLens
    from engine.robot.description import CameraOf
    from tui.commands.board_pictures import BoardPictures

OTHER_SHAPE: Final = 0.01
"""Of a picture's proportions, by which those that are used may differ."""
ASKEW: Final = math.radians(2)
"""From this on it is said that a camera is turned about its line of sight."""
HIGHEST: Final = 2.0
"""m above the floor; no camera of a robot that drives indoors is higher."""
OTHER_WAY: Final = 45.0
"""deg by which a camera cannot look otherwise than it is described: then the board is not where it should be."""
NOT_THE_FLOOR: Final = math.radians(20)
"""What is turned by more than this does not lie on the floor before the camera."""


def write_sheet(arguments: Namespace) -> int:
    """Write the board to print. Raises ``UsageError`` or ``StorageError``."""
    board, file = _board(arguments), Path(arguments.sheet)
    if not board.fits:
        size = f"{board.columns} × {board.rows} squares of {arguments.square:g} mm"
        raise UsageError(f"{size} do not fit on A4.", hint="--columns, --rows and --square make it smaller.")
    try:
        write_whole(file, board.sheet().encode(), mode=0o644)
    except OSError as error:
        raise StorageError(f"{file} cannot be written: {error.strerror}.") from error
    say(f"sayso: written into {file}. Print it at 100 % (no fitting to the page), and glue it onto something stiff.")
    say(f"A square must have {arguments.square:g} mm then; where it has not, --square says how many it has.")
    return int(ExitCode.DONE)


def run(settings: Settings, arguments: Namespace) -> int:
    """The command as the command line gives it. Raises ``UsageError``, ``RobotError`` or ``CameraError``."""
    from engine.robot.calibration.lens import lens_by
    from engine.robot.calibration.views import WANTED
    from engine.robot.camera import Lens
    from engine.robot.usb_camera import Capture
    from tui.commands.board_pictures import BoardPictures

    about, device, board = _camera(settings), settings.robot.camera.device, _board(arguments)
    assert device is not None, "looked at before"
    with contextlib.closing(Capture(device)) as capture:
        pictures = BoardPictures(capture, board, arguments.timeout)
        _same_shape(settings.robot.camera, pictures)
        guess = Lens.of_view(pictures.width, pictures.height, math.radians(about.view))
        say(
            f"{WANTED} pictures will be taken by themselves of a board with {board.columns} × {board.rows} squares. "
            "Hold it still, all of it before the camera: near and far, in the middle and at the edges; and tilt each "
            "of its edges towards the camera, by 30° or so (left and right are the camera's)."
        )
        _ask("Enter begins.", arguments)
        found = lens_by(board, guess, pictures.held(guess))
        _keep_lens(settings, found, about)
        if about.on_arm:
            say("sayso: it is on the arm; where it is there (arm.eye) is not calibrated.")
        else:
            say("Now lay the board flat on the floor before the robot, where the camera sees all of it.")
            _ask("Enter goes on.", arguments)
            _keep_place(settings, pictures, board, found, arguments.thickness / 1000)
    return int(ExitCode.DONE)


def _keep_lens(settings: Settings, found: FoundLens, about: CameraOf) -> None:
    from engine.robot.calibration.lens import MOST_BENT, MOST_UNSURE
    from engine.robot.description import note

    if not found.unsure <= MOST_UNSURE:
        raise RobotError(
            f"The angle of view is known to ± {math.degrees(found.unsure):.1f}° only: nothing was written.",
            hint="Hold the board nearer, and tilt it more.",
        )
    view = round(math.degrees(found.view), 2)
    file = note(settings.robot.made_as, {"camera.view": view, "calibrated.camera": _told(found)})
    data(f"camera.view {view:g}° (it was {about.view:g}); {_told(found)}")
    if found.bend > MOST_BENT:
        bend = f"{math.degrees(found.bend):.1f}°"
        say(f"sayso: the lens bends straight lines, by {bend} at the rim of the picture. Nothing puts that right.")
    elif found.poor:
        say("sayso: the pictures do not go well with each other. Is the board flat? Measure again with more light.")
    say(f"sayso: written into {file}")


def _keep_place(
    settings: Settings, pictures: BoardPictures, board: Chessboard, found: FoundLens, thickness: float
) -> None:
    from engine.robot.calibration.place import place_by
    from engine.robot.description import note

    about = _camera(settings)
    place = place_by(board, found.lens, pictures.lying(), thickness)
    askew = f"{abs(math.degrees(place.askew)):.0f}°"
    if abs(place.askew) > NOT_THE_FLOOR:
        raise RobotError(
            f"The board is turned by {askew} to the side: it does not lie on the floor. Only the view was written.",
            hint="Lay it flat before the robot, and begin again.",
        )
    x, y, z = about.at
    if not 0 < place.height < HIGHEST or abs(math.degrees(place.down) - about.down) > OTHER_WAY:
        raise RobotError(
            f"That would be {place.height:.2f} m above the floor, looking {math.degrees(place.down):.0f}° down:"
            " the board does not lie on the floor. Only the view was written.",
            hint=f"Lay it flat; or put about where the camera looks into camera.down, which says {about.down:g}°.",
        )
    height, down = round(place.height, 4), round(math.degrees(place.down), 2)
    told = f"{_told(found)}; height and angle by a board on the floor"
    file = note(settings.robot.made_as, {"camera.at": (x, y, height), "camera.down": down, "calibrated.camera": told})
    data(f"camera.at z {1000 * height:.0f} mm (it was {1000 * z:.0f})")
    data(f"camera.down {down:g}° (it was {about.down:g})")
    if abs(place.askew) > ASKEW:
        say(
            f"sayso: the camera is turned by {askew} about its line of sight. Straighten it: no description tells that."
        )
    say(f"sayso: written into {file}")


def _told(found: FoundLens) -> str:
    """How good it is, for the description."""
    unsure, lens = math.degrees(found.unsure), found.lens
    return f"{today()}: ± {unsure:.2f}°, reprojection error {found.error:.2f} px of {lens.width} × {lens.height}"


def _camera(settings: Settings) -> CameraOf:
    """The camera that is configured and described. Raises ``UsageError``."""
    from engine.robot.description import described

    description = described(settings.robot.made_as)
    if description.camera is None:
        raise UsageError(
            f"{description.name} is described without a camera.",
            hint="Its description needs one: camera: {depth: false, view: 50, on_arm: false}",
        )
    if settings.robot.camera.device is None:
        raise UsageError(
            "No camera is configured.", hint="--set robot.camera.device=…; `sayso robot check` lists those there are."
        )
    return description.camera


def _same_shape(used: Camera, pictures: BoardPictures) -> None:
    """Pictures are made as large as the settings say; in another shape, no lens of ours fits them."""
    width, height = pictures.width, pictures.height
    if abs(used.width * height / (used.height * width) - 1) > OTHER_SHAPE:
        raise UsageError(
            f"The camera delivers {width} × {height}, and the settings squeeze that into {used.width} × {used.height}.",
            hint=f"robot.camera.height: {round(used.width * height / width)} keeps its shape.",
        )


def _board(arguments: Namespace) -> Chessboard:
    from engine.robot.calibration.chessboard import Chessboard

    return Chessboard(arguments.columns, arguments.rows, arguments.square / 1000)


def _ask(question: str, arguments: Namespace) -> None:
    if not arguments.yes:
        say(question)
        answer()
