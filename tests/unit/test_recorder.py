"""The recorder process: what it makes of a sound card, and what it says."""

from __future__ import annotations

import socket
import subprocess
import sys
import threading
import types
from contextlib import suppress
from typing import Any

import numpy as np
import pytest

from engine.audio import portaudio
from engine.audio import recorder as r
from engine.audio.recorder import MESSAGES, Failed, Looking, Message, Opened, Recorder, Sound, record
from engine.audio.source import FRAME_S, RATE, Samples
from engine.errors import DeviceError, ExitCode
from engine.messages import LENGTH_BYTES

LIMIT_S = 20


def tone(seconds: float, rate: int = RATE) -> np.ndarray[Any, np.dtype[np.float32]]:
    return (0.5 * np.sin(2 * np.pi * 440 * np.arange(round(seconds * rate)) / rate)).astype(np.float32)


def dominant(sound: Samples) -> float:
    """The strongest frequency, Hz."""
    spectrum = np.abs(np.fft.rfft(sound.astype(np.float64) * np.hanning(len(sound))))
    return float(np.argmax(spectrum) * RATE / len(sound))


class SoundCard(types.ModuleType):
    """A sound card for what no real one can be made to do: what of sounddevice's interface the recorder uses."""

    class PortAudioError(Exception):
        pass

    def __init__(self, rates: tuple[int, ...], *, default: int = 48000, channels: int = 2) -> None:
        super().__init__("sounddevice")
        self._rates = rates
        self._default = default
        self._channels = channels
        self._known = True  # when PortAudio looked last
        self.plugged = True
        self.stream: Any = None
        self.opened = threading.Event()
        self.looks = 0

    def query_devices(self, device: str | int | None = None, kind: str | None = None) -> Any:
        info = {"name": "Test card", "default_samplerate": float(self._default), "max_input_channels": self._channels}
        if kind is None:
            return [info] if self._known else []
        if device is not None and str(device) not in "Test card":
            raise ValueError(f"No input device matching {device!r}")
        if not self._channels or not self._known:
            raise self.PortAudioError("Error querying device -1")
        return info

    def InputStream(self, **options: Any) -> Any:
        if options["samplerate"] not in self._rates:
            raise self.PortAudioError("Invalid sample rate [PaErrorCode -9997]")
        self.stream = types.SimpleNamespace(**options, start=self.opened.set, close=lambda: None)
        return self.stream

    def _terminate(self) -> None:
        self._known = False

    def _initialize(self) -> None:
        self._known = self.plugged
        self.looks += 1

    def deliver(self, sound: np.ndarray[Any, Any], *, overflow: bool = False) -> None:
        block = np.tile(sound[:, None], self.stream.channels).astype(np.float32)
        self.stream.callback(block, len(block), None, types.SimpleNamespace(input_overflow=overflow))


