"""``sayso doctor``: looks for what is missing, says how to get it, and changes nothing."""

from __future__ import annotations

import asyncio
import dataclasses
import shutil
from argparse import Namespace
from typing import Final

from config.schema import Settings
from engine.audio.calibration import Calibration, calibrate
from engine.audio.microphone import Microphone
from engine.audio.satellite_microphone import SatelliteMicrophone
from engine.audio.source import Frame
from engine.audio.vad import make_vad
from engine.errors import ExitCode
from engine.parts.loading import make_microphone
from tui.commands.level_plot import level_plot
from tui.commands.recording import recorded
from tui.commands.settings import load_settings
from tui.doctor.diagnosis import Finding, examine
from tui.output import data, json_line, say

MARKS = {"ok": "✓", "limited": "!", "missing": "✗"}

RECORDING_S: Final = 3.0


def run(arguments: Namespace) -> int:
    """Examine everything. Exit code 3 when something is missing that sayso cannot do without."""
    settings = load_settings(arguments)
    if arguments.mic:
        return _microphone(settings, json=arguments.json)
    findings: list[Finding] = []
    for finding in examine(settings):
        findings.append(finding)
        if arguments.json:
            json_line(finding)
        else:
            data(f"{MARKS[finding.state]} {finding.name:<18} {finding.detail}")
            if finding.fix:
                data(f"  {'':<18} → {finding.fix}")
    needed = [finding for finding in findings if finding.state == "missing" and finding.needed]
    return int(ExitCode.MISSING if needed else ExitCode.DONE)


def _microphone(settings: Settings, *, json: bool) -> int:
    """Record for three seconds and judge them. Exit code 1 when something is to be done about it."""
    microphone = make_microphone(settings)
    frames = asyncio.run(_recorded(microphone))
    found = calibrate(frames, make_vad(settings.vad))
    if json:
        json_line({"microphone": microphone.name, "overruns": microphone.overruns, **dataclasses.asdict(found)})
    else:
        _show(found, settings, microphone)
    return int(ExitCode.DONE if found.verdict == "good" else ExitCode.FAILED)


async def _recorded(microphone: Microphone | SatelliteMicrophone) -> list[Frame]:
    async with microphone:
        say(f"{microphone.name}: say “go to the kitchen” now. It records for {RECORDING_S:g} seconds…")
        return await recorded(microphone, RECORDING_S)


def _show(found: Calibration, settings: Settings, microphone: Microphone | SatelliteMicrophone) -> None:
    from rich.console import Console

    columns = min(110, shutil.get_terminal_size().columns)
    Console(highlight=False).print(level_plot(found.levels, found.voiced, found.noise_db, columns))
    speech = f"{found.speech_db:.0f} dB ({found.speech_s:.1f} s)" if found.speech_db is not None else "none"
    clipped = f", {found.clipped} samples clipped" if found.clipped else ""
    data(f"noise floor {found.noise_db:.0f} dB · speech {speech} · peak {found.peak_db:.0f} dB{clipped}")
    for warning in microphone.warnings:
        data(warning)
    data(f"{'✓' if found.verdict == 'good' else '!'} {found.verdict}: {found.advice}")
    if found.gain_db is not None:
        data(f"  audio.gain_db is {settings.audio.gain_db} now")
