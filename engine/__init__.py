"""Headless half of sayso: everything from the microphone to the robot, without a terminal."""

__version__ = "0.1.0"
