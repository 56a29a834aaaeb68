"""Every word of the console that a person reads, in one place, so that a language is one file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from engine.events import State

NAME: Final = "sayso"

STATE_WORDS: Final[dict[State, str]] = {
    "IDLE": "READY",
    "LISTENING": "LISTENING",
    "TRANSCRIBING": "TRANSCRIBING",
    "DECIDING": "DECIDING",
    "PLANNING": "PLANNING",
    "CLARIFYING": "ASKING",
    "SPEAKING": "SPEAKING",
    "ACTING": "ACTING",
    "FEEDBACK": "CHECKING",
    "WAITING": "WAITING",
}
STARTING: Final = "STARTING"
BROKEN: Final = "FAILED"
ENDED: Final = "ENDED"
TASK: Final = "task"

# Keys
KEY_NAMES: Final = {"pageup": "page up", "pagedown": "page down"}
KEY_STOP: Final = "stop"
KEY_WAKE: Final = "wake"
KEY_END: Final = "end"
KEY_TYPE: Final = "type"
KEY_HELP: Final = "help"
KEY_QUIT: Final = "quit"
ABOUT_STOP: Final = "Stop everything at once, motion first. Works everywhere."
ABOUT_WAKE: Final = "Listen now. A robot that speaks or acts stops first."
ABOUT_END: Final = "Stop, reset arm and history, and begin a new task."
ABOUT_TYPE: Final = "Type a request. Up and down recall earlier ones."
ABOUT_HELP: Final = "Show this page, or leave it."
ABOUT_QUIT: Final = "Quit; asks once more while a task is running."
ABOUT_QUIT_NOW: Final = "Quit at once; the robot stops."
ABOUT_LOG: Final = "Show the log instead (small terminals)."
ABOUT_OLDER: Final = "Scroll the conversation back."
ABOUT_NEWER: Final = "Scroll the conversation forward."

# Panes
PANE_CONVERSATION: Final = "Conversation"
PANE_PLAN: Final = "Plan"
PANE_QUEUE: Final = "Actions"
PANE_MAP: Final = "Map"
PANE_ROBOT: Final = "Robot"
PANE_LOG: Final = "Log"

# Conversation
YOU: Final = "you"
ROBOT: Final = "robot"
HOW_SAID: Final[dict[str, str]] = {"speech": "", "text": "typed", "overheard": "overheard"}
CUT_OFF: Final = "cut off"
WELCOME: Final = "Press {wake} and speak, or {type} and type."
WELCOME_TYPING: Final = "Press {type} and type what the robot should do."
EXAMPLES: Final = ("go to the kitchen", "turn left 90 degrees", "where are you?")
TRY: Final = "Try:"
STOPPED: Final = "stopped"
NEW_TASK: Final = "new task"
REJECTED: Final = {
    "no_speech": "nobody spoke",
    "low_confidence": "not understood clearly",
    "too_short": "too short",
    "empty": "no words in it",
    "late": "came too late",
    "artefact": "not speech",
}
NOT_HEARD: Final = "not heard"

# Plan
NO_PLAN: Final = "What the robot makes of your words appears here."
THINKING: Final = "thinking…"
NO_ACTIONS: Final = "No actions yet."
REFUSED: Final = "refused"
NO_PLAN_CAME: Final = "no plan"
QUESTION: Final = "asks"
PLAN_BY: Final = {
    "phrases": "by phrases",
    "local": "by the local model",
    "openai": "by a cloud model",
    "dify": "by Dify",
    "direct": "as given",
}

# Robot
NO_ROBOT: Final = "The robot appears when it has started."
NO_MAP: Final = "loading the map…"
PART_WORDS: Final = {
    "robot": "robot",
    "microphone": "mic",
    "recogniser": "recogniser",
    "planner": "planner",
    "camera": "camera",
    "voice": "voice",
}
LOADING: Final = "loading"
MISSING: Final = "missing"
ALL_READY: Final = "all parts ready"
HEADING: Final = "heading"
SPEED: Final = "speed"
TURNING: Final = "turning"
GRIPPER: Final = "gripper"
OPEN: Final = "open"
CLOSED: Final = "closed"
HALF_OPEN: Final = "half"
AT_REST: Final = "at rest"
MOVING: Final = "moving"

# Microphone
MIC: Final = "mic"
MIC_IDLE: Final = "not listening"
MIC_LOADING: Final = "starting"
MIC_SPEECH: Final = "speech"
MIC_QUIET: Final = "quiet"
NO_MICROPHONE: Final = "No microphone: press / and type, or start with sayso --demo."

# Input
PLACEHOLDER: Final = "Press / and type what the robot should do"
PLACEHOLDER_TYPING: Final = "enter sends · up and down recall · esc stops and leaves"

# Quitting and failing
NOT_STARTED: Final = "not started"
QUIT_QUESTION: Final = "A task is running: {key} again quits, esc stays"
ENGINE_STARTING: Final = "The engine is starting…"
ENGINE_FAILED: Final = "The engine did not start"
SESSION_ENDED: Final = "{key} quits; ended: {reason}"
ENGINE_SILENT: Final = "The engine does not answer"
ABOUT_SILENT: Final = "It hangs or was paused. The robot has stopped by itself, as it does without an engine."
HINT_SILENT: Final = "{stop} still stops the robot, {leave} quits at once. Other keys wait for the engine."
PAUSED: Final = "away for {seconds:.1f} s"
ROBOT_BACK: Final = "the robot is back where it was"
HALTED: Final = "the robot stopped by itself"
SOMETHING_FAILED: Final = "Something failed"
ASKED_EARLY: Final = "“{}” waits until the engine has started."
CRASH_HINT: Final = "This is a mistake in sayso. Please report it with the lines above."

# Help
HELP_TITLE: Final = "Keys"
HELP_SIGNS: Final = "Signs"
HELP_LEAVE: Final = "{help} or {stop} leaves this page"
SIGN_WORDS: Final = (
    ("○", "queued"),
    ("▸", "running"),
    ("✓", "done"),
    ("✗", "failed"),
    ("■", "interrupted"),
    ("?", "uncertain"),
)

# Terminals
TOO_SMALL: Final = (
    "sayso needs at least {min_columns}×{min_rows} characters (this terminal has {columns}×{rows}). Make it larger."
)
TOO_SMALL_KEYS: Final = "{stop} still stops the robot, {quit} quits."
TOO_SMALL_SHORT: Final = "{columns}×{rows} is too small"
STREAMS: Final = ("standard input", "standard output", "standard error")
NOT_A_TERMINAL: Final = (
    "The console needs a terminal, and {stream} is not one. Use `sayso engine` for programs, or `sayso ask TEXT`."
)
DUMB_TERMINAL: Final = (
    "The console cannot draw on this terminal (TERM is {term}). "
    "Use another one, or `sayso ask TEXT`, which needs only lines of text."
)

# Settings
UNKNOWN_THEME: Final = "There is no theme {!r}; the console uses its own."
