"""The doctor says which serial ports there are, and what is on the one that the settings name."""

from __future__ import annotations

import threading
from pathlib import Path
from types import SimpleNamespace

import pytest

from config import load
from config.schema import Settings
from engine.wake import iflytek
from tests.wake_module import WakeModule
from tui.doctor import diagnosis
from tui.doctor.diagnosis import _serial, _wake_module
from tui.doctor.finding import Finding


def settings(port: Path | str, protocol: str = "auto") -> Settings:
    overrides = (f"wake.serial.port={port}", f"wake.serial.protocol={protocol}")
    return load(overrides=overrides, environ={}, user_folder=Path("/nowhere"))


def test_ports_are_listed_with_what_a_setting_would_call_them(monkeypatch: pytest.MonkeyPatch) -> None:
    from serial.tools import list_ports

    usb = SimpleNamespace(
        device="/dev/ttyUSB0", description="USB Serial", vid=0x1A86, pid=0x7523, serial_number=None, location="1-1"
    )
    monkeypatch.setattr(list_ports, "comports", lambda: [usb])
    assert _serial(settings("null")).detail == "/dev/ttyUSB0 (USB Serial 1a86:7523)"
    assert _wake_module(settings("null")) == Finding("wake module", "ok", "none (wake.serial.port)")


def test_a_module_that_shakes_hands_is_recognised(tmp_path: Path) -> None:
    with WakeModule(tmp_path) as module:

        def shake_hands() -> None:
            module.hear(iflytek.IflytekRing().greeting)
            module.say(iflytek.frame(iflytek.HANDSHAKE, 1, iflytek.CONFIRM))

        ring = threading.Thread(target=shake_hands)
        ring.start()
        found = _wake_module(settings(module.path, "iflytek"))
        ring.join()
    assert found == Finding("wake module", "ok", f"iflytek on {module.path}; the module said: handshake")


def test_a_silent_module_may_be_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(diagnosis, "WAKE_MODULE_S", 0.05)
    with WakeModule(tmp_path) as module:
        found = _wake_module(settings(module.path))
    assert (found.state, found.detail.split(";")[0]) == ("ok", str(module.path))
    assert "silent" in found.detail


def test_a_port_that_is_not_there_is_missing_and_the_rest_works_without_it() -> None:
    found = _wake_module(settings("/dev/ttyNowhere"))
    assert (found.state, found.needed) == ("missing", False)
    assert found.detail == "There is no serial port /dev/ttyNowhere."
    assert "Plug the wake module in" in found.fix
