"""Which serial ports a setting means, and how one is opened for a wake module.

A setting names a device, a kind of USB device by its numbers, or ``auto``, which is every USB serial port. A device
that was open once is known again by its USB identity, should the system give it another name when it comes back. One
without a serial number of its own is like every other of its kind: it is known again in the same place on USB alone.
Plugged in elsewhere it is one of those that may be the module, as is whatever else has come meanwhile.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from typing import Any, Final

from config.schema import USB_DEVICE
from engine import serial_port
from engine.serial_port import Port, PortError, attached, device_of


@dataclass(frozen=True, slots=True)
class Known:
    """The port on which the module was."""

    port: Port
    beside: tuple[Port, ...] = ()  # attached elsewhere when it went: none of them is the module, unless plugged in anew
    alike: bool = False  # one of those had the same identity, which is no proof then

    @property
    def is_marked(self) -> bool:
        """Whether its identity is its alone, so that it is known wherever it is plugged in."""
        return self.port.identity is not None and self.port.identity[2] != "" and not self.alike

    def lost(self) -> Known:
        """The same once it has gone."""
        place, path = _place(self.port), self.port.path
        beside = tuple(port for port in attached() if _place(port) != place and port.path != path)
        return replace(self, beside=beside, alike=self.alike or any(map(self.is_like, beside)))

    def looked_for(self) -> Known:
        """The same, without what has been unplugged since."""
        return replace(self, beside=tuple(port for port in self.beside if _is_there(port.path)))

    def is_like(self, port: Port) -> bool:
        """Whether a port's identity is that of the module."""
        return self.port.identity is not None and port.identity == self.port.identity


@dataclass(frozen=True, slots=True)
class Wanted:
    """The ports that may be the module's. ``certain``: there is one, and it needs no further proof."""

    paths: tuple[str, ...]
    certain: bool


def wanted(setting: str, known: Known | None = None) -> Wanted:
    """The ports that a setting means, as far as they are there.

    ``known`` is the one on which the module was. If it is there again, it is the only one, whatever it is called now;
    and what has its name meanwhile, or was there beside it, is not taken for it: that may be a motor board.
    Raises :class:`PortError` when there is none.
    """
    if setting != "auto" and not USB_DEVICE.fullmatch(setting):
        return _named(setting, known)
    ports = tuple(port for port in _free(known) if _is_usb(port, setting))
    if (again := _again(ports, known)) is not None:
        return Wanted((again.path,), certain=True)
    if not ports:
        what = "USB serial port" if setting == "auto" else f"serial port of a USB device {setting}"
        raise PortError("absent", f"There is no {what}.", hint=_LOOK)
    return Wanted(tuple(port.path for port in ports), certain=False)


def opened(path: str) -> Any:
    """The port of this name, see :func:`engine.serial_port.opened`. Raises :class:`PortError`."""
    return serial_port.opened(path, "wake.serial.port", _LOOK)


_LOOK: Final = "Plug the wake module in. sayso finds it by itself. `sayso doctor` lists the ports there are."


def _named(path: str, known: Known | None) -> Wanted:
    """The port of this name, or the known one if names have been dealt out anew. Raises :class:`PortError`."""
    device = device_of(path)
    there = _is_there(device)
    if known is None or known.port.identity is None:
        if there:
            return Wanted((path,), certain=True)
        raise PortError("absent", f"There is no serial port {path}.", hint=_LOOK)
    ports = tuple(port for port in _free(known) if known.is_like(port))
    again = _again(ports, known, device)
    if again is not None or ports:
        paths = tuple(path if port.path == device else port.path for port in (ports if again is None else (again,)))
        return Wanted(paths, certain=again is not None)
    if there:
        hint = "Plug the module in again. To use this device, start sayso again."
        raise PortError("taken", f"{path} is another device now, and the wake module is gone.", hint=hint)
    raise PortError("absent", f"There is no serial port {path}.", hint=_LOOK)


def _is_there(device: str) -> bool:
    return os.path.exists(device)  # noqa: PTH110 - a device is no file to look into


def _is_usb(port: Port, setting: str) -> bool:
    """Whether it is on USB, and the device that is meant unless that is ``auto``."""
    if port.identity is None or (meant := USB_DEVICE.fullmatch(setting)) is None:
        return port.identity is not None
    vendor, product, serial = port.identity
    return (vendor, product, meant[3] or serial) == (int(meant[1], 16), int(meant[2], 16), serial)


def _free(known: Known | None) -> tuple[Port, ...]:
    """The ports there are, without those that were there beside the module."""
    return tuple(port for port in attached() if known is None or port not in known.beside)


def _again(ports: tuple[Port, ...], known: Known | None, device: str = "") -> Port | None:
    """The known port among these: the one in the same place, or else the only one of its identity, or that of this name
    among several; the last two only where that identity is no other's."""
    if known is None:
        return None
    alike = [port for port in ports if known.is_like(port)]
    in_place = next((port for port in alike if _place(port) == _place(known.port)), None)
    if in_place is not None or not known.is_marked:
        return in_place
    return alike[0] if len(alike) == 1 else next((port for port in alike if port.path == device), None)


def _place(port: Port) -> str:
    """Where on USB it is; its name where that is not known."""
    return port.location or port.path
