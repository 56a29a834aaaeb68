"""``sayso hear``: a recording, or sound on stdin, is heard like a person at the microphone."""

from __future__ import annotations

import sys
from argparse import Namespace
from pathlib import Path

from engine.audio.pipe import PcmSource
from engine.audio.wav import WavSource, check_sound
from engine.commands import Wake
from engine.parts.loading import Sound
from tui.commands.headless import headless
from tui.commands.settings import load_settings, make_state_folder


def run(arguments: Namespace) -> int:
    """Hear the first utterance and do what it says."""
    make_state_folder()
    settings = load_settings(arguments)
    if arguments.file == "-":
        sound = Sound("source", PcmSource(sys.stdin.buffer, live=False))
    else:
        check_sound(Path(arguments.file))  # before an engine is started for nothing
        sound = Sound("source", WavSource(Path(arguments.file), pace=arguments.pace))
    with headless(settings, mode="hear", json=arguments.json, sound=sound) as engine:
        result = engine.perform(Wake("file"), arguments.timeout)
        engine.report(result)
    return result.exit_code
