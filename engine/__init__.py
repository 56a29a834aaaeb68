"""Headless half of sayso: everything from the microphone to the robot, without a terminal."""

from engine.telemetry import switch_off

__version__ = "0.1.0"

switch_off()