class Recording:
    """A recorder at work in a thread, and the end of the link at which the engine would be."""

    def __init__(self, device: str | None = None, *, patient: bool = False) -> None:
        self.link, self._theirs = socket.socketpair()
        self.link.settimeout(LIMIT_S)
        self.last: Failed | None = None
        self._thread = threading.Thread(target=self._run, args=(device, patient))
        self._thread.start()

    def _run(self, device: str | None, patient: bool) -> None:
        with suppress(OSError):  # the engine has gone
            self.last = record(self._theirs, device, patient=patient)

    def next(self) -> Message:
        length = int.from_bytes(self._exactly(LENGTH_BYTES), "little")
        return MESSAGES.decode(self._exactly(length))

    def _exactly(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            more = self.link.recv(count - len(data))
            assert more, "the recorder has gone"
            data += more
        return data

    def wait(self) -> Failed | None:
        self._thread.join(LIMIT_S)
        assert not self._thread.is_alive()
        self._theirs.close()
        self.link.close()
        return self.last


@pytest.fixture
def card(monkeypatch: pytest.MonkeyPatch) -> SoundCard:
    monkeypatch.setattr(portaudio, "LOOK_S", 0.001)
    card = SoundCard((RATE,))
    monkeypatch.setitem(sys.modules, "sounddevice", card)
    return card


def test_nothing_touches_the_sound_system_before_it_is_opened() -> None:
    modules = "engine.audio.microphone, engine.hearing.hearing, engine.parts.ears"
    code = f"import sys, {modules}; assert 'sounddevice' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_a_missing_portaudio_says_what_to_install_and_is_not_looked_for() -> None:
    code = (
        "import ctypes.util, socket\n"
        "ctypes.util.find_library = lambda name: None\n"  # what a machine without the library answers
        "from engine.audio.recorder import record\n"
        "found = record(socket.socketpair()[0], None, patient=True)\n"
        "print(found.for_good, found.message, found.hint)\n"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    what = "The microphone cannot be used: the PortAudio library is missing."
    assert found.stdout.startswith(f"True {what}"), found.stderr
    assert "libportaudio2" in found.stdout


@pytest.mark.parametrize("rate", [16000, 48000, 44100])
def test_a_microphone_is_resampled_when_it_cannot_do_16_khz(monkeypatch: pytest.MonkeyPatch, rate: int) -> None:
    card = SoundCard((rate,), default=rate)
    monkeypatch.setitem(sys.modules, "sounddevice", card)
    recorder = Recorder("Test")
    recorder.open()
    card.deliver(tone(1, rate), overflow=True)
    sound = recorder.read()
    assert len(sound) == pytest.approx(RATE, rel=0.1)
    assert dominant(sound) == pytest.approx(440, abs=2)
    assert recorder.overruns == 1
    assert recorder.name == "microphone (Test card)"


def test_it_says_that_it_runs_once_it_sounds_and_counts_what_is_lost(card: SoundCard) -> None:
    recording = Recording()
    assert card.opened.wait(LIMIT_S)
    card.deliver(tone(FRAME_S))
    assert recording.next() == Opened("microphone (Test card)")
    card.deliver(tone(FRAME_S), overflow=True)
    first, second = recording.next(), recording.next()
    assert isinstance(first, Sound)
    assert isinstance(second, Sound)
    assert len(first.pcm) == 2 * 512
    assert second.overruns == 1
    card.stream.finished_callback()
    assert recording.wait() == Failed(
        "The microphone (Test card) is gone.", "Plug it in again. sayso keeps looking for it.", for_good=False
    )


def test_sound_that_nobody_takes_is_dropped_oldest_first_and_counted(
    card: SoundCard, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorder = Recorder(None)
    recorder.open()
    for number in range(r.WAITING_BLOCKS + 3):
        card.deliver(np.full(4, number / 1000, np.float32))
    assert recorder.unread == 3
    assert recorder.read()[0] == round(3 / 1000 * 32768)


def test_a_device_that_never_sounds_is_none(card: SoundCard, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(r, "FIRST_S", 0.01)
    last = Recording().wait()
    assert last is not None
    assert "delivers no sound" in last.message


def test_a_microphone_that_falls_silent_for_ever_is_lost(card: SoundCard, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(r, "SILENT_S", 0.01)
    monkeypatch.setattr(r.Recorder.read, "__defaults__", (0.01,))
    recording = Recording()
    assert card.opened.wait(LIMIT_S)
    card.deliver(tone(FRAME_S))
    last = recording.wait()
    assert last is not None
    assert "delivers no sound" in last.message


def test_a_microphone_that_is_plugged_in_later_is_found_by_looking_again(card: SoundCard) -> None:
    card.plugged = card._known = False
    recording = Recording(patient=True)
    assert recording.next() == Looking()
    assert recording.next() == Looking()
    card.plugged = True
    assert card.opened.wait(LIMIT_S)
    card.deliver(tone(FRAME_S))
    while (said := recording.next()) == Looking():
        pass
    assert said == Opened("microphone (Test card)")
    assert card.looks >= 2
    card.stream.finished_callback()
    recording.wait()


def test_a_recorder_whose_engine_has_gone_ends(card: SoundCard) -> None:
    card.plugged = card._known = False
    recording = Recording(patient=True)
    assert recording.next() == Looking()
    recording.link.close()
    assert recording.wait() is None


@pytest.mark.parametrize(
    ("card", "device", "message", "hint"),
    [
        (SoundCard((RATE,), channels=0), None, "There is no microphone.", "Without one you can"),
        (SoundCard((RATE,)), "Blue Yeti", "no microphone 'Blue Yeti'", "0: Test card"),
        (SoundCard(()), None, "cannot be opened: Invalid sample rate", "Another program"),
    ],
)
def test_a_microphone_that_cannot_be_had_says_why(
    monkeypatch: pytest.MonkeyPatch, card: SoundCard, device: str | None, message: str, hint: str
) -> None:
    monkeypatch.setitem(sys.modules, "sounddevice", card)
    with pytest.raises(DeviceError, match=message) as caught:
        Recorder(device).open()
    assert caught.value.exit_code is ExitCode.MISSING
    assert hint in caught.value.hint
