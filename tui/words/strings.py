"""Every word of the console that a person reads, in one place, so that a language is one file.

This is English; its twin ``tui.words.strings_zh`` has the same names. ``tui.words.language`` puts either of them here,
so that a word is looked up when it is shown, and never kept.
"""

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
    "WAITING": "READY",
}
STARTING: Final = "STARTING"
BROKEN: Final = "FAILED"
ESTOP: Final = "E-STOP"
ESTOP_HOLDS: Final = "nothing moves; {release} releases"
ESTOP_HOLDS_WAITING: Final = "nothing moves; {release} releases and drops what waits"
ESTOP_RELEASE: Final = "{release} releases"
ESTOP_COMES: Final = "E-STOP once the robot is there; {release} takes it back"
BY_HAND_STANDS: Final = "{why} · {back} back · {interrupt} stops"
BY_HAND: Final = (
    "by hand {speed:g} m/s · {hand_ahead} {hand_back} {hand_left} {hand_right} drive · "
    "{hand_faster} {hand_slower} speed · {hand_aside_left} {hand_aside_right} aside · {back} back · {interrupt} stops"
)
ENDED: Final = "ENDED"
TASK: Final = "task"

# Keys
KEY_NAMES: Final = {"pageup": "page up", "pagedown": "page down", "enter": "enter", "space": "space", "tab": "tab"}
KEY_WORDS: Final = {
    "interrupt": "stop",
    "wake": "wake",
    "end_task": "end",
    "type": "type",
    "help": "help",
    "leave": "quit",
    "leave_now": "quit",
    "back": "back",
    "pane_next": "panes",
    "palette": "find",
    "send": "send",
    "earlier": "earlier",
}
"""In the status line, by action."""
ABOUT_KEYS: Final = {
    "interrupt": "Stop everything at once, motion first. It works everywhere, and changes nothing else.",
    "back": "Go back one step, and stop nothing: from a page, a panel, a pane, the map, a hand or the line.",
    "wake": "Listen now. A robot that speaks or acts stops first.",
    "end_task": "Stop, reset arm and history, and begin a new task.",
    "type": "Go to the line, and type a request.",
    "add": "Send what is in the line to be done after all that runs and waits: it interrupts nothing.",
    "estop": "The emergency stop: nothing moves until it is released.",
    "release": "Release the emergency stop.",
    "speed_down": "Lower the speed limit of the robot: fast, quick, medium, slow.",
    "speed_up": "Raise the speed limit of the robot.",
    "resume": "Continue: do what a stop cut off, from where the robot is.",
    "undo": "Undo: go back from what was done last, where there is a way back.",
    "again": "Do the last plan once more.",
    "by_hand": "Drive by hand, or no longer: the first push ends the plan.",
    "help": "Show the keys, first those of where you are; or leave that page.",
    "leave": "Leave a page; on the main screen quit, which asks once more while something is open.",
    "leave_now": "Quit at once; the robot stops.",
    "log": "Show the log instead (small terminals).",
    "map": "Point at something on the map, look closer, and send the robot there, which asks first; or no longer.",
    "camera": "Show what the camera sees, or no longer.",
    "timeline": "Show the turns instead (small terminals).",
    "turn_back": "Look at the turn before.",
    "turn_on": "Look at the next turn; the newest is followed.",
    "turn": "Show the whole turn, or leave it.",
    "palette": "Find everything that can be done: type a part of it.",
    "recall": "Search your earlier requests.",
    "pane_next": "Go to the next pane, and from the last one to the line.",
    "pane_previous": "Go to the pane before, and from the first one to the line.",
    "pane_conversation": "Go to the conversation.",
    "pane_plan": "Go to the plan.",
    "pane_actions": "Go to the actions.",
    "pane_map": "Go to the map, and point there.",
    "pane_log": "Go to the log.",
    "pane_turns": "Go to the turns.",
    "pane_camera": "Go to what the camera sees.",
    "zoom": "Enlarge the pane with the keyboard, or make it small again.",
    "border_left": "Make the left panes narrower; from the log or the turns, the log.",
    "border_right": "Make the left panes wider; from the log or the turns, the log.",
    "copy": "Copy the turn; pressed again: conversation, plan, actions, log. In tmux: set -s set-clipboard on.",
    "save": "Save the session and a picture of the screen; it says where.",
    "link": "Show or hide how fast the connection to this terminal is.",
    "settings": "Settings: look at them and change them, or leave that page.",
    "doctor": "Examine everything that sayso needs, or leave that page.",
    "examine": "Examine everything once more.",
    "older": "Scroll back: the pane with the keyboard, or else the conversation.",
    "newer": "Scroll forward.",
    "newest": "To the newest lines, or the step of the plan: in the pane with the keyboard, else the conversation.",
    "line_up": "Scroll back by a line.",
    "line_down": "Scroll forward by a line.",
    "map_nearer": "Look closer at the map.",
    "map_farther": "Look from farther away.",
    "map_whole": "Show the whole map.",
    "map_follow": "Follow the robot, or stop following it.",
    "map_legend": "Say what the signs on the map mean, and list who and what was seen; or stop that.",
    "map_point_left": "Move the cursor on the map.",
    "map_point_right": "Move the cursor on the map.",
    "map_point_up": "Move the cursor on the map.",
    "map_point_down": "Move the cursor on the map.",
    "map_left": "Shift what is shown of the map.",
    "map_right": "Shift what is shown of the map.",
    "map_up": "Shift what is shown of the map.",
    "map_down": "Shift what is shown of the map.",
    "map_next": "Point at the next place or thing, or the one before.",
    "map_previous": "Point at the next place or thing, or the one before.",
    "map_go": "Go to the cursor: the first press asks, the second one goes.",
    "map_here": "Tell the robot that it is where the cursor is.",
    "map_turn_left": "Tell the robot that its heading is further to the left.",
    "map_turn_right": "Tell the robot that its heading is further to the right.",
    "queue_up": "Choose a request that waits.",
    "queue_down": "Choose a request that waits.",
    "queue_drop": "Drop the request that is chosen.",
    "queue_earlier": "Have it begin earlier.",
    "queue_later": "Have it begin later.",
    "queue_change": "Take it back into the line, to change it.",
    "log_level": "Show fewer levels of the log: information, warnings, errors; then all again.",
    "log_part": "Show the log of one part: the next one; after the last one of all parts.",
    "log_all": "Show all lines of the log again.",
    "log_find": "Search the log.",
    "log_trouble_before": "Go to the warning or error before.",
    "log_trouble_after": "Go to the next warning or error.",
    "log_turn": "Open the turn of the marked line, or of the newest warning or error.",
    "log_follow": "Show the newest line of the log, and each one that comes.",
    "unfold": "Unfold prompts, what models wrote, and JSON, or fold them.",
    "lines_up": "Scroll up.",
    "lines_down": "Scroll down.",
    "hand_ahead": "Drive ahead while it is held down.",
    "hand_back": "Drive back.",
    "hand_left": "Turn left.",
    "hand_right": "Turn right.",
    "hand_aside_left": "Drive to the left, where the wheels can.",
    "hand_aside_right": "Drive to the right, where the wheels can.",
    "hand_faster": "Drive faster.",
    "hand_slower": "Drive slower.",
    "setting_up": "The setting above.",
    "setting_down": "The setting below.",
    "setting_before": "Show the previous value.",
    "setting_after": "Show the next value.",
    "setting_take": "Save the value that is shown, or take the next one; or type a value.",
    "setting_default": "Go back to the default.",
    "setting_find": "Search the settings.",
}
"""On the help page and in the palette, by action."""

