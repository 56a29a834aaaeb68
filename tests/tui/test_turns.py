"""What is known of a turn, from nothing but its events: stages that add up, however they come to their end."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from engine import events as ev
from tests.tui import conversation as talk
from tests.tui.conversation import Scene
from tests.tui.scripted import ScriptedEngine, Step
from tui.shown.model import ConsoleModel
from tui.shown.turn import STAGES, Asked, Thought, Turn
from tui.shown.turns import MAX_CALLS, MAX_SAMPLES, MAX_TURNS, Turns


def after(*scenes: Scene) -> Turns:
    """What is known once these scenes were played."""
    engine, turns = ScriptedEngine(), Turns()

    def fold(event: ev.Event) -> None:
        nonlocal turns
        turns = turns.after(event)

    engine.subscribe(fold)
    talk.play(engine, scenes)
    return turns


def turn_of(*steps: Step | tuple[Step, ...]) -> Turn:
    """The one turn of these happenings."""
    flat = [step for part in steps for step in (part if isinstance(part, tuple) else (part,))]
    (turn,) = after(Scene("T1", 2, tuple(flat))).kept
    return turn


def milliseconds(turn: Turn) -> dict[str, int]:
    """How long each stage of an ended turn took."""
    assert turn.ended is not None
    return {stage: round(1000 * turn.seconds(stage, turn.ended)) for stage in STAGES if turn.of(stage)}


def until_acting() -> tuple[Step, ...]:
    """A typed request, up to the moment in which its action has started."""
    return (
        Step(1.0, talk.typed("go to the kitchen")),
        Step(0.01, ev.StateChanged("WAITING", "PLANNING", "a request was understood")),
        Step(0.0, talk.PLAN),
        Step(0.0, ev.StateChanged("PLANNING", "ACTING", "1 actions")),
        Step(0.0, ev.ActionQueued("a1", 1, 2, "navigation", talk.KITCHEN)),
        Step(0.0, ev.ActionQueued("a2", 2, 2, "beep", {})),
        Step(0.0, ev.ActionStarted("a1", 1, 2, "navigation", talk.KITCHEN)),
    )


def test_a_spoken_turn_has_all_its_stages_with_their_milliseconds() -> None:
    (turn,) = after(talk.SPOKEN).kept
    assert turn.text == "Go to the kitchen."
    assert milliseconds(turn) == {
        "wake": 4, "record": 2400, "endpoint": 576, "recognise": 310, "plan": 3, "act": 5350, "speak": 2352,
    }  # fmt: skip


def test_the_stages_before_an_action_add_up_to_the_time_until_it_starts() -> None:
    (turn,) = after(talk.BY_MODEL).kept
    before = sum(turn.seconds(stage, 0.0) for stage in STAGES if stage not in ("act", "speak"))
    assert before == pytest.approx(turn.of("act")[0].began - turn.began, abs=0.01)


def test_the_wait_counts_from_the_end_of_speech_and_not_from_the_end_of_the_recording() -> None:
    (turn,) = after(talk.SPOKEN).kept
    assert turn.to_motion is not None
    assert turn.to_answer is not None
    assert turn.to_motion == pytest.approx(0.576 + 0.31 + 0.003 + 0.002 + 0.05, abs=0.001)
    assert turn.to_answer < turn.to_motion


def test_the_slow_stage_is_the_one_that_was_waited_for_longest_and_never_what_was_asked_for() -> None:
    turns = after(talk.SPOKEN, talk.UNHEARD, talk.BY_MODEL).kept
    assert [turn.slowest(turn.ended or 0.0) for turn in turns] == ["endpoint", "recognise", "plan"]
    typed = turn_of(until_acting(), talk.over("ACTING", "done", "", after=30.0))
    assert typed.slowest(typed.ended or 0.0) is None


def test_a_typed_turn_begins_when_it_is_typed_and_has_no_sound() -> None:
    turn = turn_of(until_acting(), talk.driving(0.05), talk.over("ACTING", "done", "", after=1.0))
    assert list(milliseconds(turn)) == ["plan", "act"]
    assert turn.asked == turn.began
    assert turn.to_motion == pytest.approx(0.06)
    assert turn.voice is None


def test_what_was_refused_or_asked_back_is_told_with_its_reason() -> None:
    refused, asked = after(talk.REFUSED, talk.ASKED_BACK).kept
    assert [(thought.kind, thought.text) for thought in refused.thoughts if isinstance(thought, Thought)] == [
        ("refusal", "I won't do that: something could get broken.")
    ]
    (question,) = asked.thoughts
    assert isinstance(question, Thought)
    assert (question.kind, question.text, question.source) == ("question", "Which one?", "target")
    assert [turn.result.outcome for turn in (refused, asked) if turn.result is not None] == ["refused", "clarify"]


def test_a_turn_asks_back_no_more_once_its_question_has_ended() -> None:
    steps = talk.ASKED_BACK.steps
    again = Scene("T4", 5, (*steps, Step(0.1, ev.QuestionEnded("pick up the thing", "withdrawn"))))
    assert [turn.outcome for turn in after(talk.ASKED_BACK).kept] == ["clarify"]
    assert [turn.outcome for turn in after(talk.ASKED_BACK, again).kept] == ["withdrawn", "withdrawn"], "put twice"
    no_order = Step(0.0, ev.ClarificationAsked("What shall I do?", "don't", leaves_open=False))
    assert turn_of(steps[:-1], no_order, steps[-1]).outcome == "no_order"


def test_a_turn_in_which_nobody_spoke_ends_with_its_recording() -> None:
    (turn,) = after(talk.NOBODY).kept
    assert list(milliseconds(turn)) == ["wake", "record"]
    assert turn.of("record")[0].outcome == "failed"
    assert turn.voice is None
    assert (turn.text, turn.asked) == ("", None)


def test_what_was_not_understood_stands_there_with_what_it_sounded_like() -> None:
    (turn,) = after(talk.UNHEARD).kept
    assert turn.text == "goat the kitten"
    assert turn.unheard is not None
    assert turn.unheard.reason == "low_confidence"
    assert turn.of("recognise")[0].outcome == "failed"


def test_an_interruption_ends_what_runs_and_says_what_never_started() -> None:
    (turn,) = after(talk.BY_MODEL).kept
    assert turn.cut is not None
    assert (turn.cut.scope, turn.cut.source, turn.cut.state) == ("interrupt", "key", "ACTING")
    assert [(action.phase, action.duration_s) for action in turn.actions] == [
        ("ok", 6.9), ("interrupted", 2.8), ("interrupted", None),
    ]  # fmt: skip
    assert [span.outcome for span in turn.of("act")] == ["ok", "interrupted"]
    assert (turn.answers[-1].heard, turn.answers[-1].outcome) == ("On my", "interrupted")


def test_acting_and_speaking_side_by_side_are_two_stages_that_overlap() -> None:
    (turn,) = after(talk.SPOKEN).kept
    (act,), (speak, last) = turn.of("act"), turn.of("speak")
    assert act.ended is not None
    assert speak.ended is not None
    assert act.began < speak.ended < act.ended <= last.began


def test_actions_side_by_side_count_once() -> None:
    turn = turn_of(
        until_acting(),
        Step(1.0, ev.ActionStarted("a2", 2, 2, "beep", {})),
        Step(1.0, ev.ActionFinished("a2", "beep", {}, "ok", None, "", 1.0)),
        Step(1.0, ev.ActionFinished("a1", "navigation", talk.KITCHEN, "ok", None, "", 3.0)),
        talk.over("ACTING", "done", ""),
    )
    assert milliseconds(turn)["act"] == 3000


def test_a_second_plan_begins_where_the_feedback_ended() -> None:
    turn = turn_of(
        until_acting(),
        Step(2.0, ev.ActionFinished("a1", "navigation", talk.KITCHEN, "failed", "path_blocked", "Blocked.", 2.0)),
        Step(0.0, ev.StateChanged("ACTING", "FEEDBACK", "not done")),
        talk.answer("Blocked.", 0.5),
        Step(0.7, ev.StateChanged("FEEDBACK", "PLANNING", "a request was understood")),
        Step(0.1, talk.PLAN),
        talk.over("PLANNING", "failed", "", 1),
    )
    _, second = turn.of("plan")
    assert second.ended is not None
    assert second.ended - second.began == pytest.approx(0.8)
    assert len(turn.thoughts) == 2


def test_what_comes_after_the_end_of_a_turn_is_a_remark_and_no_stage_of_any() -> None:
    late = Scene(
        "T1",
        2,
        (
            Step(0.1, ev.TranscriptRejected("late", "The transcription was cancelled.", "go home")),
            Step(0.1, ev.PlanRejected("go home", "A plan came too late. It was dropped.", "late")),
            Step(0.1, talk.said("go home")),
            Step(0.1, ev.StateChanged("WAITING", "PLANNING", "late")),
            Step(0.1, ev.ActionStarted("a9", 1, 1, "beep", {})),
            Step(0.1, ev.SpeechStarted("Too late.", True)),
        ),
    )
    before, turns = after(talk.SPOKEN, talk.REFUSED), after(talk.SPOKEN, talk.REFUSED, late)
    assert turns.kept[0].remarks == (
        "The transcription was cancelled. go home",
        "A plan came too late. It was dropped.",
        "transcript.final: go home",
    )
    assert turns.kept[0].spans == before.kept[0].spans
    assert turns.kept[0].answers == before.kept[0].answers
    assert turns.kept[1] == before.kept[1]


def test_nothing_begins_in_a_turn_that_is_cut() -> None:
    turn = turn_of(
        until_acting(),
        Step(0.5, ev.InterruptRaised("stop", "say", "ACTING")),
        Step(0.1, ev.ActionStarted("a2", 2, 2, "beep", {})),
        Step(0.1, ev.ActionFinished("a1", "navigation", talk.KITCHEN, "interrupted", "cancelled", "", 0.7)),
        talk.over("ACTING", "interrupted", "Interrupted.", 130),
    )
    assert [span.of for span in turn.of("act")] == ["a1"]


def test_ends_without_a_beginning_are_harmless() -> None:
    orphans = Scene(
        "T1",
        2,
        (
            Step(0.0, ev.ListenEnded("silence", 1.0, 1.0)),
            Step(0.0, ev.SpeechEnded("Yes.", "Yes.", "ok")),
            Step(0.0, ev.ActionFinished("a1", "beep", {}, "ok", None, "", 0.2)),
            Step(0.0, ev.ListenLevel(-20.0, -10.0, 0.9, True)),
            talk.over("ACTING", "done", ""),
        ),
    )
    assert after(orphans).kept == ()
    turn = turn_of(Step(0.0, talk.typed("beep")), *orphans.steps)
    assert [(action.call, action.phase) for action in turn.actions] == [("beep()", "ok")]
    assert turn.samples == ()


def test_a_wake_belongs_to_the_turn_that_listens_and_to_no_later_one() -> None:
    by_word, typed = after(talk.ASKED_BACK, talk.REFUSED).kept
    assert (by_word.woken, typed.woken) == ("word", "")
    assert by_word.began < by_word.of("record")[0].began


def test_a_wake_while_listening_ends_one_turn_and_begins_another() -> None:
    first = Scene(
        "T1",
        2,
        (
            *talk.woken(),
            *talk.speech(0.5, before=0.2, silence=0.0),
            Step(0.0, ev.WakeHeard("key")),
            Step(0.0, ev.InterruptRaised("wake", "wake", "LISTENING")),
            Step(0.0, ev.ListenEnded("cancelled", 0.0, 0.0)),
            talk.over("LISTENING", "interrupted", "Woken.", 130),
        ),
    )
    cut, again = after(first, Scene("T2", 3, talk.woken(restarted=True)[1:])).kept
    assert (cut.of("record")[0].outcome, cut.open) == ("interrupted", False)
    assert (again.woken, again.open) == ("key", True)


def test_the_end_of_the_session_ends_every_turn() -> None:
    turns = after(Scene("T1", 2, (*until_acting(), Step(0.5, ev.SessionEnded("asked to")))))
    assert turns.open is None
    assert turns.kept[0].of("act")[0].ended is not None


def test_old_turns_and_long_recordings_are_forgotten_but_counted() -> None:
    many = [Scene(f"T{n}", n, (Step(0.1, talk.typed(str(n))), talk.over("PLANNING", "done", ""))) for n in range(100)]
    turns = after(*many)
    assert (len(turns.kept), turns.count, turns.kept[-1].number) == (MAX_TURNS, 100, 100)
    long = turn_of(*talk.woken(), *talk.speech(80.0, before=0.0, silence=0.0))
    assert len(long.samples) == MAX_SAMPLES


def test_nothing_in_a_turn_can_steer_a_terminal() -> None:
    evil = "a\x1b[2Jb\u202e"
    turn = turn_of(
        Step(0.0, talk.typed(evil)),
        Step(0.0, ev.PlanMade(evil, (evil,), (ev.ActionView(evil, {evil: evil}),), evil, "local")),
        Step(0.0, ev.PlanRejected(evil, evil, evil, (evil,))),
        Step(0.0, ev.ActionFinished("a1", evil, {evil: evil}, "failed", evil, evil, 0.1, {evil: evil})),
        Step(0.0, ev.SpeechStarted(evil, True)),
        Step(0.0, ev.SpeechEnded(evil, evil, "ok")),
        Step(0.0, ev.ErrorRaised(evil, evil)),
        talk.over("SPEAKING", "failed", evil, 1),
    )
    assert not any(sign in repr(turn) for sign in (r"\x1b", r"\u202e"))


def test_calls_of_models_stand_among_the_thoughts_in_the_order_in_which_they_ended() -> None:
    (turn,) = after(talk.BY_MODEL).kept
    kinds = [thought.call.layer if isinstance(thought, Asked) else thought.kind for thought in turn.thoughts]
    assert kinds == ["decision", "decision", "execution", "execution", "plan"]
    assert not any(thought.late for thought in turn.thoughts if isinstance(thought, Asked))


def test_a_call_that_ends_when_its_turn_is_over_belongs_to_it_and_changes_nothing_else() -> None:
    stopped = (
        Step(0.0, talk.typed("bring me something")),
        Step(0.1, talk.interrupted("PLANNING")),
        talk.over("PLANNING", "interrupted", "Interrupted.", 130),
    )
    without, turn = turn_of(*stopped), turn_of(*stopped, Step(3.0, talk.ACTIONS))
    (late,) = turn.thoughts
    assert isinstance(late, Asked)
    assert late.late
    assert replace(turn, thoughts=()) == without


def test_of_many_calls_the_newest_are_kept_and_everything_else_that_was_thought() -> None:
    calls = [msgspec.structs.replace(talk.ACTIONS, reply=str(number)) for number in range(MAX_CALLS + 3)]
    turn = turn_of(Step(0.0, talk.typed("go")), Step(0.0, talk.PLAN), *(Step(0.0, call) for call in calls))
    plan, *asked = turn.thoughts
    assert isinstance(plan, Thought)
    kept = [thought.call.reply for thought in asked if isinstance(thought, Asked)]
    assert kept == [call.reply for call in calls[3:]]


def test_what_models_were_told_and_wrote_keeps_its_lines_and_nothing_that_disturbs_a_terminal() -> None:
    text = "one\n\x1b[2Jtwo\u202e\n\n" + "x" * 4100
    call = msgspec.structs.replace(
        talk.ACTIONS, reply=text, error=text, model=text, messages=(ev.MessageView("user", text),)
    )
    (asked,) = turn_of(Step(0.0, talk.typed("go")), Step(0.0, call)).thoughts
    assert isinstance(asked, Asked)
    for kept in (asked.call.reply, asked.call.messages[0].text):
        assert kept.splitlines() == ["one", " [2Jtwo ", "", "x" * 2000, "x" * 2000, "x" * 100]
    assert not any(sign in repr(asked) for sign in (r"\x1b", r"\u202e"))


BODIES = st.sampled_from(
    [step.body for scene in talk.ALL for step in scene.steps]
    + [ev.SessionEnded("asked to"), ev.Timing("paused", 1.0), ev.Log("warning", "planner", "slow")]
)
HAPPENINGS = st.lists(
    st.tuples(BODIES, st.sampled_from(["T1", "T2", "T3", None]), st.integers(1, 5), st.floats(-2.0, 5.0)), max_size=60
)


@given(HAPPENINGS)
def test_whatever_comes_in_whatever_order_stages_never_run_backwards_or_on_after_the_end(
    happenings: Sequence[tuple[ev.Body, str | None, int, float]],
) -> None:
    turns, model, t = Turns(), ConsoleModel(), 10.0
    for seq, (body, turn, epoch, step) in enumerate(happenings, 1):
        t = max(0.0, t + step)
        event = ev.Event(seq, t, "", "S1", turn, epoch, body)
        turns, model = turns.after(event), model.after(event)
    assert model.turns == turns
    assert [turn.number for turn in turns.kept] == list(range(1, turns.count + 1))
    assert all(not turn.open for turn in turns.kept[:-1])
    for turn in turns.kept:
        assert all(span.ended is None or turn.began <= span.began <= span.ended for span in turn.spans)
        assert turn.open or all(span.ended is not None for span in turn.spans)
        assert len({span.of for span in turn.of("act")}) == len(turn.of("act"))
        assert all(turn.seconds(stage, t) >= 0.0 for stage in STAGES)


def test_the_turns_of_a_real_session_are_told_from_its_log() -> None:
    """Typed and demo requests to ``sayso engine --source demo``, with interruptions; without progress and poses."""
    model = ConsoleModel()
    for line in (Path(__file__).parent / "sessions" / "several_turns.jsonl").read_text().splitlines():
        model = model.after(ev.from_json(line))
    told = [
        (turn.text, turn.result.outcome, turn.slowest(turn.ended or 0.0), list(milliseconds(turn)))
        for turn in model.turns.kept
        if turn.result is not None
    ]
    heard = ["wake", "record", "endpoint", "recognise", "plan", "act", "speak"]
    assert told == [
        ("turn left 90 degrees and beep twice", "done", "plan", ["plan", "act", "speak"]),  # the robot still started
        ("Go to the kitchen.", "interrupted", "endpoint", heard),
        ("turn left 90 degrees", "done", "endpoint", heard),
        ("", "interrupted", None, ["wake", "record"]),
        ("drive into the wall as fast as you can", "refused", None, ["plan", "speak"]),
        ("pick up the thing", "interrupted", "plan", ["plan"]),
        ("go to the study", "interrupted", None, ["plan", "act", "speak"]),
        ("", "interrupted", None, ["wake", "record"]),
        ("go to the bedroom, then turn around.", "interrupted", "endpoint", heard),
    ]
    waits = [turn.to_motion for turn in model.turns.kept if turn.heard is not None and turn.heard.source == "speech"]
    assert waits == [pytest.approx(0.99, abs=0.1), pytest.approx(0.87, abs=0.1), pytest.approx(0.91, abs=0.1)]


def test_a_heading_that_an_action_has_found_is_told_in_degrees() -> None:
    pose = {"x": 1.5, "y": -2.0, "yaw": -1.5707963}
    ended = ev.ActionFinished("a1", "navigation", talk.KITCHEN, "ok", None, "I am there.", 3.0, pose)
    turn = turn_of(*until_acting(), Step(1.0, ended))
    assert turn.actions[0].data == "x 1.5, y -2, heading 270°"


def test_what_an_action_found_out_is_rounded_for_people() -> None:
    found = {"x": 8.65e-06, "y": -1e-9, "far": 1234567.891, "pulse": 0.125, "count": 3}
    body = ev.ActionFinished("A1", "navigation", {}, "ok", None, "", 1.0, found)
    turn = turn_of(*until_acting(), Step(0.5, body))
    assert turn.actions[-1].data == "x 0, y 0, far 1234567.89, pulse 0.12, count 3"
