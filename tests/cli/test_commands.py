"""The contract with outside tools: stdout is data, events have one form, exit codes mean what they say."""

from __future__ import annotations

import io
import json
import os
import re
import subprocess
import sys
import wave
from base64 import b64encode
from pathlib import Path

import numpy as np
import pytest
import soundfile
import soxr

from engine.errors import ExitCode
from engine.events import from_json
from engine.plan import Plan
from engine.planner.planner import NoPlan, Planner, PlanRequest
from tests.e2e.sayso import SHARED, command, environment, events, sayso
from tui.cli import main

needs_recordings = pytest.mark.skipif(not SHARED.is_dir(), reason="the recordings in ../shared/data are not here")


def test_ask_plans_drives_and_reports(tmp_path: Path) -> None:
    done = sayso("ask", "--json", "go to the kitchen then turn left 90 degrees", state=tmp_path)
    assert done.returncode == ExitCode.DONE, done.stderr
    plan = events(done, "plan.made")[0]["body"]
    assert [action["name"] for action in plan["actions"]] == ["navigation", "move_left"]
    assert plan["source"] == "reader"
    finished = [event["body"] for event in events(done, "action.finished")]
    assert [(body["name"], body["outcome"]) for body in finished] == [("navigation", "ok"), ("move_left", "ok")]
    last = events(done, "robot.state")[-1]["body"]
    assert abs(last["pose"]["x"] - 0.2) < 0.05
    assert abs(last["pose"]["y"] - 2.0) < 0.05


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("raise your arm, then beep", ["▸ 1/2 Raise the arm", "✓ Raise the arm", "▸ 2/2 Beep", "✓ Beep"]),
        ("举起手臂", ["▸ 1/1 举起手臂", "✓ 举起手臂"]),
        ("go forward 20 metres", ["▸ 1/1 Drive 20 metres forward", "✗ Drive 20 metres forward: I moved"]),
    ],
)
def test_ask_tells_people_in_words_what_is_done(text: str, told: list[str], tmp_path: Path) -> None:
    done = sayso("ask", text, state=tmp_path)
    lines = [line for line in done.stderr.decode().splitlines() if line[:1] in "▸✓✗"]
    assert all(line.startswith(start) for line, start in zip(lines, told, strict=True)), lines
    assert "(" not in "".join(lines)


@pytest.mark.parametrize("terminal", [True, False])
def test_plan_prints_the_calls_and_on_a_terminal_the_words_beside_them(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *, terminal: bool
) -> None:
    monkeypatch.setattr(sys.stdout, "isatty", lambda: terminal)
    assert main(["plan", "raise your arm, then go to the kitchen"]) == ExitCode.DONE
    words = ("Raise the arm.", "Go to the kitchen.") if terminal else ("", "")
    calls = capsys.readouterr().out.splitlines()
    assert calls == [
        f"{call}  {told}".rstrip() for call, told in zip(("arm_up()     ", "navigation(A)"), words, strict=True)
    ]


def test_a_chinese_request_is_answered_in_chinese_and_recorded_in_english(tmp_path: Path) -> None:
    done = sayso("ask", "--json", "去厨房，然后左转九十度", state=tmp_path)
    assert done.returncode == ExitCode.DONE, done.stderr
    spoken = [event["body"]["text"] for event in events(done, "speech.started")]
    assert spoken == ["去厨房，然后左转90度。", "我到厨房了。我向左转了90度。"]
    finished = [event["body"]["message"] for event in events(done, "action.finished")]
    assert finished == ["I am at the kitchen.", "Turned 90° left."]


def test_every_line_is_an_event_in_order(tmp_path: Path) -> None:
    done = sayso("ask", "--json", "go forward 30 cm", state=tmp_path)
    read = [from_json(line) for line in done.stdout.splitlines()]
    assert [event.seq for event in read] == list(range(1, len(read) + 1))
    assert read[0].kind == "session.started"
    assert read[-1].kind == "session.ended"