# Panes
PANES: Final = {
    "conversation": "Conversation",
    "plan": "Plan",
    "actions": "Actions",
    "map": "Map",
    "log": "Log",
    "turns": "Turns",
    "camera": "Camera",
}
PANE_ROBOT: Final = "Robot"
ZOOM_BACK: Final = "{zoom} back"
NO_FILE: Final = "{} is not a file"
NO_SIZES: Final = "it holds no pane sizes"
SIZES_NOT_KEPT: Final = "Pane sizes are not saved for later sessions: {}"

# Actions
STEPS_ENDED: Final = "{} of {} ended"
STEPS_FAILED: Final = "{} failed"
REQUESTS_WAIT: Final = "{} waiting"
ANSWER_FIRST: Final = "your answer first"
QUEUE_KEYS: Final = (
    "{queue_drop} drop · {queue_earlier} {queue_later} move · {queue_change} change · "
    "{queue_up}{queue_down} choose · {interrupt} stops"
)
TAKEN_BACK: Final = "{send} puts it back into its place · empty the line to leave it out"
PUTS_BACK: Final = "put back"
"""What the key that sends does with a request that was taken back into the line."""
TAKEN_BACK_TOO_LATE: Final = "It has begun already, or ended."
FOLLOW_UPS: Final = {"resume": "continue", "undo": "undo", "again": "again"}
"""What is offered after a turn: the words for it, as they are asked for."""
NOT_OFFERED: Final = {
    "resume": "No stop has cut anything off that could go on.",
    "undo": "There is nothing that could be undone.",
    "again": "There is no plan yet that could be done again.",
}
NOT_NOW: Final = "The robot is at something: {interrupt} stops it."
NOT_WHILE_PRESSED: Final = "The emergency stop is pressed: {release} releases it."
NOWHERE: Final = "nobody knows where the robot is"
ROBOT_GONE: Final = "The robot is not there."
NO_UNDO: Final = "No undo: {why}"
KEY_STOPS: Final = "{interrupt} stops"

