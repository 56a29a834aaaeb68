"""Serial ports: which there are, and how one is opened for nobody but us."""

from __future__ import annotations

import contextlib
import errno
import grp
import os
import termios
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal

from engine.errors import DeviceError

BAUD: Final = 115200
"""That of most devices here."""

BY_ID: Final = Path("/dev/serial/by-id")

Reason = Literal["absent", "taken", "denied", "busy", "broken"]


class PortError(DeviceError):
    """A serial port cannot be used."""

    def __init__(self, reason: Reason, message: str, *, hint: str = "") -> None:
        super().__init__(message, hint=hint)
        self.reason = reason


@dataclass(frozen=True, slots=True)
class Port:
    """A serial port of this machine."""

    path: str
    description: str
    identity: tuple[int, int, str] | None  # vendor, product, serial number; None: not on USB
    location: str  # where on USB; empty where unknown

    @property
    def lasting(self) -> str:
        """A name that stays the same when others are plugged in, where there is one; else its path."""
        with contextlib.suppress(OSError):
            for link in sorted(BY_ID.iterdir()):
                if os.path.realpath(link) == self.path:
                    return str(link)
        return self.path

    @property
    def named(self) -> str:
        """What it is, for people, and how a setting names it."""
        numbers = "" if self.identity is None else f"{self.identity[0]:04x}:{self.identity[1]:04x}"
        return " ".join(word for word in (self.description, numbers) if word and word != "n/a") or "not on USB"


def attached() -> tuple[Port, ...]:
    """The serial ports there are; none while one is being unplugged: the next look finds the others."""
    from serial.tools import list_ports

    try:
        return tuple(_port(info) for info in list_ports.comports())
    except (OSError, TypeError, ValueError):  # pyserial reads what is gone meanwhile (its issues 550 and 774)
        return ()


def at(path: str) -> Port:
    """The port of this name, with its identity where it has one."""
    device = device_of(path)
    return next((port for port in attached() if port.path == device), Port(device, "", None, ""))


def device_of(path: str) -> str:
    """The device behind a name, which may be a link; the name itself while that link is being taken away."""
    try:
        return os.path.realpath(path)
    except OSError:  # it was a link a moment ago: realpath lets nothing else through
        return path


def opened(path: str, setting: str, look: str, *, baud: int = BAUD) -> Any:
    """A ``serial.Serial`` for nobody but us. RTS and DTR stay low, for many boards are reset by them. ``setting`` is
    the one that names the port, ``look`` what to do where there is none. Raises :class:`PortError`."""
    import serial

    port = serial.Serial(None, baud, timeout=0, exclusive=True)
    port.rts = port.dtr = False
    port.port = path
    try:
        port.open()
    except (OSError, ValueError, termios.error) as error:  # a SerialException is an OSError
        raise _explained(path, error, setting, look) from error
    return port


def _port(info: Any) -> Port:
    identity = None if info.vid is None else (info.vid, info.pid, info.serial_number or "")
    return Port(info.device, info.description or "", identity, info.location or "")


def _explained(path: str, error: Exception, setting: str, look: str) -> PortError:
    match getattr(error, "errno", None):
        case errno.ENOENT | errno.ENODEV | errno.ENXIO:
            return PortError("absent", f"There is no serial port {path}.", hint=look)
        case errno.EACCES | errno.EPERM:
            hint = f"Join the group that may, and log in again: sudo usermod -aG {_group(path)} $USER"
            return PortError("denied", f"You may not open the serial port {path}.", hint=hint)
        case errno.EAGAIN | errno.EBUSY:
            hint = f"Close what uses it, perhaps another sayso, or name another port in {setting}."
            return PortError("busy", f"Another program has the serial port {path} open.", hint=hint)
    message = f"{path} cannot be used as a serial port: {error}."
    return PortError("broken", message, hint=f"Name another port in {setting}; `sayso doctor` lists them.")


def _group(path: str) -> str:
    """The group that may open it."""
    try:
        return grp.getgrgid(os.stat(path).st_gid).gr_name  # noqa: PTH116 - as above
    except (OSError, KeyError):
        return "dialout"