def test_the_log_in_the_state_folder_says_the_same(tmp_path: Path) -> None:
    done = sayso("ask", "--json", "beep", state=tmp_path)
    (log,) = (tmp_path / "logs").glob("*.jsonl")
    assert log.read_bytes().splitlines() == done.stdout.splitlines()


@pytest.mark.parametrize(
    ("said", "code", "kind"),
    [
        ("go to the moon", ExitCode.FAILED, "plan.rejected"),
        ("sing me a song", ExitCode.FAILED, "plan.rejected"),
        ("go forward", ExitCode.CLARIFY, "clarification.asked"),
        ("go forward 5 kilometres", ExitCode.REFUSED, "refusal.made"),
    ],
)
def test_what_cannot_be_done_moves_nothing(tmp_path: Path, said: str, code: ExitCode, kind: str) -> None:
    done = sayso("ask", "--json", said, state=tmp_path)
    assert done.returncode == code
    assert events(done, kind)
    assert not events(done, "action.started")


def test_an_unknown_place_is_told_with_those_that_exist(tmp_path: Path) -> None:
    done = sayso("ask", "go to the moon", state=tmp_path)
    assert done.returncode == ExitCode.FAILED
    assert b"kitchen" in done.stderr
    assert done.stdout == b""


def test_a_wall_ends_a_drive_that_is_reported_truthfully(tmp_path: Path) -> None:
    done = sayso("ask", "--json", "go forward ten metres", state=tmp_path)
    assert done.returncode == ExitCode.FAILED
    (finished,) = (event["body"] for event in events(done, "action.finished"))
    assert (finished["outcome"], finished["error_code"]) == ("failed", "path_blocked")
    driven = events(done, "robot.state")[-1]["body"]["pose"]["x"]
    assert finished["data"]["moved"] == pytest.approx(driven, abs=0.02)
    assert f"{driven:.1f}" in finished["message"]


def test_several_requests_from_stdin_share_one_session(tmp_path: Path) -> None:
    done = sayso("ask", "--json", "-", state=tmp_path, stdin=b"go forward 50 cm\n\nfly away\nwhere are you\n")
    assert done.returncode == ExitCode.FAILED  # of the first that was not done
    assert len(events(done, "session.started")) == 1
    results = [event["body"]["result"] for event in events(done, "state.changed") if event["body"]["result"]]
    assert [result["exit_code"] for result in results] == [0, 1, 0]
    assert "x 0.50 m" in results[2]["message"]


def test_plan_moves_nothing_and_starts_no_robot(tmp_path: Path) -> None:
    done = sayso("plan", "--json", "move forward half a metre, then 20 centimetres to the left", state=tmp_path)
    assert done.returncode == ExitCode.DONE
    read, made = events(done)
    assert (read["kind"], made["kind"]) == ("meaning.read", "plan.made")
    assert [action["name"] for action in made["body"]["actions"]] == ["move_forward", "move_sideways"]
    assert [action["args"]["distance"] for action in made["body"]["actions"]] == [0.5, 0.2]


def test_plan_reads_one_request_a_line(tmp_path: Path) -> None:
    done = sayso("plan", "--json", "-", state=tmp_path, stdin=b"beep\ngo to the moon\nturn around\n")
    assert done.returncode == ExitCode.FAILED
    kinds = [event["kind"] for event in events(done) if event["kind"] != "meaning.read"]
    assert kinds == ["plan.made", "plan.rejected", "plan.made"]


SPOILT = (b"\xff\xfe", b"\xed\xa0\x80", b"go " * 1000, b"move forward " + b"9" * 400 + b" metres")
"""Lines that are no requests, or none that make sense."""


def test_a_line_that_is_no_request_costs_a_batch_nothing_but_its_own_result(tmp_path: Path) -> None:
    lines = b"\n".join((b"beep", *SPOILT, b"turn around\r\n"))
    done = sayso("plan", "--json", "-", state=tmp_path, stdin=lines)
    kinds = [event["kind"] for event in events(done) if event["kind"] != "meaning.read"]
    assert kinds == ["plan.made", *["plan.rejected"] * len(SPOILT), "plan.made"]
    assert [event["body"]["code"] for event in events(done, "plan.rejected")][:3] == ["usage"] * 3
    assert "Line 2" in events(done, "plan.rejected")[0]["body"]["reason"]
    assert done.returncode == ExitCode.USAGE  # of the first line without a plan
    assert done.stderr == b""