# Camera
NO_PICTURE: Final = "waiting for a picture…"

# Map
MAP_KEYS: Final = "{map} points · {camera} camera"
MAP_FOLLOWS: Final = ("{map_follow} follows", "{map_follow} stays")
"""What the key does to the picture: it goes along with the robot from then on, or no longer."""
MAP_POINTS: Final = "{map_legend} legend · {map_nearer}{map_farther} zoom · {map} back"
MAP_SIGNS: Final = {
    "robot": "the robot and its heading",
    "robot_outside": "the robot is out of the picture there",
    "path": "its way ahead",
    "trail": "its way so far",
    "scan": "an obstacle that the map does not have",
    "thing": "a thing in its own colour",
    "round": "a round thing",
    "stale": "a thing seen long ago, may have moved",
    "person": "a person in the colour of their clothes",
    "person_stale": "a person seen long ago",
    "hand": "the hand",
    "held": "the hand holds something",
}
GO_TO: Final = "go to the {}"
GO_TO_NAMED: Final = "go to {}"  # somebody
GO_TO_HAN: Final = "去{}"  # of a name that is written in Chinese
GO_THERE: Final = "{asked}? {map_go}: yes · any other key: no"
ENTER_GOES: Final = "{map_go} goes there"
ENTER_GOES_TO: Final = "{map_go} goes to {goal}"
NO_WAY_TO_SAY: Final = "no named place here · {map_next} chooses one"
SEEN_AGO: Final = "seen {}"
JUST_NOW: Final = "just now"
SECONDS_AGO: Final = "{} s ago"
MINUTES_AGO: Final = "{} min ago"
HOURS_AGO: Final = "{} h ago"

# Conversation
YOU: Final = "you"
ROBOT: Final = "robot"
HOW_SAID: Final[dict[str, str]] = {"speech": "", "text": "typed", "overheard": "overheard"}
CUT_OFF: Final = "cut off"
WELCOME: Final = "Press {wake} and speak, or type what the robot should do."
WELCOME_TYPING: Final = "Type what the robot should do."
TOUR: Final = (
    "{interrupt} stops the robot at once, on every page · {back} goes back",
    "{help} shows all keys · {palette} finds everything that can be done",
    "{pane_next} goes to the panes, where single letters are keys · {type} goes to the line",
)
"""Below the welcome until the first request was made."""
EXAMPLES: Final = ("turn left 90 degrees", "where are you?")
TRY: Final = "Try:"
STOPPED: Final = "stopped"
STOPPED_BY: Final = "stopped: {reason}"
WAITS: Final = "waits"
MORE_WAIT: Final = "… and {} more"
LOST: Final = {
    "dropped": "dropped",
    "interrupted": "never begun",
    "replaced": "replaced before it began",
    "rejected": "not taken: the robot was busy",
    "left": "left: what it was to follow was not done",
}
"""What becomes of a request that never begins, by its outcome."""
LOST_BY: Final = "never begun: {reason}"
NO_ENGINE: Final = "never begun: the engine did not start"
WAS_PRESSED: Final = "not done: the emergency stop was pressed"
REPLACED_PLANNING: Final = "replaced while it was planned"
REPLACED_ASKED: Final = "replaced while it was asked about"
DECLINED: Final = "given up: the answer was no order"
UNANSWERED: Final = "given up: it was not answered"
QUESTION_WITHDRAWN: Final = "question withdrawn: {reason}"
REPLACED: Final = "replaced by a newer request"
NEW_TASK: Final = "new task"
REASONS: Final = {
    "interrupt": "the stop key",
    "wake": "waking the robot",
    "say": "a new request",
    "heard": "something that was said",
    "end_task": "the end of the task",
    "quit": "quitting",
    "halted": "the robot itself",
    "estop": "the emergency stop",
    "release": "the release of the emergency stop",
    "drive": "driving by hand",
    "by_hand": "driving by hand",
    "stop": "stop",
    "replaced": "a new request",
    "shutdown": "the end of the session",
    "asked": "as asked",
    "finished by the dialogue": "the dialogue ended",
    "asked to": "as asked",
    "a fault": "an error in sayso",
}
"""Who interrupts, how far that goes, and why a task or a session ends, as events name it."""
REJECTED: Final = {
    "no_speech": "nobody spoke",
    "low_confidence": "not understood clearly",
    "too_short": "too short",
    "empty": "no words recognised",
    "late": "came too late",
    "artefact": "not speech",
}
NOT_HEARD: Final = "not heard"

# Plan
NO_PLAN: Final = "The plan for your request appears here."
THINKING: Final = "thinking…"
WAITS_FOR: Final = "waits for the {parts}"
NO_ACTIONS: Final = "No actions yet."
REFUSED: Final = "refused"
NO_PLAN_CAME: Final = "no plan"
QUESTION: Final = "asks"
NO_ORDER: Final = "no order"
PLAN_BY: Final = {
    "phrases": "by known phrases",
    "reader": "by the learned reader",
    "local": "by the local model",
    "openai": "by a cloud model",
    "dify": "by Dify",
    "direct": "as written",
}

