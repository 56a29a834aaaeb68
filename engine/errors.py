"""Errors a person can act on, and the exit codes they become.

Every error of sayso is a :class:`SaysoError`: a sentence that says what failed and where, a hint that says what
to do next, a stable ``code`` for programs, and the exit code of the process when the error ends it. Failures of
*actions* are not errors but outcomes (see ``engine.skills.outcome``): the robot not being able to do something
is an answer.
"""

from __future__ import annotations

from enum import IntEnum


class ExitCode(IntEnum):
    """Exit status of every sayso command; outside tools rely on these numbers."""

    DONE = 0
    """Everything that was asked for was done."""
    FAILED = 1
    """The robot could not do it, or nothing was understood."""
    USAGE = 2
    """Wrong arguments, an unreadable input file, or an invalid configuration."""
    MISSING = 3
    """A device, a library or a model is missing or broken."""
    TIMEOUT = 4
    """A time limit ran out."""
    CLARIFY = 5
    """The request is ambiguous; a question was asked."""
    REFUSED = 6
    """The request was refused for safety."""
    INTERRUPTED = 130
    """Interrupted by the user (the shell's convention for SIGINT)."""


def one_line(text: str, most: int = 200) -> str:
    """What somebody else said, fit to be shown: one line of signs that can be printed, of ``most`` at most."""
    line = " ".join("".join(sign if sign.isprintable() else " " for sign in text).split())
    return line if len(line) <= most else f"{line[: most - 1]}…"


class SaysoError(Exception):
    """Base of all errors. ``message`` says what failed, ``hint`` what to do about it."""

    code = "error"
    exit_code = ExitCode.FAILED

    def __init__(self, message: str, *, hint: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint

    def __str__(self) -> str:
        return f"{self.message} {self.hint}".rstrip() if self.hint else self.message


class UsageError(SaysoError):
    """The command line or an input file cannot be used."""

    code = "usage"
    exit_code = ExitCode.USAGE


class AudioFormatError(UsageError):
    """A sound file or stream is not what it claims to be."""

    code = "audio_format"


class DeviceError(SaysoError):
    """A device (microphone, serial port, robot) is missing or has gone away."""

    code = "device_missing"
    exit_code = ExitCode.MISSING


class CameraError(DeviceError):
    """The camera delivers no picture."""

    code = "camera_lost"


class ModelError(SaysoError):
    """A model file is missing, incomplete or wrong."""

    code = "model_missing"
    exit_code = ExitCode.MISSING


class StorageError(SaysoError):
    """A file or folder of ours cannot be read or written (permissions, a full disk)."""

    code = "storage"
    exit_code = ExitCode.MISSING


class SceneError(SaysoError):
    """A scene file is wrong."""

    code = "scene"
    exit_code = ExitCode.USAGE


class RobotError(SaysoError):
    """The robot process died or does not answer."""

    code = "robot_lost"
    exit_code = ExitCode.MISSING


class ProcessError(SaysoError):
    """A program that the engine runs cannot be started."""

    code = "process"
    exit_code = ExitCode.MISSING


class PlanError(SaysoError):
    """A plan or an action string cannot be read or is not allowed; nothing of it may run."""

    code = "invalid_plan"
    exit_code = ExitCode.FAILED
