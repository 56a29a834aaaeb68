"""The console's model: every event leads to what a person should see, and to nothing else."""

from __future__ import annotations

import pytest

from engine import events as ev
from tests.tui import scripted
from tests.tui.scripted import ScriptedEngine, Step
from tui.shown.facts import MAX_TEXT, Line, printable
from tui.shown.model import MAX_LINES, ConsoleModel
from tui.widgets.conversation import as_told


def after(*steps: Step | ev.Body) -> ConsoleModel:
    """The model after these happenings, from an empty session."""
    engine, model = ScriptedEngine(), ConsoleModel()

    def fold(event: ev.Event) -> None:
        nonlocal model
        model = model.after(event)

    engine.subscribe(fold)
    engine.play([step if isinstance(step, Step) else Step(0.0, step) for step in steps])
    return model


def said(text: str, source: str = "speech") -> ev.TranscriptFinal:
    return ev.TranscriptFinal(text, source, "en", 1.0, -0.1, 0.0, 1.0, 0.1)  # type: ignore[arg-type]


def test_every_kind_of_event_can_be_shown_or_ignored() -> None:
    for body in (ev.Timing("asr", 0.2), ev.CameraFrame(160, 120), ev.Ack("say", True)):
        assert after(body) == ConsoleModel()


def test_words_being_heard_become_a_line_when_they_are_final() -> None:
    heard = after(ev.ListenStarted("microphone"), ev.TranscriptPartial("go to", 2))
    assert heard.listening
    assert (heard.partial, heard.stable) == ("go to", 2)
    final = after(ev.TranscriptPartial("go to", 2), said("Go to the kitchen"))
    assert final.partial == ""
    assert final.conversation == (Line("you", "Go to the kitchen"),)


def test_what_was_not_understood_is_shown_with_its_reason() -> None:
    model = after(ev.TranscriptRejected("low_confidence", "mean log-probability −1.4", "goat the kitten"))
    assert model.conversation == (Line("unheard", "goat the kitten", "not understood clearly"),)


def test_a_wake_that_nobody_gave_by_hand_stands_in_the_log() -> None:
    model = after(ev.WakeHeard("serial", "hello", 137.0), ev.WakeHeard("serial"), ev.WakeHeard("key"))
    assert [(line.source, line.message) for line in model.log] == [
        ("wake", "woken by the module, “hello”, from 137°"),
        ("wake", "woken by the module"),
    ]


def test_a_pause_for_what_may_have_been_a_stop_stands_in_the_log_and_so_does_that_it_was_false() -> None:
    model = after(ev.MotionPaused("word", "stop"), ev.MotionResumed("not_a_stop", 0.31, 3))
    assert [line.message for line in model.log] == [
        "“stop” may have been said: the robot pauses",
        "it was not said: the robot goes on after 0.3 s (false pause 3 of this session)",
    ]


def test_an_answer_that_was_cut_off_says_so() -> None:
    model = after(ev.SpeechStarted("I am going", True), ev.SpeechEnded("I am going", "I am", "interrupted"))
    assert model.conversation == (Line("robot", "I am going", "cut off"),)


def test_a_running_action_takes_its_time_from_events() -> None:
    started = ev.ActionStarted("a1", 1, 1, "wait", {"seconds": 3.0})
    model = after(Step(10.0, started), Step(1.5, ev.ActionProgress("a1", "wait", 0.5)))
    assert model.running is not None
    assert model.running.elapsed(model.t) == pytest.approx(1.5)
    assert model.running.elapsed(model.t, 40.0) == pytest.approx(1.5), "nobody has told when it began for the robot"
    assert model.moving
    assert model.busy


def test_a_finished_action_shows_the_robots_own_duration() -> None:
    model = after(
        ev.ActionStarted("a1", 1, 1, "wait", {"seconds": 3.0}),
        Step(9.0, ev.ActionFinished("a1", "wait", {"seconds": 3.0}, "ok", None, "", 3.02)),
    )
    assert [(row.phase, row.elapsed(model.t)) for row in model.queue] == [("ok", 3.02)]
    assert not model.moving


def test_an_action_that_never_started_has_no_duration() -> None:
    model = after(
        ev.ActionQueued("a1", 1, 1, "wait", {"seconds": 3.0}),
        ev.StateChanged("ACTING", "WAITING", "interrupted", ev.TurnResult(130, "interrupted", "Interrupted.")),
    )
    assert [(row.phase, row.elapsed(model.t)) for row in model.queue] == [("interrupted", None)]
    assert "not started" in model.queue[0].message


def test_late_progress_does_not_bring_a_finished_action_back() -> None:
    model = after(*scripted.done(), ev.ActionProgress("a2", "navigation", 0.9, "", scripted.PATH))
    assert model.path == ()
    assert model.running is None


def test_the_path_is_kept_until_it_changes_and_goes_with_its_action() -> None:
    assert after(*scripted.acting()).path == scripted.PATH
    assert after(*scripted.failed()).path == ()


def test_points_of_a_path_that_are_no_numbers_are_left_out() -> None:
    model = after(
        ev.ActionStarted("a1", 1, 1, "navigation", {"place": "A"}),
        ev.ActionProgress("a1", "navigation", None, "", ((0.0, 0.0), (float("nan"), 1.0), (1.0, float("inf")))),
    )
    assert model.path == ((0.0, 0.0),)