# Robot
NO_ROBOT: Final = "The robot is still starting."
NO_MAP: Final = "loading the map…"
PART_WORDS: Final = {
    "robot": "robot",
    "microphone": "mic",
    "recogniser": "recogniser",
    "planner": "planner",
    "model": "model",
    "camera": "camera",
    "voice": "voice",
    "wake": "wake",
    "wake words": "wake word",
    "ros": "ROS",
}
LOADING: Final = "loading"
LOADS: Final = "LOADING"
LOADS_PARTS: Final = "{parts} · requests wait"
MISSING: Final = "missing"
ALL_READY: Final = "all parts ready"
OTHERS_READY: Final = "all others ready"
BATTERY: Final = "battery"
BATTERY_LOW: Final = "battery low"
SPEED_LIMITS: Final = ("slow", "medium", "quick", "fast")
SPEED_LIMIT_IS: Final = "Speed limit: {}"
SPEED_LIMIT: Final = "{robot} · {limit}"
"""The title of the pane, with the keys around the limit that change it, as a click on them does."""
HEADING: Final = "heading"
SPEED: Final = "speed"
TURNING: Final = "turning"
GRIPPER: Final = "gripper"
ARM: Final = "arm"
ARM_WORDS: Final = {"up": "up", "out": "out"}
OPEN: Final = "open"
CLOSED: Final = "closed"
HALF_OPEN: Final = "half"
AT_REST: Final = "at rest"
MOVING: Final = "moving"

# Microphone
MIC: Final = "mic"
WOKEN: Final = {"serial": "woken by the module", "word": "woken by the wake word"}
WOKEN_FROM: Final = "from {angle:.0f}°"
MIC_IDLE: Final = "not listening"
MIC_LOADING: Final = "starting"
MIC_SPEECH: Final = "speech"
MIC_QUIET: Final = "quiet"
NO_MICROPHONE: Final = "No microphone: type, or start with sayso --demo."
DEAF: Final = {
    "microphone": "Nobody can be heard without a microphone: type instead",
    "recogniser": "Nobody is understood without speech recognition: type instead",
}
"""Why waking is of no use, by the part that is missing."""

MIC_WAITING: Final = "no speech"
WAKE_BY: Final = {
    "key": "woken by key",
    "serial": "woken by the module",
    "word": "woken by the wake word",
    "speech": "the speaker went on",
    "command": "woken by a command",
    "demo": "woken by the demo",
    "file": "started from a file",
}
LISTEN_ENDS: Final = {
    "silence": "end of speech",
    "max_length": "too long, cut off",
    "source_ended": "end of the sound",
    "no_speech": "nobody spoke",
    "cancelled": "cancelled",
    "device_lost": "microphone lost",
}
SPEECH_FOR: Final = "{seconds:.1f} s of speech"
LOUDEST: Final = "loudest {db} dB"
COMMA: Final = ", "
COLON: Final = ": "
SEMICOLON: Final = "; "
AND: Final = " and "
UNDERSTOOD: Final = "understood"
CONFIDENCE: Final = "confidence {percent:.0f} %"

