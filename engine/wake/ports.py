"""Serial ports: which ones a setting means, how one is opened, and what to do when it cannot be.

A setting names a device, a kind of USB device by its numbers, or ``auto``, which is every USB serial port. A device
that was open once is known again by its USB identity, should the system give it another name when it comes back.
"""

from __future__ import annotations

import errno
import grp
import os
import termios
from dataclasses import dataclass
from typing import Any, Final, Literal

from config.schema import USB_DEVICE
from engine.errors import DeviceError

BAUD: Final = 115200
"""That of all wake modules."""

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


def wanted(setting: str, known: Port | None = None) -> tuple[str, ...]:
    """The ports that a setting means, as far as they are there.

    ``known`` is the one on which the module was. If it is there again, it is the only one, whatever it is called now;
    and what has its name meanwhile is not taken for it: that may be a motor board.
    Raises :class:`PortError` when there is none.
    """
    if setting != "auto" and not USB_DEVICE.fullmatch(setting):
        return (_named(setting, known),)
    ports = tuple(port for port in attached() if _is_usb(port, setting))
    if (again := _again(ports, known)) is not None:
        return (again.path,)
    if not ports:
        what = "USB serial port" if setting == "auto" else f"serial port of a USB device {setting}"
        raise PortError("absent", f"There is no {what}.", hint=_LOOK)
    return tuple(port.path for port in ports)


def at(path: str) -> Port:
    """The port of this name, with its identity where it has one."""
    device = _device(path)
    return next((port for port in attached() if port.path == device), Port(device, "", None, ""))


def opened(path: str) -> Any:
    """A ``serial.Serial`` for nobody but us. RTS and DTR stay low, for many boards are reset by them. Raises
    :class:`PortError`."""
    import serial

    port = serial.Serial(None, BAUD, timeout=0, exclusive=True)
    port.rts = port.dtr = False
    port.port = path
    try:
        port.open()
    except (OSError, ValueError, termios.error) as error:  # a SerialException is an OSError
        raise _explained(path, error) from error
    return port


_LOOK: Final = "Plug the wake module in: it is found by itself. `sayso doctor` lists the ports there are."


def _port(info: Any) -> Port:
    identity = None if info.vid is None else (info.vid, info.pid, info.serial_number or "")
    return Port(info.device, info.description or "", identity, info.location or "")


def _named(path: str, known: Port | None) -> str:
    """The port of this name, or the known one if names have been dealt out anew. Raises :class:`PortError`."""
    device = _device(path)
    there = os.path.exists(device)  # noqa: PTH110 - a device is no file to look into
    if known is None or known.identity is None:
        if there:
            return path
    elif (again := _again(attached(), known, device)) is not None:
        return path if again.path == device else again.path
    elif there:
        hint = "Plug the module in again. To use this device, start sayso again."
        raise PortError("taken", f"{path} is another device now, and the wake module is gone.", hint=hint)
    raise PortError("absent", f"There is no serial port {path}.", hint=_LOOK)


def _device(path: str) -> str:
    """The device behind a name, which may be a link; the name itself while that link is being taken away."""
    try:
        return os.path.realpath(path)
    except OSError:  # it was a link a moment ago: realpath lets nothing else through
        return path


def _is_usb(port: Port, setting: str) -> bool:
    """Whether it is on USB, and the device that is meant unless that is ``auto``."""
    if port.identity is None or (meant := USB_DEVICE.fullmatch(setting)) is None:
        return port.identity is not None
    vendor, product, serial = port.identity
    return (vendor, product, meant[3] or serial) == (int(meant[1], 16), int(meant[2], 16), serial)


def _again(ports: tuple[Port, ...], known: Port | None, device: str = "") -> Port | None:
    """The known port among these; of several that are alike, the one in the same place, or else of this name."""
    if known is None or known.identity is None:
        return None
    alike = [port for port in ports if port.identity == known.identity]
    if len(alike) == 1:
        return alike[0]
    in_place = (port for port in alike if port.location and port.location == known.location)
    return next(in_place, None) or next((port for port in alike if port.path == device), None)


def _explained(path: str, error: Exception) -> PortError:
    match getattr(error, "errno", None):
        case errno.ENOENT | errno.ENODEV | errno.ENXIO:
            return PortError("absent", f"There is no serial port {path}.", hint=_LOOK)
        case errno.EACCES | errno.EPERM:
            hint = f"Join the group that may, and log in again: sudo usermod -aG {_group(path)} $USER"
            return PortError("denied", f"You may not open the serial port {path}.", hint=hint)
        case errno.EAGAIN | errno.EBUSY:
            hint = "Close what uses it, perhaps another sayso, or name another port in wake.serial.port."
            return PortError("busy", f"Another program has the serial port {path} open.", hint=hint)
    message = f"{path} cannot be used as a serial port: {error}."
    return PortError("broken", message, hint="Name another port in wake.serial.port; `sayso doctor` lists them.")


def _group(path: str) -> str:
    """The group that may open it."""
    try:
        return grp.getgrgid(os.stat(path).st_gid).gr_name  # noqa: PTH116 - as above
    except (OSError, KeyError):
        return "dialout"
