"""Nothing that is kept grows without end: not on the screen, not in a task that nobody ends, not in what was seen."""

from __future__ import annotations

from engine import events as ev
from engine.perception.memory import MOST, WorldMemory
from engine.session.history import MAX_ENTRIES, Said, TaskCycle
from tests.unit.test_memory import a, saw
from tui.shown.devices import Devices
from tui.shown.facts import MAX_TEXT
from tui.shown.model import MAX_LINES, MAX_ROWS, MAX_TRAIL, ConsoleModel
from tui.shown.trace import MAX_TRACE
from tui.shown.turns import MAX_CALLS, MAX_PARTS, MAX_SAMPLES, MAX_TURNS

LONG = "word " * 2000


def bodies(number: int) -> list[ev.Body]:
    """More of everything than a turn may have."""
    args = {"place": "A"}
    return [
        ev.ListenStarted("microphone"),
        ev.ListenLevel(-20.0, -12.0, 0.9, True),
        ev.TranscriptPartial(LONG, 1),
        ev.TranscriptFinal(LONG, "text", "en", 1.0, 0.0, 0.0, 0.0, 0.0),
        ev.ModelAsked("execution", "local", 1, "", 0, (ev.MessageView("user", LONG),), LONG, 1.0),
        ev.PlanMade(LONG, (LONG,), (ev.ActionView("navigation", args),), LONG, "local"),
        ev.ActionQueued(f"a{number}", 1, 1, "navigation", args),
        ev.ActionStarted(f"a{number}", 1, 1, "navigation", args),
        ev.ActionProgress(f"a{number}", "navigation", 0.5, LONG, ((0.0, 0.0),)),
        ev.RobotStateView(0.0, ev.PoseView(number / 5, 0, 0), ev.TwistView(1, 0, 0), (0.0,) * 5, 1.0, True, None),
        ev.Log("warning", "robot", LONG),
        ev.ErrorRaised("odd", LONG),
        ev.SpeechStarted(LONG, True),
        ev.SpeechEnded(LONG, LONG, "ok"),
    ]


def fed(count: int, turns: int) -> ConsoleModel:
    """The console once so many events of each kind have come, in so many turns."""
    model, seq = ConsoleModel(), 0
    for number in range(count):
        for body in bodies(number):
            seq += 1
            model = model.after(ev.Event(seq, seq / 10, "", "S", f"T{number * turns // count}", 1, body))
    return model


def test_what_the_console_keeps_of_one_endless_turn_has_an_end() -> None:
    model = fed(MAX_SAMPLES + 100, 1)
    [turn] = model.turns.kept
    assert len(turn.samples) == MAX_SAMPLES
    assert len(turn.thoughts) <= MAX_PARTS
    assert sum(1 for thought in turn.thoughts if type(thought).__name__ == "Asked") == MAX_CALLS
    assert max(map(len, (turn.spans, turn.actions, turn.answers, turn.remarks))) <= MAX_PARTS
    assert len(model.queue) == MAX_ROWS
    assert len(model.trail) == MAX_TRAIL
    assert len(model.conversation) == len(model.log) == MAX_LINES
    assert len(model.trace.items) == MAX_TRACE
    assert len(model.partial) <= MAX_TEXT
    assert max(len(line.text) for line in model.conversation) == MAX_TEXT


def test_what_the_console_keeps_of_many_turns_has_an_end() -> None:
    model = fed(3 * MAX_TURNS, 3 * MAX_TURNS)
    assert len(model.turns.kept) == MAX_TURNS
    assert model.turns.count == 3 * MAX_TURNS


def test_a_task_that_nobody_ends_keeps_its_newest_entries() -> None:
    cycle = TaskCycle(1)
    for number in range(MAX_ENTRIES + 50):
        cycle.entries.append(Said("T", f"request {number}"))
    assert len(cycle.happened()) == len(cycle.as_json()) == MAX_ENTRIES
    assert cycle.last_said == f"request {MAX_ENTRIES + 49}"


def test_of_what_was_seen_the_newest_is_remembered() -> None:
    memory = WorldMemory()
    for number in range(MOST + 20):
        saw(memory, a("red box", 1.0 + number), t=float(number), depth=0.5)
    things = memory.things
    assert len(things) == MOST
    assert min(thing.seen_at for thing in things) == 20.0


def test_news_of_services_take_no_room() -> None:
    devices = Devices()
    for number in range(1000):
        devices.hear(ev.Log("warning", "model", f"{number} The platform p{number} is asked instead."), float(number))
    assert len(devices._known) == 1