def test_a_line_that_is_no_request_is_told_and_the_others_are_done(tmp_path: Path) -> None:
    lines = b"\n".join((b"beep", *SPOILT, b"wait 1 s\n"))
    done = sayso("ask", "--json", "-", state=tmp_path, stdin=lines)
    assert [action["body"]["name"] for action in events(done, "action.finished")] == ["beep", "wait"]
    refused = [ack["body"] for ack in events(done, "ack") if not ack["body"]["ok"]]
    assert [ack["do"] for ack in refused] == ["say"] * 3
    assert done.returncode == ExitCode.USAGE
    told = sayso("ask", "-", state=tmp_path, stdin=lines)
    assert told.stderr.count(b"sayso: Line ") == 3
    assert told.stdout == b"Beeped.\nWaited 1 s.\n"


def test_a_fault_over_one_line_is_its_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    good = Planner.plan

    async def plan(planner: Planner, request: PlanRequest) -> Plan | NoPlan:
        return [][0] if request.text == "nod" else await good(planner, request)

    monkeypatch.setattr(Planner, "plan", plan)
    monkeypatch.setenv("SAYSO_PLANNER__PROFILE", "phrases")
    monkeypatch.setattr("sys.stdin", io.StringIO("beep\nnod\nwait 1 s\n"))
    assert main(["plan", "--json", "-"]) == ExitCode.FAILED
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    found = [event for event in lines if event["kind"] != "meaning.read"]
    assert [event["kind"] for event in found] == ["plan.made", "plan.rejected", "plan.made"]
    assert found[1]["body"]["code"] == "internal"


def test_the_engine_does_what_stdin_says_and_ends_when_that_is_done(tmp_path: Path) -> None:
    lines = b'{"do":"say","text":"go to the bedroom","id":"a"}\n'
    done = sayso("engine", state=tmp_path, stdin=lines)
    assert done.returncode == ExitCode.DONE, done.stderr
    assert [event["body"]["outcome"] for event in events(done, "action.finished")] == ["ok"]
    assert events(done, "ack")[0]["body"]["id"] == "a"


def test_the_engine_acknowledges_garbage_and_goes_on(tmp_path: Path) -> None:
    lines = b'nonsense\n{"do":"fly","id":"f"}\n{"do":"say"}\n\xff\xfe\n{"do":"snapshot","id":"s"}\n'
    done = sayso("engine", "--json", state=tmp_path, stdin=lines)
    assert done.returncode == ExitCode.DONE
    acks = [event["body"] for event in events(done, "ack")]
    assert [ack["ok"] for ack in acks[:4]] == [False] * 4
    assert [(ack["do"], ack["id"]) for ack in acks[:4]] == [("", None), ("fly", "f"), ("say", None), ("", None)]
    assert next(ack for ack in acks if ack["id"] == "s")["snapshot"]["state"] == "IDLE"


def test_skills_are_listed_with_types_units_and_limits(tmp_path: Path) -> None:
    listed = [json.loads(line) for line in sayso("skills", "--json", state=tmp_path).stdout.splitlines()]
    names = {skill["name"] for skill in listed}
    asked = (
        "set_cmdvel move_left move_right move_forward move_sideways navigation get_current_pose arm_up arm_down "
        "arm_nod arm_shake arm_applaud dance drift wait beep light say finishtask finish_dialogue"
    )
    assert set(asked.split()) <= names
    turn = next(skill for skill in listed if skill["name"] == "move_left")
    assert turn["occupies"] == ["base"]
    assert turn["parameters"][0]["unit"] == "deg"