# Turns
STAGES: Final = {
    "wake": "wake",
    "record": "record",
    "endpoint": "endpoint",
    "recognise": "recognise",
    "decide": "decide",
    "plan": "plan",
    "act": "act",
    "speak": "speak",
}
SINCE_SPEECH: Final = "from the end of speech"
SINCE_REQUEST: Final = "from the request"
STAGE_TO_MOTION: Final = "to motion"
STAGE_TO_ANSWER: Final = "to answer"
NO_TURNS: Final = "The time that each stage of a request takes appears here."
LISTENS: Final = "listening…"
RECOGNISES: Final = "recognising…"
NOTHING_SAID: Final = "nothing was said yet"
TO_MOTION: Final = "{milliseconds} to motion"
TO_ANSWER: Final = "{milliseconds} to answer"
NEW_TURNS: Final = "{} new"
BROWSE: Final = "{turn_back} {turn_on} browse · {turn} opens"
TURN_TITLE: Final = "Turn {number} of {count}"
TURN_KEYS: Final = "{turn_back} {turn_on} browse · {unfold} {fold} details · {back} back · {interrupt} stops"
FOLD: Final = "folds"
UNFOLD: Final = "unfolds"
NO_TURN: Final = "There has been no turn yet."
OUTCOMES: Final = {
    "done": "done",
    "failed": "failed",
    "clarify": "asked back",
    "answered": "asked back, answered",
    "declined": "asked back, given up",
    "replaced": "asked back, replaced",
    "withdrawn": "asked back, withdrawn",
    "no_order": "no order",
    "refused": "refused",
    "interrupted": "interrupted",
    "timeout": "timed out",
    "unheard": "not heard",
    "open": "in progress",
}
PART_SOUND: Final = "Sound"
PART_WORDS_HEARD: Final = "Heard"
PART_STAGES: Final = "Stages"
PART_THOUGHTS: Final = "Thought"
PART_ACTIONS: Final = "Done"
PART_ANSWERS: Final = "Said"
PART_END: Final = "End"
PART_REMARKS: Final = "Remarks"
THOUGHTS: Final = {
    "decision": "decided",
    "plan": "planned",
    "question": "asks back",
    "refusal": "refused",
    "rejection": "no plan",
}
UNCLEAR: Final = "unclear: {what}"
IN_JSON: Final = "the plan as JSON"
ASKED: Final = "asked"
LAYERS: Final = {"decision": "decision", "execution": "execution", "vision": "vision"}
AGAIN: Final = "again"
TOKENS: Final = "{prompt} → {reply} tokens"
BROKEN_OFF: Final = "cancelled"
CAME_LATE: Final = "came too late"
TOO_LONG: Final = "cut off"
HEAD: Final = "fixed beginning, {length} characters (SHA-256 {digest}…)"
REPLY: Final = "reply"
NOTHING_CAME: Final = "nothing"
SAYS: Final = "says “{text}”"
HEARD_ALL: Final = "heard"
HEARD_PART: Final = "cut off after “{heard}”"
HEARD_NOTHING: Final = "cut off before the first word"
ON_SCREEN: Final = "shown"
CUT: Final = "interrupted while {state}: {scope}"
CUT_BY: Final = "interrupted while {state}: {scope} ({source})"
LANGUAGE: Final = "language {language}"
DECODED: Final = "recognised in {milliseconds}"
NO_SPEECH_SHARE: Final = "no speech {percent:.0f} %"
LOG_PROBABILITY: Final = "log-probability {value}"
SOUND_FIGURES: Final = "listened for {listened:.1f} s · {speech:.1f} s of speech · peak {peak} dB"
RULE_SPEECH: Final = "━"
RULE_QUIET: Final = "┄"

# Input
PLACEHOLDER: Final = "Press {type} and type what the robot should do"
PLACEHOLDER_EARLY: Final = "Press {type} and type; it waits for {parts} to load"
PLACEHOLDER_TYPING: Final = (
    "Type what the robot should do · {earlier} recalls · {recall} searches · {back} back · {interrupt} stops"
)
PLACEHOLDER_TYPING_EARLY: Final = "Type; it waits for {parts} to load · {back} back · {interrupt} stops"
PLACEHOLDER_FAILED: Final = "Nothing is done: the engine did not start · {leave_now} quits"
PASTED_TOO_LONG: Final = "Too long to be pasted: the line holds {} characters. Nothing of it was taken."
ADDS: Final = "{add} afterwards"
"""Behind the line, while something runs: the key that adds what is written to what waits."""
NO_BORDER: Final = "No border to move there"
NOTHING_TO_ADD: Final = "Nothing is written to be done afterwards"
NO_USE: Final = {
    "queue": "No request waits",
    "turn_back": "There is no turn before",
    "turn_on": "There is no turn after",
    "": "That does nothing now",
}
"""Why what was chosen in the palette does nothing: by where it acts, or by its action; empty: any other."""
PHRASES: Final = (
    "go to the ", "turn left 90 degrees", "turn right 90 degrees", "turn around", "move forward 1 metre",
    "move back 1 metre", "where are you?", "what can you do?", "what do you see?", "look around", "pick up the ",
    "put it on the ", "bring the ", "find the ", "follow me", "come back", "clean up", "remember this place",
    "raise your arm", "wait 5 seconds", "end the task",
    "去", "向左转90度", "向右转90度", "转身", "前进1米", "后退1米", "你在哪里", "你会做什么", "你看到什么", "看看四周",
    "拿起", "跟着我", "回来", "结束任务",
)  # fmt: skip
"""What is often asked for, and suggested before anything was."""

# Log
SOURCES: Final = {
    "session": "session",
    "engine": "engine",
    "console": "console",
    "robot": "robot",
    "microphone": "microphone",
    "recogniser": "recogniser",
    "planner": "planner",
    "model": "model",
    "vision": "vision",
    "camera": "camera",
    "voice": "voice",
    "wake": "wake",
    "wake words": "wake words",
    "ros": "ROS graph",
    "stop": "stop",
    "dispatch": "dispatch",
}
"""Who tells a line of the log; codes of errors are the same in all languages."""

