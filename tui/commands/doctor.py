"""``sayso doctor``: looks for what is missing, says how to get it, and changes nothing."""

from __future__ import annotations

import asyncio
import dataclasses
import shutil
import sys
from argparse import Namespace
from typing import Final

from config.schema import Settings
from engine.audio.calibration import Calibration, calibrate
from engine.audio.microphone import Microphone
from engine.audio.satellite_microphone import SatelliteMicrophone
from engine.audio.source import Frame
from engine.audio.vad import make_vad
from engine.errors import ExitCode, UsageError
from engine.parts.loading import make_microphone
from tui.commands.level_plot import level_plot
from tui.commands.recording import recorded
from tui.commands.settings import load_settings
from tui.doctor.diagnosis import examine
from tui.doctor.finding import Finding
from tui.output import data, json_line, say

MARKS = {"ok": "✓", "limited": "!", "missing": "✗"}

RECORDING_S: Final = 3.0


def run(arguments: Namespace) -> int:
    """Examine everything. Exit code 3 when something is missing that sayso cannot do without."""
    settings = load_settings(arguments)
    if arguments.mic:
        return _microphone(settings, json=arguments.json)
    if arguments.wheels_up:
        return _wheels_up(settings, sure=arguments.yes)
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


def _wheels_up(settings: Settings, *, sure: bool) -> int:
    """Whether the motor board stops by itself when the line falls silent, written into the robot's description."""
    from config import paths
    from engine.robot.bodies import description_of
    from engine.robot.description import note
    from engine.robot.rosmaster.inspection import fall_silent

    robot = settings.robot
    if robot.port is None or robot.kind != "rosmaster":
        raise UsageError("There is no motor board: robot.kind is sim.", hint="--set robot.kind=rosmaster, robot.port=…")
    board = description_of(robot).board
    assert board is not None, "this kind has one"
    say("The wheels will turn for a second, and perhaps go on for two. Lift the robot so that none touches anything.")
    if not sure:
        say("Type yes when it is lifted:")
        if sys.stdin.readline().strip().casefold() not in ("yes", "是"):
            say("sayso: nothing was moved.")
            return int(ExitCode.FAILED)
    found = fall_silent(robot.port, board.car_type, paths().estop.exists)
    if not found.moved:
        say("sayso: the board reported no motion, so nothing was learned. Is the motor switch on?")
        return int(ExitCode.FAILED)
    stops = found.stopped_after is not None
    file = note(robot.made_as, {"board.stops_by_itself": stops})
    if found.stopped_after is not None:
        data(f"✓ it stops by itself {found.stopped_after:.1f} s after the line has fallen silent")
    else:
        data("! it does not stop by itself: a cable that is pulled out leaves it driving at its last speed")
    say(f"sayso: written into {file}")
    return int(ExitCode.DONE)


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