def test_headless_commands_never_import_textual(tmp_path: Path) -> None:
    script = (
        "import sys\nfrom tui.cli import main\n"
        "code = main(sys.argv[1:])\n"
        "found = sorted(name for name in sys.modules if name.split('.')[0] == 'textual')\n"
        "print(found, file=sys.stderr)\nsys.exit(9 if found else code)\n"
    )
    env = environment(tmp_path, {"SAYSO_ROBOT__SPEED": "max"})
    silence = tmp_path / "silence.wav"
    with wave.open(str(silence), "wb") as file:
        file.setparams((1, 2, 16000, 0, "NONE", ""))
        file.writeframes(bytes(2 * 16000))
    for arguments in (["ask", "beep"], ["hear", str(silence)], ["engine"], ["plan", "beep"], ["skills"]):
        run = subprocess.run(
            [sys.executable, "-c", script, *arguments], input=b"", capture_output=True, env=env, timeout=60, check=False
        )
        assert run.returncode != 9, (arguments, run.stderr)
        assert run.stderr.rstrip().endswith(b"[]"), (arguments, run.stderr)


@pytest.mark.parametrize(
    "arguments", [["--version"], ["--help"], ["ask", "--help"], ["--print-completion", "bash"]], ids=" ".join
)
def test_help_version_and_completion_print_to_stdout(tmp_path: Path, arguments: list[str]) -> None:
    done = sayso(*arguments, state=tmp_path)
    assert done.returncode == ExitCode.DONE
    assert b"sayso" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["dance"], b"invalid choice"),
        (["ask"], b"required"),
        (["ask", ""], b"empty"),
        (["ask", "--set", "robot.sped=max", "beep"], b"did you mean"),
        (["ask", "--scene", "mars", "beep"], b"mars"),
        (["--config", "nowhere.yaml", "plan", "beep"], b"nowhere.yaml"),
        (["bench", "nothing"], b"interrupt"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_wrong_usage_is_one_clear_line_and_exit_code_2(tmp_path: Path, arguments: list[str], complaint: bytes) -> None:
    done = sayso(*arguments, state=tmp_path)
    assert done.returncode == ExitCode.USAGE, done.stderr
    assert complaint in done.stderr.lower() or complaint in done.stderr
    assert b"Traceback" not in done.stderr
    assert done.stdout == b""


def test_a_wrong_key_in_a_file_is_told_with_its_line(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("endpoint:\n  silence: 0.8\n", encoding="utf-8")
    done = sayso("--config", str(file), "plan", "beep", state=tmp_path)
    assert done.returncode == ExitCode.USAGE
    assert b"mine.yaml:2" in done.stderr
    assert b"silence_s" in done.stderr


def test_the_console_is_refused_on_a_dumb_terminal_or_a_pipe(tmp_path: Path) -> None:
    done = sayso(state=tmp_path, environ={"TERM": "dumb"})
    assert done.returncode == ExitCode.USAGE
    assert b"sayso engine" in done.stderr


def test_a_missing_model_is_exit_code_3_with_the_command_that_fetches_it(tmp_path: Path) -> None:
    silence = tmp_path / "a.wav"
    with wave.open(str(silence), "wb") as file:
        file.setparams((1, 2, 16000, 0, "NONE", ""))
        file.writeframes(bytes(2 * 16000))
    done = sayso("hear", "--json", str(silence), state=tmp_path, environ={"SAYSO_CACHE_DIR": str(tmp_path / "empty")})
    assert done.returncode == ExitCode.MISSING
    assert "sayso models pull whisper-base" in str(events(done, "error"))


def test_a_log_that_cannot_be_written_is_told_and_tolerated(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    done = sayso("ask", "--json", "beep", state=tmp_path, environ={"SAYSO_STATE_DIR": str(tmp_path / "file" / "x")})
    assert done.returncode == ExitCode.DONE
    assert [event["body"]["code"] for event in events(done, "error")] == ["storage"]


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="needs a POSIX system")
def test_doctor_names_what_is_missing_with_the_fix(tmp_path: Path) -> None:
    done = sayso("doctor", "--json", state=tmp_path, environ={"SAYSO_CACHE_DIR": str(tmp_path / "empty")})
    findings = {finding["name"]: finding for finding in map(json.loads, done.stdout.splitlines())}
    assert done.returncode == ExitCode.MISSING
    assert findings["recogniser"]["state"] == "missing"
    assert "sayso models pull" in findings["recogniser"]["fix"]
    assert findings["simulation"]["state"] == "ok"


@pytest.mark.model
@needs_recordings
class TestARecordingOfAPerson:
    def test_is_heard_planned_and_driven(self, tmp_path: Path) -> None:
        done = sayso("hear", "--json", str(SHARED / "speech_real" / "goforward.wav"), state=tmp_path)
        assert done.returncode == ExitCode.FAILED  # ten metres are more than the hall has
        (final,) = events(done, "transcript.final")
        assert "forward" in final["body"]["text"].lower()
        (action,) = events(done, "plan.made")[0]["body"]["actions"]
        assert (action["name"], action["args"]["distance"]) == ("move_forward", 10)
        assert events(done, "action.finished")[0]["body"]["error_code"] == "path_blocked"

    def test_is_heard_as_raw_sound_on_stdin(self, tmp_path: Path) -> None:
        with wave.open(str(SHARED / "speech_synth" / "joe_04_clean.wav")) as file:
            pcm = file.readframes(file.getnframes())
        done = sayso("hear", "--json", "-", state=tmp_path, stdin=pcm)
        assert done.returncode == ExitCode.DONE, done.stderr
        assert "kitchen" in events(done, "transcript.final")[0]["body"]["text"].lower()

    def test_is_transcribed(self, tmp_path: Path) -> None:
        files = [str(SHARED / "speech_synth" / f"joe_0{number}_clean.wav") for number in (1, 4)]
        done = sayso("transcribe", "--json", *files, state=tmp_path)
        texts = [json.loads(line)["text"].lower() for line in done.stdout.splitlines()]
        assert "left" in texts[0]
        assert "kitchen" in texts[1]


@pytest.mark.model
def test_bad_sound_files_are_clear_errors(tmp_path: Path) -> None:
    (tmp_path / "empty.wav").touch()
    (tmp_path / "music.wav").write_bytes(b"ID3\x04\x00" + bytes(2000))
    (tmp_path / "text.wav").write_text("hello", encoding="utf-8")
    names = ("empty.wav", "music.wav", "text.wav", "missing.wav")
    files = [str(tmp_path / name) for name in names]
    for verb, given in (("transcribe", files), ("hear", files[1:2]), ("hear", files[3:])):
        done = sayso(verb, *given, state=tmp_path)
        assert done.returncode == ExitCode.USAGE, (verb, given, done.stderr)
        assert all(name.encode() in done.stderr for name in given), (verb, given, done.stderr)
        assert b"Traceback" not in done.stderr
        lines = done.stderr.splitlines()
        assert len(lines) == len(given)
        assert all(line.startswith(b"sayso: ") for line in lines)
    done = sayso("hear", str(tmp_path / "empty.wav"), state=tmp_path)
    assert done.stderr.decode() == (
        f"sayso: There is nothing to hear in {tmp_path}/empty.wav: the file is empty. Record it again.\n"
    )


@pytest.mark.model
def test_a_recording_without_speech_is_told_and_nothing_is_made_up(tmp_path: Path) -> None:
    random = np.random.default_rng(0)
    for name, level in (("silence.wav", 0.0), ("hiss.wav", 0.002), ("noise.wav", 0.05)):
        soundfile.write(tmp_path / name, random.normal(0, level, 35 * 16000) if level else np.zeros(35 * 16000), 16000)
        file = str(tmp_path / name)
        done = sayso("transcribe", file, state=tmp_path)
        assert (done.returncode, done.stdout) == (ExitCode.FAILED, b"")
        assert done.stderr.decode() == f"sayso: no speech was found in {file}.\n"
    done = sayso("transcribe", "--json", file, state=tmp_path)
    assert done.returncode == ExitCode.FAILED
    assert [json.loads(line)["text"] for line in done.stdout.splitlines()] == [""]


@pytest.mark.model
@needs_recordings
def test_a_long_recording_is_read_as_one_whatever_its_kind(tmp_path: Path) -> None:
    files = ["speech_real/lv0870", *(f"speech_synth/joe_0{number}_clean" for number in (1, 4, 2))]
    pause = np.random.default_rng(1).normal(0, 1e-4, round(0.9 * 16000))
    parts = [part for name in files for part in (soundfile.read(SHARED / f"{name}.wav")[0], pause)]
    sound = soxr.resample(np.concatenate([*parts, np.zeros(8 * 16000), *parts[2:]]), 16000, 44100)
    soundfile.write(tmp_path / "long.flac", np.stack([sound, sound / 2], axis=1), 44100)
    done = sayso("transcribe", "--json", str(tmp_path / "long.flac"), state=tmp_path)
    assert done.returncode == ExitCode.DONE
    found = json.loads(done.stdout)
    read = (
        "and mr john dashwood had then leisure to consider how much there might be prudently in his power to do "
        "for them"
    )
    commands = "turn left 90 degrees navigate to the kitchen turn right 45 degrees"
    assert re.findall(r"\w+", found["text"].lower()) == f"{read} {commands} {commands}".split()
    times = [(part["start_s"], part["end_s"]) for part in found["utterances"]]
    assert times == sorted(times)
    assert times[-1][1] == pytest.approx(len(sound) / 44100, abs=1.5)


@pytest.mark.model
def test_a_wake_to_which_no_sound_comes_ends_by_itself(tmp_path: Path) -> None:
    quick = {"SAYSO_ENDPOINT__NO_SPEECH_S": "0.5"}
    done = sayso("engine", "--json", "--source", "none", state=tmp_path, stdin=b'{"do":"wake"}\n', environ=quick)
    assert done.returncode == ExitCode.DONE
    (result,) = [event["body"]["result"] for event in events(done, "state.changed") if event["body"]["result"]]
    assert result["outcome"] == "unheard"


@pytest.mark.model
@needs_recordings
def test_sound_that_is_sent_as_commands_is_heard_and_driven(tmp_path: Path) -> None:
    with wave.open(str(SHARED / "speech_synth" / "joe_04_clean.wav")) as file:
        pcm = file.readframes(file.getnframes()) + bytes(2 * 16000)  # a second of silence ends the utterance
    lines = b'{"do":"wake"}\n' + json.dumps({"do": "audio", "pcm": b64encode(pcm).decode()}).encode() + b"\n"
    done = sayso("engine", "--json", "--source", "none", state=tmp_path, stdin=lines)
    assert "kitchen" in events(done, "transcript.final")[0]["body"]["text"].lower()
    assert [event["body"]["outcome"] for event in events(done, "action.finished")] == ["ok"]


@pytest.mark.model
def test_a_wake_while_listening_restarts_the_recording(tmp_path: Path) -> None:
    with subprocess.Popen(
        command("engine", "--json", "--source", "none"),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=environment(tmp_path),
    ) as engine:
        assert engine.stdin is not None
        assert engine.stdout is not None
        seen = []
        for wake in range(2):
            engine.stdin.write(b'{"do":"wake"}\n')
            engine.stdin.flush()
            for line in engine.stdout:
                seen.append(json.loads(line))
                if seen[-1]["kind"] == "listen.started":
                    assert seen[-1]["body"]["restarted"] is bool(wake)
                    break
        engine.stdin.write(b'{"do":"quit"}\n')
        engine.stdin.flush()
        seen += [json.loads(line) for line in engine.stdout]
    assert [event["body"]["reason"] for event in seen if event["kind"] == "listen.ended"] == ["cancelled"] * 2
    results = [
        event["body"]["result"] for event in seen if event["kind"] == "state.changed" and event["body"]["result"]
    ]
    assert [result["outcome"] for result in results] == ["interrupted"] * 2