LOG_LEVELS: Final = {"debug": "all", "info": "from information", "warning": "from warnings", "error": "errors only"}
LOG_KEYS: Final = (
    "{log_level} level · {log_part} part · {log_find} search · {log_trouble_before} errors · {log_turn} turn"
)
LOG_ALL: Final = "{log_all} all"
LOG_NOTHING_FITS: Final = "No matches · {log_all} shows all lines"
NEW_LINES: Final = "{} new"
SHOWS_NEW: Final = "{newest} shows them"
LINE_OF_NO_TURN: Final = "This line belongs to no turn."

# Quitting and failing
NOTHING_TO_STOP: Final = "Nothing to stop · {back} goes back"
NOT_PRESSED: Final = "The emergency stop is not pressed"
PRESS_TAKEN_BACK: Final = "Taken back: this console presses no E-STOP"
RELEASED: Final = "The emergency stop is released"
ESTOP_NOT_KNOWN: Final = "E-STOP not known yet: again when the robot is there"
NO_ESTOP: Final = "No emergency stop: the engine did not start"
WITHDRAWN: Final = "Question withdrawn"
WAITING_DROPPED: Final = {False: "{} waiting requests dropped", True: "{} waiting request dropped"}
"""By whether it is one."""
NOTHING_BACK: Final = "Nothing to go back from · {type} goes to the line"
NOT_STARTED: Final = "not started"
QUIT_QUESTION: Final = "A task is running: {leave} again quits, {interrupt} stops it"
QUIT_QUESTION_OPEN: Final = "A request is still open: {leave} again quits, {interrupt} drops it"
ENGINE_STARTING: Final = "The engine is starting…"
ENGINE_FAILED: Final = "The engine did not start"
SESSION_ENDED: Final = "{leave} quits; session ended: {reason}"
ENGINE_SILENT: Final = "The engine is not responding"
ABOUT_SILENT: Final = "It hangs or was paused. The robot has stopped by itself, as it does without an engine."
HINT_SILENT: Final = "{stop} still stops the robot, {leave} quits at once. Other keys wait for the engine."
PAUSED: Final = "Not responding for {seconds:.1f} s"
ROBOT_BACK: Final = "the robot is connected again"
HALTED: Final = "the robot stopped by itself"
MOTION_PAUSED: Final = "“{phrase}” may have been said: the robot pauses"
MOTION_RESUMED: Final = (
    "it was not said: the robot goes on after {seconds:.1f} s (false pause {number} of this session)"
)
PROBLEM_KEYS: Final = "{back} back · {interrupt} stops"
SOMETHING_FAILED: Final = "Something failed"
ASKED_EARLY: Final = "“{}” waits until the engine has started."
CRASH_WRITTEN: Final = "sayso: this is a bug in sayso. Please report it and attach {}"
CRASH_LOST: Final = "sayso: this is a bug in sayso, and its details could not be saved: {}."
CRASH_HINT: Final = "This is a bug in sayso. Please report it with the lines above."

# Help
HELP_TITLE: Final = "Keys"
HELP_BEGIN: Final = "To begin"
HELP_SEARCH: Final = "Type to search: a key, or a part of what it does"
HELP_REST: Final = "Outside the line"
HELP_PANE: Final = "In this pane: {}"
HELP_LINE: Final = "In the line"
ABOUT_LINE_KEYS: Final = {
    "enter": "Send the request; each line that was pasted is one of its own.",
    "up,down": "Recall earlier requests.",
    "tab": "Take what is suggested; in the empty line, go to the panes.",
}
"""Keys of the line that are not the console's."""
HELP_SIGNS: Final = "Signs"
HELP_LEAVE: Final = "{newer} {older} more · {back} back · {interrupt} stops"
HELP_MAP: Final = "While the map has the keyboard"
HELP_QUEUE: Final = "At the actions, while requests wait"
HELP_LOG: Final = "While the log has the keyboard"
HELP_DOCTOR: Final = "On the page of the doctor"
HELP_TURN: Final = "On the page of a turn"
HELP_HAND: Final = "Driving by hand"
HELP_SETTINGS: Final = "On the page of the settings"
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
ONE_LINE: Final = "Type what the robot should do."
"""On the only line, before anything was asked for."""
NO_ROOM_IN_LINE: Final = "That needs the whole console."
TOO_SMALL_KEYS: Final = "{interrupt} still stops the robot · {leave_now} quits"
TOO_SMALL_SHORT: Final = "{columns}×{rows} is too small"
STREAMS: Final = ("standard input", "standard output", "standard error")
NOT_A_TERMINAL: Final = (
    "The console needs a terminal, and {stream} is not one. Use `sayso engine` for programs, or `sayso ask TEXT`."
)
DUMB_TERMINAL: Final = (
    "The console cannot draw on this terminal (TERM is {term}). "
    "Use another one, or `sayso ask TEXT`, which needs only lines of text."
)