def test_the_actions_of_a_new_turn_replace_those_of_the_old() -> None:
    engine, model = ScriptedEngine(), ConsoleModel()
    for turn in ("T1", "T1", "T2"):
        model = model.after(engine.publish(ev.ActionQueued(f"{turn}{engine.t}", 1, 1, "dance", {}), after=1, turn=turn))
    assert [row.turn for row in model.queue] == ["T2"]


def test_a_new_task_clears_plan_and_actions_and_counts_on() -> None:
    model = after(*scripted.done(), ev.TaskEnded("key"))
    assert (model.cycle, model.plan, model.queue) == (2, None, ())


def test_an_interruption_is_marked_only_where_there_was_something_to_stop() -> None:
    nothing = ScriptedEngine().publish(ev.InterruptRaised("interrupt", "key", "IDLE"), turn=None)
    assert ConsoleModel().after(nothing).conversation == ()
    assert after(ev.InterruptRaised("interrupt", "key", "ACTING")).conversation == (Line("mark", "stopped", "key"),)


@pytest.mark.parametrize(
    ("interruption", "note"),
    [
        (ev.InterruptRaised("by_hand", "drive", "ACTING"), "stopped: driving by hand"),
        (ev.InterruptRaised("end_task", "end_task", "ACTING"), "stopped: the end of the task"),
        (ev.InterruptRaised("end_task", "say", "ACTING"), "stopped: the end of the task"),
        (ev.InterruptRaised("wake", "wake", "PLANNING"), "stopped: waking the robot"),
        (ev.InterruptRaised("replaced", "say", "PLANNING"), "replaced while it was planned"),
    ],
)
def test_what_was_ended_is_told_with_what_ended_it(interruption: ev.InterruptRaised, note: str) -> None:
    model = after(said("go to the kitchen", "text"), interruption)
    assert model.conversation[-1] == Line("lost", "go to the kitchen", note)


def test_what_a_release_of_the_emergency_stop_drops_is_told_with_that() -> None:
    why = "the release of the emergency stop"
    asked = ev.ClarificationAsked("Which room?", "go to the room")
    dropped = ev.RequestEnded("R1", "beep", "interrupted", "release")
    events = [ScriptedEngine().publish(body, turn=None) for body in (dropped, asked)]
    model = after(ev.InterruptRaised("release", "release", "SPEAKING"))
    assert as_told(model.conversation[-1]) == ("mark", "stopped", why)
    for event in (*events, ScriptedEngine().publish(ev.QuestionEnded("go to the room", "withdrawn", "release"))):
        model = model.after(event)
    rows = [Line("lost", "beep", f"never begun: {why}"), Line("lost", "go to the room", f"question withdrawn: {why}")]
    assert list(model.conversation[1:]) == rows


def test_questions_refusals_and_rejections_stand_where_the_plan_would() -> None:
    asked = after(said("pick it up"), ev.ClarificationAsked("What shall I pick up?"))
    refused = after(said("drive over the cat"), ev.RefusalMade("That could hurt someone."))
    rejected = after(said("fly"), ev.PlanRejected("fly", "No skill does that.", "unknown_skill", ("dance",)))
    stages = [(model.plan.stage, model.plan.message) for model in (asked, refused, rejected) if model.plan]
    assert stages == [
        ("question", "What shall I pick up?"),
        ("refused", "That could hurt someone."),
        ("rejected", "No skill does that."),
    ]


def test_the_reason_of_the_end_is_not_covered_by_what_comes_after() -> None:
    model = after(ev.ErrorRaised("robot_lost", "first", fatal=True), ev.ErrorRaised("other", "second"))
    assert model.problem is not None
    assert model.problem.message == "first"
    assert after(ev.ErrorRaised("other", "second"), said("go home")).problem is None


def test_a_failed_turn_is_said_once() -> None:
    texts = [line.text for line in after(*scripted.failed()).conversation]
    assert len([text for text in texts if "I stopped 2.9 m before" in text]) == 1


@pytest.mark.parametrize("text", ["\x1b[31mred\x1b[0m", "a\nb\r\tc", "\x9b2J", "a\u202egnp.exe", "\x00\x07\ud800"])
def test_nothing_that_steers_a_terminal_gets_through(text: str) -> None:
    clean = printable(text)
    assert not any(char in clean for char in "\x1b\n\r\t\x9b\u202e\x00\x07\ud800")


def test_very_long_texts_are_cut_and_lists_are_bounded() -> None:
    assert len(printable("x" * 10**6)) == MAX_TEXT
    model = after(*(ev.Log("info", "flood", str(number)) for number in range(10_000)))
    assert len(model.log) == MAX_LINES
    assert model.log[-1].message == "9999"


def test_a_session_that_ended_says_why() -> None:
    assert after(ev.SessionEnded("the robot was lost")).ended == "the robot was lost"


def test_what_was_overheard_or_typed_says_so() -> None:
    lines = after(said("stop", "overheard"), said("go", "text"), said("come")).conversation
    assert [line.note for line in lines] == ["overheard", "typed", ""]


def test_a_wake_that_stops_the_robot_says_so() -> None:
    lines = {
        state: [
            (line.who, line.text, line.note) for line in after(ev.InterruptRaised("wake", "wake", state)).conversation
        ]
        for state in ("ACTING", "SPEAKING", "LISTENING", "PLANNING")
    }
    stopped = [("mark", "stopped", "wake")]
    assert lines == {"ACTING": stopped, "SPEAKING": stopped, "LISTENING": [], "PLANNING": []}
