"""Serial ports, and the names by which a setting finds them again."""

from __future__ import annotations

from pathlib import Path

import pytest

from engine import serial_port
from engine.serial_port import Port


def test_a_port_has_a_name_that_lasts_where_the_system_gives_it_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    device, other = tmp_path / "ttyUSB0", tmp_path / "ttyUSB1"
    device.touch()
    other.touch()
    by_id = tmp_path / "by-id"
    by_id.mkdir()
    (by_id / "usb-1a86_USB_Serial-if00-port0").symlink_to(device)
    monkeypatch.setattr(serial_port, "BY_ID", by_id)
    assert Port(str(device), "", None, "").lasting == str(by_id / "usb-1a86_USB_Serial-if00-port0")
    assert Port(str(other), "", None, "").lasting == str(other)
    monkeypatch.setattr(serial_port, "BY_ID", tmp_path / "nowhere")
    assert Port(str(device), "", None, "").lasting == str(device)