# Line to the terminal
LINK_DELAY: Final = "delay {}"
LINK_SILENT: Final = "delay unknown"  # the terminal does not report what it has drawn
LINK_RATES: Final = "{:.1f} kB/s · {:.1f}/s"
FARES: Final = {
    "full": "The connection to this terminal is good again: everything is shown.",
    "spare": "The connection to this terminal is slow ({delay} ms a frame): fewer frames and pictures.",
    "bare": "The connection to this terminal is bad ({delay} ms a frame): no camera, lidar or trail, few frames.",
}
CAMERA_SPARED: Final = "no picture: the connection is bad"
NO_CELL_SIZE: Final = (
    "The camera is drawn with characters: sixel pictures (console.camera_graphics) need to know how many pixels a"
    " character has, and this terminal does not say."
)

# Keys that somebody chose
NO_ACTION: Final = "there is no such action: {}"
DID_YOU_MEAN: Final = "did you mean {}?"
NO_KEY: Final = "no key is given; write one, as in `wake: w`, or leave the line out"
KEY_TAKEN: Final = "{key} is the key of {other}; choose another one, or give {other} another one as well"
KEY_IS_TYPED: Final = (
    "{key} must stay free for typing, as this key also works while you type; choose ctrl and a letter, or f2"
)
KEY_IS_ANOTHER: Final = "terminals cannot tell {key} from {other}; choose another one"
KEY_NOT_PORTABLE: Final = (
    "{key} does not work in every terminal; choose a letter, ctrl and a letter, f1 to f12, or add one: `{key},x`"
)
KEY_UNKNOWN: Final = "{key} is not a key; write a character, a name such as pageup or f2, or ctrl+x"
KEY_MISTAKE: Final = "console.keys.{action}: {message}."
KEY_STAYS: Final = " {action} keeps {key}."

# Palette
PALETTE: Final = "Everything that can be done"
PALETTE_RECENT: Final = "What was asked for before"
PALETTE_LOG: Final = "Log"
PALETTE_PROMPT: Final = "a part of its name"
PALETTE_KEYS: Final = "{send} does it · {back} back · {interrupt} stops"
PALETTE_KEYS_FILL: Final = "{send} fills the line · {back} back · {interrupt} stops"
PASTED_LINES: Final = "Several lines were pasted, and one fits here. Nothing of it was taken."
NOTHING_FITS: Final = "No matches"
NEAREST: Final = "No matches; the nearest:"
ASK_TYPED: Final = "Ask the robot: {}"
KIND_REQUEST: Final = "request"
KIND_PLACE: Final = "place"
KIND_SKILL: Final = "skill"
KIND_RECENT: Final = "earlier"
KIND_MAP: Final = "map"
KIND_QUEUE: Final = "actions"
KIND_LOG: Final = "log"
KIND_DOCTOR: Final = "doctor"
KIND_TURN: Final = "turn"
KIND_HAND: Final = "by hand"
KIND_SETTINGS: Final = "settings"
SETTING_ENTRY: Final = "Setting: {}"
VALUE_ENTRY: Final = "Setting: {} → {}"
KIND_FILE: Final = "file"
SETTINGS_FILE: Final = "Settings are in {}"
SETTINGS_ARE_IN: Final = "Settings are written in {}; `sayso config show` lists them, `sayso config check` tests them."
FORM_KEYS: Final = "{send}: next, at the end: does it · {back} back · {interrupt} stops"
FORM_NUMBER: Final = "{low:g} to {high:g}"
FORM_WORDS: Final = "words"
FORM_NO_NUMBER: Final = "{name} must be a number, such as 1.5"
FORM_RANGE: Final = "{name} must be {low:g} to {high:g} {unit}"
FORM_MISSING: Final = "{name} is missing"
FORM_BECOMES: Final = "› {}"
NOT_KEPT: Final = "Your requests are not saved for later sessions: {}"

# Copying and saving
LINES: Final = ("{} line", "{} lines")
"""So many: one, and any other number."""
COPIED: Final = "to clipboard: {part} · {lines} · {copy} again: {other}"
NOTHING_TO_COPY: Final = "no {part} to copy · {copy} again: {other}"
COPY_PARTS: Final = {
    "turn": "turn",
    "conversation": "conversation",
    "plan": "plan",
    "actions": "actions",
    "log": "log",
}
SAVED: Final = "saved in {folder}"
SAVED_PICTURE: Final = "this session has no log; only the picture is saved: {folder}"

