"""A fault of the console is written down for its owner, without secrets, and stderr says where."""

from __future__ import annotations

import stat
import subprocess
from pathlib import Path

import pytest

import tui.app
from config import load
from config.secrets import MASK, masked, secrets_in, told
from engine.commands import Quit
from engine.handle import EngineHandle
from tests.e2e.sayso import command, environment
from tests.tui.scripted import ScriptedEngine
from tui.app import SaysoApp
from tui.messages import Failed, Started
from tui.words import strings

KEY = "zebra-4711-from-the-settings"
OTHER = "walrus-0815-from-a-variable"

STYLES = str(Path(tui.app.__file__).parent / "screens" / "console.tcss")


class Faulty(SaysoApp):
    """A console without a terminal that fails as soon as the engine is there."""

    CSS_PATH = STYLES

    def run(self) -> None:  # type: ignore[override]
        super().run(headless=True, size=(80, 24))

    def on_started(self, message: Started) -> None:
        super().on_started(message)
        local = "a-value-of-a-local-variable"
        raise RuntimeError(f"{len(local)} letters, sent with {KEY} and {OTHER}")


class Idle(SaysoApp):
    """A console without a terminal that is left at the first failure."""

    CSS_PATH = STYLES

    def run(self) -> None:  # type: ignore[override]
        super().run(headless=True, size=(80, 24))

    def on_failed(self, message: Failed) -> None:
        super().on_failed(message)
        self.action_leave_now()


@pytest.fixture
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("SAYSO_STATE_DIR", str(tmp_path / "state"))
    monkeypatch.setenv("SOME_API_KEY", OTHER)
    return tmp_path / "state"


def crashed(app: SaysoApp) -> int:
    """Run a console that fails; its exit code."""
    app.leaving.secrets = (KEY,)
    return app.leaving.run()


def test_a_fault_is_written_down_and_stderr_says_where(state: Path, capsys: pytest.CaptureFixture[str]) -> None:
    engine = ScriptedEngine()
    assert crashed(Faulty(lambda: engine)) == 1
    (file,) = state.glob("crash-*.txt")
    text, told = file.read_text(), capsys.readouterr().err
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert "Traceback (most recent call last):" in text
    assert "on_started" in text
    assert f"RuntimeError: 27 letters, sent with {MASK} and {MASK}" in text
    assert told.rstrip().endswith(strings.CRASH_WRITTEN.format(file))
    assert MASK in told
    for secret in (KEY, OTHER):
        assert secret not in text + told


def test_the_robot_stops_when_the_console_fails(state: Path) -> None:
    engine = ScriptedEngine()
    crashed(Faulty(lambda: engine))
    assert Quit() in engine.sent


def test_where_nothing_can_be_written_stderr_tells_the_fault_and_that(
    state: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    state.write_text("a file in its place")
    assert crashed(Faulty(ScriptedEngine)) == 1
    told = capsys.readouterr().err
    assert "RuntimeError: 27 letters" in told
    assert "could not be saved" in told


def test_an_engine_that_fails_unexpectedly_is_written_down_as_well(
    state: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def start() -> EngineHandle:
        raise LookupError(f"no answer to {KEY}")

    assert crashed(Idle(start)) == 1
    (file,) = state.glob("crash-*.txt")
    assert f"LookupError: no answer to {MASK}" in file.read_text()
    assert str(file) in capsys.readouterr().err


@pytest.mark.parametrize("where", ["", "threading.Thread(target=fail).start()", "asyncio.run(forgotten())"])
def test_a_fault_of_any_command_is_told_without_secrets_and_not_at_length(tmp_path: Path, where: str) -> None:
    """Also where it ends a thread alone, or a task that nobody waits for."""
    before = f"""
import asyncio, gc, threading, config
from tui.commands import skills
def fail(*_):
    config.load()
    raise RuntimeError("sent with {KEY} and {OTHER} " + "9" * 5000)
async def failing(): fail()
async def forgotten():
    task = asyncio.ensure_future(failing())
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    del task
    gc.collect()
def run(_):
    {where or "fail()"}
    return 0
skills.run = run
"""
    file = tmp_path / "config" / "platforms.yaml"
    file.parent.mkdir()
    file.write_text(f"platforms:\n  cloud: {{kind: openai, api_key: {KEY}}}\n")
    file.chmod(0o600)
    done = subprocess.run(
        command("skills", before=before),
        env=environment(tmp_path, {"MY_TOKEN": OTHER}),
        capture_output=True,
        check=False,
    )
    told = done.stderr.decode()
    assert "RuntimeError: sent with ******** and ******** 999" in told
    assert KEY not in told
    assert OTHER not in told
    assert len(told) < 4000


def test_values_of_local_variables_are_not_told() -> None:
    def fail(local: str) -> None:
        raise ValueError(len(local))

    with pytest.raises(ValueError, match="9") as failed:
        fail("-".join(["only", "here"]))
    report = told(failed.value, (), {})
    assert "in fail" in report
    assert "only-here" not in report


def test_secrets_of_the_settings_are_found_wherever_they_stand(tmp_path: Path) -> None:
    settings = load(
        environ={"OURS": KEY, "SAYSO_CONFIG_DIR": str(tmp_path)},
        overrides=["platforms.mine.kind=openai", "platforms.mine.api_key=${OURS}"],
    )
    assert KEY in set(secrets_in(settings))


@pytest.mark.parametrize(
    ("text", "left"),
    [
        ("Authorization: Bearer abc.def", f"Authorization: Bearer {MASK}"),
        ("key sk-abcdefghijklmnop1234 refused", f"key {MASK} refused"),
        ("http://me:pass@host/path", f"http://{MASK}@host/path"),
        ("the kitchen is 1 m away", "the kitchen is 1 m away"),
    ],
)
def test_what_looks_like_a_secret_is_masked_and_nothing_else(text: str, left: str) -> None:
    assert masked(text, ["1"], {"KEYS": "1", "HOME": "kitchen"}) == left


def test_a_secret_within_a_longer_one_does_not_uncover_the_rest() -> None:
    assert masked("abcdefgh-tail", ["abcdefgh"], {"MY_TOKEN": "abcdefgh-tail"}) == MASK
