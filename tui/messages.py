"""What reaches the console from other threads: the engine's, the keyboard's, those that read and write files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Literal

from textual.message import Message

if TYPE_CHECKING:
    from config.schema import Settings
    from engine.errors import SaysoError
    from engine.handle import EngineHandle
    from engine.offer import Offer
    from engine.perception.sighting import Sight
    from tui.graphics.asking import GraphicsChoice
    from tui.kept.history import RequestHistory
    from tui.kept.sizes import Shares, SizeFile
    from tui.options import Option
    from tui.words.language import Language, Telling

CameraChoice = Literal["auto", "on", "off"]


class Woken(Message):
    """Events lie in the inbox."""


class Started(Message):
    """The engine is there."""

    def __init__(self, handle: EngineHandle, offer: Offer) -> None:
        super().__init__()
        self.handle = handle
        self.offer = offer


class Failed(Message):
    """The engine did not start, or did not take a command."""

    def __init__(self, error: Exception, title: str, *, fatal: bool) -> None:
        super().__init__()
        self.error = error
        self.title = title
        self.fatal = fatal


class Dressed(Message):
    """The settings are read: how the console is to look."""

    def __init__(
        self,
        theme: str,
        fps: float,
        camera: CameraChoice,
        graphics: GraphicsChoice,
        motion: Literal["full", "reduced"],
        language: Language | None,
        wording: Telling | None,
    ) -> None:
        super().__init__()
        self.theme = theme
        self.fps = fps
        self.camera = camera
        self.graphics = graphics
        self.motion = motion
        self.language = language
        self.wording = wording


class Recalled(Message):
    """What was typed in earlier sessions is read, and the keys that somebody chose are known."""

    def __init__(self, keys: Mapping[str, str], history: RequestHistory | None) -> None:
        super().__init__()
        self.keys = keys
        self.history = history


class Measured(Message):
    """How the panes shared the room in earlier sessions is read."""

    def __init__(self, shares: Shares, file: SizeFile) -> None:
        super().__init__()
        self.shares = shares
        self.file = file


class Settled(Message):
    """Settings were read, or one of them was set, or could not be."""

    def __init__(
        self,
        options: Sequence[Option],
        key: str = "",
        *,
        settings: Settings | None = None,
        wording: Telling | None = None,
        file: str = "",
        failed: str = "",
        theme: str = "",
    ) -> None:
        """``key`` was set, in ``file``, which is empty where nothing had to be written; ``settings`` are those in force
        now. ``failed``: why not; then ``theme`` is the one that stays."""
        super().__init__()
        self.options = tuple(options)
        self.key = key
        self.settings = settings
        self.wording = wording
        self.file = file
        self.failed = failed
        self.theme = theme


class Warned(Message):
    """Something that goes into the log."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.text = text


class Told(Message):
    """Something that a person asked for is done, or was not to be had."""

    def __init__(self, text: str, level: Literal["info", "error"] = "info", file: str = "") -> None:
        """``file`` was written."""
        super().__init__()
        self.text = text
        self.level = level
        self.file = file


class Reported(Message):
    """The terminal has drawn what was sent; ``t`` is monotonic seconds."""

    def __init__(self, t: float) -> None:
        super().__init__()
        self.t = t


class Answered(Message):
    """The terminal says what it can do: an escape sequence (see ``tui.graphics``)."""

    def __init__(self, answer: str) -> None:
        super().__init__()
        self.answer = answer


class Seen(Message):
    """A picture that was asked for, or why there is none."""

    def __init__(self, found: Sight | SaysoError) -> None:
        super().__init__()
        self.found = found


class KeyDone(Message):
    """What a key was dealt out to has taken it, and what it does is done; ``told``: what it told the console by a
    message has come, too."""

    def __init__(self, *, told: bool = False) -> None:
        super().__init__()
        self.told = told


class HungUp(Message):
    """The terminal is gone, or somebody ends the process."""
