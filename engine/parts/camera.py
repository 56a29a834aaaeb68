"""The robot's camera as a part of the engine: what the robot tells of it becomes the part's status and events.

The robot itself replaces a camera that was lost; whoever drives by pictures gets an error meanwhile and drives no
more. Here people are told what happened, and when it is back.
"""

from __future__ import annotations

from engine.bus import Emit
from engine.errors import CameraError
from engine.events import ErrorRaised, Log
from engine.parts.part import Part
from engine.robot.camera_news import CameraNews, GivenUp, Lost, Opened, Opening


class CameraPart:
    """Follows the camera; its value is what kind it is ("opengl (egl) 160×120")."""

    def __init__(self, part: Part[str], emit: Emit) -> None:
        self._part = part
        self._emit = emit
        self._was_lost = False

    def follow(self, news: CameraNews) -> None:
        """Take notice of news; in the engine's loop."""
        match news:
            case Opening():
                self._part.begin()
            case Opened(detail, note):
                self._part.succeed(detail, detail)
                if note:
                    self._emit(Log("info", "camera", note))
                if self._was_lost:
                    self._emit(Log("info", "camera", "The camera is back."))
                self._was_lost = False
            case Lost(error):
                self._was_lost = True
                self._tell(error)
            case GivenUp(error):
                if self._was_lost:
                    self._tell(error)
                self._part.fail(error)

    def _tell(self, error: CameraError) -> None:
        self._emit(ErrorRaised(error.code, error.message, error.hint))