# Doctor
DOCTOR_TITLE: Final = "Doctor"
DOCTOR_KEYS: Final = "{older} {newer} more · {examine} again · {copy} copies · {back} back · {interrupt} stops"
EXAMINING: Final = "◌ {name} … {count} examined so far"
NOTHING_TO_EXAMINE: Final = "The settings are not read yet. Try again in a moment."
COPIED_PAGE: Final = "to clipboard: {lines}"
NOTHING_FOUND_YET: Final = "nothing to copy yet"
FINDINGS: Final = {"ok": "fine", "limited": "limited", "missing": "missing"}
CHECKS: Final = {
    "python": "python",
    "recogniser": "recogniser",
    "voice activity": "voice activity",
    "reader": "reader",
    "large model": "large model",
    "microphone": "microphone",
    "voice": "voice",
    "loudspeaker": "loudspeaker",
    "simulation": "simulation",
    "scheduling": "scheduling",
    "graphics": "graphics",
    "robot": "robot",
    "serial ports": "serial ports",
    "wake module": "wake module",
    "wake words": "wake words",
    "ROS graph": "ROS graph",
    "terminal": "terminal",
    "event log": "event log",
}
"""What is examined, by the name that it has in `sayso doctor`."""

# Devices
DEVICE_GONE: Final = {
    "robot": "The connection to the robot is lost, and the robot has stopped. It is being restarted.",
    "microphone": "The microphone is not connected. Typing still works.",
    "satellite": "The satellite is not connected. Typing still works.",
    "recogniser": "Speech recognition has stopped. Typing still works.",
    "planner": "The planner has stopped, and requests are not understood. {interrupt} still stops the robot.",
    "voice": "The robot has no voice now. Answers are only shown.",
    "camera": "The camera is not connected. Driving still works; finding and grasping do not.",
    "model": "The local model has stopped. Plain commands still work.",
    "service": "A model does not answer. Another one is asked, which may take longer.",
    "wake": "The wake module is not connected · {wake} still wakes",
    "wake words": "Wake words are not heard now · {wake} still wakes",
    "ros": "The ROS graph cannot be reached. Everything else works.",
}
DEVICE_BACK: Final = {
    "robot": "The robot is connected again.",
    "microphone": "The microphone is connected. The robot hears you.",
    "satellite": "The satellite is connected. The robot hears you.",
    "recogniser": "Speech is understood again.",
    "planner": "Requests are understood again.",
    "voice": "Answers are spoken again.",
    "camera": "The camera is connected again.",
    "model": "The local model works again.",
    "service": "The model answers again.",
    "wake": "The wake module is connected again.",
    "wake words": "Wake words are heard again.",
    "ros": "The ROS graph is connected again.",
}
DEVICE_LOOSE: Final = "It was connected or lost {times} times in a few seconds; check the cable."

# Settings
UNKNOWN_THEME: Final = "There is no theme {!r}; the console uses its own."
DID_YOU_MEAN_THEME: Final = "Did you mean {}?"
SETTINGS_TITLE: Final = "Settings"
SETTINGS_KEYS: Final = (
    "{setting_take} changes · {setting_find} search · "
    "{setting_up}{setting_down} {setting_before}{setting_after} look · {setting_default} default · "
    "{back} back · {interrupt} stops"
)
SETTINGS_LINE: Final = "{send} keeps what is written · {back} back · {interrupt} stops"
SETTINGS_FIND: Final = "a part of a name or of what it means · {send}: to the list"
SETTING_GROUPS: Final = {
    "usual": "Usual settings",
    "console": "Console",
    "audio": "Microphone",
    "vad": "Voice activity",
    "endpoint": "End of speech",
    "asr": "Speech recognition",
    "planner": "Planner",
    "models": "Models",
    "voice": "Voice",
    "wake": "Waking",
    "robot": "Robot",
    "session": "Session",
    "ros": "ROS graph",
}
"""The headings of the page, by section."""
SETTINGS_READING: Final = "reading the settings…"
SETTINGS_NOT_READ: Final = "The settings are not read yet, or have mistakes: `sayso config check` lists them."
SETTING_NAMES: Final = {
    "console.theme": "Theme",
    "console.language": "Language",
    "console.fps": "Frames a second",
    "console.camera": "Camera",
    "console.camera_graphics": "Camera graphics",
    "console.motion": "Motion",
    "console.notify": "Notifications",
    "voice.when": "Voice",
    "voice.volume": "Volume",
    "audio.device": "Microphone",
    "wake.words": "Wake words",
    "planner.profile": "Large models",
}
SETTING_ABOUTS: Final = {"console.theme": "The colours of the console. Left and right show others."}
"""What each means, where the schema does not say it, whose words are English."""
SETTING_VALUES: Final = {"en": "en · English", "zh": "zh · 中文", "true": "on", "false": "off"}
"""Values that need a word more."""
NO_VALUE: Final = "not set"
NO_ENTRY: Final = "none"
FROM_DEFAULT: Final = "default"
SETTING_LIVE: Final = "Takes effect at once."
SETTING_RESTART: Final = "Takes effect when sayso is started again."
SETTING_KEPT: Final = "✓ {name}: saved in {file}."
SETTING_BACK: Final = "✓ {name}: as sayso comes with it."
SETTING_OVER: Final = "{origin} overrides the file: {value} stays in force until you remove it."
